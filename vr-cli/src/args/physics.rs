//! Arguments of `vr physics`.

use clap::Args;

use super::SceneArgs;

/// `vr physics`.
#[derive(Debug, Args)]
pub struct PhysicsArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Largest error of a pixel that a simpler model may have
    #[arg(long, value_name = "E", default_value = "0", help_heading = "Model")]
    pub allowed: f64,
    /// Measure, too, what leaving scattering out costs in a picture of this view, by random paths: seconds to minutes
    #[arg(long, help_heading = "Model")]
    pub measure: bool,
}
