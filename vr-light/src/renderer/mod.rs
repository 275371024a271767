//! The renderer of media that scatter.

mod options;
mod pixel;
mod prepared;

use vr_core::scattering::Scattering;
use vr_core::{Control, Documented, Feature, NamedSetting, Prepared, RenderError, Renderer, Scene, Unsupported, View};

use crate::boundary::TracedSurfaces;
use crate::single::refuse_sampled_lights;
use prepared::PreparedLight;

/// Renderer of media that scatter: by random paths, or light that is scattered once without chance.
///
/// Pictures say their own errors ([`vr_core::Frame::uncertainty`]). They repeat bit for bit, however many threads draw them, unless they end by time.
///
/// # Examples
/// ```
/// use vr_core::{Camera, Control, Renderer, View, phantom};
/// use vr_light::LightRenderer;
///
/// let mut scene = phantom::by_name("fog").unwrap().scene(9)?;
/// scene.scattering = Some(Default::default());
/// let view = View::new(Camera::framing(scene.volume.bounds(), 30.0, 20.0, None), [8, 6]);
/// let control = Control::default();
/// let picture = LightRenderer { paths: 16, ..LightRenderer::default() }.prepare(&scene, &control)?.render(&view, &control)?;
/// assert!(picture.frame.uncertainty().expect("it knows its errors").rms() < 0.2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LightRenderer {
    /// Orders of scattering that are drawn.
    pub method: Method,
    /// Random paths for each pixel, 1 or more.
    pub paths: u32,
    /// Standard error of the picture, as the root mean square over its components, at which it needs no more paths; 0: each pixel takes all of them.
    pub error: f64,
    /// Seconds after which no more paths are begun, of a frame; 0: as long as it takes. What comes of it depends on the machine.
    pub seconds: f64,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Largest number of scatterings of a path; `None`: as many as there are.
    pub max_scatterings: Option<u32>,
    /// Step of light that is scattered once, in spacings of the volume.
    pub step: f64,
    /// True to integrate light that is scattered once to a tolerance, which is slow, in place of steps.
    pub exact: bool,
}

/// Orders of scattering that are drawn, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Light that is scattered any number of times, by random paths.
    #[default]
    Full,
    /// Light that is scattered once, without chance.
    Single,
}

impl Default for LightRenderer {
    fn default() -> Self {
        Self {
            method: Method::Full,
            paths: 64,
            error: 0.0,
            seconds: 0.0,
            seed: 0,
            max_scatterings: None,
            step: 0.5,
            exact: false,
        }
    }
}

impl LightRenderer {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "light";

    /// Checks that a scene can be drawn.
    fn check(&self, scene: &Scene) -> Result<(), RenderError> {
        scene.validate()?;
        let unsupported =
            |feature, what: &str| Err(Unsupported { renderer: Self::NAME, feature, what: what.to_owned() }.into());
        if scene.scattering.is_none() {
            let what =
                "scenes without scattering: emission and absorption, which every other renderer draws without chance";
            return unsupported(Feature::Scattering, what);
        }
        if scene.compositing != vr_core::Compositing::Over {
            return unsupported(
                Feature::Compositing,
                "compositing 'accumulate': light that is scattered comes from behind the level, too",
            );
        }
        if scene.surfaces.as_ref().is_some_and(|surfaces| !surfaces.can_be_traced()) {
            return unsupported(Feature::Surfaces, TracedSurfaces::REFUSED);
        }
        if scene.has_gradient_opacity() {
            return unsupported(
                Feature::GradientOpacity,
                "opacity by the gradient: the extinction of a medium is a function of its value",
            );
        }
        if let (Method::Single, Some(scattering)) = (self.method, &scene.scattering) {
            refuse_sampled_lights(scattering)?;
        }
        let sky = |scattering: &Scattering| scattering.environment.iter().any(|&radiance| radiance > 0.0);
        if self.method == Method::Single && !self.exact && scene.scattering.as_deref().is_some_and(sky) {
            return unsupported(
                Feature::Scattering,
                "light from all sides in steps: exact=true integrates it, model=full samples it",
            );
        }
        Ok(())
    }
}

impl Renderer for LightRenderer {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        self.check(scene)?;
        view.map_or(Ok(()), |view| Ok(view.validate()?))
    }

    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        self.check(scene)?;
        Ok(Box::new(PreparedLight::new(self.clone(), scene, control)?))
    }
}

impl Documented for LightRenderer {
    fn settings(&self) -> Vec<NamedSetting> {
        let single = Self { method: Method::Single, ..Self::default() };
        let full = |paths| NamedSetting::new(format!("{paths} paths"), &Self { paths, ..Self::default() }, None, 1e-6);
        vec![NamedSetting::new("single scattering", &single, None, 1e-6), full(16), full(64), full(256)]
    }
}
