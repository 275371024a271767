//! Samples of a level around places, for renderers that interpolate them by themselves.

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::grid::AmrGrid;
use super::level::divided;
use super::neighbors::Neighbors;

/// Access to the samples of blocks, and of those beside them, by whole numbers: a place is counted in samples of a block from its first one, and may lie a
/// step beyond it.
///
/// Between eight samples, from `low` on, the field is trilinear where [`corners`](Self::corners) has them; elsewhere, at the rim of a level,
/// [`Field::value`](crate::Field::value) tells it.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};
///
/// let block = |x: i64| AmrBlock { level: 0, first: [x, 0, 0], dims: [2; 3], values: vec![x as f32; 8] };
/// let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![], vec![block(0), block(2)], AmrCentring::Cells)?;
/// let samples = grid.samples();
/// assert_eq!(samples.first_place(1), DVec3::new(2.5, 0.5, 0.5));
/// assert_eq!(samples.inner(1), [[0; 3]; 2]);
/// // Between both blocks.
/// assert_eq!(samples.corners(1, [-1, 0, 0]), Some([0.0, 2.0, 0.0, 2.0, 0.0, 2.0, 0.0, 2.0]));
/// assert_eq!(samples.corners(1, [1, 0, 0]), None, "beyond the mesh");
/// # Ok::<(), vr_core::amr::AmrError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct AmrSamples<'a> {
    pub(super) grid: &'a AmrGrid,
    neighbors: &'a Neighbors,
}

/// Samples that central differences at eight others are made of: these eight, x fastest; then for each axis four beyond the lower face across it and
/// four beyond the upper one, in the order of the other two axes.
pub type AmrStencil = [f32; 32];

impl AmrGrid {
    /// Access to the samples.
    pub fn samples(&self) -> AmrSamples<'_> {
        AmrSamples { grid: self, neighbors: self.neighbors() }
    }
}

impl<'a> AmrSamples<'a> {
    /// World position of the first sample of a block.
    pub fn first_place(&self, number: usize) -> DVec3 {
        let block = &self.grid.blocks[number];
        let shift = if self.grid.centring == AmrCentring::Cells { 0.5 } else { 0.0 };
        let at = DVec3::from_array(block.first.map(|i| i as f64)) + shift;
        self.grid.origin + at * self.grid.levels[block.level].spacing
    }

    /// First and last place of a block around which its own samples are the corners; the last before the first if there is none.
    pub fn inner(&self, number: usize) -> [[i32; 3]; 2] {
        let block = &self.grid.blocks[number];
        let (mut first, mut last) = ([0; 3], block.dims.map(|n| n as i32 - 2));
        if self.grid.centring == AmrCentring::Points {
            // A corner that a coarser leaf touches has that one's value.
            let complete = self.grid.bricks().complete_sides(number);
            let is_complete = |place: usize| complete >> place & 1 == 1;
            let sides = |place: usize| [place % 3, place / 3 % 3, place / 9];
            let is_face = |place: usize| sides(place).iter().filter(|&&s| s != 1).count() == 1;
            let mut open = [[false; 2]; 3];
            let mut shrink = |place: usize| {
                // One side is enough for edges and corners: what is beyond both is beyond it.
                let seen = (0..3).any(|a| sides(place)[a] != 1 && open[a][sides(place)[a] / 2]);
                if let Some(a) = (0..3).find(|&a| sides(place)[a] != 1 && !seen) {
                    open[a][sides(place)[a] / 2] = true;
                }
            };
            (0..27).filter(|&p| is_face(p) && !is_complete(p)).for_each(&mut shrink);
            (0..27).filter(|&p| p != 13 && !is_face(p) && !is_complete(p)).for_each(&mut shrink);
            for a in 0..3 {
                first[a] += i32::from(open[a][0]);
                last[a] -= i32::from(open[a][1]);
            }
        }
        [first, last]
    }

    /// The eight samples from `low` on, x fastest, if the field is trilinear between them.
    #[inline]
    pub fn corners(&self, number: usize, low: [i32; 3]) -> Option<[f32; 8]> {
        if !self.tells(number, low) {
            return None;
        }
        let block = &self.grid.blocks[number];
        let side = |a: usize, at: i32| match at {
            ..0 => 0,
            i if (i as usize) < block.dims[a] => 1,
            _ => 2,
        };
        let sides: [[usize; 2]; 3] = std::array::from_fn(|a| [side(a, low[a]), side(a, low[a] + 1)]);
        // Where one axis leads from a block to another, the samples of each side are a face of one block: as a rule.
        let mut found = [f32::NAN; 8];
        let crossed: u32 = (0..3).filter(|&a| sides[a][0] != sides[a][1]).fold(0, |bits, a| bits | 1 << a);
        if let (1 | 2 | 4, axis) = (crossed, crossed.trailing_zeros() as usize) {
            let [b, c] = [[1, 2], [0, 2], [0, 1]][axis];
            for up in 0..2 {
                let mut places = sides.map(|side| side[0]);
                places[axis] = sides[axis][up];
                let Some(number) = self.neighbors.of(number, places[0] + 3 * places[1] + 9 * places[2]) else {
                    continue;
                };
                let holder = &self.grid.blocks[number];
                let mut from = low;
                from[axis] += up as i32;
                let offset = offset_from(block, holder, from);
                let strides = [1, holder.dims[0], holder.dims[0] * holder.dims[1]];
                for i in 0..4 {
                    let at = offset + (i & 1) * strides[b] + (i >> 1) * strides[c];
                    let corner = up << axis | (i & 1) << b | (i >> 1) << c;
                    found[corner] = holder.values.get(at).copied().unwrap_or(f32::NAN);
                }
            }
        }
        // One by one: from more blocks than two, or where no single one holds a side.
        let is_told = found.iter().all(|v| !v.is_nan());
        for i in (0..8).filter(|_| !is_told) {
            let local: [i32; 3] = std::array::from_fn(|a| low[a] + (i >> a & 1) as i32);
            found[i] = self.at(number, self.place_of(number, local), local);
        }
        found.iter().all(|v| !v.is_nan()).then_some(found)
    }

    /// Fills the samples around eight of them, from `low` on; false if the gradient is not made of these alone. Beyond the level, the field is taken; where
    /// that is vacuum, what makes the difference one-sided.
    #[inline]
    pub fn stencil(&self, number: usize, low: [i32; 3], out: &mut AmrStencil) -> bool {
        let block = &self.grid.blocks[number];
        let is_within = (0..3).all(|a| low[a] >= 1 && low[a] as usize + 2 < block.dims[a]);
        if is_within && self.tells(number, low) {
            within(block, low.map(|i| i as usize), out);
            return out.iter().all(|v| !v.is_nan());
        }
        let found = self.stencil_at_rim(number, low);
        if let Some(found) = found {
            *out = found.map(|sample| sample as f32);
        }
        found.is_some()
    }

    /// The same with the full precision of what lies beyond the level.
    pub(super) fn exact_stencil(&self, number: usize, low: [i32; 3]) -> Option<[f64; 32]> {
        let block = &self.grid.blocks[number];
        let is_within = (0..3).all(|a| low[a] >= 1 && low[a] as usize + 2 < block.dims[a]);
        if is_within && self.tells(number, low) {
            let mut stencil = [0.0; 32];
            within(block, low.map(|i| i as usize), &mut stencil);
            return stencil.iter().all(|v| !v.is_nan()).then(|| stencil.map(f64::from));
        }
        self.stencil_at_rim(number, low)
    }

    /// The same where some of the samples are not those of the block.
    #[inline(never)]
    fn stencil_at_rim(&self, number: usize, low: [i32; 3]) -> Option<[f64; 32]> {
        let block = &self.grid.blocks[number];
        let corners = self.corners(number, low)?.map(f64::from);
        let mut out = [0.0; 32];
        out[..8].copy_from_slice(&corners);
        for (i, by) in PLACES.iter().enumerate().skip(8) {
            let local: [i32; 3] = std::array::from_fn(|a| low[a] + by[a]);
            let mut sample = f64::from(self.at(number, self.place_of(number, local), local));
            if sample.is_nan() {
                let at = std::array::from_fn(|a| block.first[a] + i64::from(local[a]));
                sample = self.grid.beyond_level(block.level, at);
            }
            if sample.is_nan() {
                // The sample beside it, and the one behind that.
                let (axis, plane) = ((i - 8) / 8, i % 4);
                let others = [[1, 2], [0, 2], [0, 1]][axis];
                let lower = (plane & 1) << others[0] | (plane >> 1) << others[1];
                let [near, far] = if by[axis] < 0 { [lower, lower | 1 << axis] } else { [lower | 1 << axis, lower] };
                sample = 2.0 * corners[near] - corners[far];
            }
            out[i] = sample;
        }
        Some(out)
    }

    /// Block of the next coarser level that holds the cell which covers one of a block; that is counted from the block's first one, and may lie beside it.
    #[inline]
    pub fn coarser_block(&self, number: usize, cell: [i32; 3]) -> Option<usize> {
        let block = &self.grid.blocks[number];
        let cell = std::array::from_fn(|a| block.first[a] + i64::from(cell[a]));
        let coarser = block.level.checked_sub(1)?;
        self.grid.holder_of_cell(coarser, divided(cell, self.grid.levels[block.level].ratio))
    }

    /// True if the samples around a place tell the field there, as far as there are any.
    #[inline]
    fn tells(&self, number: usize, low: [i32; 3]) -> bool {
        let block = &self.grid.blocks[number];
        match self.grid.centring {
            AmrCentring::Cells => (0..3).all(|a| low[a] >= -1 && low[a] < block.dims[a] as i32),
            AmrCentring::Points => {
                let is_within = (0..3).all(|a| low[a] >= 0 && low[a] as usize + 1 < block.dims[a]);
                let cell = std::array::from_fn(|a| block.first[a] + i64::from(low[a]));
                is_within && self.grid.has_same_level_around(number, cell)
            }
        }
    }

    /// Place of a sample among the neighbours of a block.
    #[inline]
    pub(super) fn place_of(&self, number: usize, local: [i32; 3]) -> usize {
        let block = &self.grid.blocks[number];
        let side = |a: usize| match local[a] {
            ..0 => 0,
            i if (i as usize) < block.dims[a] => 1,
            _ => 2,
        };
        side(0) + 3 * side(1) + 9 * side(2)
    }

    /// Sample of a block or beside it, in one of its 27 places; NaN for none.
    #[inline]
    pub(super) fn at(&self, number: usize, place: usize, local: [i32; 3]) -> f32 {
        let block = &self.grid.blocks[number];
        let holder = self.neighbors.of(number, place).map(|n| &self.grid.blocks[n]);
        let found = holder.and_then(|holder| holder.values.get(offset_from(block, holder, local)));
        found.copied().unwrap_or_else(|| {
            let at = std::array::from_fn(|a| block.first[a] + i64::from(local[a]));
            self.grid.sample(block.level, at) as f32
        })
    }
}

/// Place of a sample in the values of a block that has it, by its place from the first sample of another one.
#[inline]
fn offset_from(block: &AmrBlock, holder: &AmrBlock, local: [i32; 3]) -> usize {
    // What the block does not have is beyond any of its values.
    let at = |a: usize| (block.first[a] - holder.first[a] + i64::from(local[a])) as usize;
    let row = at(2).wrapping_mul(holder.dims[1]).wrapping_add(at(1));
    row.wrapping_mul(holder.dims[0]).wrapping_add(at(0))
}

/// Places of a stencil's samples, from the lowest of the eight in the middle.
const PLACES: [[i32; 3]; 32] = places();

const fn places() -> [[i32; 3]; 32] {
    let mut places = [[0; 3]; 32];
    let mut i = 0;
    while i < 8 {
        places[i] = [i as i32 & 1, i as i32 >> 1 & 1, i as i32 >> 2];
        i += 1;
    }
    while i < 32 {
        let (axis, corner) = ((i - 8) / 8, (i % 4) as i32);
        let beyond = if i / 4 % 2 == 0 { -1 } else { 2 };
        let (t, u) = (corner & 1, corner >> 1);
        places[i] = match axis {
            0 => [beyond, t, u],
            1 => [t, beyond, u],
            _ => [t, u, beyond],
        };
        i += 1;
    }
    places
}

/// The samples of a block from one step below `low` to two above it, which it has.
#[inline]
fn within(block: &AmrBlock, [x, y, z]: [usize; 3], out: &mut AmrStencil) {
    let (row, layer) = (block.dims[0], block.dims[0] * block.dims[1]);
    let first = (z * block.dims[1] + y) * row + x;
    let values = &block.values;
    for (i, begin) in [first, first + row, first + layer, first + layer + row].into_iter().enumerate() {
        let four = &values[begin - 1..begin + 3];
        (out[8 + i], out[2 * i], out[2 * i + 1], out[12 + i]) = (four[0], four[1], four[2], four[3]);
    }
    let mut pair = |to: usize, begin: usize| out[to..to + 2].copy_from_slice(&values[begin..begin + 2]);
    for (i, begin) in [first, first + layer].into_iter().enumerate() {
        pair(16 + 2 * i, begin - row);
        pair(20 + 2 * i, begin + 2 * row);
    }
    for (i, begin) in [first, first + row].into_iter().enumerate() {
        pair(24 + 2 * i, begin - layer);
        pair(28 + 2 * i, begin + 2 * layer);
    }
}
