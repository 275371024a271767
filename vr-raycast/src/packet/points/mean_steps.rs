//! Steps of a ray through a mean of scattered points, which begins and ends with a jump wherever vacuum does.

use fearless_simd::Level;
use vr_core::{Placement, Ray};
use vr_kernels::vector;

use super::cells::PointCells;
use super::covered::CoveredParts;
use crate::packet::listed::{RaySteps, StepList};
use crate::walk::{Lattice, cut_steps};

/// Steps of one length, each of which ends early where vacuum begins or ends: those of the plain engine's `cut_walk`, but for those in vacuum.
#[derive(Clone, Copy)]
pub(super) struct MeanSteps<'a> {
    pub(super) cells: &'a PointCells,
    /// Placement of the field's lattice.
    pub(super) placement: &'a Placement,
    pub(super) level: Level,
    /// World length of a step.
    pub(super) step: f64,
}

impl RaySteps for MeanSteps<'_> {
    fn list(&self, ray: &Ray, ends @ [from, to]: [f64; 2], list: &mut StepList) {
        let search = CoveredParts { cells: self.cells, placement: self.placement, ray, ends };
        let parts = vector::run(self.level, search);
        let is_inner = |s: &f64| *s > from && *s < to;
        let jumps: Vec<f64> = parts.as_flattened().iter().copied().filter(is_inner).map(|s| s - from).collect();
        cut_steps(&Lattice::new(0.0, to - from, self.step), &jumps, &mut list.steps);
        let mut part = 0;
        list.steps.retain(|&(begin, length)| {
            let middle = from + begin + 0.5 * length;
            while parts.get(part).is_some_and(|part| part[1] <= middle) {
                part += 1;
            }
            parts.get(part).is_some_and(|part| part[0] <= middle)
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::{PointKernel, PointMixing, PointSet, Volume};

    use super::*;
    use crate::packet::points::engine::listed_cells;
    use crate::source::Source;

    /// Two balls of radius 1, 3 apart, and a third that overlaps the second.
    #[test]
    fn steps_cover_the_supports_and_no_vacuum() {
        let positions = vec![DVec3::ZERO, 3.0 * DVec3::X, 4.5 * DVec3::X];
        let points = PointSet::new(positions, vec![1.0; 3], vec![1.0; 3], vec![0.5; 3], PointKernel::Cone).unwrap();
        let points = points.with_mixing(PointMixing::Mean).unwrap();
        let volume = Volume::from(points.clone());
        let source = Source::of(&volume).unwrap();
        let cells = listed_cells(&points, source.placement(), source.dims()).unwrap();
        let ray = Ray { origin: DVec3::new(-5.0, 0.0, 0.0), direction: DVec3::X };
        for (part, want) in [
            ([0.0, 20.0], vec![[4.0, 6.0], [7.0, 10.5]]),
            ([4.5, 9.0], vec![[4.5, 6.0], [7.0, 9.0]]),
            ([6.2, 6.8], vec![]),
            ([5.0, 5.5], vec![[5.0, 5.5]]),
        ] {
            let mut list = StepList::EMPTY;
            MeanSteps { cells: &cells, placement: source.placement(), level: Level::new(), step: 0.3 }
                .list(&ray, part, &mut list);
            let mut covered: Vec<[f64; 2]> = Vec::new();
            for (begin, length) in list.steps {
                let (begin, end) = (part[0] + begin, part[0] + begin + length);
                assert!(length <= 0.3 + 1e-12);
                match covered.last_mut().filter(|last| (last[1] - begin).abs() < 1e-12) {
                    Some(last) => last[1] = end,
                    None => covered.push([begin, end]),
                }
            }
            assert_eq!(covered.len(), want.len(), "{covered:?}");
            for (found, want) in covered.iter().zip(&want) {
                // Edges are as exact as places in f32.
                assert!((0..2).all(|i| (found[i] - want[i]).abs() < 1e-6), "{covered:?} for {want:?}");
            }
        }
    }
}
