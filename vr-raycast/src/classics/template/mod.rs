//! Template-based viewing: parallel rays that all step through the voxels alike.

mod base_plane;
mod picture;
mod rows;
mod steps;
mod walk;

#[cfg(test)]
mod tests;

pub(crate) use walk::TemplateWalk;

use std::sync::Arc;

use glam::DVec3;
use vr_core::image_order::in_parallel;
use vr_core::{
    Control, Counts, Filter, Frame, GridVolume, Layer, ParameterError, Real, RenderError, RenderStats, Rendered, View,
};

use crate::classify::Classifier;
use crate::pipeline::{Pipeline, RayPart, SharedSamples};
use crate::screen::spots_of_pixel;
use crate::table_range::baked;
use crate::tracer::RaySample;
use crate::walk::{Walk, WalkKind};
use base_plane::BasePlane;
use picture::BasePicture;
use rows::{ACROSS, RowSamples};
use steps::TemplateSteps;

/// Samples that a ray template is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// 26-connected voxels, which touch by a face, an edge or a corner, one in each slice: their own values, not interpolated.
    Discrete,
    /// Points at equal distances, between the voxels: samples with the same weights on all rays.
    Continuous,
    /// Steps from cell face to cell face, the very cells that a ray passes, each cut into equal steps where it is longer than the step.
    Faces,
}

impl Connectivity {
    /// Returns the name of the screen in options.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Discrete => "template-discrete",
            Self::Continuous => "template-continuous",
            Self::Faces => "template-faces",
        }
    }
}

/// Rows of the base plane that a task traces.
const DOWN: usize = 16;

/// Draws an orthographic view by a template (Yagel and Kaufman, *Template-based volume viewing*, Computer Graphics Forum 11(3), 1992).
///
/// 1. The **base plane** is the face of the volume that looks at the eye most: the one across the axis along which rays go on
///    fastest in index space. One ray starts at each of its lattice points (and beyond its edges, where rays enter by other faces).
/// 2. The **template** is the way of one ray: discrete, one voxel in each slice, the nearest one (3D DDA, 26-connected); continuous, equal steps; or
///    from cell face to cell face. Rays are parallel and start at lattice points: the others take the same way from their own start, and lie
///    alike between the voxels in each step. Where a ray enters or leaves within a step, it takes the part of it that is inside.
/// 3. The rays go **through the plain engine**, whose filters, rules, shading and operators take the steps that the template's walk hands out. A trilinear
///    field without missing voxels is sampled for rows of neighbouring rays at once, with the weights that they share.
/// 4. The base plane's picture is **warped** to the screen, bilinearly, and drawn over the surfaces of the view.
///
/// The rays are those of the plain engine, and what a ray shows is what that engine shows along it: with the continuous template the samples begin at
/// the base plane, not where the ray enters, and with the discrete one they lie up to half a voxel beside the ray, of order 1 in the voxel's size. The
/// picture is sampled once a voxel and interpolated: where it is smooth, an error of order 2 in the voxel's size, like the field's own; an edge, that of a
/// surface among others, is as sharp as a voxel, not as a pixel. A ray ends at the surface of the pixel that it is nearest to.
///
/// # Errors
/// A camera that makes no sense, or [`RenderError::Cancelled`].
pub(crate) fn draw_by_template<R: Real>(
    connectivity: Connectivity,
    pipeline: Pipeline<'_, R>,
    volume: &GridVolume,
    control: &Control,
) -> Result<Rendered, RenderError> {
    let mut stats = RenderStats::default();
    let (view, step) = (pipeline.view, pipeline.walks.step);
    let plane = BasePlane::new(view, volume.placement(), volume.dims())?;
    // Whole steps of the discrete template are as long as a slice, whatever the view makes of it.
    let of_slices = (connectivity == Connectivity::Discrete)
        .then(|| stats.time("tables", || of_steps(pipeline.classifier, &pipeline, volume, plane.slice)));
    let classifier = of_slices.as_ref().unwrap_or(pipeline.classifier);
    let pipeline = Pipeline { classifier, ..pipeline };
    let steps = TemplateSteps::new(connectivity, &plane, step, pipeline.offset);
    let template = Template { plane, steps, volume, pipeline: &pipeline };
    let picture = stats.time("base plane", || template.cast(control))?;
    stats.counts = picture.counts;
    let frame = stats.time("warp", || template.warp(&picture, control))?;
    Ok(Rendered { frame, stats })
}

/// Returns a classifier with a table for steps of a length, if it has one for another.
fn of_steps<R: Real>(
    classifier: &Classifier<R>,
    pipeline: &Pipeline<'_, R>,
    volume: &GridVolume,
    length: f64,
) -> Classifier<R> {
    let is_wanted = classifier.table.is_some();
    let table = is_wanted.then(|| baked(pipeline.scene, volume, length)).flatten();
    Classifier { table: table.map(|table| (Arc::new(table), length)), ..classifier.clone() }
}

/// Template of a view, and the engine that takes its steps.
struct Template<'a, R> {
    plane: BasePlane,
    steps: TemplateSteps,
    volume: &'a GridVolume,
    pipeline: &'a Pipeline<'a, R>,
}

impl<R: Real> Template<'_, R> {
    /// Casts the rays of the base plane; returns its picture.
    fn cast(&self, control: &Control) -> Result<BasePicture, RenderError> {
        let size = self.plane.size;
        let [across, down] = [size[0].div_ceil(ACROSS), size[1].div_ceil(DOWN)];
        let corner = |tile: usize| [tile % across * ACROSS, tile / across * DOWN];
        let far = self.pipeline.layer.map(|layer| SurfaceDepths::new(layer, self.pipeline.view)).transpose()?;
        let tiles = in_parallel(control, (across * down) as u32, |tile| {
            let mut counts = Counts::default();
            (self.tile(corner(tile as usize), far.as_ref(), &mut counts), counts)
        })?;
        let rays = vec![RaySample::NOTHING; size[0] * size[1]];
        let mut picture = BasePicture { size, rays, counts: Counts::default() };
        for (i, (tile, counts)) in tiles.into_iter().enumerate() {
            picture.counts += counts;
            let [x, y] = corner(i);
            let width = ACROSS.min(size[0] - x);
            for (row, rays) in tile.chunks(width).enumerate() {
                let start = (y + row) * size[0] + x;
                picture.rays[start..start + width].copy_from_slice(rays);
            }
        }
        Ok(picture)
    }

    /// Traces the rays of a tile, row by row; depths are distances from the base plane.
    fn tile(&self, corner: [usize; 2], surfaces: Option<&SurfaceDepths<'_>>, counts: &mut Counts) -> Vec<RaySample> {
        let Self { plane, steps, volume, pipeline } = self;
        let across = ACROSS.min(plane.size[0] - corner[0]);
        let down = DOWN.min(plane.size[1] - corner[1]);
        let mut operator = pipeline.operator();
        let mut scratch = pipeline.scratch(operator.as_mut());
        // Voxels lie beside their rays, where no structure over empty space looks.
        let leaper = match pipeline.walks.kind {
            WalkKind::Lattice(leaper) if !steps.beside => leaper,
            _ => None,
        };
        let filter = volume.filter();
        let are_shared = filter == Filter::Trilinear || steps.beside && filter == Filter::Nearest;
        let mut samples =
            (are_shared && volume.vacuum_cells().is_none()).then(|| RowSamples::new(plane, steps, volume.values()));
        let mut rays = Vec::with_capacity(across * down);
        for row in 0..down {
            let first = [plane.first[0] + corner[0] as i64, plane.first[1] + (corner[1] + row) as i64];
            if let Some(samples) = &mut samples {
                samples.begin(first);
            }
            for ray in 0..across {
                let pixel = [first[0] + ray as i64, first[1]];
                let far = surfaces.map_or(f64::INFINITY, |s| s.depth(volume.placement().to_world(plane.place(pixel))));
                let Some(part) = plane.part(pixel, far) else {
                    rays.push(RaySample::NOTHING);
                    continue;
                };
                let walk = TemplateWalk::new(plane, steps, leaper, (pixel, &part), scratch.needs());
                let shared = samples.as_mut().map(|samples| {
                    samples.ask_for(ray);
                    samples as &mut dyn SharedSamples<R>
                });
                let whole = RayPart { direction: plane.forward, part, walk: Walk::Template(walk), shared };
                let mut value = pipeline.trace_part(&mut scratch, whole, counts);
                value.depth -= part.offset;
                rays.push(value.into());
            }
        }
        rays
    }

    /// Warps the picture from the base plane to the screen, over the surfaces of the view.
    fn warp(&self, picture: &BasePicture, control: &Control) -> Result<Frame, RenderError> {
        let Self { plane, volume, pipeline, .. } = self;
        let view = pipeline.view;
        let rows = in_parallel(control, view.size[1], |y| {
            // Rays of one pixel.
            let mut values = Vec::new();
            let pixel = |x: u32| {
                values.clear();
                values.extend(spots_of_pixel(view, [x, y]).map(|spot| {
                    let (at, distance) = plane.meet(&pipeline.rays.at(spot.x, spot.y), volume.placement());
                    let depth = (distance + f64::from(picture.nearest_depth(at))) as f32;
                    let value = RaySample { rgba: picture.between(at), depth };
                    pipeline.layer.map_or(value, |layer| value.over(layer, spot.pixel))
                }));
                RaySample::mean(&values)
            };
            (0..view.size[0]).map(pixel).collect::<Vec<RaySample>>()
        })?;
        let pixels = || rows.iter().flatten();
        Ok(Frame::new(view.size, pixels().map(|p| p.rgba).collect(), Some(pixels().map(|p| p.depth).collect())))
    }
}

/// Depths of the surfaces in a view, for rays between its pixels.
struct SurfaceDepths<'a> {
    layer: &'a Layer,
    view: &'a View,
    /// World directions to the right and down, in pixels per world unit.
    right: DVec3,
    down: DVec3,
}

impl<'a> SurfaceDepths<'a> {
    fn new(layer: &'a Layer, view: &'a View) -> Result<Self, ParameterError> {
        let frame = view.camera.frame()?;
        let per_unit = f64::from(view.size[1]) / view.camera.projection.height();
        Ok(Self { layer, view, right: frame.x_axis * per_unit, down: -frame.y_axis * per_unit })
    }

    /// Returns the depth of the pixel that is nearest to a point's.
    fn depth(&self, world: DVec3) -> f64 {
        let (at, [w, h]) = (world - self.view.camera.eye, self.view.size);
        // `as` saturates at 0.
        let [x, y] = [(self.right, w), (self.down, h)]
            .map(|(axis, size)| ((at.dot(axis) + 0.5 * f64::from(size)) as usize).min(size as usize - 1));
        self.layer.depth(y * w as usize + x)
    }
}
