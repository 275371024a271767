//! Single scattering against closed forms, and against sums over fine steps.

use glam::DVec3;
use vr_core::field::FunctionField;
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::*;
use vr_light::single::{RayLight, SingleScattering};
use vr_physics::{Certainty, Reference};

const TOLERANCE: f64 = 1e-7;

/// A box of fog from the origin to (2, 2, 2) with this extinction, under these lights.
fn fog(extinction: f64, color: [f64; 3], lights: Vec<Light>) -> Scene {
    let placement = Placement::from_spacing([2.0; 3]).unwrap();
    let grid = UniformGrid::new([2; 3], vec![1u8; 8], placement, Calibration::default()).unwrap();
    let point = ControlPoint::new(1.0, color, 1.0);
    let transfer = TransferFunction::new(vec![point], OpacityRule::Extinction, 1.0 / extinction).unwrap();
    Scene { lights, ..Scene::new(grid.into(), transfer) }
}

fn along_z() -> Ray {
    Ray { origin: DVec3::new(1.0, 1.0, -3.0), direction: DVec3::Z }
}

fn solve(scene: &Scene, scattering: &Scattering, ray: &Ray) -> RayLight {
    SingleScattering::new(scene, scattering, &Clip::default(), TOLERANCE).unwrap().ray(ray, f64::INFINITY).unwrap()
}

#[track_caller]
fn near(found: &RayLight, expected: f64) {
    let error = (found.radiance[0] - expected).abs();
    assert!(
        error <= TOLERANCE && error <= found.certainty.value() + 1e-12,
        "{found:?}, expected {expected}, off by {error:e}"
    );
}

#[test]
fn fog_under_a_headlight_and_a_light_from_the_side() {
    let g = 0.6;
    let phase = PhaseFunction::henyey_greenstein(g).unwrap();
    let scattering =
        Scattering { albedo: Albedo::Color, phase: phase.clone(), environment: [0.0; 3], ..Scattering::default() };
    for extinction in [1e-3f64, 0.7, 20.0] {
        let head = fog(extinction, [0.8; 3], vec![Light { direction: None, color: [3.0; 3] }]);
        let found = solve(&head, &scattering, &along_z());
        let both_ways = -libm::expm1(-4.0 * extinction) / 2.0;
        near(&found, 0.8 * 3.0 / 4.0 * phase.value(-1.0) * both_ways);
        assert!((found.depth - 2.0 * extinction).abs() < 1e-9 * extinction);

        let side = fog(extinction, [0.8; 3], vec![Light { direction: Some(5.0 * DVec3::X), color: [3.0; 3] }]);
        let once = -libm::expm1(-2.0 * extinction);
        near(&solve(&side, &scattering, &along_z()), 0.8 * 3.0 / 4.0 * phase.value(0.0) * (-extinction).exp() * once);
    }
}

/// A light at 45°: near the front its light comes through the front, behind through the side; the depth of the change is a kink that no face tells.
#[test]
fn fog_under_a_slanting_light() {
    let towards = DVec3::new(1.0, 0.0, -1.0).normalize();
    let extinction = 1.5;
    let scene = fog(extinction, [1.0; 3], vec![Light { direction: Some(towards), color: [1.0; 3] }]);
    let scattering = Scattering::default();
    // Up to a depth of 1: ∫ χ e^(−χ (1 + √2) z) dz; from there on the way to the side is √2 long.
    let way = 1.0 + 2f64.sqrt();
    let front = -libm::expm1(-extinction * way) / way;
    let behind = (-extinction * 2f64.sqrt()).exp() * ((-extinction).exp() - (-2.0 * extinction).exp());
    near(&solve(&scene, &scattering, &along_z()), 0.25 * (front + behind));
}

#[test]
fn forward_is_behind_the_medium() {
    let phase = PhaseFunction::henyey_greenstein(0.8).unwrap();
    let scattering = Scattering {
        albedo: Albedo::Constant([1.0; 3]),
        phase: phase.clone(),
        environment: [0.0; 3],
        ..Scattering::default()
    };
    let scene = fog(0.5, [1.0; 3], vec![Light { direction: Some(DVec3::Z), color: [1.0; 3] }]);
    // Every path is as long as the box is thick.
    near(&solve(&scene, &scattering, &along_z()), 0.25 * phase.value(1.0) * 1.0 * (-1f64).exp());
}

#[test]
fn without_scattering_it_is_emission_and_absorption() {
    let scattering = Scattering { albedo: Albedo::Constant([0.0; 3]), ..Scattering::default() };
    let mut scene = phantom::by_name("hydrogen").unwrap().scene(12).unwrap();
    let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [3, 3]);
    let rays = Rays::new(&view).unwrap();
    scene.shading = None;
    for (x, y) in [(1.5, 1.5), (1.2, 1.9)] {
        let ray = rays.at(x, y);
        let light = solve(&scene, &scattering, &ray);
        let reference = Reference::default().transport(&scene, &view, &ray).unwrap().unwrap();
        for c in 0..3 {
            assert!((light.radiance[c] - reference.radiance[c]).abs() < 2.0 * TOLERANCE, "{light:?} {reference:?}");
        }
        assert!((light.depth - reference.depth).abs() < 1e-9);
    }
}

/// A soft ball, by the midpoint rule along the ray and towards the light.
#[test]
fn a_soft_ball_casts_its_shadow_on_itself() {
    let density = |p: DVec3| (-4.0 * p.length_squared()).exp();
    let ball = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), density).unwrap();
    let points = vec![ControlPoint::new(0.0, [0.2, 0.9, 0.9], 0.0), ControlPoint::new(1.0, [0.9, 0.9, 0.2], 1.0)];
    let transfer = TransferFunction::new(points, OpacityRule::Extinction, 0.2).unwrap();
    let towards = DVec3::new(0.3, 1.0, -0.5).normalize();
    let lights = vec![Light { direction: Some(towards), color: [1.0; 3] }];
    let scene = Scene { lights, ..Scene::new(Volume::Field(std::sync::Arc::new(ball)), transfer.clone()) };
    let phase = PhaseFunction::henyey_greenstein(0.4).unwrap();
    let scattering =
        Scattering { albedo: Albedo::Color, phase: phase.clone(), environment: [0.0; 3], ..Scattering::default() };
    let ray = Ray { origin: DVec3::new(0.1, 0.2, -4.0), direction: DVec3::Z };
    let single = SingleScattering::new(&scene, &scattering, &Clip::default(), 1e-5).unwrap();
    let found = single.ray(&ray, f64::INFINITY).unwrap();

    let inside = |p: DVec3| p.abs().max_element() <= 1.0;
    let steps = 2000;
    let h = 2.0 / f64::from(steps);
    let mut sum = 0.0;
    let mut depth = 0.0;
    for i in 0..steps {
        let p = ray.origin + (3.0 + (f64::from(i) + 0.5) * h) * ray.direction;
        let at = transfer.at(density(p));
        let extinction = 5.0 * at.opacity;
        let mut to_light = 0.0;
        let mut q = p + 0.5 * h * towards;
        while inside(q) {
            to_light += 5.0 * density(q) * h;
            q += h * towards;
        }
        let transmittance = (-depth - 0.5 * extinction * h - to_light).exp();
        sum += h * extinction * at.color[0] * 0.25 * phase.value(towards.dot(ray.direction)) * transmittance;
        depth += extinction * h;
    }
    // The steps end up to half a step off the box's sides, where the density is e⁻⁴ at most: 10⁻³ · 5 e⁻⁴ of depth, of a sum of 0.1.
    assert!((found.radiance[0] - sum).abs() < 2e-5, "{found:?}, {sum}");
    assert!(matches!(found.certainty, Certainty::Estimate(error) if error < 1e-4), "{found:?}");
}

/// Tabulated shadows are about as wrong as they say, and less with more nodes.
#[test]
fn tabulated_shadows_come_near_to_the_solved_ones() {
    let mut scene = phantom::by_name("blobs").unwrap().scene(12).unwrap();
    scene.shading = None;
    scene.lights = vec![Light { direction: Some(DVec3::new(1.0, 1.0, -1.0)), color: [1.0; 3] }];
    let rays = Rays::new(&View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [4, 4])).unwrap();
    let solved = SingleScattering::new(&scene, &Scattering::default(), &Clip::default(), 1e-4).unwrap();
    let mut max = [0.0f64; 2];
    for (i, nodes) in [33, 65].into_iter().enumerate() {
        let tabulated = solved.clone().with_tabulated_shadows(nodes).unwrap();
        let mut sums = [0.0; 2];
        for place in 0..16 {
            let ray = rays.at(f64::from(place % 4) + 0.5, f64::from(place / 4) + 0.5);
            let light = |single: &SingleScattering| single.ray(&ray, f64::INFINITY).unwrap();
            let (truth, found) = (light(&solved), light(&tabulated));
            let error = (truth.radiance[0] - found.radiance[0]).abs();
            max[i] = max[i].max(error);
            sums[0] += error;
            sums[1] += found.certainty.value() + truth.certainty.value();
            assert_eq!(truth.depth, found.depth);
        }
        // The estimates hold for the mean: a single ray may be off by thrice its own, where it lies beside an edge that coarse nodes do not see.
        assert!(sums[0] <= sums[1], "{nodes}: {sums:?}");
    }
    assert!(max[1] < 0.5 * max[0], "{max:?}");
    assert!(solved.with_tabulated_shadows(16).is_err());
}

/// Thin fog in an environment of radiance E: ϖ χ E of each unit of length, less what is lost on the way in and out.
#[test]
fn an_environment_lights_thin_fog() {
    let scattering = Scattering { environment: [2.0, 1.0, 0.0], ..Scattering::default() };
    let scene = fog(1e-3, [1.0; 3], vec![]);
    let light = SingleScattering::new(&scene, &scattering, &Clip::default(), 1e-4).unwrap();
    let light = light.ray(&along_z(), f64::INFINITY).unwrap();
    // The ways in and out are 2 long together at most, or 4 to a corner.
    assert!((light.radiance[0] - 4e-3).abs() < 4e-3 * 5e-3, "{light:?}");
    assert!((light.radiance[1] - 2e-3).abs() < 2e-3 * 5e-3 && light.radiance[2] == 0.0, "{light:?}");
}

#[test]
fn a_ray_ends_where_it_is_told_and_a_clip_removes_medium() {
    let scene = fog(1.0, [1.0; 3], vec![Light::default()]);
    let scattering = Scattering::default();
    let single = SingleScattering::new(&scene, &scattering, &Clip::default(), TOLERANCE).unwrap();
    let light = single.ray(&along_z(), 3.5).unwrap();
    near(&light, 0.125 * -libm::expm1(-1.0));
    assert!((light.depth - 0.5).abs() < 1e-9);
    assert_eq!(single.ray(&along_z(), 2.0).unwrap().radiance, [0.0; 3]);
    let aside = Ray { origin: DVec3::new(9.0, 9.0, -1.0), direction: DVec3::Z };
    assert_eq!(single.ray(&aside, f64::INFINITY).unwrap().certainty, Certainty::Bound(0.0));

    let clip = Clip { planes: vec![Plane { normal: DVec3::Z, offset: 1.0 }], ..Clip::default() };
    let light =
        SingleScattering::new(&scene, &scattering, &clip, TOLERANCE).unwrap().ray(&along_z(), f64::INFINITY).unwrap();
    near(&light, 0.125 * -libm::expm1(-2.0));
    assert!((light.half_way - (4.0 + std::f64::consts::LN_2)).abs() < 1e-9);
}

#[test]
fn walls_are_dense_media_and_what_cannot_be_solved_is_refused() {
    let placement = Placement::from_spacing([2.0; 3]).unwrap();
    let grid = UniformGrid::new([2; 3], vec![1u8; 8], placement, Calibration::default()).unwrap();
    let wall = TransferFunction::new(vec![ControlPoint::new(1.0, [1.0; 3], 1.0)], OpacityRule::Power, 1.0).unwrap();
    let mut scene = Scene::new(grid.into(), wall);
    // Lommel and Seeliger: half of what is scattered back comes out.
    near(&solve(&scene, &Scattering::default(), &along_z()), 0.125);
    scene.compositing = Compositing::Maximum;
    let refused = SingleScattering::new(&scene, &Scattering::default(), &Clip::default(), 1e-3);
    assert!(matches!(refused, Err(RenderError::Unsupported(_))));
}
