//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod cancelled;
mod checks;
mod colors;
mod depth;
mod filters;
mod gradients;
mod line_integrals;
mod model;
mod picked_values;
mod pictures;
mod point_means;
mod point_settings;
mod points;
mod random_scenes;
mod shaded_points;
mod sheet_middles;
