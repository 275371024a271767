//! Values of a volume in planes of samples.

use glam::{DMat3, DVec3};

use super::cell_raster::CellRaster;
use super::error::ResampleError;
use super::lattice::SampleLattice;
use crate::cells::CellMesh;
use crate::error::GridError;
use crate::field::Field;
use crate::filter::Reconstruction;
use crate::grid_volume::{GridVolume, SamplerVisitor};
use crate::placement::Placement;
use crate::rectilinear::Axis;
use crate::sampler::Sampler;
use crate::volume::Volume;
use crate::voxel::Voxel;

/// A volume to be resampled, in coordinates in which its box is axis-parallel: index space of a uniform grid, the world of others.
pub(super) struct Source<'a> {
    volume: &'a Volume,
    kind: Kind<'a>,
    /// The box.
    pub bounds: (DVec3, DVec3),
    /// Steps of the finest cells along each axis.
    pub finest: DVec3,
}

enum Kind<'a> {
    Grid(&'a GridVolume),
    Cells(&'a CellMesh),
    Field(&'a dyn Field),
}

impl<'a> Source<'a> {
    /// The source that a volume is.
    ///
    /// # Errors
    /// [`ResampleError::Kind`] for a volume whose values are colours or codes.
    pub fn new(volume: &'a Volume) -> Result<Self, ResampleError> {
        let refused = |why| Err(ResampleError::Kind { kind: volume.kind(), why });
        if volume.colors().is_some() {
            return refused("its voxels have colours; take one of its components");
        }
        if volume.has_colors() {
            return refused("its points have colours, which values of voxels would lose; leave the colours out");
        }
        if volume.field().is_some_and(Field::values_are_codes) {
            return refused(
                "its values are codes of labels, between which there is nothing; resample the volume without them",
            );
        }
        volume.prepare_derived();
        let (kind, finest) = match volume {
            Volume::Grid(grid) => (Kind::Grid(grid), DVec3::ONE),
            Volume::Cells(mesh) => (Kind::Cells(mesh), DVec3::splat(finest_cells(mesh))),
            Volume::Rectilinear(grid) => {
                let steps = grid.axes().each_ref().map(Axis::smallest_step);
                (Kind::Field(&**grid), steps.into())
            }
            Volume::Amr(grid) => (Kind::Field(&**grid), grid.finest_spacing()),
            other => match other.field() {
                Some(field) => (Kind::Field(field), DVec3::splat(other.mean_spacing())),
                None => return refused("it has no field"),
            },
        };
        let bounds = match kind {
            Kind::Grid(grid) => (DVec3::ZERO, DVec3::from_array(grid.dims().map(|n| (n - 1) as f64))),
            _ => volume.bounds(),
        };
        Ok(Self { volume, kind, bounds, finest })
    }

    /// The volume.
    pub fn volume(&self) -> &Volume {
        self.volume
    }

    /// World lengths of steps along the axes of the source.
    pub fn world_steps(&self) -> DVec3 {
        match self.kind {
            Kind::Grid(grid) => grid.placement().spacing(),
            _ => DVec3::ONE,
        }
    }

    /// Placement of a grid of so many voxels over the box.
    pub fn placement(&self, dims: [usize; 3]) -> Result<Placement, GridError> {
        let (low, high) = self.bounds;
        let steps = DMat3::from_diagonal((high - low) / DVec3::from_array(dims.map(|n| (n - 1) as f64)));
        match self.kind {
            Kind::Grid(grid) => Placement::new(grid.placement().origin(), grid.placement().axes() * steps),
            _ => Placement::new(low, steps),
        }
    }

    /// The values of planes of a lattice; `parts` planes, from a multiple of it on, are asked for one after the other.
    pub fn planes<'s>(&'s self, lattice: &'s SampleLattice, parts: usize) -> Planes<'s> {
        let raster = match self.kind {
            Kind::Cells(mesh) => CellRaster::new(mesh, lattice, parts),
            _ => None,
        };
        Planes { source: self, lattice, raster }
    }
}

/// Edge of a cube of six cells as small as the smallest twentieth of a mesh: slivers, of which every mesh has some, do not count.
fn finest_cells(mesh: &CellMesh) -> f64 {
    let mut sizes: Vec<f64> = (0..mesh.cells().len())
        .map(|cell| {
            let [a, b, c, d] = mesh.corners(cell);
            (b - a).cross(c - a).dot(d - a).cbrt()
        })
        .collect();
    let rank = sizes.len() / 20;
    *sizes.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// Values of planes of a lattice.
pub(super) struct Planes<'a> {
    source: &'a Source<'a>,
    lattice: &'a SampleLattice,
    /// The cells in order, of a mesh that is not too unwieldy for that.
    raster: Option<CellRaster<'a>>,
}

impl Planes<'_> {
    /// Fills a plane across z with values, x fastest; NaN in vacuum.
    pub fn fill(&self, plane: usize, out: &mut [f64]) {
        if let Some(raster) = &self.raster {
            return raster.fill(plane, out);
        }
        let [xs, ys, zs] = &self.lattice.places;
        let z = zs[plane];
        for (row, &y) in out.chunks_mut(xs.len()).zip(ys) {
            match self.source.kind {
                Kind::Grid(grid) => grid.with_sampler(RowOf { grid, xs, y, z, row }),
                Kind::Cells(mesh) => fill_row(mesh, xs, y, z, row),
                Kind::Field(field) => fill_row(field, xs, y, z, row),
            }
        }
    }
}

fn fill_row(field: &dyn Field, xs: &[f64], y: f64, z: f64, row: &mut [f64]) {
    for (value, &x) in row.iter_mut().zip(xs) {
        *value = field.value(DVec3::new(x, y, z)).unwrap_or(f64::NAN);
    }
}

/// A row of samples in the index space of a grid.
struct RowOf<'a> {
    grid: &'a GridVolume,
    xs: &'a [f64],
    y: f64,
    z: f64,
    row: &'a mut [f64],
}

impl SamplerVisitor for RowOf<'_> {
    type Output = ();

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        let (dims, calibration) = (self.grid.dims(), self.grid.calibration());
        let is_inside = |at: [f64; 3]| (0..3).all(|a| (0.0..=(dims[a] - 1) as f64).contains(&at[a]));
        for (value, &x) in self.row.iter_mut().zip(self.xs) {
            let at = [x, self.y, self.z];
            *value = if is_inside(at) { calibration.value(sampler.value(at)) } else { f64::NAN };
        }
    }
}
