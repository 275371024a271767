//! A picture tile by tile: all slices of sixteen pixels, then the next sixteen.

use fearless_simd::{Level, Simd};
use vr_core::image_order::in_parallel;
use vr_core::vector::{LANES, Lanes, PacketLights, PacketShading, Vectorized, run};
use vr_core::{Control, Counts, Layer, RenderError, View};

use super::march::{Done, March, Pass, Workbench};
use super::state::State;
use crate::fragments::{Fragments, Setup};
use crate::texture::{Lit, Texture};

/// Everything that pixels need.
#[derive(Clone, Copy)]
pub(crate) struct Scene16<'a> {
    pub(crate) view: &'a View,
    pub(crate) setup: Setup<'a>,
    pub(crate) pass: Pass<'a>,
    pub(crate) shading: Option<&'a PacketShading>,
    pub(crate) most: Brightest,
    pub(crate) finish: &'a (dyn Fn(&Fragments, &State, usize) -> Pixel + Sync),
    pub(crate) level: Level,
}

/// The largest light that can come from behind.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Brightest {
    /// No colour is brighter.
    Radiance(f64),
    /// Nothing emits more per world unit.
    Emission(f64),
}

/// A pixel: premultiplied, and the world distance to what is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pixel {
    pub(crate) rgba: [f64; 4],
    pub(crate) depth: f64,
}

impl Pixel {
    pub(crate) const NOTHING: Self = Self { rgba: [0.0; 4], depth: f64::INFINITY };

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
    scene: &Scene16<'_>,
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
    scene: &'a Scene16<'a>,
    texture: &'a X,
    corner: [u32; 2],
}

impl<X: Texture> Vectorized for Tile<'_, X> {
    type Output = (Vec<(usize, Pixel)>, Counts);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let [w, h] = self.scene.view.size;
        let end = [(self.corner[0] + TILE).min(w), (self.corner[1] + TILE).min(h)];
        let mut drawn = Vec::with_capacity((TILE * TILE) as usize);
        let mut counts = Counts::default();
        let mut block = Block::<X>::default();
        for y in (self.corner[1]..end[1]).step_by(BLOCK as usize) {
            for x in (self.corner[0]..end[0]).step_by(BLOCK as usize) {
                block.draw(simd, self.scene, self.texture, [x, y], &mut drawn, &mut counts);
            }
        }
        (drawn, counts)
    }
}

/// What sixteen pixels are drawn with.
struct Block<X: Texture> {
    bench: Workbench<X>,
    rays: Fragments,
    lights: PacketLights,
}

impl<X: Texture> Default for Block<X> {
    fn default() -> Self {
        Self { bench: Workbench::default(), rays: Fragments::EMPTY, lights: PacketLights::default() }
    }
}

/// Pixel i of the sixteen of a block: column and row.
pub(crate) fn spot(i: usize) -> [u32; 2] {
    [i as u32 % BLOCK, i as u32 / BLOCK]
}

impl<X: Texture> Block<X> {
    fn draw<S: Simd>(
        &mut self,
        simd: S,
        scene: &Scene16<'_>,
        texture: &X,
        corner: [u32; 2],
        drawn: &mut Vec<(usize, Pixel)>,
        counts: &mut Counts,
    ) {
        let [w, h] = scene.view.size;
        let layer = scene.view.layer.as_deref();
        let n = scene.view.samples;
        let mut sum = [Pixel { rgba: [0.0; 4], depth: f64::INFINITY }; LANES];
        // Beyond the picture's edge there is nothing to draw.
        let exists = |i: usize| corner[0] + spot(i)[0] < w && corner[1] + spot(i)[1] < h;
        let number = |i: usize| {
            let [x, y] = spot(i);
            (corner[1] + y).min(h - 1) as usize * w as usize + (corner[0] + x).min(w - 1) as usize
        };
        let counted = (0..LANES).filter(|&i| exists(i)).fold(0, |bits, i| bits | 1 << i);
        for k in 0..n * n {
            let centre = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
            let x = std::array::from_fn(|i| f64::from(corner[0] + spot(i)[0]) + centre(k % n));
            let y = std::array::from_fn(|i| f64::from(corner[1] + spot(i)[1]) + centre(k / n));
            let far = std::array::from_fn(|i| layer.map_or(f64::INFINITY, |l| l.depth(number(i))));
            scene.setup.fragments(simd, [&x, &y], &far, counted, &mut self.rays);
            let mut state = State::new(scene.pass.operator);
            if self.rays.hits != 0 {
                counts.rays += u64::from(self.rays.hits.count_ones());
                let done = self.march(simd, scene, texture, &mut state);
                counts.samples += done.drawn;
                counts.skipped += done.skipped;
            }
            for i in (0..LANES).filter(|&i| exists(i)) {
                let hit = self.rays.hits >> i & 1 == 1;
                let mut pixel = if hit { (scene.finish)(&self.rays, &state, i) } else { Pixel::NOTHING };
                if let Some(layer) = layer {
                    pixel = pixel.over(layer, number(i));
                }
                (0..4).for_each(|c| sum[i].rgba[c] += pixel.rgba[c]);
                sum[i].depth = sum[i].depth.min(pixel.depth);
            }
        }
        let share = 1.0 / f64::from(n * n);
        let mean = |p: &Pixel| Pixel { rgba: p.rgba.map(|c| c * share), depth: p.depth };
        drawn.extend((0..LANES).filter(|&i| exists(i)).map(|i| (number(i), mean(&sum[i]))));
    }

    fn march<S: Simd>(&mut self, simd: S, scene: &Scene16<'_>, texture: &X, state: &mut State) -> Done {
        let lit = scene.shading.map(|shading| {
            self.lights.look_along(&shading.shading, &self.rays.chords.along);
            shading
        });
        let most = scene.most.behind(&self.rays);
        let mut march = March {
            texture,
            pass: &scene.pass,
            lit: lit.map(|shading| Lit { shading, lights: &self.lights }),
            most: &most,
            bench: &mut self.bench,
            rays: &mut self.rays,
            state,
            before: Lanes([f32::NAN; LANES]),
            done: Done::default(),
        };
        march.run(simd);
        march.done
    }
}

impl Brightest {
    /// Of each ray.
    pub(crate) fn behind(self, rays: &Fragments) -> Lanes {
        match self {
            Self::Radiance(c) => Lanes([c.max(1.0) as f32; LANES]),
            Self::Emission(q) => Lanes(std::array::from_fn(|i| {
                let [begin, length] = &rays.outer_span[1];
                let end = rays.distance_at(i, begin.0[i] + length.0[i]);
                let start = rays.distance_at(i, rays.outer_span[0][0].0[i]);
                (q * (end - start)).max(1.0) as f32
            })),
        }
    }
}
