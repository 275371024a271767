//! A picture slice by slice, as graphics cards draw: each slab's footprint is rasterised, and its fragments are blended before the next one's.

use std::sync::{Mutex, PoisonError};

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::image_order::in_parallel;
use vr_core::parallel::locked;
use vr_core::{Control, Counts, RenderError};
use vr_kernels::vector::{Pairs, run};

use super::bricks::{BrickRays, GROUP, Waiting, set_up};
use super::tiles::{PacketScene, Pixel, sixteens};
use crate::geometry::{Body, box_corners, hull, spans};
use crate::projection::ScreenProjection;

/// Draws every slab across the whole picture, front to back. Pixels whose centres lie exactly on a footprint's right or lower edge are not covered.
pub(crate) fn draw_slices<T: Pairs>(
    scene: &PacketScene<'_>,
    volume: &Lattice<'_, T>,
    control: &Control,
) -> Result<(Vec<Pixel>, Counts), RenderError> {
    let size = scene.view.size;
    let places = sixteens(size);
    let rays = set_up(scene, &places, 0, control)?;
    let across = size[0].div_ceil(4) as usize;
    let screen = ScreenProjection::new(scene.view)?;
    let dims = volume.dims;
    let corners = box_corners(scene.setup.placement, DVec3::ZERO, DVec3::from_array(dims.map(|n| (n - 1) as f64)));
    let body = Body::new(&corners, &scene.view.clip);
    let cells = dims.map(|n| [0, n - 1]);
    let mut masks = vec![0u32; places.len()];
    for [low, high] in screen.slabs(&corners, scene.setup.slices.distance) {
        let outline = hull(body.slab(screen.forward(), low, high).into_iter().map(|p| screen.at(p)).collect());
        let mut touched = Vec::new();
        for span in spans(&outline, size) {
            for x in span.begin..span.end {
                let sixteen = (span.y / 4) as usize * across + (x / 4) as usize;
                if masks[sixteen] == 0 {
                    touched.push(sixteen);
                }
                masks[sixteen] |= 1 << (span.y % 4 * 4 + x % 4);
            }
        }
        let groups: Vec<_> = touched.chunks(GROUP).collect();
        in_parallel(control, groups.len() as u32, |g| {
            for &i in groups[g as usize] {
                let mut waiting = locked(&rays[i]);
                let only = Some(masks[i]);
                run(
                    scene.level,
                    BrickRays { scene, dims, cells: &cells, texture: Some(volume), only, waiting: &mut waiting },
                );
            }
        })?;
        touched.iter().for_each(|&i| masks[i] = 0);
    }
    let mut pixels = vec![Pixel::NOTHING; size[0] as usize * size[1] as usize];
    let mut counts = Counts::default();
    for waiting in rays.into_iter().map(Mutex::into_inner) {
        let Waiting { at, rays, state, drawn, skipped, .. } = waiting.unwrap_or_else(PoisonError::into_inner);
        counts.rays += u64::from(rays.hits.count_ones());
        counts.samples += drawn;
        counts.skipped += skipped;
        at.finish(scene, &rays, &state, |number, pixel| pixels[number] = pixel);
    }
    Ok((pixels, counts))
}
