//! Flags that take one of a few words.

use clap::ValueEnum;

/// Which pixels are compared with the exact solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ErrorMeasure {
    /// None of them.
    None,
    /// Those of a subgrid of 64×64.
    Subgrid,
    /// All of them.
    Full,
}

/// How a PNG holds light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Curve {
    /// The sRGB curve.
    Srgb,
    /// Linear values as they are.
    None,
}

/// Bits per channel of a PNG.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Bits {
    /// 8 bits.
    #[value(name = "8")]
    Eight,
    /// 16 bits.
    #[value(name = "16")]
    Sixteen,
}

impl From<Curve> for vr_io::Encode {
    fn from(curve: Curve) -> Self {
        match curve {
            Curve::Srgb => Self::Srgb,
            Curve::None => Self::None,
        }
    }
}
