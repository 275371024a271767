//! OpenVDB (<https://www.openvdb.org>, versions 222 to 224 of the file, written since 2013): grids of floats in the usual tree of 32³, 16³ and
//! 8³ nodes, as dense voxels around all that is active.
//!
//! Own code: the crate at hand compiles C. The layout is that of OpenVDB's `io` and `tree` headers.

mod bytes;
mod dense;
mod file;
mod map;
mod tree;
mod values;

use std::path::Path;

use vr_core::{Calibration, Placement};

use crate::error::{FieldError, FileError, FileErrorKind, shown};
use crate::layout::{Axis, Layout, Role};
use crate::notes::Notes;
use crate::read::{Description, ReadOptions};
use crate::scalar::{Endian, ScalarType};
use crate::source::Decoded;
use crate::world::Space;

use dense::Box3;
use file::{Grid, VdbFile};

/// True if a file begins as OpenVDB's do.
pub(crate) fn is_vdb(head: &[u8]) -> bool {
    head.starts_with(&[0x20, 0x42, 0x44, 0x56, 0, 0, 0, 0])
}

/// Everything that the file says about the chosen grid, its tree included: the box of its voxels is not told before.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |kind: FileErrorKind| FileError::new(path, kind);
    let file = VdbFile::read(path).map_err(in_file)?;
    let mut notes = Notes::default();
    let grid = choose(&file.grids, options.array.as_deref(), &mut notes).map_err(|e| e.in_file(path))?;
    let tree = file.tree(grid).map_err(in_file)?;
    let inside = Box3::around(&tree, &grid.name).map_err(in_file)?;
    let axes = inside.dims().map(|size| Axis { size, role: Role::Space });
    let layout = Layout::new(path, &axes, options)?;
    let origin = tree.map.to_world(inside.low.map(f64::from));
    let placement = Placement::new(origin, tree.map.axes()).map_err(|e| FileError::new(path, e))?;
    notes
        .push("voxels that are not in the tree have the background's value; a border of one voxel is added".to_owned());
    let named = path.to_path_buf();
    let decode = Box::new(move |_: &mut Vec<String>| {
        let numbers = inside.fill(&tree).map_err(|kind| FileError::new(&named, kind))?;
        Ok(bytemuck::cast_slice::<f32, u8>(&numbers).to_vec())
    });
    let encoding = grid.compression.name();
    let files = vec![path.into()];
    let decoded = Decoded { decode, scalar: ScalarType::F32, endian: Endian::NATIVE, encoding, files };
    Ok(Description {
        format: "OpenVDB",
        header: path.into(),
        source: decoded.into(),
        layout,
        placement,
        placed_by: "transform",
        calibration: Calibration::default(),
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

/// The grid of a name, or the first of floats, which is said.
fn choose<'g>(grids: &'g [Grid], wanted: Option<&str>, notes: &mut Vec<String>) -> Result<&'g Grid, FieldError> {
    let list = || {
        let words: Vec<String> = grids.iter().map(|g| format!("{} ({})", shown(&g.name), shown(&g.kind))).collect();
        if words.is_empty() { "none".to_owned() } else { words.join(", ") }
    };
    if let Some(wanted) = wanted {
        let found = grids.iter().find(|g| g.name == wanted);
        let found = found.ok_or_else(|| FieldError::new("array", wanted, format!("the file has {}", list())))?;
        let allowed = "must be Tree_float_5_4_3: floats in the usual tree";
        return if found.is_read() { Ok(found) } else { Err(FieldError::new("grid type", &found.kind, allowed)) };
    }
    let mut read = grids.iter().filter(|g| g.is_read());
    let first = read.next().ok_or_else(|| FieldError {
        field: "grids".to_owned(),
        found: list(),
        allowed: "one must be of floats, Tree_float_5_4_3; points and vectors are not read".to_owned(),
    })?;
    if grids.len() > 1 {
        notes.push(format!("of {} grids {} is taken; the file has {}", grids.len(), shown(&first.name), list()));
    }
    Ok(first)
}

#[cfg(test)]
mod tests;
