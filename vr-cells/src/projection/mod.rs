//! Projection of cells: each cell is drawn as its outline on the screen, cell by cell in the order in which rays meet them.

mod bins;
mod crossing;
mod fragments;
mod options;
mod prepared;
mod projector;
mod screen;
mod study;

pub use projector::{Attenuation, CellProjector};
