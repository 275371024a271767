//! `[scattering]` of a scene file.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use vr_core::scattering::{Albedo, PhaseFunction, PointLight, Scattering};
use vr_core::{Light, ParameterError};

use super::file_name::FileName;
use super::sections::{LightEntry, white};
use super::surface_entry::SurfaceEntry;

/// `[scattering]`: the medium scatters light that shines into it, and casts shadows.
///
/// # Examples
/// ```
/// use std::path::Path;
///
/// let text = "[scattering]\nalbedo = 0.9\nphase = { henyey-greenstein = 0.8 }\nlights = [{ direction = [0, 1, 0] }]\n";
/// let file = vr_io::parse_scene(text, Path::new("")).unwrap();
/// assert_eq!(file.scattering.unwrap().scattering()?.phase.mean_cosine(), 0.8);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScatteringSection {
    /// Share of the extinction that is scattering.
    pub albedo: AlbedoEntry,
    /// Directions in which scattered light leaves.
    pub phase: PhaseEntry,
    /// Radiance from all sides, linear RGB.
    pub environment: [f64; 3],
    /// File of a picture of all directions, relative to the scene file ([`crate::read_environment_map`]): its light adds to the environment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_map: Option<FileName>,
    /// The lights; one of colour L sheds π L on a surface that faces it.
    pub lights: Vec<LightEntry>,
    /// Lights at a place; one of colour L sheds π L / d² at the distance d.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub point_lights: Vec<PointLightEntry>,
    /// Opaque surfaces of simple shapes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<SurfaceEntry>,
}

/// Light at a place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointLightEntry {
    /// Its place in the world.
    pub position: DVec3,
    /// Linear RGB.
    #[serde(default = "white")]
    pub color: [f64; 3],
}

impl Default for ScatteringSection {
    fn default() -> Self {
        Self::describe(&Scattering::default(), &[Light::default()])
    }
}

/// Albedo in a file: `"color"`, a number, or one for each of red, green and blue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum AlbedoEntry {
    /// The albedo is the colour of the transfer function.
    Word(ColorWord),
    /// The same in all bands.
    Grey(f64),
    /// One albedo each for red, green and blue.
    Bands([f64; 3]),
}

/// The word for an albedo that is the colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorWord {
    /// The colour of the transfer function.
    Color,
}

/// Phase function in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PhaseEntry {
    /// All directions alike.
    Isotropic,
    /// Small particles.
    Rayleigh,
    /// One lobe with this mean cosine.
    HenyeyGreenstein(f64),
    /// Two lobes.
    DoubleHenyeyGreenstein {
        /// Mean cosines of the lobes.
        g: [f64; 2],
        /// Share of the first one.
        share: f64,
    },
    /// Points of a cosine, from −1 to 1 in order, and the value there.
    Tabulated(Vec<[f64; 2]>),
}

impl ScatteringSection {
    /// Describes scattering, and the lights; an environment map, whose file a scene does not know, is left out.
    pub fn describe(scattering: &Scattering, lights: &[Light]) -> Self {
        let albedo = match scattering.albedo {
            Albedo::Color => AlbedoEntry::Word(ColorWord::Color),
            Albedo::Constant([r, g, b]) if r == g && g == b => AlbedoEntry::Grey(r),
            Albedo::Constant(bands) => AlbedoEntry::Bands(bands),
        };
        let phase = match &scattering.phase {
            PhaseFunction::Isotropic => PhaseEntry::Isotropic,
            PhaseFunction::Rayleigh => PhaseEntry::Rayleigh,
            PhaseFunction::HenyeyGreenstein(lobe) => PhaseEntry::HenyeyGreenstein(lobe.g()),
            PhaseFunction::DoubleHenyeyGreenstein(lobes) => {
                PhaseEntry::DoubleHenyeyGreenstein { g: lobes.lobes().map(|lobe| lobe.g()), share: lobes.share() }
            }
            PhaseFunction::Tabulated(table) => PhaseEntry::Tabulated(table.points().to_vec()),
        };
        let lights = lights.iter().map(LightEntry::from).collect();
        let point_lights = scattering.point_lights.iter();
        let point_lights = point_lights.map(|&PointLight { position, color }| PointLightEntry { position, color });
        let (environment, point_lights) = (scattering.environment, point_lights.collect());
        let surfaces = scattering.surfaces.iter().map(|&surface| surface.into()).collect();
        Self { albedo, phase, environment, environment_map: None, lights, point_lights, surfaces }
    }

    /// The scattering that it describes, but for the environment map, which is in a file.
    ///
    /// # Errors
    /// A [`ParameterError`] naming the field.
    pub fn scattering(&self) -> Result<Scattering, ParameterError> {
        let albedo = match self.albedo {
            AlbedoEntry::Word(ColorWord::Color) => Albedo::Color,
            AlbedoEntry::Grey(albedo) => Albedo::Constant([albedo; 3]),
            AlbedoEntry::Bands(albedo) => Albedo::Constant(albedo),
        };
        let phase = match &self.phase {
            PhaseEntry::Isotropic => PhaseFunction::Isotropic,
            PhaseEntry::Rayleigh => PhaseFunction::Rayleigh,
            PhaseEntry::HenyeyGreenstein(g) => PhaseFunction::henyey_greenstein(*g)?,
            PhaseEntry::DoubleHenyeyGreenstein { g, share } => PhaseFunction::double_henyey_greenstein(*g, *share)?,
            PhaseEntry::Tabulated(points) => PhaseFunction::tabulated(points)?,
        };
        let point_lights = self.point_lights.iter();
        let point_lights = point_lights.map(|&PointLightEntry { position, color }| PointLight { position, color });
        let (environment, point_lights) = (self.environment, point_lights.collect());
        let mut surfaces = Vec::new();
        for (i, entry) in self.surfaces.iter().enumerate() {
            for surface in entry.surfaces() {
                surface.validate(&format!("scattering.surfaces[{i}]"))?;
                surfaces.push(surface);
            }
        }
        let scattering = Scattering { albedo, phase, environment, environment_map: None, point_lights, surfaces };
        scattering.validate()?;
        Ok(scattering)
    }

    /// The lights that it describes.
    ///
    /// # Errors
    /// A light that is neither a headlight nor has a direction, or both.
    pub(super) fn lights(&self) -> Result<Vec<Light>, ParameterError> {
        LightEntry::lights(&self.lights, "scattering")
    }
}
