//! Shapes of simple surfaces.

use std::f64::consts::PI;

use crate::error::ParameterError;
use crate::limits::MAX_COORDINATE;
use crate::ray::Ray;
use glam::DVec3;

/// Shape of a surface in the world. Surfaces have no thickness, and are opaque from both sides.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Ray;
/// use vr_core::scattering::Shape;
///
/// let ball = Shape::Sphere { centre: DVec3::ZERO, radius: 1.0 };
/// let ray = Ray { origin: DVec3::new(0.0, 0.0, -3.0), direction: DVec3::Z };
/// assert_eq!(ball.intersect(&ray, false), Some(2.0));
/// assert_eq!(Shape::box_faces(DVec3::ZERO, DVec3::ONE).map(|face| face.area()), [1.0; 6]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A plane without end.
    Plane {
        /// Any of its points.
        point: DVec3,
        /// Vector across it, of any length.
        normal: DVec3,
    },
    /// A sphere, seen from within or without.
    Sphere {
        /// Its middle.
        centre: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A triangle, by its corners.
    Triangle([DVec3; 3]),
    /// A parallelogram: a patch, or the face of a box.
    Parallelogram {
        /// One corner.
        corner: DVec3,
        /// Edges to the two corners next to it.
        edges: [DVec3; 2],
    },
}

impl Shape {
    /// The six faces of a box.
    pub fn box_faces(low: DVec3, high: DVec3) -> [Self; 6] {
        let size = high - low;
        let [x, y, z] = [DVec3::X * size, DVec3::Y * size, DVec3::Z * size];
        let face = |corner, edges| Self::Parallelogram { corner, edges };
        [
            face(low, [y, z]),
            face(low + x, [y, z]),
            face(low, [z, x]),
            face(low + y, [z, x]),
            face(low, [x, y]),
            face(low + z, [x, y]),
        ]
    }

    /// World distance at which a ray meets it in front of its origin. `on` says that the ray starts on this shape: only a sphere is met again, from
    /// within.
    pub fn intersect(&self, ray: &Ray, on: bool) -> Option<f64> {
        let distance = match *self {
            Self::Sphere { centre, radius } => return sphere_distance(ray, centre - ray.origin, radius, on),
            _ if on => return None,
            Self::Plane { point, normal } => (point - ray.origin).dot(normal) / ray.direction.dot(normal),
            Self::Triangle([a, b, c]) => distance_within(ray, a, [b - a, c - a], |u, v| u + v <= 1.0)?,
            Self::Parallelogram { corner, edges } => distance_within(ray, corner, edges, |u, v| u <= 1.0 && v <= 1.0)?,
        };
        // A ray along a plane meets it at ±∞ or NaN: not at all.
        (distance > 0.0 && distance < f64::INFINITY).then_some(distance)
    }

    /// Unit vector across it at one of its points; either of the two.
    pub fn normal(&self, at: DVec3) -> DVec3 {
        match *self {
            Self::Plane { normal, .. } => normal.normalize(),
            Self::Sphere { centre, .. } => (at - centre).normalize(),
            Self::Triangle([a, b, c]) => (b - a).cross(c - a).normalize(),
            Self::Parallelogram { edges: [a, b], .. } => a.cross(b).normalize(),
        }
    }

    /// Area of one side; +∞ for a plane.
    pub fn area(&self) -> f64 {
        match *self {
            Self::Plane { .. } => f64::INFINITY,
            Self::Sphere { radius, .. } => 4.0 * PI * radius * radius,
            Self::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
            Self::Parallelogram { edges: [a, b], .. } => a.cross(b).length(),
        }
    }

    /// A point of two numbers uniform in [0, 1), uniform over the area. A plane has no such point; it gives its own.
    pub fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        match *self {
            Self::Plane { point, .. } => point,
            Self::Sphere { centre, radius } => {
                let z = 1.0 - 2.0 * u;
                let ring = (1.0 - z * z).max(0.0).sqrt();
                let (sin, cos) = libm::sincos(2.0 * PI * v);
                centre + radius * DVec3::new(ring * cos, ring * sin, z)
            }
            // The half of the unit square beyond its diagonal is turned onto the other.
            Self::Triangle([a, b, c]) if u + v > 1.0 => a + (1.0 - u) * (b - a) + (1.0 - v) * (c - a),
            Self::Triangle([a, b, c]) => a + u * (b - a) + v * (c - a),
            Self::Parallelogram { corner, edges } => corner + u * edges[0] + v * edges[1],
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Coordinates that are not finite or above 10³⁰, and shapes without area.
    pub fn validate(&self, field: &str) -> Result<(), ParameterError> {
        let (at, size) = match *self {
            Self::Plane { point, normal } => (point, normal.length()),
            Self::Sphere { centre, radius } => (centre, radius),
            Self::Triangle([a, ..]) => (a, self.area()),
            Self::Parallelogram { corner, .. } => (corner, self.area()),
        };
        let is_near = at.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE);
        if is_near && size > 0.0 && size <= MAX_COORDINATE * MAX_COORDINATE {
            return Ok(());
        }
        Err(ParameterError::new(field, self, "must be finite, coordinates 1e30 at most, and have an area"))
    }
}

/// Distance at which a ray meets a sphere whose middle is `to` away from its origin.
fn sphere_distance(ray: &Ray, to: DVec3, radius: f64, on: bool) -> Option<f64> {
    let along = to.dot(ray.direction);
    if on {
        // From a point of the sphere, the other one of the chord.
        return (along > 0.0).then_some(2.0 * along);
    }
    // The distance of the ray from the middle as a vector: no cancellation far away.
    let across = to - along * ray.direction;
    let square = radius * radius - across.length_squared();
    if square < 0.0 {
        return None;
    }
    let half = square.sqrt();
    [along - half, along + half].into_iter().find(|&distance| distance > 0.0)
}

/// Distance at which a ray meets a plane figure with a corner and two edges, where `inside` holds of its coordinates along the edges
/// (Möller & Trumbore, "Fast, minimum storage ray/triangle intersection", 1997).
fn distance_within(ray: &Ray, corner: DVec3, [a, b]: [DVec3; 2], inside: impl Fn(f64, f64) -> bool) -> Option<f64> {
    let across = ray.direction.cross(b);
    let determinant = a.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let from = ray.origin - corner;
    let u = from.dot(across) / determinant;
    let turned = from.cross(a);
    let v = ray.direction.dot(turned) / determinant;
    (u >= 0.0 && v >= 0.0 && inside(u, v)).then(|| b.dot(turned) / determinant)
}
