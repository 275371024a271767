//! Surfaces in: STL, OBJ and PLY.

mod obj;
mod ply;
mod stl;

use std::fmt::Display;
use std::io::Read;
use std::path::Path;

use vr_core::TriangleMesh;

use crate::error::{FieldError, FileError, FileErrorKind};
use crate::regular_file;

/// The formats that are read, as messages list them.
const SUPPORTED: &str = "STL (text and binary), OBJ and PLY (text and binary)";

/// A surface from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedMesh {
    /// The surface, where the file puts it: nothing is turned or scaled.
    pub mesh: TriangleMesh,
    /// `STL (text)`, `STL (binary)`, `OBJ`, `PLY (text)` or `PLY (binary)`.
    pub format: &'static str,
    /// Notes on everything left out or changed on the way, one line each.
    pub notes: Vec<String>,
}

/// Longest file of a surface, which is taken into memory as a whole.
const MAX_BYTES: u64 = 1 << 32;

/// Reads a surface: STL, OBJ or PLY, told by the content first and by the name second.
///
/// Positions are those of the file, as f64. Colours at the vertices (PLY, and OBJ with six numbers a vertex) are taken as sRGB and
/// made linear; normals at the vertices (PLY, OBJ) are kept; those of STL's facets are not looked at, for the triangles say the same and
/// are more often right. Polygons are cut into fans of triangles. Materials, textures, lines and points are left out.
///
/// # Errors
/// A [`FileError`] that names the file, the place, what was found and what is allowed.
pub fn read_mesh(path: impl AsRef<Path>) -> Result<LoadedMesh, FileError> {
    let path = path.as_ref();
    let bytes = regular_file::read(path, MAX_BYTES).map_err(|e| FileError::new(path, e))?;
    let unrecognised = || FileError::new(path, FileErrorKind::Unrecognised { supported: SUPPORTED });
    let read = match detect(path, &bytes).ok_or_else(unrecognised)? {
        Format::Ply => ply::read(&bytes),
        Format::Obj => obj::read(&String::from_utf8_lossy(&bytes)),
        Format::Stl if stl::is_text(&bytes) => stl::read_text(&String::from_utf8_lossy(&bytes)),
        Format::Stl => stl::read_binary(&bytes),
    };
    read.map_err(|kind| FileError::new(path, kind))
}

/// True if a file is a mesh rather than a volume, by its first bytes and its name; false if it cannot be read.
pub fn is_mesh(path: impl AsRef<Path>) -> bool {
    let mut head = Vec::new();
    let read = regular_file::open(path.as_ref()).and_then(|file| file.take(16).read_to_end(&mut head));
    read.is_ok() && detect(path.as_ref(), &head).is_some()
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Format {
    Stl,
    Obj,
    Ply,
}

/// The format of a file of which the first bytes are given. Of the three, only PLY begins with a word of its own.
fn detect(path: &Path, head: &[u8]) -> Option<Format> {
    if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        return Some(Format::Ply);
    }
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "stl" => Some(Format::Stl),
        "obj" => Some(Format::Obj),
        "ply" => Some(Format::Ply),
        _ => None,
    }
}

/// The triangles of a polygon: a fan around its first corner.
fn fan<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 3]> {
    corners.iter().skip(1).zip(corners.iter().skip(2)).map(|(&b, &c)| [corners[0], b, c])
}

/// A complaint about a line, counted from 0.
fn in_line(line: usize, found: impl Display, allowed: impl Into<String>) -> FieldError {
    FieldError::new(format!("line {}", line + 1), found, allowed)
}

/// Note on the polygons that are no triangles, if there are any.
fn note_of_fans(polygons: usize) -> Vec<String> {
    let note = || format!("{polygons} polygons are cut into fans of triangles: right where they are flat and convex");
    if polygons > 0 { vec![note()] } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_comes_before_the_name() {
        assert_eq!(detect(Path::new("x.stl"), b"ply\nformat"), Some(Format::Ply));
        assert_eq!(detect(Path::new("x.STL"), b"plywood"), Some(Format::Stl));
        assert_eq!(detect(Path::new("x.Obj"), b""), Some(Format::Obj));
        assert_eq!(detect(Path::new("x.raw"), b"solid"), None);
        assert_eq!(detect(Path::new("stl"), b""), None);
    }

    #[test]
    fn polygons_are_fans() {
        assert_eq!(fan(&[7, 8, 9, 4]).collect::<Vec<_>>(), [[7, 8, 9], [7, 9, 4]]);
        assert_eq!(fan::<u32>(&[1, 2]).count() + fan::<u32>(&[]).count(), 0);
    }
}
