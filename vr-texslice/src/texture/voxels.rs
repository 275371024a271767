//! A texture of values: the volume's own samples, or a stack of its layers.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::filter::Lattice;
use vr_kernels::vector::{Cells, Field, Lanes, Pairs, Stage, cells, central_differences, inside, pick, splat};

use super::interpolant::slopes;
use super::{Texture, on_slices};

/// Values, linear along each axis.
pub(crate) struct Voxels<'a, T> {
    field: Field<'a, T>,
    dims: [usize; 3],
    /// Slices to a layer along the last axis, where there is nothing between slices: of a stack of 2D textures.
    per_layer: Option<f32>,
    /// True if voxels are missing: what lies on a layer of a stack is vacuum, then, if the cell on either side of it is.
    has_holes: bool,
    relief: Relief<'a>,
}

/// Source of gradients.
#[derive(Clone)]
pub(crate) enum Relief<'a> {
    /// Central differences of the values.
    Values,
    /// Central differences of the volume's field, missing voxels filled in; texture coordinate c is the index along axis `axes[c]` of that.
    Filled { field: Arc<Field<'a, f32>>, axes: [usize; 3] },
    /// The derivative of the interpolant, inside each cell.
    Interpolant,
}

impl<'a> Relief<'a> {
    /// Central differences of a field without missing voxels.
    pub(crate) fn filled(lattice: &Lattice<'a, f32>, axes: [usize; 3]) -> Self {
        Self::Filled { field: Arc::new(Field::new(lattice)), axes }
    }
}

impl<'a, T: Pairs> Voxels<'a, T> {
    /// A 3D texture.
    pub(crate) fn new(lattice: &Lattice<'a, T>) -> Self {
        Self {
            field: Field::new(lattice),
            dims: lattice.dims,
            per_layer: None,
            has_holes: false,
            relief: Relief::Values,
        }
    }

    /// A stack of 2D textures, layer by layer, and so many slices to a layer: those between two layers are interpolated.
    pub(crate) fn stack(lattice: &Lattice<'a, T>, per_layer: u32, has_holes: bool) -> Self {
        Self { per_layer: Some(per_layer as f32), has_holes, ..Self::new(lattice) }
    }

    /// The same, with gradients from a source.
    pub(crate) fn with_relief(self, relief: Relief<'a>) -> Self {
        Self { relief, ..self }
    }
}

impl<T: Pairs> Voxels<'_, T> {
    /// Values at places, NaN on the lower face of a cell along the last axis where the cell before it is vacuum.
    ///
    /// Its own function: few volumes have holes.
    #[inline(never)]
    fn unless_vacuum_before<S: Simd>(&self, simd: S, at: &Cells<S>, value: f32x16<S>) -> f32x16<S> {
        let mut lanes = Lanes::new(value);
        simd.vectorize(
            #[inline(always)]
            || {
                let [x, y, z] = at.cell;
                let [tx, ty, tz] = at.fraction;
                let on_face = tz.simd_eq(splat(simd, 0.0)) & z.simd_gt(i32x16::splat(simd, 0));
                if on_face.any_true() {
                    let cell = [x, y, (z - 1).max(i32x16::splat(simd, 0))];
                    let before = Cells { cell, fraction: [tx, ty, splat(simd, 1.0)] };
                    let mut stage = Stage::default();
                    self.field.fetch(simd, &before, &mut stage);
                    let there = self.field.value(simd, &before, &stage);
                    lanes = Lanes::new(pick(on_face & !there.simd_eq(there), there, value));
                }
            },
        );
        lanes.load(simd)
    }
}

impl<T: Pairs> Texture for Voxels<'_, T> {
    type Stage = Stage<T>;
    const LIGHT: bool = false;

    #[inline(always)]
    fn dims(&self) -> [usize; 3] {
        self.dims
    }

    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> Cells<S> {
        let max = self.dims.map(|n| (n - 1) as f32);
        let mut z = inside(simd, z, max[2]);
        if let Some(per_layer) = self.per_layer {
            z = on_slices(simd, z, per_layer, max[2]);
        }
        cells(simd, [inside(simd, x, max[0]), inside(simd, y, max[1]), z], self.field.last_cell)
    }

    #[inline(always)]
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Stage<T>) {
        self.field.fetch(simd, at, stage);
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Stage<T>) -> [f32x16<S>; 4] {
        let value = self.field.value(simd, at, stage);
        [if self.has_holes { self.unless_vacuum_before(simd, at, value) } else { value }; 4]
    }

    #[inline(always)]
    fn place_between<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> Cells<S> {
        let max = self.dims.map(|n| (n - 1) as f32);
        cells(simd, [inside(simd, x, max[0]), inside(simd, y, max[1]), inside(simd, z, max[2])], self.field.last_cell)
    }

    #[inline(always)]
    fn gradient<S: Simd>(&self, simd: S, at: &Cells<S>, _: u32, stage: &mut Stage<T>) -> [Lanes; 3] {
        let still = [Lanes::ZERO; 3];
        match &self.relief {
            Relief::Values => {
                let [x, y, z] = at.cell;
                let cell = [Lanes::new(x.to_float()), Lanes::new(y.to_float()), Lanes::new(z.to_float())];
                let [x, y, z] = at.fraction;
                let fraction = [Lanes::new(x), Lanes::new(y), Lanes::new(z)];
                let [gradient, _] = central_differences(simd, &self.field, &[cell, fraction], &still, stage);
                gradient
            }
            Relief::Filled { field, axes } => {
                let (mut cell, mut fraction) = ([Lanes::ZERO; 3], [Lanes::ZERO; 3]);
                for (c, &a) in axes.iter().enumerate() {
                    (cell[a], fraction[a]) = (Lanes::new(at.cell[c].to_float()), Lanes::new(at.fraction[c]));
                }
                let [gradient, _] = central_differences(simd, field, &[cell, fraction], &still, &mut Stage::default());
                axes.map(|a| gradient[a])
            }
            Relief::Interpolant => {
                self.field.fetch(simd, at, stage);
                slopes(simd, at, |axis| self.field.faces(simd, axis, stage))
            }
        }
    }
}
