//! A renderer's own model, solved in f64: the sum over its segments, or the integral of its own medium.

use vr_core::cancel;
use vr_core::{ContinuousModel, Medium, Ray, SegmentTerm};

use crate::nodes::rule;
use crate::transport::{Certainty, Transport};
use vr_core::bound::{Bound, largest};

/// Σ_k b_k Π_{j<k} θ_j, front to back, with the rounding that the sum may have.
pub fn sum_segments(segments: &[SegmentTerm]) -> Transport {
    let (mut radiance, mut transparency, mut size) = ([0.0; 3], 1.0, 0.0f64);
    for term in segments {
        for c in 0..3 {
            radiance[c] += transparency * term.light[c];
        }
        size += transparency * largest(term.light);
        transparency *= term.transparency;
    }
    // One rounding a product and one a sum, each relative to what has been gathered.
    let error = (segments.len() as f64 + 2.0) * f64::EPSILON * (size + 1.0);
    Transport {
        radiance,
        depth: -libm::log(transparency),
        half_way: f64::INFINITY,
        certainty: Certainty::new(if transparency.is_nan() { f64::NAN } else { error }, true),
        pieces: segments.len() as u64,
    }
}

/// Parts of a stretch between breakpoints.
const PARTS: usize = 16;

/// Integrates a medium that a renderer describes.
///
/// The value comes from a rule of degree 16 on every part of every stretch. Where the model bounds its slopes, so is the error: a
/// positive rule that is exact for constants is off by at most the slope times length² on a part. Else the difference from
/// a rule of degree 8 is the estimate.
pub fn integrate_continuous(model: &dyn ContinuousModel, ray: &Ray) -> Transport {
    let breakpoints = model.breakpoints(ray);
    let mut result = Transport {
        radiance: [0.0; 3],
        depth: 0.0,
        half_way: f64::INFINITY,
        certainty: Certainty::Bound(0.0),
        pieces: 0,
    };
    let (mut light_error, mut depth_error, mut certain) = (Bound::ZERO, Bound::ZERO, true);
    for pair in breakpoints.windows(2).filter(|w| w[1] > w[0]) {
        cancel::poll();
        let bounds = model.bounds(ray, pair[0], pair[1]);
        certain &= bounds.is_some();
        for part in 0..PARTS {
            let end = |k: usize| pair[0] + (pair[1] - pair[0]) * k as f64 / PARTS as f64;
            let (from, to) = (end(part), end(part + 1));
            let (depth, light) = stretch(model, ray, from, to, 1);
            let length = to - from;
            let (d_depth, d_light) = match bounds {
                Some(b) => {
                    let d = b.extinction_slope * length * length;
                    let light = largest(light);
                    (d, b.emission_slope * length * length + light * d)
                }
                None => {
                    let (rough, rough_light) = stretch(model, ray, from, to, 0);
                    let d = largest((0..3).map(|c| light[c] - rough_light[c]));
                    ((depth - rough).abs(), d)
                }
            };
            let in_front = libm::exp(-result.depth);
            let brightest = largest(light.map(|x| in_front * x));
            for c in 0..3 {
                result.radiance[c] += in_front * light[c];
            }
            let dimmed = Bound::new(libm::expm1(depth_error.value())) + 32.0 * f64::EPSILON;
            light_error += Bound::new(d_light) * in_front;
            if brightest > 0.0 {
                light_error += dimmed * brightest;
            }
            result.depth += depth;
            depth_error += d_depth;
            if result.depth.is_finite() {
                depth_error += 32.0 * f64::EPSILON * result.depth;
            }
            result.pieces += 1;
        }
    }
    // Behind a wall nothing of the depth's error is left.
    let opacity_error = match result.transmittance() {
        0.0 => Bound::ZERO,
        clear => Bound::new(libm::expm1(depth_error.value())) * clear,
    };
    result.certainty = Certainty::new(light_error.max(opacity_error.min(1.0)) + f64::EPSILON, certain);
    result
}

/// Optical depth and light of one part, by the rule of degree `DEGREES[which]`.
fn stretch(model: &dyn ContinuousModel, ray: &Ray, from: f64, to: f64, which: usize) -> (f64, [f64; 3]) {
    let rule = rule(which);
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let medium: Vec<Medium> = rule.nodes.iter().map(|t| model.medium(ray, middle + half * t)).collect();
    if medium.iter().any(|m| m.extinction == f64::INFINITY) {
        // A wall: nothing comes through, and what it sends its emission does not tell.
        return (f64::INFINITY, [0.0; 3]);
    }
    let dot = |w: &[f64], v: &dyn Fn(usize) -> f64| w.iter().enumerate().map(|(j, w)| w * v(j)).sum::<f64>();
    let tau: Vec<f64> = rule.running.iter().map(|w| half * dot(w, &|j| medium[j].extinction)).collect();
    let light = std::array::from_fn(|c| half * dot(&rule.weights, &|j| medium[j].emission[c] * libm::exp(-tau[j])));
    (tau[tau.len() - 1], light)
}
