//! Everything that light meets and comes from.

use std::borrow::Cow;
use std::sync::Arc;

use vr_core::{Clip, ParameterError, Ray, RenderError, Scene};

use crate::boundary::{
    Environment, EnvironmentMap, LightSource, Reflection, Surface, SurfaceHit, SurfacePlace, TracedSurfaces, nearest,
};
use crate::medium::{Medium, SceneMedium};
use crate::tracking::TrackedMedium;

/// A medium, its boundaries and its lights: what the equation of transfer is solved for.
///
/// # Examples
/// ```
/// use vr_light::{Environment, LightScene};
///
/// // Nothing but the light of the sky.
/// let empty = LightScene::new(None, 3)?.with_environment(Environment::from([0.2, 0.3, 0.5]))?;
/// assert_eq!(empty.bands(), 3);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct LightScene {
    medium: Option<TrackedMedium>,
    bands: usize,
    surfaces: Vec<Surface>,
    traced: Option<TracedSurfaces>,
    lights: Vec<LightSource>,
    environment: Environment,
    hides_environment: bool,
    /// Numbers of the surfaces that emit and have an end: those that paths aim at.
    emitters: Vec<usize>,
}

impl LightScene {
    /// A medium in darkness; vacuum where there is none, in so many bands.
    ///
    /// # Errors
    /// No band, or not as many as the medium has.
    pub fn new(medium: Option<Arc<dyn Medium>>, bands: usize) -> Result<Self, ParameterError> {
        if bands == 0 || medium.as_ref().is_some_and(|medium| medium.bands() != bands) {
            return Err(ParameterError::new("medium.bands", bands, "must be those of the medium, at least 1"));
        }
        Ok(Self {
            medium: medium.map(TrackedMedium::new),
            bands,
            surfaces: Vec::new(),
            traced: None,
            lights: Vec::new(),
            environment: Environment::default(),
            hides_environment: false,
            emitters: Vec::new(),
        })
    }

    /// Medium, opaque surfaces and lights of a renderer's scene within a clip, in three bands. The environment lights them and is not seen behind them. A scene
    /// without scattering gets the default one.
    ///
    /// # Errors
    /// Numbers that are out of range, surfaces that no ray can be put to, or opacity by the gradient.
    pub fn of_scene(scene: &Scene, clip: &Clip) -> Result<Self, RenderError> {
        let none = Default::default();
        let scattering = scene.scattering.as_deref().unwrap_or(&none);
        let medium = SceneMedium::new(scene, clip, scattering)?;
        let far = scene.lights.iter().map(|&light| LightSource::from(light));
        let lights = far.chain(scattering.point_lights.iter().map(|&light| LightSource::from(light)));
        let environment = match &scattering.environment_map {
            Some(image) => Environment::Map(EnvironmentMap::of_image(image, scattering.environment)?),
            None => Environment::from(scattering.environment),
        };
        Ok(Self::new(Some(Arc::new(medium)), 3)?
            .with_surfaces(scattering.surfaces.iter().map(|&surface| surface.into()).collect())?
            .with_traced_surfaces(TracedSurfaces::of(scene, clip)?)?
            .with_lights(lights.collect())?
            .with_environment(environment)?
            .with_hidden_environment())
    }

    /// The same scene with these surfaces in place of its own.
    ///
    /// # Errors
    /// Numbers that are out of range.
    pub fn with_surfaces(mut self, surfaces: Vec<Surface>) -> Result<Self, ParameterError> {
        for (i, surface) in surfaces.iter().enumerate() {
            surface.validate(&format!("surfaces[{i}]"), self.bands)?;
        }
        let aimed = |surface: &Surface| !surface.emission.is_black() && surface.shape.area().is_finite();
        self.emitters = (0..surfaces.len()).filter(|&i| aimed(&surfaces[i])).collect();
        self.surfaces = surfaces;
        Ok(self)
    }

    /// The same scene with the opaque surfaces of a scene besides, which reflect red, green and blue.
    ///
    /// # Errors
    /// Surfaces in a scene of other than three bands.
    pub fn with_traced_surfaces(self, traced: Option<TracedSurfaces>) -> Result<Self, ParameterError> {
        if traced.is_some() && self.bands != 3 {
            return Err(ParameterError::new(
                "medium.bands",
                self.bands,
                "must be 3 with surfaces of red, green and blue",
            ));
        }
        Ok(Self { traced, ..self })
    }

    /// The same scene under these lights in place of its own.
    ///
    /// # Errors
    /// Numbers that are out of range.
    pub fn with_lights(mut self, lights: Vec<LightSource>) -> Result<Self, ParameterError> {
        for (i, light) in lights.iter().enumerate() {
            light.validate(&format!("lights[{i}]"), self.bands)?;
        }
        self.lights = lights;
        Ok(self)
    }

    /// The same scene in this environment.
    ///
    /// # Errors
    /// Numbers that are out of range.
    pub fn with_environment(mut self, environment: Environment) -> Result<Self, ParameterError> {
        environment.validate(self.bands)?;
        self.environment = environment;
        Ok(self)
    }

    /// The same scene, whose environment lights it without being seen behind it: a primary ray that meets nothing is dark.
    #[must_use]
    pub fn with_hidden_environment(self) -> Self {
        Self { hides_environment: true, ..self }
    }

    /// The medium with the bounds of its extinction.
    pub fn medium(&self) -> Option<&TrackedMedium> {
        self.medium.as_ref()
    }

    /// Number of spectral bands.
    pub fn bands(&self) -> usize {
        self.bands
    }

    /// The surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The lights without size.
    pub fn lights(&self) -> &[LightSource] {
        &self.lights
    }

    /// The environment.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// True if primary rays do not see the environment.
    pub fn hides_environment(&self) -> bool {
        self.hides_environment
    }

    /// First surface of any kind that a ray meets; `from` is where it starts.
    pub(crate) fn nearest(&self, ray: &Ray, from: Option<SurfacePlace>) -> Option<SurfaceHit> {
        let (index, facet) = match from {
            Some(SurfacePlace::Simple(index)) => (Some(index), None),
            Some(SurfacePlace::Facet(facet)) => (None, Some(facet)),
            None => (None, None),
        };
        let simple = nearest(&self.surfaces, ray, index);
        let traced = self.traced.as_ref().and_then(|traced| traced.nearest(ray, facet));
        match (simple, traced) {
            (Some(simple), Some(traced)) if simple.distance <= traced.distance => Some(simple),
            (simple, None) => simple,
            (_, Some(traced)) => Some(SurfaceHit::on_facet(ray, &traced)),
        }
    }

    /// The simple surface at a place.
    pub(crate) fn simple_surface(&self, hit: &SurfaceHit) -> Option<&Surface> {
        if let SurfacePlace::Simple(index) = hit.place { Some(&self.surfaces[index]) } else { None }
    }

    /// Kernel by which a place reflects.
    pub(crate) fn reflection(&self, hit: &SurfaceHit) -> Cow<'_, Reflection> {
        match self.simple_surface(hit) {
            Some(surface) => Cow::Borrowed(&surface.reflection),
            None => Cow::Owned(Reflection::Lambertian(hit.reflectance.into())),
        }
    }

    /// Numbers of the surfaces that emit and have an end.
    pub(crate) fn emitters(&self) -> &[usize] {
        &self.emitters
    }
}
