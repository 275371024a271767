//! Rasterization of a mesh, as a view sees it, into a layer.

use glam::DVec3;
use vr_core::cancel::SparsePoll;
use vr_core::image_order::in_parallel;
use vr_core::{Control, Layer, Light, Ray, RayShading, Rays, RenderError, TriangleMesh, View};

use crate::bands::{Bands, Candidate};
use crate::outline::ScreenProjection;
use crate::sheared_ray::ShearedRay;
use crate::surface::Surface;

/// Number of triangles whose outlines are one piece of work.
const PIECE: usize = 1 << 14;

/// Draws the nearest triangle along the ray through each pixel's centre, at its world distance.
///
/// Rays start where [`Rays`] has them start, and see triangles inside the view's clip alone, from both sides; a mesh that is cut open
/// shows its inside. Of triangles at the same distance, the first one counts. A layer holds one distance a pixel, whatever
/// [`View::supersampling`] is: its edges are not smoothed, and all subpixels of the volume end where the centre's ray does.
///
/// Distances are exact to a few roundings of the largest coordinate in f64; then the layer rounds them to f32, by up to 6·10⁻⁸ of
/// themselves. The result is the same for any number of threads.
///
/// # Errors
/// A view or a surface that makes no sense, or [`RenderError::Cancelled`].
pub(crate) fn rasterize(
    surface: &Surface,
    lights: &[Light],
    view: &View,
    control: &Control,
) -> Result<Layer, RenderError> {
    surface.validate()?;
    let mesh = &*surface.mesh;
    let picture = Picture { mesh, surface, lights, view, rays: Rays::new(view)?, screen: ScreenProjection::new(view)? };
    let pieces = mesh.triangles().len().div_ceil(PIECE) as u32;
    let candidates = in_parallel(control, pieces, |piece| picture.candidates(piece as usize * PIECE))?;
    let bands = Bands::new(view.size[1], &candidates);
    drop(candidates);
    let pixels = in_parallel(control, bands.count(), |band| picture.band(&bands, band))?;
    Ok(Layer { pixels: pixels.into_iter().flatten().collect() })
}

struct Picture<'a> {
    mesh: &'a TriangleMesh,
    surface: &'a Surface,
    lights: &'a [Light],
    view: &'a View,
    rays: Rays,
    screen: ScreenProjection,
}

/// Entry of a pixel in which no surface is seen.
const NOTHING: ([f32; 3], f32) = ([0.0; 3], f32::INFINITY);

/// A pixel's ray, and the nearest hit so far.
struct Sight {
    ray: Ray,
    sheared: ShearedRay,
    /// First and last distance at which something is seen.
    seen: [f64; 2],
    /// Distance of the nearest triangle, and which it is.
    nearest: Option<(f64, u32)>,
}

impl Sight {
    fn look(&mut self, mesh: &TriangleMesh, triangle: u32) {
        let Some(hit) = self.sheared.intersect(mesh.corners(triangle as usize)) else { return };
        let found = (hit.distance, triangle);
        // Pairs are compared in order: of equal distances the triangle of the lowest number counts, whichever is looked at first.
        let is_nearer = self.nearest.is_none_or(|nearest| found < nearest);
        if is_nearer && self.seen[0] <= found.0 && found.0 <= self.seen[1] {
            self.nearest = Some(found);
        }
    }
}

impl Picture<'_> {
    /// The triangles of the piece that begins at `start` that may be seen.
    fn candidates(&self, start: usize) -> Vec<Candidate> {
        let end = (start + PIECE).min(self.mesh.triangles().len());
        let candidate = |triangle: usize| {
            let rows = self.screen.outline(self.mesh.corners(triangle)).rows(self.screen.size());
            (rows[0] < rows[1]).then_some(Candidate { triangle: triangle as u32, rows })
        };
        (start..end).filter_map(candidate).collect()
    }

    /// The pixels of a band, row by row.
    fn band(&self, bands: &Bands, band: u32) -> Vec<([f32; 3], f32)> {
        let [first, end] = bands.rows(band);
        let size = self.screen.size();
        let pixels = size[0] as usize * (end - first) as usize;
        let mut triangles = bands.triangles(band).peekable();
        if triangles.peek().is_none() {
            return vec![NOTHING; pixels];
        }
        // Find the nearest triangle along the ray of each pixel, among those whose outline covers it.
        let mut sights: Vec<Option<Sight>> =
            (first..end).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| self.sight(x, y)).collect();
        let mut poll = SparsePoll::default();
        for triangle in triangles {
            let outline = self.screen.outline(self.mesh.corners(triangle as usize));
            let [top, bottom] = outline.rows(size);
            for row in top.max(first)..bottom.min(end) {
                poll.turn();
                let [left, right] = outline.columns(row, size);
                let begin = (row - first) as usize * size[0] as usize;
                for sight in sights[begin + left as usize..begin + left.max(right) as usize].iter_mut().flatten() {
                    sight.look(self.mesh, triangle);
                }
            }
        }
        // Shade what was found.
        let mut shading = None;
        sights.iter().map(|sight| sight.as_ref().map_or(NOTHING, |sight| self.pixel(sight, &mut shading))).collect()
    }

    /// The ray of a pixel, where the clip leaves any of it.
    fn sight(&self, x: u32, y: u32) -> Option<Sight> {
        let ray = self.rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let seen = ray.inside(&self.view.clip)?;
        Some(Sight { ray, sheared: ShearedRay::new(&ray), seen, nearest: None })
    }

    /// The light and the distance of what was hit; `shading` is that of the last ray, and serves all that are parallel to it.
    fn pixel(&self, sight: &Sight, shading: &mut Option<(DVec3, RayShading<f64>)>) -> ([f32; 3], f32) {
        let Some((distance, triangle)) = sight.nearest else { return NOTHING };
        let triangle = triangle as usize;
        let Some(hit) = sight.sheared.intersect(self.mesh.corners(triangle)) else { return NOTHING };
        let direction = sight.ray.direction;
        if !matches!(shading, Some((of, _)) if *of == direction) {
            *shading = None;
        }
        let (_, along) = shading.get_or_insert_with(|| (direction, self.surface.shading.along(self.lights, direction)));
        (self.surface.light(triangle, &hit, along), distance as f32)
    }
}
