//! Step of a ray, with a bound of its error.
//!
//! A step takes the radiance B behind it to light + (1 − A)·B. What it is off by is told as two numbers that do not depend on B:
//! `opacity_error` bounds |Â − A|, and `light_error` bounds what is wrong with the light *apart* from that, so that the whole error is
//! at most light_error + opacity_error·M for any B in [0, M], where M also bounds the source of a density emitter. (For those the
//! light is source·A: an opacity too large adds source·δ and takes B·δ away, and both are at most M.)

use vr_core::Real;
use vr_core::optics::source_weight;

use super::cubic::Cubic;
use super::depth::{Depth, Rate, Transparency};
use super::optics::{Extremes, Optics, Piece};

/// Step of a ray, with bounds of its errors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Step {
    /// World length.
    pub(super) length: f64,
    /// Opacity 1 − e^(−τ).
    pub(super) opacity: f64,
    /// Light at its front.
    pub(super) light: [f64; 3],
    /// Bound on the error of `opacity`.
    pub(super) opacity_error: f64,
    /// Bound on the error of `light` that is not the opacity's.
    pub(super) light_error: f64,
    /// Largest difference between two sources in the step: the cost per opacity of a cut inside it.
    pub(super) variation: f64,
    /// Sum of the parts of the two errors that shorter steps would not make smaller: rounding.
    pub(super) rounding: [f64; 2],
}

impl Step {
    /// Returns the largest component of the light.
    #[inline]
    pub(super) fn brightest(&self) -> f64 {
        self.light.into_iter().fold(0.0, f64::max)
    }
}

/// Rounding of one step in f64: a few operations.
pub(super) const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Returns 1 − e^(−τ) for any τ up to +∞.
#[inline]
pub(super) fn opacity(tau: f64) -> f64 {
    -libm::expm1(-tau)
}

/// Returns the step through a medium of which only the extremes are known: the middle, and half the width. `deepest` bounds its optical depth
/// where the extremes do not.
pub(super) fn coarse(optics: &Optics, extremes: &Extremes, length: f64, deepest: f64) -> Step {
    let per_rate = length / optics.unit;
    let depth = [per_rate * extremes.rate[0], (per_rate * extremes.rate[1]).min(deepest)];
    // 0 · ∞: a point of an opaque medium.
    let depth = depth.map(|d| if d.is_nan() { 0.0 } else { d });
    let [min_opacity, max_opacity] = depth.map(opacity);
    let middle = 0.5 * (min_opacity + max_opacity);
    let opacity_error = 0.5 * (max_opacity - min_opacity) + ROUNDING * max_opacity;
    let (mut light, mut light_error) = ([0.0; 3], 0.0f64);
    for (light, [low, high]) in light.iter_mut().zip(extremes.source) {
        if optics.emits {
            let range = [low * length * source_weight(depth[1]), high * length * source_weight(depth[0])];
            *light = 0.5 * (range[0] + range[1]);
            light_error = light_error.max(0.5 * (range[1] - range[0]) + ROUNDING * range[1]);
        } else {
            *light = 0.5 * (low + high) * middle;
            light_error = light_error.max((0.5 * (high - low) + ROUNDING * high) * max_opacity);
        }
    }
    let variation = extremes.source_width();
    Step { length, opacity: middle, light, opacity_error, light_error, variation, rounding: [0.0; 2] }
}

/// Returns the step through one stored number.
pub(super) fn constant(optics: &Optics, rate: f64, source: [f64; 3], length: f64) -> Step {
    let depth = rate * length / optics.unit;
    let a = opacity(depth);
    let factor = if optics.emits { length * source_weight(depth) } else { a };
    let light = source.map(|s| s * factor);
    let brightest = light.into_iter().fold(0.0, f64::max);
    Step {
        length,
        opacity: a,
        light,
        opacity_error: ROUNDING * a,
        light_error: ROUNDING * brightest,
        ..Step::default()
    }
}

/// Returns the step along a cubic that lies in one piece of the transfer function, by power series about its middle; `None` where they do not
/// converge well enough to say anything.
///
/// `base` is what the cubic's values are reckoned from; `noise` bounds how far they are off. Where a cruder estimate misses no more than
/// `enough`, it will do. See the README beside this file for the series and their remainders.
pub(super) fn smooth<R: Real>(
    optics: &Optics,
    piece: &Piece,
    cubic: &Cubic<R>,
    base: f64,
    noise: f64,
    length: f64,
    enough: f64,
) -> Option<Step> {
    let real = R::from_f64;
    let u = 2.0 * R::ROUNDOFF;
    let c = cubic.about_middle();
    let depth = Depth::new(optics, Rate::along(optics, piece, &c, base, noise)?, length)?;
    let source = piece.source_at(base + c[0].to_f64());
    let steep = piece.source_steepness();
    let spread = c[1].abs().to_f64() + c[2].abs().to_f64() + c[3].abs().to_f64();
    let source_off = 5.0 * piece.steepest_source * noise;
    let brightest = source.iter().fold(0.0f64, |m, s| m.max(s.abs()));
    let mut step = depth.step;
    step.variation = 2.0 * (steep * spread + source_off);
    step.rounding[1] = source_off * if optics.emits { length } else { step.opacity };
    // The source at the middle stands for all of it.
    let plain = |mut step: Step| {
        step.light = source.map(|s| (s * step.opacity).max(0.0));
        step.light_error = (steep * spread + source_off + 4.0 * u * brightest) * step.opacity;
        step
    };
    if !optics.emits && (steep == 0.0 || steep * spread * step.opacity <= enough) {
        return Some(plain(step));
    }
    let Some(inside) = Transparency::inside(&depth) else {
        return (!optics.emits).then(|| plain(step));
    };
    let (c1, c2, c3) = (c[1], c[2], c[3]);
    let (third, fifth, seventh) = (real(1.0 / 3.0), real(0.2), real(1.0 / 7.0));
    if optics.emits {
        let [p1, p2, p3] = inside.p;
        let even = (inside.first * (R::ONE + p2 * third)).to_f64();
        let odd = c1 * (p1 * third + p3 * fifth) + c2 * (third + p2 * fifth) + c3 * (p1 * fifth + p3 * seventh);
        let odd = (inside.first * odd).to_f64();
        step.light = std::array::from_fn(|i| (length * (source[i] * even + piece.source_slope[i] * odd)).max(0.0));
        step.light_error = length * ((brightest + steep * spread) * (inside.missed + inside.scaled) + source_off);
        return Some(step);
    }
    let (g, left_out) = inside.absorbed(&depth);
    let weight =
        c1 * (g[1] * third + g[3] * fifth) + c2 * (g[0] * third + g[2] * fifth) + c3 * (g[1] * fifth + g[3] * seventh);
    let weight = depth.per_rate * (inside.first * weight).to_f64();
    // |c₁t + c₂t² + c₃t³| ≤ spread·|t|, whose mean is ½.
    let light_error = depth.per_rate * steep * spread * (0.5 * left_out + 8.0 * u * depth.rate.size())
        + (source_off + 4.0 * u * brightest) * step.opacity;
    let crude = plain(step);
    if light_error >= crude.light_error {
        return Some(crude);
    }
    step.light = std::array::from_fn(|i| (source[i] * step.opacity + piece.source_slope[i] * weight).max(0.0));
    step.light_error = light_error;
    Some(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_bound::seeded::runner;
    use proptest::prelude::*;
    use vr_core::{Calibration, ControlPoint, OpacityRule, TransferFunction};

    /// Returns opacity and light of a step by 4000 midpoints: good to 10⁻⁸ or so on these smooth functions.
    fn exact(optics: &Optics, piece: &Piece, cubic: &Cubic<f64>, length: f64) -> (f64, [f64; 3]) {
        const N: usize = 4000;
        let (mut depth, mut light) = (0.0f64, [0.0; 3]);
        for i in 0..N {
            let f = cubic.at((i as f64 + 0.5) / N as f64);
            let tau = length / N as f64 / optics.unit * optics.rate(piece.opacity_at(f), piece.clearness_at(f));
            let weight =
                if optics.emits { length / N as f64 * source_weight(tau) } else { opacity(tau) } * libm::exp(-depth);
            for (sum, s) in light.iter_mut().zip(piece.source_at(f)) {
                *sum += s * weight;
            }
            depth += tau;
        }
        (opacity(depth), light)
    }

    /// Errors of many random steps, each as a fraction of its bound (opacity and light).
    fn ratios<R: Real>(of: impl Fn(&Optics, &Piece, &Cubic<R>, f64) -> Option<(Step, Step)>) -> Vec<[f64; 2]> {
        let coefficient = || 0.02f64..0.98;
        let strategy = (
            [coefficient(), coefficient(), coefficient(), coefficient()],
            [0.0f64..0.95, 0.0f64..0.95],
            [[0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0], [0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0]],
            (any::<bool>(), any::<bool>(), 0.01f64..3.0, 0.0f64..1.0),
        );
        let found = std::cell::RefCell::new(Vec::new());
        let run = runner(3000, 7).run(&strategy, |(b, alpha, color, (power, emits, length, flat))| {
            let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
            let point = |i: usize| ControlPoint {
                emission: emits.then_some(color[i]),
                ..ControlPoint::new(i as f64, color[i], alpha[i])
            };
            let transfer = TransferFunction::new(vec![point(0), point(1)], rule, 1.0).unwrap();
            let optics = Optics::new(&transfer, Calibration::default(), 1.0);
            let piece = optics.piece_at(0.5);
            // From wild to nearly flat: the smaller, the more the leading terms count.
            let b = b.map(|x| 0.5 + (x - 0.5) * flat * flat);
            let cubic = Cubic(b);
            let rounded = Cubic(b.map(R::from_f64));
            if let Some((estimate, bound)) = of(&optics, piece, &rounded, length) {
                let (a, light) = exact(&optics, piece, &cubic, length);
                let max_light = if optics.emits { 0.0 } else { 1.0 };
                let off = (0..3).map(|c| (estimate.light[c] - light[c]).abs()).fold(0.0, f64::max);
                let slack = 3e-7;
                found.borrow_mut().push([
                    ((estimate.opacity - a).abs() - slack).max(0.0) / bound.opacity_error.max(1e-12),
                    (off - slack).max(0.0) / (bound.light_error + max_light * bound.opacity_error).max(1e-12),
                ]);
            }
            Ok(())
        });
        run.unwrap();
        found.into_inner()
    }

    fn noise<R: Real>() -> f64 {
        4.0 * R::ROUNDOFF
    }

    fn holds<R: Real>() {
        let all = ratios::<R>(|o, p, c, l| smooth(o, p, c, 0.0, noise::<R>(), l, 0.0).map(|s| (s, s)));
        assert!(all.len() > 2000, "{}", all.len());
        let worst = |i: usize| all.iter().map(|r| r[i]).fold(0.0, f64::max);
        println!("{}: {} steps, worst share of the bound {:.2} and {:.2}", R::NAME, all.len(), worst(0), worst(1));
        assert!(worst(0) <= 1.0 && worst(1) <= 1.0);
        // And is no bound for its own sake: some steps use a good part of it.
        assert!(worst(0) > 0.05 && worst(1) > 0.05);
    }

    #[test]
    fn smooth_steps_keep_their_bounds() {
        holds::<f64>();
        holds::<f32>();
    }

    #[test]
    fn a_left_out_term_breaks_the_bound() {
        // What a value at the middle alone gives, with the bound of the whole series.
        let crude = |o: &Optics, p: &Piece, c: &Cubic<f64>, l: f64| {
            let bound = smooth(o, p, c, 0.0, noise::<f64>(), l, 0.0)?;
            let f = c.about_middle()[0];
            Some((constant(o, o.rate(p.opacity_at(f), p.clearness_at(f)), p.source_at(f), l), bound))
        };
        let all = ratios::<f64>(crude);
        let broken = |i: usize| all.iter().filter(|r| r[i] > 1.0).count();
        assert!(
            broken(0) > all.len() / 10 && broken(1) > all.len() / 10,
            "{} {} of {}",
            broken(0),
            broken(1),
            all.len()
        );
    }

    #[test]
    fn coarse_steps_hold_whatever_the_order_of_values() {
        let points = vec![
            ControlPoint::new(0.0, [0.1, 0.5, 0.9], 0.0),
            ControlPoint::new(0.5, [0.9, 0.5, 0.0], 0.7),
            ControlPoint::new(1.0, [0.2, 0.3, 0.4], 0.2),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let optics = Optics::new(&transfer, Calibration::default(), 1.0);
        let extremes = optics.extremes(0.2, 0.9);
        let step = coarse(&optics, &extremes, 2.0, f64::INFINITY);
        for pair in [[0.2, 0.9], [0.9, 0.2], [0.5, 0.5], [0.5, 0.2], [0.3, 0.8]] {
            let halves = pair.map(|v| {
                let (rate, source) = optics.exactly(v);
                constant(&optics, rate, source, 1.0)
            });
            for behind in [0.0, 1.0] {
                let through = |s: &Step, b: [f64; 3]| -> [f64; 3] {
                    std::array::from_fn(|c| s.light[c] + (1.0 - s.opacity) * b[c])
                };
                let want = through(&halves[0], through(&halves[1], [behind; 3]));
                let got = through(&step, [behind; 3]);
                for c in 0..3 {
                    assert!((got[c] - want[c]).abs() <= step.light_error + step.opacity_error + 1e-15, "{pair:?}");
                }
            }
        }
    }
}
