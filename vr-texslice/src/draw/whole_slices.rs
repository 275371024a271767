//! A picture slice by slice, as graphics cards draw: the triangles of each slab are rasterised, and its fragments are fetched, classified, shaded and blended
//! before the next one's.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use glam::DVec2;
use vr_core::image_order::in_parallel;
use vr_core::parallel::locked;
use vr_core::{Control, Counts, RenderError};
use vr_kernels::vector::{LANES, Lanes, Operator, Vectorized, pick, run, splat};

use super::chunk::{CHUNK, Chunk, Fetch, Fetcher};
use super::picture::Picture;
use super::step::Step;
use super::tiles::{Packet, PacketScene, Pixel, sixteens};
use super::waiting::Waiting;
use crate::geometry::polygon_spans;
use crate::proxy::{ProxyGeometry, Slab};
use crate::texture::Texture;

/// Number of sixteens of pixels in a task.
const GROUP: usize = 64;

/// Draws every slab across the whole picture, one sample of each pixel after the other: an accumulation of pictures, as cards have it.
pub(crate) fn draw_slices<X: Texture>(
    scene: &PacketScene<'_>,
    texture: &X,
    control: &Control,
) -> Result<(Vec<Pixel>, Counts), RenderError> {
    let size = scene.view.size;
    let proxy = ProxyGeometry::new(scene.view, &scene.setup)?;
    let mut slabs = proxy.slabs();
    if scene.pass.operator == Operator::Over {
        slabs.reverse();
    }
    let mut picture = Picture::new(size);
    let n = scene.view.supersampling;
    for sample in 0..n * n {
        let places = sixteens(size);
        let held = in_parallel(control, places.len().div_ceil(GROUP) as u32, |g| {
            let places = &places[group(g as usize, places.len())];
            let held = places.iter().map(|&at| run(scene.level, SetUp { scene, at, sample })).collect();
            Mutex::new(Rays { held, chunks: [Chunk::EMPTY; 2] })
        })?;
        // A sample lies where the pixel's centre would.
        let centre = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
        let shift = 0.5 - DVec2::new(centre(sample % n), centre(sample / n));
        let mut masks = vec![0u32; places.len()];
        for &slab in &slabs {
            let touched = rasterize(&proxy, slab, shift, size, &mut masks);
            let masks_of = |g: usize| &masks[group(g, places.len())];
            in_parallel(control, touched.len() as u32, |k| {
                let g = touched[k as usize];
                run(scene.level, Group { scene, texture, slab, masks: masks_of(g), rays: &mut locked(&held[g]) });
            })?;
            touched.iter().for_each(|&g| masks[group(g, places.len())].fill(0));
        }
        for waiting in held.into_iter().map(Mutex::into_inner) {
            for held in waiting.unwrap_or_else(PoisonError::into_inner).held {
                held.waiting.finish(scene, &mut picture);
            }
        }
    }
    Ok(picture.mean(n * n))
}

/// Sets the bits of the pixels of a slab, in the masks of their sixteens; returns which groups of these were touched.
fn rasterize(proxy: &ProxyGeometry<'_>, slab: Slab, shift: DVec2, size: [u32; 2], masks: &mut [u32]) -> Vec<usize> {
    let across = size[0].div_ceil(4) as usize;
    let mut is_touched = vec![false; masks.len().div_ceil(GROUP)];
    for span in proxy.polygons(slab, shift).iter().flat_map(|polygon| polygon_spans(polygon, size)) {
        let (row, bits) = ((span.y / 4) as usize * across, span.y % 4 * 4);
        for column in span.begin / 4..span.end.div_ceil(4) {
            // Set those of four pixels side by side that lie in the span.
            let (first, past) = (span.begin.max(4 * column) % 4, (span.end - 4 * column).min(4));
            let sixteen = row + column as usize;
            masks[sixteen] |= ((1 << past) - (1 << first)) << bits;
            is_touched[sixteen / GROUP] = true;
        }
    }
    (0..is_touched.len()).filter(|&g| is_touched[g]).collect()
}

/// The sixteens of a group.
fn group(number: usize, sixteens: usize) -> Range<usize> {
    number * GROUP..((number + 1) * GROUP).min(sixteens)
}

/// The rays of a group, and working memory: samples of sixteen of them, and those fetched ahead.
struct Rays {
    held: Vec<Held>,
    chunks: [Chunk; 2],
}

/// Sixteen rays, between slabs.
struct Held {
    waiting: Waiting,
    /// Number of each ray's slab in the middle, from which samples are counted.
    middle: [i32; LANES],
    /// Bit i: along ray i a stack's index falls.
    falling: u32,
}

struct SetUp<'a> {
    scene: &'a PacketScene<'a>,
    at: Packet,
    sample: u32,
}

impl Vectorized for SetUp<'_> {
    type Output = Held;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Held {
        let waiting = Waiting::new(simd, self.scene, self.at, self.sample);
        let rays = &waiting.rays;
        let (mut middle, mut falling) = ([0; LANES], 0);
        for i in (0..LANES).filter(|i| rays.hits >> i & 1 == 1) {
            middle[i] = self.scene.setup.slabs(&rays.chords, i).middle() as i32;
            let direction = rays.chords.direction.map(|axis| axis[i]);
            falling |= u32::from(self.scene.setup.slices.fall_along(direction)) << i;
        }
        Held { waiting, middle, falling }
    }
}

/// A group of sixteens of pixels, of which a slab has touched some.
struct Group<'a, X> {
    scene: &'a PacketScene<'a>,
    texture: &'a X,
    slab: Slab,
    masks: &'a [u32],
    rays: &'a mut Rays,
}

impl<X: Texture> Vectorized for Group<'_, X> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut texture = Fetcher::new(self.texture);
        draw_group(simd, self.scene, self.slab, &mut texture, (self.rays, self.masks));
    }
}

/// Draws the fragments of a slab on the pixels of a group that were rasterised.
fn draw_group<S: Simd>(
    simd: S,
    scene: &PacketScene<'_>,
    slab: Slab,
    texture: &mut dyn Fetch<S>,
    (rays, masks): (&mut Rays, &[u32]),
) {
    let pass = &scene.pass;
    let backwards = pass.operator == Operator::Over;
    let Rays { held, chunks: [chunk, ahead] } = rays;
    for (held, masks) in held.chunks_mut(CHUNK).zip(masks.chunks(CHUNK)) {
        // The samples of some sixteens, and how many of the whole ones are left out.
        let (mut steps, mut skipped) = ([Step::NOTHING; CHUNK], [None; CHUNK]);
        for (j, (held, &mask)) in held.iter().zip(masks).enumerate().filter(|(_, (_, mask))| **mask != 0) {
            let falling = if slab.falling { held.falling } else { !held.falling };
            held.samples(simd, (backwards, pass.on_faces), slab.number as i32, mask & falling, &mut steps[j]);
            if steps[j].whole != 0 {
                skipped[j] = held.waiting.invisible(simd, scene, &steps[j].number);
            }
        }
        // The texels of the others, one sixteen after the other: while those of one are on their way, the next one's are asked for.
        let mut samples = [(&held[0].waiting.rays, &steps[0].number); CHUNK];
        let mut count = 0;
        for j in (0..held.len()).filter(|&j| steps[j].whole != 0 && skipped[j].is_none()) {
            samples[count] = (&held[j].waiting.rays, &steps[j].number);
            count += 1;
        }
        texture.fetch_across(simd, &samples[..count], ahead);
        // The other stages.
        let mut fetched = 0;
        for (j, held) in held.iter_mut().enumerate().filter(|(j, _)| !steps[*j].is_nothing()) {
            held.waiting.march(scene, texture, chunk, |march| {
                march.enter(simd, steps[j].first);
                if let Some(samples) = skipped[j] {
                    march.pass_by(simd, &steps[j].number, samples);
                } else if steps[j].whole != 0 {
                    (march.chunk.value[0], march.chunk.light[0]) = (ahead.value[fetched], ahead.light[fetched]);
                    fetched += 1;
                    march.go_on(simd, &steps[j].number);
                }
                march.leave(simd, steps[j].last);
            });
        }
    }
}

impl Held {
    /// Finds the samples of a slab, on those of some rays that have a part of it, and have not ended.
    #[inline(never)]
    fn samples<S: Simd>(&self, simd: S, (backwards, on_faces): (bool, bool), slab: i32, which: u32, step: &mut Step) {
        simd.vectorize(
            #[inline(always)]
            || {
                let rays = &self.waiting.rays;
                let (begin, end) = (rays.begin.load(simd), rays.end.load(simd));
                let middle = i32x16::load_array_ref(simd, &self.middle);
                let behind: f32x16<S> = (i32x16::splat(simd, slab) - middle).to_float();
                // Numbers of samples: turned, they grow towards the eye, and a face is that behind its slab.
                let number = if backwards { splat(simd, f32::from(u8::from(on_faces))) - behind } else { behind };
                // A sample on a face is that behind a slab, and where a ray enters there is one more: then whole ones begin with the first slab, else with the one behind
                // it. Of a ray that has ended, or meets nothing, the end is −∞.
                let entry = if on_faces { begin } else { begin - 1.0 };
                let here = (number.simd_ge(entry) & number.simd_le(end)).to_bitmask() as u32 & which;
                let enters = number.simd_eq(entry).to_bitmask() as u32 & here;
                let leaves = number.simd_eq(end).to_bitmask() as u32 & here;
                // The only slab of a ray has a first sample, turned a last.
                let only = enters & leaves;
                let (first, whole, last) = match (on_faces, backwards) {
                    (true, _) => (enters, here & !leaves, leaves),
                    (false, false) => (enters, here & !leaves & !enters, leaves & !only),
                    (false, true) => (enters & !only, here & !leaves & !enters, leaves),
                };
                (step.first, step.whole, step.last) = (first, whole, last);
                let takes = mask32x16::from_bitmask(simd, whole.into());
                step.number = Lanes::new(pick(takes, number, (end + 1.0).max(splat(simd, 0.0))));
            },
        );
    }
}
