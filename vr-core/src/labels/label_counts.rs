//! Labels that occur on a lattice, counted.

use std::collections::BTreeMap;

use super::error::LabelError;
use crate::any_grid::AnyGrid;
use crate::grid::UniformGrid;
use crate::parallel::try_collect;
use crate::voxel::Voxel;
use crate::with_grid;

/// Largest number of different labels: ranks are kept in 16 bits.
const MAX_LABELS: usize = 1 << 16;

/// Voxels that a thread takes at once: some milliseconds of work.
pub(super) const PART: usize = 1 << 20;

/// Labels of a lattice, with the number of voxels of each: all of a [`LabelMap`](super::LabelMap) but its voxels, in next to no memory.
///
/// # Examples
/// ```
/// use vr_core::labels::LabelCounts;
/// use vr_core::{Calibration, Placement, UniformGrid};
///
/// let placement = Placement::from_spacing([1.0, 1.0, 2.0])?;
/// let grid = UniformGrid::new([2; 3], vec![0u8, 7, 0, 7, 0, 3, 0, 0], placement, Calibration::default())?;
/// let counts = LabelCounts::new(&grid.into()).expect("whole numbers");
/// assert_eq!(counts.labels(), [0, 3, 7]);
/// assert_eq!((counts.count(7), counts.voxel_volume()), (2, 2.0));
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LabelCounts {
    /// The labels, ascending; 0 is one of them, whether or not a voxel has it.
    labels: Vec<i32>,
    /// Number of voxels of each.
    counts: Vec<usize>,
    voxel_volume: f64,
}

impl LabelCounts {
    /// Takes the calibrated values of a grid for labels, and counts them. A voxel without a finite value is background.
    ///
    /// # Errors
    /// [`LabelError::Value`] for a value that is no whole number, [`LabelError::TooMany`] for more than 65536 labels.
    pub fn new(grid: &AnyGrid) -> Result<Self, LabelError> {
        with_grid!(grid, g => Self::of(g.samples().len(), g.placement().axes().determinant().abs(), label_of(g)))
    }

    /// Counts the labels of so many voxels of a volume each.
    pub(super) fn of(
        count: usize,
        voxel_volume: f64,
        label: impl Fn(usize) -> Result<i32, LabelError> + Sync,
    ) -> Result<Self, LabelError> {
        let parts = try_collect(count.div_ceil(PART), |part| {
            Counter::default().with_all((part * PART..count.min((part + 1) * PART)).map(&label))
        })?;
        let mut all = BTreeMap::from([(0, 0)]);
        for (label, voxels) in parts.into_iter().flatten() {
            *all.entry(label).or_default() += voxels;
            if all.len() > MAX_LABELS {
                return Err(LabelError::TooMany { limit: MAX_LABELS });
            }
        }
        let (labels, counts) = all.into_iter().unzip();
        Ok(Self { labels, counts, voxel_volume })
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
        self.voxel_volume
    }
}

/// Returns a function that tells the label of a voxel by its number.
pub(super) fn label_of<T: Voxel>(grid: &UniformGrid<T>) -> impl Fn(usize) -> Result<i32, LabelError> + Sync {
    let (dims, calibration, samples) = (grid.dims(), grid.calibration(), grid.samples());
    move |i| {
        let stored = samples[i];
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
    }
}

/// Counter of labels: the usual ones in a table, for noise is not to take a search each.
struct Counter {
    usual: Vec<usize>,
    others: BTreeMap<i32, usize>,
}

impl Default for Counter {
    fn default() -> Self {
        /// Labels of a byte, of most atlases, and of a table that stays in the first-level cache.
        const USUAL: usize = 1 << 11;
        Self { usual: vec![0; USUAL], others: BTreeMap::new() }
    }
}

impl Counter {
    /// Counts labels; returns each that occurs with the number of its voxels.
    fn with_all(
        mut self,
        labels: impl Iterator<Item = Result<i32, LabelError>>,
    ) -> Result<Vec<(i32, usize)>, LabelError> {
        // Neighbours mostly have the same one.
        let (mut last, mut run) = (0, 0);
        for label in labels {
            let label = label?;
            if label != last {
                self.add(last, run)?;
                (last, run) = (label, 0);
            }
            run += 1;
        }
        self.add(last, run)?;
        let usual = (0..).zip(self.usual).filter(|&(_, voxels)| voxels > 0);
        Ok(usual.chain(self.others).collect())
    }

    fn add(&mut self, label: i32, voxels: usize) -> Result<(), LabelError> {
        match usize::try_from(label).ok().and_then(|label| self.usual.get_mut(label)) {
            Some(count) => *count += voxels,
            None => {
                *self.others.entry(label).or_default() += voxels;
                if self.others.len() > MAX_LABELS {
                    return Err(LabelError::TooMany { limit: MAX_LABELS });
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Calibration;
    use crate::placement::Placement;

    #[test]
    fn labels_of_every_size_are_counted_across_parts() {
        // Two parts and a bit, of noise and of runs; some labels are beyond the table, some below it.
        let label = |i: usize| if i < PART { (i * 7919 % 257) as i32 } else { (i / 1000) as i32 * 37 - 40_000 };
        let dims = [256, 256, 40];
        let count = dims.iter().product();
        let samples: Vec<f32> = (0..count).map(|i| label(i) as f32).collect();
        let placement = Placement::from_spacing([1.0, 2.0, 0.5]).unwrap();
        let grid: AnyGrid = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into();
        let found = LabelCounts::new(&grid).unwrap();
        let mut expected = BTreeMap::from([(0, 0)]);
        (0..count).for_each(|i| *expected.entry(label(i)).or_default() += 1);
        assert_eq!(found.labels(), expected.keys().copied().collect::<Vec<_>>());
        assert!(expected.iter().all(|(&label, &voxels)| found.count(label) == voxels));
        assert_eq!((found.count(-1_000_000), found.voxel_volume()), (0, 1.0));
    }

    #[test]
    fn more_labels_than_there_are_ranks_are_refused() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let counts = |count: usize| {
            let samples: Vec<f32> = (0..count).map(|i| i as f32).collect();
            LabelCounts::new(
                &UniformGrid::new([count / 4, 2, 2], samples, placement, Calibration::default()).unwrap().into(),
            )
        };
        assert_eq!(counts(MAX_LABELS).unwrap().labels().len(), MAX_LABELS);
        assert_eq!(counts(MAX_LABELS + 4), Err(LabelError::TooMany { limit: MAX_LABELS }));
    }
}
