//! Walk from cell to cell: a three-dimensional DDA (Amanatides and Woo 1987, *A fast voxel traversal algorithm for ray tracing*).

use vr_core::IndexRay;
use vr_core::cancel::SparsePoll;

use super::ListedWalk;

/// Cells that a ray passes through, as the distances at which it enters and leaves each.
///
/// The distance of a cell face is computed from the face's index, not added up as in the paper: it has one rounding, however long the
/// ray. Together the parts cover the chord, each beginning where the one before ends. What is shorter than [`SLIVER`] of the chord (a
/// ray through an edge or a corner meets two or three faces at once, up to rounding) is no cell, and falls to the next one.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    axes: [Axis; 3],
    at: f64,
    end: f64,
    sliver: f64,
}

/// Faces along one axis.
#[derive(Clone, Copy, Debug)]
struct Axis {
    origin: f64,
    direction: f64,
    /// Next face, and the distance to it; +∞ where there is none inside.
    face: f64,
    distance: f64,
    /// The last face inside the volume.
    last: f64,
}

/// Fraction of a ray's chord below which a part is rounding.
const SLIVER: f64 = 1e-12;

impl Axis {
    fn new(origin: f64, direction: f64, start: f64, samples: usize) -> Self {
        let mut axis = Self { origin, direction, face: 0.0, distance: f64::INFINITY, last: 0.0 };
        if direction != 0.0 {
            let inside = (samples - 1) as f64;
            let x = (origin + direction * start).clamp(0.0, inside);
            // Faces of the box itself are the ends of the chord.
            (axis.face, axis.last) =
                if direction > 0.0 { (x.floor() + 1.0, inside - 1.0) } else { (x.ceil() - 1.0, 1.0) };
            axis.find();
            while axis.distance <= start {
                axis.advance();
            }
        }
        axis
    }

    fn advance(&mut self) {
        self.face += 1f64.copysign(self.direction);
        self.find();
    }

    fn find(&mut self) {
        let beyond = if self.direction > 0.0 { self.face > self.last } else { self.face < self.last };
        self.distance = if beyond { f64::INFINITY } else { (self.face - self.origin) / self.direction };
    }
}

impl Cells {
    /// Begins at the first cell of a grid of `dims` voxels.
    pub(crate) fn new(ray: &IndexRay, dims: [usize; 3]) -> Self {
        let axes = std::array::from_fn(|a| Axis::new(ray.origin[a], ray.direction[a], ray.start, dims[a]));
        Self { axes, at: ray.start, end: ray.end, sliver: SLIVER * (ray.end - ray.start) }
    }
}

impl Iterator for Cells {
    /// Distances at which the ray enters and leaves a cell.
    type Item = (f64, f64);

    fn next(&mut self) -> Option<(f64, f64)> {
        if self.at >= self.end {
            return None;
        }
        let from = self.at;
        loop {
            let next = self.axes.iter().map(|a| a.distance).fold(f64::INFINITY, f64::min);
            if next >= self.end - self.sliver {
                self.at = self.end;
                return Some((from, self.end));
            }
            for axis in &mut self.axes {
                if axis.distance <= next {
                    axis.advance();
                }
            }
            if next - from > self.sliver {
                self.at = next;
                return Some((from, next));
            }
        }
    }
}

/// Returns begin and length of the steps from cell to cell, each cut into equal steps no longer than `longest`.
pub(crate) fn cell_steps(ray: &IndexRay, dims: [usize; 3], longest: f64) -> Vec<(f64, f64)> {
    let mut steps = Vec::new();
    let mut poll = SparsePoll::default();
    for (from, to) in Cells::new(ray, dims) {
        // A cell that is as long as the step, up to rounding, is one step.
        let parts = ((to - from) / longest * (1.0 - SLIVER)).ceil().max(1.0);
        let length = (to - from) / parts;
        let begin = |k: f64| if k == parts { to } else { from + k * length };
        let mut k = 0.0;
        while k < parts {
            poll.turn();
            steps.push((begin(k), begin(k + 1.0) - begin(k)));
            k += 1.0;
        }
    }
    steps
}

/// Returns the walk over the steps from cell to cell.
pub(crate) fn cell_walk(ray: &IndexRay, dims: [usize; 3], longest: f64, first: u32, backwards: bool) -> ListedWalk {
    ListedWalk::new(cell_steps(ray, dims, longest), None, first, backwards)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::Steps;
    use glam::DVec3;
    use proptest::prelude::*;
    use vr_core::{Clip, Placement, Ray};

    fn chord(origin: DVec3, direction: DVec3, dims: [usize; 3]) -> Option<IndexRay> {
        let ray = Ray { origin, direction: direction.normalize() };
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        IndexRay::new(&ray, &placement, dims, &Clip::default(), f64::INFINITY)
    }

    /// Asserts that the cells are in order, without gaps, of positive length, each within one cell; returns their number.
    fn check(ray: &IndexRay, dims: [usize; 3]) -> usize {
        let cells: Vec<(f64, f64)> = Cells::new(ray, dims).collect();
        assert_eq!(cells[0].0, ray.start);
        assert_eq!(cells[cells.len() - 1].1, ray.end);
        assert!(cells.windows(2).all(|w| w[0].1 == w[1].0), "{cells:?}");
        for &(from, to) in &cells {
            assert!(to - from > 0.5 * SLIVER * ray.length(), "{cells:?}");
            // No face lies well inside: both ends are in the closed cell of the middle.
            let (middle, ends) = (ray.at(0.5 * (from + to)), [ray.at(from), ray.at(to)]);
            for a in 0..3 {
                // A ray in a face has its middle there, up to rounding, and belongs to either cell.
                if (middle[a] - middle[a].round()).abs() > 1e-9 {
                    let out = ends.map(|p| (p[a] - middle[a].floor() - 0.5).abs() - 0.5);
                    assert!(out[0].max(out[1]) < 1e-9, "{middle} {ends:?}");
                }
            }
        }
        cells.len()
    }

    #[test]
    fn axis_parallel_diagonal_and_in_faces() {
        let dims = [5, 4, 6];
        let along_x = |y: f64, z: f64| chord(DVec3::new(-3.0, y, z), DVec3::X, dims).unwrap();
        assert_eq!(check(&along_x(0.3, 2.7), dims), 4);
        assert_eq!(check(&along_x(1.0, 2.0), dims), 4, "along an edge");
        assert_eq!(check(&along_x(0.0, 5.0), dims), 4, "along an edge of the box");
        let back = chord(DVec3::new(0.5, 1.5, 9.0), DVec3::NEG_Z, dims).unwrap();
        assert_eq!(check(&back, dims), 5);
        let cube = [5; 3];
        let diagonal = chord(DVec3::splat(-1.0), DVec3::ONE, cube).unwrap();
        assert_eq!(check(&diagonal, cube), 4, "through corners only");
        let in_face = chord(DVec3::new(-1.0, -1.0, 2.0), DVec3::new(1.0, 1.0, 0.0), cube).unwrap();
        assert_eq!(check(&in_face, cube), 4);
        assert_eq!(check(&chord(DVec3::splat(-1.0), DVec3::ONE, [2; 3]).unwrap(), [2; 3]), 1);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn cells_cover_the_chord_in_order(
            dims in prop::array::uniform3(2usize..9),
            from in prop::array::uniform3(-2i32..44),
            to in prop::array::uniform3(-2i32..44),
            scale in prop::sample::select(vec![1.0, 4.0, 5.0]),
        ) {
            // Many of these go through edges and corners, and along axes.
            let [a, b] = [from, to].map(|p| DVec3::from_array(p.map(f64::from)) / scale);
            if a != b && let Some(ray) = chord(a, b - a, dims) {
                let cells = check(&ray, dims);
                let crossed: f64 = (ray.at(ray.end).floor() - ray.at(ray.start).floor()).abs().element_sum();
                prop_assert!(cells as f64 <= crossed + 2.0);
            }
        }

        #[test]
        fn steps_are_no_longer_than_asked(longest in 0.01..3.0f64, x in 0.0..4.0f64, y in 0.0..4.0f64) {
            let dims = [5, 5, 7];
            let ray = chord(DVec3::new(x, y, -1.0), DVec3::new(0.3, -0.2, 1.0), dims);
            if let Some(ray) = ray {
                let (mut walk, mut steps) = (cell_walk(&ray, dims, longest, 0, false), Steps::new());
                let mut all = Vec::new();
                while walk.next(&mut steps) {
                    all.extend((0..steps.len).map(|j| (steps.begin[j], steps.length[j])));
                }
                prop_assert_eq!(all[0].0, ray.start);
                // Begin and length add up to the next begin, but for their rounding.
                for pair in all.windows(2) {
                    prop_assert!((pair[0].0 + pair[0].1 - pair[1].0).abs() < 1e-14);
                }
                let last = all[all.len() - 1];
                prop_assert!((last.0 + last.1 - ray.end).abs() < 1e-14);
                prop_assert!(all.iter().all(|s| s.1 > 0.0 && s.1 <= longest * (1.0 + 1e-9)));
            }
        }
    }
}
