//! Steps of a ray through a mean of scattered points, which begins and ends with a jump wherever vacuum does.

use vr_core::{Field, PointSet, Ray};

use crate::packet::listed::RaySteps;
use crate::walk::{Lattice, cut_steps};

/// Steps of one length, each of which ends early where vacuum begins or ends: those of the plain engine's `cut_walk`, but for those in vacuum.
#[derive(Clone, Copy)]
pub(super) struct MeanSteps<'a> {
    pub(super) points: &'a PointSet,
    /// World length of a step.
    pub(super) step: f64,
}

impl RaySteps for MeanSteps<'_> {
    fn list(&self, ray: &Ray, [from, to]: [f64; 2], steps: &mut Vec<(f64, f64)>) {
        let mut jumps = Vec::new();
        self.points.jumps(ray, [from, to], &mut jumps);
        jumps.iter_mut().for_each(|s| *s -= from);
        cut_steps(&Lattice::new(0.0, to - from, self.step), &jumps, steps);

        // The parts between jumps are vacuum by turns: the longest one tells which.
        let mut ends = vec![0.0];
        ends.extend(jumps);
        ends.push(to - from);
        let longest = (0..ends.len() - 1).max_by(|&a, &b| (ends[a + 1] - ends[a]).total_cmp(&(ends[b + 1] - ends[b])));
        let Some(longest) = longest else { return };
        let middle = from + 0.5 * (ends[longest] + ends[longest + 1]);
        let is_field = self.points.value(ray.origin + ray.direction * middle).is_some();
        let mut part = 0;
        steps.retain(|&(begin, length)| {
            while part + 2 < ends.len() && begin + 0.5 * length >= ends[part + 1] {
                part += 1;
            }
            (part.abs_diff(longest) % 2 == 0) == is_field
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::{PointKernel, PointMixing};

    use super::*;

    /// Two balls of radius 1, 3 apart, and a third that overlaps the second.
    #[test]
    fn steps_cover_the_supports_and_no_vacuum() {
        let positions = vec![DVec3::ZERO, 3.0 * DVec3::X, 4.5 * DVec3::X];
        let points = PointSet::new(positions, vec![1.0; 3], vec![1.0; 3], vec![0.5; 3], PointKernel::Cone).unwrap();
        let points = points.with_mixing(PointMixing::Mean).unwrap();
        let ray = Ray { origin: DVec3::new(-5.0, 0.0, 0.0), direction: DVec3::X };
        for (part, want) in [
            ([0.0, 20.0], vec![[4.0, 6.0], [7.0, 10.5]]),
            ([4.5, 9.0], vec![[4.5, 6.0], [7.0, 9.0]]),
            ([6.2, 6.8], vec![]),
            ([5.0, 5.5], vec![[5.0, 5.5]]),
        ] {
            let mut steps = Vec::new();
            MeanSteps { points: &points, step: 0.3 }.list(&ray, part, &mut steps);
            let mut covered: Vec<[f64; 2]> = Vec::new();
            for (begin, length) in steps {
                let (begin, end) = (part[0] + begin, part[0] + begin + length);
                assert!(length <= 0.3 + 1e-12);
                match covered.last_mut().filter(|last| (last[1] - begin).abs() < 1e-12) {
                    Some(last) => last[1] = end,
                    None => covered.push([begin, end]),
                }
            }
            assert_eq!(covered.len(), want.len(), "{covered:?}");
            for (found, want) in covered.iter().zip(&want) {
                assert!((0..2).all(|i| (found[i] - want[i]).abs() < 1e-12), "{covered:?} for {want:?}");
            }
        }
    }
}
