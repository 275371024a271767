//! The field of a scene's volume within a clip: values and colours at a point, and ranges in a box.

use std::sync::Arc;

use glam::DVec3;
use vr_core::filter::Reconstruction;
use vr_core::{Calibration, Clip, GridVolume, Sampler, SamplerVisitor, Volume, Voxel};
use vr_kernels::ranges::RangeBlocks;

/// A volume within a clip.
#[derive(Clone, Debug)]
pub(super) struct SceneField {
    volume: Volume,
    clip: Clip,
    bounds: (DVec3, DVec3),
    /// The values, where they are those of a grid.
    grid: Option<GridValues>,
    /// Ranges of a grid's values in blocks.
    blocks: Option<Arc<RangeBlocks>>,
}

/// Values of a grid at world points.
#[derive(Clone, Debug)]
struct GridValues {
    grid: Arc<GridVolume>,
    /// Index of the last voxel along each axis.
    last: DVec3,
    calibration: Calibration,
}

/// Bounds of the field in a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct ValueRange {
    /// Lower bound of the values; above `high` if all of the box is vacuum.
    pub low: f64,
    /// Upper bound of the values.
    pub high: f64,
    /// True if a part of the box may be vacuum.
    pub has_vacuum: bool,
}

impl ValueRange {
    /// True if the box is vacuum.
    pub fn is_empty(&self) -> bool {
        self.low > self.high
    }
}

/// Cells along the edge of a block of a grid.
const EDGE: usize = 8;
/// Largest number of ranges along an axis that are worth telling apart.
const MAX_RESOLUTION: usize = 128;
/// Part of a voxel by which a box may reach into the next block before that one counts: boxes are cut at blocks, and rounded.
const REACH: f64 = 1e-7;

impl SceneField {
    pub fn new(volume: &Volume, clip: &Clip) -> Self {
        let (mut low, mut high) = volume.bounds();
        if let Some(crop) = clip.crop {
            (low, high) = (low.max(crop.0), high.min(crop.1));
        }
        let blocks = volume.value_grid().map(|grid| RangeBlocks::of_volume(grid, EDGE));
        let grid = volume.value_grid().map(GridValues::new);
        Self { volume: volume.clone(), clip: clip.clone(), bounds: (low, high), grid, blocks }
    }

    /// World box outside of which is vacuum; its corners are the wrong way round if the clip leaves nothing.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Number of blocks along x, y and z of the world.
    pub fn resolution(&self) -> [usize; 3] {
        let Some(grid) = self.volume.value_grid() else { return [1; 3] };
        // The block's edges along its own axes, seen along those of the world.
        let edge = EDGE as f64 * grid.placement().spacing().min_element();
        (self.bounds.1 - self.bounds.0)
            .to_array()
            .map(|length| ((length / edge - REACH).ceil() as usize).clamp(1, MAX_RESOLUTION))
    }

    /// The value at a point; `None` in vacuum.
    pub fn value(&self, at: DVec3) -> Option<f64> {
        if !self.keeps(at) {
            return None;
        }
        match &self.grid {
            Some(grid) => grid.at(at).map(|found| found.0),
            None => self.volume.field().and_then(|field| field.value(at)),
        }
    }

    /// Fills the values at points, NaN in vacuum.
    pub fn values(&self, at: &[DVec3], out: &mut [f64]) {
        match &self.grid {
            Some(grid) => grid.grid.with_sampler(ValuesAt { values: grid, field: self, at, out }),
            None => {
                for (out, &at) in out.iter_mut().zip(at) {
                    *out = self.value(at).unwrap_or(f64::NAN);
                }
            }
        }
    }

    /// The value at a point and the colour of the place, white where it has none; `None` in vacuum.
    pub fn at(&self, at: DVec3) -> Option<(f64, [f64; 3])> {
        let Volume::Color(colors) = &self.volume else {
            let color = || self.volume.field().and_then(|field| field.color(at)).unwrap_or([1.0; 3]);
            return self.value(at).map(|value| (value, color()));
        };
        if !self.keeps(at) {
            return None;
        }
        self.grid.as_ref()?.at(at).map(|(value, index)| (value, colors.color(index)))
    }

    /// Bounds of the values in a box.
    pub fn range(&self, low: DVec3, high: DVec3) -> ValueRange {
        let cut = !self.keeps_box(low, high);
        let (Some(grid), Some(blocks)) = (self.volume.value_grid(), &self.blocks) else {
            return ValueRange { low: f64::NEG_INFINITY, high: f64::INFINITY, has_vacuum: true };
        };
        let mut range = ValueRange { low: f64::INFINITY, high: f64::NEG_INFINITY, has_vacuum: cut };
        let Some(spans) = blocks_of_box(grid, blocks, low, high) else { return range };
        let calibration = grid.calibration();
        range.has_vacuum |= spans.leaves_grid;
        let [xs, ys, zs] = spans.blocks;
        for z in zs {
            for y in ys.clone() {
                for x in xs.clone() {
                    let block = blocks.at([x, y, z]);
                    range.has_vacuum |= block.vacuum;
                    if !block.is_empty() {
                        let ends = [block.low, block.high].map(|stored| calibration.value(stored.into()));
                        range.low = range.low.min(ends[0]).min(ends[1]);
                        range.high = range.high.max(ends[0]).max(ends[1]);
                    }
                }
            }
        }
        range
    }

    fn keeps(&self, at: DVec3) -> bool {
        super::contains(self.bounds, at) && self.clip.planes.iter().all(|p| p.normal.dot(at) >= p.offset)
    }

    /// True if all of a box is kept.
    fn keeps_box(&self, low: DVec3, high: DVec3) -> bool {
        let reach = 1e-12 * (high - low);
        let inside = low.cmpge(self.bounds.0 - reach).all() && high.cmple(self.bounds.1 + reach).all();
        // The corner furthest against a plane's normal is the first to be cut away.
        let corner = |normal: DVec3| DVec3::select(normal.cmpgt(DVec3::ZERO), low, high);
        inside && self.clip.planes.iter().all(|p| p.normal.dot(corner(p.normal)) >= p.offset)
    }
}

impl GridValues {
    fn new(grid: &Arc<GridVolume>) -> Self {
        let last = DVec3::from_array(grid.dims().map(|n| (n - 1) as f64));
        Self { grid: Arc::clone(grid), last, calibration: grid.calibration() }
    }

    /// Index-space position of a world point; `None` outside the box.
    #[inline]
    fn index(&self, at: DVec3) -> Option<[f64; 3]> {
        let index = self.grid.placement().to_index(at);
        // A point on the face may be rounded to the outside.
        let inside = index.cmpge(DVec3::splat(-REACH)).all() && index.cmple(self.last + REACH).all();
        inside.then(|| index.max(DVec3::ZERO).min(self.last).to_array())
    }

    /// The value at a world point, and the point in index space; `None` in vacuum.
    fn at(&self, at: DVec3) -> Option<(f64, [f64; 3])> {
        let index = self.index(at)?;
        let stored = self.grid.stored_at(index);
        (!stored.is_nan()).then(|| (self.calibration.value(stored), index))
    }
}

/// Values at several points, by one sampler: their voxels come from memory at once.
struct ValuesAt<'a> {
    values: &'a GridValues,
    field: &'a SceneField,
    at: &'a [DVec3],
    out: &'a mut [f64],
}

impl SamplerVisitor for ValuesAt<'_> {
    type Output = ();
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        for (out, &at) in self.out.iter_mut().zip(self.at) {
            let index = if self.field.keeps(at) { self.values.index(at) } else { None };
            *out = index.map_or(f64::NAN, |index| self.values.calibration.value(sampler.value(index)));
        }
    }
}

/// Blocks that a box meets.
struct Spans {
    blocks: [std::ops::Range<usize>; 3],
    /// True if a part of the box is outside of the grid.
    leaves_grid: bool,
}

/// Blocks of a grid that a world box meets; `None` where it meets none.
fn blocks_of_box(grid: &GridVolume, blocks: &RangeBlocks, low: DVec3, high: DVec3) -> Option<Spans> {
    let placement = grid.placement();
    let corners: [DVec3; 8] = std::array::from_fn(|c| {
        let pick = |axis: usize| if c >> axis & 1 == 1 { high[axis] } else { low[axis] };
        placement.to_index(DVec3::new(pick(0), pick(1), pick(2)))
    });
    let first = corners.into_iter().fold(DVec3::INFINITY, DVec3::min);
    let last = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max);
    let mut spans = Spans { blocks: [0..0, 0..0, 0..0], leaves_grid: false };
    for a in 0..3 {
        let end = (grid.dims()[a] - 1) as f64;
        spans.leaves_grid |= first[a] < -REACH || last[a] > end + REACH;
        if !(first[a] <= end + REACH && last[a] >= -REACH) {
            return None;
        }
        let edge = blocks.edge() as f64;
        let count = blocks.blocks()[a];
        // `as` saturates.
        let from = (((first[a] + REACH) / edge).floor() as usize).min(count - 1);
        let to = (((last[a] - REACH) / edge).ceil() as usize).clamp(from + 1, count);
        spans.blocks[a] = from..to;
    }
    Some(spans)
}
