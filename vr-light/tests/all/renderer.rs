//! The renderer, its ways to draw light that is scattered once, and its refusals.

use std::sync::Arc;

use glam::DVec3;
use vr_core::scattering::{
    Albedo, EnvironmentImage, Finish, PhaseFunction, PointLight, Scattering, Shape, SimpleSurface,
};
use vr_core::*;
use vr_light::*;

/// Fog under a lamp and a headlight.
fn fog() -> Scene {
    let mut scene = phantom::by_name("fog").unwrap().scene(17).unwrap();
    let phase = PhaseFunction::henyey_greenstein(0.3).unwrap();
    // It does not glow: paths of one scattering would scatter that light, too, which the model of single scattering leaves out.
    let scattering = Scattering { albedo: Albedo::Color, phase, environment: [0.0; 3], ..Scattering::default() };
    scene.scattering = Some(Arc::new(scattering));
    let sun = Light { direction: Some(DVec3::new(1.0, 0.8, 0.4)), color: [2.0, 1.5, 1.0] };
    scene.lights = vec![sun, Light::default()];
    scene
}

fn draw(renderer: &LightRenderer, scene: &Scene, size: [u32; 2]) -> Frame {
    let camera = Camera::framing(scene.volume.bounds(), 30.0, 20.0, Some(30.0));
    let (view, control) = (View::new(camera, size), Control::default());
    renderer.prepare(scene, &control).unwrap().render(&view, &control).unwrap().frame
}

fn single() -> LightRenderer {
    LightRenderer { method: Method::Single, ..LightRenderer::default() }
}

fn largest(a: &Frame, b: &Frame) -> f64 {
    let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
    pairs.map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
}

#[test]
fn steps_converge_to_the_integral_of_light_scattered_once() {
    let scene = fog();
    let exact = draw(&LightRenderer { exact: true, ..single() }, &scene, [6, 5]);
    let bound = exact.uncertainty().unwrap().largest();
    assert!(bound <= 2e-4, "{bound}");
    let errors =
        [8.0, 4.0, 0.5].map(|step| largest(&draw(&LightRenderer { step, ..single() }, &scene, [6, 5]), &exact));
    // Long steps are cut at the cells of the grid of bounds, and share out what is left: their errors fall by no clean order. At short ones the spacing of
    // the shadow map stays: an edge of the box is blurred over 1/160 of it.
    assert!(errors[0] > errors[1] && errors[1] > 10.0 * errors[2] && errors[2] < 1e-3, "{errors:?}");
}

#[test]
fn paths_of_one_scattering_are_the_integral() {
    let scene = fog();
    let exact = draw(&LightRenderer { exact: true, ..single() }, &scene, [6, 5]);
    let once = LightRenderer { paths: 4000, max_scatterings: Some(1), ..LightRenderer::default() };
    let paths = draw(&once, &scene, [6, 5]);
    let errors = paths.uncertainty().unwrap().components();
    let (mut count, mut beyond) = (0, 0);
    for (i, (found, expected)) in paths.pixels().iter().zip(exact.pixels()).enumerate() {
        for c in 0..4 {
            count += 1;
            beyond += usize::from((found[c] - expected[c]).abs() > 3.0 * errors[i][c] + 2e-4);
        }
    }
    // 0.27 % of normal means are beyond 3 standard errors; of those of a few bright paths, more.
    assert!(beyond * 50 <= count, "{beyond} of {count}");
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_number_of_threads() {
    let scene = fog();
    let camera = Camera::framing(scene.volume.bounds(), 30.0, 20.0, None);
    let view = View { supersampling: 2, ..View::new(camera, [7, 5]) };
    let renderer = LightRenderer { paths: 8, ..LightRenderer::default() };
    let draw = |threads: u16, seed| {
        let control = Control::default().with_threads(threads.into());
        let renderer = LightRenderer { seed, ..renderer.clone() };
        renderer.prepare(&scene, &control).unwrap().render(&view, &control).unwrap().frame
    };
    assert_eq!(draw(1, 3), draw(3, 3));
    assert_ne!(draw(1, 3), draw(1, 4));
}

#[test]
fn far_point_lights_and_even_maps_are_lights_at_infinity_and_even_light() {
    let full = LightRenderer { paths: 16, ..LightRenderer::default() };
    let with = |change: &dyn Fn(&mut Scene, &mut Scattering)| {
        let mut scene = fog();
        let mut scattering = Scattering::clone(scene.scattering.as_deref().unwrap());
        scene.lights = Vec::new();
        change(&mut scene, &mut scattering);
        scene.scattering = Some(Arc::new(scattering));
        scene
    };
    // The same random numbers: what is left is the parallax.
    let (towards, far) = (DVec3::new(1.0, 0.8, 0.4).normalize(), 1e5);
    let sun = with(&|scene, _| scene.lights = vec![Light { direction: Some(towards), color: [2.0, 1.5, 1.0] }]);
    let color = [2.0, 1.5, 1.0].map(|c| c * far * far);
    let point = with(&|_, s| s.point_lights = vec![PointLight { position: towards * far, color }]);
    let [sun, point] = [sun, point].map(|scene| draw(&full, &scene, [6, 5]));
    assert!(largest(&sun, &point) < 1e-3 && sun.pixels().iter().any(|p| p[0] > 0.1), "{}", largest(&sun, &point));
    // A map is sampled on its own: the means agree within the noise.
    let many = LightRenderer { paths: 4000, ..LightRenderer::default() };
    let sky = with(&|_, s| s.environment = [0.5, 0.25, 1.0]);
    let map = with(&|_, s| {
        s.environment = [0.25, 0.25, 0.0];
        s.environment_map = Some(Arc::new(EnvironmentImage::new([4, 2], vec![[0.25, 0.0, 1.0]; 8]).unwrap()));
    });
    let [sky, map] = [sky, map].map(|scene| draw(&many, &scene, [6, 5]));
    let (a, b) = (sky.uncertainty().unwrap().components(), map.uncertainty().unwrap().components());
    let beyond =
        |i: usize, c: usize| (sky.pixels()[i][c] - map.pixels()[i][c]).abs() > 3.0 * a[i][c].hypot(b[i][c]) + 1e-6;
    let count = (0..30).flat_map(|i| (0..3).map(move |c| (i, c))).filter(|&(i, c)| beyond(i, c)).count();
    // 0.27 % of normal differences are beyond 3 standard errors: of 90, one.
    assert!(count <= 2, "{count}");
}

#[test]
fn a_closed_box_of_matte_walls_is_a_furnace() {
    // A conservative medium that does not glow, in a box that emits E and reflects ρ: E/(1 − ρ) everywhere, and nothing else can be seen.
    let mut scene = fog();
    let wall = |shape| SimpleSurface { shape, emission: [0.2, 0.1, 0.0], reflectance: [0.5; 3], finish: Finish::Matte };
    let surfaces = Shape::box_faces(DVec3::splat(-40.0), DVec3::splat(40.0)).map(wall).to_vec();
    let scattering = Scattering { albedo: Albedo::Constant([1.0; 3]), surfaces, ..Scattering::default() };
    (scene.scattering, scene.lights) = (Some(scattering.into()), Vec::new());
    let frame = draw(&LightRenderer { paths: 2000, ..LightRenderer::default() }, &scene, [4, 3]);
    for (pixel, error) in frame.pixels().iter().zip(frame.uncertainty().unwrap().components()) {
        for (c, expected) in [0.4, 0.2, 0.0, 1.0].into_iter().enumerate() {
            // Beyond 4 standard errors are 6 of 10⁵ normal means.
            assert!((pixel[c] - expected).abs() <= 4.0 * error[c] + 1e-6, "{pixel:?} ± {error:?}");
        }
    }
}

#[test]
fn mirrors_show_the_light_from_all_sides() {
    // It is not seen behind the medium, but in a mirror: ρ E, without noise where the medium is not in the way.
    let mut scene = fog();
    let shape = Shape::Plane { point: DVec3::new(0.0, -3.0, 0.0), normal: DVec3::Y };
    let mirror = SimpleSurface { shape, emission: [0.0; 3], reflectance: [0.5, 0.75, 1.0], finish: Finish::Mirror };
    let scattering = Scattering { environment: [0.5; 3], surfaces: vec![mirror], ..Scattering::default() };
    (scene.scattering, scene.lights) = (Some(scattering.into()), Vec::new());
    let frame = draw(&LightRenderer { paths: 4, ..LightRenderer::default() }, &scene, [8, 6]);
    let shown = frame.pixels().iter().filter(|pixel| **pixel == [0.25, 0.375, 0.5, 1.0]).count();
    assert!(shown >= 4, "{:?}", frame.pixels());
}

#[test]
fn time_ends_a_run() {
    let begin = std::time::Instant::now();
    let endless = LightRenderer { paths: 1_000_000, seconds: 0.05, ..LightRenderer::default() };
    draw(&endless, &fog(), [6, 5]);
    // Without an end they would be minutes.
    assert!(begin.elapsed().as_secs() < 20);
}

#[test]
fn noise_ends_a_run() {
    let scene = fog();
    let few = draw(&LightRenderer { paths: 100_000, error: 0.05, ..LightRenderer::default() }, &scene, [6, 5]);
    assert!(few.uncertainty().unwrap().rms() < 0.06);
}

#[test]
fn what_is_not_drawn_is_refused_with_a_reason() {
    let refused = |renderer: &LightRenderer, scene: &Scene| match renderer.supports(scene, None) {
        Err(RenderError::Unsupported(refusal)) => refusal.feature,
        other => panic!("{other:?}"),
    };
    let scene = fog();
    let full = LightRenderer::default();
    assert!(full.supports(&scene, None).is_ok() && single().supports(&scene, None).is_ok());
    assert_eq!(refused(&full, &Scene { scattering: None, ..scene.clone() }), Feature::Scattering);
    let level = Compositing::Accumulate { level: 0.5 };
    assert_eq!(refused(&full, &Scene { compositing: level, ..scene.clone() }), Feature::Compositing);
    let sky = Scattering { environment: [1.0; 3], ..Scattering::default() };
    assert_eq!(refused(&single(), &Scene { scattering: Some(sky.into()), ..scene.clone() }), Feature::Scattering);
    let point = PointLight { position: DVec3::ZERO, color: [1.0; 3] };
    let near = Scattering { point_lights: vec![point], ..Scattering::default() };
    assert_eq!(refused(&single(), &Scene { scattering: Some(near.into()), ..scene.clone() }), Feature::Scattering);
    let lamp = SimpleSurface {
        shape: Shape::Sphere { centre: DVec3::Y, radius: 0.1 },
        emission: [1.0; 3],
        reflectance: [0.0; 3],
        finish: Finish::Matte,
    };
    let lit = Scattering { surfaces: vec![lamp], ..Scattering::default() };
    assert_eq!(refused(&single(), &Scene { scattering: Some(lit.into()), ..scene.clone() }), Feature::Scattering);
    // What is nonsense is an error of the scene.
    for scene in [
        Scene { compositing: Compositing::Maximum, ..scene.clone() },
        Scene { shading: Some(Shading::default().into()), ..scene.clone() },
    ] {
        assert!(matches!(full.supports(&scene, None), Err(RenderError::Parameter(_))));
    }
}
