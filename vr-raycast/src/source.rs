//! Field that rays are cast through: of a grid, or of any other volume.

use std::sync::Arc;

use glam::DVec3;
use vr_core::field::Stretch;
use vr_core::{Calibration, Field, GridVolume, IndexRay, Placement, Ray, Real, Volume};

use crate::run::{RUN, Run};

/// Field that rays are cast through. Grids, with colours or without, have kernels for their voxel type and filter; other fields are asked at each place.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "a prepared scene holds one: a box would save nothing")]
pub(crate) enum Source {
    Grid(Arc<GridVolume>),
    Other(FieldBox),
}

/// Field that is no grid's, in the index space of a lattice over its box whose edges are about as long as the field's spacing.
#[derive(Clone, Debug)]
pub(crate) struct FieldBox {
    volume: Volume,
    placement: Placement,
    dims: [usize; 3],
}

impl Source {
    /// Returns the field of a volume; `None` for a box that no lattice can fill.
    pub(crate) fn of(volume: &Volume) -> Option<Self> {
        if let Some(grid) = volume.value_grid() {
            return Some(Self::Grid(Arc::clone(grid)));
        }
        let ((low, high), spacing) = (volume.bounds(), volume.mean_spacing());
        let edges = (high - low).to_array();
        // `as` saturates; the lattice places samples and holds none.
        let cells = edges.map(|edge| (edge / spacing).round().clamp(1.0, f64::from(u32::MAX)) as usize);
        let axis = |a: usize| DVec3::AXES[a] * (edges[a] / cells[a] as f64);
        let placement = Placement::new(low, glam::DMat3::from_cols(axis(0), axis(1), axis(2))).ok()?;
        Some(Self::Other(FieldBox { volume: volume.clone(), placement, dims: cells.map(|n| n + 1) }))
    }

    /// Returns the grid, if it is one.
    pub(crate) fn grid(&self) -> Option<&Arc<GridVolume>> {
        match self {
            Self::Grid(grid) => Some(grid),
            Self::Other(_) => None,
        }
    }

    /// Returns the distances along a part of a ray at which a field that is no grid's jumps, ascending.
    pub(crate) fn jumps(&self, ray: &Ray, part: &IndexRay) -> Vec<f64> {
        let mut jumps = Vec::new();
        if let Self::Other(other) = self
            && let Some(field) = other.field()
        {
            field.jumps(ray, [part.start, part.end].map(|s| s + part.offset), &mut jumps);
            jumps.iter_mut().for_each(|s| *s -= part.offset);
        }
        jumps
    }

    /// Returns the stretches of a part of a ray in its own distances; `None` for grids, and for fields that do not know them.
    pub(crate) fn stretches(&self, ray: &Ray, part: &IndexRay) -> Option<Vec<Stretch>> {
        let Self::Other(other) = self else { return None };
        let (field, mut stretches) = (other.field()?, Vec::new());
        if !field.stretches(ray, [part.start, part.end].map(|s| s + part.offset), &mut stretches) {
            return None;
        }
        for stretch in &mut stretches {
            (stretch.from, stretch.to) = (stretch.from - part.offset, stretch.to - part.offset);
        }
        Some(stretches)
    }

    /// Returns the placement of index space in the world.
    pub(crate) fn placement(&self) -> &Placement {
        match self {
            Self::Grid(grid) => grid.placement(),
            Self::Other(other) => &other.placement,
        }
    }

    /// Returns the numbers of lattice points along x, y and z.
    pub(crate) fn dims(&self) -> [usize; 3] {
        match self {
            Self::Grid(grid) => grid.dims(),
            Self::Other(other) => other.dims,
        }
    }

    /// Returns the map from stored numbers to values: the identity for fields that are no grids.
    pub(crate) fn calibration(&self) -> Calibration {
        self.grid().map_or_else(Calibration::default, |grid| grid.calibration())
    }
}

impl FieldBox {
    fn field(&self) -> Option<&dyn Field> {
        self.volume.field()
    }

    fn world<R: Real>(&self, position: [R; 3]) -> DVec3 {
        self.placement.to_world(DVec3::from_array(position.map(R::to_f64)))
    }

    /// Returns the value at a place in index space; NaN in vacuum.
    pub(crate) fn value<R: Real>(&self, position: [R; 3]) -> f64 {
        self.field().and_then(|field| field.value(self.world(position))).unwrap_or(f64::NAN)
    }

    /// Fills the values at places in index space, given axis by axis; NaN in vacuum.
    pub(crate) fn values<R: Real>(&self, [x, y, z]: [&[R]; 3], values: &mut [R]) {
        let Some(field) = self.field() else { return };
        let (mut places, mut found) = ([DVec3::ZERO; RUN], [0.0; RUN]);
        for (part, values) in values.chunks_mut(RUN).enumerate() {
            let (first, len) = (part * RUN, values.len());
            for (i, place) in places[..len].iter_mut().enumerate() {
                *place = self.world([x[first + i], y[first + i], z[first + i]]);
            }
            field.values(&places[..len], &mut found[..len]);
            for (value, found) in values.iter_mut().zip(&found[..len]) {
                *value = R::from_f64(*found);
            }
        }
    }

    /// Returns the colour of a place in index space; `None` in vacuum, and of fields that have none.
    pub(crate) fn color<R: Real>(&self, position: [R; 3]) -> Option<[f64; 3]> {
        self.field().and_then(|field| field.color(self.world(position)))
    }

    /// Returns the gradient at a place in the world, per index step; `None` in vacuum, and of fields that have none.
    pub(crate) fn gradient(&self, at: DVec3) -> Option<[f64; 3]> {
        let gradient = self.field()?.gradient(at)?;
        Some((self.placement.axes().transpose() * gradient).to_array())
    }

    /// Fills the gradients of a placed run, per index step, where something absorbs or shines.
    pub(crate) fn gradients<R: Real>(&self, run: &mut Run<R>) {
        for j in 0..run.len() {
            if run.light[j] != [R::ZERO; 4] {
                let world = self.world(run.position_of(j));
                run.gradient[j] = self.gradient(world).unwrap_or_default().map(R::from_f64);
            }
        }
    }

    /// Returns the value at a world distance along a ray, inside the box.
    pub(crate) fn value_along(&self, ray: &IndexRay, distance: f64) -> f64 {
        let at = ray.at(distance).to_array();
        self.value::<f64>(std::array::from_fn(|a| at[a].clamp(0.0, (self.dims[a] - 1) as f64)))
    }
}
