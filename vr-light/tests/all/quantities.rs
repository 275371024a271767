//! Fluence, flux and the balance of energy against what is known in closed form. Single comparisons are allowed 4 standard errors.

use std::sync::Arc;

use glam::DVec3;
use vr_core::Control;
use vr_core::scattering::PhaseFunction;
use vr_light::quantities::{EnergyBalance, Estimate, fluence, flux};
use vr_light::*;

const PI: f64 = std::f64::consts::PI;

fn square(z: f64) -> Shape {
    Shape::Parallelogram { corner: DVec3::new(0.0, 0.0, z), edges: [DVec3::X, DVec3::Y] }
}

/// Form factor of two unit squares that face each other at the distance 1/w (Howell, "A catalog of radiation heat transfer configuration factors", C-11).
fn form_factor(w: f64) -> f64 {
    let root = (1.0 + w * w).sqrt();
    2.0 / (PI * w * w)
        * (((1.0 + w * w).powi(2) / (1.0 + 2.0 * w * w)).ln() * 0.5 + 2.0 * w * root * (w / root).atan()
            - 2.0 * w * w.atan())
}

#[test]
fn parallel_patches_exchange_the_form_factor() {
    assert!((form_factor(1.0) - 0.199_824_9).abs() < 1e-6);
    for distance in [0.5, 1.0, 3.0] {
        let lamp = Surface::emitter(square(0.0), Spectrum::grey(2.0));
        let scene = LightScene::new(None, 1).unwrap().with_surfaces(vec![lamp]).unwrap();
        let through = flux(&scene, &square(distance), false, 200_000, 3, &Control::default()).unwrap()[0];
        let expected = 2.0 * PI * form_factor(1.0 / distance);
        assert!(through.is_within(expected, 4.0), "{through:?} for {expected}");
        let back = flux(&scene, &square(distance), true, 1000, 3, &Control::default()).unwrap()[0];
        assert_eq!(back.mean, 0.0, "nothing comes from beyond");
    }
}

#[test]
fn lights_without_size_shine_through_faces() {
    // From above the middle of a large face, half of all power goes down; the sun's goes through by the cosine.
    let lamp = LightSource::Point { at: DVec3::new(0.0, 0.0, 1.0), color: Spectrum::grey(1.0) };
    let sun = LightSource::Directional { towards: DVec3::new(3.0, 0.0, 4.0), color: Spectrum::grey(1.0) };
    let face = |half: f64| Shape::Parallelogram {
        corner: DVec3::new(-half, -half, 0.0),
        edges: [2.0 * half * DVec3::X, 2.0 * half * DVec3::Y],
    };
    let through = |light, half| {
        let scene = LightScene::new(None, 1).unwrap().with_lights(vec![light]).unwrap();
        flux(&scene, &face(half), true, 100_000, 1, &Control::default()).unwrap()[0]
    };
    // Solid angle of a square of half an edge a at the distance 1: 4 atan(a² / √(1 + 2a²)), times π L.
    let solid = 4.0 * (1.0 / 3f64.sqrt()).atan();
    let lamp = through(lamp, 1.0);
    assert!(lamp.is_within(PI * solid, 4.0), "{lamp:?} for {}", PI * solid);
    assert!(through(sun, 1.0).is_within(PI * 0.8 * 4.0, 4.0));
}

#[test]
fn fluence_in_a_furnace_is_that_of_its_radiance() {
    let glow = Coefficients { absorption: 1.0, scattering: 2.0, emission: 0.75 };
    let medium = Homogeneous::new((DVec3::ZERO, DVec3::ONE), vec![glow; 2], PhaseFunction::Isotropic).unwrap();
    let scene = LightScene::new(Some(Arc::new(medium)), 2).unwrap();
    let scene = scene.with_environment(Environment::from([0.75])).unwrap();
    for estimate in fluence(&scene, DVec3::splat(0.4), 20_000, 1, &Control::default()).unwrap() {
        assert!(estimate.is_within(4.0 * PI * 0.75, 4.0), "{estimate:?}");
    }
}

/// A cube of a medium whose second band takes a part of the light of the first, over a glossy plate, beside a lamp.
fn room() -> LightScene {
    let bands = [0.5, 2.0].map(|absorption| Coefficients { absorption, scattering: 3.0, emission: 0.1 });
    let phase = PhaseFunction::henyey_greenstein(0.5).unwrap();
    let matrix = BandMatrix::new(vec![vec![0.75, 0.25], vec![0.0, 1.0]]).unwrap();
    let medium = Homogeneous::new((DVec3::ZERO, DVec3::ONE), bands.to_vec(), phase).unwrap();
    let scene = LightScene::new(Some(Arc::new(medium.with_band_matrix(matrix).unwrap())), 2).unwrap();
    let gloss = Reflection::Phong { reflectance: Spectrum::grey(0.9), exponent: 20.0 };
    let plate = Surface { shape: square(-0.5), emission: Spectrum::black(), reflection: gloss };
    let lamp = Surface {
        shape: Shape::Sphere { centre: DVec3::new(0.5, 0.5, 2.0), radius: 0.2 },
        emission: Spectrum::new(vec![1.0, 0.2]),
        reflection: Reflection::Lambertian(Spectrum::grey(0.4)),
    };
    let point = LightSource::Point { at: DVec3::new(2.0, 0.0, 0.5), color: Spectrum::grey(0.3) };
    scene.with_surfaces(vec![plate, lamp]).unwrap().with_lights(vec![point]).unwrap()
}

#[test]
fn energy_is_kept() {
    let balance = EnergyBalance::new(&room(), 100_000, 2, &Control::default()).unwrap();
    // 4π q V of two bands; 2π E A of a sphere, whose inner side emits as well; 4π² L of the point.
    let lamp = 2.0 * PI * 1.2 * 4.0 * PI * 0.04;
    let expected = 4.0 * PI * 0.2 + lamp + 4.0 * PI * PI * 0.6;
    assert!(balance.emitted.is_within(expected, 4.0), "{balance:?} for {expected}");
    assert!(balance.is_closed(3.0) && balance.escaped.mean > 0.0 && balance.absorbed.mean > 0.0);
}

#[test]
fn light_followed_forwards_is_that_followed_backwards() {
    // Power absorbed in the cube by packets, and ∫ κ fluence dV by paths from random places.
    let scene = room();
    let forwards = EnergyBalance::new(&scene, 400_000, 7, &Control::default()).unwrap().absorbed;
    let mut random = RandomStream::new(5, 0, 0);
    let backwards: Estimate = (0..2000)
        .map(|place| {
            let at = DVec3::new(random.uniform(), random.uniform(), random.uniform());
            let bands = fluence(&scene, at, 16, place, &Control::default()).unwrap();
            0.5 * bands[0].mean + 2.0 * bands[1].mean
        })
        .collect();
    let error = forwards.standard_error.hypot(backwards.standard_error);
    assert!((forwards.mean - backwards.mean).abs() < 4.0 * error, "{forwards:?} {backwards:?}");
    assert!(error < 0.02 * forwards.mean);
}

#[test]
fn sources_without_end_are_refused() {
    let sun = LightSource::Directional { towards: DVec3::X, color: Spectrum::grey(1.0) };
    let scene = LightScene::new(None, 1).unwrap().with_lights(vec![sun]).unwrap();
    assert!(EnergyBalance::new(&scene, 10, 0, &Control::default()).is_err());
    let plane = Shape::Plane { point: DVec3::ZERO, normal: DVec3::X };
    assert!(flux(&scene, &plane, false, 10, 0, &Control::default()).is_err());
}
