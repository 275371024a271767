//! A picture tile by tile: all slices of sixteen pixels, then the next sixteen.

use fearless_simd::{Level, Simd};
use glam::DVec2;
use vr_core::image_order::in_parallel;
use vr_core::{Control, Counts, Layer, MaxRadiance, RenderError, View, cancel};
use vr_kernels::vector::{LANES, Lanes, PacketLights, PacketShading, Shade, Vectorized, run};

use super::chunk::{Chunk, Fetch, Fetcher};
use super::march::{March, PacketResult, Pass};
use super::state::State;
use crate::fragments::{Fragments, Setup};
use crate::texture::Texture;

/// Inputs of all pixels.
#[derive(Clone, Copy)]
pub(crate) struct PacketScene<'a> {
    pub(crate) view: &'a View,
    pub(crate) layer: Option<&'a Layer>,
    pub(crate) setup: Setup<'a>,
    pub(crate) pass: Pass<'a>,
    pub(crate) shading: Option<&'a PacketShading>,
    pub(crate) max_radiance: MaxRadiance,
    pub(crate) finish: &'a (dyn Fn(&Fragments, &State, usize) -> Pixel + Sync),
    pub(crate) level: Level,
}

impl PacketScene<'_> {
    /// True if fragments look at gradients, for their opacity or for the light that they reflect.
    pub(super) fn looks_at_gradients(&self) -> bool {
        self.shading.is_some() || self.pass.steepness.is_some()
    }
}

/// A pixel: premultiplied, and the world distance to what is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    pub(crate) rgba: [f64; 4],
    pub(crate) depth: f64,
}

impl Pixel {
    pub(crate) const NOTHING: Self = Self { rgba: [0.0; 4], depth: f64::INFINITY };

    /// Two samples of a pixel: their light, and the nearer depth.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { rgba: std::array::from_fn(|c| self.rgba[c] + other.rgba[c]), depth: self.depth.min(other.depth) }
    }

    /// Light times a factor.
    pub(crate) fn times(&self, factor: f64) -> Self {
        Self { rgba: self.rgba.map(|c| c * factor), depth: self.depth }
    }

    /// Before an opaque layer.
    fn over(self, layer: &Layer, pixel: usize) -> Self {
        Self { rgba: layer.under(pixel, self.rgba), depth: self.depth.min(layer.depth(pixel)) }
    }
}

/// Pixels along the edge of a tile, and of the blocks of sixteen in it.
const TILE: u32 = 32;
const BLOCK: u32 = 4;

/// Draws every pixel of a view, tile by tile on all threads. The picture does not depend on their number.
pub(crate) fn draw_tiles<X: Texture>(
    scene: &PacketScene<'_>,
    texture: &X,
    control: &Control,
) -> Result<(Vec<Pixel>, Counts), RenderError> {
    let [w, h] = scene.view.size;
    let across = w.div_ceil(TILE);
    let tiles = in_parallel(control, across * h.div_ceil(TILE), |t| {
        let corner = [t % across * TILE, t / across * TILE];
        run(scene.level, Tile { scene, texture, corner })
    })?;
    let mut pixels = vec![Pixel::NOTHING; w as usize * h as usize];
    let mut counts = Counts::default();
    for (drawn, counted) in tiles {
        counts += counted;
        for (at, pixel) in drawn {
            pixels[at] = pixel;
        }
    }
    Ok((pixels, counts))
}

struct Tile<'a, X> {
    scene: &'a PacketScene<'a>,
    texture: &'a X,
    corner: [u32; 2],
}

impl<X: Texture> Vectorized for Tile<'_, X> {
    type Output = (Vec<(usize, Pixel)>, Counts);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        draw_tile(simd, self.scene, self.corner, &mut Fetcher::new(self.texture))
    }
}

fn draw_tile<S: Simd>(
    simd: S,
    scene: &PacketScene<'_>,
    corner: [u32; 2],
    texture: &mut dyn Fetch<S>,
) -> (Vec<(usize, Pixel)>, Counts) {
    let size = scene.view.size;
    let end = [0, 1].map(|a| (corner[a] + TILE).min(size[a]));
    let mut drawn = Vec::with_capacity((TILE * TILE) as usize);
    let mut counts = Counts::default();
    let mut block = Block { chunk: Chunk::EMPTY, rays: Fragments::EMPTY, lights: PacketLights::default() };
    for y in (corner[1]..end[1]).step_by(BLOCK as usize) {
        for x in (corner[0]..end[0]).step_by(BLOCK as usize) {
            cancel::poll();
            block.draw(simd, scene, texture, Packet { corner: [x, y], size }, &mut drawn, &mut counts);
        }
    }
    (drawn, counts)
}

/// Sixteen pixels, 4×4, fewer at the picture's edges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packet {
    corner: [u32; 2],
    size: [u32; 2],
}

/// All pixels of a picture.
pub(crate) fn sixteens(size: [u32; 2]) -> Vec<Packet> {
    let rows = (0..size[1]).step_by(BLOCK as usize);
    rows.flat_map(|y| (0..size[0]).step_by(BLOCK as usize).map(move |x| Packet { corner: [x, y], size })).collect()
}

impl Packet {
    /// Column and row of pixel `i`; beyond the picture's edge as well.
    fn pixel(&self, i: usize) -> [u32; 2] {
        [self.corner[0] + i as u32 % BLOCK, self.corner[1] + i as u32 / BLOCK]
    }

    /// Number of pixel `i`, row by row; `None` beyond the picture's edge.
    fn number(&self, i: usize) -> Option<usize> {
        let [x, y] = self.pixel(i);
        (x < self.size[0] && y < self.size[1]).then(|| y as usize * self.size[0] as usize + x as usize)
    }

    /// True if it and a box of the screen have anything in common.
    pub(crate) fn overlaps(&self, low: DVec2, high: DVec2) -> bool {
        let at = DVec2::new(f64::from(self.corner[0]), f64::from(self.corner[1]));
        (at + f64::from(BLOCK)).cmpge(low).all() && at.cmple(high).all()
    }

    /// The rays of sample `k` of each pixel.
    pub(crate) fn set_up<S: Simd>(&self, simd: S, scene: &PacketScene<'_>, k: u32, rays: &mut Fragments) {
        let n = scene.view.supersampling;
        let centre = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
        let x = std::array::from_fn(|i| f64::from(self.pixel(i)[0]) + centre(k % n));
        let y = std::array::from_fn(|i| f64::from(self.pixel(i)[1]) + centre(k / n));
        let layer = scene.layer;
        let far = std::array::from_fn(|i| match (layer, self.number(i)) {
            (Some(layer), Some(pixel)) => layer.depth(pixel),
            _ => f64::INFINITY,
        });
        let counted = (0..LANES).filter(|&i| self.number(i).is_some()).fold(0, |bits, i| bits | 1 << i);
        scene.setup.fragments(simd, [&x, &y], &far, counted, rays);
    }

    /// Hands over what each pixel has become, by its number.
    pub(crate) fn finish(
        &self,
        scene: &PacketScene<'_>,
        rays: &Fragments,
        state: &State,
        mut put: impl FnMut(usize, Pixel),
    ) {
        for i in 0..LANES {
            let Some(number) = self.number(i) else { continue };
            let hit = rays.hits >> i & 1 == 1;
            let pixel = if hit { (scene.finish)(rays, state, i) } else { Pixel::NOTHING };
            put(number, scene.layer.map_or(pixel, |layer| pixel.over(layer, number)));
        }
    }
}

/// Working memory of sixteen pixels.
struct Block {
    chunk: Chunk,
    rays: Fragments,
    lights: PacketLights,
}

impl Block {
    fn draw<S: Simd>(
        &mut self,
        simd: S,
        scene: &PacketScene<'_>,
        texture: &mut dyn Fetch<S>,
        at: Packet,
        drawn: &mut Vec<(usize, Pixel)>,
        counts: &mut Counts,
    ) {
        let rays = scene.view.supersampling * scene.view.supersampling;
        let first = drawn.len();
        for k in 0..rays {
            at.set_up(simd, scene, k, &mut self.rays);
            let mut state = State::new(scene.pass.operator);
            if self.rays.hits != 0 {
                counts.rays += u64::from(self.rays.hits.count_ones());
                let done = self.march(simd, scene, texture, &mut state);
                counts.samples += done.drawn;
                counts.skipped += done.skipped;
            }
            let mut i = first;
            at.finish(scene, &self.rays, &state, |number, pixel| {
                if k == 0 {
                    drawn.push((number, pixel));
                } else {
                    drawn[i].1 = drawn[i].1.plus(&pixel);
                }
                i += 1;
            });
        }
        if rays > 1 {
            drawn[first..].iter_mut().for_each(|(_, pixel)| *pixel = pixel.times(1.0 / f64::from(rays)));
        }
    }

    fn march<S: Simd>(
        &mut self,
        simd: S,
        scene: &PacketScene<'_>,
        texture: &mut dyn Fetch<S>,
        state: &mut State,
    ) -> PacketResult {
        if let Some(shading) = scene.shading {
            self.lights.look_along(&shading.lights, &self.rays.chords.along);
        }
        let max_behind = self.rays.max_behind(scene.max_radiance);
        let mut march = March {
            texture,
            pass: &scene.pass,
            lit: scene.shading.map(|shading| Shade { shading, lights: &self.lights }),
            max_behind: &max_behind,
            chunk: &mut self.chunk,
            rays: &mut self.rays,
            state,
            before: Lanes([f32::NAN; LANES]),
            done: PacketResult::default(),
        };
        march.run(simd);
        march.done
    }
}
