//! A texture of values: the volume's own samples, or the same turned for a stack of layers.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::filter::Lattice;
use vr_kernels::vector::{Cells, Field, Lanes, Pairs, Stage, central_differences};

use super::Texture;
use super::interpolant::slopes;

/// Values, linear along each axis.
pub(crate) struct Voxels<'a, T> {
    field: Field<'a, T>,
    dims: [usize; 3],
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
    /// The values of a lattice, with gradients from a source.
    pub(crate) fn new(lattice: &Lattice<'a, T>, relief: Relief<'a>) -> Self {
        Self { field: Field::new(lattice), dims: lattice.dims, relief }
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
    fn fetch<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &mut Stage<T>) {
        self.field.fetch(simd, at, stage);
    }

    #[inline(always)]
    fn read<S: Simd>(&self, simd: S, at: &Cells<S>, stage: &Stage<T>) -> [f32x16<S>; 4] {
        [self.field.value(simd, at, stage); 4]
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
