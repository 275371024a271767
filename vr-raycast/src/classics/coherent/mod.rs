//! Temporal coherence: a coherence buffer (C-buffer) of what can be seen first, projected anew for each view.
//!
//! Gudmundsson and Randén (*Incremental generation of projections of CT-volumes*, 1990) and Yagel and Shi (*Accelerating volume
//! animation by space-leaping*, 1993) keep the coordinates of the first visible voxel of each pixel's ray, project these points to
//! the next view, and start its rays there. Points that may now be hidden are dropped, and pixels without a point start as usual.
//! That saves much and proves nothing: a voxel that no ray met before may stand in front of those that the points tell of, and
//! between two rays there may always be one. Pictures change.
//!
//! Here they do not, by a bit. What is kept is the same, the cells that rays met first; but the projection is completed by what is
//! known without any ray, the ranges of the blocks of 8³ cells:
//!
//! * Of each block that an earlier picture met first, the buffer knows which cells can be seen. It knows cells and not a point for
//!   each pixel, since many pixels meet one cell, and no cell is lost to rounding.
//! * For a view, these cells and, for all other blocks of which anything can be seen, the boxes of the blocks are projected. Each leaves
//!   its nearest depth in all tiles of 4×4 pixels that its outline touches.
//! * *Hidden points*: a block behind what its tiles hold already would change nothing, and is not looked into. Nearer ones come first,
//!   so that this is found early.
//! * *Holes*: a tile that nothing was projected to shows nothing. Its rays are not even begun.
//! * All others begin at the step of their own lattice in which their tile's depth lies, and give the same sums as without.
//! * Blocks that stood in front as boxes are looked into before the next picture.
//!
//! **Why this is exact.** All boxes, of cells and of blocks, are widened by 1/32 of a cell: a kernel's rounded position lies in the
//! widened box of a visible cell wherever it can see anything. Take the first widened box of something visible that a ray
//! enters. If it is a cell of a known block, the neighbour at the side where the ray enters cannot be seen: its widened box contains the
//! point of entry, too, and so the ray would have been in it before. Hence it is enough to project the cells with such a
//! neighbour on one of the sides that rays come from. In the same way a block behind six solid ones (drawn as boxes always) is never
//! first. Everything else that can be seen is in a projected box. So every tile holds a depth at or before each of its rays' first
//! visible points; quotients are bounded outwards. Where a depth lies before a ray's entry, the ray begins at its entry:
//! clips and layers need no care. With the eye inside the volume, neighbours prove nothing, and all visible blocks are projected as
//! boxes.
//!
//! **What it gains.** Over no leaping: what lies before the first visible cell of a ray, and all rays that see nothing. Over leaping by
//! blocks of 8³ cells: the walk through clear blocks up to that cell, and the samples that a ray takes inside blocks of which it
//! meets only the clear part first. Behind the first visible cell it gains nothing: fog that fills the volume is not drawn
//! any faster.

mod buffer;
mod cells;

pub(crate) use buffer::CoherenceBuffer;
use cells::Sight;

use std::sync::Arc;

use vr_core::{
    Compositing, Control, Counts, GridVolume, IndexRay, Layer, Ray, Rays, Real, RenderError, RenderStats, Rendered,
    Scene, View,
};

use super::{distance_at_depth, steps_before};
use crate::engine::Engine;
use crate::leap::{Visibility, visibility};
use crate::render_tables::TablesByPrecision;
use crate::screen::{by_tiles, spots_of_pixel};
use crate::tracer::{RaySample, Tracer};

impl CoherenceBuffer {
    /// Makes the state before the first picture.
    pub(crate) fn of(scene: &Scene, volume: &GridVolume, engine: &Engine) -> Option<Self> {
        let sight: Sight = match engine.kernel()? {
            TablesByPrecision::F32(tables) => sight(visibility(scene, &tables.classifier)?),
            TablesByPrecision::F64(tables) => sight(visibility(scene, &tables.classifier)?),
        };
        Some(Self::new(volume, sight))
    }

    /// Draws a view, each ray from where something can be seen first; rays that cannot see anything are not traced.
    ///
    /// `step` is the world length of the steps of the tracer's lattice, and `compositing` its operator.
    pub(crate) fn draw(
        &mut self,
        tracer: &dyn Tracer,
        volume: &GridVolume,
        (step, compositing): (f64, Compositing),
        (view, layer): (&View, Option<&Layer>),
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let mut stats = RenderStats::default();
        let rays = Rays::new(view)?;
        let forward = view.camera.frame()?.z_axis;
        let near = stats.time("projection", || self.project(volume, view, control))?;
        let first_step = |ray: &Ray, pixel: usize, depth: f64| {
            let far = layer.map_or(f64::INFINITY, |l| l.depth(pixel));
            let part = IndexRay::new(ray, volume.placement(), volume.dims(), &view.clip, far)?;
            Some(steps_before(&part, distance_at_depth(&part, ray, forward, depth), step, compositing))
        };
        let frame = by_tiles(view, control, &mut stats, &|pixels| {
            let (mut spots, mut starts) = (Vec::with_capacity(pixels.len()), Vec::with_capacity(pixels.len()));
            for &pixel in pixels {
                let depth = near.at(pixel);
                if depth < f64::INFINITY {
                    for spot in spots_of_pixel(view, pixel) {
                        starts.push(first_step(&rays.at(spot.x, spot.y), spot.pixel, depth).unwrap_or(0));
                        spots.push(spot);
                    }
                }
            }
            let (mut values, mut counts) = (Vec::with_capacity(spots.len()), Counts::default());
            tracer.trace(&spots, Some(&starts), &mut values, &mut counts);
            let mut traced = values.chunks_exact((view.supersampling * view.supersampling) as usize);
            let mean = |&[x, y]: &[u32; 2]| {
                if near.at([x, y]) < f64::INFINITY {
                    return RaySample::mean(traced.next().expect("a value for each ray"));
                }
                let pixel = y as usize * view.size[0] as usize + x as usize;
                layer.map_or(RaySample::NOTHING, |l| RaySample::NOTHING.over(l, pixel))
            };
            (pixels.iter().map(mean).collect(), counts)
        })?;
        Ok(Rendered { frame, stats })
    }
}

fn sight<R: Real>(visibility: Visibility<R>) -> Sight {
    Arc::new(move |low, high| visibility.shows(low, high))
}
