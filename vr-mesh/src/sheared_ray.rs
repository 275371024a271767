//! Intersection of a ray with triangles, without gaps between those that share an edge.

use glam::DVec3;
use vr_core::Ray;

/// A ray, and the shear that makes its direction the axis of a space in which it runs through (0, 0).
///
/// The signs of three products of 2×2, one an edge, then tell if it hits a triangle (Woop, Benthin & Wald, *Watertight
/// Ray/Triangle Intersection*, JCGT 2013). Corners that are equal bit by bit get equal places there, whichever triangle asks, and
/// rounding is monotonic: a computed sign is right, or the product is 0 and counts as either. So a point of a surface that is covered
/// exactly is covered. Here in f64, where the paper's second try at zeros is not needed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: DVec3,
    /// The world axes that become x, y and z: z is the one that the direction is nearest to.
    axes: [usize; 3],
    shear: [f64; 3],
}

/// Intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// World distance along the ray; negative behind its origin.
    pub(crate) distance: f64,
    /// Barycentric weight of each corner, in [0, 1]; they add up to 1.
    pub(crate) weights: [f64; 3],
}

impl ShearedRay {
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let size = d.abs();
        let z = if size.z >= size.x.max(size.y) { 2 } else { usize::from(size.y >= size.x) };
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Self { origin: ray.origin, axes, shear: [d[axes[0]] / d[z], d[axes[1]] / d[z], 1.0 / d[z]] }
    }

    /// Intersects the ray with a triangle, seen from either side; `None` where it misses it, or runs within its plane.
    #[inline]
    pub(crate) fn intersect(&self, corners: [DVec3; 3]) -> Option<Hit> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|p| {
            let v = p - self.origin;
            [v[x] - self.shear[0] * v[z], v[y] - self.shear[1] * v[z], v[z]]
        });
        // Twice the areas of the triangles that the ray makes with the edges opposite to a, b and c: all of one sign where it hits.
        let areas = [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]];
        if areas.iter().any(|&e| e < 0.0) && areas.iter().any(|&e| e > 0.0) {
            return None;
        }
        let all = areas[0] + areas[1] + areas[2];
        // False for NaN, too: what overflows is not seen.
        if !(all.abs() > 0.0 && all.is_finite()) {
            return None;
        }
        // The areas are the corners' weights; the sheared z of the point gives its distance.
        let weights = areas.map(|e| e / all);
        let along = weights[0] * a[2] + weights[1] * b[2] + weights[2] * c[2];
        Some(Hit { distance: along * self.shear[2], weights })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> ShearedRay {
        ShearedRay::new(&Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() })
    }

    #[test]
    fn meets_from_either_side_where_it_does() {
        let corners = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0];
        for (z, distance) in [(3.0, 3.0), (-3.0, -3.0)] {
            for corners in [corners, [corners[1], corners[0], corners[2]]] {
                let met = ray([1.0, 2.0, z], [0.0, 0.0, -1.0]).intersect(corners).unwrap();
                assert_eq!(met.distance, distance);
                let p: DVec3 = (0..3).map(|i| corners[i] * met.weights[i]).sum();
                assert_eq!(p, DVec3::new(1.0, 2.0, 0.0));
            }
        }
        assert_eq!(ray([3.0, 2.0, 3.0], [0.0, 0.0, -1.0]).intersect(corners), None);
        assert_eq!(ray([1.0, 2.0, 0.0], [1.0, 0.0, 0.0]).intersect(corners), None, "within the plane");
        let oblique = ray([5.0, 0.5, 4.0], [-1.0, 0.25, -1.0]).intersect(corners).unwrap();
        assert!((oblique.distance - 4.0 * 2.0625f64.sqrt()).abs() < 1e-14, "{oblique:?}");
    }

    #[test]
    fn edges_and_corners_count_for_all_that_share_them() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        for at in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.5], [0.25, 0.0]] {
            assert!(ray([at[0], at[1], 1.0], [0.0, 0.0, -1.0]).intersect(corners).is_some(), "{at:?}");
        }
        let point = [DVec3::ONE; 3];
        assert_eq!(ray([1.0, 1.0, 5.0], [0.0, 0.0, -1.0]).intersect(point), None, "no area");
    }
}
