//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod bricks;
mod cancelled;
mod capabilities;
mod checks;
mod colors;
mod depths;
mod every_setting;
mod gradients;
mod model;
mod nearest;
mod pictures;
mod random_scenes;
mod shading;
mod turntable;
mod whole_slices;
