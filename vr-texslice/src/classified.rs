//! Textures of light, made from a volume: classified, and shaded, voxel by voxel.

use glam::DVec3;
use vr_core::parallel::each_part;
use vr_core::{GridVolume, ParameterError, RayShading, Scene, Shading, View, Voxel, with_grid};

use crate::slices::Slices;
use crate::texture_slicer::Format;

/// A texture of light, or of what a palette turns into light.
pub(crate) enum Classified {
    Rgba(Vec<[f32; 4]>),
    Luminance(Vec<[f32; 2]>),
    Indices { texels: Vec<u8>, palette: Box<[[f32; 4]; 256]>, reflections: Option<Reflections> },
}

/// Light reflected by each voxel of a palette's texture. A palette holds one colour for a value, so it cannot hold the colours of all orientations of a surface.
pub(crate) struct Reflections {
    seen: Seen,
    /// Factors on the three colours of a voxel, and the three lights that are added to an opaque one.
    pub(crate) texels: Vec<[f32; 6]>,
}

/// Index, of 256, that stands for a missing voxel.
const MISSING: u8 = 255;

/// Key of a texture of light: the length of a slab, and how a view sees voxels where they are shaded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TextureKey {
    pub(crate) length: f64,
    pub(crate) seen: Option<Seen>,
}

/// Rays along which voxels are seen, on which the light that they reflect depends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Seen {
    /// Parallel ones.
    Along(DVec3),
    /// Rays from an eye, a different one for each voxel.
    From(DVec3),
}

/// Shading of voxels in one view.
struct VoxelShading<'a> {
    scene: &'a Scene,
    volume: &'a GridVolume,
    shading: &'a Shading,
    rays: VoxelRays,
}

/// Rays along which voxels are seen, prepared for shading.
enum VoxelRays {
    /// Parallel rays share what is constant along each of them.
    Parallel(RayShading<f64>),
    /// Rays from an eye.
    From(DVec3),
}

impl<'a> VoxelShading<'a> {
    /// Makes the shading of a view; `None` where nothing is shaded.
    fn new(scene: &'a Scene, volume: &'a GridVolume, seen: Option<Seen>) -> Option<Self> {
        let (seen, shading) = (seen?, scene.reflection()?);
        let rays = match seen {
            Seen::Along(direction) => VoxelRays::Parallel(shading.along(&scene.lights, direction)),
            Seen::From(eye) => VoxelRays::From(eye),
        };
        Some(Self { scene, volume, shading, rays })
    }

    /// Factor on a voxel's colour, and light that is added to an opaque one.
    fn reflect(&self, index: [usize; 3]) -> ([f64; 3], [f64; 3]) {
        let placement = self.volume.placement();
        let gradient = self.volume.central_differences_at_sample(index);
        let world = placement.gradient_to_world(gradient.into()).to_array();
        match &self.rays {
            VoxelRays::Parallel(shading) => shading.reflect(world),
            VoxelRays::From(eye) => {
                let voxel = placement.to_world(DVec3::from_array(index.map(|i| i as f64)));
                // A voxel at the eye itself has no direction to it, and so no highlight.
                self.shading.along(&self.scene.lights, (voxel - *eye).normalize_or_zero()).reflect(world)
            }
        }
    }

    /// Light and opacity of a voxel, shaded.
    fn shade(&self, [r, g, b, alpha]: [f64; 4], index: [usize; 3]) -> [f64; 4] {
        // A clear voxel reflects nothing; vacuum is NaN.
        if alpha.is_nan() || alpha <= 0.0 {
            return [r, g, b, alpha];
        }
        let (factor, added) = self.reflect(index);
        let lit = |light: f64, c: usize| light * factor[c] + added[c] * alpha;
        [lit(r, 0), lit(g, 1), lit(b, 2), alpha]
    }
}

impl TextureKey {
    /// For a view.
    ///
    /// # Errors
    /// A camera that makes no sense.
    pub(crate) fn new(scene: &Scene, view: &View, slices: &Slices) -> Result<Self, ParameterError> {
        let camera = &view.camera;
        let forward = camera.frame()?.z_axis;
        let seen = if camera.projection.is_perspective() { Seen::From(camera.eye) } else { Seen::Along(forward) };
        Ok(Self { length: slices.table_length(), seen: scene.reflection().map(|_| seen) })
    }
}

impl Classified {
    /// Bytes that a volume takes in a format of light, shaded or not.
    pub(crate) fn bytes(format: Format, volume: &GridVolume, shaded: bool) -> u64 {
        let texel = match format {
            Format::Rgba => 16,
            Format::LuminanceAlpha => 8,
            _ if shaded => 1 + size_of::<[f32; 6]>() as u64,
            _ => 1,
        };
        volume.dims().iter().product::<usize>() as u64 * texel
    }

    /// Classifies every voxel for slabs of a length, or makes its index and a palette.
    pub(crate) fn new(format: Format, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Self {
        let shading = VoxelShading::new(scene, volume, made.seen);
        let light = |stored: f64, index: [usize; 3]| {
            let light = classified(scene, volume, made.length, stored);
            shading.as_ref().map_or(light, |shading| shading.shade(light, index)).map(|x| x as f32)
        };
        match format {
            Format::Rgba => Self::Rgba(each(volume, light)),
            Format::LuminanceAlpha => Self::Luminance(each(volume, |stored, index| {
                let [luminance, _, _, alpha] = light(stored, index);
                [luminance, alpha]
            })),
            _ => {
                let code = Codes::of(volume);
                let texels = each(volume, |stored, _| code.index(stored));
                let palette = code.palette(scene, volume, made.length);
                Self::Indices { texels, palette, reflections: Reflections::new(scene, volume, made.seen) }
            }
        }
    }

    /// Takes over a new transfer function, length or view where no voxel has to be read again; returns false where only the palette is new.
    pub(crate) fn recolor(&mut self, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> bool {
        let Self::Indices { palette, reflections, .. } = self else { return false };
        *palette = Codes::of(volume).palette(scene, volume, made.length);
        let serves = reflections.as_ref().map(|r| r.seen) == made.seen;
        if !serves {
            // The old ones go first: there may be no room for both.
            *reflections = None;
            *reflections = Reflections::new(scene, volume, made.seen);
        }
        !serves && made.seen.is_some()
    }

    /// Forgets the light that voxels reflect, after shading or lights have changed.
    pub(crate) fn forget_reflections(&mut self) {
        if let Self::Indices { reflections, .. } = self {
            *reflections = None;
        }
    }
}

impl Reflections {
    /// Makes them for a view; `None` where nothing is shaded.
    fn new(scene: &Scene, volume: &GridVolume, seen: Option<Seen>) -> Option<Self> {
        let shading = VoxelShading::new(scene, volume, seen)?;
        let texels = each(volume, |_, index| {
            let ([a, b, c], [d, e, f]) = shading.reflect(index);
            [a, b, c, d, e, f].map(|x| x as f32)
        });
        Some(Self { seen: seen?, texels })
    }
}

/// Light and opacity of a stored number and a slab, NaN where it is missing.
fn classified(scene: &Scene, volume: &GridVolume, length: f64, stored: f64) -> [f64; 4] {
    if stored.is_nan() { [f64::NAN; 4] } else { scene.transfer.step(volume.calibration().value(stored), length) }
}

/// Texels of light in f64, as the model has them: classified, and shaded.
pub(crate) struct ExactTexels<'a> {
    codes: Option<Codes>,
    shading: Option<VoxelShading<'a>>,
    scene: &'a Scene,
    volume: &'a GridVolume,
    length: f64,
}

impl<'a> ExactTexels<'a> {
    pub(crate) fn new(format: Format, scene: &'a Scene, volume: &'a GridVolume, made: &TextureKey) -> Self {
        let codes = (format == Format::Paletted).then(|| Codes::of(volume));
        Self { codes, shading: VoxelShading::new(scene, volume, made.seen), scene, volume, length: made.length }
    }

    /// Light and opacity of a voxel, NaN where it is missing.
    pub(crate) fn at(&self, stored: f64, index: [usize; 3]) -> [f64; 4] {
        let stored = self.codes.map_or(stored, |codes| codes.level(stored));
        let light = classified(self.scene, self.volume, self.length, stored);
        self.shading.as_ref().map_or(light, |shading| shading.shade(light, index))
    }
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
struct Codes {
    low: f64,
    step: f64,
    last: f64,
}

impl Codes {
    fn of(volume: &GridVolume) -> Self {
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
    fn palette(&self, scene: &Scene, volume: &GridVolume, length: f64) -> Box<[[f32; 4]; 256]> {
        let holes = volume.value_stats().has_missing();
        let entry = |i: usize| {
            let missing = holes && i == usize::from(MISSING);
            let stored = if missing { f64::NAN } else { self.low + i as f64 * self.step };
            classified(scene, volume, length, stored).map(|x| x as f32)
        };
        Box::new(std::array::from_fn(entry))
    }

    /// The stored number that stands for a given one in a palette.
    fn level(&self, stored: f64) -> f64 {
        if stored.is_nan() { stored } else { self.low + f64::from(self.index(stored)) * self.step }
    }
}
