//! A mesh that has been prepared, and its pictures.

use std::ops::ControlFlow;
use std::sync::Arc;

use glam::DVec3;
use vr_core::image_order::{ImageSample, trace_view};
use vr_core::{
    CellMesh, Compositing, Control, Counts, Frame, Layer, Model, Prepared, Ray, RayShading, RenderError, RenderStats,
    Rendered, Scene, View,
};

use crate::accumulators::{Gathered, Seen};
use crate::camera_space::CameraSpace;
use crate::medium::{ExtinctionTable, Medium};
use crate::walk::Part;

use super::bins::Bins;
use super::fragments::Fragments;
use super::projector::CellProjector;
use super::screen::Screen;

/// A scene and its mesh.
pub(super) struct PreparedProjector {
    renderer: CellProjector,
    scene: Scene,
    mesh: Arc<CellMesh>,
}

impl PreparedProjector {
    pub(super) fn new(renderer: CellProjector, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let mesh = renderer.check(scene)?;
        control.check()?;
        Ok(Self { renderer, scene: scene.clone(), mesh })
    }

    /// True if a cell may be seen, by its values.
    fn is_seen(&self, cell: usize) -> bool {
        if !matches!(self.scene.compositing, Compositing::Over | Compositing::Accumulate { .. }) {
            return true;
        }
        let values = self.mesh.corner_values(cell);
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let segments = self.scene.transfer.segments();
        let first = segments.partition_point(|s| s.to < low);
        segments[first..].iter().take_while(|s| s.from <= high).any(|s| !s.is_clear())
    }

    /// Draws every ray by itself, with values alone (`N` = 1) or with gradients (`N` = 4).
    fn draw_rays<const N: usize>(
        &self,
        view: &View,
        control: &Control,
        layer: Option<&Layer>,
        stats: &mut RenderStats,
    ) -> Result<Vec<Seen>, RenderError> {
        let scene = &self.scene;
        let camera = CameraSpace::new(view)?;
        let screen = Screen::new(view, 1, self.mesh.mean_spacing());
        let vertices = stats.time("vertices", || camera.vertices::<N>(&self.mesh));
        let bins =
            stats.time("bins", || control.run(|| Bins::new(&self.mesh, &vertices, &screen, |cell| self.is_seen(cell))));
        let fragments =
            Fragments { mesh: &self.mesh, vertices: &vertices, bins: &bins, nudge: 1e-10 * self.mesh.mean_spacing() };
        let modulation =
            scene.shading.as_deref().filter(|_| scene.has_gradient_opacity() && !scene.transfer.has_rows());
        let extinction = ExtinctionTable::new(&scene.transfer);
        let medium = Medium { transfer: &scene.transfer, modulation, extinction: &extinction };
        let reflection = scene.reflection();
        type Scratch<const N: usize> = (Vec<Part<N>>, Option<(DVec3, RayShading<f64>)>);
        let scratch = || -> Scratch<N> { (Vec::new(), None) };
        let trace = |(found, shading): &mut Scratch<N>, ray: &Ray, sample: ImageSample, counts: &mut Counts| {
            let far = layer.map_or(f64::INFINITY, |layer| layer.depth(sample.pixel));
            let mut seen = Seen::NOTHING;
            if let Some([from, to]) = ray.inside(&view.clip)
                && from < to.min(far)
            {
                if let Some(reflection) = reflection
                    && shading.as_ref().is_none_or(|(direction, _)| *direction != ray.direction)
                {
                    *shading = Some((ray.direction, reflection.along(&scene.lights, ray.direction)));
                }
                let shade = shading.as_ref().map(|(_, shade)| shade);
                let mut gathered = Gathered::new(scene.compositing, &medium, shade, self.renderer.termination);
                let mut parts = 0u64;
                let mut take = |part: &Part<N>| -> ControlFlow<()> {
                    parts += 1;
                    gathered.take(part)
                };
                fragments.along(&camera.axis(ray), [sample.x, sample.y], [from, to.min(far)], found, &mut take);
                counts.rays += u64::from(parts > 0);
                counts.samples += parts;
                seen = gathered.seen();
            }
            layer.map_or(seen, |layer| Seen {
                rgba: layer.under(sample.pixel, seen.rgba),
                depth: seen.depth.min(layer.depth(sample.pixel)),
            })
        };
        let (seen, counts) = stats.time("fragments", || trace_view(view, control, scratch, trace))?;
        stats.counts += counts;
        Ok(seen)
    }
}

impl Prepared for PreparedProjector {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let mesh = self.renderer.check(scene)?;
        control.check()?;
        self.mesh = mesh;
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        self.renderer.check_view(view)?;
        control.check()?;
        let mut stats = RenderStats::default();
        let layer = self.scene.layer(view, control)?;
        let needs_gradients = self.scene.reflection().is_some() || self.scene.has_gradient_opacity();
        let seen = if needs_gradients {
            self.draw_rays::<4>(view, control, layer.as_ref(), &mut stats)?
        } else {
            self.draw_rays::<1>(view, control, layer.as_ref(), &mut stats)?
        };
        let pixels = seen.iter().map(|s| s.rgba.map(|x| x as f32)).collect();
        let depth = seen.iter().map(|s| s.depth as f32).collect();
        Ok(Rendered { frame: Frame::new(view.size, pixels, Some(depth)), stats })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}
