//! A shear-warp renderer that has seen its scene.

use std::sync::{Arc, Mutex};

use fearless_simd::Level;
use glam::DVec3;
use vr_core::{
    Calibration, Classification, Compositing, Control, Frame, GridVolume, Light, Model, Prepared, RenderError,
    RenderStats, Rendered, Scene, Shading, View,
};
use vr_kernels::vector::Operator;

use crate::axis::{Codewords, EncodedAxis, Encoder, WholeVolume, gradient_matrix};
use crate::capabilities::{check, last_sample};
use crate::classified::Classified;
use crate::codes::Codes;
use crate::composite::Scratch;
use crate::composite::first::First;
use crate::composite::gradients::{GradientShading, Gradients};
use crate::composite::mean_color::MeanColor;
use crate::composite::pick::{Pick, PickedLight};
use crate::composite::ray_lights::RayLights;
use crate::encode::Pyramid;
use crate::factorization::IndexView;
use crate::image::IntermediateImage;
use crate::isosurface::Isosurface;
use crate::jobs::{Job, Lighting, OverJob, SteepMedium, warp_rows};
use crate::memory::EncodedSize;
use crate::model::SlicedModel;
use crate::passes::{Pass, TexelLattice, passes};
use crate::ray_distances::RayDistances;
use crate::reflections::{Reflection, table};
use crate::region::Region;
use crate::shear_warp::ShearWarp;
use crate::sheet;
use crate::shown::Shown;
use crate::slices::{Sampling, Slices};
use crate::steepness::samples_filter_gradients;
use crate::surface_depths::SurfaceDepths;
use crate::warp::{DepthWarp, Texture, Warp};

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
        let shown = Shown::of(&self.renderer, &self.scene);
        control.check()?;
        let rule = self.classified.rule(&self.renderer, &self.scene, self.volume.filter());
        let whole = &mut self.whole;
        let encoded = control.run(|| {
            let encoder = Encoder {
                volume,
                codes: &self.codes,
                blocks: &self.pyramid.visible(rule),
                rule,
                between: self.renderer.slice_spacing() < 1.0,
                empty_space: self.renderer.empty_space,
                shaded: shown.normals,
                steep: shown.gradients,
                colors: self.scene.volume.colors().map(|colors| &**colors),
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
        let [shown, seen] = [scene, &self.scene].map(|scene| Shown::of(&self.renderer, scene));
        if self.scene.transfer != scene.transfer || shown != seen {
            self.classified = Classified::new(&self.renderer, scene, &volume, &self.codes);
            self.axes = [None, None, None];
        }
        if (shown.normals, shown.gradients) != (seen.normals, seen.gradients) {
            self.whole = WholeVolume::default();
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
        let mut depths = vec![f32::INFINITY; pixels.len()];
        let layer = self.scene.layer(view, control)?;
        let mut stats = RenderStats::default();
        if let Some(region) = region {
            let lattice = TexelLattice::of(&self.renderer, &volume);
            for pass in passes(&index_view, region.corners(), last_sample(dims), lattice)? {
                let axis = pass.factorization.axes[2];
                stats.time("encode", || self.encode(axis, control))?;
                let spacing = self.renderer.slice_spacing();
                let sampling = Sampling::of(&self.scene, &volume, spacing);
                let slices = Slices::new(pass.factorization, &region, dims[axis], spacing, sampling);
                let distances = RayDistances::new(&index_view, &pass.factorization);
                let surfaces = layer.as_ref().map(|layer| SurfaceDepths::new(layer, view.size, &slices, &distances));
                let surfaces = surfaces.as_ref();
                stats.time("composite", || self.composite(&index_view, view, (&pass, &slices), surfaces, control))?;
                let lines = self.image.lines();
                stats.counts.rays +=
                    lines.iter().map(|l| u64::from(l.drawn[1].saturating_sub(l.drawn[0]))).sum::<u64>();
                stats.counts.samples += lines.iter().map(|l| u64::from(l.samples)).sum::<u64>();
                stats.counts.terminated += lines.iter().map(|l| u64::from(l.opaque)).sum::<u64>();
                self.costs[axis] = lines.iter().map(|l| l.samples).collect();
                let screen = (&mut pixels[..], &mut depths[..]);
                stats.time("warp", || self.warp((&pass, &distances), surfaces, view, screen, control))?;
            }
        }
        if let Some(layer) = &layer {
            for (i, (pixel, depth)) in pixels.iter_mut().zip(&mut depths).enumerate() {
                *pixel = layer.under(i, pixel.map(f64::from)).map(|x| x as f32);
                *depth = depth.min(layer.depth(i) as f32);
            }
        }
        control.report(1.0);
        Ok(Rendered { frame: Frame::new(view.size, pixels, Some(depths)), stats })
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
        (pass, slices): (&Pass, &Slices),
        surfaces: Option<&SurfaceDepths>,
        control: &Control,
    ) -> Result<(), RenderError> {
        let f = &pass.factorization;
        self.image.resize(f.size);
        let shown = Shown::of(&self.renderer, &self.scene);
        let shaded = shown.normals;
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
            stops: surfaces.map_or(&[], |s| &s.texels),
            scratch: &self.scratch,
            control,
        };
        let operator = Operator::new(self.scene.compositing, self.calibration(), false);
        let image = &mut self.image;
        if let (Operator::First { sign, .. }, Compositing::First { threshold }) = (operator, self.scene.compositing) {
            let surface =
                Isosurface { scene: &self.scene, volume: &self.volume, view: index_view, threshold, sign: sign.into() };
            let threshold = sign * self.codes.exact(self.volume.calibration().stored(threshold)) as f32;
            return match &axis.voxels.codes {
                Codewords::Bytes(voxels) => job.draw(&First { voxels, sign, threshold, surface }, image),
                Codewords::Words(voxels) => job.draw(&First { voxels, sign, threshold, surface }, image),
            };
        }
        // Values are picked, and classified when all are known: an extreme with the colour of its place, a mean with that of the ray.
        if operator.picks() {
            let (calibration, transfer, codes) = (self.volume.calibration(), &self.scene.transfer, &self.codes);
            let of_code = |code: f64| transfer.at(calibration.value(codes.stored(code))).pixel();
            let colors = self.scene.volume.colors().map(|colors| &**colors);
            let light = PickedLight { of_code: &of_code, colors };
            match &axis.voxels.codes {
                Codewords::Bytes(voxels) => job.draw(&Pick { voxels, operator, light }, image)?,
                Codewords::Words(voxels) => job.draw(&Pick { voxels, operator, light }, image)?,
            }
            if operator == Operator::Average {
                let means = image.texels().to_vec();
                if colors.is_some() {
                    let colors = axis.voxels.colors.each_ref().map(|channel| &channel[..]);
                    job.draw(&MeanColor { colors }, image)?;
                }
                light.of_means(&means, image.texels_mut());
            }
            return Ok(());
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
        let filter = samples_filter_gradients(&self.scene);
        let colors = self.scene.volume.colors().map(|_| axis.voxels.colors.each_ref().map(|channel| &channel[..]));
        let steep = (filter || shown.gradients || colors.is_some()).then(|| SteepMedium {
            media: &self.classified.media,
            gradients: if filter {
                Gradients::of_filter(gradient_matrix(&self.volume) * self.codes.spacing, f.axes)
            } else if shown.gradients {
                Gradients::OfVoxels(axis.voxels.gradients.each_ref().map(|component| &component[..]))
            } else {
                Gradients::None
            },
            colors,
            shading: GradientShading::new(
                (self.scene.reflection().map(|shading| &**shading), &self.scene.lights),
                (index_view, f),
            ),
        });
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
            steep,
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
        self.composite(index_view, view, (pass, slices), None, control)?;
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

    /// Resamples the intermediate image onto the screen: pixels, and world distances of what they show.
    fn warp(
        &self,
        (pass, distances): (&Pass, &RayDistances),
        surfaces: Option<&SurfaceDepths>,
        view: &View,
        screen: (&mut [[f32; 4]], &mut [f32]),
        control: &Control,
    ) -> Result<(), RenderError> {
        let f = &pass.factorization;
        let texture = Texture { pixels: self.image.texels(), size: self.image.size(), filled: self.image.drawn() };
        let warp = Warp {
            texture,
            to_texture: f.texels_of_screen(),
            within: pass.within,
            filter: self.renderer.warp,
            samples: view.supersampling,
            surfaces,
        };
        let depths = DepthWarp {
            warp: &warp,
            depths: self.image.depths(),
            seen: self.image.seen(),
            light: self.scene.compositing.integrates_light(),
            distances,
            tolerance: sheet::tolerance(f.spacing),
        };
        warp_rows(&depths, view.size[0] as usize, screen, self.level, control)
    }
}
