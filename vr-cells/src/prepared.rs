//! A mesh that has been prepared, and its pictures.

use std::sync::{Arc, Mutex, OnceLock};

use vr_core::cells::CellValues;
use vr_core::image_order::{ImageSample, trace_view};
use vr_core::memory::{self, MemoryError};
use vr_core::{
    CellMesh, Control, Counts, Layer, Model, Prepared, Ray, RenderError, RenderStats, Rendered, Scene, View,
};

use crate::accumulators::{Seen, is_whole_light};
use crate::camera_space::{CameraSpace, CameraVertex};
use crate::capabilities::{check, needs_gradients};
use crate::entries::{Entries, SurfaceFace, surface};
use crate::marcher::CellMarcher;
use crate::medium::{ExtinctionTable, Medium};
use crate::packet::{Links, Packets, Projected, Segments};
use crate::single_rays::{Scratch, SingleRays};
use crate::walk::Walker;

/// A scene, and the surface of its mesh.
pub(crate) struct PreparedMarcher {
    renderer: CellMarcher,
    scene: Scene,
    mesh: Arc<CellMesh>,
    surface: Vec<SurfaceFace>,
    /// Links of the mesh, made for the first picture that needs them; `None` inside for a mesh that has too many.
    links: OnceLock<Option<Links>>,
}

impl PreparedMarcher {
    pub(crate) fn new(renderer: CellMarcher, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let mesh = check(&renderer, scene)?;
        control.check()?;
        let surface = surface(&mesh);
        Ok(Self { renderer, scene: scene.clone(), mesh, surface, links: OnceLock::new() })
    }

    /// The links of the mesh, for rays in packets.
    fn links(&self) -> Result<Option<&Links>, MemoryError> {
        if self.links.get().is_none() {
            memory::check("the links of the mesh of cells", Links::bytes(&self.mesh))?;
        }
        Ok(self.links.get_or_init(|| Links::new(&self.mesh)).as_ref())
    }

    /// True if the picture is that of light, which packets draw: of values at vertices, without emission, and without opacity by the gradient.
    fn is_light(&self) -> bool {
        let scene = &self.scene;
        let of_vertices = matches!(self.mesh.values(), CellValues::Vertices(_));
        is_whole_light(scene.compositing)
            && of_vertices
            && !scene.transfer.has_emission()
            && !scene.has_gradient_opacity()
    }

    /// Draws with values alone (`N` = 1), or with gradients (`N` = 4).
    fn draw<const N: usize>(
        &self,
        view: &View,
        control: &Control,
        layer: Option<&Layer>,
        stats: &mut RenderStats,
    ) -> Result<Vec<Seen>, RenderError> {
        let scene = &self.scene;
        let camera = CameraSpace::new(view)?;
        let of_vertex = size_of::<CameraVertex<N>>() + Projected::BYTES_PER_VERTEX;
        memory::check("the mesh of cells on the screen", (self.mesh.vertices().len() * of_vertex) as u64)?;
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
        let links = if self.is_light() { self.links()? } else { None };
        let segments = scene.transfer.segments();
        let in_packets = links.and_then(|links| Some((links, Projected::new(&self.mesh, &vertices, view, segments)?)));
        let (seen, counts) = stats.time("march", || match in_packets {
            Some((links, projected)) => {
                let packets = Packets::<N> {
                    mesh: &self.mesh,
                    links,
                    projected: &projected,
                    segments: &Segments::new(&scene.transfer, &projected),
                    entries: &entries,
                    camera: &camera,
                    medium: &medium,
                    view,
                    layer,
                    opaque: 1.0 - self.renderer.termination,
                    lit: scene.reflection().map(|shading| (&**shading, &scene.lights[..])),
                    buffers: Mutex::default(),
                };
                packets.draw(control, |ray, sample, counts| trace(&mut Scratch::default(), ray, sample, counts))
            }
            None => trace_view(view, control, Scratch::default, trace),
        })?;
        stats.counts += counts;
        Ok(seen)
    }
}

impl Prepared for PreparedMarcher {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let mesh = check(&self.renderer, scene)?;
        control.check()?;
        if !self.scene.volume.same(&scene.volume) {
            (self.surface, self.mesh, self.links) = (surface(&mesh), mesh, OnceLock::new());
        }
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        view.validate()?;
        control.check()?;
        let mut stats = RenderStats::default();
        let layer = self.scene.layer(view, control)?;
        let seen = if needs_gradients(&self.scene) {
            self.draw::<4>(view, control, layer.as_ref(), &mut stats)?
        } else {
            self.draw::<1>(view, control, layer.as_ref(), &mut stats)?
        };
        Ok(Rendered { frame: Seen::frame(&seen, view), stats })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}

#[cfg(test)]
impl PreparedMarcher {
    /// The same, but every ray by the plain code.
    pub(crate) fn without_packets(self) -> Self {
        Self { links: OnceLock::from(None), ..self }
    }
}
