//! The renderer's model for any ray, in f64: a sample for each slab, without tables.

use std::sync::Arc;

use glam::DVec3;
use vr_core::optics::opacity_of_thickness;
use vr_core::{
    Control, DiscreteModel, GridVolume, IndexRay, Layer, Ray, Rays, RenderError, Scene, SegmentTerm, View, Voxel,
};
use vr_kernels::tables::PreIntegrated;

use crate::classified::{TextureKey, VoxelOptics};
use crate::compression::Compressed;
use crate::gradients::ExactGradients;
use crate::medium::GradientMedium;
use crate::slices::{Slabs, Slices};
use crate::tables::{segments, segments_of_rows};
use crate::texel_cell::texel_cell;
use crate::texture_slicer::TextureSlicer;

/// The sum over slabs.
pub(crate) struct SliceModel {
    renderer: TextureSlicer,
    scene: Scene,
    view: View,
    layer: Option<Layer>,
    volume: Arc<GridVolume>,
    rays: Rays,
    slices: Slices,
    segments: Option<PreIntegrated<f64>>,
    /// Segments of each row of a transfer function by gradient.
    row_segments: Vec<PreIntegrated<f64>>,
    compressed: Option<Arc<Compressed>>,
    /// Key of the texels of light.
    made: Option<TextureKey>,
}

impl SliceModel {
    pub(crate) fn new(
        renderer: &TextureSlicer,
        (scene, volume): (&Scene, &Arc<GridVolume>),
        view: &View,
        compressed: Option<Arc<Compressed>>,
    ) -> Result<Self, RenderError> {
        let on_faces = renderer.is_pre_integrated();
        let slices = Slices::new(renderer, view, volume.placement(), volume.dims(), on_faces)?;
        let made = if renderer.holds_light() { Some(TextureKey::new(scene, view, &slices)?) } else { None };
        Ok(Self {
            renderer: renderer.clone(),
            scene: scene.clone(),
            layer: scene.layer(view, &Control::default())?,
            view: view.clone(),
            volume: Arc::clone(volume),
            rays: Rays::new(view)?,
            slices,
            segments: renderer.is_pre_integrated().then(|| segments(&scene.transfer, volume)),
            row_segments: if renderer.is_pre_integrated() { segments_of_rows(scene, volume) } else { Vec::new() },
            compressed,
            made,
        })
    }
}

impl DiscreteModel for SliceModel {
    fn segments(&self, x: f64, y: f64) -> Vec<SegmentTerm> {
        let Self { volume, rays, slices, .. } = self;
        let ray = rays.at(x, y);
        let far = self.layer.as_ref().map_or(f64::INFINITY, |layer| {
            let [w, h] = self.view.size.map(|n| n as usize);
            layer.depth((y as usize).min(h - 1) * w + (x as usize).min(w - 1))
        });
        let Some(part) = IndexRay::new(&ray, volume.placement(), volume.dims(), &self.view.clip, far) else {
            return Vec::new();
        };
        let coordinate = slices.coordinate(part.origin.to_array(), part.direction.to_array(), part.offset);
        let slabs = Slabs::new(coordinate, part.start, part.end);
        let along = Along { model: self, slices, volume, ray: &ray, part: &part };
        let terms = (0..slabs.count()).map(|k| {
            let [begin, end] = slabs.part(slabs.first + k as f64);
            let length = slices.ratio(end - begin, slabs.slope) * slices.table_length();
            let [r, g, b, alpha] = along.fragment([begin, end], length);
            SegmentTerm { transparency: 1.0 - alpha, light: [r, g, b] }
        });
        terms.collect()
    }
}

/// One ray of a model.
struct Along<'a> {
    model: &'a SliceModel,
    slices: &'a Slices,
    volume: &'a GridVolume,
    ray: &'a Ray,
    part: &'a IndexRay,
}

impl Along<'_> {
    /// Index of a distance, inside the box.
    fn place(&self, s: f64) -> [f64; 3] {
        let (dims, at) = (self.volume.dims(), self.part.at(s).to_array());
        std::array::from_fn(|a| at[a].clamp(0.0, (dims[a] - 1) as f64))
    }

    /// Index at which the texture is read for a distance.
    fn index(&self, s: f64) -> [f64; 3] {
        let (dims, mut at) = (self.volume.dims(), self.place(s));
        if let Some(axis) = self.slices.axis() {
            // Between the slices of a stack there is nothing.
            let per_layer = f64::from(self.model.renderer.per_layer());
            at[axis] = ((at[axis] * per_layer + 0.5).floor() / per_layer).min((dims[axis] - 1) as f64);
        }
        at
    }

    fn stored(&self, s: f64) -> f64 {
        if let Some(compressed) = &self.model.compressed {
            return compressed.value_at(self.volume, self.index(s));
        }
        self.volume.stored_at(self.index(s))
    }

    /// Linear between the eight texels around a distance, or the nearest of them.
    fn between_texels<const N: usize>(&self, s: f64, texel: impl Fn([usize; 3]) -> [f64; N]) -> [f64; N] {
        let Some((cell, fraction)) = texel_cell(self.volume, self.index(s)) else { return [f64::NAN; N] };
        let mut sum = [0.0; N];
        for corner in 0..8 {
            let high = |a: usize| corner >> a & 1;
            let part = |a: usize| if high(a) == 1 { fraction[a] } else { 1.0 - fraction[a] };
            let value = texel(std::array::from_fn(|a| cell[a] + high(a)));
            (0..N).for_each(|c| sum[c] += part(0) * part(1) * part(2) * value[c]);
        }
        sum
    }

    /// Light and opacity of a slab, from texels that hold those of one as long as tables are made for.
    fn light(&self, s: f64, made: &TextureKey, length: f64) -> [f64; 4] {
        let (scene, volume) = (&self.model.scene, self.volume);
        let dims = volume.dims();
        let texels = VoxelOptics::new(self.model.renderer.format, scene, volume, made);
        let texel = |index: [usize; 3]| {
            fn number<T: Voxel>(samples: &[T], at: usize) -> f64 {
                samples[at].to_f32().into()
            }
            let at = (index[2] * dims[1] + index[1]) * dims[0] + index[0];
            let stored = vr_core::with_grid!(volume.values(), g => number(g.samples(), at));
            texels.at(stored, index)
        };
        let [r, g, b, alpha] = self.between_texels(s, texel);
        if alpha.is_nan() {
            return [0.0; 4];
        }
        let ratio = length / made.length;
        let corrected = opacity_of_thickness(alpha, ratio);
        let share = if alpha > 0.0 { corrected / alpha } else { ratio };
        [r * share, g * share, b * share, corrected]
    }

    /// Gradient in the world at an index, zero where no fragment looks at it.
    fn gradient(&self, index: [f64; 3]) -> DVec3 {
        let Some(shading) = self.model.scene.gradient_shading() else { return DVec3::ZERO };
        let (volume, compressed) = (self.volume, self.model.compressed.as_deref());
        ExactGradients { volume, compressed, method: shading.gradient }.at(index)
    }

    /// Light in the colour of its place in index space, where voxels have colours.
    fn tinted(&self, [r, g, b, alpha]: [f64; 4], at: [f64; 3]) -> [f64; 4] {
        let Some(colors) = self.model.scene.volume.colors() else { return [r, g, b, alpha] };
        let [x, y, z] = colors.color(at);
        [r * x, g * y, b * z, alpha]
    }

    /// Light and opacity of a slab, by what a surface across a gradient reflects.
    fn shaded(&self, light: [f64; 4], world: DVec3) -> [f64; 4] {
        let scene = &self.model.scene;
        let Some(shading) = scene.reflection() else { return light };
        shading.along(&scene.lights, self.ray.direction).shade(light, world.to_array())
    }

    /// Light and opacity of a slab.
    fn fragment(&self, [begin, end]: [f64; 2], length: f64) -> [f64; 4] {
        let scene = &self.model.scene;
        let middle = 0.5 * (begin + end);
        if let Some(made) = &self.model.made {
            return self.light(middle, made, length);
        }
        let medium = GradientMedium::new(scene, self.volume);
        if let Some(table) = &self.model.segments {
            let ends = [self.stored(begin), self.stored(end)];
            // Half way between two slices of a stack, too: so both have their share.
            let world = self.gradient(self.place(middle));
            let light = medium.map_or_else(
                || table.segment(ends[0], ends[1], length),
                |medium| {
                    let rows = &self.model.row_segments[..];
                    let tables = if medium.has_rows() { rows } else { std::slice::from_ref(table) };
                    medium.segment(tables, ends, medium.magnitude(world), length)
                },
            );
            return self.shaded(self.tinted(light, self.place(middle)), world);
        }
        let stored = self.stored(middle);
        if stored.is_nan() {
            return [0.0; 4];
        }
        let (value, world) = (self.volume.calibration().value(stored), self.gradient(self.index(middle)));
        let light = medium.map_or_else(
            || scene.transfer.step(value, length),
            |medium| medium.step(value, medium.magnitude(world), length),
        );
        self.shaded(self.tinted(light, self.index(middle)), world)
    }
}
