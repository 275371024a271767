//! The one way in: a file of any format becomes a volume, with what is worth knowing about it.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use vr_core::{Calibration, Placement, Volume};

use crate::detect::{Format, detect, detect_folder};
#[cfg(feature = "dicom")]
use crate::dicom;
use crate::encoding::Encoding;
#[cfg(not(feature = "dicom"))]
use crate::error::FileErrorKind;
use crate::error::{FieldError, FileError};
use crate::layout::Layout;
use crate::nifti::Transform;
use crate::points::{self, LoadedPoints, PointFormat, PointOptions};
use crate::raw::RawDescription;
use crate::scalar::{Endian, ScalarType};
use crate::source::Source;
use crate::world::Space;
use crate::{metaimage, nifti, nrrd, raw};

/// Options of reading a volume. `ReadOptions::default()` is right for nearly every file.
#[derive(Clone, Debug)]
pub struct ReadOptions {
    /// Frame of a 4-D file, from 0; not needed where there is one.
    pub frame: Option<usize>,
    /// Component of a file with several values per voxel, from 0; not needed where there is one.
    pub component: Option<usize>,
    /// Series of a DICOM folder: its SeriesInstanceUID, or its SeriesNumber where no other series has it; not needed where there is one.
    pub series: Option<String>,
    /// Transform of a NIfTI file that places the volume.
    pub transform: Transform,
    /// Description of a file without a header. Where this is given, the file counts as raw, whatever it looks like.
    pub raw: Option<RawDescription>,
    /// True if uncompressed voxels of a memory type in native byte order may stay in the file, mapped into memory: the
    /// default. If false, they are copied, and the file may change or vanish afterwards.
    pub map: bool,
    /// Options of reading scattered points.
    pub points: PointOptions,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            frame: None,
            component: None,
            series: None,
            transform: Transform::Auto,
            raw: None,
            map: true,
            points: PointOptions::default(),
        }
    }
}

/// A volume from a file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The volume.
    pub volume: Volume,
    /// Everything that the file says about it.
    pub info: FileInfo,
    /// Notes on everything assumed, chosen or changed on the way, one line each: spacing that the file lacks, the transform
    /// used, voxels that are missing.
    pub notes: Vec<String>,
}

/// Everything that a file says about itself beyond the volume.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FileInfo {
    /// `NRRD`, `MetaImage`, `NIfTI-1`, `NIfTI-2` or `raw`; of points `CSV`, `VTK PolyData`, `NumPy`, …
    pub format: &'static str,
    /// `raw`, `gzip`, `bzip2`, `zlib`, `hex` or `ascii`; of points also `base64` or `lz4`.
    pub encoding: &'static str,
    /// Type of the voxels, or of the positions of points, in the file; in memory it may be another ([`vr_core::GridVolume::voxel_type`]).
    pub scalar: ScalarType,
    /// Byte order of these.
    pub endian: Endian,
    /// The space that the file's positions refer to. Unless it is [`Space::Own`], the volume's world is RAS.
    pub space: Space,
    /// Source of the placement: `space directions`, `spacings`, `sform`, … or `assumed`; of points `positions`.
    pub placed_by: &'static str,
    /// Unit of the positions, if the file names one.
    pub units: Option<String>,
    /// Frames in the file; one of them is the volume.
    pub frames: usize,
    /// Components per voxel in the file; one of them is the volume.
    pub components: usize,
    /// Columns or arrays of points, of which some may have been taken; none of a grid.
    pub columns: Vec<String>,
    /// The files that hold the voxels.
    pub data_files: Vec<PathBuf>,
    /// Every file that was read, once each: the header, where it is one of its own, and the data files. None of them may be written over
    /// while the volume is used.
    pub files: Vec<PathBuf>,
    /// True if the voxels stay in the file, mapped into memory.
    pub mapped: bool,
    /// Kind of the scanner, as DICOM names it: `CT`, `MR`, `PT`, …; `None` for other formats.
    pub modality: Option<String>,
    /// Lower and upper end of the values that a DICOM file wants shown, of its middle slice: the window's centre less and plus half its width.
    pub window: Option<[f64; 2]>,
}

/// What DICOM alone says beyond a description.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Scan {
    pub modality: Option<String>,
    pub window: Option<[f64; 2]>,
}

/// Everything that a header describes: all but the voxels.
pub(crate) struct Description {
    pub format: &'static str,
    /// The file that the header was read from; not always the one that was named.
    pub header: PathBuf,
    pub source: Source,
    pub layout: Layout,
    /// Placement in the world: in RAS already, where the space is a patient's.
    pub placement: Placement,
    pub placed_by: &'static str,
    pub calibration: Calibration,
    pub space: Space,
    pub units: Option<String>,
    pub notes: Vec<String>,
}

/// Reads a volume of any supported format: NRRD, MetaImage, NIfTI-1 and -2, raw, or those of scattered points ([`crate::read_points`]). The
/// format is told by the content first, by the name second.
///
/// # Errors
/// A [`FileError`] that names the file, the field, what was found and what is allowed.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded, FileError> {
    let path = path.as_ref();
    match describe(path, options)? {
        Described::Grid(description, scan) => load(path, *description, scan, options),
        Described::Points(format) => load_points(path, format, options),
    }
}

/// What a file turned out to hold.
enum Described {
    Grid(Box<Description>, Scan),
    Points(PointFormat),
}

/// Reads the header alone.
fn describe(path: &Path, options: &ReadOptions) -> Result<Described, FileError> {
    let (format, head) = if path.is_dir() {
        (detect_folder(path)?, Vec::new())
    } else {
        let head = file_head(path).map_err(|e| FileError::new(path, e))?;
        let format = match &options.raw {
            Some(description) => Format::Raw(description.clone()),
            None => detect(path, &head)?,
        };
        (format, head)
    };
    #[cfg_attr(not(feature = "dicom"), allow(unused_mut))]
    let mut scan = Scan::default();
    let description = match format {
        Format::Nrrd => nrrd::describe(path, options)?,
        Format::MetaImage => metaimage::describe(path, options)?,
        Format::Nifti => nifti::describe(path, options)?,
        #[cfg(feature = "dicom")]
        Format::Dicom => {
            let (description, found) = dicom::describe(path, options)?;
            scan = found;
            description
        }
        #[cfg(not(feature = "dicom"))]
        Format::Dicom => {
            return Err(FileError::new(path, FileErrorKind::Feature { format: "DICOM", feature: "dicom" }));
        }
        Format::Raw(description) => raw::describe(path, &description, Encoding::of_file(&head), options)?,
        Format::Points(format) => return Ok(Described::Points(format)),
    };
    Ok(Described::Grid(Box::new(description), scan))
}

/// The first few thousand bytes of a file: enough to tell every format.
pub(crate) fn file_head(path: &Path) -> io::Result<Vec<u8>> {
    const HEAD: u64 = 4096;
    let mut head = Vec::new();
    File::open(path)?.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}

fn load_points(path: &Path, format: PointFormat, options: &ReadOptions) -> Result<Loaded, FileError> {
    for (field, choice) in [("frame", options.frame), ("component", options.component)] {
        if let Some(choice) = choice {
            return Err(FieldError::new(field, choice, "scattered points have none to choose").in_file(path));
        }
    }
    let LoadedPoints { points, info, notes } = points::read_as(format, path, &options.points)?;
    Ok(Loaded { volume: points.into(), info, notes })
}

fn load(path: &Path, described: Description, scan: Scan, options: &ReadOptions) -> Result<Loaded, FileError> {
    let Description { format, header, source, layout, placement, placed_by, calibration, space, units, mut notes } =
        described;
    let (encoding, scalar, endian, data_files) =
        (source.encoding(), source.scalar(), source.endian(), each_once(source.files()));
    let samples = source.load(path, &layout, options, &mut notes)?;
    let mapped = samples.is_mapped();
    let grid = samples.into_grid(layout.dims, placement, calibration).map_err(|e| FileError::new(path, e))?;
    let volume = Volume::from(grid);
    if let Some(uniform) = volume.grid() {
        let stats = uniform.value_stats();
        let count = layout.count();
        if stats.nan > 0 {
            notes.push(format!("{} of {count} voxels are NaN: the cells around them are vacuum", stats.nan));
        }
        if stats.infinite > 0 {
            notes.push(format!("{} of {count} voxels are infinite and count as NaN", stats.infinite));
        }
    }
    let files = each_once([path.to_path_buf(), header].into_iter().chain(data_files.iter().cloned()));
    let info = FileInfo {
        format,
        encoding,
        scalar,
        endian,
        space,
        placed_by,
        units,
        frames: layout.frames,
        components: layout.components,
        columns: Vec::new(),
        data_files,
        files,
        mapped,
        modality: scan.modality,
        window: scan.window,
    };
    Ok(Loaded { volume, info, notes })
}

/// Paths without those that were there before.
pub(crate) fn each_once(paths: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
    let mut seen = HashSet::new();
    paths.into_iter().filter(|path| seen.insert(path.clone())).collect()
}
