//! Exposure: the factor on all opacities at which what is visible has a given mean opacity.

use glam::DVec3;
use vr_core::Camera;
use vr_core::optics::opacity_of_depth;
use vr_core::parallel::collect;

use crate::lattice::Lattice;

/// Rays along each side of the picture that is solved for.
const RAYS: usize = 48;
/// Steps of a ray.
const STEPS: usize = 192;
/// A ray of less than this part of the thickest is not visible.
const FAINT: f64 = 0.01;

/// The factor on extinctions `shares / unit` at which the mean opacity of the visible rays of an oblique view is `target`; `share` gives the
/// share of a place of the lattice. `None` where nothing is visible.
pub(crate) fn solve(lattice: &Lattice, unit: f64, target: f64, share: impl Fn(usize) -> f64 + Sync) -> Option<f64> {
    let depths = depths(lattice, unit, share);
    let thickest = depths.iter().fold(0.0, |a: f64, &b| a.max(b));
    let visible: Vec<f64> = depths.into_iter().filter(|&d| d > FAINT * thickest).collect();
    if visible.is_empty() {
        return None;
    }
    let mean = |factor: f64| visible.iter().map(|&d| opacity_of_depth(factor * d)).sum::<f64>() / visible.len() as f64;
    // Bisection of the exponent: the mean grows with the factor, from 0 to 1.
    let (mut low, mut high) = (-60.0, 60.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if mean(libm::exp(middle) / thickest) < target { low = middle } else { high = middle }
    }
    Some(libm::exp(0.5 * (low + high)) / thickest)
}

/// Optical depths of rays over the whole picture, for a factor of 1.
fn depths(lattice: &Lattice, unit: f64, share: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
    let corners = lattice.corners();
    let (low, high) = corners.iter().fold((corners[0], corners[0]), |(l, h), &c| (l.min(c), h.max(c)));
    let radius = (0.5 * (high - low).length()).max(f64::MIN_POSITIVE);
    let camera = Camera::framing((low, high), 30.0, 20.0, None);
    let Ok(frame) = camera.frame() else { return Vec::new() };
    let inverse = lattice.axes.inverse();
    let step = 2.0 * radius / STEPS as f64;
    let at = |i: usize, n: usize| (2.0 * (i as f64 + 0.5) / n as f64 - 1.0) * radius;
    let ray = |i: usize| {
        let start = camera.target + frame * DVec3::new(at(i % RAYS, RAYS), at(i / RAYS, RAYS), 0.0);
        let places = (0..STEPS).filter_map(|s| lattice.nearest(inverse, start + frame.z_axis * at(s, STEPS)));
        places.map(&share).sum::<f64>() * step / unit
    };
    collect(RAYS * RAYS, ray)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid};

    #[test]
    fn a_cube_of_one_value_gets_the_mean_opacity() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([16; 3], vec![1.0f32; 4096], placement, Calibration::default()).unwrap();
        let lattice = Lattice::new(&grid.into());
        let factor = solve(&lattice, 1.0, 0.6, |_| 1.0).unwrap();
        let depths = depths(&lattice, 1.0, |_| 1.0);
        let met: Vec<f64> = depths.into_iter().filter(|&d| d > 0.0).collect();
        let mean = met.iter().map(|d| 1.0 - (-factor * d).exp()).sum::<f64>() / met.len() as f64;
        assert!((mean - 0.6).abs() < 0.02, "{mean}");
        assert_eq!(solve(&lattice, 1.0, 0.6, |_| 0.0), None);
    }
}
