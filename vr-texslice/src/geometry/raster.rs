//! Triangles of the image, rasterised in spans as graphics cards do: corners on a grid finer than pixels, edges in whole numbers.

use glam::{DVec2, DVec3};

use super::polygon::{HalfSpace, Polygon};

/// A row of pixels that a triangle covers: from `begin` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The row, from the top.
    pub y: u32,
    /// The first pixel.
    pub begin: u32,
    /// Behind the last one.
    pub end: u32,
}

/// Parts of a pixel, along each axis, that corners of triangles are rounded to: 2⁸, as graphics cards have it.
pub const SUBPIXELS: i64 = 256;

/// A point of the image on the grid of [`SUBPIXELS`].
pub fn snapped(point: DVec2) -> [i64; 2] {
    (point * SUBPIXELS as f64).round().to_array().map(|c| c as i64)
}

/// The rows of a triangle, given by its corners on the grid of [`SUBPIXELS`] in either order, within a picture. Corners must lie within 2²⁸ of the origin:
/// products of two of them are exact then.
///
/// A pixel is covered if its centre, (x + ½, y + ½), lies inside. A centre on an edge belongs to the triangle to its right or below it: the top-left
/// rule. Whole numbers round nothing, so of two triangles that share an edge exactly one has the centres on it: none is covered twice, and none left out.
pub fn triangle_spans(corners: [[i64; 2]; 3], size: [u32; 2]) -> impl Iterator<Item = Span> {
    let [a, b, c] = corners;
    let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    // Every edge function is positive inside.
    let [a, b, c] = if twice_area < 0 { [a, c, b] } else { [a, b, c] };
    let edges = [[a, b], [b, c], [c, a]];
    let half = SUBPIXELS / 2;
    let first_centre = |from: i64| (from + half).div_euclid(SUBPIXELS);
    let rows = if twice_area == 0 {
        0..0
    } else {
        let (top, bottom) = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
        // The edges decide which centres on the top and the bottom count.
        (first_centre(top - 1)).clamp(0, size[1].into())..(first_centre(bottom) + 1).clamp(0, size[1].into())
    };
    rows.filter_map(move |y| {
        let y_centre = SUBPIXELS * y + half;
        // Columns of centres, as far as the picture goes.
        let (mut begin, mut end) = (half, SUBPIXELS * i64::from(size[0]));
        for [p, q] in edges {
            let (dx, dy) = (q[0] - p[0], q[1] - p[1]);
            // Edge function dx·(y − p.y) − dy·(x − p.x): at least 0 on a top or a left edge, at least 1 on others.
            let least = i64::from(!(dy < 0 || (dy == 0 && dx > 0)));
            let along = dx * (y_centre - p[1]);
            if dy == 0 && along < least {
                return None;
            }
            if dy < 0 {
                // ⌈n / d⌉ = −⌊−n / d⌋
                begin = begin.max(p[0] - (along - least).div_euclid(-dy));
            } else if dy > 0 {
                end = end.min(p[0] + (along - least).div_euclid(dy) + 1);
            }
        }
        // Centres with begin ≤ x < end.
        let column = |x: i64| (x - half + SUBPIXELS - 1).div_euclid(SUBPIXELS) as u32;
        (begin < end).then(|| Span { y: y as u32, begin: column(begin), end: column(end) }).filter(|s| s.begin < s.end)
    })
}

/// Pixels around the picture up to which polygons are rasterised as they are: half of what corners may be away. One cut at the picture's own rim would have its corners
/// rounded there, and its edges inside the picture moved by that: no longer where those of its neighbours are.
const GUARD: f64 = (1u64 << 19) as f64;

/// The rows of a convex polygon of the image (x and y of its corners, in pixels), as a fan of triangles; what lies beyond a guard band is cut off, so that no
/// corner is too far away.
pub fn polygon_spans(polygon: &Polygon, size: [u32; 2]) -> impl Iterator<Item = Span> + use<> {
    let [w, h] = size.map(f64::from);
    let guards = [(DVec3::X, 0.0), (DVec3::NEG_X, -w), (DVec3::Y, 0.0), (DVec3::NEG_Y, -h)];
    let near = guards
        .into_iter()
        .fold(polygon.clone(), |p, (normal, offset)| p.clipped(&HalfSpace { normal, offset: offset - GUARD }));
    let triangles: Vec<_> = near.triangles().map(|t| t.map(|corner| snapped(corner.truncate()))).collect();
    triangles.into_iter().flat_map(move |t| triangle_spans(t, size))
}
