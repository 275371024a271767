use vr_core::image_order::ImageSample;
use vr_core::{Camera, Control, Counts, Layer, Rendered, View};

use super::{AdaptiveRays, adaptive};
use crate::tracer::{RaySample, Tracer};

/// A picture given by a formula in pixels.
struct Painting<F>(F);

impl<F: Fn(f64, f64) -> f64 + Sync> Tracer for Painting<F> {
    fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        counts.rays += spots.len() as u64;
        values.extend(spots.iter().map(|s| RaySample { rgba: [self.0(s.x, s.y) as f32; 4], ..RaySample::NOTHING }));
    }
}

fn view(size: [u32; 2]) -> View {
    View::new(Camera::framing((glam::DVec3::ZERO, glam::DVec3::ONE), 0.0, 0.0, None), size)
}

fn rays(threshold: f64) -> AdaptiveRays<'static> {
    AdaptiveRays { threshold, thin_parts: None, are_few: false }
}

fn draw(size: [u32; 2], threshold: f64, f: impl Fn(f64, f64) -> f64 + Sync) -> Rendered {
    adaptive(&Painting(f), (&view(size), None), rays(threshold), &Control::default()).unwrap()
}

fn largest_error(size: [u32; 2], threshold: f64, f: impl Fn(f64, f64) -> f64 + Sync) -> f64 {
    let found = draw(size, threshold, &f).frame;
    let mut error: f64 = 0.0;
    for y in 0..size[1] {
        for x in 0..size[0] {
            let want = f(f64::from(x) + 0.5, f64::from(y) + 0.5);
            error = error.max((f64::from(found.pixel(x, y)[0]) - want).abs());
        }
    }
    error
}

#[test]
fn a_plane_takes_the_first_rays_only() {
    let drawn = draw([65, 33], 0.5, |x, y| 0.001 * x + 0.002 * y);
    assert_eq!(drawn.stats.counts.rays, 17 * 9);
    assert!(largest_error([65, 33], 0.5, |x, y| 0.001 * x + 0.002 * y) < 1e-6);
}

#[test]
fn monotone_pictures_are_within_the_threshold() {
    for size in [[1, 1], [1, 17], [23, 1], [2, 2], [97, 89], [64, 64]] {
        for threshold in [0.01, 0.1, 0.5] {
            let error = largest_error(size, threshold, |x, y| 0.5 + 0.5 * libm::erf(0.05 * (x + 0.3 * y - 30.0)));
            // The rest is rounding.
            assert!(error <= threshold + 1e-6, "{size:?} {threshold}: {error}");
        }
    }
}

#[test]
fn an_edge_is_followed_and_costs_few_rays() {
    // A disc: constant but for its rim, which every ray-cell that it crosses refines to pixels.
    let disc = |x: f64, y: f64| f64::from(u8::from((x - 64.0).hypot(y - 70.0) < 40.0));
    assert_eq!(largest_error([128, 131], 0.1, disc), 0.0);
    let rays = draw([128, 131], 0.1, disc).stats.counts.rays;
    assert!(rays < 128 * 131 / 2, "{rays}");
}

#[test]
fn threshold_zero_is_every_pixel() {
    let drawn = draw([37, 11], 0.0, |_, _| 1.0);
    assert_eq!(drawn.stats.counts.rays, 37 * 11);
}

#[test]
fn pictures_that_bend_everywhere_are_traced_everywhere() {
    for size in [[1, 1], [1, 40], [41, 1], [9, 10], [31, 57]] {
        let bowl = |x: f64, y: f64| (0.01 * x * x + 0.03 * y * y) as f32;
        let drawn = draw(size, 1e-3, |x, y| f64::from(bowl(x, y)));
        // Up to the corners of the last cells.
        let points = size.map(|n: u32| u64::from((n - 1).div_ceil(4).max(1) * 4 + 1));
        assert_eq!(drawn.stats.counts.rays, points[0] * points[1], "{size:?}");
        for (i, found) in drawn.frame.pixels().iter().enumerate() {
            let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
            assert_eq!(found[0], bowl(f64::from(x) + 0.5, f64::from(y) + 0.5), "{x} {y} of {size:?}");
        }
    }
}

#[test]
fn smooth_pictures_are_interpolated_to_fourth_order() {
    let wave = |x: f64, y: f64| 0.5 + 0.2 * libm::sin(0.1 * x) + 0.2 * libm::cos(0.07 * y);
    let drawn = draw([101, 101], 0.5, wave);
    assert_eq!(drawn.stats.counts.rays, 26 * 26);
    // Cubics at distances of 4, then 2: an error of 3/128·h⁴·f⁗ each along each axis, but for the ends, where they are straight.
    let fourth = 0.2 * (0.1f64.powi(4) + 0.07f64.powi(4));
    let bound = 3.0 / 128.0 * (256.0 + 16.0) * fourth + 1e-6;
    for y in 8..93 {
        for x in 8..93 {
            let error = (f64::from(drawn.frame.pixel(x, y)[0]) - wave(f64::from(x) + 0.5, f64::from(y) + 0.5)).abs();
            assert!(error <= bound, "{x} {y}: {error} {bound}");
        }
    }
}

#[test]
fn a_layer_is_traced_where_it_shows() {
    let view = view([64, 64]);
    let shown = |i: usize| i == 64 * 20 + 13;
    let pixel = |i: usize| ([1.0, 0.0, 0.0], if shown(i) { 1.0 } else { f32::INFINITY });
    let layer = Layer { pixels: (0..64 * 64).map(pixel).collect() };
    struct Layered<'a>(&'a Layer);
    impl Tracer for Layered<'_> {
        fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, _: &mut Counts) {
            values.extend(spots.iter().map(|s| RaySample::NOTHING.over(self.0, s.pixel)));
        }
    }
    let frame = adaptive(&Layered(&layer), (&view, Some(&layer)), rays(0.1), &Control::default()).unwrap().frame;
    for (i, p) in frame.pixels().iter().enumerate() {
        assert_eq!(p[0], f32::from(u8::from(shown(i))), "{i}");
    }
}
