//! Light of steps along which the value changes.

use std::sync::Arc;

use vr_core::{Calibration, Real, TransferFunction};
use vr_kernels::tables::PreIntegrated;

use super::cubic::Cubic;
use super::exact::ExactIntegral;
use crate::run::Run;

/// Course of the value along a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Constant, the value of one sample.
    Point,
    /// Straight from front to back.
    Line,
    /// Parabola through front, middle and back.
    Parabola,
    /// Cubic through four points inside.
    Cubic,
}

/// Integrator that turns the values of a step into light, over all values between them: from a table of antiderivatives, whatever the
/// length of the step, or to rounding.
///
/// Vacuum: between a sample and one that does not exist, the field reaches half way, at the value of the one that exists. So it ends
/// at the right place on average; steps that end at the faces of cells end it there. A cubic exists with all its samples or not at all: they are in one cell.
#[derive(Clone, Debug)]
pub(crate) struct Profile<R> {
    pub(crate) shape: Shape,
    /// Table of antiderivatives; `None` where everything is integrated to rounding.
    pub(crate) table: Option<Arc<PreIntegrated<R>>>,
    pub(crate) exact: ExactIntegral,
    pub(crate) calibration: Calibration,
}

impl<R: Real> Profile<R> {
    /// Returns the positions in a step at which the field is sampled, as fractions of its length; `None` for the run's own sample of the step.
    pub(crate) fn fractions(&self) -> Option<&'static [f64]> {
        (self.shape != Shape::Point).then(|| self.shape.fractions())
    }

    /// Fills the light of a sampled run.
    pub(crate) fn classify(&self, run: &mut Run<R>) {
        for j in 0..run.len() {
            run.light[j] = self.step(run, j, run.steps.length[j]);
        }
    }

    /// Returns light and opacity of a step of the run, as if it were `length` long.
    pub(crate) fn step(&self, run: &Run<R>, j: usize, length: f64) -> [R; 4] {
        match self.shape {
            Shape::Point => self.line(run.value[j], run.value[j], length),
            Shape::Line => self.line(run.profile[0][j], run.profile[1][j], length),
            Shape::Parabola => self.parabola(run.profile[0][j], run.profile[1][j], run.profile[2][j], length),
            Shape::Cubic => {
                let values = run.profile.map(|values| values[j]);
                if values.iter().any(|v| v.is_nan()) {
                    return [R::ZERO; 4];
                }
                self.exactly(Cubic::through(values.map(|v| self.value(v))), length)
            }
        }
    }

    fn line(&self, front: R, back: R, length: f64) -> [R; 4] {
        match (front.is_nan(), back.is_nan()) {
            (true, true) => [R::ZERO; 4],
            (true, false) => self.line(back, back, 0.5 * length),
            (false, true) => self.line(front, front, 0.5 * length),
            (false, false) => match &self.table {
                Some(table) => table.segment(front, back, R::from_f64(length)),
                None => self.exactly(Cubic::line(self.value(front), self.value(back)), length),
            },
        }
    }

    fn parabola(&self, front: R, middle: R, back: R, length: f64) -> [R; 4] {
        let as_lines = || {
            let halves = (self.line(front, middle, 0.5 * length), self.line(middle, back, 0.5 * length));
            let clear = R::ONE - halves.0[3];
            std::array::from_fn(|c| halves.0[c] + clear * halves.1[c])
        };
        if front.is_nan() || middle.is_nan() || back.is_nan() {
            return as_lines();
        }
        match &self.table {
            Some(table) => table.segment3(front, middle, back, R::from_f64(length)),
            None => {
                let [front, middle, back] = [front, middle, back].map(|v| self.value(v));
                // A parabola may leave the range of the field's values, by a quarter of its sagitta; into a wall it must not.
                let more = 0.25 * (middle - 0.5 * (front + back)).abs();
                let (low, high) = (front.min(middle).min(back), front.max(middle).max(back));
                if self.exact.wall_is_near(low, high, more) {
                    return as_lines();
                }
                self.exactly(Cubic::parabola(front, middle, back), length)
            }
        }
    }

    fn exactly(&self, value: Cubic, length: f64) -> [R; 4] {
        self.exact.step(value, length).map(R::from_f64)
    }

    fn value(&self, stored: R) -> f64 {
        self.calibration.value(stored.to_f64())
    }

    /// Returns light and opacity of a step of the run whose extinction is multiplied by `factor`.
    ///
    /// κ times a factor over h is κ over h times that factor, but emission of its own must not be multiplied along.
    pub(crate) fn with_extinction_times(&self, run: &Run<R>, j: usize, factor: f64) -> [R; 4] {
        /// Factor that stands for 0: the absorption that it leaves is lost in rounding.
        const FAINT: f64 = 1e-7;
        let transfer: &TransferFunction = self.exact.transfer();
        let length = run.steps.length[j];
        if !transfer.has_emission() {
            return if factor == 0.0 { [R::ZERO; 4] } else { self.step(run, j, length * factor) };
        }
        let used = factor.max(FAINT);
        let [r, g, b, alpha] = self.step(run, j, length * used);
        let share = R::from_f64(1.0 / used);
        [r * share, g * share, b * share, if factor == 0.0 { R::ZERO } else { alpha }]
    }
}
