//! Convex polygons of the image, rasterised in spans.

use glam::DVec2;

/// A row of pixels that a polygon covers: from `begin` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The row, from the top.
    pub y: u32,
    /// The first pixel.
    pub begin: u32,
    /// Behind the last one.
    pub end: u32,
}

/// The rows of a convex polygon, given by its corners in either order, within a picture.
///
/// A pixel is covered if its centre, (x + ½, y + ½), lies inside. A centre on an edge belongs to the polygon to its right or below it: the
/// top-left rule, as on graphics cards. Every polygon walks an edge from its upper end to its lower one, so polygons that share it round it
/// alike: of the pixels along it none is covered twice, and none is left out.
pub fn spans(corners: &[DVec2], size: [u32; 2]) -> impl Iterator<Item = Span> + '_ {
    let (top, bottom) = corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(t, b), c| (t.min(c.y), b.max(c.y)));
    // Centres with top ≤ y + ½ < bottom. `as` saturates, NaN being 0.
    let row = |y: f64| (y - 0.5).ceil().clamp(0.0, f64::from(size[1])) as u32;
    let rows = if corners.len() > 2 { row(top)..row(bottom) } else { 0..0 };
    rows.filter_map(move |y| {
        let centre = f64::from(y) + 0.5;
        let mut ends = [f64::INFINITY, f64::NEG_INFINITY];
        for i in 0..corners.len() {
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
            // Half open: a corner between two edges counts once.
            if a.y <= centre && centre < b.y {
                let x = a.x + (centre - a.y) / (b.y - a.y) * (b.x - a.x);
                ends = [ends[0].min(x), ends[1].max(x)];
            }
        }
        let column = |x: f64| (x - 0.5).ceil().clamp(0.0, f64::from(size[0])) as u32;
        let (begin, end) = (column(ends[0]), column(ends[1]));
        (begin < end).then_some(Span { y, begin, end })
    })
}
