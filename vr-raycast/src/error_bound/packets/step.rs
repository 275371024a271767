//! Light of a step, and a bound on its error.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{opacity_of_depth, source_weight, splat};

use super::cost_table::CostTable;

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

impl<S: Simd> Step<S> {
    /// Takes steps of a length from places with the medium `here`; the README beside this folder derives each bound. `beyond` is the error of the value, integrated over the
    /// part of the step behind its cell.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        costs: &CostTable,
        here: &[f32x16<S>; 4],
        course: &Course<S>,
        length: f32x16<S>,
        beyond: f32x16<S>,
    ) -> Self {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let [first, middle, last] = course.values;
        let [there, slopes] = costs.medium(simd, last);
        let bow = middle - (first + last) * 0.5;
        let (bowed, cubic) = (bow.abs(), course.cubic);
        let beside = bowed + cubic;
        // All values of the step lie in this range.
        let room = beside + course.unsure;
        let (low, high) = (first.min(last) - room, first.max(last) + room);
        let changes = costs.changes(simd, low, high);
        let span = (last - first).abs();
        // Optical depth, as if κ were linear in the value.
        let change = (there[3] - here[3]) * length;
        let bent = slopes[3] * bow;
        let tau = ((here[3] + there[3]) * 0.5 + bent * (2.0 / 3.0)).max(zero) * length;
        let opacity = opacity_of_depth(simd, tau);
        let weight = source_weight(simd, tau, opacity);
        let behind = ((weight - (one - opacity)) + change * (1.0 / 12.0) * weight).max(zero).min(opacity);
        let bulge = opacity * bow * (2.0 / 3.0);
        let colors = [there[0] - here[0], there[1] - here[1], there[2] - here[2]];
        let light = [
            (here[0] * opacity + colors[0] * behind + slopes[0] * bulge).max(zero),
            (here[1] * opacity + colors[1] * behind + slopes[1] * bulge).max(zero),
            (here[2] * opacity + colors[2] * behind + slopes[2] * bulge).max(zero),
            opacity,
        ];
        // Errors of the values, and of a medium that is not linear in them.
        let rounding = changes.steepest * (course.unsure * length + beyond);
        let looked_up = changes.kappa * costs.quarter * length;
        let missed_depth = changes.kappa * (span * (1.0 / 6.0) + beside * (2.0 / 3.0)) * length + looked_up;
        let size = change.abs();
        let uneven = ((tau + size / tau.max(splat(simd, f32::MIN_POSITIVE))) * 0.52).min(splat(simd, 2.0 / 3.0));
        let color_slope = slopes[0].abs().max(slopes[1].abs()).max(slopes[2].abs());
        let missed_color =
            changes.color * (span * 0.25 + beside + costs.quarter) + color_slope * (bowed * uneven + cubic);
        // Errors of W, where the colour changes along the step.
        let color = colors[0].abs().max(colors[1].abs()).max(colors[2].abs());
        let order =
            size * size * (one + size) * (1.0 / 128.0) + size * (tau * tau * (1.0 / 96.0)).min(splat(simd, 1.0 / 24.0));
        let skew = (bent.abs() + slopes[3].abs() * cubic + changes.kappa * (span * 0.25 + beside)) * length;
        let missed = missed_depth * costs.brightest
            + (opacity + missed_depth) * missed_color
            + color * (order + skew * 2.0)
            + rounding
            + costs.walls(simd, low, high);
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
                let costs = CostTable::new(&optics, [0.0, 1.0], 1.0).unwrap();
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
                    let step = Step::new(simd, &costs, &here, &course, at(length), splat(simd, 0.0));
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
