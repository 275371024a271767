//! Rays that are drawn one at a time, in f64: every operator, with shading, clips and opaque surfaces.
//!
//! Both renderers draw so what they cannot draw faster; they differ in how a ray finds its parts inside cells.

use std::ops::ControlFlow;

use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{Counts, Layer, Ray, RayShading, Scene, View};

use crate::accumulators::{Gathered, Seen};
use crate::medium::Medium;
use crate::walk::Part;

/// A scene in a view.
pub(crate) struct SingleRays<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) medium: &'a Medium<'a>,
    pub(crate) view: &'a View,
    pub(crate) layer: Option<&'a Layer>,
    /// Opacity at which a ray may end.
    pub(crate) termination: f64,
}

/// Memory that one ray leaves to the next: a buffer, and the shading along a direction, which many rays may share.
pub(crate) struct Scratch<T> {
    pub(crate) found: Vec<T>,
    shading: Option<(DVec3, RayShading<f64>)>,
}

impl<T> Default for Scratch<T> {
    fn default() -> Self {
        Self { found: Vec::new(), shading: None }
    }
}

impl SingleRays<'_> {
    /// Draws a ray. `walk` gets the distances between which it is drawn, and calls the function that it is given with every part inside a cell, in order.
    pub(crate) fn draw<const N: usize, T>(
        &self,
        scratch: &mut Scratch<T>,
        ray: &Ray,
        sample: ImageSample,
        counts: &mut Counts,
        walk: impl FnOnce([f64; 2], &mut Vec<T>, &mut dyn FnMut(&Part<N>) -> ControlFlow<()>),
    ) -> Seen {
        let Scratch { found, shading } = scratch;
        let far = self.layer.map_or(f64::INFINITY, |layer| layer.depth(sample.pixel));
        let mut seen = Seen::NOTHING;
        if let Some([from, to]) = ray.inside(&self.view.clip)
            && from < to.min(far)
        {
            if let Some(reflection) = self.scene.reflection()
                && shading.as_ref().is_none_or(|(direction, _)| *direction != ray.direction)
            {
                *shading = Some((ray.direction, reflection.along(&self.scene.lights, ray.direction)));
            }
            let shade = shading.as_ref().map(|(_, shade)| shade);
            let mut gathered = Gathered::new(self.scene.compositing, self.medium, shade, self.termination);
            let mut parts = 0u64;
            let mut take = |part: &Part<N>| -> ControlFlow<()> {
                parts += 1;
                gathered.take(part)
            };
            walk([from, to.min(far)], found, &mut take);
            counts.rays += u64::from(parts > 0);
            counts.samples += parts;
            seen = gathered.seen();
        }
        seen.before(self.layer, sample.pixel)
    }
}
