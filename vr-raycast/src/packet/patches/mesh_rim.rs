//! Values at the rim of a level of an adaptive mesh, in the precision of the packets.

use vr_core::amr::{AmrGrid, AmrSamples};

use super::mesh_lattices::{MeshLattices, stencil};

/// Field of a mesh with values in the middles of cells, beside cells that its level does not have.
#[derive(Clone, Copy)]
pub(crate) struct MeshRim<'a> {
    pub(crate) grid: &'a AmrGrid,
    pub(crate) samples: AmrSamples<'a>,
    pub(crate) lattices: &'a MeshLattices,
}

impl MeshRim<'_> {
    /// The value between eight samples of a block from `low` on, NaN for those that its level does not have, if only leaves of the next coarser
    /// level are beside it; `None` where more is to be looked at.
    ///
    /// The octant of the cell has the samples' means at the corners that only cells of the level touch, and the values of the coarser level at the others: there,
    /// that level's field is trilinear in the whole octant.
    pub(crate) fn value(&self, number: usize, low: [i32; 3], fraction: [f32; 3]) -> Option<f32> {
        let own = &self.eight(number, low)?;
        if own.iter().any(|sample| sample.is_infinite()) {
            return None;
        }
        let octant = Octant::new(low, fraction);
        let own = octant.own_corners(own);
        let (place, holder, low) = self.coarser(number, &octant)?;
        let coarse = between(&self.eight(holder, low)?, place);
        let corners: [f32; 8] = std::array::from_fn(|i| if own[i].is_nan() { coarse[i] } else { own[i] });
        let value = trilinear(&corners, octant.place);
        value.is_finite().then_some(value)
    }

    /// The gradient there, in the world units of `unit`, likewise.
    pub(crate) fn gradient(&self, number: usize, low: [i32; 3], fraction: [f32; 3], unit: f64) -> Option<[f32; 3]> {
        let samples = self.eight(number, low)?;
        if samples.iter().any(|sample| sample.is_infinite()) {
            return None;
        }
        let octant = Octant::new(low, fraction);
        let (place, holder, coarse_low) = self.coarser(number, &octant)?;
        if self.eight(holder, coarse_low)?.iter().any(|sample| !sample.is_finite()) {
            return None;
        }
        let (fine, coarse) = (self.rises(number, low)?, self.rises(holder, coarse_low)?);
        let slope =
            |number: usize| (unit / self.grid.spacing_of(self.grid.blocks()[number].level)).as_vec3().to_array();
        let (fine_slope, coarse_slope) = (slope(number), slope(holder));
        let is_own = octant.own_corners(&samples).map(|mean| !mean.is_nan());
        let mut gradient = [0.0; 3];
        for a in 0..3 {
            let own = octant.own_corners(&fine[a].map(|rise| rise * fine_slope[a]));
            let coarse = between(&coarse[a].map(|rise| rise * coarse_slope[a]), place);
            let corners: [f32; 8] = std::array::from_fn(|i| if is_own[i] { own[i] } else { coarse[i] });
            gradient[a] = trilinear(&corners, octant.place);
        }
        gradient.iter().all(|g| g.is_finite()).then_some(gradient)
    }

    /// Differences from sample to sample, axis by axis, at eight samples from `low` on.
    fn rises(&self, number: usize, low: [i32; 3]) -> Option<[[f32; 8]; 3]> {
        let mut around = [0.0; 32];
        if !stencil(self.lattices.differences(number)?, low.map(|i| i + 1), &mut around) {
            return None;
        }
        let rise = |a: usize, i: usize| {
            let [t, u] = [[1, 2], [0, 2], [0, 1]][a].map(|other| i >> other & 1);
            let (bit, beyond) = (1 << a, 8 + 8 * a + t + 2 * u);
            let both =
                if i & bit == 0 { [around[beyond], around[i | bit]] } else { [around[i & !bit], around[beyond + 4]] };
            (both[1] - both[0]) * 0.5
        };
        Some(std::array::from_fn(|a| std::array::from_fn(|i| rise(a, i))))
    }

    /// Places of an octant's lower and upper faces along each axis between samples of the next coarser level; the block of that, and the place of
    /// the lowest of these samples in it.
    fn coarser(&self, number: usize, octant: &Octant) -> Option<([[f32; 2]; 3], usize, [i32; 3])> {
        let blocks = self.grid.blocks();
        let block = &blocks[number];
        let holder = self.samples.coarser_block(number, octant.cell)?;
        let first = blocks[holder].first;
        let ratio = self.grid.ratio_of(block.level);
        // The octant's faces, among the samples of the coarser block.
        let mut low = [0; 3];
        let mut place = [[0.0; 2]; 3];
        for a in 0..3 {
            let rate = 1.0 / f64::from(ratio[a]);
            let origin = first[a] as f64 + 0.5;
            let lower = (block.first[a] as f64 + f64::from(octant.lower[a]) + 0.5) * rate - origin;
            low[a] = (lower + 0.25 * rate).floor() as i32;
            place[a] = [0.0, 0.5].map(|by| (lower + by * rate - f64::from(low[a])) as f32);
        }
        Some((place, holder, low))
    }

    /// Samples of a block from `low` on; NaN for those that its level does not have.
    fn eight(&self, number: usize, low: [i32; 3]) -> Option<[f32; 8]> {
        let Some((dims, values)) = self.lattices.of(self.grid, number) else {
            return self.samples.corners(number, low);
        };
        let [x, y, z] = low.map(|i| (i + 1) as usize);
        let (row, layer) = (dims[0], dims[0] * dims[1]);
        let values = values.get(z * layer + y * row + x..)?;
        let far = values.get(layer + row..layer + row + 2)?;
        Some([values[0], values[1], values[row], values[row + 1], values[layer], values[layer + 1], far[0], far[1]])
    }
}

/// Octant of a cell.
struct Octant {
    /// Its cell, counted from the first of the block.
    cell: [i32; 3],
    /// Place of its lowest corner among the samples of the block.
    lower: [f32; 3],
    /// True if it is the lower half of its cell, axis by axis: the upper half of the way between two samples.
    is_upper: [bool; 3],
    /// Place in it, 0 to 1.
    place: [f32; 3],
}

impl Octant {
    /// The octant at a fraction of the way between samples from `low` on.
    fn new(low: [i32; 3], fraction: [f32; 3]) -> Self {
        let is_upper = fraction.map(|t| t >= 0.5);
        let half = |a: usize| if is_upper[a] { 0.5 } else { 0.0 };
        Self {
            cell: std::array::from_fn(|a| low[a] + i32::from(is_upper[a])),
            lower: std::array::from_fn(|a| low[a] as f32 + half(a)),
            is_upper,
            place: std::array::from_fn(|a| (fraction[a] - half(a)) * 2.0),
        }
    }

    /// Means of the samples around each corner, which are the samples themselves in the middles of cells; NaN if one of them is missing.
    fn own_corners(&self, samples: &[f32; 8]) -> [f32; 8] {
        let mut at = *samples;
        for a in 0..3 {
            let bit = 1 << a;
            for i in (0..8).filter(|i| i & bit == 0) {
                let middle = (at[i] + at[i | bit]) * 0.5;
                at[if self.is_upper[a] { i } else { i | bit }] = middle;
            }
        }
        at
    }
}

/// Trilinear interpolation between eight samples, at all combinations of two places along each axis.
fn between(samples: &[f32; 8], places: [[f32; 2]; 3]) -> [f32; 8] {
    let mut at = *samples;
    for a in 0..3 {
        let bit = 1 << a;
        for i in (0..8).filter(|i| i & bit == 0) {
            let (low, rise) = (at[i], at[i | bit] - at[i]);
            (at[i], at[i | bit]) = (low + places[a][0] * rise, low + places[a][1] * rise);
        }
    }
    at
}

fn trilinear(samples: &[f32; 8], at: [f32; 3]) -> f32 {
    between(samples, at.map(|t| [t; 2]))[0]
}
