//! The volume in bricks: textures with a layer of samples in common, kept within a budget, and the order in which they are seen.

use std::collections::VecDeque;

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::{Placement, Projection, RenderError, View, Voxel};

use crate::textures::hold;

/// The bricks of a volume: of so many cells along an edge, fewer at the upper faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrickLattice {
    pub(crate) edge: usize,
    /// Cells of the volume along each axis.
    cells: [usize; 3],
}

/// The cells of a brick along each axis: from the first to behind the last.
pub(crate) type Cells = [[usize; 2]; 3];

impl BrickLattice {
    pub(crate) fn new(dims: [usize; 3], edge: usize) -> Self {
        Self { edge, cells: dims.map(|n| n - 1) }
    }

    /// Bricks along each axis.
    pub(crate) fn count(&self) -> [usize; 3] {
        self.cells.map(|n| n.div_ceil(self.edge))
    }

    pub(crate) fn cells_of(&self, brick: [usize; 3]) -> Cells {
        std::array::from_fn(|a| [brick[a] * self.edge, ((brick[a] + 1) * self.edge).min(self.cells[a])])
    }

    /// Every brick, in an order in which none hides one before it.
    ///
    /// Along a ray a brick's number grows, or falls, away from the eye, on each axis. So does the sum over the axes of how far its number is from that of the
    /// brick in which the eye is (which may lie beyond the volume), or, where rays are parallel, its numbers along the view.
    pub(crate) fn front_to_back(&self, view: &View, placement: &Placement) -> Result<Vec<[usize; 3]>, RenderError> {
        let count = self.count();
        let eye = placement.inverse_axes() * (view.camera.eye - placement.origin()) / self.edge as f64;
        let ahead = placement.inverse_axes() * view.camera.frame()?.z_axis;
        let depth = |brick: [usize; 3]| -> f64 {
            let along = |a: usize| match view.camera.projection {
                Projection::Perspective { .. } => (brick[a] as f64 - eye[a].floor()).abs(),
                Projection::Orthographic { .. } if ahead[a] < 0.0 => -(brick[a] as f64),
                Projection::Orthographic { .. } => brick[a] as f64,
            };
            (0..3).map(along).sum()
        };
        let numbers =
            (0..count[2]).flat_map(|z| (0..count[1]).flat_map(move |y| (0..count[0]).map(move |x| [x, y, z])));
        let mut all: Vec<[usize; 3]> = numbers.collect();
        all.sort_by(|a, b| depth(*a).total_cmp(&depth(*b)));
        Ok(all)
    }

    /// The corners of a brick in the world.
    pub(crate) fn corners(&self, brick: [usize; 3], placement: &Placement) -> [DVec3; 8] {
        let cells = self.cells_of(brick);
        let [low, high] = [0, 1].map(|end| DVec3::from_array(cells.map(|c| c[end] as f64)));
        crate::geometry::box_corners(placement, low, high)
    }
}

/// Textures of bricks, the least recently used of which go where there is no room for another.
pub(crate) struct Pool<T> {
    resident: VecDeque<([usize; 3], Vec<T>)>,
    bytes: u64,
    limit: u64,
    /// Largest number of bytes held so far, and number of textures filled.
    pub(crate) peak: u64,
    pub(crate) uploads: u64,
}

impl<T: Voxel> Pool<T> {
    pub(crate) fn new(limit: u64) -> Self {
        Self { resident: VecDeque::new(), bytes: 0, limit, peak: 0, uploads: 0 }
    }

    /// The texture of a brick: one sample more than cells along each axis.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`] if the budget does not hold a single brick.
    pub(crate) fn texture(
        &mut self,
        brick: [usize; 3],
        cells: &Cells,
        volume: &Lattice<'_, T>,
    ) -> Result<Lattice<'_, T>, RenderError> {
        let dims = cells.map(|[first, end]| end - first + 1);
        let found = self.resident.iter().position(|(of, _)| *of == brick);
        let samples = match found.and_then(|at| self.resident.remove(at)) {
            Some((_, samples)) => samples,
            None => {
                let bytes = (dims.iter().product::<usize>() * size_of::<T>()) as u64;
                hold("a brick", bytes, self.limit)?;
                while self.bytes + bytes > self.limit {
                    let Some((_, oldest)) = self.resident.pop_front() else { break };
                    self.bytes -= size_of_val(&oldest[..]) as u64;
                }
                self.bytes += bytes;
                self.peak = self.peak.max(self.bytes);
                self.uploads += 1;
                filled(cells, dims, volume)
            }
        };
        self.resident.push_back((brick, samples));
        let (_, samples) = &self.resident[self.resident.len() - 1];
        Ok(Lattice { samples, dims })
    }
}

/// A brick's samples.
fn filled<T: Voxel>(cells: &Cells, dims: [usize; 3], volume: &Lattice<'_, T>) -> Vec<T> {
    let mut samples = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            let from = volume.offset(cells[0][0], cells[1][0] + y, cells[2][0] + z);
            samples.extend_from_slice(&volume.samples[from..from + dims[0]]);
        }
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bricks_share_a_layer_and_stay_within_the_budget() {
        let samples: Vec<u16> = (0..9 * 7 * 6).map(|i| i as u16).collect();
        let volume = Lattice { samples: &samples, dims: [9, 7, 6] };
        let lattice = BrickLattice::new(volume.dims, 4);
        assert_eq!(lattice.count(), [2, 2, 2]);
        let largest = 5 * 5 * 5 * 2;
        let mut pool = Pool::new(2 * largest);
        for round in 0..2 {
            for brick in [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 0, 0]] {
                let cells = lattice.cells_of(brick);
                let texture = pool.texture(brick, &cells, &volume).unwrap();
                let [x, y, z] = texture.dims.map(|n| n - 1);
                let corner = |at: [usize; 3]| volume.samples[volume.offset(at[0], at[1], at[2])];
                assert_eq!(texture.samples[0], corner(cells.map(|c| c[0])));
                assert_eq!(texture.samples[texture.offset(x, y, z)], corner(cells.map(|c| c[1])));
                assert!(pool.bytes <= pool.limit, "round {round}");
            }
        }
        assert!(pool.peak <= 2 * largest && pool.uploads > 3, "{} {}", pool.peak, pool.uploads);
        let mut none: Pool<u16> = Pool::new(largest - 1);
        assert!(matches!(none.texture([0; 3], &lattice.cells_of([0; 3]), &volume), Err(RenderError::TooLarge { .. })));
    }
}
