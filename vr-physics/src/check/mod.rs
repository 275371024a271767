//! Checks that any [`Renderer`](vr_core::Renderer) can be put through, over random scenes, in one line each.
//!
//! ```
//! use vr_physics::{Reference, check};
//!
//! # fn main() -> Result<(), check::CheckFailure> {
//! let bound = |_: &vr_core::Scene, _: &vr_core::View| 1e-6;
//! let report = check::agrees_with_reference(&Reference::default(), bound, &check::Effort::cases(4))?;
//! println!("{report}");
//! # Ok(())
//! # }
//! ```
//!
//! | check | demand |
//! |---|---|
//! | [`agrees_with_reference`] | the distance from the canonical pixel is within the bound that the renderer documents |
//! | [`agrees_with_its_model`] | the same for the model that the renderer integrates |
//! | [`converges`] | the error falls with the step at the documented order |
//! | [`errors_fall`] | the error falls with the step, over every kind of hard scene |
//! | [`obeys_invariants`] | what must not change a picture does not, what must change it does so by the right amount |
//! | [`converges_as_documented`] | the same for every claim that the renderer documents |
//! | [`documents_what_can_be_set`] | every documented setting and claim can be configured, and no two are the same |
//! | [`survives_hard_cases`] | every [named case](crate::cases) gives a finite picture within its bound |
//! | [`survives_documented_cases`] | the same within the error that the renderer documents |
//!
//! [`renderer_suite!`](crate::renderer_suite) stamps all of them that need no bound of the caller's over a renderer.
//!
//! Scenes are drawn from a fixed seed: a run that passed passes again. A scene that fails is shrunk to a small one and stands in
//! the [`CheckFailure`] as a scene file, which `vr render --scene` draws. Scenes that a renderer refuses with
//! [`RenderError::Unsupported`](vr_core::RenderError::Unsupported) are counted, not failed; refusing all of them is a failure.
//!
//! The checks draw uniform grids, or the other volumes that [`Effort::on`] is told; [`agrees_with_reference_on`] and [`agrees_with_its_model`] take scenes
//! of the caller, such as [scattered points](strategies::tame_point_scene).
//!
//! [`strategies`] has the random scenes for the caller's own checks, [`transformed`] the scenes that must look the same, [`pictures`] small
//! scenes, their pictures and the errors of these, [`time_to_cancel`] a picture that is broken off, and [`faulty_marcher`] a renderer with mistakes, to check checks with.

mod agreement;
mod cancelling;
mod convergence;
mod documented;
mod drawn;
mod effort;
mod falling;
pub mod faulty_marcher;
mod fixed_layer;
mod hard_cases;
pub mod invariants;
mod outcome;
pub mod pictures;
pub mod strategies;
mod suite;
mod test_scene;
pub mod transformed;
mod transformed_volume;
mod updates;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod volume_tests;

pub use agreement::{agrees_with_its_model, agrees_with_reference, agrees_with_reference_on};
pub use cancelling::time_to_cancel;
pub use convergence::{Convergence, Refinement, converges};
pub use documented::{converges_as_documented, documents_what_can_be_set, survives_documented_cases};
pub use effort::{Effort, Volumes};
pub use falling::{CHANCE, Fall, Falling, KindFall, Ladder, errors_fall, survey_kind};
pub use fixed_layer::FixedLayer;
pub use hard_cases::{CaseOutcome, CaseResult, HardCases, survives_hard_cases};
pub use invariants::obeys_invariants;
pub use outcome::{CheckFailure, Report};
pub use test_scene::TestScene;
