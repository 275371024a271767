//! A ray through one tetrahedron.

use glam::DVec3;

use super::FACES;
use super::adjacency::ascending;
use super::mesh::CellMesh;
use crate::ray::Ray;

/// A ray counted from a place near the mesh, so that distances are small numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRay {
    /// Place at distance 0.
    pub(super) base: DVec3,
    /// Unit vector.
    pub(super) direction: DVec3,
    /// World distance from the ray's own origin to the base.
    pub(super) offset: f64,
    /// Bound on the rounding of the base.
    pub(super) base_error: f64,
}

impl LocalRay {
    /// The ray, counted from the place on it that is nearest to a point.
    pub(super) fn near(ray: &Ray, middle: DVec3) -> Self {
        let offset = (middle - ray.origin).dot(ray.direction);
        let base = ray.origin + ray.direction * offset;
        let base_error = 4.0 * f64::EPSILON * (ray.origin.abs().max_element() + offset.abs());
        Self { base, direction: ray.direction, offset, base_error }
    }
}

/// The plane of a face and a ray: the height of the ray's place above the plane, outwards, is `rate · s − below` at distance s, in units of twice the
/// face's area.
#[derive(Clone, Copy, Debug)]
struct Plane {
    below: f64,
    rate: f64,
    /// Bounds on the rounding of both.
    below_error: f64,
    rate_error: f64,
}

impl Plane {
    /// The plane of a face: its vertices are taken in ascending order, so that both cells of a face get the same numbers.
    fn new(mesh: &CellMesh, face: [u32; 3], ray: &LocalRay) -> Self {
        let (face, outward) = ascending(face);
        let [a, b, c] = face.map(|v| mesh.vertices()[v as usize]);
        let (e, f) = (b - a, c - a);
        let normal = if outward { e.cross(f) } else { -e.cross(f) };
        let (e, f) = (e.abs(), f.abs());
        // What the normal is made of, without signs: rounding is a part of it.
        let size = DVec3::new(e.y * f.z + e.z * f.y, e.z * f.x + e.x * f.z, e.x * f.y + e.y * f.x);
        let to_plane = a - ray.base;
        let rounding = 8.0 * f64::EPSILON;
        Self {
            below: normal.dot(to_plane),
            rate: normal.dot(ray.direction),
            below_error: rounding * size.dot(to_plane.abs()) + ray.base_error * size.element_sum(),
            rate_error: rounding * size.dot(ray.direction.abs()),
        }
    }
}

/// The part of a ray inside a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellCrossing {
    /// The cell.
    pub(super) cell: u32,
    /// Distances of entry and exit.
    pub(super) ends: [f64; 2],
    /// Bounds on the errors of both.
    pub(super) errors: [f64; 2],
    /// Barycentric coordinates are `at + rate · s`.
    at: [f64; 4],
    rate: [f64; 4],
    /// Bounds on the errors of the coordinates inside the cell.
    coordinate_errors: [f64; 4],
}

impl CellCrossing {
    /// The part between two distances; `None` where nothing of positive length is left.
    pub(super) fn new(mesh: &CellMesh, cell: usize, ray: &LocalRay, part: [f64; 2]) -> Option<Self> {
        let vertices = mesh.cells()[cell];
        let planes = FACES.map(|face| Plane::new(mesh, face.map(|i| vertices[i]), ray));
        let (mut ends, mut errors) = (part, [0.0; 2]);
        for plane in &planes {
            let at = plane.below / plane.rate;
            let error = (plane.below_error + at.abs() * plane.rate_error) / plane.rate.abs();
            if plane.rate.abs() <= 4.0 * plane.rate_error {
                // Along the plane: on it or below it all the way, or never.
                if plane.below < -plane.below_error {
                    return None;
                }
            } else if plane.rate > 0.0 && at < ends[1] {
                (ends[1], errors[1]) = (at, error);
            } else if plane.rate < 0.0 && at > ends[0] {
                (ends[0], errors[0]) = (at, error);
            }
        }
        if ends[0] >= ends[1] {
            return None;
        }
        let [a, b, c, d] = mesh.corners(cell);
        let (e, f, g) = (b - a, c - a, d - a);
        let volume = e.cross(f).dot(g);
        // Rounding of the volume, as a part of it.
        let volume_error = 16.0 * f64::EPSILON * e.length() * f.length() * g.length() / volume;
        let farthest = ends[0].abs().max(ends[1].abs());
        let coordinate_errors =
            planes.map(|p| (p.below_error + farthest * p.rate_error) / volume + volume_error + 4.0 * f64::EPSILON);
        Some(Self {
            cell: cell as u32,
            ends,
            errors,
            at: planes.map(|p| p.below / volume),
            rate: planes.map(|p| -p.rate / volume),
            coordinate_errors,
        })
    }

    /// Barycentric coordinates at a distance.
    pub(super) fn coordinates(&self, s: f64) -> [f64; 4] {
        std::array::from_fn(|i| self.at[i] + self.rate[i] * s)
    }

    /// Smallest barycentric coordinate at a distance: how deep in the cell that is.
    pub(super) fn depth(&self, s: f64) -> f64 {
        self.coordinates(s).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Interpolates numbers of the corners at two distances; with a bound on the error of both, and of all between them.
    pub(super) fn interpolated(&self, corners: [f64; 4], places: [f64; 2]) -> ([f64; 2], f64) {
        let low = corners.into_iter().fold(f64::INFINITY, f64::min);
        let high = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
        if low == high {
            return ([low; 2], 0.0);
        }
        let first = corners[0];
        let at = places.map(|s| {
            let coordinates = self.coordinates(s);
            let rise: f64 = (1..4).map(|i| (corners[i] - first) * coordinates[i]).sum();
            (first + rise).clamp(low, high)
        });
        let rounding: f64 = (1..4).map(|i| (corners[i] - first).abs() * self.coordinate_errors[i]).sum();
        // No value of the cell is beyond those of its corners.
        let error = rounding + 8.0 * f64::EPSILON * (first.abs() + (high - low));
        (at, if error < high - low { error } else { high - low })
    }

    /// Slope along the ray of numbers of the corners.
    pub(super) fn slope(&self, corners: [f64; 4]) -> f64 {
        (1..4).map(|i| (corners[i] - corners[0]) * self.rate[i]).sum()
    }
}
