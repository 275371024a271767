//! Zarr arrays, versions 2 (2015) and 3 (ZEP 1, 2023), in local folders, and OME-Zarr (OME-NGFF 0.1 to 0.5): <https://ngff.openmicroscopy.org>.
//!
//! An array is a grid of chunks, each a file, and one file of JSON; a group of arrays may say that they are one image at several
//! resolutions. Of a series or of channels the chosen one is read: no other chunk is opened. A chunk that is not stored counts as the
//! fill value.

mod blosc;
mod chunks;
mod codec;
mod crc32c;
mod json;
mod listing;
mod metadata;
mod multiscales;
mod roles;
#[cfg(test)]
mod tests;

use std::path::Path;

use glam::{DMat3, DVec3};
use serde_json::Value;
use vr_core::{Calibration, Placement};

use crate::error::{FieldError, FileError, shown, shown_path};
use crate::inside::inside;
use crate::layout::{Axis, Layout, Role};
use crate::length_unit;
use crate::notes::{Assumption, Notes};
use crate::read::{Description, ReadOptions};
use crate::source::Decoded;
use crate::world::Space;

pub(crate) use blosc::decode as decode_blosc;

use chunks::Selection;
use json::Node;
use metadata::Array;
use multiscales::Multiscales;
use roles::NamedAxis;

/// Voxels of the finest resolution that is taken unless the caller asks for a finer one.
const MAX_VOXELS_UNASKED: usize = 1 << 27;

/// True if a folder is an array or a group.
pub(crate) fn is_zarr(folder: &Path) -> bool {
    [".zarray", ".zgroup", ".zattrs", "zarr.json"].iter().any(|name| folder.join(name).is_file())
}

/// Everything that the JSON says, and which of the chosen chunks are there.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let mut notes = Notes::default();
    match Node::read(path)? {
        Node::Array { file, json, attributes } => {
            if let Some(level) = options.level {
                return Err(FieldError::new("level", level, "one array has no levels to choose").in_file(path));
            }
            let array = Array::read(path, &file, &json).map_err(|e| e.in_file(&file))?;
            plain_array(path, array, &attributes, options, notes)
        }
        Node::Group { file, attributes } => {
            if let Some(found) = Multiscales::read(&attributes, &mut notes).map_err(|e| e.in_file(&file))? {
                return image(path, &found, options, notes);
            }
            // A group of one array is as good as the array.
            let (arrays, groups) = members(path)?;
            if let ([array], []) = (arrays.as_slice(), groups.as_slice()) {
                notes.push(format!("the group holds one array, {array}"));
                let inner = path.join(array);
                if let Node::Array { file, json, attributes } = Node::read(&inner)? {
                    let array = Array::read(&inner, &file, &json).map_err(|e| e.in_file(&file))?;
                    return plain_array(path, array, &attributes, options, notes);
                }
            }
            Err(choose(path, &arrays, &groups))
        }
    }
}

/// Arrays and groups directly in a group, by name.
fn members(path: &Path) -> Result<(Vec<String>, Vec<String>), FileError> {
    /// Beyond any list that is worth printing.
    const MAX_MEMBERS: usize = 10_000;
    let io = |e| FileError::new(path, e);
    let (mut arrays, mut groups) = (Vec::new(), Vec::new());
    for entry in path.read_dir().map_err(io)?.take(MAX_MEMBERS) {
        let entry = entry.map_err(io)?;
        let (name, inner) = (entry.file_name().to_string_lossy().into_owned(), entry.path());
        if !is_zarr(&inner) {
            continue;
        }
        // What is damaged there is not asked for.
        match Node::read(&inner) {
            Ok(Node::Array { .. }) => arrays.push(name),
            Ok(Node::Group { .. }) => groups.push(name),
            Err(_) => {}
        }
    }
    arrays.sort();
    groups.sort();
    Ok((arrays, groups))
}

fn choose(path: &Path, arrays: &[String], groups: &[String]) -> FileError {
    let all: Vec<String> = arrays.iter().cloned().chain(groups.iter().map(|g| format!("{g}/"))).collect();
    let Some(first) = arrays.first().or(groups.first()) else {
        return FieldError::new("Zarr group", "no array", "must hold one").in_file(path);
    };
    // The list belongs to the remedy, where it is not cut off.
    const MAX_NAMES: usize = 20;
    let more = if all.len() > MAX_NAMES { ", …" } else { "" };
    let names = all.iter().take(MAX_NAMES).map(|n| shown(n)).collect::<Vec<_>>().join(", ");
    let allowed = format!("name one of {names}{more}, as in {}", shown_path(&path.join(first)));
    let found = format!("a group of {} array(s) and {} group(s)", arrays.len(), groups.len());
    FieldError::new("Zarr group", found, allowed).in_file(path)
}

/// An array on its own: the order of its axes is named, or z, y, x.
fn plain_array(
    path: &Path,
    array: Array,
    attributes: &Value,
    options: &ReadOptions,
    mut notes: Notes,
) -> Result<Description, FileError> {
    let names = array.names.clone().or_else(|| json::strings(attributes.get("_ARRAY_DIMENSIONS")?));
    let axes = roles::of_array(array.shape.len(), names.as_deref(), &mut notes).map_err(|e| e.in_file(&array.file))?;
    notes.assume(Assumption::Spacing, "Zarr arrays state no spacing: 1, 1, 1 is assumed");
    let n = axes.len();
    let placed = Placed { scale: vec![1.0; n], translation: vec![0.0; n], by: "assumed", format: "Zarr" };
    describe_array(path, array, &axes, placed, options, notes)
}

/// One resolution of an image.
fn image(path: &Path, found: &Multiscales, options: &ReadOptions, mut notes: Notes) -> Result<Description, FileError> {
    let mut levels = Vec::new();
    for level in &found.levels {
        let folder = inside(path, "multiscales path", &level.path).map_err(|e| e.in_file(path))?;
        let Node::Array { file, json, .. } = Node::read(&folder)? else {
            return Err(FieldError::new("multiscales", &level.path, "must be an array").in_file(path));
        };
        let array = Array::read(&folder, &file, &json).map_err(|e| e.in_file(&file))?;
        if array.shape.len() != found.axes.len() {
            let allowed = format!("must be {}, the axes of the image", found.axes.len());
            return Err(FieldError::new("shape", format_args!("{} axes", array.shape.len()), allowed).in_file(&file));
        }
        levels.push(array);
    }
    // Voxels of one frame and component.
    let voxels = |array: &Array| {
        let space = array.shape.iter().zip(&found.axes).filter(|(_, a)| a.role == Role::Space);
        space.fold(1usize, |n, (&size, _)| n.saturating_mul(size))
    };
    let count = levels.len();
    let unasked = || levels.iter().position(|a| voxels(a) <= MAX_VOXELS_UNASKED).unwrap_or(count.saturating_sub(1));
    let chosen = options.level.unwrap_or_else(unasked);
    if chosen >= count {
        let allowed = format!("the image has {count} level(s), 0 to {}", count.saturating_sub(1));
        return Err(FieldError::new("level", chosen, allowed).in_file(path));
    }
    if count > 1 {
        let shown = |a: &Array| {
            let space = a.shape.iter().zip(&found.axes).rev().filter(|(_, axis)| axis.role == Role::Space);
            space.map(|(n, _)| n.to_string()).collect::<Vec<_>>().join("×")
        };
        let list = levels.iter().enumerate().map(|(i, a)| format!("{i}: {}", shown(a))).collect::<Vec<_>>().join(", ");
        let why = match options.level {
            Some(_) => "asked for".to_owned(),
            None if voxels(&levels[chosen]) > MAX_VOXELS_UNASKED => "the last; none is small".to_owned(),
            None => format!("the first of at most {MAX_VOXELS_UNASKED} voxels"),
        };
        notes.push(format!("level {chosen} of {count} is read ({why}); levels are {list}"));
    }
    let level = &found.levels[chosen];
    if !level.is_placed {
        notes.assume(Assumption::Spacing, "OME-Zarr without coordinateTransformations: spacing 1, 1, 1 is assumed");
    }
    let by = if level.is_placed { "coordinateTransformations" } else { "assumed" };
    let placed = Placed { scale: level.scale.clone(), translation: level.translation.clone(), by, format: "OME-Zarr" };
    let array = levels.swap_remove(chosen);
    describe_array(path, array, &found.axes, placed, options, notes)
}

/// Placement of the voxels, for each axis of the array.
struct Placed {
    scale: Vec<f64>,
    translation: Vec<f64>,
    by: &'static str,
    format: &'static str,
}

fn describe_array(
    path: &Path,
    array: Array,
    axes: &[NamedAxis],
    placed: Placed,
    options: &ReadOptions,
    mut notes: Notes,
) -> Result<Description, FileError> {
    // The last axis of an array runs fastest.
    let fastest_first: Vec<Axis> =
        array.shape.iter().zip(axes).rev().map(|(&size, axis)| Axis { size, role: axis.role }).collect();
    let layout = Layout::new(path, &fastest_first, options)?;
    let space: Vec<usize> = (0..axes.len()).rev().filter(|&a| axes[a].role == Role::Space).collect();
    let Ok(space) = <[usize; 3]>::try_from(space) else {
        return Err(FieldError::new("axes", axes.len(), "three must be of space").in_file(path));
    };
    let names = space.map(|a| axes[a].unit.as_deref());
    let (units, factors) = match length_unit::common(names) {
        Some((unit, factors)) => (Some(unit), factors),
        None => {
            if names.iter().any(Option::is_some) {
                notes.push("the units of the axes have no common one: they are left out".into());
            }
            (None, [1.0; 3])
        }
    };
    // An axis of the array is the world's axis of its name, in whatever order they are stored.
    let toward = space.map(|a| roles::world_axis(&axes[a].name));
    let is_xyz = (0..3).all(|w| toward.contains(&Some(w)));
    let mut steps = [DVec3::ZERO; 3];
    let mut origin = DVec3::ZERO;
    for i in 0..3 {
        let world = if is_xyz { toward[i].unwrap_or(i) } else { i };
        steps[i][world] = placed.scale[space[i]] * factors[i];
        origin[world] = placed.translation[space[i]] * factors[i];
    }
    let placement =
        Placement::new(origin, DMat3::from_cols(steps[0], steps[1], steps[2])).map_err(|e| FileError::new(path, e))?;

    let (scalar, endian, encoding) = (array.scalar, array.endian, array.encoding());
    let header = array.file.clone();
    let selection = Selection::new(array, space, &layout);
    let stored = selection.stored()?;
    let files = stored.files.clone();
    let decoded =
        Decoded { decode: Box::new(move |notes| selection.decode(&stored, notes)), scalar, endian, encoding, files };
    Ok(Description {
        format: placed.format,
        header,
        source: decoded.into(),
        layout: layout.dense(),
        placement,
        placed_by: placed.by,
        calibration: Calibration::default(),
        space: Space::Own,
        units,
        scan: None,
        notes,
    })
}
