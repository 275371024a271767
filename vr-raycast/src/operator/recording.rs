//! Another operator, watched.

use std::ops::ControlFlow;

use vr_core::{Calibration, ProbedSample, ProbedStep, Real};

use super::Operator;
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Hands everything to another operator, and notes the steps that it takes: nothing is computed in any other way for being watched.
#[derive(Clone, Debug)]
pub(crate) struct Recording<O> {
    operator: O,
    calibration: Calibration,
    /// Where in a step of light the rule samples, as fractions of its length; `None`: at the sample that the run has for each.
    fractions: Option<&'static [f64]>,
    steps: Vec<ProbedStep>,
}

impl<O> Recording<O> {
    pub(crate) fn new(operator: O, calibration: Calibration, fractions: Option<&'static [f64]>) -> Self {
        Self { operator, calibration, fractions, steps: Vec::new() }
    }

    /// The steps of the last ray, front to back.
    pub(crate) fn into_steps(mut self) -> Vec<ProbedStep> {
        // Runs from the far end come in the wrong order.
        self.steps.sort_by(|a, b| a.begin.total_cmp(&b.begin));
        self.steps
    }

    /// The samples of a step of the run.
    fn samples<R: Real>(
        &self,
        run: &Run<R>,
        chord: &Chord<'_>,
        j: usize,
        fractions: Option<&[f64]>,
    ) -> Vec<ProbedSample> {
        let sample = |at: f64, index: [R; 3], stored: R| ProbedSample {
            at: at + chord.ray.offset,
            index: index.map(R::to_f64),
            value: self.calibration.value(stored.to_f64()),
        };
        match fractions {
            None => vec![sample(run.distance(j), run.position_of(j), run.value[j])],
            Some(fractions) => {
                let at = |fraction: f64| run.steps.begin[j] + fraction * run.steps.length[j];
                let values = run.profile.iter().map(|values| values[j]);
                fractions.iter().zip(values).map(|(&f, stored)| sample(at(f), chord.position(at(f)), stored)).collect()
            }
        }
    }
}

impl<R: Real, O: Operator<R>> Operator<R> for Recording<O> {
    const LIGHT: bool = O::LIGHT;
    const BACKWARDS: bool = O::BACKWARDS;
    const ENDS: bool = O::ENDS;
    const BRACKETS: bool = O::BRACKETS;
    const SURFACE: bool = O::SURFACE;

    fn begin(&mut self, chord: &Chord<'_>) {
        self.steps.clear();
        self.operator.begin(chord);
    }

    fn take(&mut self, run: &Run<R>, chord: &Chord<'_>) -> ControlFlow<()> {
        for j in 0..run.len() {
            let [r, g, b, opacity] = if O::LIGHT { run.light[j].map(R::to_f64) } else { [0.0; 4] };
            self.steps.push(ProbedStep {
                begin: run.steps.begin[j] + chord.ray.offset,
                length: run.steps.length[j],
                samples: self.samples(run, chord, j, self.fractions.filter(|_| O::LIGHT)),
                transparency: 1.0 - opacity,
                light: [r, g, b],
            });
        }
        self.operator.take(run, chord)
    }

    fn finish(&mut self, chord: &Chord<'_>) -> RayValue {
        self.operator.finish(chord)
    }
}
