//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod amr;
mod cancelled;
mod checks;
mod closed_forms;
mod colors;
mod common;
mod convergence;
mod error_bound;
mod fields;
mod gradient_patches;
mod gradient_rows;
mod homogeneity;
mod idle_options;
mod leaping;
mod narrow_fields;
mod picked_fields;
mod point_means;
mod probe;
mod properties;
mod quality;
mod random_scenes;
mod rectilinear;
mod reference;
mod rules;
mod screen;
mod traversals;
