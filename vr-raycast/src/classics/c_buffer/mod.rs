//! C-buffer as published: each pixel's first visible point, kept from picture to picture and projected to the next view.
//!
//! Yagel and Shi (*Accelerating volume animation by space-leaping*, 1993) keep, for each pixel, the object-space coordinates of the first
//! voxel that is not empty, turn and project them to the next view, remove points that may be hidden there by the order in which they
//! land (after Gudmundsson and Randén 1990; [`points`] has it), and start the rays there.
//!
//! **What is kept.** Of each pixel the nearest place at which one of its rays enters a block of 2³ cells in which anything can be seen: all that such a
//! buffer can know of a field that is interpolated.
//!
//! **Why the picture is every pixel's, bit for bit.** The points alone prove nothing: what no ray met before may stand before them, and
//! does (`figures` counts it). A frame must not depend on earlier ones, and so each start is only a claim. The ray is walked through the structure over
//! those blocks, from its entry on (`ExactCloud`, whose guarantee is [`crate::leap`]'s), to the first block in which anything can be seen. A claim
//! no farther than that is *proven*, and the ray begins at its step; a claim behind it is *wrong or unsure*, and the ray is cast from where
//! the proof ends. Pixels without a claim are cast from their entry. Steps left out lie before the first visible block in each case, and add
//! nothing to any sum.
//!
//! **What it costs.** The walk that proves a claim finds the next picture's point as well; and it is the very walk that leaping does. So a
//! proven C-buffer gains nothing over leaping: to know that nothing new stands in front of a surface is to have looked. The exact variant
//! (`coherent`) is the way out: it projects what *can* be seen and not what *was* seen, and then no ray need be walked.

mod points;

#[cfg(test)]
mod figures;

use std::sync::Mutex;

use vr_core::{
    Compositing, Control, Counts, GridVolume, IndexRay, Layer, Rays, Real, RenderError, RenderStats, Rendered, Scene,
    View,
};
use vr_kernels::ranges::RangeBlocks;

use super::{distance_at_depth, steps_before};
use crate::engine::Engine;
use crate::leap::{ExactCloud, Leaper, Visibility, VisibleBlocks, visibility};
use crate::render_tables::TablesByPrecision;
use crate::screen::{by_tiles, spots_of_pixel};
use crate::tracer::{RaySample, Tracer};
use points::Points;

/// Cells along the edge of the blocks that starts are proven by.
const FINE: usize = 2;

/// C-buffer, and the structure that proves its starts.
pub(crate) struct CBuffer {
    cloud: ExactCloud,
    points: Option<Points>,
    /// False in measurements alone, of pictures as they would be without the proof.
    checked: bool,
    /// Statistics of the starts of the last picture.
    starts: Starts,
}

/// Starts of the rays of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Starts {
    /// Rays that meet the volume, and those of them that a point or a neighbour's tells where to begin.
    pub(crate) rays: u64,
    pub(crate) claimed: u64,
    /// Claims behind the first block in which anything can be seen.
    pub(crate) wrong: u64,
    /// World length of all rays before that block (or their end), and the part of it that rays leave out.
    pub(crate) empty: f64,
    pub(crate) saved: f64,
}

impl Starts {
    fn add(&mut self, other: &Self) {
        self.rays += other.rays;
        self.claimed += other.claimed;
        self.wrong += other.wrong;
        self.empty += other.empty;
        self.saved += other.saved;
    }
}

/// Results of a pixel: the point to keep and its distance, and what became of the starts.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    point: Option<([f32; 3], f64)>,
    starts: Starts,
}

impl CBuffer {
    /// Makes the state before the first picture.
    pub(crate) fn of(scene: &Scene, volume: &GridVolume, engine: &Engine) -> Option<Self> {
        let cloud = match engine.kernel()? {
            TablesByPrecision::F32(tables) => cloud(volume, &visibility(scene, &tables.classifier)?),
            TablesByPrecision::F64(tables) => cloud(volume, &visibility(scene, &tables.classifier)?),
        };
        Some(Self { cloud, points: None, checked: true, starts: Starts::default() })
    }

    /// Draws a view, each ray from where its start is proven.
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
        let claims = stats.time("projection", || match &self.points {
            Some(points) => points.claims(view, volume),
            None => Ok(vec![0.0; view.size[0] as usize * view.size[1] as usize]),
        })?;
        let (cloud, checked) = (&self.cloud, self.checked);
        let begin = |x: f64, y: f64, pixel: usize, met: &mut Met| -> u32 {
            let ray = rays.at(x, y);
            let far = layer.map_or(f64::INFINITY, |l| l.depth(pixel));
            let Some(part) = IndexRay::new(&ray, volume.placement(), volume.dims(), &view.clip, far) else { return 0 };
            let first = cloud.next(&part, part.start).map(|(begin, _)| begin);
            if let Some(first) = first
                && met.point.is_none_or(|(_, distance)| first + part.offset < distance)
            {
                met.point = Some((part.at(first).to_array().map(|x| x as f32), first + part.offset));
            }
            let clear = first.unwrap_or(part.end);
            let claim = match claims[pixel] {
                0.0 => part.start,
                depth => distance_at_depth(&part, &ray, forward, depth).max(part.start),
            };
            let wrong = claim > clear && first.is_some();
            let start = if wrong && checked { clear } else { claim.min(part.end) };
            met.starts.add(&Starts {
                rays: 1,
                claimed: u64::from(claims[pixel] > 0.0),
                wrong: u64::from(wrong),
                empty: clear - part.start,
                saved: start - part.start,
            });
            steps_before(&part, start, step, compositing)
        };
        let found = Mutex::new(vec![Met::default(); claims.len()]);
        let frame = by_tiles(view, control, &mut stats, &|pixels| {
            let rays = (view.supersampling * view.supersampling) as usize;
            let (mut spots, mut starts) = (Vec::with_capacity(pixels.len() * rays), Vec::new());
            let mut all_met = Vec::with_capacity(pixels.len());
            for &pixel in pixels {
                let mut met = Met::default();
                for spot in spots_of_pixel(view, pixel) {
                    starts.push(begin(spot.x, spot.y, spot.pixel, &mut met));
                    all_met.push((spot.pixel, met));
                    spots.push(spot);
                }
            }
            let (mut values, mut counts) = (Vec::with_capacity(spots.len()), Counts::default());
            tracer.trace(&spots, Some(&starts), &mut values, &mut counts);
            {
                // The last ray of a pixel holds the results of all of them. Each pixel has its own entry, so the order of tiles has no influence.
                let mut found = found.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                all_met.into_iter().for_each(|(pixel, met)| found[pixel] = met);
            }
            (values.chunks_exact(rays).map(RaySample::mean).collect(), counts)
        })?;
        let found = found.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        self.starts = Starts::default();
        found.iter().for_each(|met| self.starts.add(&met.starts));
        self.points = Some(Points::new(view, found.into_iter().map(|met| met.point.map(|p| p.0)).collect()));
        Ok(Rendered { frame, stats })
    }
}

/// Makes the structure over blocks that proves starts.
fn cloud<R: Real>(volume: &GridVolume, visibility: &Visibility<R>) -> ExactCloud {
    let ranges = RangeBlocks::of_volume(volume, FINE);
    ExactCloud::new(&VisibleBlocks::new(volume.dims(), &ranges, visibility))
}
