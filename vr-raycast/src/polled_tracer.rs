//! Rays traced a few at a time, with a look at the cancel flag between.

use vr_core::image_order::ImageSample;
use vr_core::{Counts, cancel};

use crate::tracer::{RaySample, Tracer};

/// Tracer that hands its rays to another one in parts, each of which takes little time, and asks for the cancel flag before each.
///
/// Rays of a part are traced as they are in the whole: parts are whole packets.
pub(crate) struct PolledTracer<'a> {
    inner: Box<dyn Tracer + 'a>,
    /// Rays of a part.
    rays: usize,
}

/// Steps that the rays of a part take together at most: a tenth of a second of the slowest ones.
const STEPS: f64 = (1 << 24) as f64;
/// Rays of a packet.
const PACKET: usize = 16;
/// Largest number of rays of a part: a tile of the picture.
const MAX_RAYS: usize = 1024;

impl<'a> PolledTracer<'a> {
    /// Puts a tracer whose rays take so many steps at most into parts.
    pub(crate) fn new(inner: Box<dyn Tracer + 'a>, steps: f64) -> Self {
        // `as` saturates: rays without a limit go packet by packet.
        let packets = (STEPS / steps) as usize / PACKET;
        Self { inner, rays: (packets * PACKET).clamp(PACKET, MAX_RAYS) }
    }
}

impl Tracer for PolledTracer<'_> {
    fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        for (part, spots) in spots.chunks(self.rays).enumerate() {
            cancel::poll();
            let starts = starts.map(|starts| &starts[part * self.rays..][..spots.len()]);
            self.inner.trace(spots, starts, values, counts);
        }
    }

    fn is_clear(&self, low: [u32; 2], high: [u32; 2]) -> bool {
        self.inner.is_clear(low, high)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use vr_core::Control;

    use super::*;

    /// Tracer that writes down what it is handed, and cancels at a ray.
    struct Recorder<'a> {
        parts: &'a Mutex<Vec<(usize, Vec<u32>)>>,
        control: &'a Control,
        cancels_at: usize,
    }

    impl Tracer for Recorder<'_> {
        fn trace(&self, spots: &[ImageSample], starts: Option<&[u32]>, values: &mut Vec<RaySample>, _: &mut Counts) {
            self.parts.lock().unwrap().push((spots.len(), starts.unwrap_or_default().to_vec()));
            values.extend(spots.iter().map(|_| RaySample::NOTHING));
            if values.len() >= self.cancels_at {
                self.control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
            }
        }
    }

    #[test]
    fn parts_are_whole_packets_and_none_begins_when_cancelled() {
        let spots: Vec<ImageSample> = (0..70).map(|pixel| ImageSample { pixel, x: 0.5, y: 0.5 }).collect();
        let starts: Vec<u32> = (0..70).collect();
        for (steps, cancels_at, expected) in [
            (1e3, usize::MAX, vec![70]),
            (5e5, usize::MAX, vec![32, 32, 6]),
            (f64::INFINITY, usize::MAX, vec![16, 16, 16, 16, 6]),
            (f64::INFINITY, 20, vec![16, 16]),
        ] {
            let (parts, control) = (Mutex::default(), Control::default());
            let tracer = PolledTracer::new(Box::new(Recorder { parts: &parts, control: &control, cancels_at }), steps);
            let (mut values, mut counts) = (Vec::new(), Counts::default());
            let outcome = control.cancellable(|| tracer.trace(&spots, Some(&starts), &mut values, &mut counts));
            assert_eq!(outcome.is_err(), cancels_at < 70);
            drop(tracer);
            let parts = parts.into_inner().unwrap();
            assert_eq!(parts.iter().map(|part| part.0).collect::<Vec<_>>(), expected);
            let all: Vec<u32> = parts.into_iter().flat_map(|part| part.1).collect();
            assert_eq!(all, starts[..all.len()]);
        }
    }
}
