//! A renderer that has seen its scene.

use std::sync::Arc;

use fearless_simd::Level;
use vr_core::{
    Compositing, Control, Frame, GridVolume, Model, Prepared, Rays, RenderError, RenderStats, Rendered, Scene, View,
};
use vr_kernels::ranges::Visibility;
use vr_kernels::vector::{Operator, PacketLights, PacketShading, Rows, Shade};

use crate::capabilities::check;
use crate::classified::max_code_error;
use crate::draw::{Classifier, PacketScene, Pass, Steepness};
use crate::finish::Finish;
use crate::fragments::Setup;
use crate::layout::Layout;
use crate::medium::GradientMedium;
use crate::model::SliceModel;
use crate::occupancy::{FieldRanges, Occupancy, Shown};
use crate::slices::Slices;
use crate::store::{Job, Needs, TextureStore, time_if_made};
use crate::tables::Tables;
use crate::texture_slicer::{Blend, TextureSlicer};
use crate::tint::Tint;

/// The scene, its textures, and what is kept from picture to picture.
pub(crate) struct PreparedTextureSlicer {
    renderer: TextureSlicer,
    scene: Scene,
    volume: Arc<GridVolume>,
    level: Level,
    tables: Tables,
    textures: TextureStore,
    /// Stages since the last picture, and their times.
    stats: RenderStats,
}

impl PreparedTextureSlicer {
    pub(crate) fn new(renderer: TextureSlicer, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&renderer, scene)?;
        control.check()?;
        let mut stats = RenderStats::default();
        let tables = stats.time("table", || Tables::new(&renderer, scene, &volume));
        let textures = TextureStore::new(&renderer, &volume, control, &mut stats)?;
        Ok(Self { renderer, scene: scene.clone(), volume, level: Level::new(), tables, textures, stats })
    }

    /// True if a field between two stored numbers can be visible in a texture that is made of them, or can be picked.
    fn shows(&self, volume: &GridVolume) -> impl Fn(f32, f32) -> bool + Sync + use<> {
        let (transfer, calibration) = (&self.scene.transfer, volume.calibration());
        let visibility = match self.scene.compositing {
            Compositing::First { threshold } => Some(Visibility::of_threshold(threshold, calibration)),
            // Every value counts.
            Compositing::Average | Compositing::Maximum | Compositing::Minimum => None,
            _ if self.renderer.holds_light() => Some(Visibility::<f32>::of_light(transfer, calibration, None, None)),
            _ => Some(self.tables.of_length().visibility.clone()),
        };
        let error = max_code_error(self.renderer.format, volume);
        move |low, high| visibility.as_ref().is_none_or(|visibility| visibility.shows(low - error, high + error))
    }
}

impl Prepared for PreparedTextureSlicer {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.renderer, scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            *self = Self::new(self.renderer.clone(), scene, control)?;
            return Ok(());
        }
        if self.scene.transfer != scene.transfer {
            self.tables = self.stats.time("table", || Tables::new(&self.renderer, scene, &volume));
        }
        let transfer = self.scene.transfer != scene.transfer;
        self.textures.forget(transfer, self.scene.shading != scene.shading || self.scene.lights != scene.lights);
        (self.scene, self.volume) = (scene.clone(), volume);
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let scene = self.scene.clone();
        let volume = &*Arc::clone(&self.volume);
        let rays = Rays::new(view)?;
        control.check()?;
        let layer = scene.layer(view, control)?;
        let mut stats = std::mem::take(&mut self.stats);
        let operator =
            Operator::new(scene.compositing, volume.calibration(), self.renderer.blend == Blend::BackToFront);
        // Extremes and crossings are wanted where rays enter and leave, too.
        let finds = matches!(operator, Operator::Extreme { .. } | Operator::First { .. });
        let on_faces = finds || (self.renderer.is_pre_integrated() && !operator.picks());
        // Slices of the view, and tables for their slabs.
        let slices = Slices::new(&self.renderer, view, volume.placement(), volume.dims(), on_faces)?;
        time_if_made(&mut stats, "table", || Ok(self.tables.tabulate(&scene, volume, slices.table_length())))?;
        // The textures that these slices need.
        let layout = slices.axis().map_or(Layout::VOLUME, |axis| {
            Layout::of_stack(axis, samples_per_layer(&self.renderer, scene.compositing))
        });
        let axes = layout.axes;
        let of_values = !operator.picks() && !self.renderer.holds_light();
        let reflection = scene.reflection().filter(|_| of_values);
        let medium = GradientMedium::new(&scene, volume).filter(|_| of_values);
        let looks = reflection.is_some() || medium.is_some();
        let gradients = scene.gradient_shading().filter(|_| looks).map(|shading| shading.gradient);
        let needs = Needs { scene: &scene, volume, view, slices: &slices, layout, gradients };
        self.textures.make(&self.renderer, &needs, control, &mut stats)?;
        // Blocks to leave out, and shading and classification of fragments.
        let skips = self.renderer.skip_empty_space;
        let visible = self.shows(volume);
        let shown = match operator {
            Operator::Extreme { sign } => Shown::Largest(sign),
            _ if self.renderer.is_pre_integrated() => Shown::Segments(&visible),
            _ => Shown::Samples(&visible),
        };
        let compressed = self.textures.compressed().cloned();
        let occupancy = stats.time("cull", || {
            let ranges = || FieldRanges::new(volume, compressed.as_deref(), Occupancy::EDGE);
            skips.then(ranges).and_then(|ranges| Occupancy::new(&ranges, axes, shown))
        });
        let shading = reflection.map(|s| PacketShading::new(Arc::clone(s), &scene.lights, volume.placement(), axes));
        let tables = self.tables.of_length();
        let even = slices.are_even();
        let exact = |stored: f32, ratio: f32| {
            if stored.is_nan() {
                return [f32::NAN; 4];
            }
            let value = volume.calibration().value(f64::from(stored));
            scene.transfer.step(value, f64::from(ratio) * tables.length).map(|c| c as f32)
        };
        let classifier = match &self.tables.segments {
            _ if operator.picks() => Classifier::Values,
            Some(table) => Classifier::Segments(table),
            None if self.renderer.holds_light() => Classifier::Done { even },
            None if !tables.baked.resolves() => Classifier::Exact(&exact),
            None => Classifier::Table { rows: Rows::new(&tables.baked), optics: &tables.optics, even },
        };
        // Opacity that follows the gradient of fragments.
        let world = |gradient: [f32; 3]| {
            let mut by_axis = [0.0; 3];
            axes.iter().zip(gradient).for_each(|(&a, g)| by_axis[a] = f64::from(g));
            volume.placement().gradient_to_world(by_axis.into())
        };
        let magnitude = |gradient| medium.as_ref().map_or(0.0, |medium| medium.magnitude(world(gradient)));
        let exact_steep = |stored: f32, ratio: f32, gradient: [f32; 3]| match &medium {
            Some(medium) => {
                let value = volume.calibration().value(f64::from(stored));
                let length = f64::from(ratio) * tables.length;
                medium.step(value, magnitude(gradient), length).map(|c| c as f32)
            }
            None => exact(stored, ratio),
        };
        let segment_steep = |ends: [f32; 2], length: f32, gradient: [f32; 3]| match &medium {
            Some(medium) => {
                let tables = &self.tables.row_segments;
                medium.segment(tables, ends, magnitude(gradient), f64::from(length)).map(|c| c as f32)
            }
            None => [0.0; 4],
        };
        // Light of textures has the colours of its voxels.
        let colors = scene.volume.colors().filter(|_| !self.renderer.holds_light());
        let tint = colors.map(|colors| Tint::new(colors, layout));
        let by_gradient = medium.as_ref().map(|medium| medium.packet_shading(axes, &tables.row_optics));
        let no_lights = PacketLights::default();
        let shade = by_gradient.as_ref().map(|shading| Shade { shading, lights: &no_lights });
        let steepness = shade.map(|shade| match (&self.tables.segments, shade.shading.rows.is_some()) {
            (Some(_), true) => Steepness::Segments(&segment_steep),
            (Some(table), false) => {
                Steepness::SegmentFactor { factor: shade, table, emits: scene.transfer.has_emission() }
            }
            (None, _) if !tables.resolves_extinction => Steepness::Exact(&exact_steep),
            (None, _) => Steepness::Samples { shade, optics: &tables.optics },
        });
        // Everything that pixels share.
        let setup = Setup {
            rays: &rays,
            placement: volume.placement(),
            dims: volume.dims(),
            clip: &view.clip,
            slices: &slices,
            axes,
            on_faces,
        };
        let finish = Finish { operator, scene: &scene, volume, compressed: compressed.as_deref() };
        let job = Job {
            scene: PacketScene {
                view,
                layer: layer.as_ref(),
                setup,
                pass: Pass {
                    classifier,
                    steepness,
                    tint: tint.as_ref(),
                    operator,
                    dims: axes.map(|a| volume.dims()[a]),
                    on_faces,
                    length: tables.length as f32,
                    negligible: if self.renderer.termination < 1.0 {
                        (1.0 - self.renderer.termination) as f32
                    } else {
                        -1.0
                    },
                    occupancy: occupancy.as_ref(),
                    snap: slices.axis().map_or(0.0, |_| 0.5 / self.renderer.per_layer() as f32),
                },
                shading: shading.as_ref(),
                max_radiance: scene.max_radiance(),
                finish: &|rays, state, i| finish.pixel(rays, state, i),
                level: self.level,
            },
            order: self.renderer.order,
            control,
        };
        let visible = |low, high| !skips || visible(low, high);
        let (pixels, counts) = self.textures.draw(&job, &self.renderer, &needs, visible, &mut stats)?;
        stats.counts = counts;
        control.report(1.0);
        let depth = Some(pixels.iter().map(|p| p.depth as f32).collect());
        let rgba = pixels.iter().map(|p| p.rgba.map(|c| c as f32)).collect();
        Ok(Rendered { frame: Frame::new(view.size, rgba, depth), stats })
    }

    /// The sum over slabs under `over`; the canonical pixel under every other operator.
    fn model(&self, view: &View) -> Result<Model, RenderError> {
        if self.scene.compositing != Compositing::Over {
            return Ok(Model::Canonical);
        }
        let of = (&self.scene, &self.volume);
        Ok(Model::Discrete(Arc::new(SliceModel::new(&self.renderer, of, view, self.textures.compressed().cloned())?)))
    }
}

/// Slices to a layer on which a stack's samples lie. `None` under `first`: a point is looked for between slices, too; where a ray enters and leaves, both have
/// their share.
fn samples_per_layer(renderer: &TextureSlicer, compositing: Compositing) -> Option<u32> {
    (!matches!(compositing, Compositing::First { .. })).then(|| renderer.per_layer())
}
