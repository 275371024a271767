//! Samples of a level around places, for renderers that interpolate them by themselves.

use glam::DVec3;

use super::block::{AmrBlock, AmrCentring};
use super::grid::AmrGrid;
use super::level::corner;
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
    grid: &'a AmrGrid,
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
        let mut found = [0.0; 8];
        for (i, found) in found.iter_mut().enumerate() {
            let by = corner(i);
            *found = self.at(number, std::array::from_fn(|a| low[a] + by[a] as i32));
        }
        found.iter().all(|v| !v.is_nan()).then_some(found)
    }

    /// Fills the samples around eight of them, from `low` on; false if the gradient is not made of these alone.
    #[inline]
    pub fn stencil(&self, number: usize, low: [i32; 3], out: &mut AmrStencil) -> bool {
        if !self.tells(number, low) {
            return false;
        }
        let block = &self.grid.blocks[number];
        let is_within = (0..3).all(|a| low[a] >= 1 && low[a] as usize + 2 < block.dims[a]);
        if is_within {
            within(block, low.map(|i| i as usize), out);
        } else {
            for (sample, by) in out.iter_mut().zip(&PLACES) {
                *sample = self.at(number, std::array::from_fn(|a| low[a] + by[a]));
            }
        }
        out.iter().all(|v| !v.is_nan())
    }

    /// True if the samples around a place tell the field there, as far as there are any.
    #[inline]
    fn tells(&self, number: usize, low: [i32; 3]) -> bool {
        let block = &self.grid.blocks[number];
        match self.grid.centring {
            AmrCentring::Cells => true,
            AmrCentring::Points => {
                let is_within = (0..3).all(|a| low[a] >= 0 && low[a] as usize + 1 < block.dims[a]);
                let cell = std::array::from_fn(|a| block.first[a] + i64::from(low[a]));
                is_within && self.grid.has_same_level_around(number, cell)
            }
        }
    }

    /// Sample at a place of a block or beside it; NaN for none.
    #[inline]
    fn at(&self, number: usize, local: [i32; 3]) -> f32 {
        let block = &self.grid.blocks[number];
        let side = |a: usize| match local[a] {
            ..0 => 0,
            i if (i as usize) < block.dims[a] => 1,
            _ => 2,
        };
        let at = std::array::from_fn(|a| block.first[a] + i64::from(local[a]));
        let holder = self.neighbors.of(number, side(0) + 3 * side(1) + 9 * side(2)).map(|n| &self.grid.blocks[n]);
        match holder.and_then(|holder| Some(holder.values[holder.offset(at)?])) {
            Some(value) => value,
            None => self.grid.sample(block.level, at) as f32,
        }
    }
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
fn within(block: &AmrBlock, low: [usize; 3], out: &mut AmrStencil) {
    let (row, layer) = (block.dims[0] as isize, (block.dims[0] * block.dims[1]) as isize);
    let first = ((low[2] * block.dims[1] + low[1]) * block.dims[0] + low[0]) as isize;
    for (sample, by) in out.iter_mut().zip(&PLACES) {
        let offset = first + by[2] as isize * layer + by[1] as isize * row + by[0] as isize;
        *sample = block.values[offset as usize];
    }
}
