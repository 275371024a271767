//! Tests of what is left to the caster: qualities, the rays of a picture, the rule of sharp transfer functions.

use glam::DVec3;
use vr_core::*;
use vr_raycast::{ImageSampling, Quality, RayCaster, Rule, Step};

use crate::common::{max_error, oblique, phantom_scenes, random, render, rms, transfer, truth, volume};

/// Scenes whose transfer functions change within less than 2 % of the range of values: shells of 1 % and of a thousandth, nested shells, and a jump in a field
/// with noise.
fn sharp_scenes() -> Vec<(&'static str, Scene)> {
    let n = 40;
    let ball = move |p: DVec3| 255.0 * (1.0 - p.distance(DVec3::splat(0.5 * (n - 1) as f64)) / n as f64).max(0.0);
    let white = [1.0, 0.9, 0.6];
    let shell =
        |at: f64, width: f64, opacity: f64| [(at - width, white, 0.0), (at, white, opacity), (at + width, white, 0.0)];
    let noise = |p: DVec3| {
        let mut random = random((p.x + 64.0 * (p.y + 64.0 * p.z)) as u64);
        random();
        ball(p) + 20.0 * (random() - 0.5)
    };
    let of = |field: &dyn Fn(DVec3) -> f64| volume([n; 3], |x, y, z| field(DVec3::new(x, y, z)));
    let nested: Vec<_> =
        [(100.0, 0.2), (150.0, 0.4), (190.0, 0.8)].into_iter().flat_map(|(v, a)| shell(v, 2.0, a)).collect();
    vec![
        ("shell of 1 %", Scene::new(of(&ball), transfer(&shell(160.0, 1.3, 0.6), 1.0))),
        ("shell of a thousandth", Scene::new(of(&ball), transfer(&shell(160.0, 0.13, 0.9), 1.0))),
        ("nested shells", Scene::new(of(&ball), transfer(&nested, 1.0))),
        (
            "jump in noise",
            Scene::new(
                of(&noise),
                transfer(
                    &[
                        (90.0, white, 0.0),
                        (110.0, white, 0.02),
                        (150.0, white, 0.02),
                        (150.0, white, 0.7),
                        (255.0, white, 0.9),
                    ],
                    1.0,
                ),
            ),
        ),
    ]
}

#[test]
fn qualities_come_near_the_error_they_aim_at() {
    for (name, scene) in sharp_scenes().into_iter().chain(phantom_scenes(40)) {
        let view = oblique(&scene, 40);
        let truth = truth(&scene, &view);
        for quality in Quality::ALL {
            let picture = render(&RayCaster { quality, ..RayCaster::default() }, &scene, &view);
            let error = rms(&picture.frame, &truth);
            println!("{name}, {}: RMSE {error:.1e}, {} samples", quality.name(), picture.stats.counts.samples);
            // Aimed at, not promised: within a factor of two.
            assert!(error <= 2.0 * quality.error(), "{name}, {}: {error}", quality.name());
        }
    }
}

#[test]
fn large_pictures_come_near_the_error_they_aim_at() {
    // In these, a few rays choose the length of steps.
    let size = 1 << (ImageSampling::LARGE.ilog2() / 2);
    for (name, scene) in sharp_scenes().into_iter().chain(phantom_scenes(40)) {
        let view = oblique(&scene, size);
        let proven = RayCaster { step: Step::ErrorBound(5e-5), ..RayCaster::default() };
        let truth = render(&proven, &scene, &view).frame;
        for quality in Quality::ALL {
            let picture = render(&RayCaster { quality, ..RayCaster::default() }, &scene, &view);
            let local = RayCaster { step: Step::Local { error: quality.error() }, ..RayCaster::default() };
            let local = render(&local, &scene, &view);
            let errors = [&picture, &local].map(|picture| rms(&picture.frame, &truth));
            let counts = [&picture, &local].map(|picture| picture.stats.counts);
            println!(
                "{name}, {}: {:.1e} ({:.1e} by local steps), {:?} samples",
                quality.name(),
                errors[0],
                errors[1],
                counts.map(|c| c.samples)
            );
            // Aimed at, not promised: within a factor of two, or of what local steps make.
            let allowed = (2.0 * quality.error()).max(1.1 * errors[1]);
            assert!(errors[0] <= allowed, "{name}, {}: {}", quality.name(), errors[0]);
        }
    }
}

/// Asserts that two casters draw a view alike, bit for bit.
#[track_caller]
fn assert_alike(casters: [&RayCaster; 2], (scene, view): (&Scene, &View), what: &str) {
    let [one, other] = casters.map(|caster| render(caster, scene, view).frame);
    assert_eq!(one, other, "{what}");
}

#[test]
fn sharp_transfer_functions_are_integrated_over_all_values() {
    let of_rule = |rule| RayCaster { rule, ..RayCaster::default() };
    let nearest = |caster: RayCaster| RayCaster { filter: Some(Filter::Nearest), ..caster };
    for (name, scene) in sharp_scenes() {
        let seen = (&scene, &oblique(&scene, 20));
        assert_alike([&RayCaster::default(), &of_rule(Rule::Quadratic)], seen, name);
        // Under the filter nearest no value lies between two voxels.
        assert_alike([&nearest(RayCaster::default()), &nearest(of_rule(Rule::Midpoint))], seen, name);
    }
    for (name, scene) in phantom_scenes(24).into_iter().filter(|(name, _)| ["fog", "blobs"].contains(name)) {
        assert_alike([&RayCaster::default(), &of_rule(Rule::Midpoint)], (&scene, &oblique(&scene, 20)), name);
    }
}

/// Pictures of a size at which rays are left out.
const SIDE: u32 = 256;

#[test]
fn automatic_rays_are_fewer_and_miss_nothing() {
    // Needles of one voxel in every direction, and single voxels.
    let n = 96;
    let mut random = random(5);
    let mut samples = vec![0u8; n * n * n];
    let mut put = |p: DVec3| {
        let at = p.round().clamp(DVec3::ZERO, DVec3::splat((n - 1) as f64)).to_array().map(|x| x as usize);
        samples[(at[2] * n + at[1]) * n + at[0]] = 255;
    };
    let mut point = |scale: f64| DVec3::new(random(), random(), random()) * scale;
    for _ in 0..12 {
        let (from, to) = (point((n - 1) as f64), point((n - 1) as f64));
        (0..200).for_each(|k| put(from.lerp(to, f64::from(k) / 199.0)));
    }
    (0..60).for_each(|_| put(point((n - 1) as f64)));
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let needles: Volume = UniformGrid::new([n; 3], samples, placement, Calibration::default()).unwrap().into();
    let points = [(60.0, [1.0; 3], 0.0), (200.0, [1.0; 3], 0.7), (255.0, [1.0; 3], 0.9)];
    let needles = ("needles", Scene::new(needles, transfer(&points, 1.0)));

    for (name, scene) in phantom_scenes(64).into_iter().chain([needles]) {
        let view = oblique(&scene, SIDE);
        let all =
            render(&RayCaster { image_sampling: ImageSampling::EveryPixel, ..RayCaster::default() }, &scene, &view);
        let auto = render(&RayCaster::default(), &scene, &view);
        let threshold = Step::ERROR * ImageSampling::THRESHOLD_PER_ERROR;
        let (worst, mean) = (max_error(&auto.frame, &all.frame), rms(&auto.frame, &all.frame));
        let share = auto.stats.counts.rays as f64 / all.stats.counts.rays as f64;
        println!("{name}: {share:.2} of the rays, worst pixel {worst:.1e}, RMSE {mean:.1e}");
        assert!(worst <= threshold && mean <= Step::ERROR, "{name}: {worst} {mean}");
        // Where most rays would be traced, all are: that takes less time.
        assert!(share < 0.5 || name != "fog", "{name}: {share}");
    }
}

#[test]
fn pixels_are_drawn_one_by_one() {
    let (_, scene) = phantom_scenes(32).remove(0);
    let view = oblique(&scene, 40);
    for caster in [RayCaster::uniform(0.5), RayCaster { step: Step::ErrorBound(1e-3), ..RayCaster::default() }] {
        let picture = render(&caster, &scene, &view).frame;
        let mut prepared = caster.prepare(&scene, &Control::default()).unwrap();
        let places: Vec<[u32; 2]> = (0..300).map(|i| [i * 7 % 40, i * 11 % 40]).collect();
        let drawn = prepared.pixels(&view, &places, &Control::default()).unwrap().expect("rays are cast");
        assert!(drawn.counts.samples > 0);
        for (&[x, y], pixel) in places.iter().zip(&drawn.rgba) {
            // Steps of a promise depend on the rays beside; both pixels keep it.
            let allowed = caster.max_error().map_or(0.0, |error| 2.0 * error as f32);
            let off = (0..4).map(|c| (picture.pixel(x, y)[c] - pixel[c]).abs()).fold(0.0, f32::max);
            assert!(off <= allowed, "{x}, {y}: {off}");
        }
        assert!(prepared.pixels(&view, &[[40, 0]], &Control::default()).is_err());
    }
}

#[test]
fn small_pictures_and_given_steps_have_the_rays_of_every_pixel() {
    let (_, scene) = phantom_scenes(32).remove(0);
    for (caster, side) in [(RayCaster::default(), SIDE - 1), (RayCaster::uniform(1.0), SIDE)] {
        let every = RayCaster { image_sampling: ImageSampling::EveryPixel, ..caster.clone() };
        assert_alike([&caster, &every], (&scene, &oblique(&scene, side)), &format!("{side}"));
    }
}
