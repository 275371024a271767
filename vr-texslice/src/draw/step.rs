//! Sixteen rays through one slab: the fragments that a slice across the picture has on them.

use fearless_simd::Simd;
use vr_kernels::vector::Lanes;

use super::chunk::SampleSet;
use super::classify::Classifier;
use super::march::March;

/// The samples that some of sixteen rays take in one slab, bit by bit: of those that enter the volume there, of those that go on, of those that leave it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) first: u32,
    pub(crate) whole: u32,
    pub(crate) last: u32,
    /// Numbers of the whole ones; of other rays at least two behind their last sample, where no segment begins: they neither take this one nor end.
    pub(crate) number: Lanes,
}

impl Step {
    pub(crate) const NOTHING: Self = Self { first: 0, whole: 0, last: 0, number: Lanes::ZERO };

    pub(crate) fn is_nothing(&self) -> bool {
        self.first | self.whole | self.last == 0
    }
}

impl<S: Simd> March<'_, S> {
    /// The first samples of some rays.
    pub(crate) fn enter(&mut self, simd: S, rays: u32) {
        self.only(rays, |march| {
            // The first samples of the other rays come later.
            let (has, before) = (march.rays.has[0], march.before);
            march.rays.has[0] = chosen(rays, &has, &Lanes::ZERO);
            march.outer(simd, 0);
            march.rays.has[0] = has;
            march.before = chosen(rays, &march.before, &before);
        });
    }

    /// One whole sample of the rays that have one at these numbers, which has been fetched into the chunk.
    pub(crate) fn go_on(&mut self, simd: S, number: &Lanes) {
        self.chunk.len = 1;
        let ratio = self.rays.ratio;
        self.draw(simd, SampleSet::From(number), &ratio);
    }

    /// Leaves out one whole sample of the rays that have one at these numbers: so many in all.
    pub(crate) fn pass_by(&mut self, simd: S, number: &Lanes, samples: u64) {
        self.done.skipped += samples;
        if matches!(self.pass.classifier, Classifier::Segments(_)) {
            self.look_at_last(simd, number, 1);
        }
    }

    /// The last samples of some rays.
    pub(crate) fn leave(&mut self, simd: S, rays: u32) {
        self.only(rays, |march| {
            march.rays.has[1] = chosen(rays, &march.rays.has[1], &Lanes::ZERO);
            march.outer(simd, 1);
        });
    }

    /// Runs a stage for some rays; the others neither end nor lose their last sample.
    fn only(&mut self, lanes: u32, draw: impl FnOnce(&mut Self)) {
        if lanes == 0 {
            return;
        }
        let (end, last) = (self.rays.end, self.rays.has[1]);
        draw(self);
        self.rays.end = chosen(lanes, &self.rays.end, &end);
        self.rays.has[1] = chosen(lanes, &self.rays.has[1], &last);
    }
}

/// Chooses lane by lane.
fn chosen(lanes: u32, these: &Lanes, others: &Lanes) -> Lanes {
    Lanes(std::array::from_fn(|i| if lanes >> i & 1 == 1 { these.0[i] } else { others.0[i] }))
}
