//! The renderer's settings.

use vr_core::Classification;

use crate::warp::WarpFilter;

/// A shear-warp renderer.
#[derive(Clone, Debug, PartialEq)]
pub struct ShearWarp {
    /// Order of interpolation and classification.
    pub classification: Classification,
    /// Texels from slice to slice of samples along the principal axis; [`Self::slice_spacing`] must be 0.01 to 1.
    pub slice_distance: f64,
    /// Voxels to a texel of the intermediate image, along either side: 0.03 to 1. In perspective, in the volume's middle.
    pub texel: f64,
    /// Filter that resamples the intermediate image onto the screen.
    pub warp: WarpFilter,
    /// Search for the runs of cells that can be seen.
    pub empty_space: EmptySpace,
    /// Opacity from which on a texel is opaque, in (0, 1]; changes no texel by more than 1 − termination.
    pub termination: f64,
    /// Opacity of one voxel's thickness up to which values are left out, where nothing around is more opaque; in [0, 1).
    pub opacity_threshold: f64,
    /// True if opacities are corrected for the distance between slices along a ray. Off, pictures are darker or brighter with the angle: to
    /// show why it is on.
    pub correction: bool,
}

/// Search for the runs of cells that can be seen, and the place of their voxels in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EmptySpace {
    /// Run-length encoded: runs end where nothing can be visible, and what they touch is packed. Fastest for a fixed transfer function.
    #[default]
    Runs,
    /// By an octree of ranges and a table of those that can be seen, without a look at voxels: runs of whole blocks of 4³ cells, of the
    /// volume as it lies. A new transfer function costs next to nothing.
    Octree,
}

impl Default for ShearWarp {
    fn default() -> Self {
        Self {
            classification: Classification::default(),
            slice_distance: 0.5,
            texel: 1.0,
            warp: WarpFilter::default(),
            empty_space: EmptySpace::default(),
            termination: 0.998,
            opacity_threshold: 0.0,
            correction: true,
        }
    }
}

impl ShearWarp {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "shearwarp";

    /// The classic: voxels classified and shaded, then interpolated in each layer, and texels opaque at 0.99 (Lacroute & Levoy 1994).
    pub fn classic() -> Self {
        Self { classification: Classification::Pre, slice_distance: 1.0, termination: 0.99, ..Self::default() }
    }

    /// Voxels from slice to slice: 1 samples the layers of voxels alone.
    pub fn slice_spacing(&self) -> f64 {
        let spacing = self.slice_distance * self.texel;
        // A third of a voxel times three is one.
        if (spacing - 1.0).abs() < 1e-9 { 1.0 } else { spacing }
    }
}
