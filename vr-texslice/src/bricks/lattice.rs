//! The cells of each brick, and the order in which bricks are seen.

use glam::DVec3;
use vr_core::{Placement, Projection, RenderError, View};

use crate::layout::Layout;
use crate::region::Region;

/// The bricks of a volume: of so many cells along an edge, fewer at the upper faces; all numbers are along the axes of their texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BrickLattice {
    pub(crate) edge: usize,
    /// Cells along each axis of the texels.
    cells: [usize; 3],
    layout: Layout,
}

/// The cells of a brick along each axis: from the first to behind the last.
pub(crate) type Cells = [[usize; 2]; 3];

impl BrickLattice {
    /// The bricks of a volume of so many samples along its own axes.
    pub(crate) fn new(dims: [usize; 3], edge: usize, layout: Layout) -> Self {
        Self { edge, cells: layout.turned(dims).map(|n| n - 1), layout }
    }

    /// Bricks along each axis.
    pub(crate) fn count(&self) -> [usize; 3] {
        self.cells.map(|n| n.div_ceil(self.edge))
    }

    pub(crate) fn cells_of(&self, brick: [usize; 3]) -> Cells {
        std::array::from_fn(|a| [brick[a] * self.edge, ((brick[a] + 1) * self.edge).min(self.cells[a])])
    }

    /// The bricks, from the first to the last along each axis, that have cells in common with a brick and so many around it.
    pub(crate) fn bricks_around(&self, brick: [usize; 3], cells: [usize; 3]) -> [[usize; 2]; 3] {
        let count = self.count();
        std::array::from_fn(|a| {
            let [first, behind] = self.cells_of(brick)[a];
            [first.saturating_sub(cells[a]) / self.edge, ((behind - 1 + cells[a]) / self.edge).min(count[a] - 1)]
        })
    }

    /// The largest region that a brick needs, given that of its cells.
    pub(crate) fn largest(&self, region: impl Fn(&Cells) -> Region) -> Region {
        // Along each axis the second, with an apron at both ends, or the first, if it is the larger one.
        let extent = |a: usize| {
            let of = |brick: usize| {
                let brick = std::array::from_fn(|b| if b == a { brick } else { 0 });
                region(&self.cells_of(brick)).dims[a]
            };
            (0..self.count()[a].min(2)).map(of).max().unwrap_or_default()
        };
        Region { first: [0; 3], dims: std::array::from_fn(extent) }
    }

    /// Every brick, in an order in which none hides one before it.
    ///
    /// Along a ray a brick's number grows, or falls, away from the eye, on each axis. So does the sum over the axes of how far its number is from that of the
    /// brick in which the eye is (which may lie beyond the volume), or, where rays are parallel, its numbers along the view.
    pub(crate) fn front_to_back(&self, view: &View, placement: &Placement) -> Result<Vec<[usize; 3]>, RenderError> {
        let count = self.count();
        let index = placement.inverse_axes() * (view.camera.eye - placement.origin());
        let mut eye = self.layout.turned(index.to_array());
        // Of samples that are moved, those on one side of the eye stay on one side of the slice that it moves to.
        eye[2] = self.layout.moved(eye[2]);
        let eye = eye.map(|at| (at / self.edge as f64).floor());
        let ahead = self.layout.turned((placement.inverse_axes() * view.camera.frame()?.z_axis).to_array());
        let depth = |brick: [usize; 3]| -> f64 {
            let along = |a: usize| match view.camera.projection {
                Projection::Perspective { .. } => (brick[a] as f64 - eye[a]).abs(),
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

    /// The corners in the world of a brick, and of as much before it and behind as its samples may be moved by.
    pub(crate) fn corners(&self, brick: [usize; 3], placement: &Placement) -> [DVec3; 8] {
        let cells = self.cells_of(brick);
        let [low, high] = [0, 1].map(|end| {
            let mut corner = cells.map(|c| c[end] as f64);
            corner[2] += [-1.0, 1.0][end] * self.layout.largest_move();
            DVec3::from_array(self.layout.turned_back(corner))
        });
        crate::geometry::box_corners(placement, low, high)
    }
}
