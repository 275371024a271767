//! Long tests across crates, in one program: it is linked once, and its tests run side by side.

mod cases;
mod mesh;
mod orders;
