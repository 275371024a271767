//! Keys of `[volume]`, by the kind of source.

use vr_core::phantom;

use super::Absent::{Example, Nothing, Usual};
use super::{KeyHelp, key};
use crate::scene::VolumeSource;

/// The keys that mean something to a source; to a file, where there is none.
pub(super) fn volume(source: Option<&VolumeSource>) -> Vec<KeyHelp> {
    let filter = key(
        "filter",
        Usual("\"trilinear\""),
        "Filter that makes a continuous field of the voxels: nearest, trilinear, bspline, catmull-rom or gaussian.",
    );
    let mut keys = match source {
        None | Some(VolumeSource::File(_)) => file_keys(),
        Some(VolumeSource::Phantom { .. }) => vec![
            key("phantom", Nothing, format!("Volume made by a formula: {}.", phantom::NAMES.join(", "))),
            key("size", Usual("64"), "Voxels along each axis, 2 to 2048."),
        ],
        Some(VolumeSource::PhantomPoints { .. }) => vec![
            key("phantom", Nothing, format!("Points made by a formula: {}.", phantom::POINT_NAMES.join(" or "))),
            key("count", Usual("10000"), "Number of points, 1 to 100000000."),
        ],
        Some(VolumeSource::Grid { .. }) => {
            let mut keys =
                vec![key("data", Nothing, "Voxels, x fastest, up to 64^3 of them; nan where one is missing.")];
            keys.extend(grid_keys("", "\"f32\"", "u8, i8, u16, i16 or f32"));
            keys
        }
        Some(VolumeSource::Points { .. }) => {
            let mut keys =
                vec![key("points", Nothing, "Rows of x, y, z, radius, weight and value, up to 4096 of them.")];
            keys.extend([kernel(""), mixing("")]);
            keys.push(key(
                "point_colors",
                Example("[[1.0, 0.5, 0.0]]"),
                "Red, green and blue of each point in linear light, by which colours of the transfer function are multiplied; absent: none.",
            ));
            keys
        }
    };
    if !matches!(source, Some(VolumeSource::PhantomPoints { .. } | VolumeSource::Points { .. })) {
        keys.push(filter);
    }
    if matches!(
        source,
        None | Some(VolumeSource::File(_) | VolumeSource::PhantomPoints { .. } | VolumeSource::Points { .. })
    ) {
        keys.extend(resample_keys());
    }
    keys
}

fn resample_keys() -> [KeyHelp; 3] {
    [
        key(
            "resample",
            Example("[128, 128, 128]"),
            "Meshes, points and other volumes that are no grids: size of a grid to make of them, in voxels, as a spacing, or \"finest\".",
        ),
        key(
            "resample_filter",
            Usual("\"point\""),
            "Resampling: value of a voxel, point (that of the volume there) or box (the mean around it).",
        ),
        key("conserve", Usual("false"), "Resampling: true corrects the voxels so that the integral stays what it was."),
    ]
}

fn file_keys() -> Vec<KeyHelp> {
    let mut keys = vec![
        key(
            "path",
            Example("\"scan.nii.gz\""),
            "Volume file or folder, relative to the folder of this file: NRRD, NIfTI, MetaImage, DICOM, VTK, TIFF, Zarr, raw and more; \
             or scattered points.",
        ),
        key("frame", Usual("0"), "Number of the frame of a series of volumes, from 0."),
        key("component", Usual("0"), "Number of the component where each voxel has several, from 0."),
        key(
            "as",
            Example("\"points\""),
            "Files of cells with vertices: cells, or points for the vertices alone; absent: cells where they have three dimensions and values.",
        ),
        key(
            "series",
            Example("3"),
            "DICOM: the series, by its number or its UID in quotes; needed where there are several.",
        ),
        key(
            "level",
            Example("0"),
            "OME-Zarr: number of the resolution, 0 the finest; absent: the finest of at most 2^27 voxels.",
        ),
        key("transform", Usual("\"auto\""), "NIfTI: transform that places the volume: auto, sform, qform or spacing."),
        key(
            "value",
            Example("\"density\""),
            "VTK images, cells: name of the array. Points: column or array of the values; \"1\" for a value of 1 at every point.",
        ),
    ];
    keys.extend(grid_keys("Raw files: ", "\"u8\"", "u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64"));
    keys.extend([
        key("endian", Usual("\"little\""), "Raw files: byte order, little or big."),
        key("skip", Usual("0"), "Raw files: bytes before the first voxel."),
        kernel("Points from files: "),
        key(
            "radius",
            Example("1.5"),
            "Points from files: reach of all kernels in world units, above 0; absent: what the file says, or the distance of neighbours.",
        ),
        key("radius_scale", Usual("1.0"), "Points from files: factor on every radius, above 0; more than 1 smoothes."),
        mixing("Points from files: "),
        key(
            "color_value",
            Example("\"temperature\""),
            "Points from files: column or array that points have their colours of, mixed by their weighted mean, by which colours of the transfer \
             function are multiplied; absent: none.",
        ),
        key("color_map", Usual("\"viridis\""), "Points from files: colours of that column, viridis, inferno or cool-warm."),
        key(
            "color_range",
            Example("[0.0, 1e4]"),
            "Points from files: numbers of the first and of the last of these colours; absent: the smallest and the largest.",
        ),
        key(
            "columns",
            Example("{ radius = \"h\", mass = \"m\" }"),
            "Points from files: names of the columns position (three of them, of text files), radius, smoothing_length, mass, density \
             and weight; absent: the usual names.",
        ),
    ]);
    keys
}

/// Keys of a grid without a header, for the kind of source that `of` names.
fn grid_keys(of: &str, scalar: &'static str, types: &str) -> Vec<KeyHelp> {
    let instead = if of.is_empty() { "" } else { "; of files with a header, in place of what they say" };
    vec![
        key("dims", Example("[256, 256, 128]"), format!("{of}Voxels along x, y and z.")),
        key("type", Example(scalar), format!("{of}Type of the voxels: {types}.")),
        key(
            "spacing",
            Usual("[1.0, 1.0, 1.0]"),
            format!("World units from voxel to voxel along x, y and z, above 0{instead}."),
        ),
        key("origin", Usual("[0.0, 0.0, 0.0]"), format!("World position of the first voxel{instead}.")),
        key(
            "direction",
            Usual("[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"),
            format!("{of}World directions of the x, y and z axis of the grid."),
        ),
        key("slope", Usual("1.0"), format!("{of}Calibration: value = slope * stored + intercept.")),
        key("intercept", Usual("0.0"), format!("{of}Calibration: value of a stored 0.")),
    ]
}

fn mixing(of: &str) -> KeyHelp {
    let meaning = format!("{of}Field where kernels overlap: sum, or mean (weighted by the kernels, as Shepard's).");
    key("mixing", Usual("\"sum\""), meaning)
}

fn kernel(of: &str) -> KeyHelp {
    let meaning = format!("{of}Kernel that spreads each point: cubic-spline, gaussian or cone.");
    key("kernel", Usual("\"cubic-spline\""), meaning)
}
