use glam::{DMat3, DVec2, DVec3};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, RngSeed};
use vr_core::{Clip, Placement, Plane};

use super::*;

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 256,
        failure_persistence: None,
        rng_algorithm: RngAlgorithm::ChaCha,
        rng_seed: RngSeed::Fixed(0x5eed),
        ..ProptestConfig::default()
    }
}

/// A box under a shear: its corners, and its volume.
fn any_box() -> impl Strategy<Value = ([DVec3; 8], f64)> {
    let number = || -1.0..1.0f64;
    (prop::array::uniform3(0.2..5.0f64), prop::array::uniform6(number())).prop_map(|(size, skew)| {
        let axes = DMat3::from_cols(
            DVec3::new(1.0, 0.3 * skew[0], 0.3 * skew[1]),
            DVec3::new(0.3 * skew[2], 1.0, 0.3 * skew[3]),
            DVec3::new(0.3 * skew[4], 0.3 * skew[5], 1.0),
        );
        let placement = Placement::new(DVec3::new(skew[1], skew[3], skew[5]), axes).expect("no singular matrix");
        let extent = DVec3::from_array(size);
        (box_corners(&placement, DVec3::ZERO, extent), axes.determinant().abs() * extent.element_product())
    })
}

/// A unit vector; along an axis of the world as often as not.
fn direction() -> impl Strategy<Value = DVec3> {
    let any = prop::array::uniform3(-1.0..1.0f64)
        .prop_map(DVec3::from_array)
        .prop_filter("has a direction", |d| d.length() > 1e-3)
        .prop_map(DVec3::normalize);
    prop_oneof![any, Just(DVec3::X), Just(DVec3::NEG_Y), Just(DVec3::Z)]
}

fn extent(corners: &[DVec3; 8], normal: DVec3) -> (f64, f64) {
    let along = corners.map(|c| c.dot(normal));
    (along.into_iter().fold(f64::INFINITY, f64::min), along.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

/// Distance of a point from the nearest edge of a box.
fn to_edges(corners: &[DVec3; 8], p: DVec3) -> f64 {
    let edge = |a: usize, b: usize| {
        let (from, along) = (corners[a], corners[b] - corners[a]);
        let t = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (p - from - t * along).length()
    };
    let pairs = (0..8).flat_map(|a| [1, 2, 4].map(|bit| (a, a ^ bit))).filter(|(a, b)| a < b);
    pairs.map(|(a, b)| edge(a, b)).fold(f64::INFINITY, f64::min)
}

/// A whole box.
fn body(corners: &[DVec3; 8]) -> Body {
    Body::new(corners, [])
}

/// The convex hull of points of the image, counter-clockwise where y grows downwards from the top: Andrew 1979, "Another efficient algorithm for convex
/// hulls in two dimensions".
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

fn flat(points: &[DVec2]) -> Polygon {
    Polygon { corners: points.iter().map(|p| p.extend(0.0)).collect() }
}

/// Number of times that each pixel is covered.
fn times_covered(spans: impl Iterator<Item = Span>, size: [u32; 2]) -> Vec<u32> {
    let mut counts = vec![0; (size[0] * size[1]) as usize];
    for span in spans {
        (span.begin..span.end).for_each(|x| counts[(span.y * size[0] + x) as usize] += 1);
    }
    counts
}

/// The spans of polygons.
fn covered(polygons: &[Vec<DVec2>], size: [u32; 2]) -> Vec<u32> {
    times_covered(polygons.iter().flat_map(|p| polygon_spans(&flat(p), size)), size)
}

/// Distance of a point from a polygon's outline.
fn to_outline(polygon: &[DVec2], p: DVec2) -> f64 {
    let n = polygon.len();
    let edge = |i: usize| {
        let (from, along) = (polygon[i], polygon[(i + 1) % n] - polygon[i]);
        let t = ((p - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (p - from - t * along).length()
    };
    (0..n).map(edge).fold(f64::INFINITY, f64::min)
}

proptest! {
    #![proptest_config(config())]

    /// The midpoint rule over cross-sections: off by less than a slice of the largest of them.
    #[test]
    fn slices_times_distance_are_the_volume((corners, volume) in any_box(), normal in direction(), count in 1..60u32) {
        let (low, high) = extent(&corners, normal);
        let d = (high - low) / f64::from(count) * 0.997;
        let (mut sum, mut largest) = (0.0, 0.0f64);
        let mut at = low + 0.5 * d;
        while at < high {
            let slice = body(&corners).slice(&HalfSpace { normal, offset: at });
            let area = slice.area_vector();
            prop_assert!(area.dot(normal) >= 0.0, "counter-clockwise seen from the tip of the normal");
            prop_assert!(area.cross(normal).length() <= 1e-9 * (1.0 + area.length()), "in the plane");
            sum += area.length() * d;
            largest = largest.max(area.length());
            at += d;
        }
        prop_assert!((sum - volume).abs() <= d * largest * (1.0 + 1e-9), "{sum} {volume}");
    }

    #[test]
    fn corners_lie_on_edges_and_turn_one_way((corners, _) in any_box(), normal in direction(), t in 0.001..0.999f64) {
        let (low, high) = extent(&corners, normal);
        let slice = body(&corners).slice(&HalfSpace { normal, offset: low + t * (high - low) });
        let n = slice.corners.len();
        prop_assert!((3..=6).contains(&n), "{n}");
        for i in 0..n {
            let [a, b, c] = [i, (i + 1) % n, (i + 2) % n].map(|k| slice.corners[k]);
            prop_assert!(to_edges(&corners, a) < 1e-12 * 10.0, "rounding of numbers below 10");
            // Rounding of corners that nearly coincide.
            prop_assert!((b - a).cross(c - b).dot(normal) > -1e-12, "convex");
        }
        prop_assert_eq!(slice.triangles().count(), n - 2);
        let parts: f64 = slice.triangles().map(|[a, b, c]| 0.5 * (b - a).cross(c - a).dot(normal)).sum();
        prop_assert!((parts - slice.area_vector().length()).abs() < 1e-9);
    }

    /// Every pixel inside a polygon cut into triangles, or inside two that share an edge, is drawn once, whichever way they lie; corners on pixel
    /// centres and edges through them are as frequent as others.
    #[test]
    fn every_pixel_is_covered_once(points in prop::collection::vec(prop::array::uniform2(-4..44i32), 3..9), cut in 0..9usize) {
        let size = [20, 20];
        let points = points.iter().map(|p| 0.5 * DVec2::new(f64::from(p[0]), f64::from(p[1]))).collect();
        let whole = hull(points);
        prop_assume!(whole.len() > 2);
        let count = |polygons: &[Vec<DVec2>]| covered(polygons, size);
        let once = count(std::slice::from_ref(&whole));
        prop_assert!(once.iter().all(|&c| c <= 1));
        let n = whole.len();
        let fan: Vec<_> = (1..n - 1).map(|i| vec![whole[cut % n], whole[(cut + i) % n], whole[(cut + i + 1) % n]]).collect();
        prop_assert_eq!(&count(&fan), &once);
        let middle = 0.5 * (whole[0] + whole[n / 2]);
        let star: Vec<_> = (0..n).map(|i| vec![middle, whole[i], whole[(i + 1) % n]]).collect();
        prop_assert_eq!(&count(&star), &once, "round a point inside, that may lie on an edge");
        let turned: Vec<DVec2> = whole.iter().rev().copied().collect();
        prop_assert_eq!(&count(&[turned]), &once);
    }

    /// Cells of a grid whose corners lie anywhere near their places, each cut along either diagonal: every pixel of the whole is in one triangle, whichever
    /// way its corners are named; corners on pixel centres and edges through them are as frequent as others.
    #[test]
    fn every_pixel_is_in_one_triangle(
        moved in prop::collection::vec(prop::array::uniform2(-3..=3i64), 36),
        diagonals in prop::collection::vec(any::<bool>(), 25),
        turns in prop::collection::vec(any::<bool>(), 50),
        at in prop::array::uniform2(-3..=3i64),
    ) {
        let size = [20, 20];
        // Quarters of a pixel, four pixels to a cell; corners move by less than a quarter of one, and those of the rim stay.
        let quarter = SUBPIXELS / 4;
        let corner = |x: usize, y: usize| {
            let rim = x == 0 || y == 0 || x == 5 || y == 5;
            let by = if rim { [0; 2] } else { moved[6 * y + x] };
            [(16 * x as i64 + by[0] + at[0]) * quarter, (16 * y as i64 + by[1] + at[1]) * quarter]
        };
        let mut triangles = Vec::new();
        for i in 0..25 {
            let (x, y) = (i % 5, i / 5);
            let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
            triangles.extend(if diagonals[i] { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
        let named = triangles.iter().zip(&turns).map(|(&[a, b, c], &turned)| if turned { [c, b, a] } else { [b, c, a] });
        let counts = times_covered(named.flat_map(|t| triangle_spans(t, size)), size);
        // Centres with rim ≤ centre < rim, as the rule has it.
        let inside = |x: u32, a: usize| {
            let centre = i64::from(x) * SUBPIXELS + SUBPIXELS / 2 - at[a] * quarter;
            (0..80 * quarter).contains(&centre)
        };
        for (i, &count) in counts.iter().enumerate() {
            let (x, y) = (i as u32 % 20, i as u32 / 20);
            prop_assert_eq!(count, u32::from(inside(x, 0) && inside(y, 1)), "{} {}", x, y);
        }
    }

    /// Boxes side by side: slices of each, drawn one after the other, cover what slices of both together do, but for what rounding of corners does along
    /// the outline.
    #[test]
    fn boxes_that_share_a_face_share_no_pixel(normal in direction(), t in 0.01..0.99f64, split in 1..7u32, axis in 0..3usize) {
        let placement = Placement::from_spacing([1.0, 0.8, 1.3]).expect("a placement");
        let whole = box_corners(&placement, DVec3::ZERO, DVec3::splat(7.0));
        let (low, high) = extent(&whole, normal);
        let plane = HalfSpace { normal, offset: low + t * (high - low) };
        let (right, up) = (normal.any_orthonormal_vector(), normal.cross(normal.any_orthonormal_vector()));
        let seen = |corners: &[DVec3; 8]| -> Vec<DVec2> {
            let slice = body(corners).slice(&plane).corners;
            slice.iter().map(|c| 4.0 * DVec2::new(c.dot(right), c.dot(up)) + 40.0).collect()
        };
        let (mut below, mut above) = (DVec3::splat(7.0), DVec3::ZERO);
        (below[axis], above[axis]) = (f64::from(split), f64::from(split));
        let parts = [box_corners(&placement, DVec3::ZERO, below), box_corners(&placement, above, DVec3::splat(7.0))];
        let size = [80, 80];
        let (both, whole) = (covered(&parts.each_ref().map(seen), size), seen(&whole));
        prop_assert!(both.iter().all(|&c| c <= 1), "twice");
        for (i, (&of_parts, of_whole)) in both.iter().zip(covered(std::slice::from_ref(&whole), size)).enumerate() {
            let centre = DVec2::new((i % 80) as f64 + 0.5, (i / 80) as f64 + 0.5);
            prop_assert!(of_parts == of_whole || to_outline(&whole, centre) < 2.0 / SUBPIXELS as f64, "left out");
        }
    }

    /// Slabs of a clipped box: hulls of their corners hold every point of theirs, and no corner lies outside the clip.
    #[test]
    fn slabs_hold_what_is_between_their_planes(
        (corners, _) in any_box(), normal in direction(), t in 0.0..0.8f64, cut in direction(), at in prop::array::uniform3(0.1..0.9f64),
    ) {
        let (low, high) = extent(&corners, normal);
        let (from, to) = (low + t * (high - low), low + (t + 0.2) * (high - low));
        let point = |w: DVec3| corners[0] + w.x * (corners[1] - corners[0]) + w.y * (corners[2] - corners[0]) + w.z * (corners[4] - corners[0]);
        let inside = point(DVec3::from_array(at));
        let clip = Clip { planes: vec![Plane { normal: cut, offset: cut.dot(inside) - 0.1 }], ..Clip::default() };
        let sides = [HalfSpace { normal, offset: from }, HalfSpace { normal: -normal, offset: -to }];
        let slab: Vec<DVec3> = Body::new(&corners, half_spaces(&clip).into_iter().chain(sides)).corners().collect();
        for c in &slab {
            prop_assert!(c.dot(normal) >= from - 1e-9 && c.dot(normal) <= to + 1e-9);
            prop_assert!(c.dot(cut) >= cut.dot(inside) - 0.1 - 1e-9);
        }
        if inside.dot(normal) > from && inside.dot(normal) < to {
            let (right, up) = (normal.any_orthonormal_vector(), normal.cross(normal.any_orthonormal_vector()));
            let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
            let outline = hull(slab.iter().map(|&c| flat(c)).collect());
            let n = outline.len();
            prop_assert!(n > 2);
            for i in 0..n {
                let (a, b) = (outline[i], outline[(i + 1) % n]);
                prop_assert!((b - a).perp_dot(flat(inside) - a) > -1e-9);
            }
        }
    }
}

/// An edge that leaves the picture is the same line whether one polygon has all of it or two have a half each.
#[test]
fn an_edge_is_not_moved_where_it_leaves_the_picture() {
    let [a, b, c] = [DVec2::new(-1.5, 18.0), DVec2::new(8.5, -1.0), DVec2::new(18.0, 6.0)];
    let (whole, middle) = (vec![a, b, c], 0.5 * (a + b));
    let halves = [vec![a, middle, c], vec![middle, b, c]];
    assert_eq!(covered(&[whole], [20, 20]), covered(&halves, [20, 20]));
}

#[test]
fn a_slice_that_misses_or_touches_is_nothing() {
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let corners = box_corners(&placement, DVec3::ZERO, DVec3::ONE);
    for offset in [-0.1, 1.1] {
        assert_eq!(body(&corners).slice(&HalfSpace { normal: DVec3::Z, offset }).corners.len(), 0);
    }
    let middle = body(&corners).slice(&HalfSpace { normal: DVec3::ONE, offset: 1.5 });
    assert_eq!(middle.corners.len(), 6);
}
