//! Convergence: the order with which errors fall as a step, a grid or pixels are refined, beside the documented one.
//!
//! After Etiene, Jönsson, Ropinski, Scheidegger, Comba, Nonato, Kirby, Ynnerman and Silva 2014, "Verifying volume rendering using
//! discretization error analysis": refine one thing at a time, and look at the slope of the error, not at the picture.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use vr_core::cancel::catch_stopped;
use vr_core::phantom::Phantom;
use vr_core::{Control, ConvergenceClaim, Frame, Model, RenderError, Scene, StudiedRenderer, View};
use vr_physics::fit_order_above;
use vr_physics::metrics::subgrid;

use crate::error::StudyError;
use crate::order_scenes::{Waves, adaptive, inner_view, jumping, smooth, uneven, view};
use crate::reference::{ReferenceCache, ReferencePixels};
use crate::refined_grid::refined;

/// Quantity that is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Refined {
    /// The step, on a smooth field under a continuous transfer function.
    Step,
    /// The step, where the transfer function jumps.
    StepAtJumps,
    /// The step on an adaptive mesh, in cells of each level.
    StepOnLevels,
    /// The step on a rectilinear grid, in cells of each width.
    StepOnUnevenAxes,
    /// The grid of a smooth field, the step being held fixed in voxels.
    Grid,
    /// The pixels.
    Pixels,
}

impl Refined {
    /// All of them, in the order of a report.
    #[cfg(feature = "report")]
    pub(crate) const ALL: [Self; 6] =
        [Self::Step, Self::StepAtJumps, Self::StepOnLevels, Self::StepOnUnevenAxes, Self::Grid, Self::Pixels];

    /// Returns the name in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::StepAtJumps => "step, at jumps",
            Self::StepOnLevels => "step, adaptive mesh",
            Self::StepOnUnevenAxes => "step, uneven axes",
            Self::Grid => "grid",
            Self::Pixels => "pixels",
        }
    }

    /// Returns the largest difference of a fitted order from the documented one: where something jumps, errors depend on where samples happen to lie.
    pub fn tolerance(self) -> f64 {
        match self {
            Self::StepAtJumps => 0.4,
            _ => 0.15,
        }
    }
}

/// Measured convergence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// The renderer.
    pub renderer: String,
    /// The claim that is tested.
    pub claim: String,
    /// The quantity that was refined.
    pub refined: Refined,
    /// The scene.
    pub scene: String,
    /// The documented order.
    pub expected: f64,
    /// Largest difference of the measured order from it.
    pub tolerance: f64,
    /// True if a higher order is as good: on data that were not made for the test, errors of either sign can cancel.
    pub at_least: bool,
    /// The fitted order; `None` where too few errors lie above the floor.
    pub measured: Option<f64>,
    /// Sizes of what was refined, descending: step in voxels, spacing, or pixel.
    pub sizes: Vec<f64>,
    /// RMSE at each size.
    pub errors: Vec<f64>,
    /// RMSE below which rounding decides.
    pub floor: f64,
    /// Refusal or failure, if there is no picture to judge.
    pub trouble: Option<String>,
}

/// Result of a measured convergence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The order is the documented one.
    Holds,
    /// All but the first errors are rounding: nothing is wrong, and no order can be seen.
    Exact,
    /// The order is another one, errors do not fall, or there is no picture.
    Fails,
    /// The renderer does not draw such scenes, or claims nothing about them.
    Refused,
    /// Every picture is exact to the last bit: there is nothing to see.
    Empty,
}

impl Outcome {
    /// True if no documented order was contradicted, and errors were seen to fall.
    pub fn is_held(self) -> bool {
        matches!(self, Self::Holds | Self::Exact)
    }

    /// Returns the name in tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Holds => "held",
            Self::Exact => "exact to rounding",
            Self::Fails => "FAILS",
            Self::Refused => "refused",
            Self::Empty => "nothing to see",
        }
    }
}

const REFUSED: &str = "refused: ";
/// Smallest number of errors that an order is fitted to.
const MIN_ERRORS: usize = 3;

impl Convergence {
    /// Returns the result.
    pub fn outcome(&self) -> Outcome {
        match (&self.trouble, self.measured) {
            (Some(trouble), _) if trouble.starts_with(REFUSED) => Outcome::Refused,
            (Some(_), _) => Outcome::Fails,
            (None, Some(order)) if (order - self.expected).abs() <= self.tolerance => Outcome::Holds,
            (None, Some(order)) if order > self.expected && self.at_least => Outcome::Holds,
            (None, Some(_)) if self.is_about_rounding() => Outcome::Exact,
            (None, Some(_)) => Outcome::Fails,
            (None, None) if self.errors.iter().all(|&e| e == 0.0) => Outcome::Empty,
            // Rounding may end the fall, but the last error has to be there.
            (None, None) if self.errors.last().is_some_and(|&e| e <= self.floor) => Outcome::Exact,
            (None, None) => Outcome::Fails,
        }
    }

    /// True if all errors lie within a digit of the floor, and fall below it: too few of them are of the step to tell its order.
    fn is_about_rounding(&self) -> bool {
        let largest = self.errors.iter().fold(0.0, |a: f64, &e| a.max(e));
        largest <= 10.0 * self.floor && self.errors.last().is_some_and(|&e| e <= self.floor)
    }
}

/// Test of the orders of convergence that renderers document.
pub struct OrderCheck<'a> {
    /// Reference pixels that were solved before.
    pub cache: &'a ReferenceCache,
    /// Cancellation and threads.
    pub control: &'a Control,
}

/// Number of pixels along each side where the step or the grid is refined.
const SIDE: u32 = 24;
/// Number of pixels along each side on a scene of the caller, where errors are more erratic.
const OWN_SIDE: u32 = 32;
/// First step on a scene of the caller, as a part of the coarsest: fields are steep there.
const OWN_COARSEST: f64 = 0.5;
/// Number of voxels along each side of the scenes that are made for the test.
const SAMPLES: usize = 17;
/// Number of steps, each the one before divided by the square root of 2.
const STEPS: i32 = 7;

impl OrderCheck<'_> {
    /// Tests all claims of a renderer on scenes that are made for the test.
    ///
    /// # Errors
    /// Cancellation; faults of a renderer stand in the results.
    pub fn check_claims(
        &self,
        renderer: &dyn StudiedRenderer,
        progress: &dyn Fn(f64),
    ) -> Result<Vec<Convergence>, StudyError> {
        let claims = renderer.convergence();
        let mut results = Vec::new();
        for (i, claim) in claims.iter().enumerate() {
            results.push(self.step(renderer, claim, Refined::Step, ("waves", &smooth(SAMPLES)))?);
            results.push(self.step(renderer, claim, Refined::StepAtJumps, ("waves, jumps", &jumping(SAMPLES)))?);
            results.extend(self.other_lattices(renderer, claim)?);
            results.push(self.grid(renderer, claim)?);
            if i == 0 {
                results.push(self.pixels(renderer, claim)?);
            }
            progress((i + 1) as f64 / claims.len() as f64);
        }
        Ok(results)
    }

    /// Refines the step on a scene of the caller. Fields change much from voxel to voxel there, and have kinks at cell faces: no order above 2 is
    /// expected, fitted ones scatter by as much as at jumps, and higher ones are as good.
    ///
    /// # Errors
    /// Cancellation.
    pub fn step_on(
        &self,
        renderer: &dyn StudiedRenderer,
        (name, scene, view): (&str, &Scene, &View),
        progress: &dyn Fn(f64),
    ) -> Result<Vec<Convergence>, StudyError> {
        let refined = if scene.transfer.has_jumps() { Refined::StepAtJumps } else { Refined::Step };
        let view = View { size: [OWN_SIDE, OWN_SIDE], ..view.clone() };
        let claims = renderer.convergence();
        let mut results = Vec::new();
        for (i, claim) in claims.iter().enumerate() {
            let mut blank = on_own_data(blank(renderer, claim, refined, name));
            if !is_claimed(scene) {
                blank.trouble = Some(format!("{REFUSED}orders are documented of unshaded light alone"));
                results.push(blank);
                continue;
            }
            let claim = ConvergenceClaim { coarsest: OWN_COARSEST * claim.coarsest, ..claim.clone() };
            results.push(self.step_in(blank, (renderer, &claim), scene, &view)?);
            progress((i + 1) as f64 / claims.len() as f64);
        }
        Ok(results)
    }

    /// Refines the grid of a volume of the caller: cells are cut in two, three and four, which leaves a trilinear field as it is; the step, fixed
    /// in voxels, becomes shorter, and errors fall at the order of the step. `None` where the field is another, has missing voxels, or is shaded.
    ///
    /// # Errors
    /// Cancellation.
    pub fn grid_of(
        &self,
        renderer: &dyn StudiedRenderer,
        (name, scene): (&str, &Scene),
    ) -> Result<Option<Convergence>, StudyError> {
        let Some(claim) = renderer.convergence().into_iter().next().filter(|_| is_claimed(scene)) else {
            return Ok(None);
        };
        let mut blank = on_own_data(blank(renderer, &claim, Refined::Grid, name));
        // What falls is the error of the step.
        let orders = claim.orders;
        blank.expected = if scene.transfer.has_jumps() { orders.jumps } else { orders.smooth }.min(2.0);
        let mut sizes = Vec::new();
        let mut pictures = Vec::new();
        for parts in 1..=4usize {
            let Some(scene) = refined(scene, parts) else { return Ok(None) };
            sizes.push(1.0 / parts as f64);
            pictures.push((scene, OWN_COARSEST * claim.coarsest));
        }
        let first = &pictures[0].0;
        let view = view(first, OWN_SIDE);
        let pixels = subgrid(OWN_SIDE, view.size);
        let reference = self.cache.solve((first, &view), &Model::Canonical, pixels, self.control)?;
        let judge = |frame: &Frame, _: &Model, _: usize| Ok(reference.judge(frame).rmse);
        self.fill(blank, (renderer, &claim), sizes, &pictures, |_| view.clone(), judge).map(Some)
    }

    /// Refines the step on lattices of unequal cells, where the renderer draws them by the rule of the claim.
    fn other_lattices(
        &self,
        renderer: &dyn StudiedRenderer,
        claim: &ConvergenceClaim,
    ) -> Result<Vec<Convergence>, StudyError> {
        let lattices = [
            (Refined::StepOnLevels, "waves, adaptive mesh", adaptive()),
            (Refined::StepOnUnevenAxes, "waves, uneven axes", uneven(SAMPLES)),
        ];
        let found = lattices.iter().map(|(refined, name, scene)| self.step(renderer, claim, *refined, (name, scene)));
        // Most rules are of uniform grids: what they refuse here says nothing about the claim.
        let is_drawn = |c: &Result<Convergence, _>| !c.as_ref().is_ok_and(|c| c.outcome() == Outcome::Refused);
        found.filter(is_drawn).collect()
    }

    fn step(
        &self,
        renderer: &dyn StudiedRenderer,
        claim: &ConvergenceClaim,
        refined: Refined,
        (name, scene): (&str, &Scene),
    ) -> Result<Convergence, StudyError> {
        self.step_in(blank(renderer, claim, refined, name), (renderer, claim), scene, &view(scene, SIDE))
    }

    fn step_in(
        &self,
        blank: Convergence,
        (renderer, claim): (&dyn StudiedRenderer, &ConvergenceClaim),
        scene: &Scene,
        view: &View,
    ) -> Result<Convergence, StudyError> {
        let sizes: Vec<f64> = (0..STEPS).map(|k| claim.coarsest / 2f64.sqrt().powi(k)).collect();
        let pictures: Vec<(Scene, f64)> = sizes.iter().map(|&step| (scene.clone(), step)).collect();
        // The model is the same at every step: it is the scene's, or that of a filter.
        let mut solved = None;
        let judge = |frame: &Frame, model: &Model, _: usize| {
            let reference = match solved.take() {
                Some(reference) => reference,
                None => self.cache.solve((scene, view), model, subgrid(u32::MAX, view.size), self.control)?,
            };
            Ok(solved.insert(reference).judge(frame).rmse)
        };
        self.fill(blank, (renderer, claim), sizes, &pictures, |_| view.clone(), judge)
    }

    fn grid(&self, renderer: &dyn StudiedRenderer, claim: &ConvergenceClaim) -> Result<Convergence, StudyError> {
        let cells = [16usize, 22, 32, 44, 64];
        let sizes: Vec<f64> = cells.iter().map(|&n| 2.0 / n as f64).collect();
        let pictures: Vec<(Scene, f64)> = cells.iter().map(|&n| (smooth(n + 1), 0.5 * claim.coarsest)).collect();
        let view = view(&pictures[0].0, SIDE);
        let pixels = subgrid(SIDE, view.size);
        let reference = ReferencePixels::solve_phantom(
            &(Arc::new(Waves) as Arc<dyn Phantom>),
            (&pictures[0].0, &view),
            pixels,
            self.control,
        )?;
        let judge = |frame: &Frame, _: &Model, _: usize| Ok(reference.judge(frame).rmse);
        let blank = blank(renderer, claim, Refined::Grid, "waves");
        self.fill(blank, (renderer, claim), sizes, &pictures, |_| view.clone(), judge)
    }

    fn pixels(&self, renderer: &dyn StudiedRenderer, claim: &ConvergenceClaim) -> Result<Convergence, StudyError> {
        /// Number of patches along each side, and of pixels of the reference along each side of a patch: its own error is a sixteenth of the smallest
        /// measured.
        const PATCHES: u32 = 6;
        const FINE: u32 = 24;
        let parts = [1u32, 2, 3, 4, 6];
        let scene = smooth(SAMPLES);
        let at = |parts: u32| inner_view(&scene, PATCHES * parts);
        let fine = at(FINE);
        let pixels = subgrid(u32::MAX, fine.size);
        let reference = self.cache.solve((&scene, &fine), &Model::Canonical, pixels, self.control)?;
        let reference = patches(reference.rgba(), PATCHES, FINE);
        let sizes: Vec<f64> = parts.iter().map(|&n| 1.0 / f64::from(n)).collect();
        let pictures: Vec<(Scene, f64)> = parts.iter().map(|_| (scene.clone(), claim.coarsest / 16.0)).collect();
        let judge = |frame: &Frame, _: &Model, k: usize| {
            let pixels: Vec<[f64; 4]> = frame.pixels().iter().map(|p| p.map(f64::from)).collect();
            Ok(rms(&patches(&pixels, PATCHES, parts[k]), &reference))
        };
        let blank = blank(renderer, claim, Refined::Pixels, "waves");
        self.fill(blank, (renderer, claim), sizes, &pictures, |k| at(parts[k]), judge)
    }

    /// Draws each picture, judges it, and fits the order.
    fn fill(
        &self,
        mut blank: Convergence,
        (renderer, claim): (&dyn StudiedRenderer, &ConvergenceClaim),
        sizes: Vec<f64>,
        pictures: &[(Scene, f64)],
        view: impl Fn(usize) -> View,
        mut judge: impl FnMut(&Frame, &Model, usize) -> Result<f64, RenderError>,
    ) -> Result<Convergence, StudyError> {
        for (k, (scene, step)) in pictures.iter().enumerate() {
            let configured = renderer.with_options(&claim.options.clone().with(claim.key, *step))?;
            let draw = || {
                let mut prepared = configured.prepare(scene, self.control)?;
                let view = view(k);
                let frame = prepared.render(&view, self.control)?.frame;
                Ok::<_, RenderError>((frame, prepared.model(&view)?))
            };
            // A renderer that panics is not used again.
            match catch_unwind(AssertUnwindSafe(|| catch_stopped(draw))) {
                Ok(Ok((frame, model))) => {
                    // The sum of a discrete model depends on the step: its limit is the correct pixel.
                    let model = if let Model::Filtered(_) = model { model } else { Model::Canonical };
                    blank.errors.push(judge(&frame, &model, k)?);
                }
                Ok(Err(RenderError::Cancelled)) => return Err(RenderError::Cancelled.into()),
                Ok(Err(RenderError::Unsupported(refused))) => {
                    blank.trouble = Some(format!("{REFUSED}{}", refused.what))
                }
                Ok(Err(other)) => blank.trouble = Some(other.to_string()),
                Err(_) => blank.trouble = Some("panics".to_owned()),
            }
            if blank.trouble.is_some() {
                return Ok(blank);
            }
        }
        if let Some(e) = blank.errors.iter().find(|e| !e.is_finite()) {
            blank.trouble = Some(format!("an error is {e}"));
        } else {
            blank.measured = fit_order_above(blank.floor, MIN_ERRORS, &sizes, &blank.errors);
        }
        blank.sizes = sizes;
        Ok(blank)
    }
}

fn blank(renderer: &dyn StudiedRenderer, claim: &ConvergenceClaim, refined: Refined, scene: &str) -> Convergence {
    let orders = claim.orders;
    let expected = match refined {
        Refined::Step => orders.smooth,
        Refined::StepAtJumps => orders.jumps,
        // Fields have kinks at the faces of cells, of all sizes here.
        Refined::StepOnLevels | Refined::StepOnUnevenAxes => orders.smooth.min(2.0),
        Refined::Grid => orders.grid,
        Refined::Pixels => orders.pixels,
    };
    Convergence {
        renderer: renderer.name().to_owned(),
        claim: claim.name.clone(),
        refined,
        scene: scene.to_owned(),
        expected,
        tolerance: refined.tolerance(),
        at_least: false,
        measured: None,
        sizes: Vec::new(),
        errors: Vec::new(),
        floor: claim.floor,
        trouble: None,
    }
}

/// True if the orders that renderers document hold for such a scene: unshaded light.
fn is_claimed(scene: &Scene) -> bool {
    scene.compositing.integrates_light() && scene.shading.is_none()
}

/// Loosens a test for data that were not made for it.
fn on_own_data(c: Convergence) -> Convergence {
    let tolerance = Refined::StepAtJumps.tolerance();
    Convergence { at_least: true, expected: c.expected.min(2.0), tolerance, ..c }
}

/// Returns the mean light of `n`×`n` patches of `parts`×`parts` pixels each.
fn patches(pixels: &[[f64; 4]], n: u32, parts: u32) -> Vec<[f64; 4]> {
    let (n, parts) = (n as usize, parts as usize);
    let side = n * parts;
    let mut means = vec![[0.0; 4]; n * n];
    for (i, p) in pixels.iter().enumerate() {
        let patch = i / side / parts * n + i % side / parts;
        (0..4).for_each(|c| means[patch][c] += p[c] / (parts * parts) as f64);
    }
    means
}

fn rms(a: &[[f64; 4]], b: &[[f64; 4]]) -> f64 {
    let sum: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).powi(2)).sum();
    (sum / (4 * a.len()) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_means() {
        let pixels: Vec<[f64; 4]> = (0..16).map(|i| [f64::from(i); 4]).collect();
        let found: Vec<f64> = patches(&pixels, 2, 2).iter().map(|p| p[0]).collect();
        assert_eq!(found, [2.5, 4.5, 10.5, 12.5]);
        assert_eq!(patches(&pixels, 4, 1), pixels);
    }

    /// Steps follow the cells: the orders are those of uniform grids, for the rules that draw such lattices.
    #[test]
    fn orders_hold_on_unequal_cells() {
        let (cache, control) = (ReferenceCache::none(), Control::default());
        let check = OrderCheck { cache: &cache, control: &control };
        let renderers: [&dyn StudiedRenderer; 2] =
            [&vr_raycast::RayCaster::default(), &vr_physics::check::faulty_marcher::Marcher::default()];
        for (renderer, claim) in renderers.iter().flat_map(|r| r.convergence().into_iter().map(move |claim| (r, claim)))
        {
            let found = check.other_lattices(*renderer, &claim).unwrap();
            let is_drawn = ["midpoint", "left"].contains(&claim.name.as_str());
            assert_eq!(found.len(), if is_drawn { 2 } else { 0 }, "{}", claim.name);
            for c in found {
                println!("{} {}: {:.3?} of {}, {:?}", c.claim, c.refined.word(), c.measured, c.expected, c.errors);
                assert_eq!(c.outcome(), Outcome::Holds, "{c:?}");
            }
        }
    }

    #[test]
    fn outcomes() {
        let of = |measured, errors: &[f64], trouble: Option<&str>| {
            let sizes = vec![1.0; errors.len()];
            let trouble = trouble.map(str::to_owned);
            Convergence {
                renderer: String::new(),
                claim: String::new(),
                refined: Refined::Step,
                scene: String::new(),
                expected: 2.0,
                tolerance: 0.15,
                at_least: false,
                measured,
                sizes,
                errors: errors.to_vec(),
                floor: 1e-7,
                trouble,
            }
            .outcome()
        };
        assert_eq!(of(Some(1.9), &[1e-2, 1e-3], None), Outcome::Holds);
        assert_eq!(of(Some(1.0), &[1e-2, 1e-3], None), Outcome::Fails);
        assert_eq!(of(None, &[1e-8, 1e-8], None), Outcome::Exact);
        assert_eq!(of(Some(1.2), &[9e-7, 5e-7, 2e-8], None), Outcome::Exact);
        assert_eq!(of(Some(1.2), &[9e-7, 5e-7, 2e-7], None), Outcome::Fails);
        assert_eq!(of(None, &[1e-8, 1e-2], None), Outcome::Fails);
        assert_eq!(of(None, &[0.0, 0.0], None), Outcome::Empty);
        assert_eq!(of(None, &[], Some("panics")), Outcome::Fails);
        assert_eq!(of(None, &[], Some("refused: everything")), Outcome::Refused);
    }
}
