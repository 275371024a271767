//! Gradients' part in what is classified sheet by sheet: light that is reflected, and opacity that follows their magnitude.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::{AnyGrid, Calibration, GradientMethod, GridVolume, Scene, Shading, UniformGrid, Voxel};
use vr_kernels::vector::{
    Field, LANES, Lanes, Modulation, PacketLights, PacketShading, Shade, Stage, StepOptics, splat,
};

use crate::gradient_optics::GradientOptics;
use crate::kernel::{Shape, SplatKernel};
use crate::kernel_sum::KernelSum;
use crate::splatter::Splatter;

/// The scene's optics by gradients, and the samples that gradients come from.
pub(crate) struct Shader<'a> {
    optics: GradientOptics<'a>,
    pub(crate) packet: PacketShading,
    gradients: Gradients,
    volume: &'a GridVolume,
    /// From stored numbers, as they are splatted, to values.
    calibration: Calibration,
    field: AnyField<'a>,
}

/// Homogeneous pieces of sixteen rays.
pub(crate) struct Pieces {
    /// Places in index space.
    pub(crate) place: [Lanes; 3],
    /// Stored numbers, as they are splatted.
    pub(crate) value: Lanes,
    /// World lengths.
    pub(crate) length: Lanes,
    /// The table's rows of the values, and lengths in its unit; `None` where they were classified one by one, or opacity is what it is.
    pub(crate) optics: Option<StepOptics>,
}

/// The samples, whatever they are.
enum AnyField<'a> {
    U8(Field<'a, u8>),
    I8(Field<'a, i8>),
    U16(Field<'a, u16>),
    I16(Field<'a, i16>),
    F32(Field<'a, f32>),
}

/// Calls an expression with the field in an [`AnyField`].
macro_rules! with_field {
    ($any:expr, $field:ident => $call:expr) => {
        match $any {
            AnyField::U8($field) => $call,
            AnyField::I8($field) => $call,
            AnyField::U16($field) => $call,
            AnyField::I16($field) => $call,
            AnyField::F32($field) => $call,
        }
    };
}

impl<'a> Shader<'a> {
    /// Shader of a scene whose light depends on gradients.
    pub(crate) fn new(
        renderer: &Splatter,
        scene: &'a Scene,
        volume: &'a GridVolume,
        calibration: Calibration,
    ) -> Option<Self> {
        let optics = GradientOptics::new(scene)?;
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
        let packet = packet_shading(&optics, scene, volume);
        let gradients = Gradients::new(&optics.shading, renderer, volume);
        Some(Self { optics, packet, gradients, volume, calibration, field })
    }

    /// True if opacity follows the gradient.
    pub(crate) fn follows(&self) -> bool {
        self.optics.follows
    }

    /// Shades light and opacity of pieces that were classified by their values alone.
    #[inline(always)]
    pub(crate) fn shade<S: Simd>(&self, simd: S, lights: &PacketLights, pieces: &Pieces, light: &mut [Lanes; 4]) {
        let shade = Shade { shading: &self.packet, lights };
        let vectors = matches!(self.gradients, Gradients::CentralDifferences)
            && (!self.optics.follows || self.packet.modulation.is_some() && pieces.optics.is_some());
        if !vectors {
            let gradient = self.one_by_one(pieces, light);
            if self.optics.reflects {
                shade.apply_to_gradients(simd, &gradient, light);
            }
            return;
        }
        if !light[3].load(simd).simd_gt(splat(simd, 0.0)).any_true() {
            return;
        }
        let at = with_field!(&self.field, f => cells(f.last_cell, &pieces.place));
        let none = [Lanes::ZERO; 3];
        match &pieces.optics {
            Some(optics) if self.optics.follows => {
                with_field!(&self.field, f => shade.apply_modulated(simd, f, &at, &none, optics, light, &mut Stage::default()));
            }
            _ => with_field!(&self.field, f => shade.apply(simd, f, &at, &none, light, &mut Stage::default())),
        }
    }

    /// Makes the light of pieces whose opacity follows the gradient anew, before it reflects; returns the gradients per index step.
    #[inline(never)]
    fn one_by_one(&self, pieces: &Pieces, light: &mut [Lanes; 4]) -> [Lanes; 3] {
        let mut gradients = [Lanes::ZERO; 3];
        let last = self.volume.dims().map(|n| (n - 1) as f64);
        for i in 0..LANES {
            // Where the value alone is clear, every gradient is.
            if (0..4).all(|c| light[c].0[i] == 0.0) {
                continue;
            }
            let place = std::array::from_fn(|a| f64::from(pieces.place[a].0[i]).clamp(0.0, last[a]));
            let gradient = self.gradients.at(self.volume, place);
            for a in 0..3 {
                gradients[a].0[i] = gradient[a] as f32;
            }
            if self.optics.follows {
                let value = self.calibration.value(f64::from(pieces.value.0[i]));
                let magnitude = world_gradient(self.volume, gradient).length();
                let step = self.optics.step(value, magnitude, f64::from(pieces.length.0[i]));
                for c in 0..4 {
                    light[c].0[i] = step[c] as f32;
                }
            }
        }
        gradients
    }
}

/// Shading in the form that vectors take, for gradients per index step of a grid in stored units.
pub(crate) fn packet_shading(optics: &GradientOptics<'_>, scene: &Scene, volume: &GridVolume) -> PacketShading {
    let (matrix, scale) = volume.placement().scaled_gradient_matrix(volume.calibration().slope);
    PacketShading {
        shading: optics.shading.clone(),
        lights: scene.lights.clone(),
        to_world: std::array::from_fn(|a| matrix.row(a).to_array().map(|x| x as f32)),
        modulation: Modulation::new(&optics.shading, scale),
        reflects: optics.reflects,
    }
}

/// Source of gradients.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Gradients {
    /// Central differences at the voxels.
    CentralDifferences,
    /// The field of the grid's filter.
    Filter,
    /// The sum of kernels that were asked for in its place.
    KernelSum(KernelSum),
}

impl Gradients {
    /// The source that a shading asks for, of voxels that a renderer spreads by its kernel.
    pub(crate) fn new(shading: &Shading, renderer: &Splatter, volume: &GridVolume) -> Self {
        let own = SplatKernel::new(Shape::of_filter(volume.filter()));
        match shading.gradient {
            GradientMethod::CentralDifferences => Self::CentralDifferences,
            GradientMethod::Analytic if renderer.kernel == own => Self::Filter,
            GradientMethod::Analytic => Self::KernelSum(KernelSum::new(&renderer.kernel)),
        }
    }

    /// Gradient per index step at a place in a grid, in stored units.
    pub(crate) fn at(&self, volume: &GridVolume, place: [f64; 3]) -> [f64; 3] {
        match self {
            Self::CentralDifferences => volume.central_differences_at(place),
            Self::Filter => volume.stored_and_gradient_at(place).1,
            Self::KernelSum(sum) => sum.gradient_at(volume, place),
        }
    }
}

/// Gradient in value per world unit of one per index step in stored units.
pub(crate) fn world_gradient(volume: &GridVolume, per_index: [f64; 3]) -> DVec3 {
    volume.placement().gradient_to_world(DVec3::from(per_index)) * volume.calibration().slope
}

/// Cells of places in index space, and fractions in them.
#[inline(always)]
fn cells(last: [i32; 3], place: &[Lanes; 3]) -> [[Lanes; 3]; 2] {
    let mut at = [[Lanes::ZERO; 3]; 2];
    for a in 0..3 {
        for i in 0..LANES {
            let x = place[a].0[i].max(0.0).min((last[a] + 1) as f32);
            let cell = (x as i32).min(last[a]) as f32;
            (at[0][a].0[i], at[1][a].0[i]) = (cell, x - cell);
        }
    }
    at
}
