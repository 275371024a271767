//! Sixteen rays through one slab: the fragments that a slice across the picture has on them.

use fearless_simd::Simd;
use vr_kernels::vector::{LANES, Lanes};

use super::chunk::SampleSet;
use super::classify::Classifier;
use super::march::March;

/// The samples that some of sixteen rays take in one slab, bit by bit: of those that enter the volume there, of those that go on, of those that leave it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub(crate) first: u32,
    pub(crate) whole: u32,
    pub(crate) last: u32,
    /// Numbers of the whole ones.
    pub(crate) number: Lanes,
}

impl<S: Simd> March<'_, S> {
    /// One slab, by the stages of all of them. What a ray takes, and in which order, is the same as slab after slab along it.
    pub(crate) fn step(&mut self, simd: S, step: &Step) {
        self.only(step.first, |march| {
            // The first samples of the other rays come later.
            let (has, before) = (march.rays.has[0], march.before);
            march.rays.has[0] = chosen(step.first, &has, &Lanes::ZERO);
            march.outer(simd, 0);
            march.rays.has[0] = has;
            march.before = chosen(step.first, &march.before, &before);
        });
        self.only(step.whole, |march| march.one(simd, step));
        self.only(step.last, |march| {
            march.rays.has[1] = chosen(step.last, &march.rays.has[1], &Lanes::ZERO);
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

    /// One whole sample of some rays.
    fn one(&mut self, simd: S, step: &Step) {
        // There is no sample two behind the last one, and no segment begins there.
        let beyond = Lanes(self.rays.end.0.map(|end| if end == f32::NEG_INFINITY { 0.0 } else { end + 1.0 }));
        let number = chosen(step.whole, &step.number, &beyond);
        if (0..LANES).all(|i| number.0[i] >= self.rays.end.0[i]) {
            return;
        }
        if let Some(samples) = self.invisible(simd, &number, 1) {
            self.done.skipped += samples;
            if matches!(self.pass.classifier, Classifier::Segments(_)) {
                self.look_at_last(simd, &number, 1);
            }
            return;
        }
        self.chunk.len = 1;
        let which = SampleSet::From(&number);
        self.texture.fetch(simd, self.rays, which, self.chunk);
        let ratio = self.rays.ratio;
        self.draw(simd, which, &ratio);
    }
}

/// Chooses lane by lane.
fn chosen(lanes: u32, these: &Lanes, others: &Lanes) -> Lanes {
    Lanes(std::array::from_fn(|i| if lanes >> i & 1 == 1 { these.0[i] } else { others.0[i] }))
}
