//! A whole picture whose rays wait for each other, slice by slice or brick by brick: one sample of each pixel after the other.

use vr_core::Counts;

use super::march::PacketResult;
use super::state::State;
use super::tiles::{Packet, PacketScene, Pixel};
use crate::fragments::Fragments;

/// Sum of the samples of each pixel so far, and counts of the work.
pub(crate) struct Picture {
    pixels: Vec<Pixel>,
    counts: Counts,
}

impl Picture {
    /// A picture of this size without samples.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        Self { pixels: vec![Pixel::NOTHING; size[0] as usize * size[1] as usize], counts: Counts::default() }
    }

    /// Adds a sample of each of sixteen pixels.
    pub(crate) fn add(
        &mut self,
        scene: &PacketScene<'_>,
        at: &Packet,
        rays: &Fragments,
        state: &State,
        done: PacketResult,
    ) {
        self.counts.rays += u64::from(rays.hits.count_ones());
        self.counts.samples += done.drawn;
        self.counts.skipped += done.skipped;
        at.finish(scene, rays, state, |number, pixel| self.pixels[number] = self.pixels[number].plus(&pixel));
    }

    /// Returns the means of `samples` samples a pixel, and the counts.
    pub(crate) fn mean(mut self, samples: u32) -> (Vec<Pixel>, Counts) {
        if samples > 1 {
            self.pixels.iter_mut().for_each(|pixel| *pixel = pixel.times(1.0 / f64::from(samples)));
        }
        (self.pixels, self.counts)
    }
}
