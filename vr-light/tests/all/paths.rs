//! Random paths against what is known in closed form.
//!
//! Means are allowed 4 standard errors of their own samples in single comparisons (6·10⁻⁵ of normal means are beyond), and 3 where many are counted, of
//! which 0.27 % may be beyond. Seeds are fixed: a test that passes goes on passing.

use std::sync::Arc;

use glam::DVec3;
use vr_core::phantom;
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::{Camera, Clip, Control, Light, Model, Ray, View};
use vr_light::*;

const LOW: DVec3 = DVec3::NEG_ONE;
const HIGH: DVec3 = DVec3::ONE;

/// Mean and standard error of band 0 along a ray.
fn mean(scene: &LightScene, ray: &Ray, count: u64) -> [f64; 2] {
    let mut film = Film::new([1, 1], scene.bands()).unwrap();
    let mut sample = vec![0.0; scene.bands() + 1];
    for number in 0..count {
        let mut random = RandomStream::new(99, 0, number);
        PathSampler::new(scene).sample(ray, &mut random, &Control::default(), &mut sample).unwrap();
        film.add(0, &sample);
    }
    [film.mean(0, 0), film.standard_error(0, 0)]
}

#[track_caller]
fn assert_within(found: [f64; 2], expected: f64, errors: f64) {
    let [mean, error] = found;
    // Sums of equal numbers are off by their rounding alone.
    assert!((mean - expected).abs() <= errors * error + 1e-10, "{mean} ± {error} for {expected}");
}

fn cube(absorption: f64, scattering: f64, emission: f64, g: f64) -> Arc<Homogeneous> {
    let all = Coefficients { absorption, scattering, emission };
    let phase = PhaseFunction::henyey_greenstein(g).unwrap();
    Arc::new(Homogeneous::new((LOW, HIGH), vec![all], phase).unwrap())
}

fn walls(emission: f64, reflection: Reflection) -> Vec<Surface> {
    let surface = |shape| Surface { shape, emission: Spectrum::grey(emission), reflection: reflection.clone() };
    Shape::box_faces(LOW, HIGH).map(surface).to_vec()
}

fn inside(direction: DVec3) -> Ray {
    Ray { origin: DVec3::new(0.3, -0.2, 0.1), direction: direction.normalize() }
}

#[test]
fn closed_box_of_one_temperature_has_one_radiance() {
    let temperature = 2.5;
    for (absorption, scattering, share) in [(0.5, 1.5, 0.6), (3.0, 0.0, 0.0), (0.0, 2.0, 0.9), (20.0, 20.0, 0.5)] {
        let medium = cube(absorption, scattering, absorption * temperature, 0.4);
        let reflections = [Reflection::Lambertian(Spectrum::grey(share)), Reflection::Mirror(Spectrum::grey(share))];
        for reflection in reflections {
            let scene = LightScene::new(Some(medium.clone()), 1).unwrap();
            let scene = scene.with_surfaces(walls((1.0 - share) * temperature, reflection)).unwrap();
            for direction in [DVec3::X, DVec3::new(1.0, 2.0, -3.0)] {
                assert_within(mean(&scene, &inside(direction), 20_000), temperature, 4.0);
            }
        }
    }
}

#[test]
fn lambertian_box_has_the_radiance_of_the_series_of_reflections() {
    for (emission, share) in [(1.0, 0.0), (1.0, 0.3), (0.2, 0.8)] {
        let scene = LightScene::new(None, 1).unwrap();
        let scene = scene.with_surfaces(walls(emission, Reflection::Lambertian(Spectrum::grey(share)))).unwrap();
        assert_within(mean(&scene, &inside(DVec3::new(0.3, 1.0, 0.5)), 40_000), emission / (1.0 - share), 4.0);
    }
}

#[test]
fn conservative_medium_in_uniform_light_is_invisible() {
    let fog = phantom::by_name("fog").unwrap().scene(17).unwrap();
    let scattering = Scattering {
        albedo: Albedo::Constant([1.0; 3]),
        phase: PhaseFunction::henyey_greenstein(0.8).unwrap(),
        ..Scattering::default()
    };
    let medium = SceneMedium::new(&fog, &Clip::default(), &scattering).unwrap();
    let scene = LightScene::new(Some(Arc::new(medium)), 3).unwrap();
    let scene = scene.with_environment(Environment::from([0.7, 0.2, 0.1])).unwrap();
    let view = View::new(Camera::framing((LOW, HIGH), 30.0, 20.0, Some(40.0)), [8, 8]);
    let mut film = Film::new(view.size, 3).unwrap();
    PathTracer::new(&scene, 1).run(&view, &mut film, &Until::samples(16), &Control::default(), &mut |_| {}).unwrap();
    for pixel in 0..64 {
        for (band, expected) in [0.7, 0.2, 0.1].into_iter().enumerate() {
            // Weights are products of σ/χ, which is 1 but for a last bit each.
            assert!((film.mean(pixel, band) - expected).abs() < 1e-10);
        }
    }
}

#[test]
fn lights_reflect_as_in_the_shading_of_scenes() {
    let share = Reflection::Lambertian(Spectrum::grey(0.6));
    let floor = Surface {
        shape: Shape::Plane { point: DVec3::ZERO, normal: DVec3::Z },
        emission: Spectrum::black(),
        reflection: share,
    };
    let ray = Ray { origin: DVec3::new(0.0, -1.0, 1.0), direction: DVec3::new(0.0, 1.0, -1.0).normalize() };
    let under = |light: LightSource| {
        let scene = LightScene::new(None, 1).unwrap().with_surfaces(vec![floor.clone()]).unwrap();
        mean(&scene.with_lights(vec![light]).unwrap(), &ray, 4)[0]
    };
    let color = Spectrum::grey(2.0);
    let sun = LightSource::Directional { towards: DVec3::new(3.0, 0.0, 4.0), color: color.clone() };
    let lamp = LightSource::Point { at: DVec3::new(0.0, 0.0, 2.0), color: color.clone() };
    assert!((under(sun) - 0.6 * 2.0 * 0.8).abs() < 1e-12);
    assert!((under(lamp) - 0.6 * 2.0 / 4.0).abs() < 1e-12);
    assert!((under(LightSource::Headlight { color }) - 0.6 * 2.0 * 0.5f64.sqrt()).abs() < 1e-12);
    assert!(matches!(LightSource::from(Light::default()), LightSource::Headlight { .. }));
}

#[test]
fn a_uniform_surround_is_the_same_as_walls_or_sky_or_map() {
    let surround = || LightScene::new(Some(cube(0.5, 2.0, 0.0, 0.6)), 1).unwrap();
    let ray = Ray { origin: DVec3::new(0.2, 0.1, -0.9), direction: DVec3::new(0.1, 0.2, 1.0).normalize() };
    let sky = mean(&surround().with_environment(Environment::from([1.0])).unwrap(), &ray, 40_000);
    let map = EnvironmentMap::new([8, 4], 1, vec![1.0; 32]).unwrap();
    let map = mean(&surround().with_environment(Environment::Map(map)).unwrap(), &ray, 40_000);
    let black = mean(&surround().with_surfaces(walls(1.0, Reflection::Black)).unwrap(), &ray, 40_000);
    let shell = Shape::Sphere { centre: DVec3::ZERO, radius: 3.0 };
    let shell = vec![Surface::emitter(shell, Spectrum::grey(1.0))];
    let shell = mean(&surround().with_surfaces(shell).unwrap(), &ray, 40_000);
    for [other, error] in [map, black, shell] {
        assert!((other - sky[0]).abs() < 4.0 * error.hypot(sky[1]), "{other} ± {error} for {sky:?}");
    }
}

#[test]
fn bright_parts_of_a_map_count_as_much_as_they_would_by_chance() {
    // A sun of one pixel over a lobe: aimed at, and met by chance, which a map in a mirrored scene makes comparable.
    let mut radiance = vec![0.1f32; 16 * 8];
    radiance[2 * 16 + 5] = 20.0;
    let map = EnvironmentMap::new([16, 8], 1, radiance).unwrap();
    let floor = |reflection| {
        let shape = Shape::Plane { point: DVec3::ZERO, normal: DVec3::Y };
        vec![Surface { shape, emission: Spectrum::black(), reflection }]
    };
    let ray = Ray { origin: DVec3::new(0.0, 1.0, 0.0), direction: DVec3::NEG_Y };
    let lit = |reflection| {
        let scene = LightScene::new(None, 1).unwrap().with_surfaces(floor(reflection)).unwrap();
        mean(&scene.with_environment(Environment::Map(map.clone())).unwrap(), &ray, 40_000)
    };
    // Irradiance of the map by a sum over fine directions.
    let (mut sum, n) = (0.0, 400);
    for i in 0..n {
        for j in 0..n {
            let y = (i as f64 + 0.5) / n as f64;
            let (sin, cos) = (std::f64::consts::TAU * (j as f64 + 0.5) / n as f64).sin_cos();
            let ring = (1.0 - y * y).sqrt();
            sum += map.radiance(DVec3::new(ring * cos, y, ring * sin), 0) * y * 2.0 / (n * n) as f64;
        }
    }
    let lambertian = lit(Reflection::Lambertian(Spectrum::grey(0.5)));
    // The sum's pixels are cut at 1/400 of the height.
    assert!((lambertian[0] - 0.5 * sum).abs() < 4.0 * lambertian[1] + 5e-3 * sum, "{lambertian:?} for {}", 0.5 * sum);
}

#[test]
fn without_scattering_the_reference_is_met() {
    let fog = phantom::by_name("fog").unwrap().scene(17).unwrap();
    let scattering = Scattering { albedo: Albedo::Constant([0.0; 3]), ..Scattering::default() };
    let view = View::new(Camera::framing((LOW, HIGH), 30.0, 20.0, Some(40.0)), [12, 12]);
    let reference = vr_physics::Reference::default();
    let solution = reference.solve(&fog, &view, &Model::Canonical, &Control::default()).unwrap();
    let medium = SceneMedium::new(&fog, &Clip::default(), &scattering).unwrap();
    let scene = LightScene::new(Some(Arc::new(medium)), 3).unwrap();
    let mut film = Film::new(view.size, 3).unwrap();
    // A quarter of the samples are of the opacity, too: where hardly any light gets through, a mean of few is far from a normal distribution.
    PathTracer::new(&scene, 5).run(&view, &mut film, &Until::samples(9600), &Control::default(), &mut |_| {}).unwrap();
    let mut beyond = 0;
    for (pixel, expected) in solution.pixels.iter().enumerate() {
        for channel in 0..4 {
            let (mean, error) = (film.mean(pixel, channel), film.standard_error(pixel, channel));
            let difference = (mean - expected.rgba[channel]).abs();
            assert!(difference <= 5.0 * error + 1e-9, "pixel {pixel}: {mean} ± {error} for {}", expected.rgba[channel]);
            beyond += usize::from(difference > 3.0 * error + 1e-9);
        }
    }
    // 576 means, of which the three colours of a pixel come from the same paths: 0.27 % are 1.6.
    assert!(beyond <= 7, "{beyond} beyond 3 standard errors");
}

#[test]
fn films_do_not_depend_on_threads_nor_on_interruptions() {
    let medium = cube(0.3, 2.0, 0.1, 0.5);
    let sun = LightSource::Directional { towards: DVec3::ONE, color: Spectrum::grey(1.0) };
    let scene = LightScene::new(Some(medium), 1).unwrap().with_lights(vec![sun]).unwrap();
    let view = View { supersampling: 2, ..View::new(Camera::framing((LOW, HIGH), 30.0, 20.0, None), [9, 7]) };
    let tracer = PathTracer::new(&scene, 3);
    let run = |film: &mut Film, samples, threads| {
        let control = Control::default().with_threads(threads);
        tracer.run(&view, film, &Until::samples(samples), &control, &mut |_| {}).unwrap();
    };
    let mut whole = Film::new(view.size, 1).unwrap();
    run(&mut whole, 20, 1);
    let mut parts = Film::new(view.size, 1).unwrap();
    [3, 4, 20].into_iter().for_each(|samples| run(&mut parts, samples, 3));
    assert_eq!(whole, parts);
}
