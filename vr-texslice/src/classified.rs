//! Textures of light, made from a volume: classified, and shaded, voxel by voxel.

use vr_core::filter::Lattice;
use vr_core::parallel::each_part;
use vr_core::{GridVolume, ParameterError, Scene, View, Voxel, gradient_at_sample, with_grid};

use crate::slices::Slices;
use crate::texture_slicer::Format;

/// A texture of light, or of what a palette turns into light.
pub(crate) enum Classified {
    Rgba(Vec<[f32; 4]>),
    Luminance(Vec<[f32; 2]>),
    Indices { texels: Vec<u8>, palette: Box<[[f32; 4]; 256]> },
}

/// Index, of 256, that stands for a missing voxel.
const MISSING: u8 = 255;

/// Key of a texture of light: the length of a slab, and the direction of a view where something is shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TextureKey {
    pub(crate) length: f64,
    pub(crate) forward: Option<[f64; 3]>,
}

impl TextureKey {
    /// For a view.
    ///
    /// # Errors
    /// A camera that makes no sense.
    pub(crate) fn new(format: Format, scene: &Scene, view: &View, slices: &Slices) -> Result<Self, ParameterError> {
        let forward = view.camera.frame()?.z_axis.to_array();
        let forward = is_shaded(format, scene).then_some(forward);
        Ok(Self { length: slices.table_length(), forward })
    }
}

impl Classified {
    /// Bytes that a volume takes in a format of light.
    pub(crate) fn bytes(format: Format, volume: &GridVolume) -> u64 {
        let texel = match format {
            Format::Rgba => 16,
            Format::LuminanceAlpha => 8,
            _ => 1,
        };
        volume.dims().iter().product::<usize>() as u64 * texel
    }

    /// Classifies every voxel for slabs of a length, or makes its index and a palette.
    pub(crate) fn new(format: Format, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Self {
        let light = |stored: f64, index: [usize; 3]| texel_light(scene, volume, made, stored, index);
        match format {
            Format::Rgba => Self::Rgba(each(volume, light)),
            Format::LuminanceAlpha => Self::Luminance(each(volume, |stored, index| {
                let [luminance, _, _, alpha] = light(stored, index);
                [luminance, alpha]
            })),
            _ => {
                let code = Codes::of(volume);
                let texels = each(volume, |stored, _| code.index(stored));
                Self::Indices { texels, palette: code.palette(scene, volume, made) }
            }
        }
    }

    /// Takes a new transfer function or length over, where that needs no look at voxels.
    pub(crate) fn recolor(&mut self, scene: &Scene, volume: &GridVolume, made: &TextureKey) {
        if let Self::Indices { palette, .. } = self {
            *palette = Codes::of(volume).palette(scene, volume, made);
        }
    }
}

/// Light and opacity of a voxel, NaN where it is missing.
pub(crate) fn texel_light(
    scene: &Scene,
    volume: &GridVolume,
    made: &TextureKey,
    stored: f64,
    index: [usize; 3],
) -> [f32; 4] {
    if stored.is_nan() {
        return [f32::NAN; 4];
    }
    let light = scene.transfer.step(volume.calibration().value(stored), made.length);
    let (Some(forward), Some(shading), true) = (made.forward, &scene.shading, light[3] > 0.0) else {
        return light.map(|c| c as f32);
    };
    fn gradient<T: Voxel>(lattice: &Lattice<'_, T>, index: [usize; 3]) -> [f64; 3] {
        gradient_at_sample::<T, f64>(lattice, index)
    }
    let gradient = with_grid!(volume.values(), g => {
        gradient(&Lattice { samples: g.samples(), dims: g.dims() }, index)
    });
    let world = volume.placement().gradient_to_world(gradient.into());
    shading.along(&scene.lights, forward.into()).shade(light, world.to_array()).map(|x| x as f32)
}

/// True if voxels are shaded, which a view's direction is needed for.
pub(crate) fn is_shaded(format: Format, scene: &Scene) -> bool {
    matches!(format, Format::Rgba | Format::LuminanceAlpha) && scene.reflection().is_some()
}

/// One texel for every sample, from its stored number and its index.
fn each<X: Send + Copy + Default>(volume: &GridVolume, texel: impl Fn(f64, [usize; 3]) -> X + Sync) -> Vec<X> {
    fn fill<T: Voxel, X: Send>(
        samples: &[T],
        dims: [usize; 3],
        out: &mut [X],
        texel: impl Fn(f64, [usize; 3]) -> X + Sync,
    ) {
        each_part(out.chunks_mut(dims[0]).zip(samples.chunks(dims[0])), |row, (out, samples)| {
            for (x, (out, s)) in out.iter_mut().zip(*samples).enumerate() {
                *out = texel(f64::from(s.to_f32()), [x, row % dims[1], row / dims[1]]);
            }
        });
    }
    let mut all = vec![X::default(); volume.dims().iter().product()];
    with_grid!(volume.values(), g => fill(g.samples(), g.dims(), &mut all, texel));
    all
}

/// Indices of stored numbers: bytes as they are; anything else by the nearest of 255 levels over its range, one index standing for missing voxels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Codes {
    low: f64,
    step: f64,
    last: f64,
}

impl Codes {
    pub(crate) fn of(volume: &GridVolume) -> Self {
        let (low, high) = volume.value_stats().range.map_or((0.0, 0.0), |(l, h)| (f64::from(l), f64::from(h)));
        if volume.voxel_type().is_integer() && high - low <= 255.0 {
            return Self { low, step: 1.0, last: 255.0 };
        }
        let last = f64::from(MISSING - 1);
        Self { low, step: if high > low { (high - low) / last } else { 1.0 }, last }
    }

    fn index(&self, stored: f64) -> u8 {
        if stored.is_nan() { MISSING } else { ((stored - self.low) / self.step + 0.5).clamp(0.0, self.last) as u8 }
    }

    /// Light and opacity of every index.
    fn palette(&self, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Box<[[f32; 4]; 256]> {
        let holes = volume.value_stats().has_missing();
        let entry = |i: usize| {
            let missing = holes && i == usize::from(MISSING);
            let stored = if missing { f64::NAN } else { self.low + i as f64 * self.step };
            texel_light(scene, volume, &TextureKey { forward: None, ..*made }, stored, [0; 3])
        };
        Box::new(std::array::from_fn(entry))
    }

    /// The light that a palette has for a stored number.
    pub(crate) fn light(&self, scene: &Scene, volume: &GridVolume, made: &TextureKey, stored: f64) -> [f32; 4] {
        let level = if stored.is_nan() { stored } else { self.low + f64::from(self.index(stored)) * self.step };
        texel_light(scene, volume, &TextureKey { forward: None, ..*made }, level, [0; 3])
    }
}
