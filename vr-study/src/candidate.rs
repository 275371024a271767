//! Candidates: renderers under their settings.

use vr_core::{NamedSetting, OptionError, Options, StudiedRenderer};

/// Renderer under one of its settings.
pub struct Candidate {
    /// The renderer's name.
    pub renderer: String,
    /// The setting's name; `default` where the renderer names none.
    pub setting: String,
    /// The options that make the setting.
    pub options: Options,
    /// Documented order of convergence.
    pub order: Option<f64>,
    /// Error that no step goes below, as documented.
    pub error_floor: f64,
    /// The renderer under these options.
    pub configured: Box<dyn StudiedRenderer>,
}

impl Candidate {
    /// Returns the full name, such as `raycast midpoint 0.5`.
    pub fn name(&self) -> String {
        format!("{} {}", self.renderer, self.setting)
    }
}

/// Returns every renderer under every setting that it names.
///
/// # Errors
/// A setting that the renderer itself does not take.
pub fn candidates(renderers: &[Box<dyn StudiedRenderer>]) -> Result<Vec<Candidate>, OptionError> {
    let mut all = Vec::new();
    for renderer in renderers {
        let mut settings = renderer.settings();
        if settings.is_empty() {
            let name = "default".to_owned();
            settings.push(NamedSetting { name, options: Options::new(), order: None, error_floor: 0.0 });
        }
        for NamedSetting { name: setting, options, order, error_floor } in settings {
            let configured = renderer.with_options(&options)?;
            let renderer = renderer.name().to_owned();
            all.push(Candidate { renderer, setting, options, order, error_floor, configured });
        }
    }
    Ok(all)
}
