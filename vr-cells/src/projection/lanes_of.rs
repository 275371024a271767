//! A cell's projection in sixteen lanes.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Lanes, pick, splat};

use super::line::Line;
use super::outline::Outline;
use super::stamp::{SIDE, Segments};

/// Offsets of a stamp's samples from its first one.
const RIGHT: Lanes = Lanes([0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0, 0.0, 1.0, 2.0, 3.0]);
const DOWN: Lanes = Lanes([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 3.0]);

/// A linear function in the lanes of a stamp: the first sample's value is kept in f64, so that it is exact wherever the stamp lies.
#[derive(Clone, Copy)]
pub(super) struct LineLanes<S: Simd> {
    line: Line,
    /// Value at each sample less that at the first.
    offsets: f32x16<S>,
    /// Magnitude below which rounding counts.
    doubtful: f32,
}

impl<S: Simd> LineLanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, line: Line) -> Self {
        let offsets = RIGHT.load(simd) * line.a as f32 + DOWN.load(simd) * line.b as f32;
        let doubtful = (DOUBTFUL * (line.a.abs() + line.b.abs())) as f32;
        Self { line, offsets, doubtful }
    }

    /// The values in the stamp whose first sample has its centre at a place.
    #[inline(always)]
    pub(super) fn at(&self, place: [f64; 2]) -> f32x16<S> {
        self.offsets + self.line.at(place) as f32
    }

    /// The same, of which no sign is in doubt: exact where one comes near 0.
    #[inline(always)]
    fn sure_at(&self, simd: S, place: [f64; 2]) -> f32x16<S> {
        let values = self.at(place);
        if values.abs().simd_lt(splat(simd, self.doubtful)).any_true() {
            return exact_values(&self.line, place).load(simd);
        }
        values
    }
}

/// An edge of the outline.
#[derive(Clone, Copy)]
struct EdgeLanes<S: Simd> {
    line: LineLanes<S>,
    scale: f32,
    bias: f32,
    owns_zero: bool,
}

/// Part of a line's slope below which its values are computed exactly: a sample so many times the size of a stamp away from an edge, between two cells that
/// may know the edge by different vertices, must be in one of them.
const DOUBTFUL: f64 = 1e-4;

/// The values of a line in a stamp, exact in f64.
#[inline(never)]
fn exact_values(line: &Line, [x, y]: [f64; 2]) -> Lanes {
    let mut values = Lanes::ZERO;
    for (i, value) in values.0.iter_mut().enumerate() {
        *value = line.at([x + f64::from(RIGHT.0[i]), y + f64::from(DOWN.0[i])]) as f32;
    }
    values
}

/// A cell's projection in sixteen lanes.
pub(super) struct OutlineLanes<S: Simd> {
    edges: [EdgeLanes<S>; 4],
    pub(super) count: usize,
    depth: LineLanes<S>,
    value: LineLanes<S>,
    kink: Option<(LineLanes<S>, [f32; 2])>,
    base_is_front: bool,
    rise: [f32; 2],
    /// Lowest and highest place in the table of the cell's values.
    range: [f32; 2],
}

impl<S: Simd> OutlineLanes<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, outline: &Outline, range: [f32; 2]) -> Self {
        let edge = |i: usize| {
            let edge = &outline.edges[i];
            let (scale, bias) = (edge.scale as f32, edge.bias as f32);
            EdgeLanes { line: LineLanes::new(simd, edge.line), scale, bias, owns_zero: edge.line.owns_zero() }
        };
        Self {
            edges: [edge(0), edge(1), edge(2), edge(3)],
            count: outline.count,
            depth: LineLanes::new(simd, outline.base.depth),
            value: LineLanes::new(simd, outline.base.value),
            kink: outline.base.kink.map(|(line, more)| (LineLanes::new(simd, line), more.map(|x| x as f32))),
            base_is_front: outline.base_is_front,
            rise: outline.rise.map(|x| x as f32),
            range,
        }
    }

    /// The samples inside the outline, and their part of the thickness at the apex; `None` if there are none.
    #[inline(always)]
    pub(super) fn share(&self, simd: S, place: [f64; 2]) -> Option<(mask32x16<S>, f32x16<S>)> {
        let zero = splat(simd, 0.0);
        let (mut share, mut inside) = self.edge(simd, 0, place);
        for i in 1..self.count {
            let (part, is_inside) = self.edge(simd, i, place);
            share = share.min(part);
            inside &= is_inside;
        }
        inside.any_true().then(|| (inside, pick(inside, share.max(zero).min(splat(simd, 1.0)), zero)))
    }

    /// The part of the thickness as far as one edge goes, and the samples inside of it.
    #[inline(always)]
    pub(super) fn edge(&self, simd: S, i: usize, place: [f64; 2]) -> (f32x16<S>, mask32x16<S>) {
        let edge = &self.edges[i];
        let value = edge.line.sure_at(simd, place);
        let zero = splat(simd, 0.0);
        let inside = if edge.owns_zero { value.simd_ge(zero) } else { value.simd_gt(zero) };
        (value * edge.scale + edge.bias, inside)
    }

    /// The segments inside the cell. `along` has the length of each ray for a unit of depth, in perspective.
    #[inline(always)]
    pub(super) fn segments(
        &self,
        simd: S,
        place: [f64; 2],
        (inside, share): (mask32x16<S>, f32x16<S>),
        along: Option<&Lanes>,
    ) -> Segments<S> {
        // Depth and value on the base, and on the other side.
        let (mut depth, mut value) = (self.depth.at(place), self.value.at(place));
        if let Some((kink, more)) = &self.kink {
            let part = kink.sure_at(simd, place).max(splat(simd, 0.0)).min(splat(simd, 1.0));
            depth += part * more[0];
            value += part * more[1];
        }
        let other = [depth + share * self.rise[0], value + share * self.rise[1]];
        let (near, length, [base, other]) = match along {
            None => {
                let length = share * self.rise[0].abs();
                (if self.base_is_front { depth } else { other[0] }, length, [value, other[1]])
            }
            // Depths are reciprocals, and values are multiplied by them.
            Some(along) => {
                let along = along.load(simd);
                let one = splat(simd, 1.0);
                let (a, b) = (one / depth, one / other[0]);
                let length = share * self.rise[0].abs() * a * b * along;
                ((if self.base_is_front { a } else { b }) * along, length, [value * a, other[1] * b])
            }
        };
        let (low, high) = (splat(simd, self.range[0]), splat(simd, self.range[1]));
        // Outside of the outline, planes seen from their edges have any value.
        let base = pick(inside, base.max(low).min(high), low);
        let other = pick(inside, other.max(low).min(high), low);
        let ends = if self.base_is_front { [base, other] } else { [other, base] };
        let zero = splat(simd, 0.0);
        Segments { ends, near: pick(inside, near, zero), length: pick(inside, length, zero) }
    }
}

/// Centre of a stamp's first sample, from the tile's corner in samples.
#[inline(always)]
pub(super) fn place_of([column, row]: [u32; 2]) -> [f64; 2] {
    [column, row].map(|n| f64::from(n * SIDE) + 0.5)
}
