//! Light of a step, and a bound on its error.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{opacity_of_depth, source_weight, splat};

use super::color_change::{ColorChange, load};
use super::cost_table::{Changes, CostTable};

/// Course of the field over a step: a line from the first value to the last, a parabola on it through the middle one, and a cubic that is 0 at both ends and in the
/// middle.
pub(super) struct Course<S: Simd> {
    /// Values at the begin, in the middle and at the end.
    pub(super) values: [f32x16<S>; 3],
    /// Bound of the cubic part.
    pub(super) cubic: f32x16<S>,
    /// Bound of the error of the values.
    pub(super) unsure: f32x16<S>,
}

/// Absorption along sixteen steps.
pub(super) struct Absorption<S: Simd> {
    length: f32x16<S>,
    pub(super) opacity: f32x16<S>,
    /// Bound on the error of the optical depth, and its part that is due to the table.
    missed_depth: f32x16<S>,
    looked_up: f32x16<S>,
    /// Medium at the end, and how it changes with the value there.
    there: [f32x16<S>; 4],
    slopes: [f32x16<S>; 4],
    changes: Changes<S>,
    tau: f32x16<S>,
    /// Range of all values of the step.
    range: [f32x16<S>; 2],
}

/// Step of sixteen rays.
pub(super) struct Step<S: Simd> {
    /// Light and opacity.
    pub(super) light: [f32x16<S>; 4],
    /// Medium at the end.
    pub(super) there: [f32x16<S>; 4],
    /// Bound on the error of the radiance in front of the step, for any radiance behind it up to the brightest.
    pub(super) missed: f32x16<S>,
    /// The part of that bound which is proportional to the length, so that shorter steps gain nothing: rounding, and the errors of tables.
    pub(super) rounding: f32x16<S>,
}

impl<S: Simd> Course<S> {
    #[inline(always)]
    fn bow(&self) -> f32x16<S> {
        let [first, middle, last] = self.values;
        middle - (first + last) * 0.5
    }

    #[inline(always)]
    fn span(&self) -> f32x16<S> {
        (self.values[2] - self.values[0]).abs()
    }
}

impl<S: Simd> Absorption<S> {
    /// Absorbs along steps of a length from places with the medium `here`; the README beside this folder derives each bound.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        costs: &CostTable,
        here: &[f32x16<S>; 4],
        course: &Course<S>,
        length: f32x16<S>,
    ) -> Self {
        let [first, _, last] = course.values;
        let [there, slopes] = costs.medium(simd, last);
        let bow = course.bow();
        let beside = bow.abs() + course.cubic;
        // All values of the step lie in this range.
        let room = beside + course.unsure;
        let range = [first.min(last) - room, first.max(last) + room];
        let changes = costs.changes(simd, range[0], range[1]);
        // Optical depth, as if κ were linear in the value.
        let tau = ((here[3] + there[3]) * 0.5 + slopes[3] * bow * (2.0 / 3.0)).max(splat(simd, 0.0)) * length;
        let looked_up = changes.kappa * costs.quarter * length;
        let missed_depth = changes.kappa * (course.span() * (1.0 / 6.0) + beside * (2.0 / 3.0)) * length + looked_up;
        let opacity = opacity_of_depth(simd, tau);
        Self { length, opacity, missed_depth, looked_up, there, slopes, changes, tau, range }
    }

    /// True for rays that may see something of their steps.
    #[inline(always)]
    pub(super) fn is_seen(&self, simd: S) -> mask32x16<S> {
        (self.opacity + self.missed_depth).simd_gt(splat(simd, 0.0))
    }
}

impl<S: Simd> Step<S> {
    /// Takes steps that absorb. `beyond` is the error of the value, integrated over the part of the step behind its cell, which is up to `margin` long twice. `color_change`:
    /// what becomes of the colours; `None` where they stay.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        costs: &CostTable,
        here: &[f32x16<S>; 4],
        course: &Course<S>,
        absorption: Absorption<S>,
        [beyond, margin]: [f32x16<S>; 2],
        color_change: Option<&ColorChange>,
    ) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let Absorption { length, opacity, missed_depth, looked_up, there, slopes, changes, tau, range } = absorption;
        let (bow, span) = (course.bow(), course.span());
        let (bowed, cubic) = (bow.abs(), course.cubic);
        let beside = bowed + cubic;
        // Light: the colour goes evenly over the step, and bulges.
        let (change, bent) = ((there[3] - here[3]) * length, slopes[3] * bow);
        let weight = source_weight(simd, tau, opacity);
        let behind = ((weight - (one - opacity)) + change * (1.0 / 12.0) * weight).max(zero).min(opacity);
        let size = change.abs();
        let uneven = ((tau + size / tau.max(splat(simd, f32::MIN_POSITIVE))) * 0.52).min(splat(simd, 2.0 / 3.0));
        let color_slope = slopes[0].abs().max(slopes[1].abs()).max(slopes[2].abs());
        let mut light = [zero, zero, zero, opacity];
        // Largest change of light over the step and bulge of it; the same of the factors on colours; and the largest change of colours.
        let (mut lit, mut bulged, mut turned, mut turned_bulge, mut unlit) = (zero, zero, zero, zero, zero);
        for c in 0..3 {
            let (mut ends, mut bulge) = ([here[c], there[c]], slopes[c] * bow);
            if let Some(change) = color_change {
                let factor = load(simd, &change.factor[c]);
                let added = load(simd, &change.added[c]);
                unlit = unlit.max((ends[1] - ends[0]).abs());
                turned = turned.max((factor[2] - factor[0]).abs());
                turned_bulge = turned_bulge.max((factor[1] - (factor[0] + factor[2]) * 0.5).abs());
                let middle = ((ends[0] + ends[1]) * 0.5 + bulge) * factor[1] + added[1];
                ends = [ends[0] * factor[0] + added[0], ends[1] * factor[2] + added[2]];
                bulge = middle - (ends[0] + ends[1]) * 0.5;
            }
            let difference = ends[1] - ends[0];
            (lit, bulged) = (lit.max(difference.abs()), bulged.max(bulge.abs()));
            light[c] = (ends[0] * opacity + difference * behind + opacity * bulge * (2.0 / 3.0)).max(zero);
        }
        // Errors of the values, and of a medium that is not linear in them.
        let mut rounding = changes.steepest * (course.unsure * length + beyond);
        let mut missed_color = changes.color * (span * 0.25 + beside + costs.quarter)
            + bulged * uneven
            + color_slope * cubic * costs.factor;
        if let Some(change) = color_change {
            // A product of two parabolas is one but for two terms.
            let product = unlit * turned_bulge + color_slope * bowed * (turned + turned_bulge * 1.25);
            let largest = here[0].max(here[1]).max(here[2]).max(there[0].max(there[1]).max(there[2]));
            let color = largest + color_slope * beside + changes.color * (span * 0.25 + beside + costs.quarter);
            let blurred = change.blurred.load(simd);
            missed_color +=
                product * 0.2 + color * change.factor_off.load(simd) + change.added_off.load(simd) + blurred;
            // Behind the face of the cell.
            let kappa = here[3].max(there[3]) + (slopes[3].abs() + changes.kappa) * (span + beside + costs.quarter);
            rounding += opacity * blurred + kappa * margin * 2.0 * change.beyond.load(simd);
        }
        // Errors of W, where the colour changes along the step.
        let order =
            size * size * (one + size) * (1.0 / 128.0) + size * (tau * tau * (1.0 / 96.0)).min(splat(simd, 1.0 / 24.0));
        let skew = (bent.abs() + slopes[3].abs() * cubic + changes.kappa * (span * 0.25 + beside)) * length;
        let missed = missed_depth * costs.brightest
            + (opacity + missed_depth) * missed_color
            + lit * (order + skew * 2.0)
            + rounding
            + costs.walls(simd, range[0], range[1]);
        let rounding = rounding + looked_up * costs.brightest + opacity * changes.color * costs.quarter;
        Self { light, there, missed, rounding }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_bound::optics::Optics;
    use fearless_simd::{Level, dispatch};
    use proptest::prelude::*;
    use proptest::test_runner::{Config, RngAlgorithm, RngSeed, TestRunner};
    use vr_core::{Calibration, ControlPoint, OpacityRule, TransferFunction};
    use vr_kernels::vector::LANES;

    /// Returns opacity and light along a course by many midpoints, in f64.
    fn exact(optics: &Optics, f: impl Fn(f64) -> f64, length: f64) -> [f64; 4] {
        const N: usize = 4000;
        let (mut light, mut clear) = ([0.0; 3], 1.0);
        for i in 0..N {
            let (rate, color) = optics.exactly(f((i as f64 + 0.5) / N as f64));
            let alpha = -libm::expm1(-rate * length / N as f64);
            for c in 0..3 {
                light[c] += clear * alpha * color[c];
            }
            clear *= 1.0 - alpha;
        }
        let [r, g, b] = light;
        [r, g, b, 1.0 - clear]
    }

    /// Shares of their bounds that steps through random media use, along random cubics.
    fn shares(factor: f32) -> Vec<f64> {
        let config = Config {
            cases: 4000,
            rng_algorithm: RngAlgorithm::ChaCha,
            rng_seed: RngSeed::Fixed(23),
            failure_persistence: None,
            ..Config::default()
        };
        let point = (0.0f64..1.0, prop::array::uniform3(0.0f64..1.0), 0.0f64..0.97);
        let media = (prop::collection::vec(point, 2..7), any::<bool>());
        let course = (0.1f64..0.9, -0.1f64..0.1, -0.03f64..0.03, -0.03f64..0.03, 0.02f64..2.0, 0.0f64..1.0);
        let found = std::cell::RefCell::new(Vec::new());
        let run = TestRunner::new(config).run(
            &(media, course),
            |((mut points, power), (f0, rise, bow, cubic, length, flat))| {
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let points = points.into_iter().map(|(v, c, a)| ControlPoint::new(v, c, a)).collect();
                let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
                let optics =
                    Optics::new(&TransferFunction::new(points, rule, 1.0).unwrap(), Calibration::default(), 1.0);
                let costs = CostTable::new(&optics, [0.0, 1.0], 1.0, [optics.brightest, 1.0]).unwrap();
                // From wild to nearly flat.
                let (rise, bow, cubic) = (rise * flat, bow * flat * flat, cubic * flat * flat * flat);
                let f = |t: f64| f0 + rise * t + 4.0 * bow * t * (1.0 - t) + cubic * t * (t - 0.5) * (t - 1.0);
                let step = dispatch!(Level::new(), simd => {
                    let at = |x: f64| splat(simd, x as f32);
                    let [here, _] = costs.medium(simd, at(f(0.0)));
                    let course = Course {
                        values: [at(f(0.0)), at(f(0.5)), at(f(1.0))],
                        cubic: at(cubic.abs() * 0.0482 * f64::from(factor)),
                        unsure: at(3e-7),
                    };
                    let absorption = Absorption::new(simd, &costs, &here, &course, at(length));
                    let none = [splat(simd, 0.0); 2];
                    let step = Step::new(simd, &costs, &here, &course, absorption, none, None);
                    let lanes = [step.light[0], step.light[1], step.light[2], step.light[3], step.missed * factor];
                    lanes.map(|lanes| f64::from(lanes[LANES / 2]))
                });
                let truth = exact(&optics, f, length);
                for behind in [0.0, f64::from(costs.brightest)] {
                    for c in 0..3 {
                        let got = step[c] + (1.0 - step[3]) * behind;
                        let want = truth[c] + (1.0 - truth[3]) * behind;
                        // What the midpoints are off by, and f32.
                        found.borrow_mut().push(((got - want).abs() - 3e-5).max(0.0) / step[4].max(1e-12));
                    }
                }
                Ok(())
            },
        );
        run.unwrap();
        found.into_inner()
    }

    #[test]
    fn steps_keep_their_bounds() {
        let all = shares(1.0);
        let worst = all.iter().copied().fold(0.0, f64::max);
        println!("{} steps, worst share of the bound {worst:.2}", all.len());
        assert!(worst <= 1.0);
        // And is no bound for its own sake: some steps use a good part of it.
        assert!(worst > 0.1);
    }

    #[test]
    fn a_smaller_bound_is_broken() {
        let broken = shares(0.05).iter().filter(|&&share| share > 1.0).count();
        assert!(broken > 20, "{broken}");
    }
}
