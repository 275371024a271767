//! Flags of `vr convert`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, ValueEnum};
use vr_core::VoxelType;

use super::value;
use super::{ErrorMeasure, ReplaceArgs, ResampleArgs, VolumeArgs};

/// `vr convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// The volume.
    #[command(flatten)]
    pub volume: VolumeArgs,
    /// Volume to write: .nrrd, .nii, .nii.gz, .mha, .mhd (and .raw), .vti, .zarr, .raw, or PNG slices for a pattern (out_%03d.png) or a folder (out/)
    #[arg(value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Files that are there.
    #[command(flatten)]
    pub replace: ReplaceArgs,
    /// The same by a flag, which --phantom needs
    #[arg(long = "output", short = 'o', value_name = "FILE", conflicts_with = "output")]
    pub named_output: Option<PathBuf>,
    /// Changes on the way.
    #[command(flatten)]
    pub changes: ChangeArgs,
    /// Levels of a pyramid.
    #[command(flatten)]
    pub levels: LevelArgs,
    /// Pixels of a picture of the resampled volume that are compared with the reference of the volume itself: all, those of a 48x48 subgrid
    /// (which is the default), or none; for volumes that are no uniform grids
    #[arg(long, value_name = "PIXELS", requires = "resample")]
    pub error: Option<ErrorMeasure>,
}

impl ConvertArgs {
    /// Returns the place that is written to, if it is given.
    pub fn place(&self) -> Option<&Path> {
        self.output.as_deref().or(self.named_output.as_deref())
    }
}

/// Changes on the way, in this order.
#[derive(Debug, Args)]
#[command(next_help_heading = "Changes, in this order")]
pub struct ChangeArgs {
    /// Keep these voxels alone, from the first to before the last of each axis; a number left out is the axis's end
    #[arg(long, value_name = "X0:X1,Y0:Y1,Z0:Z1", value_parser = CropBox::from_str)]
    pub crop: Option<CropBox>,
    /// Reverse the order of voxels along an axis, and its direction with it: each stays where it is in the world; may be repeated
    #[arg(long, value_name = "AXIS")]
    pub flip: Vec<Axis>,
    /// Resampling.
    #[command(flatten)]
    pub resample: ResampleArgs,
    /// Type of the voxels: u8, i8, u16, i16 or f32; values are rounded to the nearest and clamped
    #[arg(long, value_name = "TYPE", value_parser = value::word::<VoxelType>)]
    pub to: Option<VoxelType>,
    /// Stretch values from LOW to HIGH over the range of the integer type
    #[arg(long, value_name = "LOW,HIGH", value_parser = value::pair, allow_hyphen_values = true, requires = "to")]
    pub rescale: Option<[f64; 2]>,
}

/// Levels of a pyramid.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Resolutions of OME-Zarr")]
pub struct LevelArgs {
    /// Write this many resolutions, each of half the voxels along each axis; without it, as many as lead to 64 voxels along the longest axis
    #[arg(long, value_name = "N")]
    pub levels: Option<usize>,
    /// Make one voxel of a block of eight by their mean, or their mode (the most frequent); without it, mode for labels and mean for all else
    #[arg(long, value_name = "HOW")]
    pub reduce: Option<Reduce>,
}

/// Way in which the voxels of a block become one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Reduce {
    /// Quantities.
    Mean,
    /// Numbers that are names.
    Mode,
}

/// An index axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Axis {
    /// The fastest.
    X,
    /// The second.
    Y,
    /// The slowest.
    Z,
}

/// First voxel and the one behind the last along each axis, where they are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CropBox(pub [[Option<usize>; 2]; 3]);

impl FromStr for CropBox {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || "expected X0:X1,Y0:Y1,Z0:Z1, as in 10:90,:,5:".to_owned();
        let end = |end: &str| match end.trim() {
            "" => Ok(None),
            number => number.parse().map(Some).map_err(|_| expected()),
        };
        let axis = |axis: &str| {
            let (first, last) = axis.split_once(':').ok_or_else(expected)?;
            Ok([end(first)?, end(last)?])
        };
        let axes: Vec<[Option<usize>; 2]> = text.split(',').map(axis).collect::<Result<_, String>>()?;
        axes.try_into().map(Self).map_err(|_| expected())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_have_ends_that_may_be_left_out() {
        let box_of = CropBox::from_str;
        assert_eq!(box_of("1:2,3:4,5:6"), Ok(CropBox([[Some(1), Some(2)], [Some(3), Some(4)], [Some(5), Some(6)]])));
        assert_eq!(box_of(":, 3:,:6"), Ok(CropBox([[None, None], [Some(3), None], [None, Some(6)]])));
        for bad in ["", "1:2,3:4", "1,2,3", "1:2,3:4,5:6,7:8", "-1:2,:,:", "a:b,:,:"] {
            assert!(box_of(bad).unwrap_err().contains("X0:X1"), "{bad}");
        }
    }
}
