//! Shading of values, by gradients from the grid itself.

use std::sync::Arc;

use fearless_simd::Simd;
use glam::DVec3;
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
    /// Of a scene whose light is shaded.
    pub(crate) fn new(scene: &Scene, volume: &'a GridVolume) -> Option<Self> {
        let shading = Arc::clone(scene.shading.as_ref().filter(|_| is_shaded(scene))?);
        // A gradient's length does not matter: scaled to 1, so that worlds of any scale neither overflow nor vanish.
        let matrix = volume.placement().inverse_axes().transpose();
        let largest = matrix.to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let to_world = std::array::from_fn(|row| std::array::from_fn(|a| (matrix.col(a)[row] / largest) as f32));
        fn field<T: Voxel>(grid: &UniformGrid<T>) -> Field<'_, T> {
            Field::new(&Lattice { samples: grid.samples(), dims: grid.dims() })
        }
        let field = match volume.values() {
            AnyGrid::U8(grid) => AnyField::U8(field(grid)),
            AnyGrid::I8(grid) => AnyField::I8(field(grid)),
            AnyGrid::U16(grid) => AnyField::U16(field(grid)),
            AnyGrid::I16(grid) => AnyField::I16(field(grid)),
            AnyGrid::F32(grid) => AnyField::F32(field(grid)),
        };
        Some(Self { shading: PacketShading { shading, lights: scene.lights.clone(), to_world }, field })
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
            AnyField::U8(f) => shade.apply(simd, f, &at, light, &mut Stage::default()),
            AnyField::I8(f) => shade.apply(simd, f, &at, light, &mut Stage::default()),
            AnyField::U16(f) => shade.apply(simd, f, &at, light, &mut Stage::default()),
            AnyField::I16(f) => shade.apply(simd, f, &at, light, &mut Stage::default()),
            AnyField::F32(f) => shade.apply(simd, f, &at, light, &mut Stage::default()),
        }
    }
}

/// Whether light is shaded at all: emission that is given on its own is not.
pub(crate) fn is_shaded(scene: &Scene) -> bool {
    scene.shading.is_some() && scene.compositing.integrates_light() && !scene.transfer.has_emission()
}

/// The most light that anything behind what is opaque may send, for colours up to 1 or less: 1.
pub(crate) fn brightest(scene: &Scene) -> f64 {
    if scene.transfer.has_emission() {
        let (low, high) = scene.volume.bounds();
        return (scene.transfer.brightest_emission() * DVec3::distance(low, high)).max(1.0);
    }
    let color = scene.transfer.brightest_color();
    let Some(shading) = scene.shading.as_ref().filter(|_| is_shaded(scene)) else { return color.max(1.0) };
    let light = |c: usize| scene.lights.iter().map(|l| l.color[c]).sum::<f64>();
    let lights = light(0).max(light(1)).max(light(2));
    // Where the gradient is zero, the colour stays.
    (color * (shading.ambient + shading.diffuse * lights).max(1.0) + shading.specular * lights).max(1.0)
}
