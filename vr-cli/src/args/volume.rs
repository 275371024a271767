//! Flags of the volume, and of all that its file does not say.

use std::path::PathBuf;

use clap::Args;
use vr_core::transfer::ColorMap;
use vr_core::{PointKernel, PointMixing};
use vr_io::{CellsOrPoints, Endian, ScalarType, Transform};

use super::value;

/// The volume.
#[derive(Debug, Args)]
#[command(next_help_heading = "Volume")]
pub struct VolumeArgs {
    /// A volume file or folder: NRRD, MetaImage, NIfTI, DICOM, VTK, TIFF, Zarr, NetCDF and more, or raw with the size in its name; or scattered points: CSV, VTK (.vtp, .vtu, .vtk), NumPy or
    /// HDF5; or a mesh of cells: VTK (.vtu, .vts, .pvtu, .pvts, .vtk), PLOT3D or Exodus II; or a rectilinear grid: VTK (.vtr, .pvtr, .vtk); or an adaptive mesh: VTK (.vthb),
    /// an AMReX plotfile (its folder) or Enzo; without it, the embedded scene
    #[arg(value_name = "VOLUME")]
    pub path: Option<PathBuf>,
    /// A phantom instead of a file
    #[arg(long, value_name = "NAME", conflicts_with = "path")]
    pub phantom: Option<String>,
    /// Voxels along each axis of a phantom
    #[arg(long, value_name = "N", conflicts_with = "path")]
    pub phantom_size: Option<usize>,
    /// Frame of a series, from 0
    #[arg(long, value_name = "N")]
    pub frame: Option<usize>,
    /// Component of several, from 0; without it, RGB and RGBA are drawn as they are, and vectors of cells by their length
    #[arg(long, value_name = "N")]
    pub component: Option<usize>,
    /// DICOM: the series, by its SeriesInstanceUID or its number
    #[arg(long, value_name = "UID|NUMBER")]
    pub series: Option<String>,
    /// OME-Zarr: the resolution, from 0, the finest
    #[arg(long, value_name = "N")]
    pub volume_level: Option<usize>,
    /// NIfTI: transform that places the volume (auto, sform, qform or spacing)
    #[arg(long = "xform", value_name = "WHICH", value_parser = value::word::<Transform>)]
    pub transform: Option<Transform>,
    /// Raw files: voxels along x, y, z
    #[arg(long, value_name = "NXxNYxNZ", value_parser = value::dims, requires = "voxel_type")]
    pub dims: Option<[usize; 3]>,
    /// Raw files: type of the voxels (u8, i16, f32, ...)
    #[arg(long = "type", value_name = "TYPE", value_parser = value::word::<ScalarType>, requires = "dims")]
    pub voxel_type: Option<ScalarType>,
    /// Raw files: byte order, little or big
    #[arg(long, value_name = "ORDER", value_parser = value::word::<Endian>, requires = "dims")]
    pub endian: Option<Endian>,
    /// Raw files: bytes before the voxels
    #[arg(long, value_name = "BYTES", requires = "dims")]
    pub skip: Option<u64>,
    /// World units between voxels of a grid, in place of those in its file
    #[arg(long, value_name = "X,Y,Z", value_parser = value::triple::<f64>, allow_hyphen_values = true)]
    pub spacing: Option<[f64; 3]>,
    /// World position of the first voxel of a grid, in place of that in its file
    #[arg(long, value_name = "X,Y,Z", value_parser = value::triple::<f64>, allow_hyphen_values = true)]
    pub origin: Option<[f64; 3]>,
    /// Number of points of a phantom that is made of points
    #[arg(long, value_name = "N", conflicts_with = "path")]
    pub points_count: Option<usize>,
    /// Cells with vertices: take the cells or, with points, the vertices alone as scattered points
    #[arg(long = "as", value_name = "KIND", value_parser = value::word::<CellsOrPoints>)]
    pub cells_or_points: Option<CellsOrPoints>,
    /// VTK images, NetCDF and HDF5: the array, by name or path. Cells, rectilinear grids and adaptive meshes: the array of points or cells. Points: the column or array of the values, one that vr info lists; 1 for a value of 1 at every point
    #[arg(long, value_name = "NAME")]
    pub value: Option<String>,
    /// Points: kernel that spreads each (cubic-spline, gaussian or cone)
    #[arg(long, value_name = "NAME", value_parser = value::word::<PointKernel>)]
    pub kernel: Option<PointKernel>,
    /// Points: field where kernels overlap, their sum or the mean of the values weighted by them
    #[arg(long, value_name = "WHICH", value_parser = value::word::<PointMixing>)]
    pub mixing: Option<PointMixing>,
    /// Points: column or array that points have their colours of; opacity follows the values
    #[arg(long, value_name = "NAME")]
    pub color_value: Option<String>,
    /// Points: colours of that column (viridis, inferno or cool-warm)
    #[arg(long, value_name = "NAME", value_parser = value::word::<ColorMap>)]
    pub color_map: Option<ColorMap>,
    /// Points: numbers of the first and of the last of these colours; without it, the smallest and the largest
    #[arg(long, value_name = "LOW,HIGH", value_parser = value::pair, allow_hyphen_values = true)]
    pub color_range: Option<[f64; 2]>,
    /// Points: radius of all kernels in world units, in place of the file's; twice a smoothing length
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    pub radius: Option<f64>,
    /// Points: factor on every radius
    #[arg(long, value_name = "FACTOR", allow_hyphen_values = true)]
    pub radius_scale: Option<f64>,
    /// Points: the columns of positions (text alone), as X,Y,Z
    #[arg(long, value_name = "X,Y,Z", value_parser = value::triple::<String>)]
    pub position_columns: Option<[String; 3]>,
    /// Points: the column that is the radius, smoothing_length, mass, density or weight; may be repeated
    #[arg(long, value_name = "ROLE=NAME", value_parser = value::key_value)]
    pub column: Vec<(String, String)>,
}
