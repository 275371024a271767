//! The types of a scene file, with serde. The text (TOML) and the volumes that it names are `vr-io`'s.
//!
//! Unknown keys are errors. What is absent has the defaults of the house: trilinear, power rule, unit distance = mean spacing,
//! linear colours, no shading, no clipping, a 512×512 picture of the whole volume before black.

mod points;

use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

use crate::any_grid::AnyGrid;
use crate::camera::{Camera, Projection};
use crate::compositing::Compositing;
use crate::error::ParameterError;
use crate::filter::Filter;
use crate::grid::UniformGrid;
use crate::grid_volume::GridVolume;
use crate::options::Options;
use crate::point_kernel::PointKernel;
use crate::scene::Scene;
use crate::shading::{GradientMethod, Light, Shading};
use crate::transfer::{ControlPoint, OpacityRule, TransferFunction};
use crate::view::{Clip, Plane, View};
use crate::volume::Volume;
use crate::voxel::{Voxel, VoxelType};
use crate::with_grid;

pub use points::{MOST_INLINE_POINTS, PointColumns};

/// A whole scene file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneFile {
    /// The volume and its filter.
    pub volume: VolumeSection,
    /// From value to light; absent: a preset is chosen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer: Option<TransferSection>,
    /// Absent: unshaded.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<ShadingSection>,
    /// Absent: the whole volume, from an oblique direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSection>,
    /// Absent: no opaque surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mesh: Option<MeshSection>,
    /// Absent: nothing is cut away.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clip: Option<ClipSection>,
    /// Size, samples, background.
    pub image: ImageSection,
    /// Renderer, compositing, and the renderer's own options.
    pub render: RenderSection,
}

/// `[volume]`: a file, a phantom, samples, or points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VolumeSection {
    /// A volume file, relative to the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// Or the name of a phantom.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phantom: Option<String>,
    /// Samples along each axis of a phantom; 64 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<usize>,
    /// Or the samples themselves, x fastest (`nan` where one is missing), up to 64³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub data: Option<Vec<f64>>,
    /// Samples along x, y, z; raw and inline only, as all that follows but `filter`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dims: Option<[usize; 3]>,
    /// `u8`, `i8`, `u16`, `i16`, `f32` (raw files: also wider ones).
    #[serde(rename = "type", skip_serializing_if = "Option::is_none")]
    pub voxel_type: Option<String>,
    /// `little` or `big`; raw only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub endian: Option<String>,
    /// Bytes before the samples; raw only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skip: Option<u64>,
    /// World units between samples; 1 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing: Option<[f64; 3]>,
    /// World position of sample (0, 0, 0); 0 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub origin: Option<[f64; 3]>,
    /// Directions of the x, y and z axis of the grid, one after the other.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[[f64; 3]; 3]>,
    /// Calibration: value per stored unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope: Option<f64>,
    /// Calibration: value of stored 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub intercept: Option<f64>,
    /// Which frame of a series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<usize>,
    /// Which component of several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component: Option<usize>,
    /// What places a NIfTI file: `auto`, `sform`, `qform` or `spacing`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<String>,
    /// Or points themselves: x, y, z, radius, weight, value of each, up to 4096 of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 6]>>,
    /// Points of a phantom that is made of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// How points are spread: `cubic-spline`, `gaussian` or `cone`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernel: Option<PointKernel>,
    /// How far the kernel of every point reaches, in world units, whatever the file tells; files alone, as what follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// Multiplies the radii.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radius_scale: Option<f64>,
    /// The column or array of the points' values; `1` for 1 everywhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<String>,
    /// The other columns or arrays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<PointColumns>,
    /// The filter that makes the canonical field of a grid.
    pub filter: Filter,
}

/// `[transfer]`: points, a preset, or a file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TransferSection {
    /// The name of a preset.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// The range of values that a preset or a file is stretched over; the volume's if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// Or a ParaView colour map (JSON), relative to the scene file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// World length that the opacities belong to; the volume's mean spacing if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit_distance: Option<f64>,
    /// What the opacities mean.
    pub opacity_rule: OpacityRule,
    /// How the colours of the points are encoded.
    pub colors: ColorEncoding,
    /// Or the points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<PointEntry>>,
}

/// How colours in a file are encoded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ColorEncoding {
    /// Linear light.
    #[default]
    Linear,
    /// The sRGB curve.
    Srgb,
}

/// A control point in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointEntry {
    /// Calibrated value.
    pub value: f64,
    /// RGB.
    pub color: [f64; 3],
    /// Opacity of one unit distance.
    pub opacity: f64,
    /// Emission per world unit, on all points or on none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub emission: Option<[f64; 3]>,
}

/// `[shading]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShadingSection {
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
    /// [magnitude per world unit, factor on κ], sorted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gradient_opacity: Vec<[f64; 2]>,
}

impl Default for ShadingSection {
    fn default() -> Self {
        Self::describe(&Shading::default(), &[Light::default()])
    }
}

impl ShadingSection {
    fn describe(s: &Shading, lights: &[Light]) -> Self {
        let light = |l: &Light| LightEntry {
            headlight: l.direction.is_none(),
            direction: l.direction.map(|d| d.to_array()),
            color: l.color,
        };
        Self {
            ambient: s.ambient,
            diffuse: s.diffuse,
            specular: s.specular,
            power: s.power,
            lights: lights.iter().map(light).collect(),
            gradient: s.gradient,
            gradient_opacity: s.gradient_opacity.iter().map(|&(m, f)| [m, f]).collect(),
        }
    }
}

impl ShadingSection {
    /// How the volume reflects light, and the lights.
    fn shading(&self) -> Result<(Shading, Vec<Light>), ParameterError> {
        let light = |(i, l): (usize, &LightEntry)| {
            if l.headlight == l.direction.is_some() {
                let allowed = "must be either a headlight or have a direction";
                return Err(ParameterError::new(format!("shading.lights[{i}]"), l, allowed));
            }
            Ok(Light { direction: l.direction.map(DVec3::from), color: l.color })
        };
        let shading = Shading {
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            power: self.power,
            gradient: self.gradient,
            gradient_opacity: self.gradient_opacity.iter().map(|p| (p[0], p[1])).collect(),
        };
        let lights = self.lights.iter().enumerate().map(light).collect::<Result<_, _>>()?;
        Ok((shading, lights))
    }
}

/// A light in a file.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    /// Shines along every ray.
    #[serde(default)]
    pub headlight: bool,
    /// World vector towards the light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Linear RGB.
    #[serde(default = "white")]
    pub color: [f64; 3],
}

fn white() -> [f64; 3] {
    [1.0; 3]
}

/// `[camera]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSection {
    /// Orthographic (with `height`) or perspective (with `fov`).
    #[serde(default)]
    pub projection: ProjectionName,
    /// Position of the eye.
    pub eye: [f64; 3],
    /// What the image centre shows.
    pub target: [f64; 3],
    /// Which way is up.
    pub up: [f64; 3],
    /// World height of an orthographic image.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<f64>,
    /// Vertical angle of a perspective image in degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
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
    fn from(c: &Camera) -> Self {
        let (projection, height, fov) = match c.projection {
            Projection::Orthographic { height } => (ProjectionName::Orthographic, Some(height), None),
            Projection::Perspective { fov } => (ProjectionName::Perspective, None, Some(fov)),
        };
        Self { projection, eye: c.eye.to_array(), target: c.target.to_array(), up: c.up.to_array(), height, fov }
    }
}

impl CameraSection {
    fn camera(&self) -> Result<Camera, ParameterError> {
        let projection = match (self.projection, self.height, self.fov) {
            (ProjectionName::Orthographic, Some(height), None) => Projection::Orthographic { height },
            (ProjectionName::Perspective, None, Some(fov)) => Projection::Perspective { fov },
            (ProjectionName::Orthographic, height, fov) => {
                let allowed = "an orthographic camera needs height, and no fov";
                return Err(ParameterError::new("camera.height", (height, fov), allowed));
            }
            (ProjectionName::Perspective, height, fov) => {
                let allowed = "a perspective camera needs fov, and no height";
                return Err(ParameterError::new("camera.fov", (height, fov), allowed));
            }
        };
        let camera = Camera { eye: self.eye.into(), target: self.target.into(), up: self.up.into(), projection };
        camera.frame()?;
        Ok(camera)
    }
}

/// `[mesh]`: an opaque surface among the volume, lit as `[shading]` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshSection {
    /// A mesh file, relative to the scene file.
    pub path: String,
    /// Linear RGB all over; the mesh's own colours, or grey, if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<[f64; 3]>,
}

/// `[clip]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ClipSection {
    /// Lower and upper corner of the world box that is kept.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub crop: Option<[[f64; 3]; 2]>,
    /// Half spaces that are kept.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub planes: Vec<PlaneEntry>,
}

/// A clip plane in a file: keeps normal·x ≥ offset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneEntry {
    /// Points into what is kept.
    pub normal: [f64; 3],
    /// See above.
    pub offset: f64,
}

/// `[image]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImageSection {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// A pixel is the mean over samples² subpixel centres.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RenderSection {
    /// Which renderer; absent: the one that suits the volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub renderer: Option<String>,
    /// over, first, average, maximum, minimum or accumulate.
    pub compositing: CompositingName,
    /// For `first`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// For `accumulate`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// The picture's largest error, promised; renderers that cannot promise refuse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_error: Option<f64>,
    /// The renderer's own options, by name.
    #[serde(flatten)]
    pub options: Options,
}

impl Default for RenderSection {
    fn default() -> Self {
        Self {
            renderer: None,
            compositing: CompositingName::default(),
            threshold: None,
            level: None,
            max_error: None,
            options: Options::new(),
        }
    }
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
    /// The renderer: the one that is named, or else the one that draws volumes of this kind.
    pub fn renderer(&self, volume: &Volume) -> &str {
        self.renderer.as_deref().unwrap_or(match &volume {
            Volume::Grid(_) => "raycast",
            // No ray caster finds the few points, of all, that a ray meets.
            Volume::Points(_) => "splat",
            Volume::Field(_) => "raycast",
        })
    }

    /// The compositing scheme with its parameter.
    ///
    /// # Errors
    /// A parameter that is missing, out of range, or given to a scheme that has none.
    pub fn compositing(&self) -> Result<Compositing, ParameterError> {
        let name = self.compositing;
        if let (Some(t), true) = (self.threshold, name != CompositingName::First) {
            return Err(ParameterError::new("render.threshold", t, "only compositing = \"first\" has a threshold"));
        }
        if let (Some(l), true) = (self.level, name != CompositingName::Accumulate) {
            return Err(ParameterError::new("render.level", l, "only compositing = \"accumulate\" has a level"));
        }
        let needs = |field, allowed| ParameterError::new(field, "nothing", allowed);
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

    fn describe(compositing: Compositing) -> Self {
        let mut section = Self::default();
        section.compositing = match compositing {
            Compositing::Over => CompositingName::Over,
            Compositing::Average => CompositingName::Average,
            Compositing::Maximum => CompositingName::Maximum,
            Compositing::Minimum => CompositingName::Minimum,
            Compositing::First { threshold } => {
                section.threshold = Some(threshold);
                CompositingName::First
            }
            Compositing::Accumulate { level } => {
                section.level = Some(level);
                CompositingName::Accumulate
            }
        };
        section
    }
}

impl SceneFile {
    /// Describes a scene whose volume is small enough to stand in the file; the view's layer, which no file can say, is left out.
    ///
    /// # Errors
    /// A volume of more than 64³ samples or 4096 points.
    pub fn describe(scene: &Scene, view: &View) -> Result<Self, ParameterError> {
        let t = &scene.transfer;
        let point =
            |p: &ControlPoint| PointEntry { value: p.value, color: p.color, opacity: p.opacity, emission: p.emission };
        let clip = &view.clip;
        let planes = clip.planes.iter().map(|p| PlaneEntry { normal: p.normal.to_array(), offset: p.offset });
        Ok(Self {
            volume: VolumeSection {
                filter: scene.volume.filter().unwrap_or_default(),
                ..inline_volume(&scene.volume)?
            },
            transfer: Some(TransferSection {
                unit_distance: Some(t.unit_distance()),
                opacity_rule: t.rule(),
                points: Some(t.points().iter().map(point).collect()),
                ..TransferSection::default()
            }),
            shading: scene.shading.as_deref().map(|s| ShadingSection::describe(s, &scene.lights)),
            camera: Some(CameraSection::from(&view.camera)),
            mesh: None,
            clip: (*clip != Clip::default()).then(|| ClipSection {
                crop: clip.crop.map(|(a, b)| [a.to_array(), b.to_array()]),
                planes: planes.collect(),
            }),
            image: ImageSection { size: view.size, samples: view.supersampling, background: scene.background },
            render: RenderSection::describe(scene.compositing),
        })
    }

    /// The scene and the view, given the volume that `[volume]` names and the points that `[transfer]` comes to.
    ///
    /// # Errors
    /// A [`ParameterError`] naming the field.
    pub fn assemble(&self, volume: Volume, points: Vec<ControlPoint>) -> Result<(Scene, View), ParameterError> {
        let default = TransferSection::default();
        let t = self.transfer.as_ref().unwrap_or(&default);
        let unit_distance = t.unit_distance.unwrap_or_else(|| volume.mean_spacing());
        let transfer = TransferFunction::new(points, t.opacity_rule, unit_distance)?;
        let camera = match &self.camera {
            Some(c) => c.camera()?,
            None => Camera::framing(volume.bounds(), 30.0, 20.0, None),
        };
        let mut clip = Clip::default();
        if let Some(c) = &self.clip {
            clip.crop = c.crop.map(|[a, b]| (a.into(), b.into()));
            clip.planes = c.planes.iter().map(|p| Plane { normal: p.normal.into(), offset: p.offset }).collect();
        }
        let view = View { supersampling: self.image.samples, clip, ..View::new(camera, self.image.size) };
        view.validate()?;
        let mut scene = Scene {
            compositing: self.render.compositing()?,
            background: self.image.background,
            ..Scene::new(volume.with_filter(self.volume.filter), transfer)
        };
        if let Some(section) = &self.shading {
            let (shading, lights) = section.shading()?;
            (scene.shading, scene.lights) = (Some(Arc::new(shading)), lights);
        }
        scene.validate()?;
        Ok((scene, view))
    }
}

/// The largest volume that a scene file may hold inline.
pub const MOST_INLINE: usize = 64 * 64 * 64;

fn inline_volume(volume: &Volume) -> Result<VolumeSection, ParameterError> {
    match &volume {
        Volume::Grid(u) => inline_grid(u),
        Volume::Points(p) => points::inline_points(p),
        Volume::Field(field) => {
            let allowed = "only uniform grids and scattered points can be written into a scene file";
            Err(ParameterError::new("volume", field.kind(), allowed))
        }
    }
}

fn inline_grid(u: &GridVolume) -> Result<VolumeSection, ParameterError> {
    let allowed = "only uniform grids of up to 64^3 samples can be written into a scene file";
    if u.dims().iter().product::<usize>() > MOST_INLINE {
        return Err(ParameterError::new("volume.dims", u.dims(), allowed));
    }
    fn numbers<T: Voxel>(g: &UniformGrid<T>) -> Vec<f64> {
        g.samples().iter().map(|s| f64::from(s.to_f32())).collect()
    }
    let axes = u.placement().axes();
    let spacing = u.placement().spacing().to_array();
    let calibration = u.calibration();
    let unit = |c: DVec3, s: f64| (c / s).to_array();
    let direction = [unit(axes.x_axis, spacing[0]), unit(axes.y_axis, spacing[1]), unit(axes.z_axis, spacing[2])];
    Ok(VolumeSection {
        data: Some(with_grid!(u.values(), g => numbers(g))),
        dims: Some(u.dims()),
        voxel_type: Some(u.voxel_type().name().to_owned()),
        spacing: Some(spacing),
        origin: Some(u.placement().origin().to_array()),
        direction: (direction != DMat3::IDENTITY.to_cols_array_2d()).then_some(direction),
        slope: (calibration.slope != 1.0).then_some(calibration.slope),
        intercept: (calibration.intercept != 0.0).then_some(calibration.intercept),
        ..VolumeSection::default()
    })
}

impl VolumeSection {
    /// The volume of inline `data`.
    ///
    /// # Errors
    /// Missing `dims`, an unknown type, a number that its type cannot hold, or what [`UniformGrid::new`] refuses.
    pub fn inline(&self) -> Result<Volume, ParameterError> {
        let data = self.data.as_deref().unwrap_or_default();
        let dims = self.dims.ok_or_else(|| ParameterError::new("volume.dims", "nothing", "inline data need dims"))?;
        if data.len() > MOST_INLINE {
            return Err(ParameterError::new("volume.data", data.len(), "inline data are at most 64^3 numbers"));
        }
        let name = self.voxel_type.as_deref().unwrap_or("f32");
        let types = [VoxelType::U8, VoxelType::I8, VoxelType::U16, VoxelType::I16, VoxelType::F32];
        let voxel_type = types
            .into_iter()
            .find(|t| t.name() == name)
            .ok_or_else(|| ParameterError::new("volume.type", name, "inline data are one of u8, i8, u16, i16, f32"))?;
        let grid = match voxel_type {
            VoxelType::U8 => AnyGrid::from(self.grid::<u8>(dims, data, |x| x as u8)?),
            VoxelType::I8 => AnyGrid::from(self.grid::<i8>(dims, data, |x| x as i8)?),
            VoxelType::U16 => AnyGrid::from(self.grid::<u16>(dims, data, |x| x as u16)?),
            VoxelType::I16 => AnyGrid::from(self.grid::<i16>(dims, data, |x| x as i16)?),
            VoxelType::F32 => AnyGrid::from(self.grid::<f32>(dims, data, |x| x as f32)?),
        };
        Ok(grid.into())
    }

    fn grid<T: Voxel>(
        &self,
        dims: [usize; 3],
        data: &[f64],
        cast: fn(f64) -> T,
    ) -> Result<UniformGrid<T>, ParameterError> {
        let convert = |(i, &x): (usize, &f64)| {
            let t = cast(x);
            // Integers must be exact; f32 rounds, as any file would.
            if T::TYPE.is_integer() && f64::from(t.to_f32()) != x {
                let allowed = "must be a number that volume.type can hold";
                return Err(ParameterError::new(format!("volume.data[{i}]"), x, allowed));
            }
            Ok(t)
        };
        let samples = data.iter().enumerate().map(convert).collect::<Result<Vec<T>, _>>()?;
        let grid_error = |e: crate::error::GridError| ParameterError {
            field: "volume".to_owned(),
            found: e.to_string(),
            allowed: "must describe a grid that can be",
        };
        UniformGrid::new(dims, samples, self.placement().map_err(grid_error)?, self.calibration()).map_err(grid_error)
    }

    /// Spacing, origin and direction.
    ///
    /// # Errors
    /// As [`crate::Placement::oriented`].
    pub fn placement(&self) -> Result<crate::Placement, crate::GridError> {
        let direction = self.direction.map_or(DMat3::IDENTITY, |d| DMat3::from_cols_array_2d(&d));
        let origin = DVec3::from(self.origin.unwrap_or_default());
        crate::Placement::oriented(origin, self.spacing.unwrap_or([1.0; 3]), direction)
    }

    /// Slope and intercept.
    pub fn calibration(&self) -> crate::Calibration {
        crate::Calibration { slope: self.slope.unwrap_or(1.0), intercept: self.intercept.unwrap_or(0.0) }
    }
}
