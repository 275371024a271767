//! Labels on a lattice.

use std::collections::{BTreeMap, BTreeSet};
use std::iter::repeat_n;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use super::error::LabelError;
use crate::any_grid::AnyGrid;
use crate::grid::UniformGrid;
use crate::memory;
use crate::parallel::{each_part, locked, try_collect};
use crate::placement::Placement;
use crate::voxel::Voxel;
use crate::with_grid;

/// Largest number of different labels: ranks are kept in 16 bits.
const MAX_LABELS: usize = 1 << 16;

/// Voxels that a thread takes at once: some milliseconds of work.
const PART: usize = 1 << 20;

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
    /// The labels, ascending; 0 is one of them, whether or not a voxel has it.
    labels: Vec<i32>,
    /// Number of voxels of each.
    counts: Vec<usize>,
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
        let (dims, calibration) = (grid.dims(), grid.calibration());
        let label = |i: usize, stored: T| -> Result<i32, LabelError> {
            if stored.is_missing() {
                return Ok(0);
            }
            let found = calibration.value(f64::from(stored.to_f32()));
            // `as` saturates, and what is beyond does not come back.
            let label = found as i32;
            if f64::from(label) == found {
                return Ok(label);
            }
            let index = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
            Err(LabelError::Value { index, found })
        };
        let samples = grid.samples();
        Self::of_labels(dims, *grid.placement(), |i| label(i, samples[i]))
    }

    /// The map of the labels of voxels, each of which is asked for twice.
    fn of_labels(
        dims: [usize; 3],
        placement: Placement,
        label: impl Fn(usize) -> Result<i32, LabelError> + Sync,
    ) -> Result<Self, LabelError> {
        let count: usize = dims.iter().product();
        let too_many = LabelError::TooMany { limit: MAX_LABELS };
        // List the labels of each part; neighbours mostly have the same one.
        let seen = try_collect(count.div_ceil(PART), |part| {
            let mut seen = BTreeSet::from([0]);
            let mut last = 0;
            for i in part * PART..count.min((part + 1) * PART) {
                let label = label(i)?;
                if label != last && seen.insert(label) && seen.len() > MAX_LABELS {
                    return Err(too_many.clone());
                }
                last = label;
            }
            Ok(seen)
        })?;
        let mut all = BTreeSet::from([0]);
        for seen in seen {
            all.extend(seen);
            if all.len() > MAX_LABELS {
                return Err(too_many);
            }
        }
        let labels: Vec<i32> = all.into_iter().collect();
        // Rank the voxels where they stay, and count them.
        memory::check("the ranks of labels", (count * size_of::<u16>()) as u64)?;
        let background = rank_of(&labels, 0);
        let mut ranks: Arc<[u16]> = repeat_n(background, count).collect();
        let counts = Mutex::new(vec![0; labels.len()]);
        let places = Arc::get_mut(&mut ranks).expect("it has one owner so far");
        each_part(places.chunks_mut(PART), |part, ranks| {
            let mut counted = BTreeMap::<u16, usize>::new();
            let (mut last, mut run) = ((0, background), 0);
            for (i, rank) in ranks.iter_mut().enumerate() {
                // Each has had its label a moment ago.
                let label = label(part * PART + i).unwrap_or_default();
                if label != last.0 {
                    *counted.entry(last.1).or_default() += run;
                    (last, run) = ((label, rank_of(&labels, label)), 0);
                }
                *rank = last.1;
                run += 1;
            }
            *counted.entry(last.1).or_default() += run;
            let mut counts = locked(&counts);
            counted.iter().for_each(|(&rank, n)| counts[usize::from(rank)] += n);
        });
        let counts = counts.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(Self { dims, placement, labels, counts, background, ranks })
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
        let own = |map: &Self, i: usize| map.labels[usize::from(map.ranks[i])];
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

    /// The labels, ascending; 0, the background, is always one of them.
    pub fn labels(&self) -> &[i32] {
        &self.labels
    }

    /// Number of voxels that have a label.
    pub fn count(&self, label: i32) -> usize {
        self.labels.binary_search(&label).map_or(0, |rank| self.counts[rank])
    }

    /// World volume of a voxel.
    pub fn voxel_volume(&self) -> f64 {
        self.placement.axes().determinant().abs()
    }

    /// Label of a world position.
    pub fn label_at(&self, at: DVec3) -> i32 {
        self.labels[usize::from(self.rank_near(self.placement.to_index(at)))]
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
        self.ranks[(z * self.dims[1] + y) * self.dims[0] + x]
    }
}

/// Corners of the box of a lattice in the world, `margin` steps beyond the outermost voxels.
pub(super) fn corners(placement: &Placement, dims: [usize; 3], margin: f64) -> [DVec3; 8] {
    std::array::from_fn(|corner| {
        let at = |a: usize| if corner >> a & 1 == 1 { dims[a] as f64 - 1.0 + margin } else { -margin };
        placement.to_world(DVec3::new(at(0), at(1), at(2)))
    })
}

fn rank_of(labels: &[i32], label: i32) -> u16 {
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
