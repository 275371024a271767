//! A picture slice by slice, as graphics cards draw: the triangles of each slab are rasterised, and its fragments are fetched, classified, shaded and blended
//! before the next one's.

use std::sync::{Mutex, PoisonError};

use fearless_simd::Simd;
use glam::DVec2;
use vr_core::image_order::in_parallel;
use vr_core::parallel::locked;
use vr_core::{Control, Counts, RenderError};
use vr_kernels::vector::{LANES, Lanes, Operator, Vectorized, run};

use super::chunk::{Chunk, Fetch, Fetcher};
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
        let held = in_parallel(control, places.len() as u32, |i| {
            Mutex::new(run(scene.level, SetUp { scene, at: places[i as usize], sample }))
        })?;
        // A sample lies where the pixel's centre would.
        let centre = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
        let shift = 0.5 - DVec2::new(centre(sample % n), centre(sample / n));
        let mut masks = vec![0u32; places.len()];
        for &slab in &slabs {
            let touched = rasterize(&proxy, slab, shift, size, &mut masks);
            let groups: Vec<_> = touched.chunks(GROUP).collect();
            in_parallel(control, groups.len() as u32, |g| {
                run(scene.level, Group { scene, texture, slab, which: groups[g as usize], masks: &masks, held: &held });
            })?;
            touched.iter().for_each(|&i| masks[i] = 0);
        }
        for waiting in held.into_iter().map(Mutex::into_inner) {
            waiting.unwrap_or_else(PoisonError::into_inner).waiting.finish(scene, &mut picture);
        }
    }
    Ok(picture.mean(n * n))
}

/// Sets the bits of the pixels of a slab, in the masks of their sixteens; returns which of these were touched.
fn rasterize(proxy: &ProxyGeometry<'_>, slab: Slab, shift: DVec2, size: [u32; 2], masks: &mut [u32]) -> Vec<usize> {
    let across = size[0].div_ceil(4) as usize;
    let mut touched = Vec::new();
    for span in proxy.polygons(slab, shift).iter().flat_map(|polygon| polygon_spans(polygon, size)) {
        for x in span.begin..span.end {
            let sixteen = (span.y / 4) as usize * across + (x / 4) as usize;
            if masks[sixteen] == 0 {
                touched.push(sixteen);
            }
            masks[sixteen] |= 1 << (span.y % 4 * 4 + x % 4);
        }
    }
    touched
}

/// Sixteen rays, between slabs.
struct Held {
    waiting: Waiting,
    /// Numbers of each ray's first slab and of its last, and of the one in the middle, from which samples are counted.
    slabs: [[f64; LANES]; 3],
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
        let (mut slabs, mut falling) = ([[0.0; LANES]; 3], 0);
        for i in (0..LANES).filter(|i| rays.hits >> i & 1 == 1) {
            let of = self.scene.setup.slabs(&rays.chords, i);
            [slabs[0][i], slabs[1][i], slabs[2][i]] = [of.first, of.last, of.middle()];
            let direction = rays.chords.direction.map(|axis| axis[i]);
            falling |= u32::from(self.scene.setup.slices.fall_along(direction)) << i;
        }
        Held { waiting, slabs, falling }
    }
}

/// Sixteens of pixels that a slab has touched.
struct Group<'a, X> {
    scene: &'a PacketScene<'a>,
    texture: &'a X,
    slab: Slab,
    which: &'a [usize],
    masks: &'a [u32],
    held: &'a [Mutex<Held>],
}

impl<X: Texture> Vectorized for Group<'_, X> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut chunk = Chunk::EMPTY;
        let mut texture = Fetcher::new(self.texture);
        for &i in self.which {
            locked(&self.held[i]).draw(simd, self.scene, &mut texture, &mut chunk, (self.slab, self.masks[i]));
        }
    }
}

impl Held {
    /// Draws the fragments of a slab on the pixels that were rasterised.
    fn draw<S: Simd>(
        &mut self,
        simd: S,
        scene: &PacketScene<'_>,
        texture: &mut dyn Fetch<S>,
        chunk: &mut Chunk,
        (slab, rasterized): (Slab, u32),
    ) {
        let falling = if slab.falling { self.falling } else { !self.falling };
        let step = self.samples(&scene.pass.operator, scene.pass.on_faces, slab.number, rasterized & falling);
        if step.first | step.whole | step.last == 0 {
            return;
        }
        self.waiting.march(scene, texture, chunk, |march| march.step(simd, &step));
    }

    /// The samples of a slab, on those of the pixels rasterised whose rays have a part of it, and have not ended.
    fn samples(&self, operator: &Operator, on_faces: bool, number: f64, rasterized: u32) -> Step {
        let mut step = Step { first: 0, whole: 0, last: 0, number: Lanes::ZERO };
        let backwards = *operator == Operator::Over;
        let [first, last, middle] = &self.slabs;
        for i in 0..LANES {
            let rays = &self.waiting.rays;
            let live = rasterized & rays.hits & 1 << i != 0 && rays.end.0[i] > f32::NEG_INFINITY;
            if !live || number < first[i] || number > last[i] {
                continue;
            }
            let [enters, leaves] = if backwards { [last[i], first[i]] } else { [first[i], last[i]] };
            let (enters, leaves) = (number == enters, number == leaves);
            // A sample on a face is that behind a slab, and where a ray enters there is one more. The only slab of a ray has a first sample, turned a last.
            step.first |= u32::from(enters && (on_faces || !(leaves && backwards))) << i;
            step.whole |= u32::from(!leaves && (on_faces || !enters)) << i;
            step.last |= u32::from(leaves && (on_faces || !enters || backwards)) << i;
            let behind = number - middle[i];
            step.number.0[i] = if backwards { f64::from(u8::from(on_faces)) - behind } else { behind } as f32;
        }
        step
    }
}
