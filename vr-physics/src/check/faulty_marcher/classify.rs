//! Classification of samples, right and wrong.

use vr_core::filter::Reconstruction;
use vr_core::transfer::Optical;
use vr_core::{Sampler, TransferFunction, Voxel};

use super::fault::Fault;

/// Optics of a value.
pub(super) fn classified(fault: Fault, transfer: &TransferFunction, value: f64) -> Optical {
    match fault {
        Fault::BleedingJumps => bled(transfer, value),
        Fault::NarrowValues => transfer.at(narrow(value)),
        _ => transfer.at(value),
    }
}

/// A number of 12 binary digits.
fn narrow(value: f64) -> f64 {
    let scale = libm::exp2(libm::floor(libm::log2(value.abs().max(f64::MIN_POSITIVE))) - 11.0);
    (value / scale).round() * scale
}

/// Linear between the entries of a table of 64, whatever lies between them.
fn bled(transfer: &TransferFunction, value: f64) -> Optical {
    const ENTRIES: f64 = 64.0;
    let points = transfer.points();
    let (low, high) = (points[0].value, points[points.len() - 1].value);
    let width = 1.2 * (high - low).max(1e-3 * low.abs()).max(f64::MIN_POSITIVE) / ENTRIES;
    let place = (value - low) / width;
    let below = place.floor();
    let (a, b) = (transfer.at(low + below * width), transfer.at(low + (below + 1.0) * width));
    let t = place - below;
    let mix = |a: f64, b: f64| a + t * (b - a);
    // Opacity as an extinction of 1 is: any share of an opaque entry is opaque, in whatever colour.
    let opacity = if a.opacity == 1.0 || b.opacity == 1.0 { 1.0 } else { mix(a.opacity, b.opacity) };
    Optical {
        opacity,
        color: std::array::from_fn(|c| mix(a.color[c], b.color[c])),
        emission: std::array::from_fn(|c| mix(a.emission[c], b.emission[c])),
    }
}

/// The mean of what the corners of a cell are classified as, each weighted as trilinear interpolation weights its value.
pub(super) fn classified_before<T: Voxel, F: Reconstruction>(
    sampler: &Sampler<'_, T, F>,
    p: [f64; 3],
    classify: impl Fn(f64) -> Optical,
) -> Optical {
    let dims = sampler.lattice().dims;
    let mut mean = Optical::default();
    for corner in 0..8 {
        let (mut at, mut weight) = ([0.0; 3], 1.0);
        for axis in 0..3 {
            let low = p[axis].floor().clamp(0.0, (dims[axis] - 2) as f64);
            let t = p[axis] - low;
            (at[axis], weight) =
                if corner >> axis & 1 == 1 { (low + 1.0, weight * t) } else { (low, weight * (1.0 - t)) };
        }
        let optical = classify(sampler.value(at));
        mean.opacity += weight * optical.opacity;
        for c in 0..3 {
            mean.color[c] += weight * optical.color[c];
            mean.emission[c] += weight * optical.emission[c];
        }
    }
    mean
}
