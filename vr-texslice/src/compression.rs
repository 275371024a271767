//! Block compression of values at a fixed rate: any texel can be decoded by itself.

use vr_core::filter::Lattice;
use vr_core::parallel::each_part;
use vr_core::{GridVolume, LatticeVisitor, Real, VacuumCells, Voxel, gradient_between_samples};
use vr_kernels::ranges::BlockRange;

use crate::region::Region;
use crate::texel_cell::texel_cell;

/// Texels along the edge of a block.
const EDGE: usize = 4;
/// Texels of a block.
const TEXELS: usize = EDGE * EDGE * EDGE;

/// A volume in blocks of 4³ texels: the smallest and the largest value of each, and for every texel one of 8 levels between them (of bytes; of 16 for wider
/// types). So do the formats BC4 and 3Dc of graphics cards over squares of 4².
///
/// Stored as a card would, end points in the type of the samples: 26 bytes for 64 of bytes, 36 for 128 of 16-bit integers, 40 for 256 of floats. An error is at
/// most half a level: a fourteenth (a thirtieth) of a block's range.
#[derive(Clone, Debug)]
pub(crate) struct Compressed {
    dims: [usize; 3],
    blocks: [usize; 3],
    /// Levels of a texel: 3 or 4 bits.
    bits: u32,
    /// Bytes of an end point where it is stored.
    end_bytes: usize,
    /// The smallest value of each block, and from one level to the next.
    ends: Vec<[f32; 2]>,
    /// One number a texel, block by block: 8 bytes for 16 texels of 4 bits, 24 for 64 of 3.
    levels: Vec<u64>,
    /// Cells with a missing corner, a bit each: blocks hold the nearest value in the place of missing ones. `None` if there are none.
    vacuum: Option<VacuumCells>,
}

impl Compressed {
    pub(crate) fn new(volume: &GridVolume) -> Self {
        let all = volume.with_lattice(Compress { end_bytes: volume.voxel_type().bytes() });
        Self { vacuum: volume.vacuum_cells().cloned(), ..all }
    }

    /// Bytes that the texture of a volume takes here.
    pub(crate) fn bytes_in_memory(volume: &GridVolume) -> u64 {
        let blocks: usize = volume.dims().iter().map(|n| n.div_ceil(EDGE)).product();
        let words = bits_of_level(volume.voxel_type().bytes()) as usize;
        (blocks * (size_of::<[f32; 2]>() + words * size_of::<u64>())) as u64
    }

    pub(crate) fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Bytes of the texture as a card would hold it: both end points in the samples' type.
    pub(crate) fn bytes(&self) -> u64 {
        let cells = self.dims.map(|n| n - 1).iter().product::<usize>();
        let mask = if self.vacuum.is_some() { cells.div_ceil(64) * 8 } else { 0 };
        (self.ends.len() * 2 * self.end_bytes + self.levels.len() * 8 + mask) as u64
    }

    /// The value of a texel.
    #[inline(always)]
    pub(crate) fn at(&self, [x, y, z]: [usize; 3]) -> f32 {
        let block = (z / EDGE * self.blocks[1] + y / EDGE) * self.blocks[0] + x / EDGE;
        let texel = (z % EDGE * EDGE + y % EDGE) * EDGE + x % EDGE;
        let [low, step] = self.ends[block];
        low + step * self.level(block, texel) as f32
    }

    /// The texels around a cell, x fastest; NaN where one is missing.
    #[inline(always)]
    pub(crate) fn cell(&self, [x, y, z]: [usize; 3]) -> [f32; 8] {
        let mut corners = [f32::NAN; 8];
        if self.vacuum.as_ref().is_some_and(|vacuum| vacuum.is_vacuum([x, y, z])) {
            return corners;
        }
        for (i, corner) in corners.iter_mut().enumerate() {
            *corner = self.at([x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)]);
        }
        corners
    }

    /// The stored number at a place in the index space of the volume, linear between texels or that of the nearest; NaN where [`texel_cell`] has none.
    pub(crate) fn value_at(&self, volume: &GridVolume, at: [f64; 3]) -> f64 {
        let Some((cell, [x, y, z])) = texel_cell(volume, at) else { return f64::NAN };
        let [c0, c1, c2, c3, c4, c5, c6, c7] = self.cell(cell).map(f64::from);
        let mix = |low: f64, high: f64, t: f64| low + t * (high - low);
        mix(mix(mix(c0, c1, x), mix(c2, c3, x), y), mix(mix(c4, c5, x), mix(c6, c7, x), y), z)
    }

    /// Derivative of the field between texels per index step, inside the cell of a place in index space; NaN beside a missing one.
    pub(crate) fn slope_at(&self, at: [f64; 3]) -> [f64; 3] {
        let cell: [usize; 3] = std::array::from_fn(|a| (at[a] as usize).min(self.dims[a] - 2));
        let corners = self.cell(cell).map(f64::from);
        std::array::from_fn(|a| {
            let [b, c] = [[1, 2], [0, 2], [0, 1]][a];
            let (t, u) = (at[b] - cell[b] as f64, at[c] - cell[c] as f64);
            let rise = |along_b: usize, along_c: usize| {
                let low = (along_b << b) + (along_c << c);
                corners[low + (1 << a)] - corners[low]
            };
            let row = |along_c: usize| rise(0, along_c) + t * (rise(1, along_c) - rise(0, along_c));
            row(0) + u * (row(1) - row(0))
        })
    }

    /// Central differences of the texels per index step, linear between them, at a place in index space: from the texels of the cells around it.
    pub(crate) fn gradient_at<R: Real>(&self, at: [R; 3]) -> [R; 3] {
        gradient_of_texels(self.dims, at, |texel| self.at(texel))
    }

    /// The values of texels, in the place of missing ones the nearest.
    pub(crate) fn decode(&self, region: &Region) -> Vec<f32> {
        let mut texels = vec![0.0; region.count()];
        each_part(texels.chunks_mut(region.dims[0]), |row, texels| {
            let [first, y, z] = region.row(row);
            texels.iter_mut().zip(first..).for_each(|(texel, x)| *texel = self.at([x, y, z]));
        });
        texels
    }

    /// The values of texels, NaN for those that are missing.
    ///
    /// Which cells are vacuum is known, and not which texels are missing: those count as it that have vacuum on all sides. Each cell of vacuum has one of
    /// them at a corner, and no other cell has.
    pub(crate) fn decode_with_missing(&self, region: &Region) -> Vec<f32> {
        let mut texels = self.decode(region);
        let Some(vacuum) = &self.vacuum else { return texels };
        each_part(texels.chunks_mut(region.dims[0]), |row, texels| {
            let [first, y, z] = region.row(row);
            for (texel, x) in texels.iter_mut().zip(first..) {
                let at = [x, y, z];
                let around = |a: usize| at[a].saturating_sub(1)..=at[a].min(self.dims[a] - 2);
                let missing = around(2).all(|z| around(1).all(|y| around(0).all(|x| vacuum.is_vacuum([x, y, z]))));
                *texel = if missing { f32::NAN } else { *texel };
            }
        });
        texels
    }

    /// Bounds of the field in cells, given from the first to behind the last along each axis: those of the blocks that hold their corners.
    pub(crate) fn range(&self, cells: &[[usize; 2]; 3]) -> BlockRange {
        let last = ((1u32 << self.bits) - 1) as f32;
        let [x, y, z] = cells.map(|[first, behind]| first / EDGE..behind / EDGE + 1);
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for row in z.flat_map(|z| y.clone().map(move |y| (z * self.blocks[1] + y) * self.blocks[0])) {
            for [smallest, step] in &self.ends[row + x.start..row + x.end] {
                (low, high) = (low.min(*smallest), high.max(smallest + step * last));
            }
        }
        BlockRange::of_trilinear([low, high])
    }

    /// Level of a texel. Of 3 bits, 21 levels share a word but for the last of the block's three, which holds 22: levels run on across words.
    #[inline(always)]
    fn level(&self, block: usize, texel: usize) -> u64 {
        let words = self.bits as usize;
        let bit = texel * words;
        let (word, shift) = (block * words + bit / 64, bit as u32 % 64);
        let mut level = self.levels[word] >> shift;
        if shift + self.bits > 64 {
            level |= self.levels[word + 1] << (64 - shift);
        }
        level & ((1 << self.bits) - 1)
    }
}

/// Central differences of texels per index step, linear between them, at a place in the index space of a texture of so many texels along each axis.
#[inline(always)]
pub(crate) fn gradient_of_texels<R: Real>(dims: [usize; 3], at: [R; 3], texel: impl Fn([usize; 3]) -> f32) -> [R; 3] {
    let cell: [usize; 3] = std::array::from_fn(|a| at[a].to_index().min(dims[a] - 2));
    let low = cell.map(|c| c.saturating_sub(1));
    let dims: [usize; 3] = std::array::from_fn(|a| (cell[a] + 3).min(dims[a]) - low[a]);
    let mut texels = [0.0; TEXELS];
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                texels[(z * dims[1] + y) * dims[0] + x] = texel([low[0] + x, low[1] + y, low[2] + z]);
            }
        }
    }
    let lattice = Lattice { samples: &texels[..dims.iter().product()], dims };
    gradient_between_samples(&lattice, std::array::from_fn(|a| at[a] - R::from_index(low[a])))
}

/// Bits of a texel's level, and words of a block, of samples of so many bytes.
fn bits_of_level(bytes: usize) -> u32 {
    if bytes == 1 { 3 } else { 4 }
}

struct Compress {
    end_bytes: usize,
}

impl LatticeVisitor for Compress {
    type Output = Compressed;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Compressed {
        let dims = lattice.dims;
        let blocks = dims.map(|n| n.div_ceil(EDGE));
        let bits = bits_of_level(self.end_bytes);
        let count = blocks.iter().product();
        let (mut ends, mut levels) = (vec![[0.0; 2]; count], vec![0u64; count * bits as usize]);
        // A row of blocks along x is a task.
        let rows = ends.chunks_mut(blocks[0]).zip(levels.chunks_mut(blocks[0] * bits as usize));
        each_part(rows, |row, (ends, levels)| {
            for (x, (ends, words)) in ends.iter_mut().zip(levels.chunks_mut(bits as usize)).enumerate() {
                let corner = [x, row % blocks[1], row / blocks[1]];
                // Beyond the volume's end lies its last texel again.
                let value = |texel: usize| {
                    let inside = [texel % EDGE, texel / EDGE % EDGE, texel / (EDGE * EDGE)];
                    let [x, y, z]: [usize; 3] =
                        std::array::from_fn(|a| (corner[a] * EDGE + inside[a]).min(dims[a] - 1));
                    lattice.at::<f32>(x, y, z)
                };
                let values: [f32; TEXELS] = std::array::from_fn(value);
                let low = values.iter().copied().fold(f32::INFINITY, f32::min);
                let high = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
                let last = ((1u32 << bits) - 1) as f32;
                // Halves first: the range of floats may be beyond the largest float.
                let step = 2.0 * ((0.5 * high - 0.5 * low) / last);
                *ends = [low, step];
                for (texel, &v) in values.iter().enumerate() {
                    let level = if step > 0.0 { ((v - low) / step + 0.5).min(last) as u64 } else { 0 };
                    let bit = texel * bits as usize;
                    words[bit / 64] |= level << (bit % 64);
                    if bit % 64 + bits as usize > 64 {
                        words[bit / 64 + 1] |= level >> (64 - bit % 64);
                    }
                }
            }
        });
        Compressed { dims, blocks, bits, end_bytes: self.end_bytes, ends, levels, vacuum: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{AnyGrid, Calibration, Placement, UniformGrid, Volume};

    fn compressed<T: Voxel>(dims: [usize; 3], samples: Vec<T>) -> Compressed
    where
        AnyGrid: From<UniformGrid<T>>,
    {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into();
        Compressed::new(volume.grid().unwrap())
    }

    #[test]
    fn errors_are_half_a_level_of_a_block() {
        let dims = [9, 7, 6];
        let number = |i: usize| (i * 7919 % 251) as f32;
        let bytes = compressed(dims, (0..378).map(|i| number(i) as u8).collect());
        let floats = compressed(dims, (0..378).map(|i| number(i) * 1e9).collect::<Vec<f32>>());
        for i in 0..378 {
            let at = [i % 9, i / 9 % 7, i / 63];
            assert!((bytes.at(at) - number(i)).abs() <= 250.0 / 14.0 + 1e-4, "{at:?}");
            // Rounding of a level, and of what it is multiplied by.
            assert!((floats.at(at) / 1e9 - number(i)).abs() <= 250.0 / 30.0 + 1e-3, "{at:?}");
        }
        assert_eq!(bytes.cell([3, 2, 1])[7], bytes.at([4, 3, 2]));
        assert_eq!((bytes.bytes(), floats.bytes()), (3 * 2 * 2 * 26, 3 * 2 * 2 * 40));
        for made in [bytes, floats] {
            assert_eq!(size_of_val(&*made.ends) + size_of_val(&*made.levels), 12 * (8 + 8 * made.bits as usize));
        }
    }

    #[test]
    fn a_block_of_levels_is_exact() {
        let levels = compressed([4, 4, 4], (0..64).map(|i| (i % 8 * 5) as u8).collect());
        assert!((0..64).all(|i| levels.at([i % 4, i / 4 % 4, i / 16]) == (i % 8 * 5) as f32));
        let constant = compressed([4, 4, 4], vec![-3.5f32; 64]);
        assert_eq!(constant.at([1, 2, 3]), -3.5);
    }

    #[test]
    fn a_decoded_brick_is_the_field_of_its_blocks() {
        let dims = [9, 7, 6];
        let holes = |[x, y, z]: [usize; 3]| (x < 3 && y < 3) || [x, y, z] == [6, 5, 2] || z == 5 && x > 6;
        let value = |i: usize| {
            let at = [i % 9, i / 9 % 7, i / 63];
            if holes(at) { f32::NAN } else { (i * 7919 % 251) as f32 }
        };
        let texture = compressed(dims, (0..378).map(value).collect());
        let region = Region::around(&[[2, 8], [1, 6], [0, 5]], 1, dims);
        let texels = texture.decode_with_missing(&region);
        let (mut missing, filled) = (0, texture.decode(&region));
        for z in region.first[2]..region.first[2] + region.dims[2] - 1 {
            for y in region.first[1]..region.first[1] + region.dims[1] - 1 {
                for x in region.first[0]..region.first[0] + region.dims[0] - 1 {
                    let corner = |i: usize| {
                        let at = [x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)];
                        let [x, y, z] = std::array::from_fn(|a| at[a] - region.first[a]);
                        (z * region.dims[1] + y) * region.dims[0] + x
                    };
                    let corners: [usize; 8] = std::array::from_fn(corner);
                    let blocks = texture.cell([x, y, z]);
                    let vacuum = blocks[0].is_nan();
                    missing += u32::from(vacuum);
                    // Cells of vacuum have a missing corner, others none; and their values are bounded.
                    assert_eq!(corners.iter().any(|&i| texels[i].is_nan()), vacuum, "{x} {y} {z}");
                    let range = texture.range(&[[x, x + 1], [y, y + 1], [z, z + 1]]);
                    for (i, block) in corners.into_iter().zip(blocks).filter(|_| !vacuum) {
                        assert!(texels[i] == block && filled[i] == block && (range.low..=range.high).contains(&block));
                    }
                }
            }
        }
        assert!(missing > 20 && filled.iter().all(|v| v.is_finite()), "{missing}");
    }
}
