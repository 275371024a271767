//! Values at which a transfer function changes within a small part of the range that a volume has.

use vr_core::transfer::Optical;
use vr_core::{Scene, TransferFunction};

use super::classes::optics;

/// Ranges of calibrated values over which a medium changes so fast that single samples miss it: jumps, steep ramps and the flanks of thin peaks.
#[derive(Clone, Debug, Default)]
pub(crate) struct SharpValues(Vec<[f64; 2]>);

/// Part of the volume's range of values below which a change is sharp: a field that goes through all of its range on a few voxels passes it within a
/// part of a step.
const WIDEST: f64 = 1.0 / 64.0;
/// Change of optical depth, over the length of a voxel, from which on it shows.
const VISIBLE: f64 = 0.02;

impl SharpValues {
    /// Finds the sharp changes between the values that the scene's volume has; `voxel` is the world length of its smallest voxel edge.
    pub(crate) fn of(scene: &Scene, (low, high): (f64, f64), voxel: f64) -> Self {
        let transfer: &TransferFunction = &scene.transfer;
        let points: Vec<(f64, [f64; 4])> =
            transfer.points().iter().map(|p| (p.value, optics(transfer, &Optical::at_point(p)))).collect();
        let is_sharp = |pair: &&[(f64, [f64; 4])]| {
            let [(from, before), (to, after)] = [pair[0], pair[1]];
            // Inside a wall, ∞ − ∞, nothing changes.
            let change = (0..4).map(|c| if after[c] == before[c] { 0.0 } else { (after[c] - before[c]).abs() });
            let change = change.fold(0.0, f64::max) * voxel;
            change >= VISIBLE && to - from <= WIDEST * (high - low) && to >= low && from <= high
        };
        Self(points.windows(2).filter(is_sharp).map(|pair| [pair[0].0, pair[1].0]).collect())
    }

    /// True if nothing changes fast.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// True if a field between two values passes through a sharp change.
    pub(crate) fn lie_within(&self, [low, high]: [f64; 2]) -> bool {
        self.0.iter().any(|&[from, to]| to >= low && from <= high)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use vr_core::field::FunctionField;
    use vr_core::{ControlPoint, OpacityRule, Volume};

    use super::*;

    fn sharp(points: &[(f64, f64)]) -> Vec<[f64; 2]> {
        let field = FunctionField::new((DVec3::ZERO, DVec3::ONE), |p| p.x).unwrap();
        let points = points.iter().map(|&(value, opacity)| ControlPoint::new(value, [1.0; 3], opacity)).collect();
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        SharpValues::of(&Scene::new(Volume::Field(Arc::new(field)), transfer), (0.0, 256.0), 1.0).0
    }

    #[test]
    fn jumps_and_thin_peaks_are_sharp_and_ramps_are_not() {
        assert!(sharp(&[(20.0, 0.0), (80.0, 0.9)]).is_empty());
        assert_eq!(sharp(&[(20.0, 0.0), (20.0, 0.9)]), [[20.0; 2]]);
        assert_eq!(sharp(&[(20.0, 0.0), (22.0, 0.5), (24.0, 0.0)]), [[20.0, 22.0], [22.0, 24.0]]);
        assert!(sharp(&[(20.0, 0.0), (20.0, 0.01)]).is_empty(), "hardly visible");
        assert!(sharp(&[(300.0, 0.0), (300.0, 0.9)]).is_empty(), "beyond the volume's values");
        assert_eq!(sharp(&[(20.0, 0.0), (20.0, 1.0), (90.0, 1.0)]), [[20.0; 2]], "a wall, from its face on");
    }

    #[test]
    fn a_range_passes_what_it_meets() {
        let sharp = SharpValues(vec![[20.0, 22.0]]);
        assert!(sharp.lie_within([10.0, 20.0]) && sharp.lie_within([21.0, 21.0]) && sharp.lie_within([22.0, 90.0]));
        assert!(!sharp.lie_within([10.0, 19.0]) && !sharp.lie_within([23.0, 90.0]) && !sharp.is_empty());
    }
}
