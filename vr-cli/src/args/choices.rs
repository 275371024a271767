//! Flags that take one of a few words.

use clap::ValueEnum;

/// Pixels that are compared with the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ErrorMeasure {
    /// No pixels.
    None,
    /// Pixels of a subgrid of 64×64.
    Subgrid,
    /// All pixels.
    Full,
}

/// Encoding of light in a PNG.
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
