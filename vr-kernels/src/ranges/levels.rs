//! Ranges of the field in small blocks, in two bytes each.

use std::sync::Arc;

use super::blocks::{BlockRange, block_ranges, bounds};
use vr_core::GridVolume;
use vr_core::filter::Trilinear;

/// Smallest and largest value of the field in each block of [`LevelRanges::EDGE`]³ cells, rounded outward to 256 levels.
///
/// Two bytes a block are 3 % of a volume of bytes, where [`RangeBlocks`](crate::ranges::RangeBlocks) of such small blocks would be a fifth of it. And there are
/// so few different ranges that what follows from one can be looked up in a table over both ends. Integers that span no more than 255 are
/// levels themselves.
///
/// A range may fall short of the field by [`LevelRanges::SLACK`] of a level: it serves decisions that cost a little where they err, not proofs.
#[derive(Clone, Debug)]
pub struct LevelRanges {
    blocks: [usize; 3],
    origin: f64,
    spacing: f64,
    ranges: Vec<[u8; 2]>,
    /// True for blocks of which a part is vacuum; empty where no voxel is missing.
    holes: Vec<bool>,
}

impl LevelRanges {
    /// Cells along the edge of a block.
    pub const EDGE: usize = 4;
    /// The last level.
    pub const LAST: u8 = u8::MAX;
    /// Part of a level by which a range may fall short: bounds are widened for rounding in f32, which must not cost a whole level.
    pub const SLACK: f64 = 0.01;

    /// Ranges of a volume's field; made once and kept with the volume.
    pub fn of_volume(volume: &GridVolume) -> Arc<Self> {
        volume.derived().get(volume.filter(), || Self::of_field(volume))
    }

    fn of_field(volume: &GridVolume) -> Self {
        let last = f64::from(Self::LAST);
        // Filters may overshoot the voxels: levels end where these do, and what lies beyond belongs to the last one.
        let (low, high) = volume.value_stats().range.map_or((0.0, 0.0), |(l, h)| (f64::from(l), f64::from(h)));
        let span = high - low;
        let spacing = if Self::are_exact(volume) || span == 0.0 { 1.0 } else { span / last };
        let level = |stored: f32| (f64::from(stored) - low) / spacing;
        let keep = |range: BlockRange| {
            if range.is_empty() {
                return Self::NOTHING;
            }
            // `as` saturates.
            [(level(range.low) + Self::SLACK).floor() as u8, (level(range.high) - Self::SLACK).ceil() as u8]
        };
        let (blocks, ranges) = block_ranges(volume, Self::EDGE, keep);
        Self { blocks, origin: low, spacing, ranges, holes: holes(volume, blocks) }
    }

    /// The range of a block that is vacuum throughout: its ends are the wrong way round.
    pub const NOTHING: [u8; 2] = [u8::MAX, 0];

    /// True if levels are a volume's own numbers, integers that span no more than 255: the range of a trilinear field in a block is exact
    /// then.
    pub fn are_exact(volume: &GridVolume) -> bool {
        let span = volume.value_stats().range.map_or(0.0, |(low, high)| f64::from(high) - f64::from(low));
        span <= f64::from(Self::LAST) && volume.voxel_type().is_integer()
    }

    /// Blocks along x, y, z.
    pub fn blocks(&self) -> [usize; 3] {
        self.blocks
    }

    /// Lower and upper level of each block, x fastest.
    pub fn ranges(&self) -> &[[u8; 2]] {
        &self.ranges
    }

    /// True if a part of a block is vacuum (cells with a missing corner), of which its range says nothing.
    pub fn has_hole(&self, block: usize) -> bool {
        self.holes.get(block).is_some_and(|&hole| hole)
    }

    /// True if a part of any block is vacuum.
    pub fn has_holes(&self) -> bool {
        !self.holes.is_empty()
    }

    /// The bounds that [`RangeBlocks`](crate::ranges::RangeBlocks) would give of a trilinear field between two levels, where levels are exact.
    pub fn bounds(&self, levels: [u8; 2]) -> (f32, f32) {
        let [low, high] = levels.map(|level| self.stored(level) as f32);
        bounds::<Trilinear>(low, high)
    }

    /// The stored number of a level.
    pub fn stored(&self, level: u8) -> f64 {
        self.origin + f64::from(level) * self.spacing
    }
}

/// True for blocks of which a part is vacuum; empty where no voxel is missing.
fn holes(volume: &GridVolume, blocks: [usize; 3]) -> Vec<bool> {
    let Some(vacuum) = volume.vacuum_cells() else { return Vec::new() };
    let mut holes = vec![false; blocks.iter().product()];
    let cells = volume.dims().map(|n| n - 1);
    for z in 0..cells[2] {
        for y in 0..cells[1] {
            let row = (z / LevelRanges::EDGE * blocks[1] + y / LevelRanges::EDGE) * blocks[0];
            for x in 0..cells[0] {
                holes[row + x / LevelRanges::EDGE] |= vacuum.is_vacuum([x, y, z]);
            }
        }
    }
    holes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranges::RangeBlocks;
    use vr_core::Filter;
    use vr_core::Placement;
    use vr_core::Volume;
    use vr_core::Voxel;
    use vr_core::{Calibration, UniformGrid};

    fn volume<T: Voxel>(dims: [usize; 3], samples: Vec<T>) -> Volume
    where
        Volume: From<UniformGrid<T>>,
    {
        UniformGrid::new(dims, samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default())
            .unwrap()
            .into()
    }

    #[test]
    fn bytes_are_their_own_levels() {
        let samples: Vec<u8> = (0..9 * 5 * 5).map(|i| (i * 37 % 200) as u8 + 20).collect();
        let volume = volume([9, 5, 5], samples.clone());
        let ranges = LevelRanges::of_volume(volume.grid().unwrap());
        assert_eq!(ranges.blocks(), [2, 1, 1]);
        assert!(LevelRanges::are_exact(volume.grid().unwrap()));
        let of = |xs: std::ops::RangeInclusive<usize>| {
            let all = (0..25).flat_map(|row| xs.clone().map(move |x| row * 9 + x)).map(|i| samples[i]);
            [all.clone().min().unwrap(), all.max().unwrap()]
        };
        let stored = ranges.ranges().iter().map(|r| r.map(|l| ranges.stored(l) as u8)).collect::<Vec<_>>();
        assert_eq!(stored, [of(0..=4), of(4..=8)]);
        let blocks = RangeBlocks::of_volume(volume.grid().unwrap(), LevelRanges::EDGE);
        for (levels, block) in ranges.ranges().iter().zip(blocks.ranges()) {
            assert_eq!(ranges.bounds(*levels), (block.low, block.high));
        }
    }

    #[test]
    fn ranges_enclose_the_field() {
        for filter in Filter::ALL {
            let samples: Vec<f32> = (0..216).map(|i| ((i * i) as f32 * 0.7).sin() * 1e4 + 3e4).collect();
            let volume = volume([6, 6, 6], samples).with_filter(filter);
            let volume = volume.grid().unwrap();
            let (exact, rounded) = (RangeBlocks::of_volume(volume, LevelRanges::EDGE), LevelRanges::of_volume(volume));
            for (exact, levels) in exact.ranges().iter().zip(rounded.ranges()) {
                let slack = LevelRanges::SLACK * rounded.spacing;
                let [low, high] = levels.map(|l| rounded.stored(l));
                // Overshoot falls to the levels at the ends.
                let (least, most) = (rounded.stored(0), rounded.stored(LevelRanges::LAST));
                assert!(
                    low <= f64::from(exact.low).max(least) + slack && high >= f64::from(exact.high).min(most) - slack
                );
            }
        }
    }

    #[test]
    fn vacuum_is_nothing() {
        let volume = volume([2, 2, 2], vec![f32::NAN; 8]);
        assert_eq!(LevelRanges::of_volume(volume.grid().unwrap()).ranges(), [LevelRanges::NOTHING]);
    }

    #[test]
    fn holes_are_noted_beside_the_range_of_the_rest() {
        let mut samples = vec![3.0f32; 9 * 5 * 5];
        samples[7] = f32::NAN;
        let ranges = volume([9, 5, 5], samples);
        let ranges = LevelRanges::of_volume(ranges.grid().unwrap());
        assert_eq!((ranges.has_hole(0), ranges.has_hole(1)), (false, true));
        assert_eq!(ranges.ranges()[0], ranges.ranges()[1]);
        let whole = volume([2, 2, 2], vec![1.0f32; 8]);
        assert!(!LevelRanges::of_volume(whole.grid().unwrap()).has_holes());
    }
}
