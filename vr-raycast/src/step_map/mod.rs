//! Map of the steps of rays: each small block is passed over, or crossed in steps as long as its content allows.

mod classes;
mod features;
mod range_steps;
mod sharp;

pub(crate) use range_steps::RangeSteps;
pub(crate) use sharp::SharpValues;

use std::sync::Arc;

use vr_core::cancel;
use vr_core::parallel::{collect, each_part};
use vr_core::{Calibration, Filter, GradientMethod, Scene, Shading};
use vr_kernels::ranges::LevelRanges;

use crate::leap::{VisibleBlocks, chessboard_distances};
use classes::{Classes, LevelVariations, class_of, step_of};

/// Map with a byte per block of 4³ cells: the step to take in it, or its distance from anything visible.
///
/// The error of a midpoint step of length h is h²/24 times the second derivative, along the ray, of what is integrated: extinction κ and
/// emission q. That derivative is of the size D/e², D how much κ and q vary within a block of edge e. So the step is h = e·√(ε/D)
/// where D (the sum of all rises and falls over the block's range of values) is the largest of the block's own and those that the step
/// can lead into, ε the error allowed per unit length; it is kept between bounds. Changes beyond an optical depth of about
/// one a voxel do not show: light saturates. Where a peak or a gap of the transfer function is thinner than such a step, the step
/// follows from that (see `features.rs`).
///
/// At jumps of the field (the faces of voxels under the filter nearest, and of cells that are vacuum) no second derivative tells
/// anything: steps end at those faces.
///
/// It is an estimate, not a bound. What it comes to in pictures is measured, and [`crate::Step::Local`] says so.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StepMap {
    blocks: [usize; 3],
    bytes: Vec<u8>,
    steps: [f32; CLASSES],
    cuts: Cuts,
}

/// Faces at which the field jumps, and steps end.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cuts {
    /// No faces: the field does not jump.
    None,
    /// Faces in these blocks, which have missing voxels in them or next to them.
    Holes(Vec<bool>),
    /// Faces in all blocks: the field is constant around each voxel.
    Voxels {
        /// True if the faces of cells count, too: voxels are missing, and vacuum cells have faces of their own, or normals are interpolated, and bend there.
        cells: bool,
        /// World length of the longest step between faces.
        length: f32,
    },
}

/// Movement of a ray in a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BlockStep {
    /// Step of this length, in world units.
    Step(f32),
    /// Step of this length, or to the next of [`StepMap::faces`].
    CutStep(f32),
    /// Leap to the point where the ray leaves the blocks up to this many around, in which nothing is visible.
    Leap(u8),
}

/// Smallest byte of a clear block; the difference to it is the number of clear blocks around in each direction.
pub(crate) const CLEAR: u8 = 128;
/// Number of classes of steps, each longer than the one before by √2.
const CLASSES: usize = 23;
/// Length of the shortest step in voxels. No multiple of it by a power of √2 is near a small ratio of whole numbers: along an axis, samples would meet
/// voxels always at the same phase, and mistake what alternates from voxel to voxel for a constant.
pub(crate) const SHORTEST: f64 = 0.0577 / 8.0;
/// Length of the longest step in voxels: just under four blocks.
const LONGEST: f64 = SHORTEST * 2048.0;

/// Length of the longest step in voxels where voxels have colours of their own.
const LONGEST_BESIDE_COLORS: f64 = SHORTEST * 24.0;

/// Returns the longest step inside a voxel of a field that is constant there: all of the voxel, unless what is reflected changes with normals that are
/// interpolated. Steps end at the faces of cells then, too, beyond which normals bend or, where a region ends, begin; and two fifths of a voxel keep the
/// error within that of the other steps (a ball of one label, 30³ voxels at 256×256 pixels: RMSE 8.1·10⁻⁴ with whole pieces, 6.5·10⁻⁴ with halves of a
/// voxel, 3.4·10⁻⁴ with two fifths, 1.8·10⁻⁴ with quarters; 1.1·10⁻³ with quarters that did not end at those faces, and more of them).
fn length_in_voxels(scene: &Scene, voxel: f64) -> f32 {
    let interpolated = |shading: &Arc<Shading>| shading.gradient == GradientMethod::CentralDifferences;
    let followed = scene.gradient_shading().filter(|_| scene.reflection().is_some() || scene.transfer.has_rows());
    if followed.as_ref().is_some_and(interpolated) { (0.4 * voxel) as f32 } else { f32::INFINITY }
}

impl StepMap {
    /// Cells along the edge of a block.
    pub(crate) const EDGE: usize = LevelRanges::EDGE;

    /// Makes the map of a scene for an error of the picture to aim at. `voxel` is the world length of the smallest voxel edge; `integrated` are the sharp changes
    /// of the transfer function where steps integrate all values of a parabola between their ends, and need not be short for thin peaks.
    pub(crate) fn new(
        levels: &LevelRanges,
        (scene, integrated): (&Scene, Option<SharpValues>),
        calibration: Calibration,
        voxel: f64,
        error: f64,
    ) -> Self {
        let variations = LevelVariations::new(scene, integrated, |level| calibration.value(levels.stored(level as u8)));
        let by_range = Classes::new(&variations, levels.ranges(), voxel, error);
        let blocks = levels.blocks();
        let mut bytes: Vec<u8> = collect(levels.ranges().len(), |i| by_range.of(levels.ranges()[i]));
        let mut distances: Vec<u8> = bytes.iter().map(|&b| if b == CLEAR { u8::MAX } else { 0 }).collect();
        chessboard_distances(blocks, &mut distances);
        bytes.iter_mut().for_each(|b| *b = (*b).min(CLASSES as u8 - 1));
        if levels.has_holes() {
            // No step from afar may pass a hole, and what is next to one is cut.
            let of_block = class_of(Self::EDGE as f64);
            let holes = bytes.iter_mut().enumerate().filter(|(i, _)| levels.has_hole(*i));
            holes.for_each(|(_, b)| *b = (*b).min(of_block));
        }
        let cuts = match scene.volume.filter() {
            Some(Filter::Nearest) => {
                let length = length_in_voxels(scene, voxel);
                Cuts::Voxels { cells: levels.has_holes() || length < f32::INFINITY, length }
            }
            _ if levels.has_holes() => Cuts::Holes(beside_holes(levels)),
            _ => Cuts::None,
        };
        // Colours of the voxels change whatever the medium does.
        let longest = if scene.volume.colors().is_some() { LONGEST_BESIDE_COLORS } else { LONGEST };
        let steps = std::array::from_fn(|c| (voxel * step_of(c).min(longest)) as f32);
        let mut map = Self { blocks, bytes, steps, cuts };
        map.look_around();
        map.leap(&distances);
        map
    }

    /// Returns the numbers of blocks along x, y, z.
    pub(crate) fn blocks(&self) -> [usize; 3] {
        self.blocks
    }

    /// Returns the bytes, x fastest: below [`CLEAR`] the index of the step to take in [`StepMap::steps`]; from it on, the number of blocks around that are
    /// clear, too, plus [`CLEAR`].
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the world lengths of the steps.
    pub(crate) fn steps(&self) -> &[f32; CLASSES] {
        &self.steps
    }

    /// Returns the visible blocks, of twice the edge, of a volume with the given voxels along x, y, z.
    pub(crate) fn visible(&self, dims: [usize; 3]) -> VisibleBlocks {
        VisibleBlocks::of_halves(dims, Self::EDGE, &self.bytes, CLEAR)
    }

    /// Returns the faces at which steps end.
    pub(crate) fn cuts(&self) -> &Cuts {
        &self.cuts
    }

    /// Returns the movement of a ray in a block.
    pub(crate) fn at(&self, [x, y, z]: [usize; 3]) -> BlockStep {
        let block = (z * self.blocks[1] + y) * self.blocks[0] + x;
        match (self.bytes[block], &self.cuts) {
            (leap @ CLEAR.., _) => BlockStep::Leap(leap - CLEAR),
            (_, Cuts::Voxels { length, .. }) => BlockStep::CutStep(*length),
            (class, Cuts::Holes(cut)) if cut[block] => BlockStep::CutStep(self.steps[usize::from(class)]),
            (class, _) => BlockStep::Step(self.steps[usize::from(class)]),
        }
    }

    /// Returns the positions, between two voxels, of the faces at which steps are cut.
    pub(crate) fn faces(&self) -> &'static [f64] {
        match self.cuts {
            Cuts::None | Cuts::Holes(_) => &[0.0],
            Cuts::Voxels { cells: false, .. } => &[0.5],
            Cuts::Voxels { cells: true, .. } => &[0.0, 0.5],
        }
    }

    /// Shortens steps to those that the blocks ahead allow: those one block away for steps of up to a block, and so on.
    fn look_around(&mut self) {
        let own = self.bytes.clone();
        let near = least_around(&own, self.blocks, 1);
        self.bytes.copy_from_slice(&near);
        let of_block = class_of(Self::EDGE as f64);
        self.bytes.iter_mut().for_each(|b| *b = (*b).min(of_block));
        let mut around = near;
        for radius in [2, 4] {
            cancel::poll();
            // Of a radius of 1, 2, 4: what the last one found, spread by as much again.
            around = least_around(&around, self.blocks, radius / 2);
            let longest = class_of((radius * Self::EDGE) as f64);
            for (b, &class) in self.bytes.iter_mut().zip(&around) {
                *b = (*b).max(class.min(longest));
            }
        }
    }

    /// Writes into clear blocks the number of clear blocks around, from the distances to the others.
    fn leap(&mut self, distances: &[u8]) {
        for (byte, &distance) in self.bytes.iter_mut().zip(distances) {
            if distance > 0 {
                *byte = CLEAR + (distance - 1).min(u8::MAX - CLEAR);
            }
        }
    }
}

/// Marks the blocks that have holes, or a neighbour that has.
fn beside_holes(levels: &LevelRanges) -> Vec<bool> {
    let open: Vec<u8> = (0..levels.ranges().len()).map(|i| u8::from(!levels.has_hole(i))).collect();
    least_around(&open, levels.blocks(), 1).into_iter().map(|open| open == 0).collect()
}

/// Returns, for each block, the smallest byte of it and the blocks up to `radius` around it.
fn least_around(bytes: &[u8], [nx, ny, nz]: [usize; 3], radius: usize) -> Vec<u8> {
    let slice = nx * ny;
    // Axis by axis: the least of a cube is the least of the least of its rows.
    let mut along_x = bytes.to_vec();
    each_part(along_x.chunks_mut(slice).zip(bytes.chunks(slice)), |_, (out, rows)| {
        for (out, row) in out.chunks_mut(nx).zip(rows.chunks(nx)) {
            for d in 1..=radius.min(nx - 1) {
                for (o, &b) in out.iter_mut().zip(&row[d..]) {
                    *o = b.min(*o);
                }
                for (o, &b) in out[d..].iter_mut().zip(row) {
                    *o = b.min(*o);
                }
            }
        }
    });
    let spread = |from: &[u8], length: usize, stride: usize, position: usize, out: &mut [u8]| {
        for other in position.saturating_sub(radius)..=(position + radius).min(length - 1) {
            if other != position {
                let from = &from[other * stride..][..out.len()];
                out.iter_mut().zip(from).for_each(|(o, &b)| *o = b.min(*o));
            }
        }
    };
    let mut along_y = along_x.clone();
    each_part(along_y.chunks_mut(slice).zip(along_x.chunks(slice)), |_, (out, from)| {
        for (y, row) in out.chunks_mut(nx).enumerate() {
            spread(from, ny, nx, y, row);
        }
    });
    let mut along_z = along_y.clone();
    each_part(along_z.chunks_mut(slice), |z, out| spread(&along_y, nz, slice, z, out));
    along_z
}

#[cfg(test)]
mod tests {
    use super::classes::RATE;
    use super::*;
    use vr_core::{ControlPoint, OpacityRule, Placement, TransferFunction, UniformGrid, Volume};

    fn map(dims: [usize; 3], error: f64, f: impl Fn(usize, usize, usize) -> u8) -> StepMap {
        let at = |i: usize| f(i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1]));
        let samples: Vec<u8> = (0..dims.iter().product()).map(at).collect();
        let grid = UniformGrid::new(dims, samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
        let volume: Volume = grid.unwrap().into();
        let points = vec![ControlPoint::new(100.0, [1.0; 3], 0.0), ControlPoint::new(200.0, [1.0; 3], 0.5)];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let levels = LevelRanges::of_volume(volume.grid().unwrap());
        StepMap::new(&levels, (&Scene::new(volume, transfer), None), Calibration::default(), 1.0, error)
    }

    #[test]
    fn clear_blocks_know_how_far_all_is_clear() {
        // Visible in one block of nine, at the low end.
        let map = map([37, 5, 5], 1e-3, |x, _, _| if x == 2 { 255 } else { 0 });
        let block_steps: Vec<BlockStep> = (0..9).map(|x| map.at([x, 0, 0])).collect();
        assert!(matches!(block_steps[0], BlockStep::Step(_)));
        for (x, block_step) in block_steps.iter().enumerate().skip(1) {
            assert_eq!(*block_step, BlockStep::Leap(x as u8 - 1));
        }
    }

    #[test]
    fn steps_are_short_near_changes_and_long_far_from_them() {
        // A wall of change at x = 80 in a medium that is visible everywhere.
        let map = map([161, 5, 5], 1e-3, |x, _, _| if x < 80 { 150 } else { 180 });
        let step = |x: usize| match map.at([x, 0, 0]) {
            BlockStep::Step(h) => f64::from(h),
            leap => panic!("{leap:?} at {x}"),
        };
        assert_eq!((step(0) as f32, step(39) as f32), (LONGEST as f32, LONGEST as f32));
        for x in 0..40 {
            // The change lies in block 19, between the samples 79 and 80: no step from another block reaches past it.
            let to_change = if x < 19 { (19 - x) as f64 * 4.0 } else { (x - 19) as f64 * 4.0 };
            assert!(step(x) <= to_change.max(step(19)) + 1e-6, "{x}: {}", step(x));
        }
        // h = e·√(ε/D), down to a class.
        let change = -((1.0f64 - 0.4).ln() - (1.0f64 - 0.25).ln());
        let exact = 4.0 * (RATE * 1e-3 / change).sqrt();
        assert!(step(19) <= exact && step(19) * 2f64.sqrt() > exact, "{} {exact}", step(19));
    }

    #[test]
    fn smaller_errors_take_shorter_steps_down_to_the_shortest() {
        let at = |error: f64| match map([5, 5, 5], error, |x, _, _| 50 * x as u8).at([0, 0, 0]) {
            BlockStep::Step(h) => f64::from(h),
            leap => panic!("{leap:?}"),
        };
        assert!(at(1e-2) > at(1e-3) && at(1e-3) > at(1e-4));
        assert_eq!(at(1e-9) as f32, SHORTEST as f32);
    }

    #[test]
    fn steps_end_at_the_faces_of_holes() {
        let samples: Vec<f32> = (0..37 * 5 * 5).map(|i| if i % 37 == 18 { f32::NAN } else { 150.0 }).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([37, 5, 5], samples, placement, Calibration::default());
        let volume: Volume = grid.unwrap().into();
        let points = vec![ControlPoint::new(100.0, [1.0; 3], 0.0), ControlPoint::new(200.0, [1.0; 3], 0.5)];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let scene = Scene::new(volume, transfer);
        let map = |filter| {
            let scene = scene.with_filter(filter);
            let levels = LevelRanges::of_volume(scene.volume.grid().unwrap());
            StepMap::new(&levels, (&scene, None), Calibration::default(), 1.0, 1e-3)
        };
        // The missing sheet lies in the middle of block 4.
        for x in 0..9usize {
            let block_step = map(Filter::Trilinear).at([x, 0, 0]);
            assert_eq!(
                matches!(block_step, BlockStep::CutStep(h) if h <= 4.0),
                x.abs_diff(4) <= 1,
                "{x}: {block_step:?}"
            );
            let far = x.abs_diff(4) as f32 * 4.0;
            assert!(matches!(block_step, BlockStep::Step(h) if h <= far) || x.abs_diff(4) <= 1, "{x}: {block_step:?}");
            assert_eq!(map(Filter::Nearest).at([x, 0, 0]), BlockStep::CutStep(f32::INFINITY));
        }
        assert_eq!((map(Filter::Trilinear).faces(), map(Filter::Nearest).faces()), (&[0.0][..], &[0.0, 0.5][..]));
    }

    #[test]
    fn nothing_visible_is_far_everywhere() {
        let map = map([37, 5, 5], 1e-3, |_, _, _| 0);
        assert!(map.bytes().iter().all(|&b| b == u8::MAX));
    }

    #[test]
    fn least_around_is_the_least_of_the_cube() {
        let n = [5, 4, 3];
        let bytes: Vec<u8> = (0..60u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        for radius in 1..3 {
            let fast = least_around(&bytes, n, radius);
            for (i, &found) in fast.iter().enumerate() {
                let at = [i % n[0], i / n[0] % n[1], i / (n[0] * n[1])];
                let near = |a: usize| at[a].saturating_sub(radius)..=(at[a] + radius).min(n[a] - 1);
                let cube =
                    near(2).flat_map(|z| near(1).flat_map(move |y| near(0).map(move |x| (z * n[1] + y) * n[0] + x)));
                assert_eq!(found, cube.map(|j| bytes[j]).min().unwrap());
            }
        }
    }
}
