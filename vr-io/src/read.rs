//! The one way in: a file of any format becomes a volume, with what is worth knowing about it.

use std::collections::HashSet;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use glam::DMat3;
use vr_core::{Calibration, ColorGrid, GridError, Placement, Volume};
use vr_look::Hints;

use crate::amr::{self, AmrFormat};
use crate::cells::{self, CellFormat, CellsOrPoints};
use crate::detect::{Format, detect, detect_folder};
use crate::encoding::Encoding;
use crate::error::{FieldError, FileError};
use crate::given_place::GivenPlace;
use crate::layout::Layout;
use crate::memory_folder;
use crate::nifti::Transform;
use crate::notes::Notes;
use crate::points::{self, LoadedPoints, PointFormat, PointOptions};
use crate::raw::RawDescription;
use crate::regular_file;
use crate::scalar::{Endian, ScalarType};
use crate::source::Source;
use crate::voxels::{Stored, Voxels};
use crate::vtk::RectilinearFormat;
use crate::world::Space;
use crate::{
    colors, dicom, metaimage, mrc, netcdf, nifti, npy, nrrd, opendx, pvm, raw, slc, slices, tiff, vdb, voreen, vtk,
    zarr,
};

/// Options of reading a volume. `ReadOptions::default()` is right for nearly every file.
#[derive(Clone, Debug)]
pub struct ReadOptions {
    /// Frame of a 4-D file, from 0; the first if absent, which is said.
    pub frame: Option<usize>,
    /// Component of a file with several values per voxel, from 0. If absent, the voxels of a file of colours are these colours
    /// ([`Volume::Color`]), of cells the length of all components is taken, and of others the first one, which is said.
    pub component: Option<usize>,
    /// Array of a file that holds several under names; not needed where the file says which one is meant, or has one. Of scattered points
    /// and cells, that of the values ([`PointOptions::value`], which comes first); `1` for a value of 1 everywhere.
    pub array: Option<String>,
    /// Resolution of an OME-Zarr image, from 0, the finest; `None` takes the finest of at most 2²⁷ voxels. Other files have none.
    pub level: Option<usize>,
    /// Series of a DICOM folder: its SeriesInstanceUID, or its SeriesNumber where no other series has it; not needed where there is one.
    pub series: Option<String>,
    /// Transform of a NIfTI file that places the volume.
    pub transform: Transform,
    /// Spacing and origin of a grid in place of the file's own.
    pub place: GivenPlace,
    /// Description of a file without a header. Where this is given, the file counts as raw, whatever it looks like.
    pub raw: Option<RawDescription>,
    /// True if uncompressed voxels of a memory type in native byte order may stay in the file, mapped into memory: the
    /// default. If false, they are copied, and the file may change or vanish afterwards.
    pub map: bool,
    /// Options of reading scattered points.
    pub points: PointOptions,
    /// The way to take a file that has cells with vertices; if absent, a mesh of the cells where they have three dimensions and values, else points.
    pub cells_or_points: Option<CellsOrPoints>,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            frame: None,
            component: None,
            array: None,
            level: None,
            series: None,
            transform: Transform::Auto,
            place: GivenPlace::default(),
            raw: None,
            map: true,
            points: PointOptions::default(),
            cells_or_points: None,
        }
    }
}

impl ReadOptions {
    /// The same with [`PointOptions::value`] for the array, which comes first where a file may give points.
    pub(crate) fn with_point_value(&self) -> Self {
        Self { array: self.points.value.clone().or_else(|| self.array.clone()), ..self.clone() }
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
    /// used, voxels that are missing (but of 2²⁴ voxels and more that stay in the file, none is read yet:
    /// [`vr_core::GridVolume::value_stats`] counts them).
    pub notes: Vec<String>,
}

/// Everything that a file says about itself beyond the volume.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FileInfo {
    /// `NRRD`, `MetaImage`, `NIfTI-1`, `NIfTI-2`, `DICOM`, `VTK ImageData`, `MRC`, `OME-TIFF`, `PNG slices`, `Zarr`, … or `raw`; of points `CSV`,
    /// `VTK PolyData`, `NumPy`, …
    pub format: &'static str,
    /// `raw`, `gzip`, `bzip2`, `zlib`, `hex`, `ascii`, or the name of the format's own coding; of VTK's also `base64` or `lz4`.
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
    /// Components per voxel in the file; one of them is the volume, or all where they are a colour. Of cells, those of the array that is taken.
    pub components: usize,
    /// Columns or arrays of points or cells, of which some may have been taken; none of a grid.
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

impl FileInfo {
    /// Facts for an automatic look.
    pub fn hints(&self) -> Hints {
        Hints { patient: self.space.is_patient(), map: self.format == mrc::FORMAT, ..Hints::default() }
    }
}

/// Attributes that only DICOM has.
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
    /// `None` for every format but DICOM.
    pub scan: Option<Scan>,
    pub notes: Notes,
}

/// Reads a volume of any supported format, from a file, a folder or a pattern of names; the crate's page lists them. The
/// format is told by the content first, by the name second.
///
/// # Errors
/// A [`FileError`] that names the file, the field, what was found and what is allowed.
pub fn read(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Loaded, FileError> {
    let path = path.as_ref();
    match describe(path, options)? {
        Described::Grid(description) if takes_colors(&description, options) => {
            let load = |source, layout: &Layout, placement, _, notes: &mut Vec<String>| {
                colors::load(path, source, layout, placement, options, notes).map(|colors| (colors.into(), false))
            };
            assemble(path, *description, options, load)
        }
        Described::Grid(description) => load(path, *description, options),
        Described::Points(format) => load_points(path, format, options),
        Described::Cells(format, head) => cells::read_as(format, path, &head, options),
        Described::Rectilinear(format) => vtk::read_rectilinear(format, path, options),
        Described::Amr(format) => amr::read_as(format, path, options),
    }
}

/// The source and the layout of one component of a file.
pub(crate) fn component(
    path: &Path,
    component: usize,
    options: &ReadOptions,
) -> Result<Option<(Source, Layout)>, FileError> {
    let options = ReadOptions { component: Some(component), ..options.clone() };
    Ok(match describe(path, &options)? {
        Described::Grid(description) => Some((description.source, description.layout)),
        _ => None,
    })
}

/// True if the components of a file are taken together, as colours.
fn takes_colors(description: &Description, options: &ReadOptions) -> bool {
    let scalar = description.source.scalar();
    let takes = matches!(scalar, ScalarType::U8 | ScalarType::U16 | ScalarType::F32 | ScalarType::F64);
    takes && description.layout.is_color && options.component.is_none()
}
/// Number of voxels from which they are worth not to be read before they are needed.
const LARGE: usize = 1 << 24;

/// Reads the header alone, and stands a volume of at most two voxels along each axis, all zero, in for the one that [`read()`] gives: of its
/// box and, where memory holds the file's type as it is, of its type. Tells in milliseconds what a file of gigabytes is, and whether a
/// renderer draws it ([`vr_core::Renderer::supports`]). `None` for scattered points, whose files have no header that says as much, and for
/// volumes of less than 2²⁴ voxels, which are read as fast as told.
///
/// # Errors
/// A [`FileError`] about the header.
pub fn outline(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Option<Loaded>, FileError> {
    let path = path.as_ref();
    let Described::Grid(mut description) = describe(path, options)? else { return Ok(None) };
    let Layout { dims, .. } = description.layout;
    if description.layout.count() < LARGE {
        return Ok(None);
    }
    let few = dims.map(|n| n.min(2));
    // The steps of two voxels span the box; one voxel keeps its step.
    let stretch = dims.map(|n| n.saturating_sub(1).max(1) as f64);
    let axes = description.placement.axes() * DMat3::from_diagonal(stretch.into());
    let in_file = |e: GridError| FileError::new(path, e);
    description.placement = Placement::new(description.placement.origin(), axes).map_err(in_file)?;
    let count = few.iter().product();
    if takes_colors(&description, options) {
        let black = vec![0u8; 3 * count];
        let stand_in = |_, _: &Layout, placement, _, _: &mut Vec<String>| {
            let colors = ColorGrid::from_components(few, &black, 3, placement).map_err(in_file)?;
            Ok((colors.into(), false))
        };
        return assemble(path, *description, options, stand_in).map(Some);
    }
    let voxels = match description.source.scalar() {
        ScalarType::U8 => Voxels::U8(Stored::Owned(vec![0; count])),
        ScalarType::I8 => Voxels::I8(Stored::Owned(vec![0; count])),
        ScalarType::U16 => Voxels::U16(Stored::Owned(vec![0; count])),
        ScalarType::I16 => Voxels::I16(Stored::Owned(vec![0; count])),
        _ => Voxels::F32(Stored::Owned(vec![0.0; count])),
    };
    assemble(path, *description, options, |_, _, placement, calibration, _| {
        grid_of(voxels, path, few, placement, calibration)
    })
    .map(Some)
}

/// Content of a file.
enum Described {
    Grid(Box<Description>),
    Points(PointFormat),
    /// With the beginning of the file.
    Cells(CellFormat, Vec<u8>),
    Rectilinear(RectilinearFormat),
    Amr(AmrFormat),
}

/// Reads the header alone.
fn describe(path: &Path, options: &ReadOptions) -> Result<Described, FileError> {
    let (format, head) = if memory_folder::is_folder(path) {
        (detect_folder(path)?, Vec::new())
    } else if slices::is_pattern(path) {
        (Format::Slices, Vec::new())
    } else {
        let head = file_head(path).map_err(|e| FileError::new(path, e))?;
        let format = match &options.raw {
            Some(description) => Format::Raw(description.clone()),
            None => detect(path, &head)?,
        };
        (format, head)
    };
    #[cfg(feature = "hdf5")]
    let format = match format {
        Format::Points(PointFormat::Hdf5) if !points::hdf5::holds_points(path) => Format::Hdf5,
        other => other,
    };
    // What has cells besides its points is no list of points.
    let format = match format {
        Format::Points(_) => cells::by_content(&head).map_or(format, Format::Cells),
        Format::NetCdf if cells::is_exodus(path) => Format::Cells(CellFormat::Exodus),
        other => other,
    };
    let is_points = matches!(format, Format::Points(_));
    let choices = [
        (
            "array",
            options.array.clone(),
            is_points || format.has_named_arrays(),
            "files of this format hold one array, without a name",
        ),
        ("series", options.series.clone(), matches!(format, Format::Dicom), "only DICOM files belong to series"),
        (
            "level",
            options.level.map(|n| n.to_string()),
            matches!(format, Format::Zarr),
            "only OME-Zarr images have levels",
        ),
    ];
    let takes_cells = matches!(format, Format::Cells(_));
    let wants_points = options.cells_or_points == Some(CellsOrPoints::Points) && is_points;
    if let Some(found) = options.cells_or_points.filter(|_| !takes_cells && !wants_points) {
        let allowed = "only files of cells with vertices have the choice";
        return Err(FieldError::new("as", found.name(), allowed).in_file(path));
    }
    for (field, choice, is_there, otherwise) in choices {
        if let Some(found) = choice.filter(|_| !is_there) {
            return Err(FieldError::new(field, found, otherwise).in_file(path));
        }
    }
    if matches!(format, Format::Points(_) | Format::Cells(_) | Format::Rectilinear(_) | Format::Amr(_)) {
        options.place.refuse(path)?;
    }
    let mut description = match format {
        Format::Nrrd => nrrd::describe(path, options)?,
        Format::MetaImage => metaimage::describe(path, options)?,
        Format::Nifti => nifti::describe(path, options)?,
        Format::Mrc => mrc::describe(path, options)?,
        Format::NetCdf => netcdf::describe(path, options)?,
        Format::Vdb => vdb::describe(path, options)?,
        #[cfg(feature = "hdf5")]
        Format::Hdf5 => crate::hdf5::describe(path, options)?,
        Format::Pvm => pvm::describe(path, options)?,
        Format::Slc => slc::describe(path, options)?,
        Format::Npy => npy::describe(path, options)?,
        Format::DxGeneral => opendx::describe_general(path, options)?,
        Format::DxNative => opendx::describe_native(path, options)?,
        Format::Vvd => voreen::describe_vvd(path, options)?,
        Format::Dat => voreen::describe_dat(path, options)?,
        Format::Tiff => tiff::describe(path, options)?,
        Format::Slices => slices::describe(path, options)?,
        Format::Zarr => zarr::describe(path, options)?,
        Format::Dicom => dicom::describe(path, options)?,
        Format::Raw(description) => raw::describe(path, &description, Encoding::of_file(&head), options)?,
        Format::VtkImage(format) => vtk::describe(format, path, options)?,
        Format::Points(format) => return Ok(Described::Points(format)),
        Format::Cells(format) => return Ok(Described::Cells(format, head)),
        Format::Rectilinear(format) => return Ok(Described::Rectilinear(format)),
        Format::Amr(format) => return Ok(Described::Amr(format)),
    };
    options.place.apply(&mut description)?;
    Ok(Described::Grid(Box::new(description)))
}

/// The first few thousand bytes of a file: enough to tell every format.
pub(crate) fn file_head(path: &Path) -> io::Result<Vec<u8>> {
    const HEAD: u64 = 4096;
    let mut head = Vec::new();
    regular_file::open(path)?.take(HEAD).read_to_end(&mut head)?;
    Ok(head)
}

pub(crate) fn load_points(path: &Path, format: PointFormat, options: &ReadOptions) -> Result<Loaded, FileError> {
    for (field, choice) in [("frame", options.frame), ("component", options.component)] {
        if let Some(choice) = choice {
            return Err(FieldError::new(field, choice, "scattered points have none to choose").in_file(path));
        }
    }
    let mut choices = options.points.clone();
    choices.value = choices.value.or_else(|| options.array.clone());
    let LoadedPoints { points, info, notes } = points::read_as(format, path, &choices)?;
    Ok(Loaded { volume: points.into(), info, notes })
}

fn load(path: &Path, description: Description, options: &ReadOptions) -> Result<Loaded, FileError> {
    let dims = description.layout.dims;
    assemble(path, description, options, |source, layout, placement, calibration, notes| {
        let voxels = source.load(path, layout, options, notes)?;
        grid_of(voxels, path, dims, placement, calibration)
    })
}

/// The volume of voxels, and whether they stay in their file.
fn grid_of(
    voxels: Voxels,
    path: &Path,
    dims: [usize; 3],
    placement: Placement,
    calibration: Calibration,
) -> Result<(Volume, bool), FileError> {
    let mapped = voxels.is_mapped();
    let grid = voxels.into_grid(dims, placement, calibration).map_err(|e| FileError::new(path, e))?;
    Ok((grid.into(), mapped))
}

/// The volume of a description, which `make` makes of its voxels; with it, whether they stay in their file.
fn assemble(
    path: &Path,
    description: Description,
    options: &ReadOptions,
    make: impl FnOnce(Source, &Layout, Placement, Calibration, &mut Vec<String>) -> Result<(Volume, bool), FileError>,
) -> Result<Loaded, FileError> {
    let takes_colors = takes_colors(&description, options);
    let Description {
        format,
        header,
        source,
        layout,
        placement,
        placed_by,
        calibration,
        space,
        units,
        scan,
        mut notes,
    } = description;
    let Scan { modality, window } = scan.unwrap_or_default();
    let (encoding, scalar, endian, data_files) =
        (source.encoding(), source.scalar(), source.endian(), each_once(source.files()));
    let components = if takes_colors { 1 } else { layout.components };
    let chosen = [("frame", layout.frames, options.frame), ("component", components, options.component)];
    for (what, count, _) in chosen.into_iter().filter(|&(_, count, chosen)| count > 1 && chosen.is_none()) {
        notes.push(format!("{what} 0 is taken, of 0 to {}", count - 1));
    }
    let (volume, mapped) = make(source, &layout, placement, calibration, &mut notes)?;
    if !has_unread_voxels(&volume, mapped) {
        notes.extend(missing_voxels(&volume));
    }
    // A folder or a pattern is no file.
    let named = [path.to_path_buf(), header].into_iter().filter(|path| memory_folder::is_file(path));
    let files = each_once(named.chain(data_files.iter().cloned()));
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
        modality,
        window,
    };
    Ok(Loaded { volume, info, notes: notes.into_lines() })
}

/// True if a volume's voxels are so many that none is read before it is asked for: opening takes milliseconds then.
pub(crate) fn has_unread_voxels(volume: &Volume, mapped: bool) -> bool {
    mapped && volume.grid().is_some_and(|grid| grid.dims().iter().product::<usize>() >= LARGE)
}

/// Notes on voxels that are missing; reads all of them, if they are floats.
pub(crate) fn missing_voxels(volume: &Volume) -> Vec<String> {
    let mut notes = Vec::new();
    // No integer is missing.
    if let Some(grid) = volume.value_grid().filter(|grid| !grid.voxel_type().is_integer()) {
        let (stats, count) = (grid.value_stats(), grid.dims().iter().product::<usize>());
        if stats.nan > 0 {
            notes.push(format!("{} of {count} voxels are NaN: the cells around them are vacuum", stats.nan));
        }
        if stats.infinite > 0 {
            notes.push(format!("{} of {count} voxels are infinite, or beyond f32, and count as NaN", stats.infinite));
        }
    }
    notes
}

/// Paths without those that were there before.
pub(crate) fn each_once(paths: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
    let mut seen = HashSet::new();
    paths.into_iter().filter(|path| seen.insert(path.clone())).collect()
}
