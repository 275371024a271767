//! Sixteen rays at once: light through meshes in front of the eye, without shading.
//!
//! The way from cell to cell is the one of [`crate::walk`], in `f32` and on vectors: a lane is a ray, and takes the next ray of its tile when it is
//! done. The walk only notes where each ray passes a face and the value there. What lies between is cut at the points of the transfer function
//! into stretches, on which everything is linear; their light does not depend on what lies before, so that sixteen of any rays are integrated at
//! once; and is put together ray by ray. Everything that is rare (walls, logarithms that bend, rays that get stuck) is left to the plain code.

mod entries;
mod integral;
mod links;
mod march;
mod projected;
mod segments;
mod stretches;
#[cfg(test)]
mod tests;
mod tiles;

pub(crate) use links::Links;
pub(crate) use projected::Projected;
pub(crate) use segments::Segments;
pub(crate) use tiles::Packets;
