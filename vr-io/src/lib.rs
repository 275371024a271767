//! Files in and out: volumes, scene files and colour maps are read, pictures and volumes written.
//!
//! [`read()`] takes a volume of any supported format, told by its content first and by its name second, and gives a
//! [`vr_core::Volume`], what the file said about it, and notes on what had to be assumed. [`load_scene`] takes a scene file with
//! everything that it names, [`read_points`] scattered points, and [`read_mesh`] an opaque surface. [`write()`](write()), [`write_volume`] and [`write_scene`] go the other way. [`read_picture`] takes
//! pictures of other programs, and our own, for comparison.
//!
//! ```
//! use vr_io::{NrrdOptions, ReadOptions};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! let raw = folder.path().join("ramp_4x3x2_uint8.raw");
//! std::fs::write(&raw, (0..24).collect::<Vec<u8>>())?;
//!
//! // A name like this describes a raw file; the other formats describe themselves.
//! let loaded = vr_io::read(&raw, &ReadOptions::default())?;
//! assert_eq!(loaded.volume.value_range(), Some((0.0, 23.0)));
//! assert_eq!(loaded.notes, ["raw files state no spacing: 1, 1, 1 is assumed"]);
//!
//! let nrrd = folder.path().join("ramp.nrrd");
//! vr_io::write_nrrd(&nrrd, &loaded.volume, &NrrdOptions::default())?;
//! assert_eq!(vr_io::read(&nrrd, &ReadOptions::default())?.info.encoding, "gzip");
//!
//! // What is wrong is said in one line: file, field, what was found, what is allowed.
//! std::fs::write(&raw, [0; 23])?;
//! let error = vr_io::read(&raw, &ReadOptions::default()).unwrap_err().to_string();
//! assert!(error.contains("the header claims 24 bytes of voxels, found 23; the two must agree"));
//! # Ok(())
//! # }
//! ```
//!
//! # Scene files
//!
//! A [`SceneFile`] holds the sections of the text; [`resolve_scene`] reads what they name.
//!
//! ```
//! use std::path::Path;
//! use vr_io::VolumeSource;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = "[volume]\nphantom = \"blobs\"\nsize = 8\n[camera]\neye = [0, 0, 9]\ntarget = [0, 0, 0]\nup = [0, 1, 0]\nheight = 3\n";
//! let file = vr_io::parse_scene(text, Path::new("blobs.toml"))?;
//! assert!(matches!(&file.volume.source, Some(VolumeSource::Phantom { size: Some(8), .. })));
//! let loaded = vr_io::resolve_scene(&file, Path::new("blobs.toml"))?;
//! assert_eq!((loaded.view.camera.eye.z, loaded.view.size), (9.0, [512, 512]));
//!
//! let error = vr_io::parse_scene("[volume]\nphantom = \"blobs\"\nsise = 8\n", Path::new("blobs.toml")).unwrap_err();
//! assert_eq!(error.to_string(), "blobs.toml: line 3: unknown key 'sise'; did you mean 'size'?");
//! # Ok(())
//! # }
//! ```
//!
//! [`SceneFile::completed`] states what a file leaves open, and [`commented_scene`] writes it with the meaning of every key.
//!
//! # Records in pictures
//!
//! [`write_with_record`] puts a [`PictureRecord`] into a picture, from which it can be drawn again bit for bit: the complete scene, the
//! version of the program, and hashes of volume ([`volume_hash`]) and pixels ([`StoredPixels`]). It is TOML, in PNG an iTXt chunk `vr` beside
//! `Software` and `Description`, in EXR a text attribute `vr` beside `software` and `comments`. Folders, and names of a patient's files,
//! are left out. [`read_record`] reads it.
//!
//! # Volumes that are read
//!
//! | format | files | encodings |
//! |---|---|---|
//! | raw | described by [`RawDescription`] or by the name | raw, gzip, bzip2 |
//! | NRRD 1 to 5 | attached, detached, lists and patterns of files | raw, gzip, bzip2, hex, ascii |
//! | MetaImage | `.mha`, `.mhd`, lists and patterns of files | raw, zlib, ascii |
//! | DICOM | a folder of slices, one of them with its siblings, files of many frames | raw, deflate, RLE, JPEG (8 bits, lossless), JPEG-LS; JPEG 2000 with the feature `jpeg2000` |
//! | NIfTI-1, NIfTI-2 | `.nii`, pairs of `.hdr` and `.img` | raw, gzip |
//! | VTK ImageData, XML | `.vti`, pieces of one file or, of `.pvti`, of several | text, base64, appended (base64 or raw), zlib, LZ4, LZMA |
//! | VTK STRUCTURED_POINTS, legacy | `.vtk` up to version 5.1 | text, raw |
//! | MRC, CCP4 | `.mrc`, `.map`; modes 0, 1, 2, 6 and 12, cells with any angles | raw, gzip, bzip2 |
//! | PVM 1 to 3 | `.pvm` | raw, gzip, bzip2, Differential Data Streams v3d and v3e |
//! | SLC | `.slc`, 8 bits | raw, runs |
//! | NumPy | `.npy` of three to five axes, `[z, y, x]`, in C and Fortran order | raw, gzip, bzip2 |
//! | OpenDX | `.general` headers, `.dx` with regular grids | raw, gzip, bzip2, ascii |
//! | Voreen | `.vvd`, `.dat` with a raw file; `.dat` of three 16-bit sizes and 16-bit voxels | raw, gzip, bzip2 |
//! | TIFF, BigTIFF | pages of one file; ImageJ's and OME-TIFF's stacks | raw, PackBits, LZW, Deflate, JPEG |
//! | slices | a folder of TIFF, PNG, JPEG, BMP or PNM files, or a pattern such as `slice_%03d.png` | theirs |
//! | Zarr 2 and 3, OME-Zarr | local folders, shards among them | raw, gzip, zlib, bzip2, zstd, lz4, blosc |
//! | NetCDF, classic | CDF-1, CDF-2 and CDF-5 | raw; packed by `scale_factor`, `add_offset`, `_FillValue`, `valid_range` |
//! | OpenVDB | grids of floats, dense around what is active | raw, zlib, blosc, 16-bit floats |
//! | HDF5, NetCDF-4, feature `hdf5` | datasets of three axes and more | raw, chunks with Deflate, shuffle, Fletcher-32, SZIP, n-bit, scale-offset, LZ4 |
//!
//! Integers and floats of 8 to 64 bits, in both byte orders. Memory holds u8, i8, u16, i16 and f32; of the others, integers that
//! fit one of these exactly become that one, and everything else becomes f32, which is said where it rounds. Uncompressed
//! voxels that memory can hold as they are stay in the file, mapped. One frame of a series and one component of several are
//! picked by [`ReadOptions`], and so are one series of DICOM, one resolution of OME-Zarr, and one array of a file that holds several under names: else it is the one that VTK calls the active
//! scalars, the first with one component, or the first; of NetCDF and HDF5 the largest of at most 2²⁷ numbers, and a note lists the others. VTK's numbers of cells are placed at the centres of the cells.
//! Points and cells that `vtkGhostType` hides in VTK's images have no value: then all become floats.
//!
//! Voxels of three or four components that are colours become a [`vr_core::ColorGrid`]: RGB24 and RGBA32 of NIfTI, the kinds RGB-color and
//! RGBA-color of NRRD, RGB TIFF and slices of colour, RGB of DICOM, and three or four bytes a voxel in NRRD, MetaImage, VTK, Voreen
//! and NumPy, which have no word for colours that every writer uses. Integers are sRGB, floats are linear light.
//!
//! # Volumes that are written
//!
//! | format | files | placement | calibration |
//! |---|---|---|---|
//! | NRRD | `.nrrd`, gzip | any | applied ([`write_nrrd`] can keep it as keys) |
//! | NIfTI-1 | `.nii`, `.nii.gz` | any, in 32 bits: sform, and qform but of sheared grids; always a patient's | kept, in 32 bits; applied where that is off by a millionth of the range |
//! | MetaImage | `.mha`, `.mhd` with `.raw` | any, as ITK writes it; a patient's, but for spacing alone | applied |
//! | VTK ImageData | `.vti`, appended raw | perpendicular axes; no patients | applied |
//! | OME-Zarr 0.5 | `.zarr`, a folder: Zarr 3, chunks of 64³, gzip | along the axes of the world, in any order and direction; no patients | applied |
//! | raw | `.raw`, little-endian | none: a note tells the flags that read it | applied |
//! | PNG slices | `out_%03d.png`, or a folder `out/`; whole values from 0 to 255 or 65535 | none | applied |
//!
//! A calibration is applied to integers where all values are whole and fit, to 32-bit floats otherwise, or 64-bit ones where 32 bits would lose
//! digits. [`WriteVolumeOptions`] say whether the world is a patient's, and [`WrittenVolume`] what the format does not hold. [`crop_grid`],
//! [`flip_grid`], [`resample_grid`] and [`convert_grid`] change a grid before.
//!
//! # Transfer functions that are read and written
//!
//! | format | files | what is taken | written |
//! |---|---|---|---|
//! | ParaView | `.json`; old XML with `<ColorMap>` | colours in their colour space, opacities; the first map of several | JSON |
//! | 3D Slicer | `.vp`, `.vp.json`, `presets.xml`, scenes | colours, opacities, shading, gradient opacity, nearest filter | `.vp` |
//! | VTK | XML of `VolumeProperty`, `ColorTransferFunction`, `PiecewiseFunction` | as above; the first component | |
//! | ImageJ, NIH Image | `.lut`: 768 bytes, 32 before them, or text | colours; opacity grows over the range | 768 bytes |
//! | tables | `.csv`, `.tsv`, text: value, red, green, blue, opacity, with or without names; 0 to 1 or 0 to 255 | all columns | both |
//! | scene files | TOML with `[transfer]` points, and `[shading]` | every digit | yes |
//!
//! [`read_transfer`] tells them by content. ParaView's and ImageJ's are spread over the volume's values; the others stay at their own.
//!
//! # Scattered points that are read
//!
//! | format | files | what is taken |
//! |---|---|---|
//! | text | `.csv`, `.tsv`, `.txt`; commas, semicolons, tabs or blanks; with a line of names, or x y z \[radius \[value \[weight\]\]\] | columns by name |
//! | VTK, XML | `.vtp`, `.vtu`: text, base64, appended (base64 or raw), zlib, LZ4, LZMA | points of all pieces, point data by name |
//! | VTK, legacy | `.vtk` up to version 5.1 with POLYDATA or UNSTRUCTURED_GRID, text or binary | points, point data by name |
//! | NumPy | `.npy`, N×3 | positions |
//! | HDF5, feature `hdf5` | snapshots of Gadget's family (`PartType0/Coordinates`), dumps of Phantom (`particles/xyz`) | one kind of particle, datasets by name |
//!
//! [`read()`] gives a volume of points, and so does [`read_points`], whose page tells where radii, weights and values come from; [`PointOptions`]
//! choose columns, the kernel, radii, the sum or the mean, and a column that colours are made of. Points that make no sense (a radius of 0, a position that is NaN) are refused by number or line and column.
//! Cells are left out, which is said; grids whose cells have a volume and values become meshes, as follows.
//!
//! # Meshes of cells that are read
//!
//! | format | files | what is taken |
//! |---|---|---|
//! | VTK, legacy | `.vtk` up to version 5.1 with UNSTRUCTURED_GRID or STRUCTURED_GRID, text or binary | cells of three dimensions, data of points or cells |
//! | VTK, XML | `.vtu`, `.vts`: text, base64, appended (base64 or raw), zlib, LZ4, LZMA; pieces, also in files of their own (`.pvtu`, `.pvts`) | the same; ghosts and blanked cells are left out |
//! | PLOT3D | binary grids of three dimensions with a solution beside: both byte orders, 32 and 64 bits, with record marks or without, several grids, `iblank` | Density, Momentum, Energy |
//! | Exodus II | NetCDF's classic formats: blocks of TETRA, PYRAMID, WEDGE and HEX | values of nodes and elements at one time step; vectors of three names that end in x, y, z |
//!
//! [`read()`] gives a [`vr_core::CellMesh`] where there are cells of three dimensions and an array of values, and scattered points otherwise
//! ([`ReadOptions::cells_or_points`] chooses). Tetrahedra, voxels, hexahedra, wedges, pyramids, prisms and polyhedra are split alike on both sides of a
//! face; cells of higher order are taken by their corners; vertices, lines and surfaces are counted and left out. Pieces are welded where vertices have the
//! same position, bit by bit. A vertex that is not there is refused with its cell; cells without a volume, repeated or without a finite value are left
//! out, which is said.
//!
//! # Rectilinear grids that are read
//!
//! | format | files | what is taken |
//! |---|---|---|
//! | VTK, legacy | `.vtk` up to version 5.1 with RECTILINEAR_GRID, text or binary | planes, data of points or cells |
//! | VTK, XML | `.vtr`: text, base64, appended (base64 or raw), zlib, LZ4, LZMA; pieces, also in files of their own (`.pvtr`) | the same |
//!
//! [`read()`] gives a [`vr_core::RectilinearGrid`] with values of 32 bits or, where all planes are at even distances but for rounding, a uniform grid. Points
//! and cells that `vtkGhostType` hides have no value. Of vectors the length is taken, or the component that [`ReadOptions::component`] names. Planes
//! that neither rise nor fall all the way, and pieces that place one plane differently, are refused.
//!
//! # Adaptive meshes that are read
//!
//! | format | files | what is taken |
//! |---|---|---|
//! | VTK | `.vthb`, `.vth` of versions 1.0 and 1.1, overlapping or not: lists of `.vti` files | data of cells or points; cells that `vtkGhostType` marks as copies are left out, blanked ones have no value |
//! | AMReX | plotfiles: a folder, or its file `Header`; HyperCLaw-V1.1, NavierStokes-V1.1, CartGrid-V2.0; boxes with headers of their own or without, 32 and 64 bits in both byte orders | components by name, without ghost cells |
//! | Enzo, packed | a folder, its parameters, or its `.hierarchy`; HDF5 with the feature `hdf5`, without it as Enzo itself writes it | fields by name, without ghost zones; no particles |
//!
//! [`read()`] gives a [`vr_core::AmrGrid`] with values of 32 bits. Ratios come from the edges of the levels' cells and must be whole numbers, along each axis
//! its own; blocks must begin at corners of their level's cells. A block that ends within a coarser cell is grown to the whole of it, with values of its
//! neighbours or of that cell, which is said. Files that a header names must lie within its folder.
//!
//! # Surfaces that are read
//!
//! | format | files | what is taken |
//! |---|---|---|
//! | STL | text and binary | triangles; normals of facets are computed anew |
//! | OBJ | text | vertices with colours, normals, polygons |
//! | PLY | text, binary of either byte order | vertices with colours and normals, polygons |
//!
//! Colours are taken as sRGB. Positions are world positions of the volume that the surface stands in, in the file's own frame: a
//! surface made from a scan in LPS has to be turned to RAS before.
//!
//! # Where a volume lies
//!
//! The world is RAS (right, anterior, superior) for files that declare a patient space, and the file's own frame otherwise.
//! * **NIfTI** is RAS. The sform places it if its code is above 0, else the qform, else spacing alone; [`Transform`] chooses.
//! * **DICOM** is LPS, turned to RAS. Slices are sorted along their normal, and the distance between them comes from their positions; a
//!   tilted gantry shears the grid. Without positions the slices keep a frame of their own.
//! * **NRRD** with a `space` of RAS, LAS or LPS *and* `space directions` is turned to RAS. A space without directions says
//!   nothing about the axes, so the file's own frame is kept.
//! * **MetaImage** with a `TransformMatrix`, an `Offset` or an `AnatomicalOrientation` is taken as ITK writes it, LPS, and
//!   turned to RAS; without any of them it keeps its own frame.
//! * **VTK** knows no patients: its origin, spacing and direction are kept as they are.
//! * **MRC** is placed by its cell, in Å: ORIGIN where it is not 0, else the first column, row and section.
//!   Columns, rows and sections stay what they are in memory, whichever axes of the cell they run along.
//! * **TIFF** has the resolution that its tags say, and from ImageJ or OME-XML the distance of slices. Slices in files of their own, and
//!   plain Zarr arrays, say nothing of it.
//! * **NetCDF and HDF5** are placed by coordinates along their axes where these are lengths, and by `element_size_um`. Degrees and pressures give
//!   the directions of the axes alone: north is up.
//! * **OME-Zarr** is placed by `coordinateTransformations`. Of its resolutions the finest of at most 2²⁷ voxels is read unless
//!   [`ReadOptions::level`] chooses.
//!
//! # Animations
//!
//! [`write_animation`] puts frames that are PNG files together, one in memory at a time: as GIF (one palette for all frames, dithered by place so
//! that still parts are still), animated PNG or WebP, both without loss. [`read_keys`] reads key frames, and [`KeyFile`] gives camera,
//! control points and clip at any time between them. [`files_of_pattern`] lists the volumes of a time series.
//!
//! # Bad files
//!
//! Every error is one line that names the file, the field, what was found and what is allowed. Nothing is allocated on a
//! header's word: what it claims is held against the length of the file, and what is compressed grows as it comes out. Files
//! are written beside their place and renamed, so that they are there whole or not at all.
//!
//! # Large files
//!
//! Voxels that stay in their file are not read before they are asked for: a file of gigabytes opens in milliseconds. Floats are read once, for
//! their range and for what is missing, when their values are first asked for.
//!
//! # What is not here yet
//!
//! These are recognised, and refused by name:
//! * VTK: parallel files of points (`.pvtp`; their parts can be read), and trees of cells (`.htg`);
//! * adaptive meshes of two dimensions, in cylindrical or spherical coordinates, or of Enzo's older formats;
//! * ParaView's colour maps with indexed (categorical) colours;
//! * DICOM: frames in High-Throughput JPEG 2000, JPEG XL and JPEG of 12 bits, and images of single bits.
//!
//! # Features
//! * `hdf5`, off by default: points and grids in HDF5, NetCDF-4 among them, and Enzo's meshes in HDF5 of any form, through a reader in Rust alone.
//! * `jpeg2000`, off by default: frames of DICOM in JPEG 2000, through a decoder in Rust alone; needs Rust 1.92.

mod advice;
mod amr;
mod animation;
mod atomic;
mod cells;
mod chosen;
mod claim;
mod colors;
mod decode;
mod detect;
mod dicom;
mod digest;
mod edit;
mod encoding;
mod environment_map;
mod error;
mod exr;
mod facts;
mod file_pattern;
mod float16;
mod framing;
mod given_place;
#[cfg(feature = "hdf5")]
mod hdf5;
mod header_text;
mod inside;
mod keys;
mod labels;
mod layout;
mod length_unit;
mod maker;
mod mapped;
mod memory_folder;
mod mesh;
mod metaimage;
mod mrc;
mod names;
mod narrow;
mod netcdf;
mod nifti;
mod notes;
mod npy;
mod nrrd;
mod opendx;
mod packed;
mod payload;
mod picture;
mod picture_read;
mod plain_hdf5;
mod png;
mod png_texts;
mod points;
mod polled;
mod pvm;
mod raw;
mod read;
mod record;
mod regular_file;
mod scalar;
mod scene;
mod screen_bytes;
mod slc;
mod slices;
mod source;
mod tiff;
mod toml_table;
mod transfer;
mod unfinished;
mod variables;
mod vdb;
mod voreen;
mod voxels;
mod vtk;
mod world;
mod write;
mod zarr;

pub use animation::{AnimationFormat, AnimationOptions, write_animation};
pub use atomic::write_bytes;
pub use cells::CellsOrPoints;
pub use digest::{file_hash, volume_hash};
pub use edit::{Reduction, Rounding, convert_grid, crop_grid, flip_grid, halve_grid, resample_grid};
pub use environment_map::{LoadedEnvironment, read_environment_map};
pub use error::{FieldError, FileError, FileErrorKind, WriteError};
pub use exr::write_exr;
pub use file_pattern::{files_of_pattern, numbered_names};
pub use framing::{default_angles, framing};
pub use given_place::GivenPlace;
pub use keys::{AnglePath, Angles, CameraPath, Interpolation, Key, KeyFile, PlacedPath, parse_keys, read_keys};
pub use labels::{LabelEntry, LoadedLabels, has_segments, parse_label_list, read_label_list, read_labels};
pub use maker::is_own_picture;
pub use memory_folder::MemoryFolder;
pub use mesh::{LoadedMesh, is_mesh, read_mesh};
pub use nifti::Transform;
pub use picture::write;
pub use picture_read::{MAX_PIXELS, Picture, PictureError, SampleKind, StoredPixels, read_picture};
pub use png::{Encode, PngDepth, PngOptions, encode_png, encode_rgba_png, write_png};
pub use points::{LoadedPoints, PointColumns, PointOptions, read_points};
pub use raw::RawDescription;
pub use read::{FileInfo, Loaded, ReadOptions, outline, read};
pub use record::{
    ErrorRecord, FileRecord, PictureFormat, PictureRecord, PixelsRecord, RecordError, RecordSection, SheetPicture,
    SheetRecord, VolumeRecord, encode_png_with_record, read_record, write_with_record,
};
pub use regular_file::read_text;
pub use scalar::{Endian, ScalarType};
pub use scene::{
    AlbedoEntry, AnnotationsSection, CameraSection, ColorEncoding, ColorWord, CompositingName, FaceName, FileName,
    FileSource, FinestWord, FinishEntry, GridDescription, ImageSection, LabelLook, LabelName, LabelSection,
    LabelsSection, LightEntry, LoadedScene, LoadedVolume, LookName, MeshSection, PhaseEntry, PointLightEntry,
    ProjectionName, RenderSection, ResampleSection, ResampleSize, ScatteringSection, SceneFile, SceneFileError,
    SceneMesh, ShadingSection, ShapeEntry, SurfaceEntry, TransferPoints, TransferRowSection, TransferSection,
    USUAL_FOV, VolumeSection, VolumeSource, commented_scene, load_scene, load_volume, outline_scene, parse_scene,
    preset_by_name, read_scene, resolve_scene, resolve_scene_around, scene_keys, scene_text, write_scene,
};
pub use screen_bytes::screen_rgba;
pub use transfer::{
    ColorMap, TRANSFER_EXTENSIONS, TransferFile, TransferSource, parse_color_maps, parse_transfer, read_color_maps,
    read_transfer, write_transfer,
};
pub use unfinished::remove_unfinished;
pub use world::{Space, orientation};
pub use write::{
    Levels, NrrdEncoding, NrrdOptions, NrrdValues, WriteVolumeOptions, WrittenVolume, volume_files, write_nrrd,
    write_volume,
};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
