//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod both_errors;
mod cancelled;
mod checks;
mod colors;
mod depths;
mod first;
mod gradients;
mod nearest;
mod random_scenes;
mod shading;
mod surfaces;
mod turntable;
