//! A renderer that has seen its scene.

use std::sync::Arc;

use fearless_simd::Level;
use vr_core::{
    Compositing, Control, Frame, GridVolume, Model, Prepared, Rays, RenderError, RenderStats, Rendered, Scene, View,
};
use vr_kernels::ranges::Visibility;
use vr_kernels::vector::{Operator, PacketShading, Rows};

use crate::capabilities::check;
use crate::classified::max_code_error;
use crate::draw::{Classifier, PacketScene, Pass};
use crate::finish::Finish;
use crate::fragments::Setup;
use crate::model::SliceModel;
use crate::occupancy::{FieldRanges, Occupancy};
use crate::slices::Slices;
use crate::store::{Job, Needs, TextureStore, time_if_made};
use crate::tables::Tables;
use crate::texture_slicer::{Blend, TextureSlicer};
use crate::textures::axes_of_stack;

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

    /// True if a field between two stored numbers can be visible in a texture that is made of them.
    fn shows(&self, volume: &GridVolume) -> impl Fn(f32, f32) -> bool + Sync + use<> {
        let visibility = if self.renderer.holds_light() {
            Visibility::<f32>::of_light(&self.scene.transfer, volume.calibration(), None, None)
        } else {
            self.tables.of_length().visibility.clone()
        };
        let error = max_code_error(self.renderer.format, volume);
        move |low, high| visibility.shows(low - error, high + error)
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
        let axes = slices.axis().map_or([0, 1, 2], axes_of_stack);
        let reflection =
            scene.reflection().filter(|_| scene.compositing.integrates_light() && !self.renderer.holds_light());
        let needs = Needs { scene: &scene, volume, view, slices: &slices, shaded: reflection.is_some() };
        self.textures.make(&self.renderer, &needs, control, &mut stats)?;
        // Blocks to leave out, and shading and classification of fragments.
        let skips = self.renderer.skip_empty_space && !operator.picks();
        let visible = self.shows(volume);
        let compressed = self.textures.compressed().cloned();
        let occupancy = stats.time("cull", || {
            let ranges = || FieldRanges::new(volume, compressed.as_deref(), Occupancy::EDGE);
            skips.then(ranges).and_then(|ranges| Occupancy::new(&ranges, axes, &visible))
        });
        let shading = reflection.map(|s| {
            // A field without missing voxels is the volume's own, and lies as that does.
            let axes = if volume.vacuum_cells().is_some() { [0, 1, 2] } else { axes };
            PacketShading::new(Arc::clone(s), &scene.lights, volume.placement(), axes)
        });
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
