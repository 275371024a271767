//! The solver of slabs against published values, closed forms, balances, and two other ways to solve the same equation.

mod closed_forms;
mod diamond_scheme;
mod milne;
mod published;
mod table;

use vr_core::scattering::PhaseFunction;
use vr_light::slab::{Illumination, Layer, Probes, Slab, SlabSolution};

/// Uniform light of flux 1.
const DIFFUSE: Illumination = Illumination::Diffuse { radiance: std::f64::consts::FRAC_1_PI };

/// A beam of flux 1.
fn beam(cosine: f64) -> Illumination {
    Illumination::Beam { cosine, flux: 1.0 }
}

fn lobe(g: f64) -> PhaseFunction {
    PhaseFunction::henyey_greenstein(g).unwrap()
}

fn solve(layers: &[Layer], light: &Illumination, probes: &Probes) -> SlabSolution {
    Slab::new(layers.to_vec()).unwrap().solve(light, probes, 1e-8).unwrap()
}

/// Reflected and transmitted share of the light.
fn shares(layer: &Layer, light: &Illumination) -> [f64; 2] {
    let slab = Slab::new(vec![layer.clone()]).unwrap();
    let solution = slab.solve(light, &Probes::default(), 1e-6).unwrap();
    let [r, t] = [solution.reflected(), solution.transmitted()];
    assert!(r.error.max(t.error) < 1e-6, "{solution:?}");
    let balance = r.value + t.value + solution.absorbed.value;
    assert!((balance - solution.incident).abs() < 1e-9 * solution.incident, "{balance}");
    [r.value / solution.incident, t.value / solution.incident]
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} to {tolerance}");
}
