//! Simple surfaces of `[scattering]` in a scene file.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use vr_core::scattering::{Finish, Shape, SimpleSurface};

/// Surface of a simple shape in a file; a box is as many as it has faces.
///
/// # Examples
/// ```
/// use std::path::Path;
///
/// let text = "[[scattering.surfaces]]\nshape = { box = { low = [-1, -1, -1], high = [1, 1, 1], faces = [\"-y\", \"+x\"] } }\n\
///             reflectance = [0.8, 0.8, 0.8]\nfinish = { gloss = 20.0 }\n";
/// let scattering = vr_io::parse_scene(text, Path::new("")).unwrap().scattering.unwrap();
/// assert_eq!(scattering.scattering()?.surfaces.len(), 2);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceEntry {
    /// Its shape.
    pub shape: ShapeEntry,
    /// Radiance that it emits, linear RGB.
    #[serde(default)]
    pub emission: [f64; 3],
    /// Share of light that it reflects.
    #[serde(default)]
    pub reflectance: [f64; 3],
    /// Directions in which it reflects.
    #[serde(default)]
    pub finish: FinishEntry,
}

/// Shape of a surface in a file, in world coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
pub enum ShapeEntry {
    /// A plane without end.
    Plane {
        /// Any of its points.
        point: DVec3,
        /// Vector across it.
        normal: DVec3,
    },
    /// A sphere.
    Sphere {
        /// Its middle.
        centre: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A triangle, by its corners.
    Triangle([DVec3; 3]),
    /// A parallelogram.
    Parallelogram {
        /// One corner.
        corner: DVec3,
        /// Edges to the two corners next to it.
        edges: [DVec3; 2],
    },
    /// Faces of a box.
    Box {
        /// Corner of the lowest coordinates.
        low: DVec3,
        /// Corner of the highest ones.
        high: DVec3,
        /// Which faces; all if absent.
        #[serde(default = "all_faces")]
        faces: Vec<FaceName>,
    },
}

/// Face of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaceName {
    /// That of the lowest x.
    #[serde(rename = "-x")]
    LowX,
    /// That of the highest x.
    #[serde(rename = "+x")]
    HighX,
    /// That of the lowest y.
    #[serde(rename = "-y")]
    LowY,
    /// That of the highest y.
    #[serde(rename = "+y")]
    HighY,
    /// That of the lowest z.
    #[serde(rename = "-z")]
    LowZ,
    /// That of the highest z.
    #[serde(rename = "+z")]
    HighZ,
}

impl FaceName {
    /// Every face of a box, in the order of [`Shape::box_faces`].
    pub const ALL: [Self; 6] = [Self::LowX, Self::HighX, Self::LowY, Self::HighY, Self::LowZ, Self::HighZ];
}

fn all_faces() -> Vec<FaceName> {
    FaceName::ALL.to_vec()
}

/// Directions in which a surface reflects, in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FinishEntry {
    /// All alike.
    #[default]
    Matte,
    /// The mirrored one.
    Mirror,
    /// A lobe about the mirrored one, with this exponent.
    Gloss(f64),
}

impl From<SimpleSurface> for SurfaceEntry {
    fn from(surface: SimpleSurface) -> Self {
        let shape = match surface.shape {
            Shape::Plane { point, normal } => ShapeEntry::Plane { point, normal },
            Shape::Sphere { centre, radius } => ShapeEntry::Sphere { centre, radius },
            Shape::Triangle(corners) => ShapeEntry::Triangle(corners),
            Shape::Parallelogram { corner, edges } => ShapeEntry::Parallelogram { corner, edges },
        };
        let finish = match surface.finish {
            Finish::Matte => FinishEntry::Matte,
            Finish::Mirror => FinishEntry::Mirror,
            Finish::Gloss { exponent } => FinishEntry::Gloss(exponent),
        };
        Self { shape, emission: surface.emission, reflectance: surface.reflectance, finish }
    }
}

impl SurfaceEntry {
    /// The surfaces that it describes.
    pub(super) fn surfaces(&self) -> impl Iterator<Item = SimpleSurface> {
        let shapes = match &self.shape {
            &ShapeEntry::Plane { point, normal } => vec![Shape::Plane { point, normal }],
            &ShapeEntry::Sphere { centre, radius } => vec![Shape::Sphere { centre, radius }],
            &ShapeEntry::Triangle(corners) => vec![Shape::Triangle(corners)],
            &ShapeEntry::Parallelogram { corner, edges } => vec![Shape::Parallelogram { corner, edges }],
            ShapeEntry::Box { low, high, faces } => {
                let shapes = FaceName::ALL.into_iter().zip(Shape::box_faces(*low, *high));
                shapes.filter(|(name, _)| faces.contains(name)).map(|(_, shape)| shape).collect()
            }
        };
        let finish = match self.finish {
            FinishEntry::Matte => Finish::Matte,
            FinishEntry::Mirror => Finish::Mirror,
            FinishEntry::Gloss(exponent) => Finish::Gloss { exponent },
        };
        let Self { emission, reflectance, .. } = *self;
        shapes.into_iter().map(move |shape| SimpleSurface { shape, emission, reflectance, finish })
    }
}
