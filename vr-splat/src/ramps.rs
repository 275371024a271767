//! A transfer function's ramps, evaluated for sixteen values at once: where no table tells apart what is narrow and what is wide.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::{OpacityRule, TransferFunction};
use vr_kernels::vector::{depth_of_opacity, pick, splat, step_light};

/// The ramps of a transfer function, in the order of their values.
pub(crate) struct Ramps {
    ramps: Vec<Ramp>,
    /// Extinction per unit of the view, of an optical depth or an opacity of 1.
    per_unit: f32,
    rule: OpacityRule,
    emits: bool,
}

/// A ramp, from one value to the next.
struct Ramp {
    from: f32,
    per_width: f32,
    /// (r, g, b, α) at its begin, and the change up to its end.
    start: [f32; 4],
    change: [f32; 4],
}

/// Largest number of ramps, each of which costs every value a comparison.
const MAX_RAMPS: usize = 24;
/// Narrowest ramp, relative to its values, in which f32 has places enough.
const NARROWEST: f64 = 1e-3;
/// Largest opacity whose rest, 1 − α, f32 knows to 10⁻⁵.
const DENSEST: f64 = 0.99;
/// Extinction that stands for opaque values.
const OPAQUE: f32 = 1e30;

impl Ramps {
    /// The ramps of a transfer function of values as they are stored, for lengths in units of `unit`; `None` where f32 or time does not allow it.
    pub(crate) fn new(transfer: &TransferFunction, unit: f64) -> Option<Self> {
        let segments = transfer.segments();
        let is_wide = |from: f64, to: f64| to - from >= NARROWEST * from.abs().max(to.abs());
        let finite = |x: f64| x.is_finite();
        let wide = segments.iter().all(|s| !(finite(s.from) && finite(s.to)) || is_wide(s.from, s.to));
        // f32 keeps too few digits of a small 1 − α.
        let dense = |s: &vr_core::transfer::Segment| s.start.opacity.max(s.end.opacity) > DENSEST && !s.is_opaque();
        let loses = transfer.rule() == OpacityRule::Power && segments.iter().any(dense);
        if !wide || loses || segments.len() > MAX_RAMPS {
            return None;
        }
        let emits = transfer.has_emission();
        let ramp = |s: &vr_core::transfer::Segment| {
            let row = |at: &vr_core::transfer::Optical| {
                let [r, g, b] = if emits { at.emission.map(|q| q * unit) } else { at.color };
                [r, g, b, at.opacity]
            };
            let (start, end) = (row(&s.start), row(&s.end));
            let bounded = finite(s.from) && finite(s.to);
            Ramp {
                from: if finite(s.from) { s.from as f32 } else { f32::NEG_INFINITY },
                per_width: if bounded { (1.0 / (s.to - s.from)) as f32 } else { 0.0 },
                start: start.map(|x| x as f32),
                change: std::array::from_fn(|c| if bounded { (end[c] - start[c]) as f32 } else { 0.0 }),
            }
        };
        let per_unit = (unit / transfer.unit_distance()) as f32;
        Some(Self { ramps: segments.iter().map(ramp).collect(), per_unit, rule: transfer.rule(), emits })
    }

    /// Light and opacity of homogeneous pieces of some values and lengths.
    #[inline(always)]
    pub(crate) fn step<S: Simd>(&self, simd: S, value: f32x16<S>, length: f32x16<S>) -> [f32x16<S>; 4] {
        let zero = splat(simd, 0.0);
        let (mut start, mut change, mut t) = ([zero; 4], [zero; 4], zero);
        for ramp in &self.ramps {
            let here = value.simd_ge(splat(simd, ramp.from));
            if !here.any_true() {
                break;
            }
            // A ramp without end is constant.
            let at = if ramp.per_width > 0.0 { (value - ramp.from) * ramp.per_width } else { zero };
            t = pick(here, at, t);
            for c in 0..4 {
                start[c] = pick(here, splat(simd, ramp.start[c]), start[c]);
                change[c] = pick(here, splat(simd, ramp.change[c]), change[c]);
            }
        }
        let t = t.min(splat(simd, 1.0));
        let [r, g, b, alpha] = [0, 1, 2, 3].map(|c| start[c] + change[c] * t);
        let kappa = match self.rule {
            OpacityRule::Extinction => alpha,
            OpacityRule::Power => {
                let opaque = alpha.simd_ge(splat(simd, 1.0));
                pick(opaque, splat(simd, OPAQUE), depth_of_opacity(simd, alpha.max(zero)))
            }
        };
        step_light(simd, [r, g, b, (kappa * self.per_unit).min(splat(simd, OPAQUE))], length, self.emits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use vr_core::ControlPoint;
    use vr_core::phantom::point_transfer_function;

    #[test]
    fn steps_are_those_of_the_transfer_function() {
        let point = |v: f64, a: f64| ControlPoint::new(v, [0.2 + 0.1 * v.min(3.0), 0.5, 1.0 - a], a);
        let jumps = vec![
            point(-1.0, 0.3),
            point(0.5, 0.1),
            point(0.5, 0.9),
            point(0.51, 0.99),
            point(0.6, 0.99),
            point(0.6, 1.0),
            point(2.0, 1.0),
            point(2.0, 0.0),
            point(900.0, 0.8),
        ];
        let glow = |v: f64| ControlPoint { emission: Some([v, 0.1, 0.0]), ..point(v, 0.5) };
        let all = [
            (point_transfer_function("plummer").unwrap().0, OpacityRule::Power),
            (jumps.clone(), OpacityRule::Power),
            (jumps, OpacityRule::Extinction),
            (vec![glow(0.0), glow(2.0)], OpacityRule::Power),
        ];
        for (points, rule) in all {
            let transfer = TransferFunction::new(points, rule, 0.7).unwrap();
            let ramps = Ramps::new(&transfer, 0.3).unwrap();
            for i in 0..4000 {
                let value = (libm::pow(10.0, f64::from(i) / 1000.0 - 1.0) - 1.5) as f32;
                for length in [0.001f32, 0.3, 40.0] {
                    let got = dispatch!(Level::new(), simd => ramps.step(simd, splat(simd, value), splat(simd, length)).map(|x| x.to_array()[7]));
                    let want = transfer.step(f64::from(value), f64::from(length) * 0.3);
                    for c in 0..4 {
                        let error = (f64::from(got[c]) - want[c]).abs();
                        assert!(
                            error < 3e-5 * want[c].abs().max(0.1),
                            "{rule:?} {value} {length}: {got:?} for {want:?}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn what_f32_cannot_tell_apart_has_no_ramps() {
        for [value, opacity] in [[1.0001, 0.5], [1.5, 0.999]] {
            let points = [(1.0, 0.5), (value, opacity), (2.0, 0.5)].map(|(v, a)| ControlPoint::new(v, [1.0; 3], a));
            let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
            assert!(Ramps::new(&transfer, 1.0).is_none());
        }
    }
}
