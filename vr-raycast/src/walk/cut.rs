//! Steps of one length that end where the field jumps.

use vr_core::IndexRay;
use vr_core::cancel::SparsePoll;

use super::{Lattice, ListedWalk};

/// Part of a step that is taken by itself behind a jump: a surface begins there, and its normal is that of the point at which it is met.
pub(crate) const SKIN: f64 = 1e-3;

/// Fraction of a step below which a part of one is rounding, and falls to its neighbour.
pub(crate) const SLIVER: f64 = 1e-9;

/// Begins a walk along a ray in steps of one length, each of which ends early where the field jumps. `jumps` are distances along the ray, ascending.
pub(crate) fn cut_walk(ray: &IndexRay, step: f64, jumps: &[f64], backwards: bool) -> ListedWalk {
    let lattice = Lattice::new(ray.start, ray.end, step);
    let mut steps = Vec::with_capacity(lattice.count as usize + jumps.len());
    cut_steps(&lattice, jumps, &mut steps);
    ListedWalk::new(steps, None, 0, backwards)
}

/// Appends the steps of a lattice, each of which ends early at a jump, so that a sample stands for its own side of it alone; behind a jump comes a very short
/// one.
pub(crate) fn cut_steps(lattice: &Lattice, jumps: &[f64], steps: &mut Vec<(f64, f64)>) {
    let (sliver, skin) = (SLIVER * lattice.length, SKIN * lattice.length);
    let mut left = jumps.iter().copied().peekable();
    let mut from = lattice.start;
    let mut poll = SparsePoll::default();
    for k in 0..lattice.count {
        poll.turn();
        let end = lattice.begin(k) + lattice.length_of(k);
        while let Some(jump) = left.next_if(|&jump| jump < end - sliver) {
            if jump > from + sliver {
                steps.push((from, jump - from));
                from = jump;
            } else if jump < from - sliver {
                // In the short step behind the jump before.
                continue;
            }
            let next = left.peek().map_or(end, |&next| next.min(end));
            if next > from + 2.0 * skin {
                steps.push((from, skin));
                from += skin;
            }
        }
        // Steps between jumps keep the length that their neighbours have, to the last bit.
        let length = if from == lattice.begin(k) { lattice.length_of(k) } else { end - from };
        steps.push((from, length));
        from = end;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::run::Steps;

    #[test]
    fn steps_end_at_jumps_and_cover_the_ray() {
        let ray = IndexRay { origin: DVec3::ZERO, direction: DVec3::X, start: 1.0, end: 5.25, offset: 0.0 };
        let listed = |jumps: &[f64]| {
            let (mut walk, mut steps) = (cut_walk(&ray, 1.0, jumps, false), Steps::new());
            assert!(walk.next(&mut steps));
            let all: Vec<_> = (0..steps.len).map(|k| (steps.begin[k], steps.length[k])).collect();
            all
        };
        let whole = [(1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (4.0, 1.0), (5.0, 0.25)];
        assert_eq!(listed(&[]), whole);
        let cut = listed(&[1.5, 4.25, 4.75, 5.125]);
        let wanted = [1.0, 1.5, 1.501, 2.0, 3.0, 4.0, 4.25, 4.251, 4.75, 4.751, 5.0, 5.125, 5.126, 5.25];
        assert_eq!(cut.len(), wanted.len() - 1);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(cut.iter().zip(wanted.windows(2)).all(|(s, w)| near(s.0, w[0]) && near(s.1, w[1] - w[0])), "{cut:?}");
        // Where steps meet anyway, and jumps that are one up to rounding.
        let met: Vec<f64> = listed(&[3.0, 3.0 + 1e-12]).iter().map(|s| s.0).collect();
        assert_eq!(met.len(), 6);
        assert!(near(met[2], 3.0) && near(met[3], 3.001), "{met:?}");
    }
}
