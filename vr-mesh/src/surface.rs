//! A mesh, and its colour and light where a ray hits it.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{
    Control, Layer, Light, ParameterError, RayShading, RenderError, Scene, Shading, SurfaceTracer, Surfaces,
    TriangleMesh, View,
};

use crate::rasterize::rasterize;
use crate::sheared_ray::Hit;
use crate::tracer::MeshTracer;

/// A surface of triangles, with its colour and shading.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The triangles.
    pub mesh: Arc<TriangleMesh>,
    /// One colour all over, in linear RGB; `None`: the mesh's own colours, or [`Surface::COLOR`] where it has none.
    pub color: Option<[f64; 3]>,
    /// Reflection of the scene's lights: Blinn-Phong, two-sided. Its settings for gradients are not used.
    pub shading: Shading,
}

impl Surface {
    /// The colour of a surface that has none: a light grey.
    pub const COLOR: [f64; 3] = [0.8; 3];

    /// A surface in the mesh's own colours, shaded by the default coefficients.
    pub fn new(mesh: TriangleMesh) -> Self {
        Self { mesh: Arc::new(mesh), color: None, shading: Shading::default() }
    }

    /// A surface of a scene, in one colour or the mesh's own: it reflects as the scene's volume does, and by the default coefficients where that
    /// is not shaded, since a mesh that nothing lights would be flat.
    pub fn in_scene(mesh: Arc<TriangleMesh>, color: Option<[f64; 3]>, scene: &Scene) -> Self {
        Self { mesh, color, shading: scene.shading.as_deref().cloned().unwrap_or_default() }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// A colour that is negative or not finite, or as [`Shading::validate`].
    pub fn validate(&self) -> Result<(), ParameterError> {
        if self.color.is_some_and(|c| c.iter().any(|&x| !(x >= 0.0 && x.is_finite()))) {
            let allowed = "must be three numbers, finite and not negative";
            return Err(ParameterError::new("mesh.color", self.color.unwrap_or_default(), allowed));
        }
        self.shading.validate()
    }

    /// Linear RGB of the light that a point of a triangle sends back along a ray, `shading` being this surface's along it.
    pub(crate) fn light(&self, triangle: usize, hit: &Hit, shading: &RayShading<f64>) -> [f32; 3] {
        let color = self.color_at(triangle, hit);
        let normal = smooth_normal(&self.mesh, triangle, hit).unwrap_or_else(|| flat_normal(&self.mesh, triangle));
        let (factor, added) = shading.reflect(normal.to_array());
        std::array::from_fn(|c| (color[c] * factor[c] + added[c]) as f32)
    }

    /// Linear RGB of a point of a triangle.
    pub(crate) fn color_at(&self, triangle: usize, hit: &Hit) -> DVec3 {
        let corners = self.mesh.triangles()[triangle];
        let between = |values: &[[f32; 3]]| {
            let value = |i: usize| DVec3::from(values[corners[i] as usize].map(f64::from));
            (0..3).map(|i| value(i) * hit.weights[i]).sum::<DVec3>()
        };
        match (self.color, self.mesh.colors()) {
            (Some(color), _) => DVec3::from(color),
            (None, Some(colors)) => between(colors),
            (None, None) => DVec3::from(Self::COLOR),
        }
    }
}

impl Surfaces for Surface {
    fn layer(&self, lights: &[Light], view: &View, control: &Control) -> Result<Layer, RenderError> {
        rasterize(self, lights, view, control)
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        self.mesh.bounds()
    }

    fn can_be_traced(&self) -> bool {
        true
    }

    fn tracer(&self) -> Option<Arc<dyn SurfaceTracer>> {
        Some(Arc::new(MeshTracer::new(self.clone())))
    }
}

/// The triangle's own normal, of any length.
pub(crate) fn flat_normal(mesh: &TriangleMesh, triangle: usize) -> DVec3 {
    let [a, b, c] = mesh.corners(triangle);
    (b - a).cross(c - a)
}

/// Interpolates the normals at the corners; `None` where one is absent, or they cancel.
pub(crate) fn smooth_normal(mesh: &TriangleMesh, triangle: usize, hit: &Hit) -> Option<DVec3> {
    let normals = mesh.normals()?;
    let mut sum = DVec3::ZERO;
    for (&vertex, weight) in mesh.triangles()[triangle].iter().zip(hit.weights) {
        sum += DVec3::from(normals[vertex as usize].map(f64::from)).try_normalize()? * weight;
    }
    sum.try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> TriangleMesh {
        TriangleMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]).unwrap()
    }

    /// The light of the point with these weights, seen along −z.
    fn light(surface: &Surface, weights: [f64; 3]) -> [f32; 3] {
        let along = surface.shading.along(&[Light::default()], DVec3::NEG_Z);
        surface.light(0, &Hit { distance: 1.0, weights }, &along)
    }

    #[test]
    fn colours_are_the_surfaces_or_the_corners_or_grey() {
        // Ambient light alone gives colours back as they are.
        let shading = Shading { ambient: 1.0, diffuse: 0.0, specular: 0.0, ..Shading::default() };
        let plain = Surface { shading, ..Surface::new(corner()) };
        assert_eq!(light(&plain, [0.2, 0.3, 0.5]), [0.8; 3]);
        let colors = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]];
        let colored = Surface { mesh: Arc::new(corner().with_colors(colors).unwrap()), ..plain };
        assert_eq!(light(&colored, [0.25, 0.5, 0.25]), [0.25, 0.5, 0.5]);
        let red = Surface { color: Some([1.0, 0.0, 0.0]), ..colored };
        assert_eq!(light(&red, [0.25, 0.5, 0.25]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn normals_are_the_corners_or_the_triangles() {
        let shading = Shading { ambient: 0.0, diffuse: 1.0, specular: 0.0, ..Shading::default() };
        let facing = |mesh: TriangleMesh| {
            let surface = Surface { color: Some([1.0; 3]), shading: shading.clone(), ..Surface::new(mesh) };
            light(&surface, [0.0, 0.5, 0.5])[0]
        };
        assert_eq!(facing(corner()), 1.0, "it faces the eye");
        let at = |b: [f32; 3], c: [f32; 3]| corner().with_normals(vec![[0.0, 0.0, 3.0], b, c]).unwrap();
        // Between (0.6, 0, 0.8) and (−0.6, 0, 0.8) of any length is z.
        assert!((facing(at([6.0, 0.0, 8.0], [-0.6, 0.0, 0.8])) - 1.0).abs() < 1e-7);
        assert!((facing(at([0.6, 0.0, 0.8], [0.6, 0.0, 0.8])) - 0.8).abs() < 1e-7);
        for absent in [[0.0; 3], [f32::NAN; 3], [-1.0, 0.0, 0.0]] {
            assert_eq!(facing(at([1.0, 0.0, 0.0], absent)), 1.0, "{absent:?}: the triangle's own");
        }
    }

    #[test]
    fn colours_that_are_none_are_refused() {
        for x in [-1.0, f64::NAN] {
            let wrong = Surface { color: Some([0.0, x, 0.0]), ..Surface::new(corner()) };
            assert_eq!(wrong.validate().unwrap_err().field, "mesh.color");
        }
        assert!(Surface::new(corner()).validate().is_ok());
    }
}
