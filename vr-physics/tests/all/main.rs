//! Tests of the crate from outside, in one program: it is linked once, and its tests run side by side.

mod amr;
mod brute;
mod cancelled;
mod cells;
mod closed_forms;
mod colored_grids;
mod double_double;
mod every_field;
mod gradient_rows;
mod independent;
mod labels;
mod point_means;
mod points;
mod rectilinear;
mod segments;
mod wrong_scenes;
