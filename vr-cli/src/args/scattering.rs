//! Flags of `[scattering]`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use vr_io::SurfaceEntry;

use super::{surface, value};

/// Part of the equation of transfer that is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightModel {
    /// No scattering.
    EmissionAbsorption,
    /// Light that is scattered once.
    Single,
    /// All of it.
    Full,
}

impl LightModel {
    /// The word for it among the options of the renderer `light`; `None` where another renderer draws it.
    pub fn option(self) -> Option<&'static str> {
        match self {
            Self::EmissionAbsorption => None,
            Self::Single => Some("single"),
            Self::Full => Some("full"),
        }
    }
}

/// `[scattering]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Scattering")]
pub struct ScatteringArgs {
    /// Light that is drawn: emission-absorption (none is scattered), single (scattered once: shadows, no noise) or full (any number of times, by
    /// random paths); the last two light the medium as --light says, in place of shading
    #[arg(long, value_name = "MODEL", hide_possible_values = true)]
    pub model: Option<LightModel>,
    /// Share of the extinction that is scattering, 0 to 1, or one each for red, green and blue; that of the transfer function's colour if absent
    #[arg(long, value_name = "SHARE", value_parser = value::grey_or_rgb, allow_hyphen_values = true)]
    pub albedo: Option<[f64; 3]>,
    /// Mean cosine of the angle by which light is scattered: 0 all directions alike, 0.9 forward as in clouds (Henyey-Greenstein)
    #[arg(long, value_name = "G", allow_hyphen_values = true)]
    pub anisotropy: Option<f64>,
    /// Radiance that comes from all sides, a number or linear RGB
    #[arg(long, value_name = "RADIANCE", value_parser = value::grey_or_rgb, allow_hyphen_values = true)]
    pub environment: Option<[f64; 3]>,
    /// Picture of the light from all sides (an equirectangular EXR; PNG and others by the sRGB curve), which adds to --environment
    #[arg(long, value_name = "FILE")]
    pub environment_map: Option<PathBuf>,
    /// Place of a light in the world, and its linear RGB if it is not white: at the distance d it sheds pi RGB / d^2; may be repeated
    #[arg(long, value_name = "X,Y,Z[,R,G,B]", value_parser = value::light, allow_hyphen_values = true)]
    pub point_light: Vec<([f64; 3], [f64; 3])>,
    /// Opaque surface in or beside the medium, which is seen, shades and lights it: plane=POINT,NORMAL, sphere=CENTRE,RADIUS, triangle=P,Q,R,
    /// parallelogram=CORNER,EDGE,EDGE or box=LOW,HIGH, and what it does: emission=RADIANCE, matte=SHARE, mirror=SHARE or gloss=EXPONENT,SHARE, as in
    /// sphere=0,2,0,0.3:emission=9; may be repeated
    #[arg(long, value_name = "SHAPE:PROPERTY", value_parser = surface::surface, allow_hyphen_values = true)]
    pub surface: Vec<SurfaceEntry>,
}
