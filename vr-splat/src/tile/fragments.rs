//! Kernels that are small beside a block of rays: their rays are gathered from any splats and blocks, sixteen at a time, so that no lane of a vector is for a
//! ray that misses its kernel.
//!
//! Sections are those of [`chords`](super::chords), to rounding at the faces of sheets; their order in a sum differs.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, u32x16};
use vr_kernels::vector::{LANES, Lanes, pick, splat};

use crate::chord_table::{Chord, ChordTable};
use crate::splat::Splat;

use super::block::EDGE;
use super::chords::Chords;
use super::{Covered, Tile};

/// Largest number of pixels in the rectangle of a splat that is taken apart into rays: beyond it blocks are filled well enough.
pub(super) const MAX_PIXELS: u32 = 9;

/// Channels of sheets that fragments add to: a sum of values, and what supports cover of the sheet from its back and from its front.
pub(super) const CHANNELS: usize = 3;

/// Rays through kernels, until there are sixteen.
pub(super) struct Fragments {
    count: usize,
    /// Block and lane of each ray.
    block: [u8; LANES],
    lane: [u8; LANES],
    /// First and last sheet of its splat.
    sheets: [[u32; 2]; LANES],
    /// Square of the distance of the ray from the kernel's middle.
    square: Lanes,
    /// Depth at which it is nearest to it.
    nearest: Lanes,
    /// 1 over the radius, the splat's weight and its value.
    scale: Lanes,
    weight: Lanes,
    value: Lanes,
    /// Kernel space per unit of depth and 1 over it, world length per unit of depth, and the ends, of the ray.
    speed: Lanes,
    inverse_speed: Lanes,
    stretch: Lanes,
    near: Lanes,
    far: Lanes,
}

impl Fragments {
    pub(super) const NONE: Self = Self {
        count: 0,
        block: [0; LANES],
        lane: [0; LANES],
        sheets: [[0; 2]; LANES],
        square: Lanes::ZERO,
        nearest: Lanes::ZERO,
        scale: Lanes([1.0; LANES]),
        weight: Lanes::ZERO,
        value: Lanes::ZERO,
        speed: Lanes([1.0; LANES]),
        inverse_speed: Lanes([1.0; LANES]),
        stretch: Lanes::ZERO,
        near: Lanes::ZERO,
        far: Lanes::ZERO,
    };
}

impl Tile<'_> {
    /// Takes the rays of a splat that go through its kernel, and adds them once there are sixteen.
    #[inline(always)]
    pub(super) fn take_apart<S: Simd>(
        &mut self,
        simd: S,
        table: &ChordTable,
        fragments: &mut Fragments,
        at: &Splat,
        covered: &Covered,
        sheets: [u32; 2],
    ) {
        let [across_square, across_both, up_square] = self.axes.square();
        let lever = self.axes.lever(at);
        let square_scale = at.scale * at.scale;
        for y in covered.y[0]..=covered.y[1] {
            for x in covered.x[0]..=covered.x[1] {
                let Some(number) = self.take(x, y) else { continue };
                let inside = |[first, last]: [u32; 2], block: u32| {
                    (first.max(block * EDGE) - block * EDGE)..=(last - block * EDGE).min(EDGE - 1)
                };
                for row in inside(covered.rows, y) {
                    for column in inside(covered.columns, x) {
                        let lane = (row * EDGE + column) as usize % LANES;
                        let block = &self.blocks[number];
                        // The same as in `Passing`.
                        let u = block.lateral[0].0[lane] * lever - at.place[0];
                        let v = block.lateral[1].0[lane] * lever - at.place[1];
                        let square = u * u * across_square + u * v * across_both + v * v * up_square;
                        let along = u * block.across[0].0[lane] + v * block.across[1].0[lane];
                        let ahead = along * block.inverse_square.0[lane];
                        let square = (square - along * ahead) * square_scale;
                        if square >= 1.0 {
                            continue;
                        }
                        let i = fragments.count % LANES;
                        (fragments.block[i], fragments.lane[i]) = (number as u8, lane as u8);
                        fragments.sheets[i] = sheets;
                        fragments.square.0[i] = square;
                        fragments.nearest.0[i] = at.place[2] - ahead;
                        fragments.scale.0[i] = at.scale;
                        fragments.weight.0[i] = at.weight;
                        fragments.value.0[i] = at.value;
                        fragments.speed.0[i] = block.speed.0[lane];
                        fragments.inverse_speed.0[i] = block.inverse_speed.0[lane];
                        fragments.stretch.0[i] = block.stretch.0[lane];
                        fragments.near.0[i] = block.near.0[lane];
                        fragments.far.0[i] = block.far.0[lane];
                        fragments.count += 1;
                        if fragments.count == LANES {
                            self.add_fragments(simd, table, fragments);
                        }
                    }
                }
            }
        }
    }

    /// Adds the fragments that there are to their sheets. A function of its own, compiled once.
    #[inline(never)]
    pub(super) fn add_fragments<S: Simd>(&mut self, simd: S, table: &ChordTable, fragments: &mut Fragments) {
        simd.vectorize(
            #[inline(always)]
            || self.add_here(simd, table, fragments),
        );
    }

    #[inline(always)]
    fn add_here<S: Simd>(&mut self, simd: S, table: &ChordTable, fragments: &mut Fragments) {
        if fragments.count == 0 {
            return;
        }
        let painter = self.painter;
        let (distance, ring) = (painter.distance, painter.ring as usize - 1);
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        // Chords and courses of the kernels along them, as for the rays of a block.
        let scale = fragments.scale.load(simd);
        let nearest = fragments.nearest.load(simd);
        let per_speed = fragments.inverse_speed.load(simd) * (one / scale);
        let factor = fragments.stretch.load(simd) * per_speed * fragments.weight.load(simd);
        let chord = Chord::new(simd, fragments.square.load(simd).max(zero).min(one).sqrt());
        let half = chord.half * per_speed;
        let (enter, leave) = (nearest - half, nearest + half);
        let chords = Chords {
            course: table.at(simd, &chord),
            nearest,
            per_half: chord.per_half * (fragments.speed.load(simd) * scale),
            gradients: None,
        };
        // Sheets that each goes through.
        let (fronts, backs) = ((enter * painter.per_distance).to_array(), (leave * painter.per_distance).to_array());
        let (mut first, mut left, mut bases, mut most) = ([0u32; LANES], [0u32; LANES], [0; LANES], 0);
        for i in 0..fragments.count.min(LANES) {
            let [from, to] = fragments.sheets[i];
            // `as` saturates.
            first[i] = (fronts[i] as u32).clamp(from, to);
            left[i] = (backs[i] as u32).clamp(from, to) + 1 - first[i];
            most = most.max(left[i]);
            bases[i] = self.place_of(0, usize::from(fragments.block[i]));
        }
        let (near, far) = (fragments.near.load(simd), fragments.far.load(simd));
        let value = fragments.value.load(simd);
        let numbers = u32x16::load_array_ref(simd, &first).to_float::<f32x16<S>>();
        let mut start = (numbers * distance).max(near).min(far);
        let mut before = chords.up_to(simd, start);
        for sheet in 0..most {
            let end = ((numbers + (sheet + 1) as f32) * distance).max(near).min(far);
            let after = chords.up_to(simd, end);
            let whole = chords.between(simd, &before, &after).whole * factor;
            let (front, back) = (enter.max(start), leave.min(end));
            let covered = front.simd_lt(back);
            let sums = (whole * value).to_array();
            let to_back = pick(covered, end - front, zero).to_array();
            let to_front = pick(covered, back - start, zero).to_array();
            for i in 0..LANES {
                if sheet < left[i] {
                    let slot = (first[i] + sheet) as usize & ring;
                    let (at, lane) = (bases[i] + slot * CHANNELS, usize::from(fragments.lane[i]) % LANES);
                    if let Some([sum, back, front]) = self.sheets.get_mut(at..at + CHANNELS) {
                        sum.0[lane] += sums[i];
                        // No call of `max`, which minds NaN.
                        back.0[lane] = if to_back[i] > back.0[lane] { to_back[i] } else { back.0[lane] };
                        front.0[lane] = if to_front[i] > front.0[lane] { to_front[i] } else { front.0[lane] };
                    }
                    self.touched[slot] |= 1 << fragments.block[i];
                }
            }
            (before, start) = (after, end);
        }
        fragments.count = 0;
    }
}
