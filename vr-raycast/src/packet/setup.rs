//! Set-up of sixteen rays at once, from the image into the volume: in f64, in loops that the compiler makes vector code of.

use fearless_simd::Simd;
use glam::DVec3;
use vr_core::image_order::ImageSample;
use vr_core::{Clip, Layer, Placement, Rays};
use vr_kernels::vector::{Chords, LANES, Lanes};

use super::listed::StepList;

/// Data that the rays of a frame share.
#[derive(Clone, Debug)]
pub(crate) struct FrameSetup<'a> {
    pub(crate) rays: &'a Rays,
    pub(crate) placement: &'a Placement,
    pub(crate) dims: [usize; 3],
    pub(crate) clip: &'a Clip,
    pub(crate) layer: Option<&'a Layer>,
    /// Length of a step in world units.
    pub(crate) step: f64,
    /// Place of a step's sample, as a fraction of the step.
    pub(crate) offset: f64,
    /// Unit vector along which depth is measured.
    pub(crate) forward: DVec3,
}

/// Sixteen rays in index space, cut into steps: the same parts and the same steps as `vr_core::IndexRay` and `Lattice` make of each.
///
/// Steps are counted from the one in the middle of each ray, so that positions, a base and so many times a difference in f32, are as
/// exact as they can be: what the difference was rounded by is multiplied by half as many steps.
#[derive(Clone, Debug)]
pub(crate) struct Packet {
    /// Mask of the rays that meet the volume.
    pub(crate) hits: u32,
    /// Position of the sample of the middle step, axis by axis.
    pub(crate) base: [Lanes; 3],
    /// Vector from one sample to the next.
    pub(crate) delta: [Lanes; 3],
    /// Position of the first sample, in steps from the middle.
    pub(crate) first: Lanes,
    /// Number of the last step, which may be a shorter one; −∞ for a ray that does not meet the volume.
    pub(crate) end: Lanes,
    /// Position of the sample of the last step, in steps from the middle.
    pub(crate) last: Lanes,
    /// Length of the last step, as a fraction of a whole one.
    pub(crate) ratio: Lanes,
    /// End of the ray, in steps from the middle one's begin; −∞ for one that does not meet the volume.
    pub(crate) stop: Lanes,
    /// Number of the middle step.
    pub(crate) middle: [f64; LANES],
    /// World distance from the ray's own origin to the begin of step 0.
    pub(crate) begin: [f64; LANES],
    /// Length of the part in world units.
    pub(crate) length: [f64; LANES],
    /// Unit vectors along the rays, in the world.
    pub(crate) directions: [[f64; LANES]; 3],
    /// Steps of each ray, from the begin of step 0 on, where they are listed.
    pub(crate) listed: [StepList; LANES],
}

/// Fraction of a ray's length below which a last step is rounding, as in `Lattice`.
const SLIVER: f64 = 1e-12;

impl FrameSetup<'_> {
    /// Sets up to sixteen rays up; missing ones meet nothing. Their first steps are the last that begin before the depth along the view at
    /// which they may meet something first; +∞: they meet nothing. Its own function: the same for all kernels of a level.
    #[inline(never)]
    pub(crate) fn packet<S: Simd>(&self, simd: S, spots: &[ImageSample], nearest: &[f64; LANES], packet: &mut Packet) {
        simd.vectorize(
            #[inline(always)]
            || self.fill(spots, nearest, packet),
        );
    }

    #[inline(always)]
    fn fill(&self, spots: &[ImageSample], nearest: &[f64; LANES], packet: &mut Packet) {
        let (mut x, mut y, mut far) = ([0.0; LANES], [0.0; LANES], [f64::INFINITY; LANES]);
        for i in 0..LANES {
            let spot = &spots[i.min(spots.len() - 1)];
            (x[i], y[i]) = (spot.x, spot.y);
            if let Some(layer) = self.layer {
                far[i] = layer.depth(spot.pixel);
            }
        }
        let Chords { origin, direction, start, end, offset, along } =
            Chords::new(self.rays, [&x, &y], self.placement, self.dims, self.clip, &far);
        packet.directions = along;
        packet.hits = 0;
        let (per_step, steps_per_length) = (self.step, 1.0 / self.step);
        let forward = self.forward.to_array();
        for i in 0..LANES {
            let hit = start[i] < end[i] && nearest[i] < f64::INFINITY && i < spots.len();
            packet.hits |= u32::from(hit) << i;
            let chord = if hit { end[i] - start[i] } else { 1.0 };
            let begin = if hit { start[i] } else { 0.0 };
            let sliver = SLIVER * chord;
            let count = ((chord - sliver) * steps_per_length).ceil();
            let count = if count > 1.0 { count } else { 1.0 };
            let rest = chord - (count - 1.0) * per_step;
            let last = if rest + sliver >= per_step { per_step } else { rest };
            let middle = (0.5 * count).floor();
            packet.middle[i] = middle;
            packet.begin[i] = offset[i] + begin;
            packet.length[i] = chord;
            let cosine = forward[0] * along[0][i] + forward[1] * along[1][i] + forward[2] * along[2][i];
            let late = if hit { nearest[i] / cosine - (offset[i] + begin) } else { 0.0 };
            // One step less, for rounding.
            let skipped = (late * steps_per_length).floor() - 1.0;
            let skipped = if skipped > 0.0 { skipped } else { 0.0 };
            let skipped = if skipped < count - 1.0 { skipped } else { count - 1.0 };
            packet.first.0[i] = (skipped - middle) as f32;
            packet.end.0[i] = if hit { (count - 1.0 - middle) as f32 } else { f32::NEG_INFINITY };
            let ratio = last * steps_per_length;
            packet.last.0[i] = (count - 1.0 - middle + self.offset * (ratio - 1.0)) as f32;
            packet.ratio.0[i] = ratio as f32;
            packet.stop.0[i] = if hit { (chord * steps_per_length - middle) as f32 } else { f32::NEG_INFINITY };
            let s = begin + (middle + self.offset) * per_step;
            for a in 0..3 {
                packet.base[a].0[i] = if hit { (origin[a][i] + direction[a][i] * s) as f32 } else { 0.0 };
                packet.delta[a].0[i] = if hit { (direction[a][i] * per_step) as f32 } else { 0.0 };
            }
        }
    }
}

impl Packet {
    pub(crate) const EMPTY: Self = Self {
        hits: 0,
        base: [Lanes::ZERO; 3],
        delta: [Lanes::ZERO; 3],
        first: Lanes::ZERO,
        end: Lanes::ZERO,
        last: Lanes::ZERO,
        ratio: Lanes::ZERO,
        stop: Lanes::ZERO,
        middle: [0.0; LANES],
        begin: [0.0; LANES],
        length: [0.0; LANES],
        directions: [[0.0; LANES]; 3],
        listed: [const { StepList::EMPTY }; LANES],
    };

    /// Moves the begin of the rays to these steps, or to their last ones.
    pub(crate) fn begin_at(&mut self, starts: &[u32]) {
        for (i, &start) in starts.iter().enumerate() {
            let last = f64::from(self.end.0[i]).max(0.0 - self.middle[i]);
            let first = (f64::from(start) - self.middle[i]).min(last) as f32;
            self.first.0[i] = first.max(self.first.0[i]);
        }
    }
}
