//! Kind of the steps of a ray.

/// Kind of the steps of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Traversal {
    /// Steps of the given length, wherever the faces of cells are.
    #[default]
    Samples,
    /// Walk from cell to cell (3D DDA, Amanatides and Woo 1987): steps end at cell faces, and a cell is cut into equal steps where it is
    /// longer than a [`Step::Uniform`](super::Step::Uniform) (other settings do not cut them; [`Rule::Exact`](super::Rule::Exact) never does). No step has a kink of the trilinear
    /// field inside, and so rules keep the order that they have on smooth fields.
    Cells,
    /// Walk from voxel to voxel (a 26-connected Bresenham line): the field is taken at the samples nearest to the ray, as if it were constant
    /// around each. The classic discrete approximation: of first order in the size of a voxel, and as there is one step a voxel, none
    /// makes it better. With [`Rule::Midpoint`](super::Rule::Midpoint) alone.
    #[cfg(feature = "classics")]
    Voxels,
}
