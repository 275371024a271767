//! Light of sixteen steps along which the value changes, some of whose samples may be missing.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Lanes, SegmentTable, pick, splat};

/// Course of the value along the steps of packets, and the table that integrates it.
#[derive(Clone, Copy)]
pub(crate) struct Course<'a> {
    pub(crate) table: &'a SegmentTable,
    /// True if the value is a parabola through the middle of the step, too; else it is a straight line.
    pub(crate) is_parabola: bool,
    /// True if samples may be missing: NaN.
    pub(crate) has_holes: bool,
    /// Length of the packets' unit of steps in the world.
    pub(crate) unit: f32,
}

/// Light (r, g, b) and opacity of one step, or of two.
pub(crate) type TwoLights = [[Lanes; 4]; 2];

impl Course<'_> {
    /// Writes the light of a parabola through three values into `light[0]`; or those of two lines, from the first value to the second and on to the third,
    /// into both. Lengths are in world units. Between a sample and one that is missing, the field reaches half way, at the value of the one that exists,
    /// as in `crate::rule::Profile`.
    #[inline(always)]
    pub(crate) fn light<S: Simd>(
        &self,
        simd: S,
        values: &[Lanes; 3],
        lengths: &[Lanes; 2],
        live: u32,
        light: &mut TwoLights,
    ) {
        // Values of rays that wait count, too: a table has no place for NaN.
        if self.has_holes && values.iter().any(|lanes| lanes.0.iter().any(|value| value.is_nan())) {
            self.light_beside_holes(simd, values, lengths, live, light);
        } else if self.is_parabola {
            self.table.parabola(simd, values, &lengths[0], live, &mut light[0]);
        } else {
            self.table.lines(simd, values, [&lengths[0], &lengths[1]], live, light);
        }
    }

    #[inline(never)]
    fn light_beside_holes<S: Simd>(
        &self,
        simd: S,
        values: &[Lanes; 3],
        lengths: &[Lanes; 2],
        live: u32,
        light: &mut TwoLights,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let points = [values[0].load(simd), values[1].load(simd), values[2].load(simd)];
                let lengths = [lengths[0].load(simd), lengths[1].load(simd)];
                if !self.is_parabola {
                    self.broken_lines(simd, points, lengths, live, light);
                    return;
                }
                // Parabolas where all samples exist; elsewhere a line on either side of the middle.
                let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
                let whole = is_number(points[0]) & is_number(points[1]) & is_number(points[2]);
                let filled = [
                    Lanes::new(pick(whole, points[0], zero)),
                    Lanes::new(pick(whole, points[1], zero)),
                    Lanes::new(pick(whole, points[2], zero)),
                ];
                let mut bow = [Lanes::ZERO; 4];
                let bits = live & whole.to_bitmask() as u32;
                self.table.parabola(simd, &filled, &Lanes::new(lengths[0]), bits, &mut bow);
                let half = lengths[0] * 0.5;
                let mut halves = [[Lanes::ZERO; 4]; 2];
                self.broken_lines(simd, points, [half, half], live & !bits, &mut halves);
                let clear = one - halves[0][3].load(simd);
                for c in 0..4 {
                    let both = halves[0][c].load(simd) + clear * halves[1][c].load(simd);
                    light[0][c] = Lanes::new(pick(whole, bow[c].load(simd), both));
                }
            },
        );
    }

    /// Writes the light of two lines, each of which ends half way to a sample that is missing.
    #[inline(always)]
    fn broken_lines<S: Simd>(
        &self,
        simd: S,
        points: [f32x16<S>; 3],
        lengths: [f32x16<S>; 2],
        live: u32,
        light: &mut TwoLights,
    ) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        for k in 0..2 {
            let (front, back) = (points[k], points[k + 1]);
            let (has_front, has_back) = (is_number(front), is_number(back));
            let exists = has_front | has_back;
            let share = pick(has_front & has_back, one, splat(simd, 0.5));
            let from = pick(has_front, front, pick(has_back, back, zero));
            let to = Lanes::new(pick(has_back, back, from));
            let length = Lanes::new(lengths[k] * share);
            let mut found = [[Lanes::ZERO; 4]; 2];
            let bits = live & exists.to_bitmask() as u32;
            self.table.lines(simd, &[Lanes::new(from), to, to], [&length, &Lanes::ZERO], bits, &mut found);
            for c in 0..4 {
                light[k][c] = Lanes::new(pick(exists, found[0][c].load(simd), zero));
            }
        }
    }
}

/// Lanes that hold a number.
#[inline(always)]
fn is_number<S: Simd>(value: f32x16<S>) -> fearless_simd::mask32x16<S> {
    value.simd_eq(value)
}
