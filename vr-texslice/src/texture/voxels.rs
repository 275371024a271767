//! A texture of values: the volume's own samples, or a stack of its layers.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_core::filter::Lattice;
use vr_kernels::vector::{Cells, Field, Lanes, Pairs, Shade, Stage, cells, inside};

use super::{Lit, Texture};

/// Values, linear along each axis.
pub(crate) struct Voxels<'a, T> {
    field: Field<'a, T>,
    dims: [usize; 3],
    /// Slices to a layer along the last axis, where there is nothing between slices: of a stack of 2D textures.
    per_layer: Option<f32>,
    /// Field that gradients are taken from; `None` for that of the values.
    relief: Option<Relief<'a>>,
}

/// Field that gradients are taken from where voxels are missing: the volume's, the missing ones filled in.
#[derive(Clone)]
pub(crate) struct Relief<'a> {
    field: Arc<Field<'a, f32>>,
    /// Texture coordinate c is the index along axis `axes[c]` of this.
    axes: [usize; 3],
}

impl<'a> Relief<'a> {
    pub(crate) fn new(lattice: &Lattice<'a, f32>, axes: [usize; 3]) -> Self {
        Self { field: Arc::new(Field::new(lattice)), axes }
    }

    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, at: &Cells<S>, with: &Lit<'_>, light: &mut [Lanes; 4]) {
        let (mut cell, mut fraction) = ([Lanes::ZERO; 3], [Lanes::ZERO; 3]);
        for (c, &a) in self.axes.iter().enumerate() {
            (cell[a], fraction[a]) = (Lanes::new(at.cell[c].to_float()), Lanes::new(at.fraction[c]));
        }
        let shade = Shade { shading: with.shading, lights: with.lights };
        shade.apply(simd, &self.field, &[cell, fraction], &[Lanes::ZERO; 3], light, &mut Stage::default());
    }
}

impl<'a, T: Pairs> Voxels<'a, T> {
    /// A 3D texture.
    pub(crate) fn new(lattice: &Lattice<'a, T>) -> Self {
        Self { field: Field::new(lattice), dims: lattice.dims, per_layer: None, relief: None }
    }

    /// A stack of 2D textures, layer by layer, and so many slices to a layer: those between two layers are interpolated.
    pub(crate) fn stack(lattice: &Lattice<'a, T>, per_layer: u32) -> Self {
        Self { per_layer: Some(per_layer as f32), ..Self::new(lattice) }
    }

    /// The same, with gradients of another field.
    pub(crate) fn with_relief(self, relief: Option<Relief<'a>>) -> Self {
        Self { relief, ..self }
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
            let slice: i32x16<S> = (z * per_layer + 0.5).to_int();
            z = inside(simd, slice.to_float::<f32x16<S>>() * (1.0 / per_layer), max[2]);
        }
        cells(simd, [inside(simd, x, max[0]), inside(simd, y, max[1]), z], self.field.last_cell)
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
    fn place_between<S: Simd>(&self, simd: S, [x, y, z]: [f32x16<S>; 3]) -> Cells<S> {
        let max = self.dims.map(|n| (n - 1) as f32);
        cells(simd, [inside(simd, x, max[0]), inside(simd, y, max[1]), inside(simd, z, max[2])], self.field.last_cell)
    }

    #[inline(always)]
    fn shade<S: Simd>(&self, simd: S, at: &Cells<S>, with: &Lit<'_>, light: &mut [Lanes; 4], stage: &mut Stage<T>) {
        if let Some(relief) = &self.relief {
            return relief.shade(simd, at, with, light);
        }
        let [x, y, z] = at.cell;
        let cell = [Lanes::new(x.to_float()), Lanes::new(y.to_float()), Lanes::new(z.to_float())];
        let [x, y, z] = at.fraction;
        let fraction = [Lanes::new(x), Lanes::new(y), Lanes::new(z)];
        let shade = Shade { shading: with.shading, lights: with.lights };
        shade.apply(simd, &self.field, &[cell, fraction], &[Lanes::ZERO; 3], light, stage);
    }
}
