//! Vertices of a mesh in pixels, for rays in `f32`.

use vr_core::transfer::Segment;
use vr_core::{CellMesh, View};

use crate::camera_space::{CameraVertex, gradient};

/// A vertex on the screen: x and y in pixels from the middle, the depth between −1 and 1, and the value between 0 and 1 over the range of the mesh. Each is a
/// sum of two, so that its distance from a place near by is good to the last bits.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct ScreenVertex {
    /// x and y, and what they lack.
    pub(crate) place: [f32; 4],
    /// Depth and value, and what they lack.
    pub(crate) depth_value: [f32; 4],
}

impl ScreenVertex {
    /// Depth and value.
    #[inline]
    pub(crate) fn depth_value(&self) -> [f64; 2] {
        let [depth, value, depth_rest, value_rest] = self.depth_value.map(f64::from);
        [depth + depth_rest, value + value_rest]
    }
}

/// The gradient at a vertex, by the largest component of all; a fourth number that means nothing.
pub(crate) type ScreenGradient = [f32; 4];

/// A mesh in front of the eye.
pub(crate) struct Projected {
    pub(crate) vertices: Vec<ScreenVertex>,
    /// Gradients of the vertices; none where nothing is shaded.
    pub(crate) gradients: Vec<ScreenGradient>,
    /// Gradient of 1.
    pub(crate) slope: f64,
    /// Depth of 0, and the distance to the depth of 1.
    pub(crate) depth: [f64; 2],
    /// Scale of distances on the screen, less 1, for each unit of depth: 0 in parallel projection.
    pub(crate) widening: f32,
    /// Value of 0, and the distance to the value of 1.
    pub(crate) value: [f64; 2],
}

/// A number as a sum of two of half the length.
#[inline]
pub(crate) fn in_two(x: f64) -> [f32; 2] {
    let high = x as f32;
    [high, (x - f64::from(high)) as f32]
}

/// Smallest depth of a vertex, as part of the largest, that counts as in front of the eye.
const IN_FRONT: f64 = 1e-3;

/// Smallest part of the values' range over which a transfer function may change, so that values in `f32` resolve it.
const NARROW: f64 = 1e-3;

impl Projected {
    /// Bytes that each vertex takes, with its gradient.
    pub(crate) const BYTES_PER_VERTEX: usize = size_of::<ScreenVertex>() + size_of::<ScreenGradient>();

    /// The mesh in a view; `None` if part of it is beside or behind the eye, or if its values need more digits.
    pub(crate) fn new<const N: usize>(
        mesh: &CellMesh,
        vertices: &[CameraVertex<N>],
        view: &View,
        segments: &[Segment],
    ) -> Option<Self> {
        let projection = view.camera.projection;
        let (perspective, per_unit) = (projection.is_perspective(), f64::from(view.size[1]) / projection.height());
        let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
        for vertex in vertices {
            (near, far) = (near.min(vertex.at[2]), far.max(vertex.at[2]));
        }
        let is_solid = near < far;
        if !is_solid || (perspective && near < IN_FRONT * far) {
            return None;
        }
        let (low, high) = mesh.value_range();
        let range = if high > low { high - low } else { 1.0 };
        let narrow = |s: &&Segment| s.from.is_finite() && s.to.is_finite() && s.to - s.from < NARROW * range;
        if segments.iter().any(|s| narrow(&s) && s.to >= low && s.from <= high) {
            return None;
        }
        let (middle, half) = (0.5 * (near + far), 0.5 * (far - near));
        let on_screen = |v: &CameraVertex<N>| {
            let [x, y, z] = v.at;
            let scale = if perspective { per_unit / z } else { per_unit };
            let ([x, x_rest], [y, y_rest]) = (in_two(x * scale), in_two(y * scale));
            let ([depth, depth_rest], [value, value_rest]) =
                (in_two((z - middle) / half), in_two((v.attributes[0] - low) / range));
            ScreenVertex { place: [x, y, x_rest, y_rest], depth_value: [depth, value, depth_rest, value_rest] }
        };
        let (gradients, slope) = scaled_gradients(vertices);
        let vertices: Vec<_> = vertices.iter().map(on_screen).collect();
        // Far beside the picture, products of places would overflow.
        if vertices.iter().any(|v| !(v.place[0].abs() < 1e15 && v.place[1].abs() < 1e15)) {
            return None;
        }
        let widening = if perspective { (half / middle) as f32 } else { 0.0 };
        Some(Self { vertices, gradients, slope, depth: [middle, half], widening, value: [low, range] })
    }
}

/// The gradients of vertices by the largest of their components, and that.
fn scaled_gradients<const N: usize>(vertices: &[CameraVertex<N>]) -> (Vec<ScreenGradient>, f64) {
    let gradients = || vertices.iter().filter_map(|vertex| gradient(&vertex.attributes));
    let largest = gradients().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let slope = if largest > 0.0 { largest } else { 1.0 };
    let scaled = |[x, y, z]: [f64; 3]| [x / slope, y / slope, z / slope, 0.0].map(|x| x as f32);
    (gradients().map(scaled).collect(), slope)
}
