//! The fragments of sixteen pixels: where slices meet their rays, in f64, and what a kernel needs of that, in f32.

use fearless_simd::Simd;
use vr_core::{Clip, MaxRadiance, Placement, Rays};
use vr_kernels::vector::{Chords, LANES, Lanes};

use crate::slices::{Slabs, Slices};

/// Inputs that the pixels of a view share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setup<'a> {
    pub(crate) rays: &'a Rays,
    pub(crate) placement: &'a Placement,
    pub(crate) dims: [usize; 3],
    pub(crate) clip: &'a Clip,
    pub(crate) slices: &'a Slices,
    /// Texture coordinate c is the index along axis `axes[c]`.
    pub(crate) axes: [usize; 3],
    /// True if samples are at the ends of slabs, and not in the middle of a ray's part of them.
    pub(crate) on_faces: bool,
}

/// The samples of sixteen rays: a first one, those of whole slabs one after the other, and a last one.
///
/// In the middle of slabs: a ray of n slabs has a first sample, n − 2 whole ones, and a last one if n > 1. On their faces: the first is where it
/// enters, the last where it leaves, and n − 1 lie between. Whole ones are counted from the ray's middle one, so that a base and so many times a
/// difference, in f32, are as exact as they can be.
#[derive(Clone, Debug)]
pub(crate) struct Fragments {
    /// Bit i: ray i meets the volume.
    pub(crate) hits: u32,
    /// 1 for rays that have a first sample, and a last one, 0 for others.
    pub(crate) has: [Lanes; 2],
    /// Positions of the first sample and of the last.
    pub(crate) outer: [[Lanes; 3]; 2],
    /// Length of the first slab and of the last, in table lengths ([`Slices::ratio`]); and of a whole one.
    pub(crate) outer_ratio: [Lanes; 2],
    pub(crate) ratio: Lanes,
    /// Position of the sample numbered 0, and from one to the next.
    pub(crate) base: [Lanes; 3],
    pub(crate) delta: [Lanes; 3],
    /// Number of the first whole sample, and of the one behind the last; −∞ for a ray that misses.
    pub(crate) begin: Lanes,
    pub(crate) end: Lanes,
    /// Number at which the first slab begins, and how much of a whole one it is; the same of the last.
    pub(crate) outer_span: [[Lanes; 2]; 2],
    /// From numbers to world distances along the rays: the distance of number 0, and from one to the next.
    pub(crate) distance: [[f64; LANES]; 2],
    /// The rays' parts in the volume's own index space.
    pub(crate) chords: Chords,
}

impl Fragments {
    pub(crate) const EMPTY: Self = Self {
        hits: 0,
        has: [Lanes::ZERO; 2],
        outer: [[Lanes::ZERO; 3]; 2],
        outer_ratio: [Lanes::ZERO; 2],
        ratio: Lanes::ZERO,
        base: [Lanes::ZERO; 3],
        delta: [Lanes::ZERO; 3],
        begin: Lanes::ZERO,
        end: Lanes::ZERO,
        outer_span: [[Lanes::ZERO; 2]; 2],
        distance: [[0.0; LANES]; 2],
        chords: Chords {
            origin: [[0.0; LANES]; 3],
            direction: [[0.0; LANES]; 3],
            start: [0.0; LANES],
            end: [0.0; LANES],
            offset: [0.0; LANES],
            along: [[0.0; LANES]; 3],
        },
    };

    /// The same samples from the last to the first, and numbers that grow towards the eye.
    pub(crate) fn turn(&mut self) {
        self.has.swap(0, 1);
        self.outer.swap(0, 1);
        self.outer_ratio.swap(0, 1);
        self.outer_span.swap(0, 1);
        for i in 0..LANES {
            if self.hits >> i & 1 == 1 {
                (self.begin.0[i], self.end.0[i]) = (1.0 - self.end.0[i], 1.0 - self.begin.0[i]);
            }
            for a in 0..3 {
                self.delta[a].0[i] = -self.delta[a].0[i];
            }
            for [begin, length] in &mut self.outer_span {
                begin.0[i] = -(begin.0[i] + length.0[i]);
            }
            self.distance[1][i] = -self.distance[1][i];
        }
    }

    /// Ends a ray: it takes no more samples.
    #[inline(always)]
    pub(crate) fn stop(&mut self, ray: usize) {
        self.end.0[ray] = f32::NEG_INFINITY;
        self.has[1].0[ray] = 0.0;
    }

    /// Index-space position in the volume at a world distance along a ray.
    pub(crate) fn index_at(&self, ray: usize, distance: f64) -> [f64; 3] {
        let s = distance - self.chords.offset[ray];
        std::array::from_fn(|a| self.chords.origin[a][ray] + self.chords.direction[a][ray] * s)
    }

    /// World distance along a ray at a number.
    pub(crate) fn distance_at(&self, ray: usize, number: f32) -> f64 {
        self.distance[0][ray] + f64::from(number) * self.distance[1][ray]
    }

    /// Largest light, or opacity, that can come from behind along each ray, by what is left clear.
    pub(crate) fn max_behind(&self, max_radiance: MaxRadiance) -> Lanes {
        Lanes(std::array::from_fn(|i| {
            let [begin, length] = &self.outer_span[1];
            let end = self.distance_at(i, begin.0[i] + length.0[i]);
            let start = self.distance_at(i, self.outer_span[0][0].0[i]);
            max_radiance.over(end - start) as f32
        }))
    }
}

impl Setup<'_> {
    /// The fragments of the rays through `x`, `y` as far as world distances `far`, of those among them that count.
    #[inline(never)]
    pub(crate) fn fragments<S: Simd>(
        &self,
        simd: S,
        at: [&[f64; LANES]; 2],
        far: &[f64; LANES],
        counted: u32,
        out: &mut Fragments,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.fill(at, far, counted, out),
        );
    }

    /// The slabs of one of sixteen rays, which meets the volume.
    #[inline(always)]
    pub(crate) fn slabs(&self, chords: &Chords, ray: usize) -> Slabs {
        let coordinate = self.slices.coordinate(
            std::array::from_fn(|a| chords.origin[a][ray]),
            std::array::from_fn(|a| chords.direction[a][ray]),
            chords.offset[ray],
        );
        Slabs::new(coordinate, chords.start[ray], chords.end[ray])
    }

    #[inline(always)]
    fn fill(&self, at: [&[f64; LANES]; 2], far: &[f64; LANES], counted: u32, out: &mut Fragments) {
        let chords = Chords::new(self.rays, at, self.placement, self.dims, self.clip, far);
        out.chords = chords;
        out.hits = 0;
        for i in 0..LANES {
            let (start, end) = (chords.start[i], chords.end[i]);
            let hit = start < end && counted >> i & 1 == 1;
            out.hits |= u32::from(hit) << i;
            if !hit {
                (out.begin.0[i], out.end.0[i]) = (0.0, f32::NEG_INFINITY);
                (out.has[0].0[i], out.has[1].0[i]) = (0.0, 0.0);
                continue;
            }
            // The ray in texture coordinates, and its slabs.
            let origin: [f64; 3] = std::array::from_fn(|a| chords.origin[self.axes[a]][i]);
            let direction: [f64; 3] = std::array::from_fn(|a| chords.direction[self.axes[a]][i]);
            let slabs = self.slabs(&chords, i);
            let several = slabs.last > slabs.first;
            let middle = slabs.middle();
            let (first_end, last_begin) = (slabs.first_end(), slabs.last_begin());
            // Lengths of the samples' slabs, in table lengths.
            let ratio = |length: f64| self.slices.ratio(length, slabs.slope) as f32;
            out.outer_ratio[0].0[i] = ratio(first_end - start);
            out.outer_ratio[1].0[i] = ratio(end - last_begin);
            out.ratio.0[i] = if self.slices.are_even() { 1.0 } else { ratio(1.0 / slabs.slope) };
            // Distances of the first and the last sample, and the slab coordinate of the one numbered 0.
            let (outer, number) = if self.on_faces {
                ([start, end], middle + 0.5)
            } else {
                ([0.5 * (start + first_end), 0.5 * (last_begin + end)], middle)
            };
            // Faces lie half a slab behind what they are numbered by; there is none behind the last slab.
            out.begin.0[i] = (slabs.first - middle) as f32 + if self.on_faces { 0.0 } else { 1.0 };
            out.end.0[i] = (slabs.last - middle) as f32;
            out.has[0].0[i] = 1.0;
            out.has[1].0[i] = f32::from(u8::from(several || self.on_faces));
            // A ray along its only slab: that is number 0 to 1.
            let (base, step) = if several { (slabs.distance_of(number), 1.0 / slabs.slope) } else { (start, 0.0) };
            // From numbers to distances, and to texture coordinates.
            let scale = if several { step } else { end - start };
            out.distance[0][i] = chords.offset[i] + base;
            out.distance[1][i] = scale;
            let span = |from: f64, to: f64| [((from - base) / scale) as f32, ((to - from) / scale) as f32];
            for (k, [from, to]) in [[start, first_end], [last_begin, end]].into_iter().enumerate() {
                let [begin, length] = span(from, to);
                (out.outer_span[k][0].0[i], out.outer_span[k][1].0[i]) = (begin, length);
            }
            for a in 0..3 {
                let at = |s: f64| (origin[a] + direction[a] * s) as f32;
                out.base[a].0[i] = at(base);
                out.delta[a].0[i] = (direction[a] * step) as f32;
                out.outer[0][a].0[i] = at(outer[0]);
                out.outer[1][a].0[i] = at(outer[1]);
            }
        }
    }
}
