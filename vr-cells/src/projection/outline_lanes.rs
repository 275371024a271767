//! A cell's projection in sixteen samples.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use vr_kernels::vector::{LANES, Lanes, splat};

use super::line::Line;
use super::outline::Outline;
use super::samples::{Numbers, ROW};
use super::screen_mesh::ScreenVertex;
use super::steps::Segments;
use super::tile_rays::Ends;
use super::tiling::MAX_SIDE;

/// A linear function, from a sample near by on: in `f32` as exact as the cell is large.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalLine {
    at: f32,
    a: f32,
    b: f32,
    /// The same numbers, for slivers.
    long: [f64; 3],
}

impl LocalLine {
    /// A line from the centre of a sample on.
    #[inline(always)]
    pub(super) fn new(line: &Line, centre: [f64; 2]) -> Self {
        let long = [line.at(centre), line.a, line.b];
        let [at, a, b] = long.map(|x| x as f32);
        Self { at, a, b, long }
    }

    /// The values at some samples.
    #[inline(always)]
    pub(super) fn at<S: Simd>(&self, [x, y]: [f32x16<S>; 2]) -> f32x16<S> {
        x * self.a + (y * self.b + self.at)
    }

    /// The values at some samples, in `f64`.
    #[inline(never)]
    fn slowly(&self, [x, y]: &[[f32; LANES]; 2]) -> Lanes {
        let [at, a, b] = self.long;
        Lanes(std::array::from_fn(|i| (at + a * f64::from(x[i]) + b * f64::from(y[i])) as f32))
    }
}

/// A cell's projection, for sixteen samples at a time.
pub(super) struct OutlineLanes {
    /// The sample from which places are counted.
    from: [f32; 2],
    /// Its centre.
    pub(super) centre: [f64; 2],
    /// The part of the thickness at the apex as far as each edge goes; the last one twice in triangles.
    edges: [LocalLine; 4],
    depth: LocalLine,
    value: LocalLine,
    /// See [`super::outline::Surface::kink`]; without one, nothing changes behind it.
    kink: LocalLine,
    more: [f32; 2],
    base_is_front: bool,
    rise: [f32; 2],
    /// Lowest and highest place in the table of the cell's values.
    range: [f32; 2],
    /// True for a sliver.
    is_steep: bool,
}

/// Change of the part of the thickness over a tile, or a cell in it, from which on digits are short: as many times the rounding of `f32` are lost.
const STEEP: f64 = 512.0;

impl OutlineLanes {
    /// The projection of a cell that has a sample, with the lowest and the highest place in the table of its values.
    #[inline(always)]
    pub(super) fn new(outline: &Outline, corners: &[ScreenVertex; 4], range: [f32; 2], sample: u32) -> Self {
        let from = [sample % MAX_SIDE, (sample >> ROW) % MAX_SIDE];
        let centre = from.map(|n| f64::from(n) + 0.5);
        let edges = outline.edges.each_ref().map(|edge| {
            let mut line = edge.line.scaled(edge.scale);
            line.c += edge.bias;
            LocalLine::new(&line, centre)
        });
        let (kink, more) = outline.base.kink.unwrap_or((Line::constant(0.0), [0.0; 2]));
        let [width, height] = [0, 1].map(|a| {
            let [p, q, r, s] = corners.map(|c| c.at[a]);
            (p.max(q).max(r.max(s)) - p.min(q).min(r.min(s))).min(f64::from(MAX_SIDE))
        });
        let change = |line: &Line| line.a.abs() * width + line.b.abs() * height;
        let is_steep = outline.edges.iter().any(|e| change(&e.line) * e.scale > STEEP) || change(&kink) > STEEP;
        Self {
            from: from.map(|n| n as f32),
            centre,
            edges,
            depth: LocalLine::new(&outline.base.depth, centre),
            value: LocalLine::new(&outline.base.value, centre),
            kink: LocalLine::new(&kink, centre),
            more: more.map(|x| x as f32),
            base_is_front: outline.base_is_front,
            rise: outline.rise.map(|x| x as f32),
            range,
            is_steep,
        }
    }

    /// Places of some samples, from the first one.
    #[inline(always)]
    pub(super) fn places<S: Simd>(&self, simd: S, numbers: &Numbers) -> [f32x16<S>; 2] {
        let numbers = u32x16::load_array_ref(simd, numbers);
        let (x, y) = (numbers & (MAX_SIDE - 1), (numbers >> ROW) & (MAX_SIDE - 1));
        [x.to_float::<f32x16<S>>() - self.from[0], y.to_float::<f32x16<S>>() - self.from[1]]
    }

    /// The part of the thickness at the apex as far as one edge goes.
    #[inline(always)]
    pub(super) fn edge<S: Simd>(&self, i: usize, places: [f32x16<S>; 2]) -> f32x16<S> {
        self.edges[i].at(places)
    }

    /// The edges' parts, depth and value on the base, and the function of the kink.
    #[inline(always)]
    fn values<S: Simd>(&self, simd: S, places: [f32x16<S>; 2]) -> [f32x16<S>; 7] {
        let [a, b, c, d] = &self.edges;
        if self.is_steep {
            let [p, q, r, s, t, u, v] = self.slow_values(&[places[0].to_array(), places[1].to_array()]);
            return [p.load(simd), q.load(simd), r.load(simd), s.load(simd), t.load(simd), u.load(simd), v.load(simd)];
        }
        let (depth, value, kink) = (self.depth.at(places), self.value.at(places), self.kink.at(places));
        [a.at(places), b.at(places), c.at(places), d.at(places), depth, value, kink]
    }

    /// The same, in `f64`.
    #[inline(never)]
    fn slow_values(&self, places: &[[f32; LANES]; 2]) -> [Lanes; 7] {
        let [a, b, c, d] = &self.edges;
        [a, b, c, d, &self.depth, &self.value, &self.kink].map(|line| line.slowly(places))
    }

    /// Samples' part of the thickness at the apex.
    #[inline(always)]
    pub(super) fn share<S: Simd>(&self, simd: S, places: [f32x16<S>; 2]) -> f32x16<S> {
        let [a, b, c, d, ..] = self.values(simd, places);
        a.min(b).min(c.min(d)).max(splat(simd, 0.0)).min(splat(simd, 1.0))
    }

    /// The segments of samples' rays inside the cell.
    #[inline(always)]
    pub(super) fn segments<S: Simd>(
        &self,
        simd: S,
        places: [f32x16<S>; 2],
        ends: Option<&Ends<S>>,
        perspective: bool,
    ) -> Segments<S> {
        // Depth and value on the base, and on the other side.
        let [a, b, c, d, depth, value, kink] = self.values(simd, places);
        let share = a.min(b).min(c.min(d)).max(splat(simd, 0.0)).min(splat(simd, 1.0));
        let behind = kink.max(splat(simd, 0.0)).min(splat(simd, 1.0));
        let depth = depth + behind * self.more[0];
        let value = value + behind * self.more[1];
        let other = [depth + share * self.rise[0], value + share * self.rise[1]];
        let thickness = share * self.rise[0].abs();
        let (near, length, [base, other]) = match ends {
            // Depths are reciprocals, and values are multiplied by them.
            Some(ends) if perspective => {
                let one = splat(simd, 1.0);
                let (a, b) = (one / depth, one / other[0]);
                let length = thickness * a * b * ends.along;
                (pick_by(self.base_is_front, a, b) * ends.along, length, [value * a, other[1] * b])
            }
            _ => (pick_by(self.base_is_front, depth, other[0]), thickness, [value, other[1]]),
        };
        let (low, high) = (splat(simd, self.range[0]), splat(simd, self.range[1]));
        let (base, other) = (base.max(low).min(high), other.max(low).min(high));
        let of_ends = if self.base_is_front { [base, other] } else { [other, base] };
        Segments { ends: of_ends, near, length }
    }
}

/// One of two.
#[inline(always)]
fn pick_by<S: Simd>(first: bool, a: f32x16<S>, b: f32x16<S>) -> f32x16<S> {
    if first { a } else { b }
}
