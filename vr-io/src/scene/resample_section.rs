//! The keys of `[volume]` about resampling.

use serde::{Deserialize, Serialize};
use vr_core::resample::{ResampleError, ResampleFilter, Resampled, Resampling, Resolution, resample};
use vr_core::{Control, Filter, GridVolume, ParameterError, Volume};

/// Resampling of a volume that is no grid, to one that renderers of grids draw.
///
/// # Examples
/// ```
/// use vr_core::resample::Resolution;
///
/// let text = "[volume]\npath = \"mesh.vtu\"\nresample = [64, 64, 32]\nresample_filter = \"box\"\n";
/// let file = vr_io::parse_scene(text, "scene.toml".as_ref())?;
/// let section = file.volume.resample.expect("it is there");
/// assert_eq!(section.choices().resolution, Resolution::Dims([64, 64, 32]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResampleSection {
    /// Size of the grid.
    pub size: ResampleSize,
    /// Way from the volume's values to that of a voxel.
    pub filter: ResampleFilter,
    /// True if voxels are corrected so that the integral stays what it was.
    pub conserve: bool,
}

/// Size of the grid that a volume is resampled to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "must be \"finest\", three numbers of voxels, or a spacing")]
pub enum ResampleSize {
    /// The spacing of the finest cells.
    Word(FinestWord),
    /// Voxels along x, y and z.
    Dims([usize; 3]),
    /// World units between voxels, at most.
    Spacing(f64),
}

/// The word for the size of the finest cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FinestWord {
    /// The spacing of the finest cells, or a wider one that gives 2²⁴ voxels.
    Finest,
}

impl ResampleSection {
    /// The section of choices.
    pub fn describe(choices: &Resampling) -> Self {
        let size = match choices.resolution {
            Resolution::Finest => ResampleSize::Word(FinestWord::Finest),
            Resolution::Dims(dims) => ResampleSize::Dims(dims),
            Resolution::Spacing(spacing) => ResampleSize::Spacing(spacing),
        };
        Self { size, filter: choices.filter, conserve: choices.conserve }
    }

    /// The choices of the section.
    pub fn choices(&self) -> Resampling {
        let resolution = match self.size {
            ResampleSize::Word(FinestWord::Finest) => Resolution::Finest,
            ResampleSize::Dims(dims) => Resolution::Dims(dims),
            ResampleSize::Spacing(spacing) => Resolution::Spacing(spacing),
        };
        Resampling { resolution, filter: self.filter, conserve: self.conserve, ..Resampling::default() }
    }

    /// Resamples a volume; returns it with notes on what was done.
    pub(super) fn apply(&self, volume: &Volume) -> Result<(Volume, Vec<String>), ParameterError> {
        let wrong = |found: String, allowed| ParameterError { field: "volume.resample".into(), found, allowed };
        if volume.value_grid().is_some() {
            let allowed =
                "only a volume that is no grid is resampled to one; vr convert --resample makes another grid of a grid";
            return Err(wrong(volume.kind().to_owned(), allowed));
        }
        let resampled = resample(volume, &self.choices(), &Control::default()).map_err(|e| match e {
            ResampleError::Empty { .. } => wrong(e.to_string(), "must be so fine that a voxel falls into the volume"),
            _ => wrong(e.to_string(), "must be a size that a grid can have"),
        })?;
        let notes = resampled.notes();
        let Resampled { grid, .. } = resampled;
        Ok((Volume::Grid(std::sync::Arc::new(GridVolume::new(grid.into(), Filter::default()))), notes))
    }
}
