//! The warp against the formula, pixel by pixel in f64.

use fearless_simd::{Level, dispatch};
use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_kernels::vector::baseline;

use super::*;

/// Every level that the machine has.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut all = vec![best];
    #[cfg(target_arch = "x86_64")]
    all.extend([best.as_avx2().map(Level::Avx2), best.as_sse2().map(Level::Sse2)].into_iter().flatten());
    all
}

/// A texture that owns its pixels.
#[derive(Clone, Debug)]
struct Canvas {
    pixels: Vec<[f32; 4]>,
    size: [usize; 2],
    filled: [usize; 4],
}

impl Canvas {
    /// Random texels in a rectangle, zeros around it.
    fn noise(size: [usize; 2], filled: [usize; 4], seed: u64) -> Self {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let texel = |i: usize| {
            let (x, y) = (i % size[0], i / size[0]);
            let color: [f32; 4] = std::array::from_fn(|_| random());
            let inside = (filled[0]..filled[2]).contains(&x) && (filled[1]..filled[3]).contains(&y);
            if inside { color } else { [0.0; 4] }
        };
        Self { pixels: (0..size[0] * size[1]).map(texel).collect(), size, filled }
    }

    fn constant(size: [usize; 2], color: [f32; 4]) -> Self {
        Self { pixels: vec![color; size[0] * size[1]], size, filled: [0, 0, size[0], size[1]] }
    }

    fn texture(&self) -> Texture<'_> {
        Texture { pixels: &self.pixels, size: self.size, filled: self.filled }
    }

    fn warp(&self, to_texture: DMat3, filter: WarpFilter, samples: u32) -> Warp<'_> {
        Warp { texture: self.texture(), to_texture, within: None, filter, samples, surfaces: None }
    }
}

fn draw_at(level: Level, warp: &Warp<'_>, size: [usize; 2], before: [f32; 4]) -> Vec<[f32; 4]> {
    let mut all = vec![before; size[0] * size[1]];
    for (y, row) in all.chunks_mut(size[0]).enumerate() {
        dispatch!(level, simd => warp.row(simd, y as u32, row));
    }
    all
}

fn draw(warp: &Warp<'_>, size: [usize; 2]) -> Vec<[f32; 4]> {
    draw_at(Level::new(), warp, size, [0.0; 4])
}

/// Keys 1981, equation 15, with a = −½.
fn keys(s: f64) -> f64 {
    let s = s.abs();
    match s {
        _ if s <= 1.0 => (1.5 * s - 2.5) * s * s + 1.0,
        _ if s <= 2.0 => ((-0.5 * s + 2.5) * s - 4.0) * s + 2.0,
        _ => 0.0,
    }
}

fn hat(s: f64) -> f64 {
    (1.0 - s.abs()).max(0.0)
}

/// A pixel by the formula; `None` where no sample sees a texel of the filled rectangle.
fn reference(warp: &Warp<'_>, x: usize, y: usize) -> Option<[f64; 4]> {
    let Texture { pixels, size, filled } = warp.texture;
    let (reach, weight): (i64, fn(f64) -> f64) = match warp.filter {
        WarpFilter::Bilinear => (1, hat),
        WarpFilter::Cubic => (2, keys),
    };
    let n = warp.samples;
    let (mut sum, mut seen) = ([0.0; 4], false);
    for sample in 0..n * n {
        let [dx, dy] = [sample % n, sample / n].map(|i| (f64::from(i) + 0.5) / f64::from(n));
        let at = warp.to_texture * DVec3::new(x as f64 + dx, y as f64 + dy, 1.0);
        let (px, py) = (at.x / at.z, at.y / at.z);
        let within = warp.within.is_none_or(|[x0, y0, x1, y1]| px >= x0 && px < x1 && py >= y0 && py < y1);
        if !(at.z > 0.0 && px.is_finite() && py.is_finite() && within && px.abs().max(py.abs()) < 1e9) {
            continue;
        }
        let mut value = [0.0; 4];
        let (column, row) = (px.floor() as i64, py.floor() as i64);
        for j in row + 1 - reach..=row + reach {
            for i in column + 1 - reach..=column + reach {
                let inside = |a: i64, axis: usize| a >= filled[axis] as i64 && a < filled[axis + 2] as i64;
                if inside(i, 0) && inside(j, 1) {
                    seen = true;
                    let texel = pixels[j as usize * size[0] + i as usize];
                    let weight = weight(px - i as f64) * weight(py - j as f64);
                    value = std::array::from_fn(|c| value[c] + weight * f64::from(texel[c]));
                }
            }
        }
        if warp.filter == WarpFilter::Cubic {
            value = value.map(|x| x.max(0.0));
            value[3] = value[3].min(1.0);
        }
        sum = std::array::from_fn(|c| sum[c] + value[c] / f64::from(n * n));
    }
    seen.then_some(sum)
}

fn textures() -> impl Strategy<Value = Canvas> {
    let size = prop_oneof![
        8 => [1usize..60, 1usize..60],
        1 => [1usize..3, 1usize..3],
        // Large coordinates: positions must keep their fractions.
        1 => [3900usize..4097, 1usize..9]
    ];
    (size, prop::array::uniform4(0.0f64..1.0), any::<bool>(), any::<u64>()).prop_map(|(size, cut, whole, seed)| {
        let cut = |a: usize, n: usize| {
            let (low, high) = ((cut[a] * n as f64) as usize, (cut[a + 2] * n as f64) as usize + 1);
            if whole { (0, n) } else { (low, high) }
        };
        let ((x0, x1), (y0, y1)) = (cut(0, size[0]), cut(1, size[1]));
        // First behind last: empty.
        Canvas::noise(size, [x0, y0, x1, y1], seed)
    })
}

/// Maps of a screen onto a texture and its surroundings: rotated, scaled, sheared, and seen in perspective, with or without a horizon.
fn maps() -> impl Strategy<Value = Place> {
    let tilt = prop_oneof![2 => Just([0.0; 2]), 3 => prop::array::uniform2(-0.4f64..0.4), 2 => prop::array::uniform2(-2.0f64..2.0)];
    (prop::array::uniform4(-2.0f64..2.0), prop::array::uniform2(0.1f64..0.9), tilt, 0.1f64..8.0)
}

/// (linear part, where the middle of the screen lands, tilt, scale of the homogeneous matrix).
type Place = ([f64; 4], [f64; 2], [f64; 2], f64);

fn map((linear, middle, tilt, scale): Place, texture: [usize; 2], screen: [usize; 2]) -> DMat3 {
    let [w, h] = screen.map(|n| n as f64);
    let centred = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-w / 2.0, -h / 2.0, 1.0));
    let [a, b, c, d] = linear;
    let [p, q] = tilt;
    let turned = DMat3::from_cols(DVec3::new(a, b, p / w), DVec3::new(c, d, q / h), DVec3::Z);
    let [x, y] = [middle[0] * texture[0] as f64, middle[1] * texture[1] as f64];
    let placed = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(x, y, 1.0)) * turned * centred;
    if tilt == [0.0; 2] { placed } else { placed * scale }
}

fn filters() -> impl Strategy<Value = WarpFilter> {
    prop::sample::select(&[WarpFilter::Bilinear, WarpFilter::Cubic][..])
}

/// A rectangle in shares of a texture.
fn rectangle(shares: Option<[f64; 4]>, size: [usize; 2]) -> Option<[f64; 4]> {
    let [w, h] = size.map(|n| n as f64);
    shares.map(|[x0, y0, x1, y1]| [x0 * w, y0 * h, x1 * w, y1 * h])
}

fn shares() -> impl Strategy<Value = Option<[f64; 4]>> {
    prop::option::of([-0.3f64..0.6, -0.3f64..0.6, 0.4f64..1.3, 0.4f64..1.3])
}

fn sizes() -> impl Strategy<Value = [usize; 2]> {
    [1usize..70, 1usize..20]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_pixel_is_as_the_formula_says(
        canvas in textures(), place in maps(), filter in filters(), samples in 1u32..4, shares in shares(), size in sizes(),
    ) {
        let warp = Warp {
            within: rectangle(shares, canvas.size),
            ..canvas.warp(map(place, canvas.size, size), filter, samples)
        };
        let before = [0.25, 3.0, -1.0, 0.5];
        let drawn = draw_at(Level::new(), &warp, size, before);
        for (i, pixel) in drawn.iter().enumerate() {
            let (x, y) = (i % size[0], i / size[0]);
            match reference(&warp, x, y) {
                None => prop_assert_eq!(*pixel, before, "at {:?}", (x, y)),
                Some(expected) => {
                    prop_assert!(warp.columns(y as u32, size[0]).contains(&x));
                    for c in 0..4 {
                        let expected = expected[c] + if samples > 1 { f64::from(before[c]) } else { 0.0 };
                        let error = (f64::from(pixel[c]) - expected).abs();
                        prop_assert!(error <= 1e-5, "{pixel:?} for {expected} at {:?}", (x, y));
                    }
                }
            }
        }
    }

    #[test]
    fn all_levels_give_the_same_bits(
        canvas in textures(), place in maps(), filter in filters(), samples in 1u32..3, shares in shares(), size in sizes(),
    ) {
        let warp = Warp {
            within: rectangle(shares, canvas.size),
            ..canvas.warp(map(place, canvas.size, size), filter, samples)
        };
        let bits = |level| -> Vec<[u32; 4]> {
            draw_at(level, &warp, size, [0.0; 4]).iter().map(|p| p.map(f32::to_bits)).collect()
        };
        let all: Vec<_> = levels().into_iter().map(bits).collect();
        for other in &all[1..] {
            prop_assert_eq!(other, &all[0]);
        }
    }

    #[test]
    fn two_parts_make_the_whole(
        canvas in textures(), place in maps(), filter in filters(), size in sizes(), share in 0.0f64..1.0,
    ) {
        let whole = canvas.warp(map(place, canvas.size, size), filter, 2);
        let cut = share * canvas.size[0] as f64;
        let (far, near) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut sum = vec![[0.0; 4]; size[0] * size[1]];
        for part in [[near, near, cut, far], [cut, near, far, far]] {
            let part = Warp { within: Some(part), ..whole };
            for (y, row) in sum.chunks_mut(size[0]).enumerate() {
                part.row(baseline(), y as u32, row);
            }
        }
        for (a, b) in sum.iter().zip(draw(&whole, size)) {
            prop_assert!((0..4).all(|c| (a[c] - b[c]).abs() <= 1e-6), "{a:?} for {b:?}");
        }
    }

    #[test]
    fn no_matrix_is_too_wild(
        canvas in textures(), filter in filters(), samples in 1u32..3, size in sizes(),
        entries in prop::array::uniform9(prop_oneof![
            Just(0.0), Just(1.0), Just(-1.0), Just(f64::MAX), Just(-f64::MAX), Just(f64::MIN_POSITIVE), Just(5e-324), -1e3f64..1e3,
            Just(1e16), Just(f64::INFINITY), Just(f64::NAN)
        ]),
    ) {
        let warp = canvas.warp(DMat3::from_cols_array(&entries), filter, samples);
        for pixel in draw(&warp, size) {
            prop_assert!(pixel.iter().all(|x| x.is_finite()));
        }
    }
}

/// Texel (i, j) at the centre of pixel (i, j).
fn identity() -> DMat3 {
    DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-0.5, -0.5, 1.0))
}

#[test]
fn texels_at_pixels_are_copied() {
    let canvas = Canvas::noise([37, 21], [0, 0, 37, 21], 5);
    for filter in [WarpFilter::Bilinear, WarpFilter::Cubic] {
        assert_eq!(draw(&canvas.warp(identity(), filter, 1), [37, 21]), canvas.pixels);
    }
}

#[test]
fn a_constant_stays_constant() {
    let color = [0.3, 0.7, 0.1, 1.0];
    let canvas = Canvas::constant([50, 40], color);
    // From the 20 × 10 pixels into the middle of the texture.
    let turned =
        DMat3::from_cols(DVec3::new(0.9, 0.4, 0.003), DVec3::new(-0.4, 0.9, -0.002), DVec3::new(15.0, 12.0, 1.0));
    for pixel in draw(&canvas.warp(turned, WarpFilter::Bilinear, 1), [20, 10]) {
        assert_eq!(pixel, color);
    }
    for samples in 1..6 {
        for pixel in draw(&canvas.warp(turned, WarpFilter::Bilinear, samples), [20, 10]) {
            assert!((0..4).all(|c| (pixel[c] - color[c]).abs() <= 5e-7), "{pixel:?}");
            assert_eq!(pixel[3], 1.0);
        }
        for pixel in draw(&canvas.warp(turned, WarpFilter::Cubic, samples), [20, 10]) {
            assert!((0..4).all(|c| (pixel[c] - color[c]).abs() <= 1e-6), "{pixel:?}");
        }
    }
}

#[test]
fn edges_fade_without_darkening() {
    let canvas = Canvas::constant([1, 1], [0.5, 0.25, 1.0, 1.0]);
    let halfway = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(-1.0, -0.5, 1.0));
    let drawn = draw(&canvas.warp(halfway, WarpFilter::Bilinear, 1), [3, 1]);
    assert_eq!(drawn, [[0.25, 0.125, 0.5, 0.5], [0.25, 0.125, 0.5, 0.5], [0.0; 4]]);
}

#[test]
fn what_overshoots_is_cut_off() {
    // A step from nothing to all: beyond 1 on its upper side, below 0 before its lower one.
    let mut canvas = Canvas::constant([8, 1], [1.0; 4]);
    canvas.pixels[..4].fill([0.0; 4]);
    canvas.filled[0] = 4;
    let between = DMat3::from_cols(DVec3::X, DVec3::Y, DVec3::new(0.0, -0.5, 1.0));
    let drawn = draw(&canvas.warp(between, WarpFilter::Cubic, 1), [8, 1]);
    assert_eq!(drawn[2], [0.0; 4]);
    assert_eq!(drawn[3], [0.5; 4]);
    assert_eq!(drawn[4], [1.0625, 1.0625, 1.0625, 1.0]);
}

#[test]
fn nothing_is_seen_of_what_is_empty() {
    let canvas = Canvas { filled: [0; 4], ..Canvas::constant([5, 5], [1.0; 4]) };
    assert_eq!(canvas.warp(identity(), WarpFilter::Cubic, 2).columns(2, 5), 0..0);
    assert!(draw(&canvas.warp(identity(), WarpFilter::Cubic, 2), [5, 5]).iter().all(|p| *p == [0.0; 4]));
    let behind = -identity();
    let canvas = Canvas::constant([5, 5], [1.0; 4]);
    assert!(draw(&canvas.warp(behind, WarpFilter::Bilinear, 1), [5, 5]).iter().all(|p| *p == [0.0; 4]));
}

#[test]
fn columns_are_few() {
    let mut canvas = Canvas::constant([40, 9], [1.0; 4]);
    canvas.filled = [10, 2, 20, 5];
    for (filter, seen) in [(WarpFilter::Bilinear, 9..20), (WarpFilter::Cubic, 8..21)] {
        let columns = canvas.warp(identity(), filter, 2).columns(3, 64);
        assert!(columns.start <= seen.start && columns.start + 4 >= seen.start, "{columns:?}");
        assert!(columns.end >= seen.end && columns.end <= seen.end + 4, "{columns:?}");
        assert!(canvas.warp(identity(), filter, 1).columns(8, 64).is_empty());
    }
}
