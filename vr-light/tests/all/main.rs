//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod cancelled;
mod hard_cases;
mod ladder;
mod paths;
mod quantities;
mod renderer;
mod single;
mod slab;
mod slabs_by_paths;
mod surfaces;
