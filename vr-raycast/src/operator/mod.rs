//! Compositing operators, which make one value of the samples of a ray. One small file each.
//!
//! | operator | consumes | sees the ends of the chord | order of the runs |
//! |---|---|---|---|
//! | [`OverFrontToBack`] | light | no | front to back |
//! | [`OverBackToFront`] | light | no | back to front |
//! | [`Accumulate`] | light | no | front to back |
//! | [`Average`] | values | no | any |
//! | [`Extreme`] | values | yes | any |
//! | [`First`] | values | yes | front to back |
//!
//! [`Recording`] is any of them, watched.

mod accumulate;
mod average;
mod extreme;
mod first;
mod over_back_to_front;
mod over_front_to_back;
mod recording;

pub(crate) use recording::Recording;

use std::ops::ControlFlow;
use std::sync::Arc;

use vr_core::optics::fraction_to_level;
use vr_core::{Calibration, Compositing, Real, Scene};

use accumulate::Accumulate;
use average::Average;
use extreme::Extreme;
use first::First;
use over_back_to_front::OverBackToFront;
use over_front_to_back::OverFrontToBack;

use crate::caster::CompositingOrder;
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Input that an operator asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Needs {
    /// True if the operator composites light, false if it needs values alone.
    pub(crate) light: bool,
    /// True if the runs come from the far end.
    pub(crate) backwards: bool,
    /// True if the operator also takes the two end points of the chord, as runs of one sample and no length.
    pub(crate) ends: bool,
    /// True if the operator goes back from a sample to the one before, even if that one is not visible.
    pub(crate) brackets: bool,
    /// True if the operator, which takes values, takes the colours of all places, too.
    pub(crate) colors: bool,
    /// True if the operator finds a surface, which is shaded once found.
    pub(crate) surface: bool,
}

impl Needs {
    const VALUES: Self =
        Self { light: false, backwards: false, ends: false, brackets: false, colors: false, surface: false };
    pub(crate) const LIGHT: Self = Self { light: true, ..Self::VALUES };
}

/// Compositing operator, with the state of one ray.
///
/// Called once a run, through a pointer: so that the pipeline is compiled for each precision and not for each operator as well.
pub(crate) trait Operator<R: Real> {
    /// Returns the input that the operator asks for, the same for every ray.
    fn needs(&self) -> Needs;

    /// Forgets the last ray.
    fn begin(&mut self, chord: &Chord<'_>);

    /// Takes the next run; returns `Break` if nothing that follows can matter.
    fn take(&mut self, run: &Run<R>, chord: &Chord<'_>) -> ControlFlow<()>;

    /// Returns the value of the ray.
    fn finish(&mut self, chord: &Chord<'_>) -> RayValue;
}

/// Makes the operator of a scene for one thread.
pub(crate) fn operator<R: Real>(
    scene: &Scene,
    calibration: Calibration,
    order: CompositingOrder,
) -> Box<dyn Operator<R>> {
    let transfer = || Arc::clone(&scene.transfer);
    match (scene.compositing, order) {
        (Compositing::Over, CompositingOrder::BackToFront) => Box::new(OverBackToFront::default()),
        (Compositing::Over, CompositingOrder::FrontToBack { termination }) => {
            Box::new(OverFrontToBack::new(termination, scene.max_radiance()))
        }
        (Compositing::Accumulate { level }, _) => Box::new(Accumulate::new(level)),
        (Compositing::First { threshold }, _) => Box::new(First::new(transfer(), calibration, threshold)),
        (Compositing::Average, _) => Box::new(Average::new(transfer(), calibration)),
        (Compositing::Maximum, _) => Box::new(Extreme::new(transfer(), calibration, true)),
        (Compositing::Minimum, _) => Box::new(Extreme::new(transfer(), calibration, false)),
    }
}

/// Opacity that defines the depth of a pixel.
const HALF: f64 = 0.5;

/// Returns the distance at which opacity reaches a level, within consecutive homogeneous steps (opacity, begin, length), from the opacity
/// that lies before them on; `None` if it does not.
fn distance_of_opacity(level: f64, before: f64, steps: impl Iterator<Item = (f64, f64, f64)>) -> Option<f64> {
    let mut clear = 1.0 - before;
    // A step of no opacity reaches nothing, whatever rounding says.
    for (alpha, begin, length) in steps.filter(|step| step.0 > 0.0) {
        let behind = clear * (1.0 - alpha);
        if behind <= 1.0 - level {
            return Some(begin + length * fraction_to_level(clear, alpha, level));
        }
        clear = behind;
    }
    None
}

/// Returns the steps of a run in the form that [`distance_of_opacity`] takes.
fn steps_of<R: Real>(run: &Run<R>) -> impl DoubleEndedIterator<Item = (f64, f64, f64)> + '_ {
    (0..run.len()).map(|j| (run.light[j][3].to_f64(), run.steps.begin[j], run.steps.length[j]))
}

/// Returns the end of the last step of a run that has any opacity. (The end of a run without such a step depends on what was left out.)
fn end_of_opacity<R: Real>(run: &Run<R>) -> f64 {
    let last = (0..run.len()).rfind(|&j| run.light[j][3] > R::ZERO).unwrap_or(run.len() - 1);
    run.steps.begin[last] + run.steps.length[last]
}
