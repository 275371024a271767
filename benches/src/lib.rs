//! What the benches across renderers have in common. The study of speed against error will live here.
//!
//! The library sees renderers through [`vr_core::Renderer`] alone; the benches name them.

mod phantom_scene;

pub use phantom_scene::{PhantomScene, phantom_scenes};

/// The examples on the front page, as tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct FrontPage;
