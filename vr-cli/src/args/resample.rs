//! Flags of resampling.

use std::str::FromStr;

use clap::Args;
use vr_core::resample::{ResampleFilter, Resampling, Resolution};

use super::value;

/// Resampling of a volume to a uniform grid.
#[derive(Clone, Copy, Debug, Args)]
pub struct ResampleArgs {
    /// Make it a uniform grid of this many voxels over the same box, or with this many world units between them at most, or as fine as its
    /// finest cells; renderers and formats of grids then take what is none
    #[arg(long, value_name = "NXxNYxNZ|SPACING|finest", value_parser = ResampleTo::from_str)]
    pub resample: Option<ResampleTo>,
    /// Value of a resampled voxel: point (the volume's value there, which is the default) or box (the mean around it, which smooths what is finer than the voxels)
    #[arg(long, value_name = "NAME", value_parser = filter, requires = "resample")]
    pub resample_filter: Option<ResampleFilter>,
    /// Correct resampled voxels by one factor, or one shift where values have both signs, so that the integral over the volume stays what it was
    #[arg(long, requires = "resample")]
    pub conserve: bool,
}

impl ResampleArgs {
    /// Returns the choices, if any resampling is asked for.
    pub fn choices(&self) -> Option<Resampling> {
        let ResampleTo(resolution) = self.resample?;
        let filter = self.resample_filter.unwrap_or_default();
        Some(Resampling { resolution, filter, conserve: self.conserve, ..Resampling::default() })
    }

    /// Returns the voxels along each axis where a grid is to be interpolated to them, and nothing else is asked for.
    pub fn plain_dims(&self) -> Option<[usize; 3]> {
        match self.resample {
            Some(ResampleTo(Resolution::Dims(dims))) if self.resample_filter.is_none() && !self.conserve => Some(dims),
            _ => None,
        }
    }
}

/// Resolution of a resampling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResampleTo(pub Resolution);

impl FromStr for ResampleTo {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "finest" {
            return Ok(Self(Resolution::Finest));
        }
        // `64,64,64` as well as `64x64x64`.
        if let Ok(dims) = value::dims(text).or_else(|_| value::triple::<usize>(text)) {
            return Ok(Self(Resolution::Dims(dims)));
        }
        let spacing = text.parse().ok().filter(|spacing: &f64| spacing.is_finite() && *spacing > 0.0);
        let expected = || "expected NXxNYxNZ, as in 256x256x128, a positive spacing, or finest".to_owned();
        spacing.map(|spacing| Self(Resolution::Spacing(spacing))).ok_or_else(expected)
    }
}

fn filter(name: &str) -> Result<ResampleFilter, String> {
    ResampleFilter::from_name(name).ok_or_else(|| "expected point or box".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resolutions_are_told_apart() {
        let to = |text: &str| text.parse().map(|ResampleTo(resolution)| resolution);
        assert_eq!(to("finest"), Ok(Resolution::Finest));
        assert_eq!(to("4x5x6"), Ok(Resolution::Dims([4, 5, 6])));
        assert_eq!(to("4,5,6"), Ok(Resolution::Dims([4, 5, 6])));
        assert_eq!(to("0.25"), Ok(Resolution::Spacing(0.25)));
        for wrong in ["", "4x5", "-1", "0", "nan", "inf", "coarse"] {
            assert!(to(wrong).is_err_and(|e| e.contains("finest")), "{wrong}");
        }
    }
}
