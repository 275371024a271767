//! Optical depth towards a light, tabulated: a fast way to the same shadows, with an error of its own.

use glam::DVec3;
use rayon::prelude::*;
use vr_core::{Ray, RenderError, Scene, View};
use vr_physics::{RaySegment, Reference};

use crate::marched::is_beside;

/// Optical depths towards one light on a lattice that is aligned with it (Lokovic & Veach, "Deep shadow maps", 2000, on a regular lattice).
#[derive(Clone, Debug)]
pub(super) struct ShadowVolume {
    /// Two unit vectors across the light, and one towards it.
    axes: [DVec3; 3],
    /// Coordinates of the first node on each axis, and distances of nodes.
    low: [f64; 3],
    step: [f64; 3],
    /// Nodes along each axis: an odd number.
    nodes: usize,
    /// Depths, those along the light beside each other.
    depths: Vec<f32>,
}

impl ShadowVolume {
    /// Tabulates a light from this direction: one ray of the reference for each pair of coordinates across the light.
    pub(super) fn new(
        reference: &Reference,
        scene: &Scene,
        view: &View,
        towards: DVec3,
        nodes: usize,
    ) -> Result<Self, RenderError> {
        let (a, b) = towards.any_orthonormal_pair();
        let axes = [a, b, towards];
        // The box around the volume, in coordinates of the light.
        let (low, high) = scene.volume.bounds();
        let corner =
            |i: usize| DVec3::new([low.x, high.x][i & 1], [low.y, high.y][i >> 1 & 1], [low.z, high.z][i >> 2]);
        let range = axes.map(|axis| {
            let along = (0..8).map(|i| corner(i).dot(axis));
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], x| [min.min(x), max.max(x)])
        });
        let low = range.map(|r| r[0]);
        let step = range.map(|r| (r[1] - r[0]) / (nodes - 1) as f64);
        let length = range[2][1] - range[2][0];
        // Light travels down the last axis: the node farthest along it is met first.
        let places: Vec<f64> = (0..nodes).map(|k| length + length - step[2] * k as f64).collect();
        let column = |index: usize| -> Result<Vec<f32>, RenderError> {
            let (i, j) = (index / nodes, index % nodes);
            let across = (low[0] + step[0] * i as f64) * a + (low[1] + step[1] * j as f64) * b;
            let ray = Ray { origin: across + (range[2][1] + length) * towards, direction: -towards };
            let segments = reference.segments(scene, view, &ray, &places)?;
            Ok(places.iter().map(|&s| depth_up_to(&segments, s, length) as f32).collect())
        };
        let columns: Vec<Vec<f32>> = (0..nodes * nodes).into_par_iter().map(column).collect::<Result<_, _>>()?;
        Ok(Self { axes, low, step, nodes, depths: columns.concat() })
    }

    /// Transmittance from a place to the light, and an estimate of its error: twice the difference to that of every second node alone, for beside
    /// an edge of a
    /// shadow error falls no faster than the step.
    pub(super) fn transmittance(&self, at: DVec3) -> [f64; 2] {
        let fine = libm::exp(-self.depth(at, 1));
        let coarse = libm::exp(-self.depth(at, 2));
        [fine, 2.0 * (fine - coarse).abs()]
    }

    /// Depth at a place, linear between every `stride`th node.
    fn depth(&self, at: DVec3, stride: usize) -> f64 {
        let last = (self.nodes - 1) / stride;
        let mut first = [0; 3];
        let mut part = [0.0; 3];
        for axis in 0..3 {
            let x = (at.dot(self.axes[axis]) - self.low[axis]) / (self.step[axis] * stride as f64);
            // Light to the sides of the box passes by it.
            if axis < 2 && is_beside(x, last + 1) {
                return 0.0;
            }
            first[axis] = (x.max(0.0) as usize).min(last - 1);
            part[axis] = (x - first[axis] as f64).clamp(0.0, 1.0);
        }
        let node = |di: usize, dj: usize, dk: usize| {
            let [i, j, k] = [first[0] + di, first[1] + dj, first[2] + dk].map(|n| n * stride);
            f64::from(self.depths[(i * self.nodes + j) * self.nodes + k])
        };
        let mix = |t: f64, a: f64, b: f64| a + t * (b - a);
        let line = |di: usize, dj: usize| mix(part[2], node(di, dj, 0), node(di, dj, 1));
        let sheet = |di: usize| mix(part[1], line(di, 0), line(di, 1));
        mix(part[0], sheet(0), sheet(1))
    }
}

/// Optical depth of a ray up to a place at which it was cut.
fn depth_up_to(segments: &[RaySegment], place: f64, length: f64) -> f64 {
    let end = segments.partition_point(|segment| segment.to <= place + 1e-9 * length);
    end.checked_sub(1).and_then(|last| segments[last].light).map_or(0.0, |light| light.depth)
}
