//! Rays of every pixel.

use rayon::prelude::*;
use vr_core::image_order::{ImageSample, in_parallel};
use vr_core::{Control, Counts, DrawnPixels, Frame, RenderError, RenderStats, Rendered, View};

use super::blocks::in_blocks;
use crate::tracer::{RaySample, Tracer};

/// Pixels along the edge of a tile: small enough to balance, large enough that a tile's rays share the cache.
const TILE: u32 = 32;

/// Traces every ray of a view, tile by tile on all threads. The picture does not depend on their number.
pub(crate) fn every_pixel(tracer: &dyn Tracer, view: &View, control: &Control) -> Result<Rendered, RenderError> {
    let mut stats = RenderStats::default();
    let frame = by_tiles(view, control, &mut stats, &|pixels| match (pixels.first(), pixels.last()) {
        // The first and the last pixel of a tile are two of its corners. Pixels without a value stay clear.
        (Some(&low), Some(&high)) if tracer.is_clear(low, high) => (Vec::new(), Counts::default()),
        _ => traced(tracer, view, pixels),
    })?;
    Ok(Rendered { frame, stats })
}

/// Traces the rays of some pixels of a view on all threads.
pub(crate) fn some_pixels(
    tracer: &dyn Tracer,
    view: &View,
    pixels: &[[u32; 2]],
    control: &Control,
) -> Result<DrawnPixels, RenderError> {
    const PART: usize = 64;
    let parts = pixels.len().div_ceil(PART) as u32;
    let traced = in_parallel(control, parts, |part| {
        let from = part as usize * PART;
        traced(tracer, view, &pixels[from..(from + PART).min(pixels.len())])
    })?;
    let mut counts = Counts::default();
    traced.iter().for_each(|(_, of_part)| counts += *of_part);
    let rgba = traced.into_iter().flat_map(|(values, _)| values).map(|value| value.rgba).collect();
    Ok(DrawnPixels { rgba, counts })
}

/// Function that draws pixels and returns one value for each, or none if they are clear.
type DrawTile<'a> = &'a (dyn Fn(&[[u32; 2]]) -> (Vec<RaySample>, Counts) + Sync);

/// Draws a view tile by tile on all threads: `draw` is handed the pixels of a tile, block by block, and returns one value for each, or none if they are clear.
pub(crate) fn by_tiles(
    view: &View,
    control: &Control,
    stats: &mut RenderStats,
    draw: DrawTile<'_>,
) -> Result<Frame, RenderError> {
    let across = view.size[0].div_ceil(TILE);
    let tiles = across * view.size[1].div_ceil(TILE);
    let results = stats.time("rays", || {
        in_parallel(control, tiles, |t| {
            let pixels = pixels_of_tile(view.size, [t % across * TILE, t / across * TILE]);
            let (values, counts) = draw(&pixels);
            (pixels, values, counts)
        })
    })?;
    let [w, h] = view.size.map(|n| n as usize);
    let (mut rgba, mut depth) = (vec![[0.0; 4]; w * h], vec![f32::INFINITY; w * h]);
    results.iter().for_each(|(_, _, counts)| stats.counts += *counts);
    stats.time("image", || {
        // Rows of tiles are rows of the picture.
        let band = w * TILE as usize;
        let bands = rgba.par_chunks_mut(band).zip(depth.par_chunks_mut(band)).zip(results.par_chunks(across as usize));
        control.run(|| {
            bands.enumerate().for_each(|(k, ((rgba, depth), tiles))| {
                for (pixels, values, _) in tiles {
                    for (&[x, y], value) in pixels.iter().zip(values) {
                        let pixel = y as usize * w + x as usize - k * band;
                        (rgba[pixel], depth[pixel]) = (value.rgba, value.depth);
                    }
                }
            });
        });
    });
    Ok(Frame::new(view.size, rgba, Some(depth)))
}

/// Returns the pixels of a tile, block by block.
fn pixels_of_tile(size: [u32; 2], corner: [u32; 2]) -> Vec<[u32; 2]> {
    let end = [0, 1].map(|a| (corner[a] + TILE).min(size[a]));
    let mut pixels = Vec::with_capacity((TILE * TILE) as usize);
    in_blocks(corner, end, |pixel| pixels.push(pixel));
    pixels
}

/// Traces pixels; returns a value for each.
pub(crate) fn traced(tracer: &dyn Tracer, view: &View, pixels: &[[u32; 2]]) -> (Vec<RaySample>, Counts) {
    let rays = (view.supersampling * view.supersampling) as usize;
    let mut spots: Vec<ImageSample> = Vec::with_capacity(pixels.len() * rays);
    pixels.iter().for_each(|&pixel| push_spots(view, pixel, &mut spots));
    let (mut values, mut counts) = (Vec::with_capacity(spots.len()), Counts::default());
    tracer.trace(&spots, None, &mut values, &mut counts);
    if rays > 1 {
        values = values.chunks_exact(rays).map(RaySample::mean).collect();
    }
    (values, counts)
}

/// Appends the rays of a pixel. (For one ray, the division that finds its place in the pixel costs more than all else.)
#[inline]
fn push_spots(view: &View, pixel @ [x, y]: [u32; 2], spots: &mut Vec<ImageSample>) {
    if view.supersampling == 1 {
        spots.push(ImageSample { pixel: number_of(view, pixel), x: f64::from(x) + 0.5, y: f64::from(y) + 0.5 });
    } else {
        spots.extend(spots_of_pixel(view, pixel));
    }
}

/// Returns the n² rays of a pixel.
pub(crate) fn spots_of_pixel(view: &View, pixel @ [x, y]: [u32; 2]) -> impl Iterator<Item = ImageSample> {
    let n = view.supersampling;
    let pixel = number_of(view, pixel);
    let centre = move |k: u32| (f64::from(k) + 0.5) / f64::from(n);
    (0..n * n).map(move |k| ImageSample { pixel, x: f64::from(x) + centre(k % n), y: f64::from(y) + centre(k / n) })
}

/// Returns the index of a pixel, row by row. Beyond the view, where rays may go as well, it is that of the nearest pixel: layers know no other.
#[inline]
fn number_of(view: &View, [x, y]: [u32; 2]) -> usize {
    let [w, h] = view.size;
    y.min(h - 1) as usize * w as usize + x.min(w - 1) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_every_pixel_once() {
        for size in [[1, 1], [33, 7], [64, 31]] {
            let mut seen = vec![0; (size[0] * size[1]) as usize];
            for y in (0..size[1]).step_by(TILE as usize) {
                for x in (0..size[0]).step_by(TILE as usize) {
                    for [x, y] in pixels_of_tile(size, [x, y]) {
                        seen[(y * size[0] + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&n| n == 1), "{size:?}");
        }
    }
}
