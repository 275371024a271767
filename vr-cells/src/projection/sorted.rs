//! A mesh that is drawn cell by cell, from front to back, tile by tile.

use fearless_simd::Level;
use vr_core::image_order::in_parallel;
use vr_core::memory;
use vr_core::{Control, Layer, Projection, Rays, RenderError, RenderStats, Scene, View};

use crate::accumulators::Seen;
use crate::camera_space::{CameraSpace, CameraVertex};
use crate::entries::SurfaceFace;
use crate::tile_lists::{TileLists, TileRange, each_tile};

use super::projector::CellProjector;
use super::screen_mesh::{MAX_EXTENT, ScreenMesh};
use super::segment_table::SegmentTable;
use super::surface_pairs::SurfacePairs;
use super::tile::Painter;
use super::tiling::Tiling;
use super::visibility::Visibility;
use crate::screen::Screen;

/// Entries of the lists of cells at most.
const MAX_ENTRIES: usize = 1 << 28;

/// A scene in a form that can be drawn cell by cell.
pub(super) struct SortedScene<'a> {
    pub(super) renderer: &'a CellProjector,
    pub(super) scene: &'a Scene,
    pub(super) surface: &'a [SurfaceFace],
    pub(super) table: &'a SegmentTable,
}

/// A picture, and the pixels of it that have to be drawn ray by ray.
pub(super) struct Sorted {
    pub(super) pixels: Vec<Seen>,
    pub(super) left: Vec<[u32; 2]>,
}

impl SortedScene<'_> {
    /// Draws a view; `None` if no tile can be drawn so.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`]; [`RenderError::Memory`] for a mesh that is too large.
    pub(super) fn draw(
        &self,
        view: &View,
        control: &Control,
        layer: Option<&Layer>,
        stats: &mut RenderStats,
    ) -> Result<Option<Sorted>, RenderError> {
        let Some(tiling) = Tiling::new(view) else { return Ok(None) };
        let Some(mesh) = self.scene.volume.cells() else { return Ok(None) };
        let screen = Screen::new(view, tiling.per_pixel, mesh.mean_spacing());
        let camera = CameraSpace::new(view)?;
        let of_cell = ScreenMesh::BYTES_PER_CELL + Visibility::BYTES_PER_CELL + size_of::<CellBox>();
        let of_vertex = size_of::<CameraVertex<1>>() + ScreenMesh::BYTES_PER_VERTEX;
        let bytes = mesh.cells().len() * of_cell + mesh.vertices().len() * of_vertex;
        memory::check("the mesh of cells on the screen", bytes as u64)?;
        let vertices = stats.time("vertices", || camera.vertices::<1>(mesh));
        let is_behind = vertices.iter().any(|v| v.at[2] < 0.0);
        let on_screen = stats.time("screen", || {
            control.run(|| ScreenMesh::new(mesh, &vertices, &screen, |value| self.table.place(value)))
        });

        // Order the cells.
        let pairs = stats.time("surface", || SurfacePairs::new(&on_screen, self.surface, &tiling, control))?;
        control.check()?;
        let visibility = stats.time("order", || Visibility::new(&on_screen, &pairs.pairs));
        control.check()?;

        // Tiles that each cell touches; what cannot be drawn there as a whole leaves the tile to its rays.
        let mut by_ray = pairs.unsure;
        let boxes = stats.time("boxes", || {
            control.run(|| {
                vr_core::parallel::collect(mesh.cells().len(), |cell| {
                    if self.table.largest(on_screen.range(cell)).is_none() {
                        return CellBox::NOWHERE;
                    }
                    let corners = mesh.cells()[cell].map(|v| &vertices[v as usize]);
                    let at = mesh.cells()[cell].map(|v| on_screen.vertices[v as usize].at);
                    if at.iter().all(|p| !p[0].is_nan()) {
                        let bound = |pick: fn(f64, f64) -> f64| {
                            [0, 1].map(|a| pick(pick(at[0][a], at[1][a]), pick(at[2][a], at[3][a])))
                        };
                        let (low, high) = (bound(f64::min), bound(f64::max));
                        let is_exact = (0..2).all(|a| high[a] - low[a] <= MAX_EXTENT);
                        return CellBox { range: tiling.touched([low, high]), is_whole: is_exact };
                    }
                    let range = screen.bounds(&corners).and_then(|bounds| tiling.touched(bounds));
                    CellBox { range, is_whole: false }
                })
            })
        });
        let across = tiling.tiles[0];
        let mut leave = |cell: usize| {
            if let Some(range) = boxes[cell].range {
                each_tile(range, across, &mut |tile| by_ray[tile] = true);
            }
        };
        (0..boxes.len()).filter(|&cell| !boxes[cell].is_whole).for_each(&mut leave);
        visibility.tangled.iter().for_each(|&cell| leave(cell as usize));
        let ranges = visibility.order.iter().filter_map(|&cell| Some((cell, boxes[cell as usize].range?)));
        let Some(lists) = stats.time("lists", || TileLists::new(tiling.tiles, ranges, MAX_ENTRIES)) else {
            return Ok(None);
        };

        // Draw.
        let rays = Rays::new(view)?;
        let focus = matches!(view.camera.projection, Projection::Perspective { .. }).then_some(screen.per_unit);
        let painter = Painter {
            level: Level::new(),
            mesh: &on_screen,
            table: self.table,
            transfer: &self.scene.transfer,
            tiling,
            view,
            rays: &rays,
            layer,
            focus,
            is_cut: layer.is_some()
                || view.clip.crop.is_some()
                || !view.clip.planes.is_empty()
                || (focus.is_none() && is_behind),
            attenuation: self.renderer.attenuation,
            min_clear: (1.0 - self.renderer.termination) as f32,
        };
        let draw = |tile: u32| (!by_ray[tile as usize]).then(|| painter.draw(tile, lists.of(tile as usize)));
        let drawn = stats.time("cells", || in_parallel(control, tiling.count(), draw))?;
        let mut sorted =
            Sorted { pixels: vec![Seen::NOTHING; view.size[0] as usize * view.size[1] as usize], left: Vec::new() };
        for (tile, drawn) in drawn.into_iter().enumerate() {
            let (first, size) = tiling.pixels_of(tile as u32);
            let places = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [first[0] + x, first[1] + y]));
            match drawn {
                Some((seen, counts)) => {
                    stats.counts += counts;
                    for ([x, y], seen) in places.zip(seen) {
                        sorted.pixels[(y * view.size[0] + x) as usize] = seen;
                    }
                }
                None => sorted.left.extend(places),
            }
        }
        Ok(Some(sorted))
    }
}

/// Tiles that a cell touches.
#[derive(Clone, Copy, Default)]
struct CellBox {
    range: Option<TileRange>,
    /// True if it can be drawn as a whole.
    is_whole: bool,
}

impl CellBox {
    const NOWHERE: Self = Self { range: None, is_whole: true };
}
