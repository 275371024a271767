//! Light of a step, and a bound on its error.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{opacity_of_depth, pick, source_weight, splat};

use super::color_change::{ColorChange, load};
use super::cost_table::{Changes, CostTable, Here};

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
    pub(super) length: f32x16<S>,
    /// Optical depth, and opacity.
    pub(super) tau: f32x16<S>,
    pub(super) opacity: f32x16<S>,
    /// Medium at the end, and how colours change with the value there.
    pub(super) there: Here<S>,
    color_slopes: [f32x16<S>; 3],
    /// Change of the optical depth along the step, as if it were that of the begin and that of the end throughout.
    change: f32x16<S>,
}

/// Bounds on how a medium is off from what steps take it for.
pub(super) struct Doubt<S: Simd> {
    pub(super) changes: Changes<S>,
    /// Bound on the error of the optical depth, and its part that is due to the table.
    pub(super) missed_depth: f32x16<S>,
    looked_up: f32x16<S>,
    /// Infinity where a wall may be met.
    pub(super) walls: f32x16<S>,
}

/// Light of steps, and the largest of what its error depends on.
pub(super) struct Emission<S: Simd> {
    /// Light and opacity.
    pub(super) light: [f32x16<S>; 4],
    /// Changes of light over the steps, and its bulges.
    pub(super) change: f32x16<S>,
    pub(super) bulge: f32x16<S>,
    /// The same of the factors on colours.
    turned: f32x16<S>,
    turned_bulge: f32x16<S>,
    /// Changes of colours.
    unlit: f32x16<S>,
}

/// Step of sixteen rays.
pub(super) struct Step<S: Simd> {
    /// Light and opacity.
    pub(super) light: [f32x16<S>; 4],
    /// Medium at the end.
    pub(super) there: Here<S>,
    /// Bound on the error of the radiance in front of the step, for any radiance behind it up to the brightest.
    pub(super) missed: f32x16<S>,
    /// The part of that bound which is proportional to the length, so that shorter steps gain nothing: rounding, and the errors of tables.
    pub(super) rounding: f32x16<S>,
}

impl<S: Simd> Course<S> {
    #[inline(always)]
    pub(super) fn bow(&self) -> f32x16<S> {
        let [first, middle, last] = self.values;
        middle - (first + last) * 0.5
    }

    #[inline(always)]
    pub(super) fn span(&self) -> f32x16<S> {
        (self.values[2] - self.values[0]).abs()
    }

    /// Returns the largest distance from the line.
    #[inline(always)]
    pub(super) fn beside(&self) -> f32x16<S> {
        self.bow().abs() + self.cubic
    }

    /// Returns the largest distance from the line where the values may leave the range between the ends, and 0 where they are monotone.
    #[inline(always)]
    pub(super) fn outside(&self, simd: S) -> f32x16<S> {
        // The cubic part has a slope of 10.4 times its largest value at most.
        let is_monotone = (self.bow().abs() * 4.0 + self.cubic * 10.4).simd_le(self.span());
        pick(is_monotone, splat(simd, 0.0), self.beside())
    }
}

impl<S: Simd> Absorption<S> {
    /// Absorbs along steps of a length from places with the medium `here`; the README beside this folder derives each bound.
    #[inline(always)]
    pub(super) fn new(simd: S, costs: &CostTable, here: &Here<S>, course: &Course<S>, length: f32x16<S>) -> Self {
        let (there, color_slopes) = costs.medium(simd, course.values[2]);
        // The chord of κ, the middle of how far κ may lie beside it, and the parabola.
        let rise = course.values[2] - course.values[0];
        let bent = (there[4] - here[4]) * rise * (1.0 / 16.0);
        let bowed = (here[4] + there[4]) * course.bow() * (1.0 / 3.0);
        let tau = ((here[3] + there[3]) * 0.5 - bent + bowed).max(splat(simd, 0.0)) * length;
        let change = (there[3] - here[3]) * length;
        Self { length, tau, opacity: opacity_of_depth(simd, tau), there, color_slopes, change }
    }

    /// Largest change of a colour with the value, and that of κ.
    #[inline(always)]
    pub(super) fn steepness(&self) -> [f32x16<S>; 2] {
        let [r, g, b] = self.color_slopes;
        [r.abs().max(g.abs()).max(b.abs()), self.there[4].abs()]
    }

    /// Change of the optical depth along the step.
    #[inline(always)]
    pub(super) fn unevenness(&self) -> f32x16<S> {
        self.change.abs()
    }

    /// Returns the light of steps from places with the medium `here`. The colour goes evenly over the step, and bulges. `color_change`: what becomes of the colours; `None` where they stay.
    #[inline(always)]
    pub(super) fn emission(
        &self,
        simd: S,
        here: &Here<S>,
        bow: f32x16<S>,
        color_change: Option<&ColorChange>,
    ) -> Emission<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let Self { tau, opacity, there, color_slopes, .. } = *self;
        let weight = source_weight(simd, tau, opacity);
        let behind = ((weight - (one - opacity)) + self.change * (1.0 / 12.0) * weight).max(zero).min(opacity);
        let mut emission = Emission {
            light: [zero, zero, zero, opacity],
            change: zero,
            bulge: zero,
            turned: zero,
            turned_bulge: zero,
            unlit: zero,
        };
        for c in 0..3 {
            let (mut ends, mut bulge) = ([here[c], there[c]], color_slopes[c] * bow);
            if let Some(change) = color_change {
                let factor = load(simd, &change.factor[c]);
                let added = load(simd, &change.added[c]);
                emission.unlit = emission.unlit.max((ends[1] - ends[0]).abs());
                emission.turned = emission.turned.max((factor[2] - factor[0]).abs());
                emission.turned_bulge = emission.turned_bulge.max((factor[1] - (factor[0] + factor[2]) * 0.5).abs());
                let middle = ((ends[0] + ends[1]) * 0.5 + bulge) * factor[1] + added[1];
                ends = [ends[0] * factor[0] + added[0], ends[1] * factor[2] + added[2]];
                bulge = middle - (ends[0] + ends[1]) * 0.5;
            }
            let difference = ends[1] - ends[0];
            emission.change = emission.change.max(difference.abs());
            emission.bulge = emission.bulge.max(bulge.abs());
            emission.light[c] = (ends[0] * opacity + difference * behind + opacity * bulge * (2.0 / 3.0)).max(zero);
        }
        emission
    }
}

impl<S: Simd> Doubt<S> {
    /// Bounds what is missed along lengths whose values lie in a range, in steps over which they change by `span` at most and lie beside a line by `beside` at most; `outside` is the same for
    /// those steps alone that may leave the range between the values at their ends, 0 where none does.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        costs: &CostTable,
        [low, high]: [f32x16<S>; 2],
        [span, beside, outside]: [f32x16<S>; 3],
        length: f32x16<S>,
    ) -> Self {
        let changes = costs.changes(simd, low, high);
        let looked_up = changes.kappa * costs.quarter * length;
        let missed_depth =
            changes.kappa * (span * (1.0 / 16.0) + (beside + outside) * (1.0 / 3.0)) * length + looked_up;
        Self { changes, missed_depth, looked_up, walls: costs.walls(simd, low, high) }
    }

    /// Bounds what one step misses.
    #[inline(always)]
    pub(super) fn of_step(simd: S, costs: &CostTable, course: &Course<S>, length: f32x16<S>) -> Self {
        let [first, _, last] = course.values;
        let beside = course.beside();
        let room = beside + course.unsure;
        let spans = [course.span(), beside, course.outside(simd)];
        Self::new(simd, costs, [first.min(last) - room, first.max(last) + room], spans, length)
    }

    /// Returns true for rays that may see something of steps with these opacities.
    #[inline(always)]
    pub(super) fn is_seen(&self, simd: S, opacity: f32x16<S>) -> mask32x16<S> {
        (opacity + self.missed_depth).simd_gt(splat(simd, 0.0))
    }

    /// Bounds how far the extinction is from a line, over `span` and `beside` as in [`Self::new`], times a length; `slope`: the largest slope of it.
    #[inline(always)]
    pub(super) fn skew(&self, slope: f32x16<S>, span: f32x16<S>, beside: f32x16<S>, length: f32x16<S>) -> f32x16<S> {
        (slope * beside + self.changes.kappa * (span * 0.25 + beside)) * length + self.looked_up
    }

    /// Bounds how far colours are from lines, over `span` and `beside` as in [`Self::new`].
    #[inline(always)]
    pub(super) fn color(&self, costs: &CostTable, span: f32x16<S>, beside: f32x16<S>) -> f32x16<S> {
        self.changes.color * (span * 0.25 + beside + costs.quarter)
    }
}

/// Bounds the error of W, of a colour that changes by 1: by the optical depth of the step, and the change of the depth along it.
#[inline(always)]
pub(super) fn missed_order<S: Simd>(simd: S, tau: f32x16<S>, change: f32x16<S>) -> f32x16<S> {
    let one = splat(simd, 1.0);
    change * change * (one + change) * (1.0 / 128.0) + change * (tau * tau * (1.0 / 96.0)).min(splat(simd, 1.0 / 24.0))
}

impl<S: Simd> Step<S> {
    /// Takes steps that absorb. `beyond` is the error of the value, integrated over the parts of the step outside its cell, which are up to six times `margin` long. `color_change`:
    /// what becomes of the colours; `None` where they stay.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        costs: &CostTable,
        here: &Here<S>,
        course: &Course<S>,
        (absorption, doubt): (Absorption<S>, Doubt<S>),
        [beyond, margin]: [f32x16<S>; 2],
        color_change: Option<&ColorChange>,
    ) -> Self {
        let Absorption { length, opacity, tau, there, .. } = absorption;
        let Doubt { changes, missed_depth, looked_up, walls } = &doubt;
        let (bow, span) = (course.bow(), course.span());
        let (bowed, cubic) = (bow.abs(), course.cubic);
        let beside = bowed + cubic;
        let Emission { light, change, bulge, turned, turned_bulge, unlit } =
            absorption.emission(simd, here, bow, color_change);
        let size = absorption.unevenness();
        let uneven = ((tau + size / tau.max(splat(simd, f32::MIN_POSITIVE))) * 0.52).min(splat(simd, 2.0 / 3.0));
        let [color_slope, kappa_slope] = absorption.steepness();
        // Errors of the values, and of a medium that is not linear in them.
        let mut rounding = changes.steepest * (course.unsure * length + beyond);
        let bent_color = doubt.color(costs, span, beside);
        let mut missed_color = bent_color + bulge * uneven + color_slope * cubic * costs.factor;
        if let Some(change) = color_change {
            // A product of two parabolas is one but for two terms.
            let product = unlit * turned_bulge + color_slope * bowed * (turned + turned_bulge * 1.25);
            let largest = here[0].max(here[1]).max(here[2]).max(there[0].max(there[1]).max(there[2]));
            let color = largest + color_slope * beside + bent_color;
            let blurred = change.blurred.load(simd);
            missed_color +=
                product * 0.2 + color * change.factor_off.load(simd) + change.added_off.load(simd) + blurred;
            // Behind the face of the cell, and before it.
            let kappa = here[3].max(there[3]) + (kappa_slope + changes.kappa) * (span + beside + costs.quarter);
            rounding += opacity * blurred + kappa * margin * 6.0 * change.beyond.load(simd);
        }
        // Errors of W, where the colour changes along the step.
        let skew = doubt.skew(kappa_slope, span, beside, length);
        let missed = *missed_depth * costs.brightest
            + (opacity + *missed_depth) * missed_color
            + change * (missed_order(simd, tau, size) + skew * 2.0)
            + rounding
            + *walls;
        let rounding = rounding + *looked_up * costs.brightest + opacity * changes.color * costs.quarter;
        Self { light, there, missed, rounding }
    }
}

#[cfg(test)]
mod tests {
    use super::super::midpoints::exact;
    use super::*;
    use crate::error_bound::optics::Optics;
    use crate::error_bound::seeded::runner;
    use proptest::prelude::*;
    use vr_core::{Calibration, ControlPoint, OpacityRule, TransferFunction};
    use vr_kernels::vector::{LANES, baseline};

    /// Shares of their bounds that steps through random media use, along random cubics.
    fn shares(factor: f32) -> Vec<f64> {
        let point = (0.0f64..1.0, prop::array::uniform3(0.0f64..1.0), 0.0f64..0.97);
        let media = (prop::collection::vec(point, 2..7), any::<bool>());
        let course = (0.1f64..0.9, -0.1f64..0.1, -0.03f64..0.03, -0.03f64..0.03, 0.02f64..2.0, 0.0f64..1.0);
        let found = std::cell::RefCell::new(Vec::new());
        let run =
            runner(4000, 23).run(&(media, course), |((mut points, power), (f0, rise, bow, cubic, length, flat))| {
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let points = points.into_iter().map(|(v, c, a)| ControlPoint::new(v, c, a)).collect();
                let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
                let optics =
                    Optics::new(&TransferFunction::new(points, rule, 1.0).unwrap(), Calibration::default(), 1.0);
                let costs = CostTable::new(&optics, [0.0, 1.0], 1.0, [optics.brightest, 1.0]).unwrap();
                // From wild to nearly flat.
                let (rise, bow, cubic) = (rise * flat, bow * flat * flat, cubic * flat * flat * flat);
                let f = |t: f64| f0 + rise * t + 4.0 * bow * t * (1.0 - t) + cubic * t * (t - 0.5) * (t - 1.0);
                let simd = baseline();
                let step = {
                    let at = |x: f64| splat(simd, x as f32);
                    let (here, _) = costs.medium(simd, at(f(0.0)));
                    let course = Course {
                        values: [at(f(0.0)), at(f(0.5)), at(f(1.0))],
                        cubic: at(cubic.abs() * 0.0482 * f64::from(factor)),
                        unsure: at(3e-7),
                    };
                    let absorption = Absorption::new(simd, &costs, &here, &course, at(length));
                    let doubt = Doubt::of_step(simd, &costs, &course, at(length));
                    let none = [splat(simd, 0.0); 2];
                    let step = Step::new(simd, &costs, &here, &course, (absorption, doubt), none, None);
                    let lanes = [step.light[0], step.light[1], step.light[2], step.light[3], step.missed * factor];
                    lanes.map(|lanes| f64::from(lanes[LANES / 2]))
                };
                let truth = exact(&optics, |s| f(s / length), length, 4000);
                for behind in [0.0, f64::from(costs.brightest)] {
                    for c in 0..3 {
                        let got = step[c] + (1.0 - step[3]) * behind;
                        let want = truth[c] + (1.0 - truth[3]) * behind;
                        // What the midpoints are off by, and f32.
                        found.borrow_mut().push(((got - want).abs() - 3e-5).max(0.0) / step[4].max(1e-12));
                    }
                }
                Ok(())
            });
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
