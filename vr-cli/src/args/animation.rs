//! Flags of `vr turntable` and `vr animate`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use glam::DVec3;

use super::value;
use super::{Background, Bits, RendererArgs, SceneArgs};

/// `vr turntable`.
#[derive(Debug, Args)]
pub struct TurntableArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The turn.
    #[command(flatten)]
    pub turn: TurnArgs,
    /// Frames and files.
    #[command(flatten)]
    pub animation: AnimationArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
}

/// `vr animate`.
#[derive(Debug, Args)]
pub struct AnimateArgs {
    /// Key frames (TOML): a table `[[keys]]` for each, with time in seconds; azimuth, elevation and zoom, or eye, target, up and height or
    /// fov; points of the transfer function; clip. interpolation = "smooth", "linear" or "ease"
    #[arg(value_name = "KEYS")]
    pub keys: PathBuf,
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Frames and files.
    #[command(flatten)]
    pub animation: AnimationArgs,
    /// The renderer and its options.
    #[command(flatten)]
    pub renderer: RendererArgs,
}

/// The turn of a turntable.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Turn")]
pub struct TurnArgs {
    /// Angle of the whole turn; the camera goes to the right, or to the left below 0
    #[arg(long, value_name = "DEGREES", default_value = "360", value_parser = degrees, allow_hyphen_values = true)]
    pub turn: f64,
    /// Axis of the turn: up, for what is up in the volume, or a world vector
    #[arg(long, value_name = "up|X,Y,Z", default_value = "up", value_parser = Axis::from_str, allow_hyphen_values = true)]
    pub axis: Axis,
}

/// Frames and files of an animation.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Animation")]
pub struct AnimationArgs {
    /// Animation to write (.gif, .webp, .apng or .png), or its frames: a pattern (frame-%04d.png) or a folder (frames/); may be repeated
    #[arg(long = "output", short, value_name = "FILE", default_value = "vr.gif")]
    pub outputs: Vec<PathBuf>,
    /// Number of frames; if absent 72 of a turn, those of the keys' times, or of the time series
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: Option<u32>,
    /// Frames per second
    #[arg(long, value_name = "N", default_value = "24")]
    pub fps: f64,
    /// Begin again when it is over, for ever: what happens if --once is absent
    #[arg(long = "loop", overrides_with = "once")]
    pub repeat: bool,
    /// Show it once
    #[arg(long)]
    pub once: bool,
    /// Draw all frames, those of an interrupted or earlier run too, and replace files that are there
    #[arg(long)]
    pub force: bool,
    /// VOLUME changes with time: a pattern of files (vol-%03d.nrrd), or a file whose frames follow one another
    #[arg(long)]
    pub time_series: bool,
    /// Time series: pictures of each volume; the series begins again when it is over
    #[arg(long, value_name = "K", default_value = "1", requires = "time_series",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub hold: u32,
    /// Time series: volume that transfer function and framing come from: the first, or all, for the range of all and the look of the strongest
    #[arg(long, value_name = "WHICH", default_value = "first", requires = "time_series")]
    pub look_from: LookFrom,
    /// Compare every Kth frame (24th if no number is given) with the reference on a 64x64 subgrid of its pixels
    #[arg(long, value_name = "K", num_args = 0..=1, require_equals = true, default_missing_value = "24",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub error: Option<u32>,
    /// Bits per channel of frames; 16 only for PNG
    #[arg(long, value_name = "N", default_value = "8")]
    pub bits: Bits,
    /// Keep opacity instead of blending with the background; not in a GIF
    #[arg(long)]
    pub alpha: bool,
}

impl AnimationArgs {
    /// True if the animation begins again when it is over.
    pub fn repeats(&self) -> bool {
        self.repeat || !self.once
    }

    /// Returns the same flags with the opacity kept, if the background is transparent.
    pub fn before(&self, background: Option<Background>) -> Self {
        Self { alpha: self.alpha || background == Some(Background::Transparent), ..self.clone() }
    }

    /// Returns every place that is written to.
    pub fn places(&self) -> impl Iterator<Item = &Path> {
        self.outputs.iter().map(PathBuf::as_path)
    }
}

/// Volumes of a time series that decide on its look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LookFrom {
    /// The first one.
    First,
    /// The range of all, and the look of the one with the largest value.
    All,
}

/// Axis of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axis {
    /// Up direction of the volume, or of the picture where the camera is placed.
    Up,
    /// A world vector.
    Along(DVec3),
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "up" {
            return Ok(Self::Up);
        }
        let vector = DVec3::from(value::triple::<f64>(text).map_err(|_| "expected up, or a vector as in 0,0,1")?);
        let length = vector.length();
        if length.is_finite() && length > 1e-100 {
            Ok(Self::Along(vector / length))
        } else {
            Err("must be a vector with a direction".to_owned())
        }
    }
}

/// Parses degrees of as many turns as anyone may want.
fn degrees(text: &str) -> Result<f64, String> {
    let degrees: f64 = text.trim().parse().map_err(|_| "expected a number of degrees".to_owned())?;
    if degrees.abs() <= 36_000.0 { Ok(degrees) } else { Err("must be from -36000 to 36000 degrees".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_and_angles() {
        assert_eq!("up".parse(), Ok(Axis::Up));
        assert_eq!("0,-2,0".parse(), Ok(Axis::Along(DVec3::NEG_Y)));
        for bad in ["down", "0,0,0", "nan,0,0", "1,2", "inf,0,0"] {
            assert!(bad.parse::<Axis>().is_err(), "{bad}");
        }
        assert_eq!((degrees("-720"), degrees("1e9").is_err(), degrees("nan").is_err()), (Ok(-720.0), true, true));
    }
}
