//! The reference against what can be integrated on paper.

use std::sync::Arc;

use glam::DVec3;
use vr_core::field::{FunctionField, FunctionLine};
use vr_core::phantom::{Phantom, SheppLogan};
use vr_core::{
    Camera, ControlPoint, OpacityRule, Placement, Projection, Ray, Scene, TransferFunction, UniformGrid, View, Volume,
};
use vr_physics::{Certainty, Optics, Reference, Transport, transport};

/// A field that is the ramp z/(n − 1) from 0 to 1, with `n` samples of spacing `h` along z; exact for n = 2ᵏ + 1.
fn ramp(n: usize, h: f64) -> Volume {
    let samples: Vec<f32> = (0..n).flat_map(|z| [z as f32 / (n - 1) as f32; 4]).collect();
    UniformGrid::new([2, 2, n], samples, Placement::from_spacing([1.0, 1.0, h]).unwrap(), Default::default())
        .unwrap()
        .into()
}

fn point(value: f64, opacity: f64, color: [f64; 3], emission: Option<[f64; 3]>) -> ControlPoint {
    ControlPoint { emission, ..ControlPoint::new(value, color, opacity) }
}

/// Along +z through the ramp, which the ray meets in the order of rising values.
fn along_z(volume: Volume, points: Vec<ControlPoint>, rule: OpacityRule, unit: f64) -> Transport {
    let scene = Scene::new(volume, TransferFunction::new(points, rule, unit).unwrap());
    let camera = Camera {
        eye: DVec3::new(0.3, 0.6, -5.0),
        target: DVec3::new(0.3, 0.6, 0.0),
        up: DVec3::Y,
        projection: Projection::Orthographic { height: 1.0 },
    };
    let view = View::new(camera, [1, 1]);
    let ray = Ray { origin: camera.eye, direction: DVec3::Z };
    Reference::default().transport(&scene, &view, &ray).unwrap().expect("the ray meets the volume")
}

fn check(name: &str, t: &Transport, radiance: f64, depth: f64) {
    let Certainty::Bound(bound) = t.certainty else { panic!("{name}: {:?} is no bound", t.certainty) };
    let scale = radiance.abs().max(1.0);
    assert!(bound <= 1e-10 * scale, "{name}: bound {bound:e}");
    let error = (t.radiance[0] - radiance).abs().max((t.opacity() - -(-depth).exp_m1()).abs());
    assert!(error <= bound + 2e-16 * scale, "{name}: error {error:e}, bound {bound:e}");
}

#[test]
fn homogeneous_slab() {
    for (alpha, unit) in [(0.3, 1.0), (1e-12, 0.5), (0.999_999, 3.0), (0.01, 1e-3)] {
        let t = along_z(ramp(7, 1.7), vec![point(0.0, alpha, [0.8; 3], None)], OpacityRule::Power, unit);
        let tau = -f64::ln_1p(-alpha) / unit * 6.0 * 1.7;
        check(&format!("slab α = {alpha}"), &t, 0.8 * -(-tau).exp_m1(), tau);
    }
}

#[test]
fn linear_extinction_with_constant_emission() {
    // κ = a + (b − a) z/L, q = 2: 2 ∫ exp(−a s − m s²/2) ds in error functions.
    let (a, b, length, q) = (0.2, 0.9, 12.0, 2.0);
    let points = vec![point(0.0, a, [0.0; 3], Some([q; 3])), point(1.0, b, [0.0; 3], Some([q; 3]))];
    let t = along_z(ramp(17, 0.75), points, OpacityRule::Extinction, 1.0);
    let m = (b - a) / length;
    let root = f64::sqrt(m / 2.0);
    let erf = |s: f64| libm::erf(root * s + a / f64::sqrt(2.0 * m));
    let integral = f64::sqrt(std::f64::consts::PI / (2.0 * m)) * f64::exp(a * a / (2.0 * m)) * (erf(length) - erf(0.0));
    check("linear κ, constant q", &t, q * integral, a * length + 0.5 * m * length * length);
}

#[test]
fn linear_extinction_with_constant_color() {
    // I = c (1 − e^(−τ)) whatever κ does.
    let points = vec![point(0.0, 0.1, [0.6; 3], None), point(1.0, 0.8, [0.6; 3], None)];
    let t = along_z(ramp(9, 0.5), points, OpacityRule::Extinction, 1.0);
    let tau: f64 = 0.45 * 4.0;
    check("linear κ, constant c", &t, 0.6 * -(-tau).exp_m1(), tau);
}

#[test]
fn pure_emission_and_pure_absorption() {
    let points = vec![point(0.0, 0.0, [0.0; 3], Some([1.0; 3])), point(1.0, 0.0, [0.0; 3], Some([4.0; 3]))];
    check("emission", &along_z(ramp(5, 2.0), points, OpacityRule::Power, 1.0), 2.5 * 8.0, 0.0);
    let points = vec![point(0.0, 0.0, [0.0; 3], None), point(1.0, 0.7, [0.0; 3], None)];
    // ∫₀¹ −ln(1 − 0.7 x) dx = 1 + (0.3/0.7) ln 0.3
    let mean = 1.0 + 0.3 / 0.7 * f64::ln(0.3);
    check("absorption", &along_z(ramp(5, 2.0), points, OpacityRule::Power, 1.0), 0.0, 8.0 * mean);
}

#[test]
fn a_ramp_of_opacity_to_one_over_one_unit_has_depth_one() {
    for n in [2, 5, 65] {
        let points = vec![point(0.0, 0.0, [0.5; 3], None), point(1.0, 1.0, [0.5; 3], None)];
        let t = along_z(ramp(n, 3.0), points, OpacityRule::Power, 3.0 * (n - 1) as f64);
        check("ramp to 1", &t, 0.5 * -(-1.0f64).exp_m1(), 1.0);
    }
}

#[test]
fn opaque_wall_behind_fog() {
    // Fog of κ = −ln 0.9 up to the value 0.5, then a wall of another colour.
    let fog = [0.2; 3];
    let points = vec![
        point(0.0, 0.1, fog, None),
        point(0.5, 0.1, fog, None),
        point(0.5, 1.0, [0.9; 3], None),
        point(1.0, 1.0, [0.9; 3], None),
    ];
    let t = along_z(ramp(9, 1.25), points, OpacityRule::Power, 1.0);
    let through = f64::powf(0.9, 5.0);
    check("wall", &t, 0.2 * (1.0 - through) + 0.9 * through, f64::INFINITY);
    // The fog alone has opacity 0.41 there: it is the wall that passes one half.
    // s = 0 is the middle of the box, where the wall stands.
    assert!(t.half_way.abs() < 1e-12);
}

#[test]
fn shepp_logan_line_integrals() {
    let phantom = Arc::new(SheppLogan::new());
    let field = FunctionField::of_phantom(phantom.clone()).with_lipschitz(phantom.lipschitz_between_breakpoints());
    let points = vec![point(-1.0, 0.0, [0.0; 3], Some([0.0; 3])), point(3.0, 0.0, [0.0; 3], Some([4.0; 3]))];
    let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
    let mut state = 1u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    };
    for i in 0..200 {
        let target = DVec3::new(random(), random(), random()) * 0.8;
        let direction = DVec3::new(random(), random(), random()).normalize();
        let ray = Ray { origin: target - 3.0 * direction, direction };
        let line = FunctionLine::new(&field, ray, 0.0, 6.0);
        let t = transport(&line, &Optics::new(&transfer, None), 1e-11, 1.0);
        // Emission is value + 1.
        let exact = phantom.line_integral(ray.origin, ray.direction) + 6.0;
        let Certainty::Bound(bound) = t.certainty else { panic!("ray {i}: {:?}", t.certainty) };
        let error = (t.radiance[0] - exact).abs();
        assert!(error <= bound && bound <= 1e-10 * exact.max(1.0), "ray {i}: error {error:e}, bound {bound:e}");
    }
    assert!(phantom.value(DVec3::ZERO) >= 0.0);
}

#[test]
fn incoming_light_is_a_boundary_condition() {
    let t = along_z(ramp(3, 1.0), vec![point(0.0, 0.5, [1.0; 3], None)], OpacityRule::Power, 1.0);
    let lit = t.with_incoming([4.0, 0.0, 0.0]);
    assert!((lit[0] - (0.75 + 4.0 * 0.25)).abs() < 1e-15 && (lit[1] - 0.75).abs() < 1e-15);
}
