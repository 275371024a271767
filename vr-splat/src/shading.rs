//! Shading of values, by gradients from the grid itself.

use std::sync::Arc;

use fearless_simd::Simd;
use vr_core::filter::Lattice;
use vr_core::{AnyGrid, GridVolume, Scene, UniformGrid, Voxel};
use vr_kernels::vector::{Field, LANES, Lanes, PacketLights, PacketShading, Shade, Stage};

/// The scene's shading, and the samples that gradients come from.
pub(crate) struct Shader<'a> {
    pub(crate) shading: PacketShading,
    field: AnyField<'a>,
}

/// The samples, whatever they are.
enum AnyField<'a> {
    U8(Field<'a, u8>),
    I8(Field<'a, i8>),
    U16(Field<'a, u16>),
    I16(Field<'a, i16>),
    F32(Field<'a, f32>),
}

impl<'a> Shader<'a> {
    /// Shader of a scene whose light is shaded.
    pub(crate) fn new(scene: &Scene, volume: &'a GridVolume) -> Option<Self> {
        let shading = Arc::clone(scene.reflection()?);
        fn field<T: Voxel>(grid: &UniformGrid<T>) -> Field<'_, T> {
            Field::new(&Lattice { samples: grid.samples(), dims: grid.dims() })
        }
        let field = match volume.values() {
            AnyGrid::U8(grid) => AnyField::U8(field(grid)),
            AnyGrid::I8(grid) => AnyField::I8(field(grid)),
            AnyGrid::U16(grid) => AnyField::U16(field(grid)),
            AnyGrid::I16(grid) => AnyField::I16(field(grid)),
            // Beside missing voxels gradients are those of the nearest values, as they are for the reference.
            AnyGrid::F32(grid) => {
                let samples = volume.filled_floats().unwrap_or(grid.samples());
                AnyField::F32(Field::new(&Lattice { samples, dims: grid.dims() }))
            }
        };
        Some(Self { shading: PacketShading::new(shading, &scene.lights, volume.placement(), [0, 1, 2]), field })
    }

    /// Shades light and opacity at places in index space.
    #[inline(always)]
    pub(crate) fn shade<S: Simd>(&self, simd: S, lights: &PacketLights, place: [Lanes; 3], light: &mut [Lanes; 4]) {
        let last = match &self.field {
            AnyField::U8(f) => f.last_cell,
            AnyField::I8(f) => f.last_cell,
            AnyField::U16(f) => f.last_cell,
            AnyField::I16(f) => f.last_cell,
            AnyField::F32(f) => f.last_cell,
        };
        let mut at = [[Lanes::ZERO; 3]; 2];
        for a in 0..3 {
            for i in 0..LANES {
                let x = place[a].0[i].max(0.0).min((last[a] + 1) as f32);
                let cell = (x as i32).min(last[a]) as f32;
                (at[0][a].0[i], at[1][a].0[i]) = (cell, x - cell);
            }
        }
        let shade = Shade { shading: &self.shading, lights };
        match &self.field {
            AnyField::U8(f) => shade.apply(simd, f, &at, &[Lanes::ZERO; 3], light, &mut Stage::default()),
            AnyField::I8(f) => shade.apply(simd, f, &at, &[Lanes::ZERO; 3], light, &mut Stage::default()),
            AnyField::U16(f) => shade.apply(simd, f, &at, &[Lanes::ZERO; 3], light, &mut Stage::default()),
            AnyField::I16(f) => shade.apply(simd, f, &at, &[Lanes::ZERO; 3], light, &mut Stage::default()),
            AnyField::F32(f) => shade.apply(simd, f, &at, &[Lanes::ZERO; 3], light, &mut Stage::default()),
        }
    }
}
