//! Triangles as rays from anywhere meet them.

use vr_core::{FacetHit, Ray, SurfaceTracer, TriangleIndex};

use crate::sheared_ray::{Hit, ShearedRay};
use crate::surface::{Surface, flat_normal, smooth_normal};

/// A surface with an index of its triangles.
#[derive(Debug)]
pub(crate) struct MeshTracer {
    surface: Surface,
    index: TriangleIndex,
}

impl MeshTracer {
    pub(crate) fn new(surface: Surface) -> Self {
        let index = TriangleIndex::new(&surface.mesh);
        Self { surface, index }
    }

    /// The hit as light sees it: a matt surface, of which the shading's diffuse share of the colour is reflected.
    fn facet(&self, ray: &Ray, triangle: usize, hit: &Hit) -> FacetHit {
        let mesh = &*self.surface.mesh;
        let towards_eye = -ray.direction;
        let turned = |normal: glam::DVec3| if normal.dot(towards_eye) < 0.0 { -normal } else { normal };
        let flat = flat_normal(mesh, triangle);
        // Slivers may have no normal that f64 can tell.
        let facet_normal = turned(flat.try_normalize().unwrap_or(towards_eye));
        // Interpolated normals are on the facet's side; one that points away from the eye would make a dark rim.
        let smooth = smooth_normal(mesh, triangle, hit).map(|n| if n.dot(facet_normal) < 0.0 { -n } else { n });
        let normal = smooth.filter(|n| n.dot(towards_eye) > 0.0).unwrap_or(facet_normal);
        let color = self.surface.color_at(triangle, hit) * self.surface.shading.diffuse;
        let reflectance = color.to_array().map(|share| share.clamp(0.0, 1.0));
        FacetHit { distance: hit.distance, facet: triangle as u32, normal, facet_normal, reflectance }
    }
}

impl SurfaceTracer for MeshTracer {
    fn nearest(&self, ray: &Ray, [from, to]: [f64; 2], leaving: Option<u32>) -> Option<FacetHit> {
        let sheared = ShearedRay::new(ray);
        let mut nearest: Option<(usize, Hit)> = None;
        self.index.visit(ray, [from, to], |triangle| {
            let hit = sheared.intersect(self.surface.mesh.corners(triangle))?;
            if !(from..=to).contains(&hit.distance) || leaving == Some(triangle as u32) {
                return None;
            }
            // Of triangles at the same distance the first one counts, as in layers.
            let is_nearer = nearest.is_none_or(|(first, n)| (hit.distance, triangle) < (n.distance, first));
            if is_nearer {
                nearest = Some((triangle, hit));
            }
            Some(hit.distance)
        });
        nearest.map(|(triangle, hit)| self.facet(ray, triangle, &hit))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use vr_core::{Camera, Control, Rays, Shading, Surfaces, TriangleMesh, View};

    use super::*;

    /// A bowl of triangles.
    fn bowl() -> Surface {
        let edge = 12;
        let at = |i: u32, j: u32| {
            let [x, y] = [i, j].map(|n| 2.0 * f64::from(n) / f64::from(edge) - 1.0);
            DVec3::new(x, y, 0.4 * (x * x + y * y))
        };
        let places = (0..=edge).flat_map(|j| (0..=edge).map(move |i| at(i, j))).collect();
        let number = |i: u32, j: u32| j * (edge + 1) + i;
        let cell = |i: u32, j: u32| {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i, j + 1), number(i + 1, j + 1)];
            [[a, b, c], [b, d, c]]
        };
        let triangles = (0..edge).flat_map(|j| (0..edge).flat_map(move |i| cell(i, j))).collect();
        Surface::new(TriangleMesh::new(places, triangles).unwrap())
    }

    #[test]
    fn rays_meet_what_the_layer_shows() {
        let bowl = bowl();
        let tracer = bowl.tracer().unwrap();
        let view = View::new(Camera::framing(bowl.bounds(), 20.0, 35.0, Some(40.0)), [40, 30]);
        let layer = bowl.layer(&[], &view, &Control::default()).unwrap();
        let rays = Rays::new(&view).unwrap();
        let mut hits = 0;
        for pixel in 0..40 * 30 {
            let ray = rays.at((pixel % 40) as f64 + 0.5, (pixel / 40) as f64 + 0.5);
            let hit = tracer.nearest(&ray, [0.0, f64::INFINITY], None);
            // The layer rounds to f32.
            assert_eq!(hit.map_or(f32::INFINITY, |hit| hit.distance as f32), layer.pixels[pixel].1, "{pixel}");
            let Some(hit) = hit else { continue };
            hits += 1;
            assert!(hit.normal.dot(ray.direction) <= 0.0 && hit.facet_normal.dot(ray.direction) <= 0.0);
            assert!(hit.reflectance.iter().all(|share| (share - 0.8 * 0.7).abs() < 1e-12), "{hit:?}");
        }
        assert!(hits > 200, "{hits}");
    }

    #[test]
    fn a_facet_that_is_left_is_not_met_again() {
        let corners = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let shading = Shading { diffuse: 2.0, ..Shading::default() };
        let mesh = TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
        let tracer = Surface { mesh: Arc::new(mesh), color: Some([1.0, 0.25, 0.0]), shading }.tracer().unwrap();
        let ray = Ray { origin: DVec3::new(0.25, 0.25, 1.0), direction: DVec3::NEG_Z };
        let hit = tracer.nearest(&ray, [0.0, 5.0], None).unwrap();
        assert_eq!((hit.distance, hit.facet_normal, hit.reflectance), (1.0, DVec3::Z, [1.0, 0.5, 0.0]));
        assert_eq!(tracer.nearest(&ray, [0.0, 5.0], Some(0)), None);
        assert_eq!(tracer.nearest(&ray, [0.0, 0.5], None), None);
        assert_eq!([DVec3::Z, DVec3::NEG_Z].map(|towards| hit.cosine(towards)), [1.0, 0.0]);
    }
}
