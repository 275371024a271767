//! Inputs that the tiles of a picture share, and the work on each.

use fearless_simd::Level;
use vr_kernels::vector::{LANES, Operator, OpticsTable, VoxelColors};

use crate::bins::Keyed;
use crate::kernel::RadialWeight;
use crate::point_gradients::PointGradient;
use crate::point_mixture::{MixtureChannels, PointMixture};
use crate::projection::SplatView;
use crate::ramps::Ramps;
use crate::shading::Shader;
use crate::splat::Splat;
use crate::splatter::Buffers;
use crate::visible::CellBits;
use crate::voxel_optics::VoxelOptics;

use super::block::{Bounds, EDGE};
use super::footprint::FootprintKernel;
use super::state::State;
use super::{ACROSS, TileJob};

/// Inputs that all tiles share.
pub(crate) struct Painter<'a> {
    pub(crate) view: &'a SplatView,
    pub(crate) bounds: Bounds<'a>,
    pub(crate) kernel: &'a FootprintKernel,
    /// Formula of the kernel, if it is radial and evaluated in the middle of sheets parallel to the image.
    pub(crate) in_middle: Option<RadialWeight>,
    pub(crate) operator: Operator,
    pub(crate) buffers: Buffers,
    /// Distance between sheets that are parallel to the image, in the view's units.
    pub(crate) distance: f32,
    /// 1 over that.
    pub(crate) per_distance: f32,
    /// Number of these sheets.
    pub(crate) sheets: u32,
    /// Number of them that are held at once: a power of two, and at least as many as one splat is in.
    pub(crate) ring: u32,
    /// Sheets of the volume's own: their axis, and the layer of each.
    pub(crate) layers: Option<(usize, &'a [u32])>,
    pub(crate) content: Content<'a>,
    /// Smallest integral of a kernel along a ray, in world units, that lets a sample without sheets be picked: rounding must not.
    pub(crate) min_met: f32,
    /// Transmittance up to which pixels are left as they are.
    pub(crate) negligible: f32,
    pub(crate) level: Level,
}

/// Content of sheets.
pub(crate) enum Content<'a> {
    /// Values, and their divisors or the lengths that are covered, and where light depends on the gradient of points, that; classified sheet by sheet.
    Values {
        classifier: Classifier<'a>,
        /// True if weights are divided out (of a grid), or the length that supports cover (of points): from the first one's front to the last one's
        /// back, in each sheet.
        normalised: bool,
        /// Values and colours of points, by the numbers that their splats carry; `None` where sheets sum no weights.
        mixture: Option<&'a PointMixture>,
        /// Colours of voxels; `None` where they have none.
        colors: Option<&'a VoxelColors<'a>>,
        /// Cells in which something can be seen at all.
        cells: Option<VisibleCells<'a>>,
        /// Shading of light.
        shader: Option<&'a Shader<'a>>,
    },
    /// Emission and optical depth of what is classified already.
    Light(SplatLight<'a>),
    /// Sums of values over whole kernels alone.
    Sums,
}

/// Cells in which something can be seen, of a lattice that may have voxels beyond the grid.
#[derive(Clone, Copy)]
pub(crate) struct VisibleCells<'a> {
    pub(crate) bits: &'a CellBits,
    /// Voxels of the lattice.
    pub(crate) dims: [usize; 3],
    /// Number of its voxels before the grid's first.
    pub(crate) beyond: usize,
}

/// (q, κ) of splats that are classified already.
#[derive(Clone, Copy)]
pub(crate) enum SplatLight<'a> {
    /// By the value that a splat carries.
    OfValue(&'a VoxelOptics),
    /// By the number that it carries, as bits: see [`Splat::value`](crate::splat::Splat::value).
    OfSample(&'a [[f32; 4]]),
}

impl SplatLight<'_> {
    /// (q, κ) of a splat by what it carries.
    #[inline(always)]
    pub(super) fn at(&self, carried: f32) -> [f32; 4] {
        match self {
            Self::OfValue(optics) => optics.at(carried),
            Self::OfSample(rows) => rows[carried.to_bits() as usize],
        }
    }
}

/// Classification of a sheet's values.
pub(crate) enum Classifier<'a> {
    /// By a table, over lengths in the view's units.
    Table(&'a OpticsTable),
    /// By the transfer function's ramps, over the same lengths.
    Ramps(&'a Ramps),
    /// One by one: of a stored number and a length.
    Exact(&'a (dyn Fn(f32, f32) -> [f32; 4] + Sync)),
}

/// The work on a tile.
#[derive(Clone, Copy, Default)]
pub(crate) struct Work {
    pub(crate) rays: u64,
    /// Splats times blocks.
    pub(crate) met: u64,
    /// Splats that nothing was done for, what is before them being opaque.
    pub(crate) skipped: u64,
    pub(crate) opaque: u64,
}

/// Pixels of a tile, block by block.
pub(crate) struct Drawn {
    pub(crate) column: u32,
    pub(crate) row: u32,
    pub(super) blocks: Vec<(u32, State)>,
    pub(crate) work: Work,
}

impl Drawn {
    /// Calls back with place, state and lane of every pixel that anything may be in.
    pub(crate) fn each(&self, size: [u32; 2], mut take: impl FnMut([u32; 2], &State, usize)) {
        for (number, state) in &self.blocks {
            let (x, y) = (self.column + number % ACROSS * EDGE, self.row + number / ACROSS * EDGE);
            for i in 0..LANES {
                let at = [x + i as u32 % EDGE, y + i as u32 / EDGE];
                if at[0] < size[0] && at[1] < size[1] {
                    take(at, state, i);
                }
            }
        }
    }
}

impl Painter<'_> {
    /// Draws the tile whose first pixel is (column, row).
    pub(crate) fn draw(&self, column: u32, row: u32, splats: Vec<Keyed>) -> Drawn {
        vr_kernels::vector::run(self.level, TileJob { painter: self, column, row, splats: &splats })
    }

    pub(super) fn shader(&self) -> Option<&Shader<'_>> {
        match self.content {
            Content::Values { shader, .. } => shader,
            _ => None,
        }
    }

    /// The gradient of points' kernels, where sheets sum it.
    #[inline(always)]
    pub(super) fn summed_gradient(&self) -> Option<PointGradient> {
        self.shader().and_then(Shader::summed)
    }

    /// Returns the value that a splat adds to sheets, and its optics or its colour.
    #[inline(always)]
    pub(super) fn carried(&self, splat: &Splat) -> (f32, [f32; 4]) {
        match &self.content {
            Content::Light(optics) => (splat.value, optics.at(splat.value)),
            Content::Values { mixture: Some(mixture), .. } => {
                let [value, r, g, b] = mixture.rows[splat.value.to_bits() as usize];
                (value, [r, g, b, 0.0])
            }
            _ => (splat.value, [0.0; 4]),
        }
    }

    /// Colours of voxels that are classified sheet by sheet, or picked.
    #[inline(always)]
    pub(super) fn colors(&self) -> Option<&VoxelColors<'_>> {
        match self.content {
            Content::Values { colors, .. } => colors,
            _ => None,
        }
    }

    /// True if sheets sum weights of points.
    #[inline(always)]
    pub(super) fn mixes(&self) -> bool {
        matches!(self.content, Content::Values { mixture: Some(_), .. })
    }

    pub(super) fn channels(&self) -> usize {
        match self.content {
            Content::Values { normalised: true, .. } => 2,
            Content::Values { mixture: Some(mixture), shader, .. } => {
                MixtureChannels::new(shader.is_some(), mixture.is_mean).count
            }
            Content::Values { shader: Some(_), .. } => 6,
            Content::Values { .. } => 3,
            Content::Light(_) => 4,
            Content::Sums => 0,
        }
    }
}
