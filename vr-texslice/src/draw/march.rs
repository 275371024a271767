//! Sixteen rays through all of their slices.

use fearless_simd::Simd;
use vr_kernels::vector::{LANES, Lanes, Operator, Shade};

use super::blend::{Blending, blend};
use super::chunk::{CHUNK, Chunk, Fetch, SampleSet, reach};
use super::classify::{Classifier, classify, integrate};
use super::state::State;
use super::steepness::Steepness;
use crate::fragments::Fragments;
use crate::occupancy::Occupancy;
use crate::tint::Tint;

/// Inputs that all fragments of a picture share.
#[derive(Clone, Copy)]
pub(crate) struct Pass<'a> {
    pub(crate) classifier: Classifier<'a>,
    /// `None`: opacity follows no gradient, or did so when texels were classified.
    pub(crate) steepness: Option<Steepness<'a>>,
    /// Colours of voxels, by which the light of fragments is multiplied before it reflects, or that are averaged; `None` where there are none, or texels have them.
    pub(crate) tint: Option<&'a Tint<'a>>,
    pub(crate) operator: Operator,
    /// Texels along each axis.
    pub(crate) dims: [usize; 3],
    /// True if samples are on the faces of slabs.
    pub(crate) on_faces: bool,
    /// World length of a table's slab.
    pub(crate) length: f32,
    pub(crate) negligible: f32,
    /// `None`: every fragment is drawn.
    pub(crate) occupancy: Option<&'a Occupancy<'a>>,
    /// Largest distance of a sample of a stack's slice from its place, in layers; 0 where there are no stacks.
    pub(crate) snap: f32,
}

impl Pass<'_> {
    /// Number of the next samples of rays, if nothing can be visible in the blocks that they touch.
    pub(super) fn invisible<S: Simd>(
        &self,
        simd: S,
        rays: &Fragments,
        state: &State,
        number: &Lanes,
        len: usize,
    ) -> Option<u64> {
        let occupancy = self.occupancy?;
        let touched = if self.on_faces {
            // A segment begins at the sample before.
            let before = Lanes(number.0.map(|n| n - 1.0));
            reach(simd, rays, &before, len + 1, (self.dims, self.snap))
        } else {
            reach(simd, rays, number, len, (self.dims, self.snap))
        };
        // An extreme is looked for above those that all live rays have.
        let floor = match self.operator {
            Operator::Extreme { .. } => {
                let live = (0..LANES).filter(|&i| number.0[i] < rays.end.0[i]);
                live.map(|i| state.value.0[i]).fold(f32::INFINITY, f32::min)
            }
            _ => 0.0,
        };
        if !occupancy.is_empty(touched.cells, floor) {
            return None;
        }
        let left = |i: usize| (rays.end.0[i] - number.0[i]).clamp(0.0, len as f32) as u64;
        Some(if self.on_faces { (0..LANES).map(left).sum() } else { touched.samples })
    }
}

/// Largest number of samples of a ray that are looked at together.
const FARTHEST: usize = 64;

/// Counts of a march.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PacketResult {
    pub(crate) drawn: u64,
    pub(crate) skipped: u64,
}

/// A march of sixteen rays.
pub(crate) struct March<'a, S> {
    pub(crate) texture: &'a mut dyn Fetch<S>,
    pub(crate) pass: &'a Pass<'a>,
    /// `None`: nothing is shaded.
    pub(crate) lit: Option<Shade<'a>>,
    /// Largest light, or opacity, that can come from behind, by what is left clear.
    pub(crate) max_behind: &'a Lanes,
    pub(crate) chunk: &'a mut Chunk,
    pub(crate) rays: &'a mut Fragments,
    pub(crate) state: &'a mut State,
    /// Values at the last faces: where segments begin.
    pub(crate) before: Lanes,
    pub(crate) done: PacketResult,
}

impl<S: Simd> March<'_, S> {
    /// Through all slices.
    pub(crate) fn run(&mut self, simd: S) {
        if self.pass.operator == Operator::Over {
            self.rays.turn();
        }
        self.outer(simd, 0);
        self.whole(simd, self.rays.begin);
        self.outer(simd, 1);
    }

    /// The whole samples of some rays, from these numbers to those before others. Rays that have none there have the end −∞, and rays that are done take none.
    pub(super) fn stretch(&mut self, simd: S, from: Lanes, to: &Lanes) {
        let end = self.rays.end;
        let part = Lanes(std::array::from_fn(|i| to.0[i].min(end.0[i])));
        self.rays.end = part;
        self.whole(simd, from);
        for i in 0..LANES {
            let done = part.0[i] > f32::NEG_INFINITY && self.rays.end.0[i] == f32::NEG_INFINITY;
            if !done {
                self.rays.end.0[i] = end.0[i];
            }
        }
    }

    /// The first samples of all rays (0), or the last (1).
    pub(super) fn outer(&mut self, simd: S, end: usize) {
        if self.rays.has[end].0 == [0.0; LANES] {
            return;
        }
        self.chunk.len = 1;
        let which = SampleSet::Outer(end);
        self.texture.fetch(simd, self.rays, which, self.chunk);
        if self.pass.on_faces && matches!(self.pass.classifier, Classifier::Segments(_)) && end == 0 {
            // Nothing but where the first segment begins.
            self.before = self.chunk.value[0];
            return;
        }
        let ratio = self.rays.outer_ratio[end];
        self.draw(simd, which, &ratio);
    }

    /// The samples of whole slabs, from numbers on.
    fn whole(&mut self, simd: S, from: Lanes) {
        let mut number = from;
        // So many samples are looked at together for whether anything can be visible in their blocks: more after each look that found nothing.
        let mut stride = CHUNK;
        loop {
            let max = (0..LANES).map(|i| self.rays.end.0[i] - number.0[i]).fold(f32::NEG_INFINITY, f32::max);
            if max <= 0.0 {
                break;
            }
            let len = (max as usize).min(stride);
            if let Some(samples) = self.pass.invisible(simd, self.rays, self.state, &number, len) {
                self.done.skipped += samples;
                stride = (2 * stride).min(FARTHEST);
                if matches!(self.pass.classifier, Classifier::Segments(_)) {
                    self.look_at_last(simd, &number, len);
                }
            } else if stride > CHUNK {
                stride = CHUNK;
                continue;
            } else {
                self.chunk.len = len;
                let which = SampleSet::From(&number);
                self.texture.fetch(simd, self.rays, which, self.chunk);
                let ratio = self.rays.ratio;
                self.draw(simd, which, &ratio);
            }
            for n in &mut number.0 {
                *n += len as f32;
            }
        }
    }

    /// Values at the last of samples that are left out: what the next segments begin with.
    pub(super) fn look_at_last(&mut self, simd: S, number: &Lanes, len: usize) {
        // Of a ray that ends before, nothing is asked any more.
        let last = Lanes(number.0.map(|n| n + (len - 1) as f32));
        self.chunk.len = 1;
        self.texture.fetch(simd, self.rays, SampleSet::From(&last), self.chunk);
        for i in 0..LANES {
            if last.0[i] < self.rays.end.0[i] {
                self.before.0[i] = self.chunk.value[0].0[i];
            }
        }
        // Its last segment begins at its own last face.
        let ends = Lanes(std::array::from_fn(|i| (self.rays.end.0[i] - 1.0).max(number.0[i])));
        let short = |i: usize| number.0[i] < self.rays.end.0[i] && self.rays.end.0[i] <= last.0[i];
        if (0..LANES).any(short) {
            self.texture.fetch(simd, self.rays, SampleSet::From(&ends), self.chunk);
            for i in (0..LANES).filter(|&i| short(i)) {
                self.before.0[i] = self.chunk.value[0].0[i];
            }
        }
    }

    /// Classifies, shades and blends what was fetched.
    pub(super) fn draw(&mut self, simd: S, which: SampleSet<'_>, ratio: &Lanes) {
        let pass = self.pass;
        match pass.classifier {
            Classifier::Segments(table) => {
                let lengths = self.segment_lengths(which, ratio);
                let backwards = pass.operator == Operator::Over;
                integrate(simd, table, &self.before, &lengths, backwards, self.chunk);
                self.find_gradients(simd, which, true);
                if let Some(steepness) = &pass.steepness {
                    steepness.integrate(simd, &self.before, &lengths, backwards, self.chunk);
                }
                if let Some(tint) = pass.tint {
                    tint.multiply(simd, self.rays, which, true, self.chunk);
                }
                if let SampleSet::From(number) = which {
                    let (number, last) = (*number, self.chunk.len - 1);
                    self.keep(&number, last);
                }
            }
            _ => {
                classify(simd, &pass.classifier, ratio, matches!(which, SampleSet::Outer(_)), self.chunk);
                self.find_gradients(simd, which, false);
                if let Some(steepness) = &pass.steepness {
                    steepness.classify(simd, ratio, self.chunk);
                }
                match pass.tint {
                    Some(tint) if !pass.operator.picks() => tint.multiply(simd, self.rays, which, false, self.chunk),
                    Some(tint) if pass.operator == Operator::Average => tint.put(simd, self.rays, which, self.chunk),
                    _ => {}
                }
            }
        }
        if let Some(lit) = &self.lit {
            shade(simd, lit, self.chunk);
        }
        let how = Blending {
            operator: pass.operator,
            on_faces: pass.on_faces,
            negligible: pass.negligible,
            tinted: pass.tint.is_some(),
            max_behind: self.max_behind,
        };
        let drawn = blend(simd, &how, which, self.rays, self.chunk, self.state);
        self.done.drawn += u64::from(drawn);
    }

    /// World lengths of the segments that end at samples; `ratio`: of whole ones in table lengths.
    fn segment_lengths(&self, which: SampleSet<'_>, ratio: &Lanes) -> [Lanes; CHUNK] {
        let (rays, world) = (&*self.rays, self.pass.length);
        let length = |j: usize, i: usize| match which {
            SampleSet::From(number) if number.0[i] + j as f32 <= rays.begin.0[i] => rays.outer_ratio[0].0[i] * world,
            _ => ratio.0[i] * world,
        };
        std::array::from_fn(|j| Lanes(std::array::from_fn(|i| length(j, i))))
    }

    /// Finds the gradients of a chunk's samples, or in the middle of its segments, if opacity or shading looks at them.
    fn find_gradients(&mut self, simd: S, which: SampleSet<'_>, segments: bool) {
        if self.lit.is_some() || self.pass.steepness.is_some() {
            self.texture.gradients(simd, self.rays, which, segments, self.chunk);
        }
    }

    /// Remembers the values at the last faces that rays have in a chunk of which sample 0 has the numbers given.
    fn keep(&mut self, number: &Lanes, last: usize) {
        for i in 0..LANES {
            let left = self.rays.end.0[i] - number.0[i];
            if left > 0.0 {
                self.before.0[i] = self.chunk.value[last.min(left as usize - 1)].0[i];
            }
        }
    }
}

/// Shades a chunk's samples by their gradients.
#[inline(never)]
fn shade<S: Simd>(simd: S, lit: &Shade<'_>, chunk: &mut Chunk) {
    for j in 0..chunk.len {
        if chunk.light[j][3].0.iter().any(|&alpha| alpha > 0.0) {
            lit.apply_to_gradients(simd, &chunk.gradient[j], &mut chunk.light[j]);
        }
    }
}
