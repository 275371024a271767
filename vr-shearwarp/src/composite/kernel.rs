//! Operations on samples: compositing, or picking the largest, say.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{LANES, pick, splat};

use super::cells::{Columns, Edges, SPAN, STEPS_F32};
use crate::slices::Slices;

/// Operation on the samples under texels of one row, in one run of cells.
pub(crate) trait Kernel: Sync {
    /// True if texels can become opaque.
    const CLOSES: bool;

    /// Columns of voxels that texels which are added to at once may lie between.
    const COLUMNS: usize = SPAN;

    /// Adds a sample to each of the `n` texels from (x, y) on. `UNIT`: a texel a cell. A sample stands for its
    /// share of the distance between slices, or for all of it; it is none where its share is negative. Texels that are opaque are left as they
    /// are.
    fn add<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: Chunk,
        shares: Option<&[f32; LANES]>,
        row: &mut Row<'_>,
    ) -> Added;

    /// Completes a row after its last slice, before texels are finished.
    fn end<S: Simd>(&self, _: S, _: &mut Row<'_>) {}

    /// Finishes a texel that sees something at a place of its ray, and returns the depth of that.
    fn finish(&self, seen: &Seen<'_>, texel: &mut [f32; 4]) -> f64;
}

/// The place on a texel's ray at which it sees something, in one of its slices.
pub(crate) struct Seen<'a> {
    pub(crate) slices: &'a Slices,
    /// Index of the slice.
    pub(crate) slice: usize,
    /// Fraction of the interval that the slice's sample stands for.
    pub(crate) fraction: f64,
    pub(crate) texel: [usize; 2],
    /// Depths at which the texel's ray enters and leaves; infinite where the sample stands for a whole distance between slices.
    pub(crate) chord: [f64; 2],
}

impl Seen<'_> {
    /// Index-space position at a depth of the texel's ray, inside the box of a grid.
    pub(crate) fn index(&self, depth: f64, dims: [usize; 3]) -> [f64; 3] {
        let f = &self.slices.factorization;
        let w = depth * f.sign;
        let map = f.slice(w);
        let [u, v] = [0, 1].map(|a| map.offset[a] + map.scale * self.texel[a] as f64);
        let mut index = [0.0; 3];
        for (axis, at) in f.axes.into_iter().zip([u, v, w]) {
            index[axis] = at.clamp(0.0, (dims[axis] - 1) as f64);
        }
        index
    }

    /// Depth of the slice.
    pub(crate) fn depth_of_slice(&self) -> f64 {
        self.slices.slices[self.slice].depth
    }
}

/// Result of adding samples to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Added {
    /// Number of texels that took one.
    pub(crate) samples: u32,
    /// A bit for each that became opaque by it.
    pub(crate) closed: u32,
}

/// Up to sixteen neighbouring texels.
#[derive(Clone, Copy)]
pub(crate) struct Chunk {
    pub(crate) x: usize,
    pub(crate) y: usize,
    pub(crate) n: usize,
    /// Number of the slice, from 1 on.
    pub(crate) slice: f32,
}

impl Chunk {
    /// The texels that take a sample, given the shares of the distance between slices that samples stand for.
    #[inline(always)]
    pub(super) fn taking<S: Simd>(&self, simd: S, shares: Option<&[f32; LANES]>) -> mask32x16<S> {
        let taking = f32x16::load_array_ref(simd, &STEPS_F32).simd_lt(splat(simd, self.n as f32));
        match shares {
            Some(shares) => taking & f32x16::load_array_ref(simd, shares).simd_ge(splat(simd, 0.0)),
            None => taking,
        }
    }
}

/// A row of texels while it is worked on: all reds, all greens, all blues, all opacities, all places of what is seen, and the opacities
/// that [`super::half`] needs, each with room for a vector behind the last.
pub(crate) struct Row<'a>([&'a mut [f32]; PLANES]);

/// Components of a texel.
const PLANES: usize = 7;

/// The component that says where on its ray a texel sees something: the number of a slice, from 1 on, and a fraction of the interval that its
/// sample stands for; 0 for nowhere yet.
const PLACE: usize = 4;

/// Opacities before the sample in which a texel passes a half, and those of that sample.
const HALVES: [usize; 2] = [5, 6];

impl<'a> Row<'a> {
    /// Numbers that a row of that many texels takes.
    pub(crate) fn length(width: usize) -> usize {
        PLANES * (width + LANES)
    }

    #[inline(always)]
    pub(crate) fn new(planes: &'a mut [f32]) -> Self {
        let stride = planes.len() / PLANES;
        let (r, rest) = planes.split_at_mut(stride);
        let (g, rest) = rest.split_at_mut(stride);
        let (b, rest) = rest.split_at_mut(stride);
        let (a, rest) = rest.split_at_mut(stride);
        let (place, rest) = rest.split_at_mut(stride);
        let (before, alpha) = rest.split_at_mut(stride);
        Self([r, g, b, a, place, before, alpha])
    }

    /// Number of texels.
    pub(crate) fn width(&self) -> usize {
        self.0[0].len() - LANES
    }

    /// One component of that many texels, from x on: at most [`LANES`].
    #[inline(always)]
    pub(crate) fn several<const COUNT: usize>(&mut self, component: usize, x: usize) -> &mut [f32; COUNT] {
        (&mut self.0[component][x..x + COUNT]).try_into().expect("as many as asked for")
    }

    /// One component of sixteen texels, from x on.
    #[inline(always)]
    pub(crate) fn lanes(&mut self, component: usize, x: usize) -> &mut [f32; LANES] {
        self.several(component, x)
    }

    /// Notes a place for some of sixteen texels, from x on.
    #[inline(always)]
    pub(super) fn note<S: Simd>(&mut self, simd: S, x: usize, which: mask32x16<S>, place: f32) {
        let places = self.lanes(PLACE, x);
        *places = pick(which, splat(simd, place), f32x16::load_array_ref(simd, places)).to_array();
    }

    /// Notes the slice in which a texel's opacity passes a half, the opacity before and that of its sample.
    #[inline(always)]
    pub(super) fn pass_half(&mut self, x: usize, slice: f32, half: [f32; 2]) {
        self.0[PLACE][x] = slice;
        for (plane, opacity) in HALVES.into_iter().zip(half) {
            self.0[plane][x] = opacity;
        }
    }

    /// The places of sixteen texels, from x on, and what is noted of their halves.
    pub(super) fn halves(&mut self, x: usize) -> (&mut [f32; LANES], [&[f32; LANES]; 2]) {
        let [.., places, before, alpha] = &mut self.0;
        let places = (&mut places[x..x + LANES]).try_into().expect("as many as asked for");
        (places, [before, alpha].map(|plane| plane[x..x + LANES].try_into().expect("as many as asked for")))
    }

    /// The texels, one after another.
    pub(crate) fn write(&self, texels: &mut [[f32; 4]]) {
        let [r, g, b, a, ..] = self.0.each_ref().map(|plane| &plane[..texels.len()]);
        for (i, texel) in texels.iter_mut().enumerate() {
            *texel = [r[i], g[i], b[i], a[i]];
        }
    }

    /// The places of what texels see.
    pub(crate) fn places(&self) -> &[f32] {
        self.0[PLACE]
    }
}
