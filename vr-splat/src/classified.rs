//! Tables that follow from the transfer function, and the voxels or points that are splatted under it.

use vr_core::filter::Lattice;
use vr_core::{GridVolume, LatticeVisitor, PointMixing, Scene, Voxel};
use vr_kernels::ranges::VisibleLevels;
use vr_kernels::tables::{BakedTransfer, table_range};
use vr_kernels::vector::OpticsTable;

use crate::cell_range::CellRange;
use crate::ghosts::{BEYOND, Ghosts, Vacuum};
use crate::input::{SplatInput, offset, unit};
use crate::kernel::Shape;
use crate::point_mixture::PointMixture;
use crate::ramps::Ramps;
use crate::splatter::{Buffers, Splatter};
use crate::visible::{VisibleVoxels, missing, visible_levels};
use crate::voxel_optics::VoxelOptics;

/// Tables that follow from the transfer function, and the visible voxels or points.
pub(crate) struct Classified {
    pub(crate) visible: Visible,
    pub(crate) light: VoxelOptics,
    /// For lengths in view units.
    pub(crate) values: OpticsTable,
    /// True if that table tells apart all that the transfer function does.
    pub(crate) resolved: bool,
    /// The ramps themselves, for points whose table does not tell them apart.
    pub(crate) ramps: Option<Ramps>,
    /// Values and colours of the points to be averaged; `None` where values are summed and points have no colours.
    pub(crate) mixture: Option<PointMixture>,
}

/// Voxels or points that are splatted.
pub(crate) enum Visible {
    Voxels(VisibleVoxels),
    Points(Vec<u32>),
}

impl Classified {
    /// Makes the tables of a scene, and finds what is visible of it, for a reach of voxels' kernels.
    pub(crate) fn new(
        renderer: &Splatter,
        scene: &Scene,
        input: &SplatInput,
        ghosts: Option<&Ghosts>,
        reach: [f64; 3],
    ) -> Self {
        let transfer = &scene.transfer;
        let (offset, calibration) = offset(input);
        let (integer, field, carried) = match input {
            SplatInput::Grid(grid) => {
                let (low, high) = grid.value_stats().range.map_or((0.0, 0.0), |(l, h)| (f64::from(l), f64::from(h)));
                // No weighted mean lies beyond all that is weighed, coefficients of the B-spline among it.
                let (min, max) = ghosts.map_or((low, high), |ghosts| {
                    let (min, max) = ghosts.range();
                    (low.min(f64::from(min)), high.max(f64::from(max)))
                });
                let beyond = overshoot(renderer) * (high - low);
                let field = (min - low - beyond, max - low + beyond);
                (grid.voxel_type().is_integer(), field, field)
            }
            SplatInput::Points(points) => {
                let values = || points.values().iter().map(|&v| f64::from(v));
                let carried = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
                // Sums may be any number, but of none below 0 they are not below 0, where tables have an end then, and no chord across a kink. Means,
                // counted from the smallest value, lie between it and the largest.
                let negative = || (0..points.count()).any(|k| points.amplitude(k) < 0.0);
                let field = match points.mixing() {
                    PointMixing::Mean => (0.0, carried.1 - carried.0),
                    PointMixing::Sum => (if negative() { f64::MIN / 4.0 } else { 0.0 }, f64::MAX / 4.0),
                };
                (false, field, carried)
            }
        };
        let range = table_range(field, integer, calibration, transfer);
        let baked = BakedTransfer::new(transfer, calibration, range, integer, unit(input));
        let values = OpticsTable::new(&baked, transfer, calibration, unit(input));
        let resolved = baked.resolves();
        let light =
            VoxelOptics::new(transfer, calibration, table_range(carried, integer, calibration, transfer), integer);
        let visible = match input {
            SplatInput::Grid(grid) => {
                let range = [range.0, range.1].map(|end| f64::from(end) + f64::from(offset));
                let seen = visible_levels(transfer, grid.calibration(), range.into());
                let shows_all = seen.all(range[0], range[1]);
                // Voxels on their own leave those that are missing out; elsewhere these are filled in, and vacuum has no part.
                let single = renderer.splats_light() && grid.vacuum_cells().is_some();
                let picks = !scene.compositing.integrates_light();
                let all = picks && !single || (shows_all && grid.vacuum_cells().is_none());
                let beyond = if ghosts.is_some() { BEYOND } else { 0 };
                let vacuum = Vacuum { cells: grid.vacuum_cells(), dims: grid.dims(), beyond };
                let find = FindVisible { renderer, grid, vacuum, seen: &seen, picks, reach };
                Visible::Voxels(match ghosts {
                    _ if all => VisibleVoxels::all(vacuum),
                    Some(ghosts) => find.visit(ghosts.lattice()),
                    None => grid.with_lattice(find),
                })
            }
            SplatInput::Points(points) => {
                let shows = |k: usize| {
                    let counts = points.weights()[k] != 0.0;
                    let seen = || light.at(points.values()[k]) != [0.0; 4];
                    counts && (!renderer.splats_light() || seen())
                };
                Visible::Points((0..points.count()).filter(|&k| shows(k)).map(|k| k as u32).collect())
            }
        };
        let ramps = match input {
            // Ramps are of values as they are; those of means count from the smallest.
            SplatInput::Points(points) if !resolved && points.mixing() == PointMixing::Sum => {
                Ramps::new(transfer, unit(input))
            }
            _ => None,
        };
        let mixture = match (input, &visible) {
            (SplatInput::Points(points), Visible::Points(visible)) => PointMixture::new(points, visible),
            _ => None,
        };
        Self { visible, light, values, resolved, ramps, mixture }
    }
}

/// Distance that a field may lie beyond the values of its voxels, by their range: kernels with negative weights overshoot.
fn overshoot(renderer: &Splatter) -> f64 {
    if matches!(renderer.kernel.shape, Shape::Sinc | Shape::CatmullRom) { 0.5 } else { 0.0 }
}

/// Finds the voxels that matter.
struct FindVisible<'a> {
    renderer: &'a Splatter,
    grid: &'a GridVolume,
    vacuum: Vacuum<'a>,
    seen: &'a VisibleLevels,
    /// True if every value may be picked, whether it can be seen or not.
    picks: bool,
    /// Reach of kernels along the grid's axes, in voxels.
    reach: [f64; 3],
}

impl LatticeVisitor for FindVisible<'_> {
    type Output = VisibleVoxels;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> VisibleVoxels {
        if self.renderer.splats_light() {
            let shows = |value: f64| self.picks || self.seen.any(value, value);
            return VisibleVoxels::single(&lattice, &missing(self.grid), &shows);
        }
        let reach = self.reach;
        // A sheet parallel to the image has the field's value in its middle, one of the volume's own a mean over whole kernels.
        let beyond = match self.renderer.buffers {
            Buffers::Image => 0.0,
            _ => reach.into_iter().fold(0.0, f64::max),
        };
        let overshoot = overshoot(self.renderer) as f32;
        // Fields of radial kernels vary less than the range of all voxels in reach; kernels that a low-pass widens have other weights.
        let is_fine = beyond == 0.0 && !self.renderer.kernel.shape.is_separable() && self.renderer.low_pass == 0.0;
        let fine = if is_fine { CellRange::new(&self.renderer.kernel) } else { None };
        VisibleVoxels::reconstructed(&lattice, self.vacuum, self.seen, reach, beyond, (overshoot, fine.as_ref()))
    }
}
