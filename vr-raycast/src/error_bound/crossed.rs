//! Cell that a ray crosses.

use vr_core::IndexRay;

/// Cell that a ray crosses.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossed {
    /// Its first sample.
    pub(super) cell: [usize; 3],
    /// Fractions of the cell, per axis, at which the ray enters and leaves.
    pub(super) part: [[f64; 2]; 3],
    /// Upper bound of what they are off by.
    pub(super) misplaced: f64,
    /// True if the ray may lie in a face, as far as rounding can tell.
    pub(super) in_face: bool,
    /// Faces (lower and upper, per axis) that it may even lie beyond: not where it runs along them, so that its coordinate is exact.
    pub(super) beyond: [[bool; 2]; 3],
}

impl Crossed {
    /// Returns the cell that a ray crosses between two distances.
    pub(super) fn new(ray: &IndexRay, cell: [usize; 3], [from, to]: [f64; 2], misplaced: f64) -> Self {
        let ends = [ray.at(from).to_array(), ray.at(to).to_array()];
        // A sliver, which rounding leaves where faces meet, lies in none of them: the ray goes on.
        let is_sliver = (0..3).all(|axis| (ends[1][axis] - ends[0][axis]).abs() <= 4.0 * misplaced);
        let (mut in_face, mut beyond) = (false, [[false; 2]; 3]);
        let part = std::array::from_fn(|axis| {
            let at = ends.map(|end| end[axis] - cell[axis] as f64);
            let faces = [at.iter().all(|&t| t <= misplaced), at.iter().all(|&t| t >= 1.0 - misplaced)];
            if !is_sliver && faces != [false; 2] {
                in_face = true;
                beyond[axis] = faces.map(|face| face && ray.direction[axis] != 0.0);
            }
            at.map(|t| t.clamp(0.0, 1.0))
        });
        Self { cell, part, misplaced, in_face, beyond }
    }

    /// True if something holds of a sample of the cells that the ray may lie in beyond this one's faces, in a lattice of the given size.
    pub(super) fn any_beyond(&self, dims: [usize; 3], holds: impl Fn([usize; 3]) -> bool) -> bool {
        let samples = |a: usize| {
            let [low, high] = self.beyond[a].map(usize::from);
            self.cell[a].saturating_sub(low)..=(self.cell[a] + 1 + high).min(dims[a] - 1)
        };
        let any = || samples(2).any(|z| samples(1).any(|y| samples(0).any(|x| holds([x, y, z]))));
        self.beyond != [[false; 2]; 3] && any()
    }
}
