//! A mesh that has been prepared, and its pictures.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, OnceLock};

use glam::DVec3;
use vr_core::cells::CellValues;
use vr_core::image_order::{ImageSample, PixelValue, trace_view};
use vr_core::{
    CellMesh, Compositing, Control, Counts, Frame, Layer, Model, Prepared, Ray, RayShading, RenderError, RenderStats,
    Rendered, Scene, View,
};

use crate::accumulators::{Gathered, Seen};
use crate::camera_space::CameraSpace;
use crate::capabilities::check;
use crate::entries::{Entries, SurfaceFace, surface};
use crate::marcher::CellMarcher;
use crate::medium::{ExtinctionTable, Medium};
use crate::packet::{Links, Packets, Projected, Segments};
use crate::walk::{Part, Walker};

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
    fn links(&self) -> Option<&Links> {
        self.links.get_or_init(|| Links::new(&self.mesh)).as_ref()
    }

    /// True if the picture is that of light, which packets draw: of values at vertices, without emission, and without opacity by the gradient.
    fn is_light(&self) -> bool {
        let scene = &self.scene;
        let is_light = match scene.compositing {
            Compositing::Over => true,
            Compositing::Accumulate { level } => level >= 1.0,
            _ => false,
        };
        let of_vertices = matches!(self.mesh.values(), CellValues::Vertices(_));
        is_light && of_vertices && !scene.transfer.has_emission() && !scene.has_gradient_opacity()
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
        let vertices = stats.time("vertices", || camera.vertices::<N>(&self.mesh));
        let entries = stats.time("entries", || Entries::new(&self.surface, &self.mesh, &vertices, &camera, view));
        let walker = Walker {
            mesh: &self.mesh,
            vertices: &vertices,
            entries: &entries,
            nudge: 1e-10 * self.mesh.mean_spacing(),
        };
        let modulation =
            scene.shading.as_deref().filter(|_| scene.has_gradient_opacity() && !scene.transfer.has_rows());
        let extinction = ExtinctionTable::new(&scene.transfer);
        let medium = Medium { transfer: &scene.transfer, modulation, extinction: &extinction };
        let reflection = scene.reflection();
        type Scratch = (Vec<(f64, SurfaceFace)>, Option<(DVec3, RayShading<f64>)>);
        let scratch = || -> Scratch { (Vec::new(), None) };
        let trace = |(found, shading): &mut Scratch, ray: &Ray, sample: ImageSample, counts: &mut Counts| {
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
                walker.walk(&camera.axis(ray), [sample.x, sample.y], [from, to.min(far)], found, &mut take);
                counts.rays += u64::from(parts > 0);
                counts.samples += parts;
                seen = gathered.seen();
            }
            layer.map_or(seen, |layer| Seen {
                rgba: layer.under(sample.pixel, seen.rgba),
                depth: seen.depth.min(layer.depth(sample.pixel)),
            })
        };
        let links = if self.is_light() { self.links() } else { None };
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
                    lit: reflection.map(|shading| (&**shading, &scene.lights[..])),
                    buffers: Mutex::default(),
                };
                packets.draw(control, |ray, sample, counts| trace(&mut scratch(), ray, sample, counts))
            }
            None => trace_view(view, control, scratch, trace),
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
        let needs_gradients = self.scene.reflection().is_some() || self.scene.has_gradient_opacity();
        let seen = if needs_gradients {
            self.draw::<4>(view, control, layer.as_ref(), &mut stats)?
        } else {
            self.draw::<1>(view, control, layer.as_ref(), &mut stats)?
        };
        let pixels = seen.iter().map(|s| s.rgba.map(|x| x as f32)).collect();
        let depth = seen.iter().map(|s| s.depth as f32).collect();
        Ok(Rendered { frame: Frame::new(view.size, pixels, Some(depth)), stats })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}

impl PixelValue for Seen {
    fn mean(values: &[Self]) -> Self {
        let share = 1.0 / values.len() as f64;
        let sum = |c: usize| values.iter().map(|v| v.rgba[c]).sum::<f64>() * share;
        let depth = values.iter().map(|v| v.depth).fold(f64::INFINITY, f64::min);
        Self { rgba: std::array::from_fn(sum), depth }
    }
}

#[cfg(test)]
impl PreparedMarcher {
    /// The same, but every ray by the plain code.
    pub(crate) fn without_packets(self) -> Self {
        Self { links: OnceLock::from(None), ..self }
    }
}
