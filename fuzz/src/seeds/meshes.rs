//! Surfaces of triangles.

use crate::small_meshes::{obj as obj_file, ply_binary, ply_text, stl_binary, stl_text};

pub fn stl() -> Vec<Vec<u8>> {
    vec![stl_text().into_bytes(), stl_binary(b"solid")]
}

pub fn obj() -> Vec<Vec<u8>> {
    let mixed = b"v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 -1//-1\n".to_vec();
    vec![obj_file().into_bytes(), mixed]
}

pub fn ply() -> Vec<Vec<u8>> {
    vec![ply_text().into_bytes(), ply_binary(false), ply_binary(true)]
}
