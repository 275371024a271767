//! Values at the rim of a level, for renderers that interpolate samples by themselves.

use glam::DVec3;

use super::block::AmrCentring;
use super::element::Element;
use super::inner_value::trilinear;
use super::level::{corner, divided};
use super::samples::AmrSamples;

impl AmrSamples<'_> {
    /// The value at the rim of a level, at a fraction of the way between eight places from `low` on that have no [`corners`](Self::corners); `None` in
    /// vacuum, and off the cells of the level.
    pub fn value_at_rim(&self, number: usize, low: [i32; 3], fraction: DVec3) -> Option<f64> {
        let block = &self.grid.blocks()[number];
        let at: [i64; 3] = std::array::from_fn(|a| block.first[a] + i64::from(low[a]));
        let (node, place) = match self.grid.centring() {
            AmrCentring::Points => (at, fraction),
            // From the middle of a cell to the middle of the next there are two elements.
            AmrCentring::Cells => {
                let upper = (fraction * 2.0).floor().clamp(DVec3::ZERO, DVec3::ONE);
                (std::array::from_fn(|a| 2 * at[a] + 1 + upper[a] as i64), fraction * 2.0 - upper)
            }
        };
        let elements = self.grid.centring().elements();
        self.grid.holder_of_cell(block.level, divided(node, [elements; 3]))?;
        if let Some(value) = self.value_at_face(number, low, at, fraction.clamp(DVec3::ZERO, DVec3::ONE)) {
            return Some(value);
        }
        let place = place.clamp(DVec3::ZERO, DVec3::ONE);
        let value = self.grid.rim_value(Element { level: block.level, node }, place);
        (!value.is_nan()).then_some(value)
    }

    /// The same in an element of which one face, and nothing else, touches leaves of the next coarser level: between the samples of this level on one side
    /// and the field of the coarser one on the other. `None` where that is not so.
    ///
    /// The corners on that face have the values of the coarser field, which is trilinear between them: so it need not be asked at each corner.
    fn value_at_face(&self, number: usize, low: [i32; 3], at: [i64; 3], fraction: DVec3) -> Option<f64> {
        let grid = self.grid;
        let level = grid.blocks[number].level;
        let coarser = level.checked_sub(1)?;
        let local = |i: usize| -> [i32; 3] { std::array::from_fn(|a| low[a] + corner(i)[a] as i32) };
        let mut samples: [f64; 8] =
            std::array::from_fn(|i| f64::from(self.at(number, self.place_of(number, local(i)), local(i))));
        // The face, the part of the way from the samples on the inner side to it, and the cell beyond it.
        let is_cells = grid.centring == AmrCentring::Cells;
        let (axis, is_upper) = if is_cells { face_without(&samples)? } else { self.open_face(number, low, at)? };
        let from_inner = if is_upper { fraction[axis] } else { 1.0 - fraction[axis] };
        let part = if is_cells { 2.0 * from_inner } else { from_inner };
        let mut beyond = at;
        beyond[axis] += match (is_cells, is_upper) {
            (_, true) => 1,
            (true, false) => 0,
            (false, false) => -1,
        };

        // The inner side: constant along the axis.
        let bit = 1 << axis;
        for i in 0..8 {
            samples[i] = samples[if is_upper { i & !bit } else { i | bit }];
        }
        let inner = trilinear(&samples, fraction);

        // The field of the coarser level on the face.
        let mut on_face = fraction;
        on_face[axis] = match (is_cells, is_upper) {
            (true, _) => 0.5,
            (false, true) => 1.0,
            (false, false) => 0.0,
        };
        let world =
            self.first_place(number) + (DVec3::from_array(low.map(f64::from)) + on_face) * grid.spacing_of(level);
        let holder = grid.holder_of_cell(coarser, divided(beyond, grid.levels[level].ratio))?;
        let place = (world - self.first_place(holder)) / grid.spacing_of(coarser);
        let dims = grid.blocks[holder].dims;
        let below: [i32; 3] = std::array::from_fn(|a| {
            let below = place[a].floor() as i32;
            // Rounding may carry it past a face of the block.
            if is_cells { below } else { below.clamp(0, dims[a] as i32 - 2) }
        });
        let corners = self.corners(holder, below)?.map(f64::from);
        let outer = trilinear(&corners, place - DVec3::from_array(below.map(f64::from)));
        let value = inner + (outer - inner) * part;
        (!value.is_nan()).then_some(value)
    }

    /// Axis and side of the one face of a cell between points beyond which the level has no cells, if it has all others around.
    fn open_face(&self, number: usize, low: [i32; 3], at: [i64; 3]) -> Option<(usize, bool)> {
        let block = &self.grid.blocks[number];
        let is_last = |a: usize| low[a] + 2 == block.dims[a] as i32;
        let rim = |a: usize| low[a] == 0 || is_last(a);
        let is_within = (0..3).all(|a| low[a] >= 0 && low[a] + 1 < block.dims[a] as i32);
        let axis = (0..3).find(|&a| rim(a)).filter(|&axis| is_within && (axis + 1..3).all(|a| !rim(a)))?;
        let is_upper = is_last(axis);
        if is_upper && low[axis] == 0 {
            return None;
        }
        // None of the nine cells beyond it is there.
        let beyond = |i: usize| -> [i64; 3] {
            let mut cell = at;
            cell[axis] += if is_upper { 1 } else { -1 };
            let [b, c] = [[1, 2], [0, 2], [0, 1]][axis];
            cell[b] += i as i64 % 3 - 1;
            cell[c] += i as i64 / 3 - 1;
            cell
        };
        (0..9).all(|i| self.grid.holder_of_cell(block.level, beyond(i)).is_none()).then_some((axis, is_upper))
    }
}

/// Axis and side of the face across which four of eight samples are missing, if no others are.
fn face_without(samples: &[f64; 8]) -> Option<(usize, bool)> {
    let missing = (0..8).filter(|&i| samples[i].is_nan()).fold(0u8, |bits, i| bits | 1 << i);
    match missing {
        0x55 => Some((0, false)),
        0xaa => Some((0, true)),
        0x33 => Some((1, false)),
        0xcc => Some((1, true)),
        0x0f => Some((2, false)),
        0xf0 => Some((2, true)),
        _ => None,
    }
}
