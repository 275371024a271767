//! Grids with labels in packets.
//!
//! A field of labels is asked place by place by the plain engine: for the label, for the grid's value, and for what the transfer function of all codes says
//! there. Here the steps of each ray are listed ([`steps`]), each with the band that holds in it, so that sixteen samples of the grid are classified at once, each by
//! the table of its own band ([`bands`]); solid styles, which have one value, take their normals from the smoothed boundary of their region ([`field`]).

mod bands;
mod engine;
mod field;
mod steps;
#[cfg(test)]
mod tests;

pub(crate) use engine::{LabelEngine, LabelFrame};
