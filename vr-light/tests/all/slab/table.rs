//! Reflectance and transmittance of 72 slabs, each by a second method.

use vr_core::scattering::PhaseFunction;
use vr_light::slab::Layer;

use super::{DIFFUSE, beam, diamond_scheme, lobe, milne, shares};

const ALBEDOS: [f64; 6] = [0.2, 0.5, 0.8, 0.95, 0.99, 1.0];
const THICKNESSES: [f64; 6] = [0.1, 0.5, 2.0, 8.0, 16.0, 32.0];

/// Both lights: reflected and transmitted.
fn solved(thickness: f64, albedo: f64, phase: &PhaseFunction) -> [[f64; 2]; 2] {
    let layer = Layer::new(thickness, albedo, phase.clone());
    [shares(&layer, &DIFFUSE), shares(&layer, &beam(1.0))]
}

fn max_difference(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn isotropic_slabs_agree_with_milnes_equation() {
    let mut max = 0.0f64;
    for albedo in ALBEDOS {
        for thickness in THICKNESSES {
            let here = solved(thickness, albedo, &PhaseFunction::Isotropic);
            let (there, change) = milne::isotropic_slab(thickness, albedo);
            let difference = max_difference(here, there);
            max = max.max(difference);
            // Thick slabs have coarse cells: half of the last change is left there.
            assert!(difference < 1e-6 + 0.5 * change, "albedo {albedo}, thickness {thickness}: {here:?}, {there:?}");
        }
    }
    println!("largest difference {max:.1e}");
}

#[test]
fn lobes_agree_with_the_diamond_scheme() {
    let mut max = 0.0f64;
    for albedo in ALBEDOS {
        for thickness in THICKNESSES {
            let (here, there) =
                (solved(thickness, albedo, &lobe(0.75)), diamond_scheme::slab(thickness, albedo, &lobe(0.75)));
            let difference = max_difference(here, there);
            max = max.max(difference);
            assert!(difference < 1e-5, "albedo {albedo}, thickness {thickness}: {here:?}, {there:?}");
        }
    }
    println!("largest difference {max:.1e}");
}
