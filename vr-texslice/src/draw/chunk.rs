//! A few samples of sixteen rays, on their way from stage to stage.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Cells, LANES, Lanes, pick, splat};

use crate::fragments::Fragments;
use crate::texture::Texture;

/// Samples of a ray that pass through the stages together: stages are functions of their own, each compiled once for a texture or an operator, not
/// for each pair of them, and a chunk is what a call is for.
pub(crate) const CHUNK: usize = 8;

/// Values, or light and opacity, of up to [`CHUNK`] samples.
#[derive(Clone, Copy)]
pub(crate) struct Chunk {
    /// Number of samples.
    pub(crate) len: usize,
    pub(crate) value: [Lanes; CHUNK],
    pub(crate) light: [[Lanes; 4]; CHUNK],
    /// Gradients per step of texture coordinates, where light asked for them.
    pub(crate) gradient: [[Lanes; 3]; CHUNK],
}

impl Chunk {
    pub(crate) const EMPTY: Self = Self {
        len: 0,
        value: [Lanes::ZERO; CHUNK],
        light: [[Lanes::ZERO; 4]; CHUNK],
        gradient: [[Lanes::ZERO; 3]; CHUNK],
    };

    /// Mask of the rays on which a sample has any light or opacity; vacuum has none.
    #[inline(always)]
    pub(super) fn lit<S: Simd>(&self, simd: S, sample: usize) -> u32 {
        let zero = f32x16::splat(simd, 0.0);
        let [r, g, b, a] = &self.light[sample];
        let largest = r.load(simd).max(g.load(simd)).max(b.load(simd)).max(a.load(simd));
        largest.simd_gt(zero).to_bitmask() as u32
    }
}

/// Set of samples of rays.
#[derive(Clone, Copy)]
pub(crate) enum SampleSet<'a> {
    /// The first ones (0), or the last (1).
    Outer(usize),
    /// Whole ones from these numbers on.
    From(&'a Lanes),
}

impl SampleSet<'_> {
    /// Positions in the middle of the segments that end at the samples `j` behind these, on faces of slabs.
    #[inline(always)]
    pub(crate) fn middle<S: Simd>(self, simd: S, rays: &Fragments, j: usize) -> [f32x16<S>; 3] {
        let (begin, end) = (rays.begin.load(simd), rays.end.load(simd));
        let half = splat(simd, 0.5);
        let mut middle = [half; 3];
        for a in 0..3 {
            let (base, delta) = (rays.base[a].load(simd), rays.delta[a].load(simd));
            let (first, last) = (rays.outer[0][a].load(simd), rays.outer[1][a].load(simd));
            middle[a] = match self {
                // The last begins at the last face within the ray, or where the ray enters.
                SampleSet::Outer(_) => {
                    let from = pick(begin.simd_lt(end), base + (end - 1.0) * delta, first);
                    (from + last) * half
                }
                SampleSet::From(number) => {
                    let n = number.load(simd) + j as f32;
                    let to = base + n * delta;
                    pick(n.simd_le(begin), (first + to) * half, base + (n - 0.5) * delta)
                }
            };
        }
        middle
    }

    /// Positions of the samples `j` behind these, in texture coordinates.
    #[inline(always)]
    pub(crate) fn position<S: Simd>(self, simd: S, rays: &Fragments, j: usize) -> [f32x16<S>; 3] {
        match self {
            SampleSet::Outer(end) => {
                let at = &rays.outer[end];
                [at[0].load(simd), at[1].load(simd), at[2].load(simd)]
            }
            SampleSet::From(number) => {
                let n = number.load(simd) + j as f32;
                [
                    rays.base[0].load(simd) + n * rays.delta[0].load(simd),
                    rays.base[1].load(simd) + n * rays.delta[1].load(simd),
                    rays.base[2].load(simd) + n * rays.delta[2].load(simd),
                ]
            }
        }
    }

    /// Places of the samples `j` behind these.
    #[inline(always)]
    fn place<S: Simd, X: Texture>(self, simd: S, texture: &X, rays: &Fragments, j: usize) -> Cells<S> {
        texture.place(simd, self.position(simd, rays, j))
    }
}

/// A texture, a chunk of samples to a call: so what calls it is compiled once, not anew for each texture.
pub(crate) trait Fetch<S: Simd> {
    /// Fetches samples of rays into a chunk: its `len` first ones.
    fn fetch(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, chunk: &mut Chunk);

    /// Fetches a sample of the rays of several sixteens each, the j-th into place j of a chunk.
    fn fetch_across(&mut self, simd: S, samples: &[(&Fragments, &Lanes)], chunk: &mut Chunk);

    /// Finds gradients at a chunk's samples that have light, zero at others; `segments`: in the middle of the segments which end at them.
    fn gradients(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, segments: bool, chunk: &mut Chunk);
}

/// A texture, and where what is fetched from it waits.
pub(crate) struct Fetcher<'a, X: Texture> {
    pub(super) texture: &'a X,
    pub(super) stages: [X::Stage; 2],
}

impl<'a, X: Texture> Fetcher<'a, X> {
    pub(crate) fn new(texture: &'a X) -> Self {
        Self { texture, stages: [X::Stage::default(), X::Stage::default()] }
    }
}

impl<S: Simd, X: Texture> Fetch<S> for Fetcher<'_, X> {
    fn fetch(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, chunk: &mut Chunk) {
        simd.vectorize(
            #[inline(always)]
            || {
                let [stage, next_stage] = &mut self.stages;
                let (mut now, mut next) = (stage, next_stage);
                let mut at = which.place(simd, self.texture, rays, 0);
                self.texture.fetch(simd, &at, now);
                for j in 0..chunk.len {
                    // While one waits for its texels, those of the next one are fetched.
                    let ahead = which.place(simd, self.texture, rays, (j + 1).min(chunk.len - 1));
                    if j + 1 < chunk.len {
                        self.texture.fetch(simd, &ahead, next);
                    }
                    put::<S, X>(self.texture.read(simd, &at, now), j, chunk);
                    (at, now, next) = (ahead, next, now);
                }
            },
        );
    }

    fn fetch_across(&mut self, simd: S, samples: &[(&Fragments, &Lanes)], chunk: &mut Chunk) {
        simd.vectorize(
            #[inline(always)]
            || {
                let Some(last) = samples.len().checked_sub(1) else { return };
                let [stage, next_stage] = &mut self.stages;
                let (mut now, mut next) = (stage, next_stage);
                let mut at = SampleSet::From(samples[0].1).place(simd, self.texture, samples[0].0, 0);
                self.texture.fetch(simd, &at, now);
                for j in 0..=last {
                    // As along a ray: those of the next sixteen are fetched meanwhile.
                    let (rays, number) = samples[(j + 1).min(last)];
                    let ahead = SampleSet::From(number).place(simd, self.texture, rays, 0);
                    if j < last {
                        self.texture.fetch(simd, &ahead, next);
                    }
                    put::<S, X>(self.texture.read(simd, &at, now), j, chunk);
                    (at, now, next) = (ahead, next, now);
                }
            },
        );
    }

    fn gradients(&mut self, simd: S, rays: &Fragments, which: SampleSet<'_>, segments: bool, chunk: &mut Chunk) {
        simd.vectorize(
            #[inline(always)]
            || {
                for j in 0..chunk.len {
                    let wanted = chunk.lit(simd, j);
                    if wanted == 0 {
                        chunk.gradient[j] = [Lanes::ZERO; 3];
                        continue;
                    }
                    let at = if segments {
                        self.texture.place_between(simd, which.middle(simd, rays, j))
                    } else {
                        which.place(simd, self.texture, rays, j)
                    };
                    chunk.gradient[j] = self.texture.gradient(simd, &at, wanted, &mut self.stages[0]);
                }
            },
        );
    }
}

/// Puts what was read from a texture into a place of a chunk.
#[inline(always)]
fn put<S: Simd, X: Texture>([r, g, b, a]: [f32x16<S>; 4], j: usize, chunk: &mut Chunk) {
    if X::LIGHT {
        chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
    } else {
        chunk.value[j] = Lanes::new(r);
    }
}

/// Box of cells that the next samples of rays touch, from the first to the last along each axis; and the number of these samples.
pub(crate) struct Reach {
    pub(crate) cells: [[usize; 2]; 3],
    pub(crate) samples: u64,
}

/// The reach of the `len` samples of live rays from numbers on, in a texture of so many texels along each axis; along the last one, places may be so far from where
/// samples are.
#[inline(never)]
pub(crate) fn reach<S: Simd>(
    simd: S,
    rays: &Fragments,
    number: &Lanes,
    len: usize,
    (dims, snap): ([usize; 3], f32),
) -> Reach {
    simd.vectorize(
        #[inline(always)]
        || {
            let (from, end) = (number.load(simd), rays.end.load(simd));
            let live = from.simd_lt(end);
            let count = pick(live, (end - from).min(splat(simd, len as f32)), splat(simd, 0.0));
            let to = from + (count - 1.0);
            let (never, always) = (splat(simd, f32::NEG_INFINITY), splat(simd, f32::INFINITY));
            let mut cells = [[0; 2]; 3];
            for a in 0..3 {
                let (base, delta) = (rays.base[a].load(simd), rays.delta[a].load(simd));
                let (p, q) = (base + from * delta, base + to * delta);
                let low = pick(live, p.min(q), always).to_array();
                let high = pick(live, p.max(q), never).to_array();
                let (mut min, mut max) = (f32::INFINITY, f32::NEG_INFINITY);
                for i in 0..LANES {
                    min = min.min(low[i]);
                    max = max.max(high[i]);
                }
                if a == 2 {
                    (min, max) = (min - snap, max + snap);
                }
                // Into the box, as texels are. `as` saturates.
                cells[a] = [(min as usize).min(dims[a] - 2), (max as usize).min(dims[a] - 2)];
            }
            let mut samples = 0.0;
            for n in count.to_array() {
                samples += n;
            }
            Reach { cells, samples: samples as u64 }
        },
    )
}
