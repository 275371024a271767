//! Opaque surfaces of scenes in media that scatter.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::*;
use vr_light::marched::MarchedScattering;
use vr_light::single::SingleScattering;
use vr_light::*;
use vr_mesh::Surface as Mesh;

/// A box of fog from the origin to (2, 2, 2), white as a scatterer, with this surface.
fn fog(extinction: f64, lights: Vec<Light>, environment: f64, mesh: Mesh) -> Scene {
    let placement = Placement::from_spacing([2.0; 3]).unwrap();
    let grid = UniformGrid::new([2; 3], vec![1u8; 8], placement, Calibration::default()).unwrap();
    let point = ControlPoint::new(1.0, [1.0; 3], 1.0);
    let transfer = TransferFunction::new(vec![point], OpacityRule::Extinction, 1.0 / extinction).unwrap();
    let scattering = Scattering { environment: [environment; 3], ..Scattering::default() };
    let (scattering, surfaces) = (Some(Arc::new(scattering)), Some(Arc::new(mesh) as Arc<dyn Surfaces>));
    Scene { lights, scattering, surfaces, ..Scene::new(grid.into(), transfer) }
}

/// A parallelogram of two triangles that reflects all light.
fn patch(corner: [f64; 3], edges: [[f64; 3]; 2]) -> Mesh {
    let [o, a, b] = [corner, edges[0], edges[1]].map(DVec3::from);
    let mesh = TriangleMesh::new(vec![o, o + a, o + b, o + a + b], vec![[0, 1, 2], [1, 3, 2]]).unwrap();
    matt(mesh, 1.0)
}

fn matt(mesh: TriangleMesh, reflectance: f64) -> Mesh {
    let shading = Shading { ambient: 0.0, diffuse: 1.0, specular: 0.0, ..Shading::default() };
    Mesh { color: Some([reflectance; 3]), shading, ..Mesh::new(mesh) }
}

/// The twelve triangles of a box.
fn cube(low: f64, high: f64) -> TriangleMesh {
    let corner = |i: u32| DVec3::from([0, 1, 2].map(|axis| if i >> axis & 1 == 1 { high } else { low }));
    let faces = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 4, 5], [2, 3, 6, 7], [0, 2, 4, 6], [1, 3, 5, 7]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [b, d, c]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap()
}

fn sun(direction: [f64; 3], color: f64) -> Light {
    Light { direction: Some(direction.into()), color: [color; 3] }
}

fn along_z() -> Ray {
    Ray { origin: DVec3::new(1.0, 1.0, -3.0), direction: DVec3::Z }
}

/// Light along the ray by the integral and by steps.
fn both(scene: &Scene) -> [f64; 2] {
    let scattering = scene.scattering.as_deref().unwrap();
    let exact = SingleScattering::new(scene, scattering, &Clip::default(), 1e-6).unwrap();
    let steps = MarchedScattering::new(scene, &Clip::default(), 0.005, &Control::default()).unwrap();
    let exact = exact.ray(&along_z(), f64::INFINITY).unwrap();
    assert!(exact.certainty.value() < 3e-6, "{exact:?}");
    [exact.radiance[0], steps.along(&along_z()).radiance[0]]
}

#[track_caller]
fn near(found: [f64; 2], expected: f64) {
    // Steps see the shadow map's spacing, a 160th of the box.
    assert!(
        (found[0] - expected).abs() < 3e-6 && (found[1] - expected).abs() < 4e-3 * (1.0 + expected),
        "{found:?} {expected}"
    );
}

#[test]
fn a_wall_in_fog_reflects_what_gets_to_it_and_back() {
    let wall = || patch([-1.0, -1.0, 1.5], [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]);
    for extinction in [1e-3f64, 0.7, 4.0] {
        let both_ways = (-2.0 * extinction * 1.5).exp();
        // ¼ ∫ χ e^(−2χz) dz from the fog in front, and the wall behind it; the headlight and a lamp behind the eye alike.
        let expected = 3.0 * (0.25 * (1.0 - both_ways) / 2.0 + both_ways);
        near(both(&fog(extinction, vec![Light { color: [3.0; 3], ..Light::default() }], 0.0, wall())), expected);
        near(both(&fog(extinction, vec![sun([0.0, 0.0, -1.0], 3.0)], 0.0, wall())), expected);
        // A lamp behind the wall lights nothing that is seen.
        near(both(&fog(extinction, vec![sun([0.0, 0.0, 1.0], 3.0)], 0.0, wall())), 0.0);
    }
}

#[test]
fn walls_cast_shadows_into_fog() {
    // Hides the lamp from the part z > 1 of the fog.
    let wall = patch([2.5, -1.0, 1.0], [[0.0, 4.0, 0.0], [0.0, 0.0, 3.0]]);
    let extinction = 0.8f64;
    let expected = 0.25 * (-extinction).exp() * (1.0 - (-extinction).exp());
    near(both(&fog(extinction, vec![sun([1.0, 0.0, 0.0], 1.0)], 0.0, wall)), expected);
}

#[test]
fn light_passes_by_the_fog() {
    // Beside the fog and below it: the floor has all of the lamp's light, times the cosine.
    let floor = patch([0.0, -5.0, 20.0], [[9.0, 0.0, 0.0], [0.0, 9.0, 0.0]]);
    let scene = fog(2.0, vec![sun([0.6, 0.0, -0.8], 1.0)], 0.0, floor);
    let scattering = scene.scattering.as_deref().unwrap();
    let exact = SingleScattering::new(&scene, scattering, &Clip::default(), 1e-6).unwrap();
    let steps = MarchedScattering::new(&scene, &Clip::default(), 0.5, &Control::default()).unwrap();
    let table = exact.clone().with_tabulated_shadows(9).unwrap();
    let ray = Ray { origin: DVec3::new(5.0, 1.0, -3.0), direction: DVec3::Z };
    let found = [&exact, &table].map(|single| single.ray(&ray, f64::INFINITY).unwrap().radiance[0]);
    assert!(found.iter().all(|f| (f - 0.8).abs() < 1e-9), "{found:?}");
    let light = steps.along(&ray);
    assert!((light.radiance[0] - 0.8).abs() < 1e-9 && light.opacity() == 1.0 && light.half_way == 23.0, "{light:?}");
}

#[test]
fn white_things_in_white_fog_are_invisible_in_uniform_light() {
    let scene = fog(1.5, vec![], 0.6, matt(cube(0.4, 1.3), 1.0));
    let medium = SceneMedium::new(&scene, &Clip::default(), scene.scattering.as_deref().unwrap()).unwrap();
    let lit = LightScene::new(Some(Arc::new(medium)), 3)
        .and_then(|lit| lit.with_environment(Environment::from([0.6; 3])))
        .and_then(|lit| lit.with_traced_surfaces(TracedSurfaces::of(&scene, &Clip::default()).unwrap()))
        .unwrap();
    let paths = PathSampler::new(&lit);
    let mut sample = [0.0; 4];
    for i in 0..3000u32 {
        let direction = DVec3::new(f64::from(i % 50) - 25.0, f64::from(i / 50) - 30.0, 60.0).normalize();
        // No ray meets an edge of the cube exactly: light that does may leave inwards, and never gets out again.
        let ray = Ray { origin: DVec3::new(1.013, 0.987, -2.0), direction };
        paths.sample(&ray, &mut RandomStream::new(1, i, 0), &Control::default(), &mut sample).unwrap();
        // Every path gets out, with all of its weight.
        assert!(sample[..3].iter().all(|l| (l - 0.6).abs() < 1e-9), "{i}: {sample:?}");
    }
}

/// A patch of reflectance ρ that faces the sky in vacuum has ρE; one that sees the opening of a box through a form factor, ρEF.
#[test]
fn the_sky_of_a_pit_is_its_form_factor() {
    // A pit without a lid, black but for its floor, of which the middle is looked at through the opening.
    let half = 1.0f64;
    let walls = [
        patch([-half, -half, 0.0], [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]),
        patch([-half, -half, 0.0], [[2.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
        patch([-half, half, 0.0], [[2.0, 0.0, 0.0], [0.0, 0.0, -1.0]]),
        patch([-half, -half, 0.0], [[0.0, 2.0, 0.0], [0.0, 0.0, -1.0]]),
        patch([half, -half, 0.0], [[0.0, 2.0, 0.0], [0.0, 0.0, -1.0]]),
    ];
    let (mut places, mut triangles, mut colors) = (Vec::new(), Vec::new(), Vec::new());
    for (i, wall) in walls.iter().enumerate() {
        let first = places.len() as u32;
        places.extend(wall.mesh.positions());
        triangles.extend(wall.mesh.triangles().iter().map(|corners| corners.map(|v| v + first)));
        colors.extend([[if i == 0 { 0.5 } else { 0.0 }; 3]; 4]);
    }
    let mesh = TriangleMesh::new(places, triangles).unwrap().with_colors(colors).unwrap();
    let scene = fog(1.0, vec![], 0.0, Mesh { color: None, ..matt(mesh, 1.0) });
    let traced = TracedSurfaces::of(&scene, &Clip::default()).unwrap();
    let lit = LightScene::new(None, 3)
        .and_then(|lit| lit.with_environment(Environment::from([2.0; 3])))
        .and_then(|lit| lit.with_traced_surfaces(traced))
        .unwrap();
    let paths = PathSampler::new(&lit);
    let ray = Ray { origin: DVec3::new(0.0, 0.0, -3.0), direction: DVec3::Z };
    let count = 40_000u32;
    let mut sum = 0.0;
    for i in 0..count {
        let mut sample = [0.0; 4];
        paths.sample(&ray, &mut RandomStream::new(5, i, 0), &Control::default(), &mut sample).unwrap();
        sum += sample[0];
    }
    // From a point to a square of half edge 1 at the distance 1, four corners of (Howell, configuration B-3): 4/2π · 2 · (1/√2) atan(1/√2).
    let factor = 4.0 / (2.0 * PI) * 2.0 * 0.5f64.sqrt() * 0.5f64.sqrt().atan();
    let (mean, expected) = (sum / f64::from(count), 0.5 * 2.0 * factor);
    // Each path brings 1 or 0.
    let error = (factor * (1.0 - factor) / f64::from(count)).sqrt();
    assert!((mean - expected).abs() < 4.0 * error, "{mean} {expected} ± {error}");
}

#[test]
fn paths_of_one_scattering_are_the_integral_with_surfaces() {
    let phase = PhaseFunction::henyey_greenstein(0.3).unwrap();
    let mut scene = fog(0.9, vec![sun([0.5, 1.0, -0.7], 1.5), Light::default()], 0.3, matt(cube(0.6, 1.2), 0.7));
    let scattering = Scattering { albedo: Albedo::Color, phase, environment: [0.3; 3], ..Scattering::default() };
    scene.scattering = Some(Arc::new(scattering));
    let view = View::new(Camera::framing(scene.bounds(), 30.0, 20.0, Some(30.0)), [7, 5]);
    let control = Control::default();
    let draw =
        |renderer: LightRenderer| renderer.prepare(&scene, &control).unwrap().render(&view, &control).unwrap().frame;
    let exact = draw(LightRenderer { method: Method::Single, exact: true, ..LightRenderer::default() });
    let paths = draw(LightRenderer { paths: 4000, max_scatterings: Some(1), ..LightRenderer::default() });
    let (own, noise) = (exact.uncertainty().unwrap().components(), paths.uncertainty().unwrap().components());
    let mut beyond = 0;
    for (i, (found, expected)) in paths.pixels().iter().zip(exact.pixels()).enumerate() {
        for c in 0..4 {
            let allowed = 3.0 * noise[i][c] + own[i][c] + 2e-4;
            beyond += usize::from((found[c] - expected[c]).abs() > allowed);
        }
    }
    // 0.27 % of normal means are beyond 3 standard errors; of those of a few bright paths, more.
    assert!(beyond <= 2, "{beyond} of 140");
    assert!(exact.pixels().iter().any(|p| p[3] == 1.0) && exact.pixels().iter().any(|p| p[3] < 1.0));
}

#[test]
fn surfaces_without_geometry_are_refused() {
    #[derive(Debug)]
    struct Picture;
    impl Surfaces for Picture {
        fn layer(&self, _: &[Light], _: &View, _: &Control) -> Result<Layer, RenderError> {
            Ok(Layer { pixels: Vec::new() })
        }
        fn bounds(&self) -> (DVec3, DVec3) {
            (DVec3::ZERO, DVec3::ONE)
        }
    }
    let mut scene = fog(1.0, vec![], 0.0, matt(cube(0.0, 1.0), 1.0));
    let renderer = LightRenderer::default();
    assert!(renderer.supports(&scene, None).is_ok());
    scene.surfaces = Some(Arc::new(Picture));
    match renderer.supports(&scene, None) {
        Err(RenderError::Unsupported(refusal)) => assert_eq!(refusal.feature, Feature::Surfaces),
        other => panic!("{other:?}"),
    }
    assert!(TracedSurfaces::of(&scene, &Clip::default()).is_err());
}
