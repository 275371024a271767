//! Volume rendering by slices through textures.

mod bricks;
mod classified;
mod compression;
mod draw;
mod finish;
mod fragments;
pub mod geometry;
mod hard_cases;
mod model;
mod occupancy;
mod options;
mod prepared;
mod projection;
mod renderer;
mod settings;
mod shading;
mod slices;
mod support;
mod tables;
mod tex_slice;
mod texture;
mod textures;

pub use tex_slice::{Blend, Format, Order, Proxy, TexSlice};
