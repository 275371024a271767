//! Template-based viewing: parallel rays that all step through the voxels alike.

mod base_plane;
mod tile;

use vr_core::image_order::in_parallel;
use vr_core::{Control, Counts, Feature, Frame, GridVolume, Rays, RenderError, RenderStats, Rendered, Scene, View};
use vr_kernels::tables::BakedTransfer;

use crate::capabilities::unsupported;
use crate::caster::{CompositingOrder, RayCaster};
use crate::screen::spots_of_pixel;
use crate::table_range::table_range;
use crate::tracer::RaySample;
use crate::walk::Lattice;
use base_plane::BasePlane;
use tile::{ACROSS, DOWN, TemplateRays, TemplateStep};

/// Samples that a ray template is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Connectivity {
    /// 26-connected voxels, which touch by a face, an edge or a corner, one in each slice: their own values, not interpolated.
    Discrete,
    /// Points at equal distances, between the voxels: trilinear samples, with the same weights on all rays.
    Continuous,
}

impl Connectivity {
    /// Returns the name of the screen in options.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Discrete => "template-discrete",
            Self::Continuous => "template-continuous",
        }
    }
}

/// Draws a view of a scene by a template; the caster can draw both.
///
/// # Errors
/// The error of a camera that makes no sense, or [`RenderError::Cancelled`].
pub(crate) fn draw_by_template(
    connectivity: Connectivity,
    caster: &RayCaster,
    scene: &Scene,
    volume: &GridVolume,
    view: &View,
    control: &Control,
) -> Result<Rendered, RenderError> {
    let CompositingOrder::FrontToBack { termination } = caster.order else {
        return Err(unsupported(Feature::Compositing, "compositing back to front with a template screen"));
    };
    let (low, high) = scene.volume.bounds();
    let max_light = scene.max_radiance().over(low.distance(high));
    let step = caster.world_step(volume.placement());
    let template = Template { volume, connectivity, step, enough: 1.0 - (1.0 - termination) / max_light };
    let range = table_range(volume, &scene.transfer);
    let integer = volume.voxel_type().is_integer();
    let bake = |length| BakedTransfer::new(&scene.transfer, volume.calibration(), range, integer, length);
    template.draw(bake, view, control)
}

/// Volume and settings that a template is cast through.
struct Template<'a> {
    volume: &'a GridVolume,
    connectivity: Connectivity,
    /// World length of a step between the voxels.
    step: f64,
    /// Opacity at which rays may end.
    enough: f64,
}

impl Template<'_> {
    /// Draws an orthographic view without surfaces (Yagel and Kaufman, *Template-based volume viewing*, Computer Graphics Forum 11(3),
    /// 1992). `bake` makes the table for steps of a world length.
    ///
    /// 1. The **base plane** is the face of the volume that looks at the eye most: the one across the axis along which rays go on
    ///    fastest in index space. One ray starts at each of its lattice points (and beyond its edges, where rays enter by other faces).
    /// 2. The **template** is the way of one ray: discrete, one voxel in each slice, the nearest one (3D DDA, 26-connected); or
    ///    continuous, the middles of equal steps, sampled trilinearly. Rays are parallel and start at lattice points: the others take the
    ///    same way from their own start, with the same weights, and neighbours in memory are sampled together.
    /// 3. The base plane's picture is **warped** to the screen, bilinearly.
    ///
    /// Differences from a ray through each pixel with steps of the same length:
    ///
    /// * The picture is sampled once a voxel and interpolated: where it is smooth, an error of order 2 in the voxel's size, like the
    ///   field's own; an edge is as sharp as a voxel, not as a pixel.
    /// * A step counts wholly if its sample is inside box and clip: at faces other than the base plane, of order 1 in the step.
    /// * Discrete: a sample is up to half a voxel beside its ray, which leaves order 1 in the voxel's size. The first and the last slice
    ///   count half.
    /// * A voxel that is missing makes vacuum of the samples that would use it: trilinear ones of its cells, as everywhere; discrete ones
    ///   of itself alone.
    ///
    /// # Errors
    /// A camera that makes no sense, or [`RenderError::Cancelled`].
    fn draw(
        &self,
        bake: impl Fn(f64) -> BakedTransfer<f32>,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let mut stats = RenderStats::default();
        let rays = Rays::new(view)?;
        let plane = BasePlane::new(view, self.volume.placement(), self.volume.dims())?;
        let (steps, lengths) = self.steps(&plane);
        let tables: Vec<BakedTransfer<f32>> = stats.time("tables", || lengths.into_iter().map(bake).collect());
        let picture = stats.time("base plane", || self.cast(&plane, &steps, &tables, control))?;
        stats.counts = picture.counts;
        let frame = stats.time("warp", || self.warp(&plane, &picture, &rays, view, control))?;
        Ok(Rendered { frame, stats })
    }

    /// Returns the template, and the world lengths of its steps.
    fn steps(&self, plane: &BasePlane) -> (Vec<TemplateStep>, Vec<f64>) {
        let last = plane.dims[2] - 1;
        match self.connectivity {
            Connectivity::Discrete => {
                let step = |t: usize| {
                    let at_end = t == 0 || t == last;
                    let begin = (t as f64 - 0.5).max(0.0);
                    let length = if at_end { 0.5 } else { 1.0 };
                    TemplateStep { t: t as f64, begin, length, table: usize::from(at_end) }
                };
                ((0..=last).map(step).collect(), vec![plane.slice, 0.5 * plane.slice])
            }
            Connectivity::Continuous => {
                let lattice = Lattice::new(0.0, last as f64 * plane.slice, self.step);
                let step = |k: u32| {
                    let (begin, length) = (lattice.begin(k) / plane.slice, lattice.length_of(k) / plane.slice);
                    let table = usize::from(k + 1 == lattice.count && lattice.last != lattice.length);
                    TemplateStep { t: (begin + 0.5 * length).min(last as f64), begin, length, table }
                };
                let mut lengths = vec![lattice.length];
                lengths.extend((lattice.last != lattice.length).then_some(lattice.last));
                ((0..lattice.count).map(step).collect(), lengths)
            }
        }
    }

    /// Casts the rays of the base plane; returns its picture.
    fn cast(
        &self,
        plane: &BasePlane,
        steps: &[TemplateStep],
        tables: &[BakedTransfer<f32>],
        control: &Control,
    ) -> Result<BasePicture, RenderError> {
        let [across, down] = [plane.size[0].div_ceil(ACROSS), plane.size[1].div_ceil(DOWN)];
        let corner = |tile: u32| [tile as usize % across * ACROSS, tile as usize / across * DOWN];
        let (grid, connectivity, enough) = (self.volume.values(), self.connectivity, self.enough);
        let rays = TemplateRays { plane, grid, connectivity, steps, tables, enough };
        let tiles = in_parallel(control, (across * down) as u32, |tile| {
            let mut counts = Counts::default();
            (rays.tile(corner(tile), &mut counts), counts)
        })?;
        let pixels = plane.size[0] * plane.size[1];
        let mut picture = BasePicture {
            size: plane.size,
            rgba: vec![[0.0; 4]; pixels],
            depth: vec![f32::INFINITY; pixels],
            counts: Counts::default(),
        };
        for (i, (tile, counts)) in tiles.into_iter().enumerate() {
            picture.counts += counts;
            let [x, y] = corner(i as u32);
            let width = ACROSS.min(plane.size[0] - x);
            for (row, (rgba, depth)) in tile.rgba.chunks(width).zip(tile.depth.chunks(width)).enumerate() {
                let start = (y + row) * plane.size[0] + x;
                picture.rgba[start..start + width].copy_from_slice(rgba);
                picture.depth[start..start + width].copy_from_slice(depth);
            }
        }
        Ok(picture)
    }

    /// Warps the picture from the base plane to the screen.
    fn warp(
        &self,
        plane: &BasePlane,
        picture: &BasePicture,
        rays: &Rays,
        view: &View,
        control: &Control,
    ) -> Result<Frame, RenderError> {
        let rows = in_parallel(control, view.size[1], |y| {
            let pixel = |x: u32| {
                let values: Vec<RaySample> = spots_of_pixel(view, [x, y])
                    .map(|spot| {
                        let (at, distance) = plane.meet(&rays.at(spot.x, spot.y), self.volume.placement());
                        let slices = f64::from(picture.nearest_depth(at));
                        RaySample { rgba: picture.between(at), depth: (distance + slices * plane.slice) as f32 }
                    })
                    .collect();
                RaySample::mean(&values)
            };
            (0..view.size[0]).map(pixel).collect::<Vec<RaySample>>()
        })?;
        let pixels = || rows.iter().flatten();
        Ok(Frame::new(view.size, pixels().map(|p| p.rgba).collect(), Some(pixels().map(|p| p.depth).collect())))
    }
}

/// The picture on the base plane.
struct BasePicture {
    size: [usize; 2],
    rgba: Vec<[f32; 4]>,
    /// Position where opacity reaches ½, in slices from the plane.
    depth: Vec<f32>,
    counts: Counts,
}

impl BasePicture {
    /// Returns the colour between pixels, bilinear; clear beyond the edges.
    fn between(&self, at: [f64; 2]) -> [f32; 4] {
        let whole = at.map(f64::floor);
        let [tu, tv] = [0, 1].map(|a| (at[a] - whole[a]) as f32);
        let pixel = |du: i64, dv: i64| {
            let [u, v] = [whole[0] as i64 + du, whole[1] as i64 + dv];
            let inside = (0..self.size[0] as i64).contains(&u) && (0..self.size[1] as i64).contains(&v);
            if inside { self.rgba[v as usize * self.size[0] + u as usize] } else { [0.0; 4] }
        };
        let corners = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
        std::array::from_fn(|c| {
            let a = corners[0][c] + tu * (corners[1][c] - corners[0][c]);
            let b = corners[2][c] + tu * (corners[3][c] - corners[2][c]);
            a + tv * (b - a)
        })
    }

    /// Returns the depth of the nearest pixel: the mean of depths on two sides of an edge means nothing.
    fn nearest_depth(&self, at: [f64; 2]) -> f32 {
        let [u, v] = at.map(|x| (x + 0.5).floor());
        let inside = u >= 0.0 && v >= 0.0 && u < self.size[0] as f64 && v < self.size[1] as f64;
        if inside { self.depth[v as usize * self.size[0] + u as usize] } else { f32::INFINITY }
    }
}
