//! Packets along their rays.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use super::elementary::{depth_of_opacity, opacity_of_depth};
use super::field::{Cells, Field, Pairs, Stage, cells, inside};
use super::lanes::{LANES, Lanes, pick, splat};
use super::leap::{Distances, Leaper};
use super::setup::Packet;
use super::sums::Sums;
use super::table::Rows;

/// What all packets of a frame march through.
#[derive(Clone, Copy)]
pub(crate) struct Medium<'a, T> {
    pub(crate) field: Field<'a, T>,
    pub(crate) dims: [usize; 3],
    pub(crate) rows: Rows<'a>,
    /// `None`: nothing is leaped over.
    pub(crate) distances: Option<&'a Distances>,
    /// A ray ends when no more than this could be added to any component.
    pub(crate) negligible: f32,
}

/// What became of a packet's rays.
pub(crate) struct Marched {
    pub(crate) rgba: [Lanes; 4],
    /// Step of the first sample with α > 0, counted from the middle one.
    pub(crate) first: Lanes,
    /// Step in which opacity reaches a half, counted from the middle one, and the fraction of it before that.
    pub(crate) half: [Lanes; 2],
    pub(crate) samples: u32,
    /// Bit i: ray i ended before its last step.
    pub(crate) terminated: u32,
}

/// Steps between two looks for invisible blocks: a look costs a third of a sample.
const STRIDE: u32 = 4;

/// Takes the packet's rays to their ends. `most`: the largest light, or opacity, that can come from behind, by what is left clear.
#[inline(always)]
pub(crate) fn march<S: Simd, T: Pairs>(
    simd: S,
    medium: &Medium<'_, T>,
    packet: &Packet,
    most: &Lanes,
    stage: &mut Stage<T>,
) -> Marched {
    let ray = Path::new(simd, medium, packet);
    let never = splat(simd, f32::NEG_INFINITY);
    let negligible = splat(simd, medium.negligible);
    let most = most.load(simd);
    let mut at = packet.first.load(simd);
    let mut end = packet.end.load(simd);
    let leaper = medium.distances.map(
        #[inline(always)]
        |d| (d, Leaper::new(simd, d, packet, medium.dims)),
    );
    let mut sums = Sums::new(simd);
    let mut samples = 0;
    let mut until_look = 0;
    // The last steps of all rays are taken at once, at the end: shorter ones, whose light must be converted.
    let mut ending = false;
    loop {
        let mut live = if ending { end.simd_gt(never) } else { at.simd_lt(end) };
        if let Some((distances, leaper)) = &leaper {
            if until_look == 0 {
                until_look = STRIDE;
                loop {
                    let (position, cells) = ray.cells(simd, medium, at);
                    let distance = distances.at(simd, &cells);
                    let invisible = live & distance.simd_gt(0);
                    if invisible.all_false() {
                        break;
                    }
                    let visible = live & !invisible;
                    if ending {
                        live = visible;
                        break;
                    }
                    at = pick(invisible, at + leaper.steps(simd, position, &cells, distance), at);
                    live = at.simd_lt(end);
                    // Rays whose blocks have been seen to be visible outnumber those that have come to unknown ones.
                    let (known, all) = (visible.to_bitmask().count_ones(), live.to_bitmask().count_ones());
                    if known * 2 >= all {
                        break;
                    }
                }
            }
            until_look -= 1;
        }
        let bits = live.to_bitmask();
        if bits == 0 {
            if ending {
                break;
            }
            ending = true;
            at = packet.last.load(simd);
            until_look = 0;
            continue;
        }
        samples += bits.count_ones();
        let (_, cells) = ray.cells(simd, medium, at);
        let mut light = medium.rows.at(simd, medium.field.value(simd, &cells, stage));
        let mut step = at;
        if ending {
            let mut lanes = light.map(Lanes::of);
            shorten(simd, &mut lanes, &packet.ratio);
            light = lanes.map(
                #[inline(always)]
                |l| l.load(simd),
            );
            step = end;
        }
        sums.add(simd, live, step, light);
        if ending {
            break;
        }
        let done = (sums.clear(simd) * most).simd_le(negligible);
        end = pick(done, never, end);
        at += 1.0;
    }
    let hits = mask32x16::from_bitmask(simd, u64::from(packet.hits));
    let terminated = (hits & end.simd_le(never)).to_bitmask() as u32;
    Marched {
        rgba: sums.rgba().map(Lanes::of),
        first: Lanes::of(sums.first()),
        half: sums.half(simd),
        samples,
        terminated,
    }
}

/// Light and opacity of the part `ratio` of a homogeneous step, from those of the whole.
///
/// With τ the optical depth of the whole: α′ = 1 − e^(−ratio·τ), and light, c·α or q·h·α/τ, goes with α. Not part of the loop that calls
/// it once a packet.
#[inline(never)]
fn shorten<S: Simd>(simd: S, light: &mut [Lanes; 4], ratio: &Lanes) {
    simd.vectorize(
        #[inline(always)]
        || {
            let ratio = ratio.load(simd);
            let alpha = light[3].load(simd);
            let part = opacity_of_depth(simd, depth_of_opacity(simd, alpha) * ratio);
            let nothing = alpha.simd_le(splat(simd, 0.0));
            let share = pick(nothing, ratio, part / pick(nothing, splat(simd, 1.0), alpha));
            let is_whole = ratio.simd_ge(splat(simd, 1.0));
            let share = pick(is_whole, splat(simd, 1.0), share);
            for c in 0..3 {
                light[c] = Lanes::of(light[c].load(simd) * share);
            }
            light[3] = Lanes::of(pick(is_whole, alpha, part));
        },
    );
}

/// Positions along the rays of a packet.
struct Path<S: Simd> {
    base: [f32x16<S>; 3],
    delta: [f32x16<S>; 3],
    most: [f32; 3],
}

impl<S: Simd> Path<S> {
    #[inline(always)]
    fn new<T>(simd: S, medium: &Medium<'_, T>, packet: &Packet) -> Self {
        Self {
            base: [packet.base[0].load(simd), packet.base[1].load(simd), packet.base[2].load(simd)],
            delta: [packet.delta[0].load(simd), packet.delta[1].load(simd), packet.delta[2].load(simd)],
            most: medium.dims.map(|n| (n - 1) as f32),
        }
    }

    /// Positions, and their cells, so many steps from the middle ones.
    #[inline(always)]
    fn cells<T>(&self, simd: S, medium: &Medium<'_, T>, at: f32x16<S>) -> ([f32x16<S>; 3], Cells<S>) {
        let position = [
            inside(simd, self.base[0] + at * self.delta[0], self.most[0]),
            inside(simd, self.base[1] + at * self.delta[1], self.most[1]),
            inside(simd, self.base[2] + at * self.delta[2], self.most[2]),
        ];
        (position, cells(simd, position, medium.field.last_cell))
    }
}

/// Index of a lane's step from its number, counted from the middle one.
pub(crate) fn step_number(middle: f64, from_middle: f32) -> u32 {
    (middle + f64::from(from_middle)) as u32
}

const _: () = assert!(LANES == 16);
