//! A shear-warp renderer that has seen its scene.

use std::sync::{Arc, Mutex};

use fearless_simd::Level;
use glam::DVec3;
use vr_core::optics::{depth_of_opacity, opacity_of_depth};
use vr_core::{
    Calibration, Classification, Compositing, Control, Frame, GridVolume, Light, Model, OpacityRule, Prepared,
    RenderError, RenderStats, Rendered, Scene, Shading, View,
};
use vr_kernels::ranges::VisibleValues;
use vr_kernels::vector::Operator;

use crate::axis::{Codewords, EncodedAxis, Encoder, WholeVolume};
use crate::capabilities::{check, last_sample};
use crate::codes::Codes;
use crate::composite::Scratch;
use crate::composite::pick::Pick;
use crate::composite::ray_lights::RayLights;
use crate::encode::{Pyramid, Rule, VisibleLevels};
use crate::factorization::IndexView;
use crate::image::IntermediateImage;
use crate::jobs::{Job, Lighting, OverJob, warp_rows};
use crate::memory::EncodedSize;
use crate::model::SlicedModel;
use crate::optics::Optics;
use crate::passes::{Pass, passes};
use crate::reflections::{Reflection, table};
use crate::region::Region;
use crate::shear_warp::ShearWarp;
use crate::slices::Slices;
use crate::warp::{Texture, Warp};

/// The scene, the volume as it is encoded for it, and what is kept from picture to picture.
pub(crate) struct PreparedShearWarp {
    renderer: ShearWarp,
    scene: Scene,
    volume: Arc<GridVolume>,
    level: Level,
    pyramid: Pyramid,
    codes: Codes,
    classified: Classified,
    whole: WholeVolume,
    axes: [Option<EncodedAxis>; 3],
    image: IntermediateImage,
    scratch: Mutex<Vec<Scratch>>,
    /// Samples of each row of the last picture, axis by axis.
    costs: [Vec<u32>; 3],
    reflections: Option<ReflectionTable>,
}

/// Light that each normal reflects, and what it was made for.
struct ReflectionTable {
    shading: Arc<Shading>,
    lights: Vec<Light>,
    direction: DVec3,
    entries: Vec<Reflection>,
}

/// Tables that follow from the transfer function.
struct Classified {
    visibility: VisibleLevels,
    optics: Optics,
}

impl Classified {
    fn new(renderer: &ShearWarp, scene: &Scene, volume: &GridVolume, codes: &Codes) -> Self {
        let calibration = volume.calibration();
        let transfer = &scene.transfer;
        // A code stands for what rounds to it.
        let around = if volume.voxel_type().is_integer() { 0.0 } else { 0.5 * codes.spacing };
        // The opacity of a unit distance at which a voxel has that of the threshold.
        let voxels = transfer.unit_distance() / scene.volume.mean_spacing();
        let depth = depth_of_opacity(renderer.opacity_threshold) * voxels;
        let opacity = if transfer.rule() == OpacityRule::Power { opacity_of_depth(depth) } else { depth };
        let values = VisibleValues::above(transfer, opacity);
        let visible =
            |from: f64, to: f64| values.shows(calibration.value(from - around), calibration.value(to + around));
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let visibility = VisibleLevels::new((low.into(), high.into()), volume.voxel_type().is_integer(), visible);
        let optics = match renderer.classification {
            Classification::Post => Optics::of_values(transfer, calibration, codes),
            Classification::Pre => Optics::of_voxels(transfer, calibration, codes),
        };
        Self { visibility, optics }
    }
}

impl PreparedShearWarp {
    pub(crate) fn new(renderer: ShearWarp, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&renderer, scene)?;
        control.check()?;
        let pyramid = control.run(|| Pyramid::new(&volume));
        let codes = Codes::of(&volume);
        let classified = Classified::new(&renderer, scene, &volume, &codes);
        Ok(Self {
            renderer,
            scene: scene.clone(),
            volume,
            level: Level::new(),
            pyramid,
            codes,
            classified,
            whole: WholeVolume::default(),
            axes: [None, None, None],
            image: IntermediateImage::default(),
            scratch: Mutex::default(),
            costs: Default::default(),
            reflections: None,
        })
    }

    /// Encodes the volume for an axis, unless it is.
    pub(crate) fn encode(&mut self, axis: usize, control: &Control) -> Result<(), RenderError> {
        if self.axes[axis].is_some() {
            return Ok(());
        }
        let volume = &*self.volume;
        control.check()?;
        let rule = match self.renderer.classification {
            _ if !self.scene.compositing.integrates_light() => Rule::Everything,
            Classification::Post => Rule::Interpolated(&self.classified.visibility),
            Classification::Pre => Rule::Classified(&self.classified.visibility),
        };
        let whole = &mut self.whole;
        let encoded = control.run(|| {
            let encoder = Encoder {
                volume,
                codes: &self.codes,
                blocks: &self.pyramid.visible(rule),
                rule,
                between: self.renderer.slice_spacing() < 1.0,
                empty_space: self.renderer.empty_space,
                shaded: self.scene.reflection().is_some(),
            };
            encoder.encode(axis, whole)
        })?;
        self.axes[axis] = Some(encoded);
        Ok(())
    }
}

impl PreparedShearWarp {
    /// Size of the axes encoded so far.
    pub(crate) fn encoded_size(&self) -> EncodedSize {
        let axes = self.axes.iter().flatten();
        let runs = axes.clone().map(|axis| axis.cells.bytes()).sum();
        // Axes may share their voxels: those count once.
        let own = axes.map(|axis| &axis.voxels).filter(|v| !self.whole.all().any(|w| Arc::ptr_eq(v, w)));
        let mut size = EncodedSize { runs, octree: self.pyramid.bytes(), ..EncodedSize::default() };
        for voxels in own.chain(self.whole.all()) {
            size.voxels += voxels.bytes();
            size.stored += voxels.stored();
        }
        size
    }
}

impl Prepared for PreparedShearWarp {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.renderer, scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            *self = Self::new(self.renderer.clone(), scene, control)?;
            return Ok(());
        }
        let shaded = scene.reflection().is_some();
        let picks = |scene: &Scene| !scene.compositing.integrates_light();
        if self.scene.transfer != scene.transfer {
            self.classified = Classified::new(&self.renderer, scene, &volume, &self.codes);
            self.axes = [None, None, None];
        }
        if shaded != self.scene.reflection().is_some() {
            (self.whole, self.axes) = (WholeVolume::default(), [None, None, None]);
        }
        if picks(scene) != picks(&self.scene) {
            self.axes = [None, None, None];
        }
        (self.scene, self.volume) = (scene.clone(), volume);
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let volume = Arc::clone(&self.volume);
        let index_view = IndexView::new(view, volume.placement())?;
        let region = Region::of(view, volume.placement(), volume.dims())?;
        let dims = volume.dims();
        control.check()?;
        let [width, height] = view.size;
        let mut pixels = vec![[0.0; 4]; width as usize * height as usize];
        let mut stats = RenderStats::default();
        if let Some(region) = region {
            for pass in passes(&index_view, region.corners(), last_sample(dims), self.renderer.texel)? {
                let axis = pass.factorization.axes[2];
                stats.time("encode", || self.encode(axis, control))?;
                let slices = Slices::new(pass.factorization, &region, dims[axis], self.renderer.slice_spacing());
                stats.time("composite", || self.composite(&index_view, view, &pass, &slices, control))?;
                let lines = self.image.lines();
                stats.counts.rays +=
                    lines.iter().map(|l| u64::from(l.drawn[1].saturating_sub(l.drawn[0]))).sum::<u64>();
                stats.counts.samples += lines.iter().map(|l| u64::from(l.samples)).sum::<u64>();
                stats.counts.terminated += lines.iter().map(|l| u64::from(l.opaque)).sum::<u64>();
                self.costs[axis] = lines.iter().map(|l| l.samples).collect();
                stats.time("warp", || self.warp(&pass, view, &mut pixels, control))?;
            }
        }
        control.report(1.0);
        Ok(Rendered { frame: Frame::new(view.size, pixels, None), stats })
    }

    /// The sum over slices under `over`; the canonical pixel under every other operator.
    fn model(&self, view: &View) -> Result<Model, RenderError> {
        if self.scene.compositing != Compositing::Over {
            return Ok(Model::Canonical);
        }
        let model = SlicedModel::new(&self.renderer, (&self.scene, &self.volume), view)?;
        Ok(Model::Discrete(Arc::new(model)))
    }
}

impl PreparedShearWarp {
    /// Composites the slices of a pass onto the intermediate image.
    fn composite(
        &mut self,
        index_view: &IndexView,
        view: &View,
        pass: &Pass,
        slices: &Slices,
        control: &Control,
    ) -> Result<(), RenderError> {
        let f = &pass.factorization;
        self.image.resize(f.size);
        let shaded = self.scene.reflection().is_some();
        let by_rays = index_view.is_perspective();
        if shaded && !by_rays {
            self.reflect(view, control)?;
        }
        let axis = self.axes[f.axes[2]].as_ref().expect("encoded before");
        let correction = self.renderer.correction;
        let job = Job {
            cells: &axis.cells,
            slices,
            level: self.level,
            before: &self.costs[f.axes[2]],
            scratch: &self.scratch,
            control,
        };
        let operator = Operator::new(self.scene.compositing, self.calibration(), false);
        let image = &mut self.image;
        // Values are picked, and classified afterwards.
        if operator.picks() {
            return match &axis.voxels.codes {
                Codewords::Bytes(voxels) => job.draw(&Pick { voxels, operator }, image),
                Codewords::Words(voxels) => job.draw(&Pick { voxels, operator }, image),
            }
            .map(|()| self.classify_picks(operator));
        }
        // Light is composited, up to the level of accumulate.
        let optics = &self.classified.optics;
        let level = match self.scene.compositing {
            Compositing::Accumulate { level } => level,
            _ => 1.0,
        };
        let lighting = match (&self.scene.shading, &self.reflections) {
            (Some(shading), _) if shaded && by_rays => {
                Lighting::Rays(RayLights::new(shading, &self.scene.lights, index_view, f))
            }
            (_, Some(table)) if shaded => Lighting::Table(&table.entries),
            _ => Lighting::None,
        };
        let over = OverJob {
            normals: &axis.voxels.normals,
            lighting,
            optics,
            index_view,
            pass,
            correction,
            termination: self.renderer.termination.min(level) as f32,
            level: level as f32,
            before: self.renderer.classification == Classification::Pre,
        };
        match &axis.voxels.codes {
            Codewords::Bytes(voxels) => over.draw(voxels, &job, image),
            Codewords::Words(voxels) => over.draw(voxels, &job, image),
        }
    }

    /// The texels of a pass.
    #[cfg(test)]
    pub(crate) fn composited(
        &mut self,
        index_view: &IndexView,
        view: &View,
        pass: &Pass,
        slices: &Slices,
        control: &Control,
    ) -> Result<&[[f32; 4]], RenderError> {
        self.encode(pass.factorization.axes[2], control)?;
        self.composite(index_view, view, pass, slices, control)?;
        Ok(self.image.texels())
    }

    fn calibration(&self) -> Calibration {
        self.volume.calibration()
    }

    /// Makes the table of what normals reflect, unless neither light nor view has changed.
    fn reflect(&mut self, view: &View, control: &Control) -> Result<(), RenderError> {
        let shading = self.scene.shading.as_ref().expect("asked for where something is shaded");
        let (lights, direction) = (&self.scene.lights, view.camera.frame()?.z_axis);
        let same = |t: &ReflectionTable| t.shading == *shading && t.lights == *lights && t.direction == direction;
        if !self.reflections.as_ref().is_some_and(same) {
            let entries = control.run(|| table(shading, lights, direction));
            let (shading, lights) = (Arc::clone(shading), lights.clone());
            self.reflections = Some(ReflectionTable { shading, lights, direction, entries });
        }
        Ok(())
    }

    /// Turns the values of texels into light and opacity.
    fn classify_picks(&mut self, operator: Operator) {
        let (calibration, transfer, codes) = (self.calibration(), &self.scene.transfer, &self.codes);
        for texel in self.image.texels_mut() {
            let [value, weight, ..] = texel.map(f64::from);
            if weight > 0.0 {
                let code = if operator == Operator::Average { value / weight } else { value };
                *texel = transfer.at(calibration.value(codes.stored(code))).pixel().map(|x| x as f32);
            }
        }
    }

    /// Resamples the intermediate image onto the screen.
    fn warp(&self, pass: &Pass, view: &View, pixels: &mut [[f32; 4]], control: &Control) -> Result<(), RenderError> {
        let texture = Texture { pixels: self.image.texels(), size: self.image.size(), filled: self.image.drawn() };
        let warp = Warp {
            texture,
            to_texture: pass.factorization.texels_of_screen(),
            within: pass.within,
            filter: self.renderer.warp,
            samples: view.supersampling,
        };
        warp_rows(&warp, view.size[0] as usize, pixels, self.level, control)
    }
}
