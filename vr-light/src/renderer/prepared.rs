//! A scene that the renderer has seen.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use vr_core::image_order::{ImageSample, trace_view};
use vr_core::parallel::locked;
use vr_core::{
    Clip, Control, Counts, Feature, Frame, Model, Prepared, Ray, RenderError, RenderStats, Rendered, Scene,
    Uncertainty, Unsupported, View,
};

use super::pixel::LightPixel;
use super::{LightRenderer, Method};
use crate::light_scene::LightScene;
use crate::marched::MarchedScattering;
use crate::paths::{Film, PathTracer, Until};
use crate::single::SingleScattering;

/// Tolerance of the quadrature of light that is scattered once.
const TOLERANCE: f64 = 1e-4;

/// A scene, and how it is drawn.
pub(super) struct PreparedLight {
    renderer: LightRenderer,
    scene: Scene,
    /// Medium and lights with the clip that they were made for: most views have the same.
    lit: Option<(Clip, Arc<LightScene>)>,
    /// The same for light that is scattered once, in steps.
    marched: Option<(Clip, MarchedScattering)>,
}

impl PreparedLight {
    pub(super) fn new(renderer: LightRenderer, scene: &Scene, _control: &Control) -> Result<Self, RenderError> {
        scene.volume.prepare_derived();
        Ok(Self { renderer, scene: scene.clone(), lit: None, marched: None })
    }

    /// Medium and lights within a clip.
    fn lit(&mut self, clip: &Clip) -> Result<Arc<LightScene>, RenderError> {
        if let Some((known, lit)) = &self.lit
            && known == clip
        {
            return Ok(Arc::clone(lit));
        }
        let lit = Arc::new(LightScene::of_scene(&self.scene, clip)?);
        self.lit = Some((clip.clone(), Arc::clone(&lit)));
        Ok(lit)
    }

    /// Draws by random paths.
    fn full(&mut self, view: &View, control: &Control, stats: &mut RenderStats) -> Result<Frame, RenderError> {
        let lit = stats.time("medium", || self.lit(&view.clip))?;
        let LightRenderer { paths, error, seconds, seed, max_scatterings, .. } = self.renderer;
        let mut film = Film::new(view.size, lit.bands())?;
        let until = Until {
            samples: Some(paths.into()),
            error: (error > 0.0).then_some(error),
            time: (seconds > 0.0).then(|| Duration::from_secs_f64(seconds)),
        };
        let tracer = PathTracer::new(&lit, seed.into()).with_max_scatterings(max_scatterings);
        stats.time("paths", || tracer.run(view, &mut film, &until, control, &mut |_| {}))?;
        let count = view.size[0] as usize * view.size[1] as usize;
        stats.counts.rays = (0..count).map(|pixel| film.count(pixel)).sum();
        let pixels = (0..count).map(|pixel| std::array::from_fn(|c| film.mean(pixel, c) as f32)).collect();
        let error = |pixel: usize, c: usize| film.standard_error(pixel, c) as f32;
        let errors = (0..count).map(|pixel| std::array::from_fn(|c| error(pixel, c))).collect();
        Ok(Frame::new(view.size, pixels, None).with_uncertainty(Uncertainty::StandardError(errors)))
    }

    /// Draws light that is scattered once, in steps.
    fn marched(&mut self, view: &View, control: &Control, stats: &mut RenderStats) -> Result<Frame, RenderError> {
        if self.marched.as_ref().is_none_or(|(clip, _)| *clip != view.clip) {
            let made = stats
                .time("shadows", || MarchedScattering::new(&self.scene, &view.clip, self.renderer.step, control))?;
            self.marched = Some((view.clip.clone(), made));
        }
        let (_, marched) = self.marched.as_ref().expect("made just now");
        let trace = |_: &mut (), ray: &Ray, _: ImageSample, counts: &mut Counts| {
            let light = marched.along(ray);
            counts.rays += 1;
            counts.samples += light.samples;
            let [r, g, b] = light.radiance;
            LightPixel { rgba: [r, g, b, light.opacity()], error: 0.0, depth: light.half_way }
        };
        let (pixels, counts) = stats.time("rays", || trace_view(view, control, || (), trace))?;
        stats.counts = counts;
        Ok(frame(view, &pixels))
    }

    /// Draws light that is scattered once, by quadrature with an account of its error.
    fn exact(&self, view: &View, control: &Control, stats: &mut RenderStats) -> Result<Frame, RenderError> {
        let scattering = self.scene.scattering.as_deref().expect("checked in prepare");
        let single = SingleScattering::new(&self.scene, scattering, &view.clip, TOLERANCE)?;
        let failed = Mutex::new(None);
        let trace = |_: &mut (), ray: &Ray, _: ImageSample, counts: &mut Counts| {
            counts.rays += 1;
            match single.ray(ray, f64::INFINITY) {
                Ok(light) => {
                    counts.samples += light.samples;
                    let [r, g, b] = light.radiance;
                    LightPixel {
                        rgba: [r, g, b, light.opacity()],
                        error: light.certainty.value(),
                        depth: light.half_way,
                    }
                }
                Err(e) => {
                    *locked(&failed) = Some(e);
                    LightPixel { rgba: [0.0; 4], error: f64::INFINITY, depth: f64::INFINITY }
                }
            }
        };
        let (pixels, counts) = stats.time("rays", || trace_view(view, control, || (), trace))?;
        if let Some(e) = locked(&failed).take() {
            return Err(e);
        }
        stats.counts = counts;
        let errors = pixels.iter().map(|p| [p.error as f32; 4]).collect();
        Ok(frame(view, &pixels).with_uncertainty(Uncertainty::Bound(errors)))
    }
}

/// The picture of pixels.
fn frame(view: &View, pixels: &[LightPixel]) -> Frame {
    let colors = pixels.iter().map(|p| p.rgba.map(|x| x as f32)).collect();
    let depth = pixels.iter().map(|p| p.depth as f32).collect();
    Frame::new(view.size, colors, Some(depth))
}

impl Prepared for PreparedLight {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        self.renderer.check(scene)?;
        *self = Self::new(self.renderer.clone(), scene, control)?;
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        view.validate()?;
        let mut stats = RenderStats::default();
        let frame = match self.renderer.method {
            Method::Full => self.full(view, control, &mut stats)?,
            Method::Single if self.renderer.exact => self.exact(view, control, &mut stats)?,
            Method::Single => self.marched(view, control, &mut stats)?,
        };
        Ok(Rendered { frame, stats })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        // All light of the scene: the mean over paths is the correct pixel.
        if self.renderer.method == Method::Full && self.renderer.max_scatterings.is_none() {
            return Ok(Model::Canonical);
        }
        let what = "a model of emission and absorption: light comes from all directions".to_owned();
        Err(Unsupported { renderer: LightRenderer::NAME, feature: Feature::Model, what }.into())
    }
}
