//! A mesh that has been prepared, and its pictures.

use std::sync::Arc;

use vr_core::image_order::{ImageSample, trace_pixels, trace_view};
use vr_core::memory;
use vr_core::{
    CellMesh, Control, Counts, Layer, Model, Prepared, Ray, RenderError, RenderStats, Rendered, Scene, View,
};

use crate::accumulators::{Seen, is_whole_light};
use crate::camera_space::{CameraSpace, CameraVertex};
use crate::capabilities::needs_gradients;
use crate::entries::{Entries, SurfaceFace, surface};
use crate::medium::{ExtinctionTable, Medium};
use crate::single_rays::{Scratch, SingleRays};
use crate::walk::Walker;

use super::projector::CellProjector;
use super::segment_table::SegmentTable;
use super::sorted::{Sorted, SortedScene};

/// A scene and its mesh.
pub(super) struct PreparedProjector {
    renderer: CellProjector,
    scene: Scene,
    mesh: Arc<CellMesh>,
    surface: Vec<SurfaceFace>,
    /// Integrals of the transfer function; none where the scene has to be drawn ray by ray.
    table: Option<SegmentTable>,
}

impl PreparedProjector {
    pub(super) fn new(renderer: CellProjector, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let mesh = renderer.check(scene)?;
        control.check()?;
        let (surface, table) = (surface(&mesh), table_of(scene, &mesh));
        Ok(Self { renderer, scene: scene.clone(), mesh, surface, table })
    }

    /// Draws cell by cell, where the scene allows it.
    fn draw_sorted(
        &self,
        view: &View,
        control: &Control,
        layer: Option<&Layer>,
        stats: &mut RenderStats,
    ) -> Result<Option<Sorted>, RenderError> {
        let Some(table) = &self.table else { return Ok(None) };
        SortedScene { renderer: &self.renderer, scene: &self.scene, surface: &self.surface, table }
            .draw(view, control, layer, stats)
    }

    /// Draws rays by themselves, with values alone (`N` = 1) or with gradients (`N` = 4): those of some pixels, or all.
    fn draw_rays<const N: usize>(
        &self,
        view: &View,
        control: &Control,
        layer: Option<&Layer>,
        stats: &mut RenderStats,
        pixels: Option<&[[u32; 2]]>,
    ) -> Result<Vec<Seen>, RenderError> {
        let scene = &self.scene;
        let camera = CameraSpace::new(view)?;
        let bytes = self.mesh.vertices().len() * size_of::<CameraVertex<N>>();
        memory::check("the mesh of cells before the camera", bytes as u64)?;
        let vertices = stats.time("vertices", || camera.vertices::<N>(&self.mesh));
        let entries = stats.time("entries", || Entries::new(&self.surface, &self.mesh, &vertices, view));
        let walker = Walker::new(&self.mesh, &vertices, &entries);
        let extinction = ExtinctionTable::new(&scene.transfer);
        let medium = Medium::of(scene, &extinction);
        let single = SingleRays { scene, medium: &medium, view, layer, termination: self.renderer.termination };
        let trace = |scratch: &mut Scratch<(f64, SurfaceFace)>, ray: &Ray, sample: ImageSample, counts: &mut Counts| {
            single.draw(scratch, ray, sample, counts, |part, found, take| {
                walker.walk(&camera.axis(ray), [sample.x, sample.y], part, found, take);
            })
        };
        let (seen, counts) = stats.time("rays", || match pixels {
            Some(pixels) => trace_pixels(view, pixels, control, Scratch::default, trace),
            None => trace_view(view, control, Scratch::default, trace),
        })?;
        stats.counts += counts;
        Ok(seen)
    }
}

/// Returns the integrals of a scene's transfer function, if light is all that it asks for.
fn table_of(scene: &Scene, mesh: &CellMesh) -> Option<SegmentTable> {
    let (low, high) = mesh.value_range();
    let is_plain = is_whole_light(scene.compositing) && !needs_gradients(scene);
    if is_plain { SegmentTable::new(&scene.transfer, [low, high]) } else { None }
}

impl Prepared for PreparedProjector {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let mesh = self.renderer.check(scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            self.surface = surface(&mesh);
        }
        self.table = table_of(scene, &mesh);
        self.mesh = mesh;
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        self.renderer.check_view(view)?;
        control.check()?;
        let mut stats = RenderStats::default();
        let layer = self.scene.layer(view, control)?;
        let layer = layer.as_ref();
        let seen = if needs_gradients(&self.scene) {
            self.draw_rays::<4>(view, control, layer, &mut stats, None)?
        } else if let Some(sorted) = self.draw_sorted(view, control, layer, &mut stats)? {
            let mut pixels = sorted.pixels;
            if !sorted.left.is_empty() {
                let left = self.draw_rays::<1>(view, control, layer, &mut stats, Some(&sorted.left))?;
                for ([x, y], seen) in sorted.left.iter().zip(left) {
                    pixels[(y * view.size[0] + x) as usize] = seen;
                }
            }
            pixels
        } else {
            self.draw_rays::<1>(view, control, layer, &mut stats, None)?
        };
        Ok(Rendered { frame: Seen::frame(&seen, view), stats })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}
