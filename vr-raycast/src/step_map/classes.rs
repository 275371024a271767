//! Classes of steps by the range of values of a block: the longest step that the medium allows.

use vr_core::transfer::Optical;
use vr_core::{Scene, TransferFunction};
use vr_kernels::ranges::LevelRanges;

use crate::caster::Step;

use super::features::Features;
use super::sharp::SharpValues;
use super::{CLASSES, CLEAR, LONGEST, SHORTEST, StepMap};

/// Error per unit length that is allowed for an error of 1 in the picture: calibrated on ten scenes, opaque and translucent, so that their
/// RMSE is the error asked for or less.
pub(super) const RATE: f64 = 7.5;
/// Change of optical depth, per voxel, beyond which light is saturated and its error grows no more.
const SATURATION: f64 = 0.64;

/// Length in voxels of the longest step through a sharp change along which the value is taken for a parabola, for an error of [`Step::ERROR`]: the field's
/// kinks at the faces of cells, which no parabola has, move the place of the change by the square of the step. Measured on shells and on a CT head with a jump
/// (`docs/notes/vr-raycast.md`).
const LONGEST_PARABOLA: f64 = 0.25;

/// Returns the length of the steps of a class, in voxels.
pub(super) fn step_of(class: usize) -> f64 {
    SHORTEST * libm::exp2(0.5 * class as f64)
}

/// Returns the class of the longest step that is no longer than so many voxels.
pub(super) fn class_of(voxels: f64) -> u8 {
    let class = libm::floor(2.0 * libm::log2(voxels / SHORTEST) + 1e-9);
    class.clamp(0.0, CLASSES as f64 - 1.0) as u8
}

/// Class of a block by its range of levels, for the ranges that occur in a volume.
pub(super) struct Classes {
    /// Table of 256 × 256 classes: lower level, upper level.
    table: Vec<u8>,
}

/// Variation of κ and the three q over a range of values (the sum of all rises and falls), and the largest value of each.
#[derive(Clone, Copy)]
struct Variation {
    total: [f64; 4],
    greatest: [f64; 4],
}

impl Variation {
    /// Sums the variation of values in order.
    fn of(path: impl Iterator<Item = [f64; 4]>) -> Self {
        let mut all = Self { total: [0.0; 4], greatest: [0.0; 4] };
        let mut last: Option<[f64; 4]> = None;
        for here in path {
            all.greatest = std::array::from_fn(|c| all.greatest[c].max(here[c]));
            if let Some(last) = last {
                for c in 0..4 {
                    // ∞ − ∞ is no change.
                    all.total[c] += if here[c] == last[c] { 0.0 } else { (here[c] - last[c]).abs() };
                }
            }
            last = Some(here);
        }
        all
    }

    /// Combines the variations of two rows: the larger of each.
    fn or(self, other: &Self) -> Self {
        Self {
            total: std::array::from_fn(|c| self.total[c].max(other.total[c])),
            greatest: std::array::from_fn(|c| self.greatest[c].max(other.greatest[c])),
        }
    }

    fn then(self, next: &Self) -> Self {
        Self {
            total: std::array::from_fn(|c| self.total[c] + next.total[c]),
            greatest: std::array::from_fn(|c| self.greatest[c].max(next.greatest[c])),
        }
    }

    /// Returns the variation of the most varying one. Where light is `shaded`, it can go from all to nothing on a few voxels, whatever the values do.
    fn largest(&self, shaded: bool) -> f64 {
        let of = |c: usize| self.total[c] + if shaded { self.greatest[c] } else { 0.0 };
        (0..4).map(of).fold(0.0, f64::max)
    }
}

/// Number of levels that ranges of values are rounded to.
pub(super) const LEVELS: usize = LevelRanges::LAST as usize + 1;

/// Variation of a transfer function at levels of values and between them.
pub(super) struct LevelVariations {
    values: Vec<f64>,
    /// Variation at each level, and from each to the next.
    at: Vec<Variation>,
    between: Vec<Variation>,
    features: Features,
    /// Sharp changes, where steps integrate all values between their ends, whatever the transfer function does there.
    integrated: Option<SharpValues>,
    shaded: bool,
}

impl LevelVariations {
    /// Looks at a scene's transfer function between levels of these values; at the sharp changes in it where steps integrate all values between their ends.
    pub(super) fn new(scene: &Scene, integrated: Option<SharpValues>, value: impl Fn(usize) -> f64) -> Self {
        // What one row shows and another does not comes and goes with the gradient, as shaded light does.
        let rows: Vec<&TransferFunction> = match scene.transfer.rows() {
            [] => vec![&scene.transfer],
            rows => rows.iter().map(|row| &row.transfer).collect(),
        };
        let shaded = scene.shading.is_some() || scene.transfer.has_rows();
        let values: Vec<f64> = (0..LEVELS).map(value).collect();
        let of_rows = |variation: &dyn Fn(&TransferFunction) -> Variation| {
            let all = rows.iter().map(|row| variation(row));
            all.reduce(|a, b| a.or(&b)).expect("a transfer function has a row at least")
        };
        let at = |value: f64| of_rows(&|row| Variation::of(std::iter::once(optics(row, &row.at(value)))));
        // From a level to the next, both included, with the points between them: all of a jump counts.
        let between = |pair: &[f64]| {
            let (a, b) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
            of_rows(&|row| {
                let at = |value: f64| optics(row, &row.at(value));
                let points = row.points().iter().filter(|p| p.value >= a && p.value <= b);
                let points = points.map(|p| optics(row, &Optical::at_point(p)));
                Variation::of(std::iter::once(at(a.next_down())).chain(points).chain([at(b)]))
            })
        };
        let points = |row: &&TransferFunction| {
            let points = row.points().iter().map(|p| (p.value, optics(row, &Optical::at_point(p))));
            points.collect::<Vec<_>>()
        };
        let features = Features::new(&rows.iter().map(points).collect::<Vec<_>>());
        let at = values.iter().map(|&value| at(value)).collect();
        Self { between: values.windows(2).map(between).collect(), at, values, features, integrated, shaded }
    }

    /// Calls `each` with every wanted range of levels, lower and upper, and the largest variation of extinction and emission over it; `None` where there is
    /// neither.
    pub(super) fn each_range(
        &self,
        is_wanted: impl Fn(usize, usize) -> bool,
        mut each: impl FnMut(usize, usize, Option<f64>),
    ) {
        for low in 0..LEVELS {
            let mut variation = self.at[low];
            for high in low..LEVELS {
                if high > low {
                    variation = variation.then(&self.between[high - 1]);
                }
                if is_wanted(low, high) {
                    let is_visible = variation.greatest != [0.0; 4];
                    each(low, high, is_visible.then(|| variation.largest(self.shaded)));
                }
            }
        }
    }

    /// Returns the length, in voxels, of the longest step in a block of `edge` voxels over whose range of levels the medium varies by so much per world
    /// unit; `voxel` is the world length of a voxel.
    pub(super) fn longest_step(
        &self,
        variation: f64,
        [low, high]: [usize; 2],
        (voxel, edge): (f64, f64),
        error: f64,
    ) -> f64 {
        // Blocks of 4³ are what the rate is calibrated on; in others the medium varies as much more as they are larger.
        let change = (variation * voxel * (StepMap::EDGE as f64 / edge)).min(SATURATION);
        let voxels = if change > 0.0 { StepMap::EDGE as f64 * libm::sqrt(RATE * error / change) } else { LONGEST };
        let (a, b) = (self.values[low], self.values[high]);
        if let Some(sharp) = &self.integrated {
            let is_sharp = sharp.lie_within([a.min(b), a.max(b)]);
            return if is_sharp { voxels.min(LONGEST_PARABOLA * libm::sqrt(error / Step::ERROR)) } else { voxels };
        }
        // In a larger block the field may cross its range in a part of it.
        let crossed = edge.min(StepMap::EDGE as f64);
        self.features.longest_step([a.min(b), a.max(b)], voxels, (voxel, crossed), error)
    }
}

impl Classes {
    /// Makes the classes of the blocks of a volume, which have these ranges.
    pub(super) fn new(variations: &LevelVariations, ranges: &[[u8; 2]], voxel: f64, error: f64) -> Self {
        // Few of the 32,896 possible ranges occur, and a transfer function may be edited many times a second: the others are left out.
        let mut occurs = vec![false; LEVELS * LEVELS];
        ranges.iter().for_each(|&range| occurs[place_of(range)] = true);
        // An empty range (all vacuum) is clear.
        let mut table = vec![CLEAR; LEVELS * LEVELS];
        let is_wanted = |low, high| occurs[low * LEVELS + high];
        variations.each_range(is_wanted, |low, high, variation| {
            let block = (voxel, StepMap::EDGE as f64);
            let step = |variation| class_of(variations.longest_step(variation, [low, high], block, error));
            table[low * LEVELS + high] = variation.map_or(CLEAR, step);
        });
        Self { table }
    }

    pub(super) fn of(&self, range: [u8; 2]) -> u8 {
        self.table[place_of(range)]
    }
}

/// Place of a range in a table of all of them.
fn place_of([low, high]: [u8; 2]) -> usize {
    usize::from(low) * LEVELS + usize::from(high)
}

/// Returns κ, and q of red, green and blue.
pub(super) fn optics(transfer: &TransferFunction, at: &Optical) -> [f64; 4] {
    let kappa = transfer.extinction(at.opacity);
    // κ·c with κ = ∞ and c = 0 would be NaN: an opaque wall that shines nowhere.
    let q = |c: usize| match () {
        () if transfer.has_emission() => at.emission[c],
        () if at.color[c] == 0.0 => 0.0,
        () => kappa * at.color[c],
    };
    [kappa, q(0), q(1), q(2)]
}
