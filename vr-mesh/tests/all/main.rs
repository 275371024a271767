//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod cancelled;
mod physics;
mod properties;
