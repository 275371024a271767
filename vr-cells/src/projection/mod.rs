//! Projection of cells: each cell is drawn as its outline on the screen, cell by cell in the order in which rays meet them.

mod bins;
mod classic;
mod crossing;
mod fragments;
mod lanes_of;
mod line;
mod options;
mod outline;
mod prepared;
mod projector;
mod screen;
mod screen_mesh;
mod segment_table;
mod sorted;
mod stamp;
mod strong_components;
mod study;
mod surface_pairs;
mod tile;
mod tiling;
mod visibility;

pub use projector::{Attenuation, CellProjector};
