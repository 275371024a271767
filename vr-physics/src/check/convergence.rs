//! Errors that fall with the step at the order that a renderer documents.

use std::panic::{AssertUnwindSafe, catch_unwind};

use proptest::strategy::{Strategy, ValueTree};
use vr_core::{Configurable, Control, Model, Options, RenderError, Renderer};

use super::drawn::{ReferencePixels, draw};
use super::effort::{Effort, Verdict};
use super::outcome::CheckFailure;
use super::strategies::smooth_scene;
use super::test_scene::TestScene;
use crate::Metrics;
use crate::order::fit_order_above;

const CHECK: &str = "converges at its documented order";
/// Smallest number of errors above the floor that an order is fitted to: four halvings.
const MIN_ERRORS: usize = 5;

/// Refinement of a renderer, and the order that it documents.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// Options held fixed: the instance in f64, early termination off, and so on.
    pub options: Options,
    /// The option that is halved.
    pub step: &'static str,
    /// Its first value.
    pub coarsest: f64,
    /// Number of halvings; at least 4.
    pub halvings: u32,
    /// The documented order.
    pub order: f64,
    /// Largest deviation of the fitted order, to either side: a first-order rule that is seen to converge at order 2 shows that
    /// the scenes do not tell the rules apart.
    pub tolerance: f64,
    /// Errors (RMSE) below this are not fitted: frames are f32, so that nothing converges below 10⁻⁷ or so.
    pub floor: f64,
}

impl Refinement {
    /// Four halvings of a step from 1 on, a tolerance of 0.25, a floor of 3·10⁻⁷.
    pub fn new(step: &'static str, order: f64) -> Self {
        Self { options: Options::new(), step, coarsest: 1.0, halvings: 4, order, tolerance: 0.25, floor: 3e-7 }
    }

    fn steps(&self) -> Vec<f64> {
        (0..=self.halvings).map(|k| self.coarsest / f64::from(1u32 << k)).collect()
    }
}

/// The measured convergence of a renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct Convergence {
    /// The fitted order; +∞ where errors reach the floor of rounding before an order can be fitted.
    pub order: f64,
    /// The values of the step's option.
    pub steps: Vec<f64>,
    /// The root mean square over the scenes of their RMSE, for each step.
    pub errors: Vec<f64>,
    /// Scenes that the renderer refused as unsupported.
    pub refused: u32,
}

impl std::fmt::Display for Convergence {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "order {:.2} (", self.order)?;
        for (i, (h, e)) in self.steps.iter().zip(&self.errors).enumerate() {
            write!(f, "{}step {h}: {e:.2e}", if i == 0 { "" } else { ", " })?;
        }
        f.write_str(")")
    }
}

/// The error against the canonical pixel falls at the documented order, over [smooth scenes](smooth_scene).
///
/// One order is fitted for all scenes together, by the root mean square of their errors: what converges most slowly decides, as it
/// should, and the erratic signs of single scenes even out. If it is wrong, the scene in the failure is one whose own order is
/// wrong by even more, if there is one.
///
/// # Errors
/// Another order than documented, errors that are too small to fit one and larger than rounding, an option that does not exist.
///
/// # Panics
/// Panics if there are fewer than 4 halvings.
pub fn converges(
    renderer: &impl Configurable,
    refinement: &Refinement,
    effort: &Effort,
) -> Result<Convergence, CheckFailure> {
    assert!(refinement.halvings >= 4, "fewer than four halvings say little about an order");
    let failure = |reason: String, scene| CheckFailure { check: CHECK, renderer: renderer.name(), reason, scene };
    let steps = refinement.steps();
    let at = |&h: &f64| {
        let configured = renderer.configure(&refinement.options.clone().with(refinement.step, h));
        configured.map(|renderer| Box::new(renderer) as Box<dyn Renderer>)
    };
    let refined: Result<Vec<_>, _> = steps.iter().map(at).collect();
    let refined = refined.map_err(|e| failure(e.to_string(), None))?;

    let mut runner = effort.runner();
    let (mut squares, mut judged, mut refused) = (vec![0.0; steps.len()], 0u32, 0);
    for _ in 0..effort.cases {
        let test = smooth_scene().new_tree(&mut runner).map_err(|e| failure(e.to_string(), None))?.current();
        // Nothing that a panic leaves half done is used afterwards.
        let errors = catch_unwind(AssertUnwindSafe(|| errors_of(&refined, &test, effort)));
        let Ok(errors) = errors else { return Err(failure("panics".to_owned(), Some(Box::new(test)))) };
        match errors {
            Ok(Some(errors)) => {
                judged += 1;
                squares.iter_mut().zip(errors).for_each(|(s, e)| *s += e * e);
            }
            Ok(None) | Err(RenderError::Unsupported { .. }) => refused += 1,
            Err(other) => {
                return Err(failure(format!("an error on a valid scene: {other}"), Some(Box::new(test))));
            }
        }
    }
    if judged == 0 {
        return Err(failure(format!("not one scene was judged: {refused} refused"), None));
    }
    let errors: Vec<f64> = squares.iter().map(|s| (s / f64::from(judged)).sqrt()).collect();
    let Some(order) = fit_order_above(refinement.floor, MIN_ERRORS, &steps, &errors) else {
        // Rounding ended the fall before an order can be seen: nothing is wrong.
        if errors.last().is_some_and(|&e| e <= refinement.floor) {
            return Ok(Convergence { order: f64::INFINITY, steps, errors, refused });
        }
        let reason = format!("errors {errors:.2?} at steps {steps:?}: five above {:.1e} are needed", refinement.floor);
        return Err(failure(reason, None));
    };
    let convergence = Convergence { order, steps, errors, refused };
    if (order - refinement.order).abs() <= refinement.tolerance {
        return Ok(convergence);
    }
    let scene = scene_of_wrong_order(renderer, &refined, refinement, effort);
    Err(failure(format!("{convergence}, documented {}", refinement.order), scene))
}

/// The RMSE at each step; `None` if the reference cannot solve the scene.
fn errors_of(
    refined: &[Box<dyn Renderer>],
    test: &TestScene,
    effort: &Effort,
) -> Result<Option<Vec<f64>>, RenderError> {
    // A renderer with a filter of its own draws that field, and is judged by it; any other model is towards the scene itself.
    let control = Control::default();
    let model = match refined.last() {
        Some(finest) => finest.prepare(&test.scene, &control)?.model(&test.view)?,
        None => return Ok(None),
    };
    let model = if matches!(model, Model::Filtered(_)) { model } else { Model::Canonical };
    let Some(expected) = ReferencePixels::solve(&effort.reference, test, &model)? else {
        return Ok(None);
    };
    let error = |r: &dyn Renderer| {
        let frame = draw(r, test, &control)?;
        Ok(Metrics::of(&expected.pixels, frame.pixels()).rmse)
    };
    refined.iter().map(|r| error(&**r)).collect::<Result<Vec<_>, _>>().map(Some)
}

/// A shrunk scene whose own order is off by twice the tolerance.
fn scene_of_wrong_order(
    renderer: &dyn Renderer,
    refined: &[Box<dyn Renderer>],
    refinement: &Refinement,
    effort: &Effort,
) -> Option<Box<TestScene>> {
    let steps = refinement.steps();
    let result = effort.over(CHECK, renderer, smooth_scene(), |test| {
        let Some(errors) = errors_of(refined, test, effort)? else { return Ok(Verdict::Skipped) };
        let Some(order) = fit_order_above(refinement.floor, MIN_ERRORS, &steps, &errors) else {
            return Ok(Verdict::Skipped);
        };
        let deviation = (order - refinement.order).abs();
        Ok(Verdict::within(deviation, 2.0 * refinement.tolerance, || format!("order {order:.2}, off by")))
    });
    result.err().and_then(|e| e.scene)
}
