//! Labels on a lattice.

use std::iter::repeat_n;
use std::sync::Arc;

use glam::DVec3;

use super::error::LabelError;
use super::label_counts::{LabelCounts, PART, label_of};
use crate::any_grid::AnyGrid;
use crate::grid::UniformGrid;
use crate::memory;
use crate::parallel::each_part;
use crate::placement::Placement;
use crate::voxel::Voxel;
use crate::with_grid;

/// Labels at the voxels of a lattice: whole numbers, of which 0 is the background. Cloning is cheap: the voxels are shared.
///
/// The label of a place is that of the nearest voxel; a voxel reaches half a step to each side, and beyond the last ones is background. A
/// voxel without a finite value is background, too.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::labels::LabelMap;
/// use vr_core::{Calibration, Placement, UniformGrid};
///
/// let placement = Placement::from_spacing([1.0, 1.0, 2.0])?;
/// let grid = UniformGrid::new([2; 3], vec![0u8, 7, 0, 7, 0, 3, 0, 0], placement, Calibration::default())?;
/// let map = LabelMap::new(&grid.into()).expect("whole numbers");
/// assert_eq!(map.labels(), [0, 3, 7]);
/// assert_eq!((map.count(7), map.voxel_volume()), (2, 2.0));
/// assert_eq!(map.label_at(DVec3::new(0.8, 0.2, 0.9)), 7);
/// assert_eq!(map.label_at(DVec3::new(9.0, 0.0, 0.0)), 0, "outside");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LabelMap {
    dims: [usize; 3],
    placement: Placement,
    counts: LabelCounts,
    /// Rank of the background.
    background: u16,
    /// Rank of each voxel's label.
    ranks: Arc<[u16]>,
}

impl LabelMap {
    /// Takes the calibrated values of a grid for labels.
    ///
    /// # Errors
    /// [`LabelError::Value`] for a value that is no whole number, [`LabelError::TooMany`] for more than 65536 labels.
    pub fn new(grid: &AnyGrid) -> Result<Self, LabelError> {
        with_grid!(grid, g => Self::of(g))
    }

    fn of<T: Voxel>(grid: &UniformGrid<T>) -> Result<Self, LabelError> {
        Self::of_labels(grid.dims(), *grid.placement(), label_of(grid))
    }

    /// The map of the labels of voxels, each of which is asked for twice.
    fn of_labels(
        dims: [usize; 3],
        placement: Placement,
        label: impl Fn(usize) -> Result<i32, LabelError> + Sync,
    ) -> Result<Self, LabelError> {
        let count: usize = dims.iter().product();
        let counts = LabelCounts::of(count, placement.axes().determinant().abs(), &label)?;
        // Rank the voxels where they stay.
        memory::check("the ranks of labels", (count * size_of::<u16>()) as u64)?;
        let background = rank_among(counts.labels(), 0);
        let mut ranks: Arc<[u16]> = repeat_n(background, count).collect();
        let places = Arc::get_mut(&mut ranks).expect("it has one owner so far");
        each_part(places.chunks_mut(PART), |part, ranks| {
            // Neighbours mostly have the same one.
            let mut last = (0, background);
            for (i, rank) in ranks.iter_mut().enumerate() {
                // Each has had its label a moment ago.
                let label = label(part * PART + i).unwrap_or_default();
                if label != last.0 {
                    last = (label, rank_among(counts.labels(), label));
                }
                *rank = last.1;
            }
        });
        Ok(Self { dims, placement, counts, background, ranks })
    }

    /// The labels that `label` makes of those of this map and of another one on a lattice of the same size, voxel by voxel.
    ///
    /// # Errors
    /// [`LabelError::TooMany`] for more than 65536 labels.
    ///
    /// # Panics
    /// Panics if the lattices have different sizes.
    pub fn combined(&self, other: &Self, label: impl Fn(i32, i32) -> i32 + Sync) -> Result<Self, LabelError> {
        assert_eq!(self.dims, other.dims, "two maps of one lattice");
        let own = |map: &Self, i: usize| map.labels()[usize::from(map.ranks[i])];
        Self::of_labels(self.dims, self.placement, |i| Ok(label(own(self, i), own(other, i))))
    }

    /// Voxels along x, y and z.
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Placement of the lattice in the world.
    pub fn placement(&self) -> &Placement {
        &self.placement
    }

    /// The labels, with the number of voxels of each.
    pub fn counts(&self) -> &LabelCounts {
        &self.counts
    }

    /// The labels, ascending; 0, the background, is always one of them.
    pub fn labels(&self) -> &[i32] {
        self.counts.labels()
    }

    /// Number of voxels that have a label.
    pub fn count(&self, label: i32) -> usize {
        self.counts.count(label)
    }

    /// World volume of a voxel.
    pub fn voxel_volume(&self) -> f64 {
        self.counts.voxel_volume()
    }

    /// Label of a world position.
    pub fn label_at(&self, at: DVec3) -> i32 {
        self.labels()[usize::from(self.rank_near(self.placement.to_index(at)))]
    }

    /// Lower and upper corner of the world box around all voxels.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let corners = corners(&self.placement, self.dims, 0.5);
        corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &c| (l.min(c), h.max(c)))
    }

    /// Rank of the background.
    pub(super) fn background(&self) -> u16 {
        self.background
    }

    /// Rank of the label of the voxel nearest to a position in index space; the background's outside.
    #[inline]
    pub(super) fn rank_near(&self, index: DVec3) -> u16 {
        let nearest = (index + 0.5).floor();
        let [nx, ny, nz] = self.dims;
        let end = DVec3::new(nx as f64, ny as f64, nz as f64);
        // False for NaN, too.
        if !(nearest.cmpge(DVec3::ZERO).all() && nearest.cmplt(end).all()) {
            return self.background;
        }
        self.rank([nearest.x as usize, nearest.y as usize, nearest.z as usize])
    }

    /// Rank of the label of a voxel.
    #[inline]
    pub(super) fn rank(&self, [x, y, z]: [usize; 3]) -> u16 {
        self.rank_of((z * self.dims[1] + y) * self.dims[0] + x)
    }

    /// Ranks of 4³ voxels from one on, x fastest.
    #[inline]
    pub(super) fn ranks_around(&self, [x, y, z]: [usize; 3]) -> [u16; 64] {
        let (row, layer) = (self.dims[0], self.dims[0] * self.dims[1]);
        let first = z * layer + y * row + x;
        let mut ranks = [0; 64];
        for (i, four) in ranks.chunks_exact_mut(4).enumerate() {
            four.copy_from_slice(&self.ranks[first + i % 4 * row + i / 4 * layer..][..4]);
        }
        ranks
    }

    /// Rank of the label of the voxel of a number, x fastest.
    #[inline]
    pub(super) fn rank_of(&self, number: usize) -> u16 {
        self.ranks[number]
    }
}

/// Corners of the box of a lattice in the world, `margin` steps beyond the outermost voxels.
pub(super) fn corners(placement: &Placement, dims: [usize; 3], margin: f64) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let at = |a: usize| if corner >> a & 1 == 1 { dims[a] as f64 - 1.0 + margin } else { -margin };
        placement.to_world(DVec3::new(at(0), at(1), at(2)))
    })
}

fn rank_among(labels: &[i32], label: i32) -> u16 {
    let rank = labels.partition_point(|&l| l < label);
    u16::try_from(rank).expect("there are 65536 labels at most")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Calibration;

    fn map<T: Voxel>(voxels: Vec<T>, calibration: Calibration) -> Result<LabelMap, LabelError>
    where
        AnyGrid: From<UniformGrid<T>>,
    {
        let grid = UniformGrid::new([2, 2, 2], voxels, Placement::from_spacing([1.0; 3]).unwrap(), calibration);
        LabelMap::new(&AnyGrid::from(grid.unwrap()))
    }

    #[test]
    fn values_become_labels_and_missing_ones_background() {
        let calibration = Calibration { slope: 2.0, intercept: -4.0 };
        let labels = map(vec![0i16, 1, 2, 2, 2, 2, 2, 900], calibration).unwrap();
        assert_eq!(labels.labels(), [-4, -2, 0, 1796]);
        assert_eq!([-4, -2, 0, 1796, 5].map(|l| labels.count(l)), [1, 1, 5, 1, 0]);
        let labels = map(vec![f32::NAN, 3.0, f32::INFINITY, 3.0, 3.0, 3.0, 3.0, 16e6], Calibration::default()).unwrap();
        assert_eq!(labels.labels(), [0, 3, 16_000_000]);
        assert_eq!(labels.count(0), 2);
    }

    #[test]
    fn what_is_no_label_is_refused() {
        let fraction = Calibration { slope: 0.5, intercept: 0.0 };
        let error = map(vec![0u8, 2, 4, 5, 0, 0, 0, 0], fraction).unwrap_err();
        assert_eq!(error, LabelError::Value { index: [1, 1, 0], found: 2.5 });
        assert!(map(vec![1e10f32; 8], Calibration::default()).is_err());
    }

    #[test]
    fn a_place_has_the_label_of_the_nearest_voxel() {
        let labels = map(vec![1u8, 2, 3, 4, 5, 6, 7, 8], Calibration::default()).unwrap();
        let at = |x: f64, y: f64, z: f64| labels.label_at(DVec3::new(x, y, z));
        assert_eq!([at(0.4, 0.4, 0.4), at(0.6, 0.4, 0.4), at(0.4, 0.6, 1.49)], [1, 2, 7]);
        assert_eq!(
            [at(-0.49, 0.0, 0.0), at(-0.51, 0.0, 0.0), at(0.0, 0.0, 1.51), at(f64::NAN, 0.0, 0.0)],
            [1, 0, 0, 0]
        );
    }
}
