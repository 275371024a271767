//! Labels beside a volume: a mask or segmentation says for every place what it belongs to, and each label is drawn in a style of its own.
//!
//! A [`LabelMap`] holds the labels, on a lattice that need not be the volume's: the label of a place is that of the nearest voxel, and labels
//! are never interpolated. [`LabelledGrid`] is the [`Field`](crate::Field) of a grid and its labels. Its values are codes: the grid's own value
//! in a band for each style, so that one transfer function ([`LabelledGrid::transfer`]) says what every style looks like, and whatever
//! draws a field draws labels.

mod boundary;
mod error;
mod label_counts;
mod label_map;
mod labelled_grid;
mod lattice_ray;
mod line;
mod style;

pub use error::LabelError;
pub use label_counts::LabelCounts;
pub use label_map::LabelMap;
pub use labelled_grid::{LabelCode, LabelledGrid};
pub use style::LabelStyle;
