//! Light of steps along which the value changes, from a pre-integrated table, for sixteen rays at once.

use std::sync::Arc;

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};

use super::{LANES, Lanes, opacity_of_depth, pick, rows_at, source_weight, splat};
use crate::tables::PreIntegrated;

/// A [`PreIntegrated`] table in the form that lanes read: the same light as [`PreIntegrated::segment`] and [`PreIntegrated::segment3`], but for
/// rounding. Values must be numbers.
///
/// A row fills one cache line. The few lanes that meet an opaque wall are looked up in the table itself, one by one.
#[derive(Clone, Debug)]
pub struct SegmentTable {
    rows: Vec<Row>,
    table: Arc<PreIntegrated<f32>>,
    origin: f32,
    per_unit: f32,
    last: f32,
    quantum: [f32; 4],
    /// The largest colour, channel by channel; absent where emission is given on its own.
    brightest: Option<[f32; 3]>,
    /// Ranges of values that are opaque, in entries.
    walls: Vec<[f32; 2]>,
}

/// κ and q in one interval of values. Integrals are integers, kept as the bits of floats: rows are turned into vectors of floats.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
struct Row {
    /// Integral up to the begin of the interval.
    sum: [f32; 4],
    /// Integral up to its end.
    end: [f32; 4],
    /// Value at its begin.
    start: [f32; 4],
    /// Change over it.
    rise: [f32; 4],
}

/// Places of sixteen values in a table.
#[derive(Clone, Copy)]
struct Places<S: Simd> {
    row: f32x16<S>,
    fraction: f32x16<S>,
}

impl SegmentTable {
    /// The table for lanes.
    pub fn new(table: &Arc<PreIntegrated<f32>>) -> Self {
        let rows = table.rows();
        let bits = |sum: [u32; 4]| sum.map(f32::from_bits);
        let row = |i: usize| {
            let (row, next) = (rows[i], rows[(i + 1).min(rows.len() - 1)]);
            Row { sum: bits(row.sum), end: bits(next.sum), start: row.start, rise: row.rise }
        };
        let (origin, per_unit) = table.scale();
        Self {
            rows: (0..rows.len()).map(row).collect(),
            table: Arc::clone(table),
            origin,
            per_unit,
            last: (rows.len() - 1) as f32,
            quantum: table.quantum(),
            brightest: table.brightest(),
            walls: table.opaque_ranges().collect(),
        }
    }

    /// The table that it was made of.
    pub fn pre_integrated(&self) -> &Arc<PreIntegrated<f32>> {
        &self.table
    }

    /// Light (r, g, b) and opacity of two stretches, one behind the other, of two lengths in world units, on which the value goes linearly from the
    /// first number to the second, and from that to the third; of the rays in `live`.
    ///
    /// Its own function: the same for all kernels of a level.
    #[inline(never)]
    pub fn lines<S: Simd>(
        &self,
        simd: S,
        values: &[Lanes; 3],
        length: [&Lanes; 2],
        live: u32,
        light: &mut [[Lanes; 4]; 2],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let values = [values[0].load(simd), values[1].load(simd), values[2].load(simd)];
                let [first, second] = self.two(simd, values, [length[0].load(simd), length[1].load(simd)]);
                *light = [in_lanes(first), in_lanes(second)];
                // Walls are integrated one by one. Each stretch is judged by itself: no bit of its light depends on the one that it shares the call with.
                for k in 0..2 {
                    let met = self.met(simd, [values[k], values[k + 1], values[k + 1]], splat(simd, 0.0)) & live;
                    if met != 0 {
                        let (front, back) = (Lanes::new(values[k]), Lanes::new(values[k + 1]));
                        for i in (0..LANES).filter(|i| met >> i & 1 == 1) {
                            set(&mut light[k], i, self.table.segment(front.0[i], back.0[i], length[k].0[i]));
                        }
                    }
                }
            },
        );
    }

    /// Light and opacity of stretches `length` world units long on which the value is the parabola through three numbers at equal distances; of the rays
    /// in `live`.
    ///
    /// Its own function, as [`lines`](Self::lines) is.
    #[inline(never)]
    pub fn parabola<S: Simd>(&self, simd: S, values: &[Lanes; 3], length: &Lanes, live: u32, light: &mut [Lanes; 4]) {
        simd.vectorize(
            #[inline(always)]
            || {
                let [front, middle, back] = [values[0].load(simd), values[1].load(simd), values[2].load(simd)];
                let raise = (middle - (front + back) * 0.5) * (1.0 / 6.0);
                let raised = [front + raise, middle + raise, back + raise];
                let half = length.load(simd) * 0.5;
                let [first, second] = self.two(simd, raised, [half, half]);
                let clear = splat(simd, 1.0) - first[3];
                *light = in_lanes([
                    first[0] + clear * second[0],
                    first[1] + clear * second[1],
                    first[2] + clear * second[2],
                    first[3] + clear * second[3],
                ]);
                let met = self.met(simd, [front, middle, back], raise.abs()) & live;
                for i in (0..LANES).filter(|i| met >> i & 1 == 1) {
                    let [front, middle, back] = [values[0].0[i], values[1].0[i], values[2].0[i]];
                    set(light, i, self.table.segment3(front, middle, back, length.0[i]));
                }
            },
        );
    }

    /// Mask of the lanes in which values between three numbers, or so much beyond them, may be opaque.
    #[inline(always)]
    fn met<S: Simd>(&self, simd: S, [a, b, c]: [f32x16<S>; 3], beyond: f32x16<S>) -> u32 {
        if self.walls.is_empty() {
            return 0;
        }
        let (low, high) = (a.min(b).min(c) - beyond, a.max(b).max(c) + beyond);
        let ends = [(low - self.origin) * self.per_unit, (high - self.origin) * self.per_unit];
        let (low, high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let mut met = 0;
        for &[from, to] in &self.walls {
            met |= (high.simd_ge(splat(simd, from)) & low.simd_le(splat(simd, to))).to_bitmask() as u32;
        }
        met
    }

    /// Light of two stretches that share their middle value, without walls.
    #[inline(always)]
    fn two<S: Simd>(&self, simd: S, [a, b, c]: [f32x16<S>; 3], length: [f32x16<S>; 2]) -> [[f32x16<S>; 4]; 2] {
        let (a, b, c) = (self.places(simd, a), self.places(simd, b), self.places(simd, c));
        [self.between(simd, a, b, length[0]), self.between(simd, b, c, length[1])]
    }

    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, value: f32x16<S>) -> Places<S> {
        let x = (value - self.origin) * self.per_unit;
        let row = x.max(splat(simd, 0.0)).min(splat(simd, self.last)).to_int::<i32x16<S>>().to_float();
        Places { row, fraction: x - row }
    }

    /// Light of stretches between two places, as `PreIntegrated::segment_between` has it.
    #[inline(always)]
    fn between<S: Simd>(&self, simd: S, front: Places<S>, back: Places<S>, length: f32x16<S>) -> [f32x16<S>; 4] {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        // The lower place, and the upper one.
        let falls = front.row.simd_gt(back.row);
        let low =
            Places { row: pick(falls, back.row, front.row), fraction: pick(falls, back.fraction, front.fraction) };
        let high =
            Places { row: pick(falls, front.row, back.row), fraction: pick(falls, front.fraction, back.fraction) };
        let [low_rows, high_rows] = [low.row, high.row].map(|row| row.to_int::<i32x16<S>>().to_array());
        let end = rows_at(simd, low_rows, |n| &self.rows[n].end);
        let low_start = rows_at(simd, low_rows, |n| &self.rows[n].start);
        let low_rise = rows_at(simd, low_rows, |n| &self.rows[n].rise);
        let sum = rows_at(simd, high_rows, |n| &self.rows[n].sum);
        let high_start = rows_at(simd, high_rows, |n| &self.rows[n].start);
        let high_rise = rows_at(simd, high_rows, |n| &self.rows[n].rise);
        // Means over the values between: inside one row, or from the one to its end and from the begin of the other.
        let inside = low.row.simd_eq(high.row);
        let (rest, centre) = (one - low.fraction, (one + low.fraction) * 0.5);
        let before = high.fraction * 0.5;
        let extent = rest + (high.row - low.row - 1.0) + high.fraction;
        let per_interval = one / pick(inside, one, extent);
        let middle = (low.fraction + high.fraction) * 0.5;
        let (mut mean, mut at_low, mut at_high) = ([zero; 4], [zero; 4], [zero; 4]);
        for c in 0..4 {
            let whole = sum[c].bitcast::<i32x16<S>>() - end[c].bitcast::<i32x16<S>>();
            let ends =
                rest * (low_start[c] + centre * low_rise[c]) + high.fraction * (high_start[c] + before * high_rise[c]);
            let across = (ends + whole.to_float::<f32x16<S>>() * self.quantum[c]) * per_interval;
            mean[c] = pick(inside, low_start[c] + middle * low_rise[c], across);
            at_low[c] = low_start[c] + low.fraction * low_rise[c];
            at_high[c] = high_start[c] + high.fraction * high_rise[c];
        }
        self.shine(simd, mean, [at_low, at_high], falls, length)
    }

    /// Light of stretches with mean properties, and those at their lower and upper values; in `falls`, the upper one lies in front.
    #[inline(always)]
    fn shine<S: Simd>(
        &self,
        simd: S,
        mean: [f32x16<S>; 4],
        [low, high]: [[f32x16<S>; 4]; 2],
        falls: mask32x16<S>,
        length: f32x16<S>,
    ) -> [f32x16<S>; 4] {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let tau = mean[3] * length;
        let alpha = opacity_of_depth(simd, tau);
        let weight = source_weight(simd, tau, alpha) * length;
        // Light that comes from further in front is dimmed less.
        let fade = one / ((tau * 1.5 + 6.0) * tau + 12.0);
        let (tau_low, tau_high) = (low[3] * length, high[3] * length);
        let (square, product) = (tau * tau, tau_low * tau_high);
        let denser = product.simd_gt(square);
        let moment = fade * pick(denser, square / pick(denser, product, one), one) * length;
        let moment = pick(falls, -moment, moment);
        let mut light = [zero, zero, zero, alpha];
        for c in 0..3 {
            let l = mean[c] * weight + moment * (low[c] * tau_high - high[c] * tau_low);
            light[c] = l.max(zero);
            if let Some(brightest) = &self.brightest {
                light[c] = light[c].min(alpha * brightest[c]);
            }
        }
        light
    }
}

#[inline(always)]
fn in_lanes<S: Simd>([r, g, b, a]: [f32x16<S>; 4]) -> [Lanes; 4] {
    [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)]
}

#[inline(always)]
fn set(light: &mut [Lanes; 4], lane: usize, value: [f32; 4]) {
    for c in 0..4 {
        light[c].0[lane] = value[c];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};
    use vr_core::transfer::{ControlPoint, OpacityRule};
    use vr_core::{Calibration, TransferFunction};

    /// Ramps, a jump and a wall; steps of all directions and lengths between values inside and outside of the table.
    #[test]
    fn light_is_that_of_the_table() {
        for (opacity, emits, slope) in [(0.8, false, 1.0), (1.0, false, 1.0), (1.0, true, -0.5), (0.8, true, 1.0)] {
            let point = |value: f64, color: [f64; 3], opacity: f64| ControlPoint {
                emission: emits.then(|| color.map(|c| 2.0 * c)),
                ..ControlPoint::new(value, color, opacity)
            };
            let points = vec![
                point(0.25, [0.0; 3], 0.0),
                point(0.5, [1.0, 0.25, 0.0], 0.5),
                point(0.5, [0.0, 1.0, 0.5], 0.125),
                point(0.75, [0.5, 0.5, 1.0], opacity),
                point(0.875, [1.0, 0.5, 0.25], opacity),
                point(1.0, [0.0; 3], 0.0),
            ];
            let transfer = TransferFunction::new(points, OpacityRule::Power, 0.5).unwrap();
            let calibration = Calibration { slope, intercept: if slope > 0.0 { 0.0 } else { 1.0 } };
            let table = Arc::new(PreIntegrated::<f32>::new(&transfer, calibration, (-0.5, 2.5), 1024));
            assert_eq!(table.has_walls(), opacity == 1.0);
            let lanes = SegmentTable::new(&table);
            let mut state = 7u64;
            let mut random = || {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                (state >> 40) as f32 / (1u64 << 24) as f32
            };
            for round in 0..2000 {
                // Close together, and far apart.
                let spread = if round % 2 == 0 { 0.01 } else { 1.0 };
                let mut values = [Lanes::ZERO; 3];
                let (mut length, mut other) = (Lanes::ZERO, Lanes::ZERO);
                for i in 0..LANES {
                    let first = 2.4 * random() - 0.2;
                    values[0].0[i] = first;
                    values[1].0[i] = if i % 5 == 0 { first } else { first + spread * (random() - 0.5) };
                    values[2].0[i] = first + spread * (random() - 0.5);
                    length.0[i] = if i % 3 == 0 { 2.0 * random() } else { 0.01 };
                    other.0[i] = random();
                }
                let (mut lines, mut bow) = ([[Lanes::ZERO; 4]; 2], [Lanes::ZERO; 4]);
                dispatch!(Level::new(), simd => {
                    lanes.lines(simd, &values, [&length, &other], u32::MAX, &mut lines);
                    lanes.parabola(simd, &values, &length, u32::MAX, &mut bow);
                });
                for i in 0..LANES {
                    let [a, b, c] = [values[0].0[i], values[1].0[i], values[2].0[i]];
                    let wants = [table.segment(a, b, length.0[i]), table.segment(b, c, other.0[i])];
                    let found = [lines[0], lines[1], bow];
                    for (want, found) in wants.into_iter().chain([table.segment3(a, b, c, length.0[i])]).zip(found) {
                        for k in 0..4 {
                            let off = (found[k].0[i] - want[k]).abs();
                            assert!(off <= 2e-6 * (1.0 + want[k]), "{opacity} {emits}: {off} of {want:?}, {a} {b} {c}");
                        }
                    }
                }
            }
        }
    }
}
