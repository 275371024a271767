//! Several steps under one account: what they miss together follows from the largest of what each depends on.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Pairs, Stage, splat};

use super::cell::{Entry, Way};
use super::cost_table::Here;
use super::march::Medium;
use super::step::{Absorption, Doubt, missed_order};

/// Number of steps in a stretch, each of which goes through one cell.
pub(super) const STEPS: u32 = 4;

/// Stretch of sixteen rays.
pub(super) struct Stretch<S: Simd> {
    /// Places at the end, and value and medium there.
    pub(super) to: f32x16<S>,
    pub(super) value: f32x16<S>,
    pub(super) there: Here<S>,
    /// Light and opacity.
    pub(super) light: [f32x16<S>; 4],
    /// Bound on the error of the radiance in front of the stretch, for any radiance behind it up to the brightest.
    pub(super) missed: f32x16<S>,
    /// Number of steps that have a length, of all rays.
    pub(super) samples: u32,
}

impl<S: Simd> Stretch<S> {
    /// Takes rays on from places `start`, in the cells of places `within`, with a value and a medium, none beyond its `end`. Those that are `fresh` do not know value and
    /// medium yet. Colours stay as they are.
    #[inline(always)]
    pub(super) fn new<T: Pairs>(
        simd: S,
        medium: &Medium<'_, T>,
        way: &Way<S>,
        [start, within, value, end]: [f32x16<S>; 4],
        here: &Here<S>,
        [active, fresh]: [mask32x16<S>; 2],
        stages: &mut [Stage<T>; 2],
    ) -> Self {
        let costs = medium.costs;
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (mut at, mut value, mut there) = (start, value, *here);
        let mut light = [zero; 4];
        let mut samples = 0;
        // The largest of each: range of values, their change in a step, their distance from a line, their error; slopes of the colours and of κ; optical depth of a step, its change along
        // it, and the change of light.
        let (mut low, mut high) = (splat(simd, f32::INFINITY), splat(simd, f32::NEG_INFINITY));
        let (mut span, mut beside, mut outside, mut unsure) = (zero, zero, zero, zero);
        let (mut color_slope, mut kappa_slope) = (zero, zero);
        let (mut tau, mut uneven, mut change) = (zero, zero, zero);
        // Sum of what bulges of the colours add where opacity is spread unevenly, and of what is missed of their cubic parts.
        let mut bulged = zero;
        let [mut stage, mut next_stage] = stages.each_mut();
        let mut entry = Entry::new(simd, medium, way, [at, within, end], active, stage);
        let mut fresh = fresh;
        for step in 1..=STEPS {
            // While a step waits for its samples, those of the next one are fetched.
            let next = if step < STEPS {
                let behind = entry.to + way.margin;
                Some(Entry::new(simd, medium, way, [entry.to, behind, end], active, next_stage))
            } else {
                None
            };
            let ahead = entry.step(simd, medium, way, (value, fresh), stage);
            samples += (active & ahead.length.simd_gt(zero)).to_bitmask().count_ones();
            let course = &ahead.course;
            let [first, _, last] = course.values;
            // After the first step, every ray knows the medium.
            if step == 1 {
                there = costs.entered(simd, &there, fresh, first);
            }
            let absorption = Absorption::new(simd, costs, &there, course, ahead.length);
            let emission = absorption.emission(simd, &there, course.bow(), None);
            // The steps behind one another.
            let clear = one - light[3];
            for c in 0..4 {
                light[c] += clear * emission.light[c];
            }
            low = low.min(first).min(last);
            high = high.max(first).max(last);
            span = span.max(course.span());
            beside = beside.max(course.beside());
            outside = outside.max(course.outside(simd));
            unsure = unsure.max(course.unsure);
            let [steep_color, steep_kappa] = absorption.steepness();
            color_slope = color_slope.max(steep_color);
            kappa_slope = kappa_slope.max(steep_kappa);
            tau = tau.max(absorption.tau);
            uneven = uneven.max(absorption.unevenness());
            change = change.max(emission.change);
            let opacity = absorption.opacity;
            bulged += emission.bulge * (absorption.tau * opacity + absorption.unevenness()) * 0.52
                + steep_color * course.cubic * opacity;
            (at, value, there) = (ahead.to, last, absorption.there);
            fresh &= !active;
            let Some(next) = next else { break };
            entry = next;
            std::mem::swap(&mut stage, &mut next_stage);
        }
        let length = at - start;
        let room = beside + unsure;
        let doubt = Doubt::new(simd, costs, [low - room, high + room], [span, beside, outside], length);
        let bent_color = doubt.color(costs, span, beside);
        let skew = doubt.skew(kappa_slope, span, beside, length);
        let steps = STEPS as f32;
        let missed = doubt.missed_depth * (bent_color + color_slope * beside + costs.brightest)
            + light[3] * bent_color
            + bulged
            + change * (missed_order(simd, tau, uneven) * steps + skew * 2.0)
            + doubt.changes.steepest * (unsure * length + way.beyond * steps)
            + doubt.walls;
        Self { to: at, value, there, light, missed, samples }
    }
}

#[cfg(test)]
mod tests {
    use super::super::BoundedPackets;
    use super::super::march::Packet;
    use super::super::midpoints::exact;
    use super::*;
    use crate::error_bound::optics::Optics;
    use crate::error_bound::seeded::runner;
    use fearless_simd::Level;
    use proptest::prelude::*;
    use vr_core::filter::Lattice;
    use vr_core::{
        Calibration, ControlPoint, Filter, GridVolume, OpacityRule, Placement, TransferFunction, UniformGrid,
    };
    use vr_kernels::vector::{Field, LANES, Lanes, PacketLights, baseline};

    const SIDE: usize = 6;

    /// Shares of their bounds that stretches through random volumes and media use. `factor` scales the bounds.
    fn shares(factor: f64) -> Vec<f64> {
        let point = (0.0f64..255.0, prop::array::uniform3(0.0f64..1.0), 0.0f64..0.97);
        let media = (prop::collection::vec(point, 2..7), any::<bool>());
        // From hardly any noise on a ramp to nothing but noise.
        let samples =
            (prop::collection::vec(0.0f64..1.0, SIDE.pow(3)), 0.0f64..1.0, prop::array::uniform3(0.0f64..16.0));
        let places = prop::array::uniform2(prop::array::uniform3(0.0f64..SIDE as f64 - 1.0));
        let found = std::cell::RefCell::new(Vec::new());
        let run = runner(1500, 29).run(
            &(media, samples, places),
            |((mut points, power), (noise, rough, ramp), [from, to])| {
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                let points = points.into_iter().map(|(v, c, a)| ControlPoint::new(v, c, a)).collect();
                let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
                let transfer = TransferFunction::new(points, rule, 1.0).unwrap();
                let rough = rough.powi(4);
                let value = |i: usize| {
                    let smooth: f64 =
                        [i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE].iter().zip(ramp).map(|(&n, r)| n as f64 * r).sum();
                    (smooth * (1.0 - rough) + rough * 255.0 * noise[i]).clamp(0.0, 255.0) as u8
                };
                let samples: Vec<u8> = (0..SIDE.pow(3)).map(value).collect();
                let grid = UniformGrid::new(
                    [SIDE; 3],
                    samples.clone(),
                    Placement::from_spacing([1.0; 3]).unwrap(),
                    Calibration::default(),
                )
                .unwrap();
                let volume = GridVolume::new(grid.into(), Filter::Trilinear);
                let optics = Optics::new(&transfer, volume.calibration(), 1.0);
                let Some(packets) = BoundedPackets::new(Level::new(), &volume, &optics, None) else {
                    return Ok(());
                };
                let way: [f64; 3] = std::array::from_fn(|a| to[a] - from[a]);
                let length = way.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-3);
                let delta = way.map(|x| x / length);
                let packet = Packet {
                    hits: 1,
                    base: from.map(|x| [x; LANES]),
                    delta: delta.map(|x| [x; LANES]),
                    rounded_delta: delta.map(|x| Lanes([x as f32; LANES])),
                    first: Lanes::ZERO,
                    end: Lanes([length as f32; LANES]),
                    backdrop: Lanes::ZERO,
                    lights: PacketLights::default(),
                };
                let medium = Medium {
                    field: Field::new(&Lattice { samples: &samples, dims: [SIDE; 3] }),
                    dims: [SIDE; 3],
                    clear: &packets.clear,
                    costs: &packets.costs,
                    span: packets.span,
                    noise: packets.noise,
                    error: 1e-3,
                    reflection: None,
                    tints: None,
                };
                let simd = baseline();
                let stretch = {
                    let (zero, end) = (splat(simd, 0.0), splat(simd, length as f32));
                    let all = zero.simd_eq(zero);
                    let way = Way::new(simd, &medium, &packet);
                    let mut stages = [Stage::default(), Stage::default()];
                    let stretch = Stretch::new(
                        simd,
                        &medium,
                        &way,
                        [zero, way.margin, zero, end],
                        &[zero; 5],
                        [all, all],
                        &mut stages,
                    );
                    let [r, g, b, a] = stretch.light;
                    [r, g, b, a, stretch.missed, stretch.to].map(|lanes| f64::from(lanes[LANES / 2]))
                };
                let at = |s: f64| std::array::from_fn(|a| from[a] + delta[a] * s);
                let truth = exact(&optics, |s| volume.stored_at(at(s)), stretch[5], 8000);
                for behind in [0.0, f64::from(packets.costs.brightest)] {
                    for c in 0..4 {
                        let got = stretch[c] + (1.0 - stretch[3]) * behind * f64::from(c < 3);
                        let want = truth[c] + (1.0 - truth[3]) * behind * f64::from(c < 3);
                        // What the midpoints are off by, and f32.
                        found
                            .borrow_mut()
                            .push(((got - want).abs() - 3e-5).max(0.0) / (factor * stretch[4]).max(1e-12));
                    }
                }
                Ok(())
            },
        );
        run.unwrap();
        found.into_inner()
    }

    #[test]
    fn stretches_keep_their_bounds() {
        let all = shares(1.0);
        let worst = all.iter().copied().fold(0.0, f64::max);
        println!("{} components of stretches, worst share of the bound {worst:.2}", all.len());
        assert!(worst <= 1.0);
        // And is no bound for its own sake: some stretches use a good part of it.
        assert!(worst > 0.1);
    }

    #[test]
    fn a_smaller_bound_is_broken() {
        let broken = shares(0.05).iter().filter(|&&share| share > 1.0).count();
        assert!(broken > 20, "{broken}");
    }
}
