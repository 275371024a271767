//! Classes of steps by the range of values of a block: the longest step that the medium allows.

use vr_core::transfer::Optical;
use vr_core::{Calibration, Scene, TransferFunction};
use vr_kernels::ranges::LevelRanges;

use super::features::Features;
use super::{CLASSES, CLEAR, LONGEST, SHORTEST, StepMap};

/// Error per unit length that is allowed for an error of 1 in the picture: calibrated on ten scenes, opaque and translucent, so that their
/// RMSE is the error asked for or less.
pub(super) const RATE: f64 = 5.0;
/// Change of optical depth, per voxel, beyond which light is saturated and its error grows no more.
const SATURATION: f64 = 0.64;

/// Returns the length of the steps of a class, in voxels.
pub(super) fn step_of(class: usize) -> f64 {
    SHORTEST * libm::exp2(0.5 * class as f64)
}

/// Returns the class of the longest step that is no longer than so many voxels.
pub(super) fn class_of(voxels: f64) -> u8 {
    let class = libm::floor(2.0 * libm::log2(voxels / SHORTEST) + 1e-9);
    class.clamp(0.0, CLASSES as f64 - 1.0) as u8
}

/// Class of a block by its range of levels, for all ranges that there are.
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

impl Classes {
    pub(super) fn new(levels: &LevelRanges, scene: &Scene, calibration: Calibration, voxel: f64, error: f64) -> Self {
        // What one row shows and another does not comes and goes with the gradient, as shaded light does.
        let rows: Vec<&TransferFunction> = match scene.transfer.rows() {
            [] => vec![&scene.transfer],
            rows => rows.iter().map(|row| &row.transfer).collect(),
        };
        let shaded = scene.shading.is_some() || scene.transfer.has_rows();
        const N: usize = LevelRanges::LAST as usize + 1;
        let value = |level: usize| calibration.value(levels.stored(level as u8));
        let of_rows = |variation: &dyn Fn(&TransferFunction) -> Variation| {
            let all = rows.iter().map(|row| variation(row));
            all.reduce(|a, b| a.or(&b)).expect("a transfer function has a row at least")
        };
        let at = |value: f64| of_rows(&|row| Variation::of(std::iter::once(optics(row, &row.at(value)))));
        // From a level to the next, both included, with the points between them: all of a jump counts.
        let between: Vec<Variation> = (0..N - 1)
            .map(|level| {
                let (a, b) = (value(level), value(level + 1));
                let (a, b) = (a.min(b), a.max(b));
                of_rows(&|row| {
                    let at = |value: f64| optics(row, &row.at(value));
                    let points = row.points().iter().filter(|p| p.value >= a && p.value <= b);
                    let points = points.map(|p| optics(row, &Optical::at_point(p)));
                    Variation::of(std::iter::once(at(a.next_down())).chain(points).chain([at(b)]))
                })
            })
            .collect();
        let points = |row: &&TransferFunction| {
            let points = row.points().iter().map(|p| (p.value, optics(row, &Optical::at_point(p))));
            points.collect::<Vec<_>>()
        };
        let features = Features::new(&rows.iter().map(points).collect::<Vec<_>>());
        let class = |variation: &Variation, low: usize, high: usize| {
            if variation.greatest == [0.0; 4] {
                return CLEAR;
            }
            let change = (variation.largest(shaded) * voxel).min(SATURATION);
            let voxels = if change > 0.0 { StepMap::EDGE as f64 * libm::sqrt(RATE * error / change) } else { LONGEST };
            let (a, b) = (value(low), value(high));
            class_of(features.longest_step([a.min(b), a.max(b)], voxels, voxel, error))
        };
        // An empty range (all vacuum) is clear.
        let mut table = vec![CLEAR; N * N];
        for low in 0..N {
            let mut variation = at(value(low));
            table[low * N + low] = class(&variation, low, low);
            for high in low + 1..N {
                variation = variation.then(&between[high - 1]);
                table[low * N + high] = class(&variation, low, high);
            }
        }
        Self { table }
    }

    pub(super) fn of(&self, [low, high]: [u8; 2]) -> u8 {
        self.table[usize::from(low) * (usize::from(LevelRanges::LAST) + 1) + usize::from(high)]
    }
}

/// Returns κ, and q of red, green and blue.
fn optics(transfer: &TransferFunction, at: &Optical) -> [f64; 4] {
    let kappa = transfer.extinction(at.opacity);
    // κ·c with κ = ∞ and c = 0 would be NaN: an opaque wall that shines nowhere.
    let q = |c: usize| match () {
        () if transfer.has_emission() => at.emission[c],
        () if at.color[c] == 0.0 => 0.0,
        () => kappa * at.color[c],
    };
    [kappa, q(0), q(1), q(2)]
}
