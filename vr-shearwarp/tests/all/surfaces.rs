//! Opaque surfaces among the volume, against the reference.

use glam::DVec3;
use vr_core::*;
use vr_physics::check::FixedLayer;
use vr_physics::check::pictures::*;
use vr_physics::{Metrics, Reference};
use vr_shearwarp::{ShearWarp, WarpFilter};

const VIEWS: [(f64, f64, Option<f64>); 3] = [(10.0, 5.0, None), (33.0, 21.0, None), (25.0, -10.0, Some(35.0))];

/// A scene with an oblique red triangle that cuts its volume, as one view sees it.
fn cut_by_triangle(scene: &Scene, view: &View) -> Scene {
    let (low, high) = scene.volume.bounds();
    let (middle, size) = (0.5 * (low + high), high - low);
    let corners = [DVec3::new(-0.4, -0.35, 0.1), DVec3::new(0.6, -0.2, -0.3), DVec3::new(0.0, 0.7, 0.25)]
        .map(|c| middle + c * size);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let rays = Rays::new(view).unwrap();
    let pixel = |i: u32| {
        let [x, y] = [i % view.size[0], i / view.size[0]].map(|k| f64::from(k) + 0.5);
        let ray = rays.at(x, y);
        let distance = normal.dot(corners[0] - ray.origin) / normal.dot(ray.direction);
        let at = ray.origin + distance * ray.direction;
        let inside = |a: DVec3, b: DVec3| normal.dot((b - a).cross(at - a)) >= 0.0;
        let met = distance > 0.0 && (0..3).all(|k| inside(corners[k], corners[(k + 1) % 3]));
        if met { ([0.9, 0.1, 0.2], distance as f32) } else { ([0.0; 3], f32::INFINITY) }
    };
    FixedLayer::new(view, pixel).among(scene)
}

/// Root of the mean square error; and the same of the pixels that see the triangle and whose neighbours do.
fn errors(renderer: &ShearWarp, scene: &Scene, view: &View) -> [f64; 2] {
    let control = Control::default();
    let solution = Reference::new(1e-6).solve(scene, view, &Model::Canonical, &control).expect("solvable");
    let frame = draw(renderer, scene, view).frame;
    let layer = scene.layer(view, &control).unwrap().unwrap();
    let width = view.size[0] as usize;
    let sees = |i: usize| layer.depth(i).is_finite();
    let (mut want, mut got) = (Vec::new(), Vec::new());
    for i in width + 1..solution.pixels.len() - width - 1 {
        if [i - width - 1, i - width + 1, i + width - 1, i + width + 1, i].into_iter().all(sees) {
            want.push(solution.pixels[i].rgba);
            got.push(frame.pixels()[i]);
            // What is seen is the surface, or before it.
            let (depth, truth) = (f64::from(frame.depth().unwrap()[i]), solution.pixels[i].depth);
            assert!(depth <= layer.depth(i) + 1e-4, "{depth}");
            // Extremes may be found far apart along stretches that are flat.
            let near = (depth - truth).abs() < 0.3 || !scene.compositing.integrates_light();
            assert!(near, "{depth} {truth}");
        }
    }
    assert!(want.len() > 40, "{}", want.len());
    let all: Vec<[f64; 4]> = solution.pixels.iter().map(|p| p.rgba).collect();
    [Metrics::of(&all, frame.pixels()).rmse, Metrics::of(&want, &got).rmse]
}

#[test]
fn a_triangle_cuts_the_volume_where_it_is() {
    for (compositing, classification) in [
        (Compositing::Over, Classification::Post),
        (Compositing::Over, Classification::Pre),
        (Compositing::Accumulate { level: 0.6 }, Classification::Post),
        (Compositing::Maximum, Classification::Post),
        (Compositing::Average, Classification::Post),
        (Compositing::First { threshold: 0.45 }, Classification::Post),
    ] {
        let plain = Scene { compositing, ..phantom_scene::<f32>("fog", 24, 1.0) };
        for (azimuth, elevation, fov) in VIEWS {
            let view = view(&plain, azimuth, elevation, fov, 32);
            let scene = cut_by_triangle(&plain, &view);
            let of = |texel| {
                let renderer = ShearWarp { texel, classification, ..ShearWarp::default() };
                errors(&renderer, &scene, &view)
            };
            let [coarse, fine] = [1.0, 0.125].map(of);
            println!("{compositing:?} {classification:?} {azimuth}: {coarse:.4?}, {fine:.4?}");
            // Where a ray just meets a surface of the field or just not, all of it is at stake, and between two texels that disagree half of it.
            let bound = if let Compositing::First { .. } = compositing { 0.06 } else { 0.01 };
            assert!(fine[1] < bound && fine[0] < bound.max(0.5 * coarse[0]), "{compositing:?}: {coarse:?} {fine:?}");
        }
    }
}

#[test]
fn no_light_leaks_over_outlines() {
    let plain = phantom_scene::<f32>("fog", 24, 1.0);
    for warp in [WarpFilter::Bilinear, WarpFilter::Cubic] {
        for supersampling in [1, 2] {
            let view = View { supersampling, ..view(&plain, 33.0, 21.0, None, 48) };
            let scene = cut_by_triangle(&plain, &view);
            let renderer = ShearWarp { warp, ..ShearWarp::default() };
            let [cut, _] = errors(&renderer, &scene, &view);
            let far = FixedLayer::new(&view, |_| ([0.0; 3], f32::INFINITY)).among(&plain);
            let truth = solve(&plain, &view, &Model::Canonical, 1e-6);
            let uncut = Metrics::of(&truth, draw(&renderer, &far, &view).frame.pixels()).rmse;
            println!("{warp:?} {supersampling}: {cut:.1e}, without the triangle {uncut:.1e}");
            // The outline of a triangle is as good as the rest of the picture.
            assert!(cut < 1.5 * uncut, "{warp:?} {supersampling}: {cut} {uncut}");
            // Nothing that is nowhere changes anything.
            let (far, bare) = (draw(&renderer, &far, &view).frame, draw(&renderer, &plain, &view).frame);
            let pairs = far.pixels().iter().flatten().zip(bare.pixels().iter().flatten());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-5));
        }
    }
}

#[test]
fn surfaces_before_and_behind_the_volume() {
    let plain = phantom_scene::<u8>("fog", 12, 1.0);
    let view = view(&plain, 33.0, 21.0, Some(30.0), 16);
    let alone = draw(&ShearWarp::default(), &plain, &view).frame;
    let blue = |depth| FixedLayer::new(&view, move |_| ([0.0, 0.0, 0.5], depth)).among(&plain);
    let before = draw(&ShearWarp::default(), &blue(1e-3), &view).frame;
    assert!(before.pixels().iter().all(|&p| p == [0.0, 0.0, 0.5, 1.0]));
    assert!(before.depth().unwrap().iter().all(|&d| d == 1e-3));
    let behind = draw(&ShearWarp::default(), &blue(1e6), &view).frame;
    for (got, bare) in behind.pixels().iter().zip(alone.pixels()) {
        let want = [bare[0], bare[1], bare[2] + (1.0 - bare[3]) * 0.5, 1.0];
        assert!((0..4).all(|c| (got[c] - want[c]).abs() < 1e-6), "{got:?} {want:?}");
    }
}
