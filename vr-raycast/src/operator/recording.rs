//! Record of the steps that another operator takes.

use std::ops::ControlFlow;

use vr_core::{Calibration, ProbedSample, ProbedStep, Real};

use super::{Needs, Operator};
use crate::chord::Chord;
use crate::ray_value::RayValue;
use crate::run::Run;

/// Operator that hands everything to another one and notes the steps that it takes: the other computes as it does without.
pub(crate) struct Recording<R> {
    operator: Box<dyn Operator<R>>,
    calibration: Calibration,
    /// Positions in a step of light at which the rule samples, as fractions of its length; `None`: at the sample that the run has for each.
    fractions: Option<&'static [f64]>,
    steps: Vec<ProbedStep>,
}

impl<R: Real> Recording<R> {
    pub(crate) fn new(
        operator: Box<dyn Operator<R>>,
        calibration: Calibration,
        fractions: Option<&'static [f64]>,
    ) -> Self {
        Self { operator, calibration, fractions, steps: Vec::new() }
    }

    /// Returns the steps of the last ray, front to back.
    pub(crate) fn into_steps(mut self) -> Vec<ProbedStep> {
        // Runs from the far end come in the wrong order.
        self.steps.sort_by(|a, b| a.begin.total_cmp(&b.begin));
        self.steps
    }

    /// Returns the samples of a step of the run.
    fn samples(&self, run: &Run<R>, chord: &Chord<'_>, j: usize, fractions: Option<&[f64]>) -> Vec<ProbedSample> {
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

impl<R: Real> Operator<R> for Recording<R> {
    fn needs(&self) -> Needs {
        self.operator.needs()
    }

    fn begin(&mut self, chord: &Chord<'_>) {
        self.steps.clear();
        self.operator.begin(chord);
    }

    fn take(&mut self, run: &Run<R>, chord: &Chord<'_>) -> ControlFlow<()> {
        let light = self.needs().light;
        for j in 0..run.len() {
            let [r, g, b, opacity] = if light { run.light[j].map(R::to_f64) } else { [0.0; 4] };
            self.steps.push(ProbedStep {
                begin: run.steps.begin[j] + chord.ray.offset,
                length: run.steps.length[j],
                samples: self.samples(run, chord, j, self.fractions.filter(|_| light)),
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
