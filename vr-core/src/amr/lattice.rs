//! Samples of a block together with those beside it.

use super::block::AmrCentring;
use super::check::each_index;
use super::grid::AmrGrid;
use super::level::plus;
use super::samples::AmrSamples;

/// Samples of a block, and a layer of those beside it, in one box: between eight of them, none of which is NaN or infinite, the field is trilinear. A
/// renderer that interpolates between them as in a uniform grid need not ask in which block a sample lies.
///
/// Values in the middles of cells have a border of one sample. It has NaN where the level has no cell, since the field there is not made of the samples of the
/// level alone, and +∞ for a cell without a value, around which there is vacuum. Points need no border: those that a coarser leaf touches have the
/// value that the leaf has there, and NaN is vacuum.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};
///
/// let block = |x: i64| AmrBlock { level: 0, first: [x, 0, 0], dims: [2; 3], values: vec![x as f32; 8] };
/// let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![], vec![block(0), block(2)], AmrCentring::Cells)?;
/// let lattice = grid.samples().lattice(1).expect("it has a border");
/// assert_eq!(lattice.dims, [4; 3]);
/// // Beyond the mesh, in the other block, in its own cells, and beyond the mesh.
/// let row = &lattice.values[20..24];
/// assert!(row[0] == 0.0 && row[1..3] == [2.0, 2.0] && row[3].is_nan());
/// # Ok::<(), vr_core::amr::AmrError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AmrLattice {
    /// Numbers of samples along x, y and z.
    pub dims: [usize; 3],
    /// Values, x fastest.
    pub values: Vec<f32>,
}

impl AmrLattice {
    /// Number of samples of a lattice before the first one of its block, along each axis.
    pub fn border(centring: AmrCentring) -> usize {
        match centring {
            AmrCentring::Cells => 1,
            AmrCentring::Points => 0,
        }
    }
}

impl AmrSamples<'_> {
    /// The lattice of a block; `None` if the samples of the block itself are such a lattice.
    pub fn lattice(&self, number: usize) -> Option<AmrLattice> {
        match self.grid.centring() {
            AmrCentring::Cells => Some(self.bordered(number)),
            AmrCentring::Points => self.unified(number),
        }
    }

    /// Bytes of the values of a block's [`lattice`](Self::lattice), known before that is made; 0 where there is none.
    pub fn lattice_bytes(&self, number: usize) -> u64 {
        match self.grid.centring() {
            AmrCentring::Points if self.is_complete(number) => 0,
            centring => self.bytes_with_border(number, AmrLattice::border(centring)),
        }
    }

    /// Bytes of the values of a block's [`difference_lattice`](Self::difference_lattice), known before that is made.
    pub fn difference_lattice_bytes(&self, number: usize) -> u64 {
        self.bytes_with_border(number, AmrLattice::border(self.grid.centring()) + 1)
    }

    fn bytes_with_border(&self, number: usize, border: usize) -> u64 {
        let samples: usize = self.grid.blocks()[number].dims.iter().map(|n| n + 2 * border).product();
        (samples * size_of::<f32>()) as u64
    }

    /// True if no coarser leaf touches a block, on any side.
    fn is_complete(&self, number: usize) -> bool {
        let complete = self.grid.bricks().complete_sides(number);
        (0..27).all(|side| complete >> side & 1 == 1)
    }

    /// Samples of a block with those that central differences at the samples of its [`lattice`](Self::lattice) are made of: with a border of one more
    /// than that has. Beyond the level it has the field, and where that is vacuum, the value that makes the difference one-sided; NaN where two differences
    /// ask for different ones, and where none asks for any.
    pub fn difference_lattice(&self, number: usize) -> AmrLattice {
        let block = &self.grid.blocks()[number];
        let border = AmrLattice::border(self.grid.centring()) as i32 + 1;
        let dims = block.dims.map(|n| n + 2 * border as usize);
        let sample = |local: [i32; 3]| self.at(number, self.place_of(number, local), local);
        let value = |from_first: [i64; 3]| {
            let local = from_first.map(|i| i as i32);
            let own = sample(local);
            if own.is_nan() { self.beyond_sample(number, local, sample) } else { own }
        };
        let first = [-i64::from(border); 3];
        let values = each_index(first, plus(first, dims.map(|n| n as i64))).map(value);
        AmrLattice { dims, values: values.collect() }
    }

    /// Value in place of a sample that the level does not have, beside one that it has.
    fn beyond_sample(&self, number: usize, local: [i32; 3], sample: impl Fn([i32; 3]) -> f32) -> f32 {
        let block = &self.grid.blocks()[number];
        let behind = |a: usize, by: i32| {
            let mut at = local;
            at[a] += by;
            sample(at)
        };
        let sides = || (0..3).flat_map(|a| [(a, -1), (a, 1)]);
        if sides().all(|(a, by)| behind(a, by).is_nan()) {
            return f32::NAN;
        }
        let at = std::array::from_fn(|a| block.first[a] + i64::from(local[a]));
        let field = self.grid.beyond_level(block.level, at);
        if !field.is_nan() {
            return field as f32;
        }
        // The sample beside it, and the one behind that.
        let mut one_sided = sides().map(|(a, by)| 2.0 * behind(a, by) - behind(a, 2 * by)).filter(|v| !v.is_nan());
        match (one_sided.next(), one_sided.next()) {
            (Some(only), None) => only,
            _ => f32::NAN,
        }
    }

    fn bordered(&self, number: usize) -> AmrLattice {
        let grid: &AmrGrid = self.grid;
        let block = &grid.blocks()[number];
        let dims = block.dims.map(|n| n + 2);
        let mut values = Vec::with_capacity(dims.iter().product());
        let own = |value: f32| if value.is_nan() { f32::INFINITY } else { value };
        let beside = |local: [i32; 3]| {
            let found = self.at(number, self.place_of(number, local), local);
            let at = || std::array::from_fn(|a| block.first[a] + i64::from(local[a]));
            if found.is_nan() && grid.holds_sample(block.level, at()) { f32::INFINITY } else { found }
        };
        let [nx, ny, nz] = block.dims.map(|n| n as i32);
        for z in -1..=nz {
            for y in -1..=ny {
                if (0..ny).contains(&y) && (0..nz).contains(&z) {
                    // A row of the block's own, between two others.
                    let from = (z as usize * block.dims[1] + y as usize) * block.dims[0];
                    values.push(beside([-1, y, z]));
                    values.extend(block.values[from..from + block.dims[0]].iter().copied().map(own));
                    values.push(beside([nx, y, z]));
                } else {
                    values.extend((-1..=nx).map(|x| beside([x, y, z])));
                }
            }
        }
        AmrLattice { dims, values }
    }

    /// Points of a block with the values that coarser leaves have at those that they touch; `None` if they touch none.
    fn unified(&self, number: usize) -> Option<AmrLattice> {
        let grid = self.grid;
        let block = &grid.blocks()[number];
        if self.is_complete(number) {
            return None;
        }
        let complete = grid.bricks().complete_sides(number);
        let is_complete = |side: [usize; 3]| complete >> (side[0] + 3 * side[1] + 9 * side[2]) & 1 == 1;
        let mut values = block.values.clone();
        let dims = block.dims.map(|n| n as i64);
        // Sides of the block on which the cells around a point lie.
        let sides = |a: usize, at: i64| match at {
            0 => 0..2,
            _ if at + 1 == dims[a] => 1..3,
            _ => 1..2,
        };
        for (at, value) in each_index([0; 3], dims).zip(&mut values) {
            let [x, y, z] = [0, 1, 2].map(|a| sides(a, at[a]));
            let is_own = x.clone().all(|x| y.clone().all(|y| z.clone().all(|z| is_complete([x, y, z]))));
            if !is_own {
                *value = grid.at_node::<f64>(block.level, std::array::from_fn(|a| block.first[a] + at[a])) as f32;
            }
        }
        Some(AmrLattice { dims: block.dims, values })
    }
}
