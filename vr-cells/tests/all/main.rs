//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod along_faces;
mod cancelled;
mod checks;
mod exact;
mod eye_inside;
mod march_steep;
mod memory;
mod meshes;
mod project_order;
