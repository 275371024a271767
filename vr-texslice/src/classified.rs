//! Textures of light, made from a volume: classified, and shaded, voxel by voxel.

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::parallel::each_part;
use vr_core::{GridVolume, ParameterError, RayShading, Scene, Shading, View, Voxel, with_grid};

use crate::region::Region;
use crate::slices::Slices;
use crate::texture_slicer::Format;

/// Texels of light, or of what a palette turns into light.
pub(crate) enum LightTexels {
    Rgba(Vec<[f32; 4]>),
    Luminance(Vec<[f32; 2]>),
    /// Indices into a palette; where voxels are shaded, factors on the three colours of each, and the three lights that are added to an opaque one. A palette
    /// holds one colour for a value, so it cannot hold the colours of all orientations of a surface.
    Indices {
        indices: Vec<u8>,
        reflections: Option<Vec<[f32; 6]>>,
    },
}

/// Light and opacity of every index.
pub(crate) type Palette = [[f32; 4]; 256];

/// A volume's texture of light.
pub(crate) struct Classified {
    pub(crate) texels: LightTexels,
    /// Palette of indices.
    pub(crate) palette: Option<Box<Palette>>,
    /// Rays on which voxels reflect what indices have beside them; `None` where they have nothing.
    seen: Option<Seen>,
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

impl LightTexels {
    /// Bytes of a texel in a format of light, shaded or not.
    pub(crate) fn texel_bytes(format: Format, shaded: bool) -> u64 {
        match format {
            Format::Rgba => 16,
            Format::LuminanceAlpha => 8,
            _ if shaded => 1 + size_of::<[f32; 6]>() as u64,
            _ => 1,
        }
    }

    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        let bytes = match self {
            Self::Rgba(texels) => size_of_val(&texels[..]),
            Self::Luminance(texels) => size_of_val(&texels[..]),
            Self::Indices { indices, reflections } => {
                indices.len() + reflections.as_ref().map_or(0, |reflections| size_of_val(&reflections[..]))
            }
        };
        bytes as u64
    }

    /// Classifies voxels for slabs of a length, or finds their indices.
    pub(crate) fn new(format: Format, scene: &Scene, volume: &GridVolume, made: &TextureKey, region: &Region) -> Self {
        let shading = VoxelShading::new(scene, volume, made.seen);
        let light = |stored: f64, index: [usize; 3]| {
            let light = classified(scene, volume, made.length, stored);
            shading.as_ref().map_or(light, |shading| shading.shade(light, index)).map(|x| x as f32)
        };
        match format {
            Format::Rgba => Self::Rgba(each(volume, region, light)),
            Format::LuminanceAlpha => Self::Luminance(each(volume, region, |stored, index| {
                let [luminance, _, _, alpha] = light(stored, index);
                [luminance, alpha]
            })),
            _ => {
                let code = Codes::of(volume);
                Self::Indices {
                    indices: each(volume, region, |stored, _| code.index(stored)),
                    reflections: reflections(scene, volume, made.seen, region),
                }
            }
        }
    }
}

/// Largest distance from a stored number to the one that a format classifies in its place.
pub(crate) fn max_code_error(format: Format, volume: &GridVolume) -> f32 {
    if format == Format::Paletted { Codes::of(volume).max_error() as f32 } else { 0.0 }
}

/// The palette of a format, for slabs of a length; `None` of formats that have none.
pub(crate) fn palette(format: Format, scene: &Scene, volume: &GridVolume, length: f64) -> Option<Box<Palette>> {
    (format == Format::Paletted).then(|| Codes::of(volume).palette(scene, volume, length))
}

impl Classified {
    /// Bytes that a volume takes in a format of light, shaded or not.
    pub(crate) fn bytes(format: Format, volume: &GridVolume, shaded: bool) -> u64 {
        volume.dims().iter().product::<usize>() as u64 * LightTexels::texel_bytes(format, shaded)
    }

    /// Classifies every voxel for slabs of a length, or makes its index and a palette.
    pub(crate) fn new(format: Format, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Self {
        let texels = LightTexels::new(format, scene, volume, made, &Region::whole(volume.dims()));
        Self { texels, palette: palette(format, scene, volume, made.length), seen: made.seen }
    }

    /// Takes over a new transfer function, length or view where no voxel has to be read again; returns true if what voxels reflect is new, false where only the
    /// palette is; `None` if every voxel has to be classified again.
    pub(crate) fn recolor(&mut self, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Option<bool> {
        let LightTexels::Indices { reflections: kept, .. } = &mut self.texels else { return None };
        self.palette = palette(Format::Paletted, scene, volume, made.length);
        let serves = self.seen == made.seen;
        if !serves {
            // The old ones go first: there may be no room for both.
            *kept = None;
            *kept = reflections(scene, volume, made.seen, &Region::whole(volume.dims()));
            self.seen = made.seen;
        }
        Some(!serves && made.seen.is_some())
    }

    /// Forgets the light that voxels reflect, after shading or lights have changed.
    pub(crate) fn forget_reflections(&mut self) {
        if let LightTexels::Indices { reflections, .. } = &mut self.texels {
            (*reflections, self.seen) = (None, None);
        }
    }
}

/// Light that voxels reflect in a view; `None` where nothing is shaded.
fn reflections(scene: &Scene, volume: &GridVolume, seen: Option<Seen>, region: &Region) -> Option<Vec<[f32; 6]>> {
    let shading = VoxelShading::new(scene, volume, seen)?;
    Some(each(volume, region, |_, index| {
        let ([a, b, c], [d, e, f]) = shading.reflect(index);
        [a, b, c, d, e, f].map(|x| x as f32)
    }))
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

/// One texel for every sample of a region, from its stored number and its index.
fn each<X: Send + Copy + Default>(
    volume: &GridVolume,
    region: &Region,
    texel: impl Fn(f64, [usize; 3]) -> X + Sync,
) -> Vec<X> {
    fn fill<T: Voxel, X: Send>(
        lattice: &Lattice<'_, T>,
        region: &Region,
        out: &mut [X],
        texel: impl Fn(f64, [usize; 3]) -> X + Sync,
    ) {
        each_part(out.chunks_mut(region.dims[0]), |row, out| {
            let [first, y, z] = region.row(row);
            let from = lattice.offset(first, y, z);
            for (i, (out, s)) in out.iter_mut().zip(&lattice.samples[from..]).enumerate() {
                *out = texel(f64::from(s.to_f32()), [first + i, y, z]);
            }
        });
    }
    let mut all = vec![X::default(); region.count()];
    with_grid!(volume.values(), g => {
        fill(&Lattice { samples: g.samples(), dims: g.dims() }, region, &mut all, texel);
    });
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
    fn palette(&self, scene: &Scene, volume: &GridVolume, length: f64) -> Box<Palette> {
        let holes = volume.value_stats().has_missing();
        let entry = |i: usize| {
            let missing = holes && i == usize::from(MISSING);
            let stored = if missing { f64::NAN } else { self.low + i as f64 * self.step };
            classified(scene, volume, length, stored).map(|x| x as f32)
        };
        Box::new(std::array::from_fn(entry))
    }

    /// Largest distance from a stored number to the one that stands for it.
    fn max_error(&self) -> f64 {
        if self.last == 255.0 { 0.0 } else { 0.5 * self.step }
    }

    /// The stored number that stands for a given one in a palette.
    fn level(&self, stored: f64) -> f64 {
        if stored.is_nan() { stored } else { self.low + f64::from(self.index(stored)) * self.step }
    }
}
