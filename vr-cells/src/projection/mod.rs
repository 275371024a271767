//! Projection of cells: each cell is drawn as its outline on the screen, cell by cell in the order in which rays meet them.

mod cell_samples;
mod classic;
mod line;
mod options;
mod outline;
mod outline_lanes;
mod prepared;
mod projector;
mod samples;
mod screen_mesh;
mod segment_light;
mod segment_table;
mod severe_segments;
mod sorted;
mod steps;
mod strong_components;
mod study;
mod surface_pairs;
mod tile;
mod tile_rays;
mod tiling;
mod visibility;

pub use projector::{Attenuation, CellProjector};
