//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod amr;
mod cells;
mod fields;
mod memory;
mod resample;
