//! Scattered points in packets: each point near sixteen neighbouring places is looked at once for all of them.
//!
//! The plain engine finds the supports around each place in a tree, and adds them up in f64. Here the supports that reach into each cell of coarse
//! lattices, one for each size of supports, are listed ([`cells`]); the places of a packet lie in few cells, and each point of such a list is evaluated for sixteen places in f32 ([`field`]).
//! A place takes the points of its own cells alone, in the lists' order: no bit of it depends on which others are in the packet.
//!
//! A sum is marched in steps of one length. A mean begins and ends with a jump, and its steps are listed ray by ray ([`mean_steps`]), between the edges of vacuum that the same lists tell ([`covered`]). Where ramps of the
//! transfer function are of several orders of magnitude, tables are over places between its control points, and not over values ([`even_ramps`]). Operators that pick a value
//! take the same steps ([`pick_engine`]).

mod cells;
mod covered;
mod engine;
mod even_ramps;
mod field;
mod mean_steps;
mod pick_engine;
#[cfg(test)]
mod tests;

pub(crate) use engine::{PointEngine, PointFrame};
pub(crate) use pick_engine::{PointPickEngine, PointPickFrame};
