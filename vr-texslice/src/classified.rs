//! Textures of light, made from a volume: classified, and shaded, voxel by voxel.

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::parallel::each_part;
use vr_core::{GridVolume, ParameterError, RayShading, Scene, Shading, View, Voxel, with_grid};

use crate::gradients::at_voxel;
use crate::medium::GradientMedium;
use crate::palette::{Codes, Levels, Palette};
use crate::region::Region;
use crate::slices::Slices;
use crate::texture_slicer::Format;

/// Texels of light, or of what a palette turns into light.
pub(crate) enum LightTexels {
    Rgba(Vec<[f32; 4]>),
    Luminance(Vec<[f32; 2]>),
    /// Indices into a palette; where voxels are shaded or have colours, factors on the three colours of each, and the three lights that are added to an opaque one. A
    /// palette holds one colour for a value, so it cannot hold the colours of all orientations of a surface, nor those of voxels themselves.
    /// If opacity follows the gradient, the level of its magnitude as well.
    Indices {
        indices: Vec<u8>,
        levels: Option<Vec<u8>>,
        reflections: Option<Vec<[f32; 6]>>,
    },
}

/// A volume's texture of light.
pub(crate) struct Classified {
    pub(crate) texels: LightTexels,
    /// Palette of indices.
    pub(crate) palette: Option<Palette>,
    /// Levels of the gradient's magnitude that indices have beside them.
    levels: Option<Levels>,
    /// Rays on which voxels reflect what indices have beside them; `None` where they have nothing.
    seen: Option<Seen>,
}

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

    /// Factor on the colour of a voxel with this world gradient, and light that is added to an opaque one.
    fn reflect(&self, world: DVec3, index: [usize; 3]) -> ([f64; 3], [f64; 3]) {
        match &self.rays {
            VoxelRays::Parallel(shading) => shading.reflect(world.to_array()),
            VoxelRays::From(eye) => {
                let voxel = self.volume.placement().to_world(DVec3::from_array(index.map(|i| i as f64)));
                // A voxel at the eye itself has no direction to it, and so no highlight.
                let along = (voxel - *eye).normalize_or_zero();
                self.shading.along(&self.scene.lights, along).reflect(world.to_array())
            }
        }
    }
}

/// Classification and shading of voxels, in f64.
pub(crate) struct VoxelOptics<'a> {
    scene: &'a Scene,
    volume: &'a GridVolume,
    length: f64,
    /// `None` where opacity follows no gradient.
    medium: Option<GradientMedium<'a>>,
    /// Codes and levels that stand for values and magnitudes, where a palette does.
    codes: Option<Codes>,
    levels: Option<Levels>,
    shading: Option<VoxelShading<'a>>,
}

impl<'a> VoxelOptics<'a> {
    pub(crate) fn new(format: Format, scene: &'a Scene, volume: &'a GridVolume, made: &TextureKey) -> Self {
        let medium = GradientMedium::new(scene, volume);
        let codes = (format == Format::Paletted).then(|| Codes::of(volume));
        let levels = medium.as_ref().filter(|_| codes.is_some()).map(Levels::of);
        let shading = VoxelShading::new(scene, volume, made.seen);
        Self { scene, volume, length: made.length, medium, codes, levels, shading }
    }

    /// Light and opacity of a voxel for a slab, NaN where it is missing.
    pub(crate) fn at(&self, stored: f64, index: [usize; 3]) -> [f64; 4] {
        let stored = self.codes.map_or(stored, |codes| codes.level(stored));
        if stored.is_nan() {
            return [f64::NAN; 4];
        }
        let value = self.volume.calibration().value(stored);
        let light = self.scene.transfer.step(value, self.length);
        // A clear voxel reflects nothing, and is clear at every gradient.
        let clear = light == [0.0; 4];
        if clear || self.medium.is_none() && self.shading.is_none() {
            return tinted(self.scene, light, index);
        }
        let world = at_voxel(self.volume, index);
        let light = self.medium.as_ref().map_or(light, |medium| {
            let magnitude = medium.magnitude(world);
            let magnitude = self.levels.map_or(magnitude, |levels| levels.magnitude(levels.level(magnitude)));
            medium.step(value, magnitude, self.length)
        });
        let light = tinted(self.scene, light, index);
        let Some(shading) = &self.shading else { return light };
        let ([r, g, b, alpha], (factor, added)) = (light, shading.reflect(world, index));
        let lit = |light: f64, c: usize| light * factor[c] + added[c] * alpha;
        [lit(r, 0), lit(g, 1), lit(b, 2), alpha]
    }
}

/// The colour of a voxel; white where voxels have none.
fn color(scene: &Scene, index: [usize; 3]) -> [f64; 3] {
    scene.volume.colors().map_or([1.0; 3], |colors| colors.color(index.map(|i| i as f64)))
}

/// Light of a voxel in its colour.
fn tinted(scene: &Scene, [r, g, b, alpha]: [f64; 4], index: [usize; 3]) -> [f64; 4] {
    let [x, y, z] = color(scene, index);
    [r * x, g * y, b * z, alpha]
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
    /// Bytes of a texel in a format of light, shaded or of a colour of its own or neither, whose opacity follows the gradient or not.
    pub(crate) fn texel_bytes(format: Format, shaded: bool, follows: bool) -> u64 {
        match format {
            Format::Rgba => 16,
            Format::LuminanceAlpha => 8,
            _ => 1 + u64::from(follows) + if shaded { size_of::<[f32; 6]>() as u64 } else { 0 },
        }
    }

    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        let bytes = match self {
            Self::Rgba(texels) => size_of_val(&texels[..]),
            Self::Luminance(texels) => size_of_val(&texels[..]),
            Self::Indices { indices, levels, reflections } => {
                let beside = reflections.as_ref().map_or(0, |reflections| size_of_val(&reflections[..]));
                indices.len() + levels.as_ref().map_or(0, Vec::len) + beside
            }
        };
        bytes as u64
    }

    /// Classifies voxels for slabs of a length, or finds their indices.
    pub(crate) fn new(format: Format, scene: &Scene, volume: &GridVolume, made: &TextureKey, region: &Region) -> Self {
        let optics = VoxelOptics::new(format, scene, volume, made);
        let light = |stored: f64, index: [usize; 3]| optics.at(stored, index).map(|x| x as f32);
        match format {
            Format::Rgba => Self::Rgba(each(volume, region, light)),
            Format::LuminanceAlpha => Self::Luminance(each(volume, region, |stored, index| {
                let [luminance, _, _, alpha] = light(stored, index);
                [luminance, alpha]
            })),
            _ => {
                let code = Codes::of(volume);
                let medium = GradientMedium::new(scene, volume);
                let levels = medium.as_ref().map(|medium| (medium, Levels::of(medium)));
                Self::Indices {
                    indices: each(volume, region, |stored, _| code.index(stored)),
                    levels: levels.map(|(medium, levels)| {
                        each(volume, region, |_, index| levels.level(medium.magnitude(at_voxel(volume, index))))
                    }),
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
pub(crate) fn palette(format: Format, scene: &Scene, volume: &GridVolume, length: f64) -> Option<Palette> {
    (format == Format::Paletted).then(|| Codes::of(volume).palette(scene, volume, length))
}

/// Levels that a format keeps beside indices; `None` of formats that keep none, and where opacity follows no gradient.
pub(crate) fn levels(format: Format, scene: &Scene, volume: &GridVolume) -> Option<Levels> {
    GradientMedium::new(scene, volume).filter(|_| format == Format::Paletted).as_ref().map(Levels::of)
}

impl Classified {
    /// Bytes that a volume takes in a format of light.
    pub(crate) fn bytes(format: Format, scene: &Scene, volume: &GridVolume) -> u64 {
        let shaded = scene.reflection().is_some() || scene.volume.has_colors();
        let follows = scene.has_gradient_opacity();
        volume.dims().iter().product::<usize>() as u64 * LightTexels::texel_bytes(format, shaded, follows)
    }

    /// Classifies every voxel for slabs of a length, or makes its index and a palette.
    pub(crate) fn new(format: Format, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Self {
        let texels = LightTexels::new(format, scene, volume, made, &Region::whole(volume.dims()));
        let (palette, levels) = (palette(format, scene, volume, made.length), levels(format, scene, volume));
        Self { texels, palette, levels, seen: made.seen }
    }

    /// Takes over a new transfer function, length or view where no voxel has to be read again; returns true if what voxels reflect is new, false where only the
    /// palette is; `None` if every voxel has to be classified again.
    pub(crate) fn recolor(&mut self, scene: &Scene, volume: &GridVolume, made: &TextureKey) -> Option<bool> {
        let LightTexels::Indices { reflections: kept, .. } = &mut self.texels else { return None };
        if self.levels != levels(Format::Paletted, scene, volume) {
            return None;
        }
        self.palette = palette(Format::Paletted, scene, volume, made.length);
        // Forgotten ones may be those of colours alone.
        let serves = self.seen == made.seen && (kept.is_some() || !scene.volume.has_colors());
        if !serves {
            // The old ones go first: there may be no room for both.
            *kept = None;
            *kept = reflections(scene, volume, made.seen, &Region::whole(volume.dims()));
            self.seen = made.seen;
        }
        Some(!serves && kept.is_some())
    }

    /// Forgets the light that voxels reflect, after shading or lights have changed.
    pub(crate) fn forget_reflections(&mut self) {
        if let LightTexels::Indices { reflections, .. } = &mut self.texels {
            (*reflections, self.seen) = (None, None);
        }
    }
}

/// Factors and light of voxels by their colours and by what they reflect in a view; `None` where nothing is shaded and voxels have no colours.
fn reflections(scene: &Scene, volume: &GridVolume, seen: Option<Seen>, region: &Region) -> Option<Vec<[f32; 6]>> {
    let shading = VoxelShading::new(scene, volume, seen);
    if shading.is_none() && !scene.volume.has_colors() {
        return None;
    }
    Some(each(volume, region, |_, index| {
        let reflect = |shading: &VoxelShading<'_>| shading.reflect(at_voxel(volume, index), index);
        let ([a, b, c], [d, e, f]) = shading.as_ref().map_or(([1.0; 3], [0.0; 3]), reflect);
        let [x, y, z] = color(scene, index);
        [a * x, b * y, c * z, d, e, f].map(|x| x as f32)
    }))
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
