//! The sections of a scene file but `[volume]` and `[clip]`, with serde.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use vr_core::{
    Camera, Compositing, ControlPoint, GradientMethod, Light, OpacityRule, Options, ParameterError, Projection, Shading,
};

use super::file_name::FileName;
use super::transfer_points::TransferRowSection;

/// Look of a scene without a transfer function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LookName {
    /// Transfer function, shading and filter found from the volume ([`vr_look`]).
    #[default]
    Auto,
    /// A preset over the range of the values, by the kind of voxels alone; unshaded.
    Flat,
}

/// `[transfer]`: points, a preset, or a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TransferSection {
    /// The look where nothing else here names one.
    pub look: LookName,
    /// The name of a preset.
    pub preset: Option<String>,
    /// The range of values that a preset or a file is stretched over; if absent the preset's or file's own, or the volume's.
    pub range: Option<[f64; 2]>,
    /// Or a file of a transfer function ([`crate::read_transfer`]), relative to the scene file.
    pub file: Option<FileName>,
    /// World length that the opacities belong to; the volume's mean spacing if absent.
    pub unit_distance: Option<f64>,
    /// Meaning of the opacities.
    pub opacity_rule: OpacityRule,
    /// Encoding of the colours of the points.
    pub colors: ColorEncoding,
    /// Or the points, their colours as `colors` says.
    pub points: Option<Vec<ControlPoint>>,
    /// Or rows of points by the magnitude of the gradient.
    pub rows: Option<Vec<TransferRowSection>>,
}

/// Encoding of colours in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorEncoding {
    /// Linear light.
    #[default]
    Linear,
    /// The sRGB curve.
    Srgb,
}

/// `[shading]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShadingSection {
    /// False for no shading, whatever the automatic look would do.
    pub enabled: bool,
    /// ka.
    pub ambient: f64,
    /// kd.
    pub diffuse: f64,
    /// ks.
    pub specular: f64,
    /// p.
    pub power: f64,
    /// The lights.
    pub lights: Vec<LightEntry>,
    /// `central-differences` or `analytic`.
    pub gradient: GradientMethod,
    /// Magnitude per world unit and factor on κ, sorted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gradient_opacity: Vec<(f64, f64)>,
}

impl Default for ShadingSection {
    fn default() -> Self {
        Self::describe(&Shading::default(), &[Light::default()])
    }
}

impl ShadingSection {
    /// Describes shading, and the lights.
    pub(crate) fn describe(s: &Shading, lights: &[Light]) -> Self {
        Self {
            enabled: true,
            ambient: s.ambient,
            diffuse: s.diffuse,
            specular: s.specular,
            power: s.power,
            lights: lights.iter().map(LightEntry::from).collect(),
            gradient: s.gradient,
            gradient_opacity: s.gradient_opacity.clone(),
        }
    }

    pub(crate) fn shading(&self) -> Shading {
        Shading {
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            power: self.power,
            gradient: self.gradient,
            gradient_opacity: self.gradient_opacity.clone(),
        }
    }

    pub(super) fn lights(&self) -> Result<Vec<Light>, ParameterError> {
        LightEntry::lights(&self.lights, "shading")
    }
}

/// A light in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    /// True if it shines along every ray.
    #[serde(default)]
    pub headlight: bool,
    /// World vector towards the light.
    pub direction: Option<DVec3>,
    /// Linear RGB.
    #[serde(default = "white")]
    pub color: [f64; 3],
}

impl From<&Light> for LightEntry {
    fn from(light: &Light) -> Self {
        Self { headlight: light.direction.is_none(), direction: light.direction, color: light.color }
    }
}

impl LightEntry {
    /// The lights that a section lists.
    ///
    /// # Errors
    /// One that is neither a headlight nor has a direction, or both.
    pub(super) fn lights(entries: &[Self], section: &str) -> Result<Vec<Light>, ParameterError> {
        let light = |(i, l): (usize, &Self)| {
            if l.headlight == l.direction.is_some() {
                let allowed = "must be either a headlight or have a direction";
                return Err(ParameterError::new(format!("{section}.lights[{i}]"), l, allowed));
            }
            Ok(Light { direction: l.direction, color: l.color })
        };
        entries.iter().enumerate().map(light).collect()
    }
}

pub(super) fn white() -> [f64; 3] {
    [1.0; 3]
}

/// `[camera]`. All that is absent is that of a camera which sees all that is visible.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSection {
    /// Orthographic (with `height`) or perspective (with `fov`).
    pub projection: ProjectionName,
    /// Position of the eye.
    pub eye: Option<DVec3>,
    /// The point that the image centre shows.
    pub target: Option<DVec3>,
    /// Direction that is up in the image.
    pub up: Option<DVec3>,
    /// Angle in degrees about the upright axis, in place of `eye`.
    pub azimuth: Option<f64>,
    /// Angle in degrees above the level, in place of `eye`.
    pub elevation: Option<f64>,
    /// World height of an orthographic image.
    pub height: Option<f64>,
    /// Vertical angle of a perspective image in degrees.
    pub fov: Option<f64>,
}

/// The word for a projection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ProjectionName {
    /// Parallel rays.
    #[default]
    Orthographic,
    /// Rays from the eye.
    Perspective,
}

impl From<&Camera> for CameraSection {
    fn from(&Camera { eye, target, up, projection }: &Camera) -> Self {
        let (projection, height, fov) = match projection {
            Projection::Orthographic { height } => (ProjectionName::Orthographic, Some(height), None),
            Projection::Perspective { fov } => (ProjectionName::Perspective, None, Some(fov)),
        };
        let [eye, target, up] = [eye, target, up].map(Some);
        Self { projection, eye, target, up, azimuth: None, elevation: None, height, fov }
    }
}

/// Vertical angle in degrees of a perspective camera that was given none.
pub const USUAL_FOV: f64 = 30.0;

impl CameraSection {
    /// True if eye, target and up are left to the volume, which is seen from an azimuth and elevation.
    pub fn is_framed(&self) -> bool {
        self.eye.is_none() && self.target.is_none() && self.up.is_none()
    }

    /// Azimuth and elevation in degrees; those that are absent are the usual ones.
    pub fn angles(&self, usual: (f64, f64)) -> (f64, f64) {
        (self.azimuth.unwrap_or(usual.0), self.elevation.unwrap_or(usual.1))
    }

    /// Makes the camera. `framed` gives one that sees all, from usual angles that are changed as this section says, for the vertical angle of a
    /// perspective one.
    ///
    /// # Errors
    /// Keys that do not go together, or a camera that sees nothing.
    pub fn camera(&self, framed: impl FnOnce(Option<f64>) -> Camera) -> Result<Camera, ParameterError> {
        let &Self { projection, eye, target, up, azimuth, elevation, height, fov } = self;
        // Refuse keys that would have no effect.
        let is_perspective = projection == ProjectionName::Perspective;
        match (is_perspective, height, fov) {
            (false, _, Some(fov)) => {
                return Err(ParameterError::new("camera.fov", fov, "must go with projection = \"perspective\""));
            }
            (true, Some(height), _) => {
                return Err(ParameterError::new("camera.height", height, "must go with projection = \"orthographic\""));
            }
            _ => {}
        }
        for (field, angle) in [("camera.azimuth", azimuth), ("camera.elevation", elevation)] {
            match angle {
                Some(angle) if eye.is_some() => {
                    return Err(ParameterError::new(
                        field,
                        angle,
                        "must be absent beside eye, which says from where to look",
                    ));
                }
                Some(angle) if !angle.is_finite() => return Err(ParameterError::new(field, angle, "must be finite")),
                _ => {}
            }
        }
        // A wrong angle is to be named, not the eye that it would put somewhere.
        let fov = is_perspective.then(|| fov.unwrap_or(USUAL_FOV));
        Camera::framing((DVec3::ZERO, DVec3::ONE), 0.0, 0.0, fov).frame()?;
        // Take what is said, and find the rest: looking for all that is visible may take long.
        let projection = match fov {
            Some(fov) => Some(Projection::Perspective { fov }),
            None => height.map(|height| Projection::Orthographic { height }),
        };
        let camera = if let (Some(eye), Some(target), Some(up), Some(projection)) = (eye, target, up, projection) {
            Camera { eye, target, up, projection }
        } else {
            let own = framed(fov);
            Camera {
                eye: eye.unwrap_or(own.eye),
                target: target.unwrap_or(own.target),
                up: up.unwrap_or(own.up),
                projection: projection.unwrap_or(own.projection),
            }
        };
        camera.frame()?;
        Ok(camera)
    }
}

/// `[mesh]`: an opaque surface among the volume, lit as `[shading]` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSection {
    /// A mesh file, relative to the scene file.
    pub path: FileName,
    /// Linear RGB all over; the mesh's own colours, or grey, if absent.
    pub color: Option<[f64; 3]>,
}

/// `[image]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImageSection {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Supersampling n: a pixel is the mean over n² subpixel centres.
    pub samples: u32,
    /// Linear RGB behind everything.
    pub background: [f32; 3],
}

impl Default for ImageSection {
    fn default() -> Self {
        Self { size: [512, 512], samples: 1, background: [0.0; 3] }
    }
}

/// `[render]`. Keys that are none of these are the renderer's own options.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RenderSection {
    /// Name of a renderer; absent: the program's choice.
    pub renderer: Option<String>,
    /// over, first, average, maximum, minimum or accumulate.
    pub compositing: CompositingName,
    /// Value that `first` looks for.
    pub threshold: Option<f64>,
    /// Opacity at which `accumulate` stops.
    pub level: Option<f64>,
    /// Bound of the picture's error; renderers that cannot bound it refuse.
    pub max_error: Option<f64>,
    /// The renderer's own options, by name.
    #[serde(flatten)]
    pub options: Options,
}

/// The word for a compositing scheme.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum CompositingName {
    #[default]
    Over,
    First,
    Average,
    Maximum,
    Minimum,
    Accumulate,
}

impl RenderSection {
    pub(super) fn compositing(&self) -> Result<Compositing, ParameterError> {
        let name = self.compositing;
        if let (Some(t), true) = (self.threshold, name != CompositingName::First) {
            return Err(ParameterError::new("render.threshold", t, "only compositing = \"first\" has a threshold"));
        }
        if let (Some(l), true) = (self.level, name != CompositingName::Accumulate) {
            return Err(ParameterError::new("render.level", l, "only compositing = \"accumulate\" has a level"));
        }
        let needs = |field: &str, allowed| ParameterError { field: field.into(), found: "nothing".into(), allowed };
        let compositing = match name {
            CompositingName::Over => Compositing::Over,
            CompositingName::Average => Compositing::Average,
            CompositingName::Maximum => Compositing::Maximum,
            CompositingName::Minimum => Compositing::Minimum,
            CompositingName::First => Compositing::First {
                threshold: self.threshold.ok_or_else(|| needs("render.threshold", "first needs a value to reach"))?,
            },
            CompositingName::Accumulate => Compositing::Accumulate {
                level: self.level.ok_or_else(|| needs("render.level", "accumulate needs an opacity in (0, 1]"))?,
            },
        };
        compositing.validate()?;
        Ok(compositing)
    }

    pub(super) fn describe(compositing: Compositing) -> Self {
        let (compositing, threshold, level) = match compositing {
            Compositing::Over => (CompositingName::Over, None, None),
            Compositing::Average => (CompositingName::Average, None, None),
            Compositing::Maximum => (CompositingName::Maximum, None, None),
            Compositing::Minimum => (CompositingName::Minimum, None, None),
            Compositing::First { threshold } => (CompositingName::First, Some(threshold), None),
            Compositing::Accumulate { level } => (CompositingName::Accumulate, None, Some(level)),
        };
        Self { compositing, threshold, level, ..Self::default() }
    }
}
