//! The study of speed against error: what renderers cost, and how wrong they are, on the same scenes.
//!
//! Renderers are known through [`vr_core::StudiedRenderer`] alone: each [documents](vr_core::Documented) the settings that are worth a
//! try, its claims of convergence, and the errors that it allows itself on hard cases. A new one joins by being in the list.
//!
//! | what | where |
//! |---|---|
//! | suites of measurements, and what they found | [`suite`] |
//! | one subject: times in turns, errors against the reference, memory | [`study`] |
//! | reference pixels, kept on disk | [`reference`](mod@reference) |
//! | features of scenes by renderer | [`features`] |
//! | candidates that none beats, and the fastest within each error | [`front`] |
//! | orders of convergence, documented and measured | [`convergence`] |
//! | one ray, step by step beside the reference | [`ray`] |
//! | hard cases | [`stability`] |
//! | growth with threads, volumes, pictures | [`scaling`] |
//! | the cheapest setting within an error | [`choose`] |
//! | parts of long work that are done, on disk | [`journal`] |
//! | the figures that no later version may be worse than | [`baseline`] |
//! | pages, plots, tables (the feature of that name, on by default) | `report` |
//!
//! # Example
//! ```
//! use vr_study::reference::ReferenceCache;
//! use vr_study::{candidate::candidates, front::pareto_front, study::Study, subject::phantom_subject};
//! use vr_core::{Control, StudiedRenderer};
//! use vr_raycast::RayCaster;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let renderers: Vec<Box<dyn StudiedRenderer>> = vec![Box::new(RayCaster::default())];
//! let candidates = candidates(&renderers)?;
//! let cache = ReferenceCache::none();
//! let study = Study { candidates: &candidates, timing: None, subgrid: 4, own_subgrid: 2, cache: &cache, meter: None };
//! let result = study.measure(&phantom_subject("fog", 8, [16, 16])?, (&Control::default(), &|_| {}))?;
//!
//! // By samples instead of times: they are the same on every machine.
//! let pairs: Vec<(f64, f64)> = result.points.iter().map(|p| (p.counts["samples"] as f64, p.error.rmse)).collect();
//! assert!(!pareto_front(&pairs).is_empty());
//! # Ok(())
//! # }
//! ```

pub mod baseline;
pub mod candidate;
pub mod choose;
mod clock_reference;
pub mod convergence;
mod error;
pub mod error_bound;
pub mod error_colors;
pub mod features;
pub mod figures;
pub mod front;
pub mod journal;
pub mod machine;
pub mod memory;
mod order_scenes;
pub mod origin;
mod picture;
pub mod point;
pub mod ray;
pub mod reference;
mod refined_grid;
#[cfg(feature = "report")]
pub mod report;
pub mod scaling;
pub mod stability;
pub mod stated;
pub mod study;
pub mod subject;
pub mod suite;
pub mod timing;

pub use error::StudyError;

/// The examples on the front page, as tests.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct FrontPage;
