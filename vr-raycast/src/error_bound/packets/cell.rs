//! Steps ahead, each inside a cell, and the trilinear field along them.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Field, Pairs, Stage, pick, splat};

use super::march::{Medium, Packet};
use super::path::{Exits, Path};
use super::step::Course;

/// Error of a position, in cells: its three fractions are rounded to f32.
const MISPLACED: f32 = 4.0 / (1 << 24) as f32;

/// Largest value of t(t − ½)(t − 1), from 0 to 1: √3/36.
pub(super) const CUBIC: f32 = 0.0482;

/// Ways of sixteen rays through cells, and how exactly the field is known along them.
pub(super) struct Way<S: Simd> {
    pub(super) path: Path<S>,
    pub(super) exits: Exits<S>,
    /// Cells per unit of length.
    delta: [f32x16<S>; 3],
    /// Bound of the rounding of a distance.
    pub(super) margin: f32x16<S>,
    /// Bound of the cubic part of the field, by its third difference and the cube of the length.
    cubic: f32x16<S>,
    /// Bound of the error of values.
    unsure: f32x16<S>,
    /// Error of the value, integrated over the part of a step behind its cell.
    pub(super) beyond: f32x16<S>,
}

impl<S: Simd> Way<S> {
    #[inline(always)]
    pub(super) fn new<T>(simd: S, medium: &Medium<'_, T>, packet: &Packet) -> Self {
        let [dx, dy, dz] = &packet.rounded_delta;
        let delta = [dx.load(simd), dy.load(simd), dz.load(simd)];
        // Distances are rounded to f32: steps end a little behind faces, and leaps a little before them, so that neither misses anything.
        let margin = packet.end.load(simd).max(splat(simd, 1.0)) * (1.0 / (1 << 24) as f32);
        Self {
            path: Path::new(simd, packet, medium.dims),
            exits: Exits::new(simd, &delta),
            delta,
            margin,
            // The third difference of the corners times dx dy dz h³ t(t − ½)(t − 1).
            cubic: (delta[0] * delta[1] * delta[2]).abs() * CUBIC,
            // Fractions of a cell are rounded: at most this changes the value.
            unsure: splat(simd, medium.span * MISPLACED + medium.noise + medium.costs.misplaced),
            // Behind its face a step follows the field of its own cell, over less than two margins; and before the face that it leaped to, over less than four. The two
            // fields differ there by their slopes.
            beyond: margin * margin * (40.0 * medium.span),
        }
    }
}

/// Cells that rays are about to go through, whose samples are fetched and not used yet.
pub(super) struct Entry<S: Simd> {
    at: f32x16<S>,
    pub(super) to: f32x16<S>,
    /// Place from which the cell was found, with its numbers and the place in it.
    within: f32x16<S>,
    cell: [f32x16<S>; 3],
    fraction: [f32x16<S>; 3],
}

/// Step through the cell that lies ahead, or a part of it.
pub(super) struct Ahead<S: Simd> {
    pub(super) to: f32x16<S>,
    pub(super) length: f32x16<S>,
    pub(super) course: Course<S>,
    /// Numbers of the cell, and the place in it of the middle of the step.
    pub(super) cell: [f32x16<S>; 3],
    pub(super) middle: [f32x16<S>; 3],
}

impl<S: Simd> Entry<S> {
    /// Finds the cells at places `within`, which are a few margins behind `at` at most, and fetches their samples. Rays go to the end of their cells, but not beyond a
    /// limit; one that is not active stays where it is.
    #[inline(always)]
    pub(super) fn new<T: Pairs>(
        simd: S,
        medium: &Medium<'_, T>,
        way: &Way<S>,
        [at, within, limit]: [f32x16<S>; 3],
        active: mask32x16<S>,
        stage: &mut Stage<T>,
    ) -> Self {
        let (cell, cells) = way.path.cells(simd, within);
        medium.field.fetch(simd, &cells, stage);
        let to = (within + (way.exits.of_cell(simd, &cells.fraction) + way.margin)).min(limit);
        let to = pick(active, to, at);
        Self { at, to, within, cell, fraction: cells.fraction }
    }

    /// Takes the step, where the last cell gave a value at its begin; to `fresh` rays none did.
    #[inline(always)]
    pub(super) fn step<T: Pairs>(
        self,
        simd: S,
        medium: &Medium<'_, T>,
        way: &Way<S>,
        (value, fresh): (f32x16<S>, mask32x16<S>),
        stage: &Stage<T>,
    ) -> Ahead<S> {
        let Self { at, to, within, cell, fraction: [x, y, z] } = self;
        let delta = &way.delta;
        let length = to - at;
        let back = at - within;
        let (half, forth) = (back + length * 0.5, to - within);
        let first = [x + delta[0] * back, y + delta[1] * back, z + delta[2] * back];
        let middle = [x + delta[0] * half, y + delta[1] * half, z + delta[2] * half];
        let last = [x + delta[0] * forth, y + delta[1] * forth, z + delta[2] * forth];
        let along = Along::new(simd, &medium.field, stage, [&first, &middle, &last]);
        // The medium at the begin was looked up for the value that the last cell gave there.
        let off = pick(fresh, splat(simd, 0.0), (along.begin - value).abs());
        let course = Course {
            values: [along.begin, along.middle, along.end],
            cubic: along.third.abs() * (way.cubic * length * length * length),
            unsure: way.unsure + off,
        };
        Ahead { to, length, course, cell, middle }
    }
}

/// Field along a step inside a cell.
pub(super) struct Along<S: Simd> {
    pub(super) begin: f32x16<S>,
    pub(super) middle: f32x16<S>,
    pub(super) end: f32x16<S>,
    /// Third difference of the cell's corners: what the cubic part is made of.
    pub(super) third: f32x16<S>,
}

impl<S: Simd> Along<S> {
    /// Evaluates the trilinear field of staged cells at three places in each.
    #[inline(always)]
    pub(super) fn new<T: Pairs>(simd: S, field: &Field<'_, T>, stage: &Stage<T>, places: [&[f32x16<S>; 3]; 3]) -> Self {
        let [[a00, b00, a10, b10], [a01, b01, a11, b11]] = field.faces(simd, 2, stage);
        let (d00, d10, d01, d11) = (b00 - a00, b10 - a10, b01 - a01, b11 - a11);
        let third = (d11 - d01) - (d10 - d00);
        let mut values = [a00; 3];
        for i in 0..3 {
            let [x, y, z] = *places[i];
            let (f00, f10, f01, f11) = (a00 + x * d00, a10 + x * d10, a01 + x * d01, a11 + x * d11);
            let (f0, f1) = (f00 + y * (f10 - f00), f01 + y * (f11 - f01));
            values[i] = f0 + z * (f1 - f0);
        }
        let [begin, middle, end] = values;
        Self { begin, middle, end, third }
    }
}
