//! Volume rendering by slices through textures.

pub mod geometry;
