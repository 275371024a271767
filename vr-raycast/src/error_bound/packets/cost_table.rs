//! Transfer function as tables: the medium of a value, and the cost of not knowing the value exactly.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16, mask32x16};
use vr_kernels::vector::{LANES, pick, splat, transpose};

use super::super::optics::{Optics, Piece};

/// Medium over the stored numbers of a volume, and bounds on how it changes, in equal bins.
///
/// A slab that is dh long, in front of which the ray has a transmittance T and behind which there is the radiance I, changes the pixel by T (κ(c − I)) dh. With c and I in [0, M],
/// a value that changes by df therefore changes it by at most T · L · df · dh, where L = M |κ′| + κ |c′|.
#[derive(Clone, Debug)]
pub(super) struct CostTable {
    /// Colour and extinction per unit length at the start and the end of each bin.
    optics: Vec<[[f32; 4]; 2]>,
    /// At the start and the end of each bin: the largest L in it; how much that has changed from bin to bin; and how much the slopes of κ and of c have
    /// changed up to there. What changes at the edge between two bins is in the start of the second.
    changes: Vec<[[f32; 4]; 2]>,
    /// At the start and the end of each bin: how much the slope of κ has changed up to there at knots alone, and how much κ″ has changed between and at these; and κ″.
    bends: Vec<[[f32; 4]; 2]>,
    /// Weight of the change of the slope of κ in the mean of κ over a line, by which it differs from that of its ends; and that of what is in doubt at knots.
    pub(super) bend: f32,
    /// Ranges of values for which packets have no bound: walls, and opacities close to 1.
    walls: Vec<[f32; 2]>,
    origin: f32,
    per_unit: f32,
    /// A quarter of the width of a bin, in stored units. Times the change of slope in the bin, it bounds the error of what is looked up there.
    pub(super) quarter: f32,
    /// Bounds on the rounding error of the differences of these sums.
    slack: [f32; 5],
    /// Largest radiance that may come from behind a step, and from a source: M.
    pub(super) brightest: f32,
    /// Largest factor by which what is reflected changes with a colour; 1 where nothing is reflected. The changes of colours are multiplied by it.
    pub(super) factor: f32,
    /// Upper bound on the rounding error of a value's place among the bins, in stored units.
    pub(super) misplaced: f32,
}

/// Number of bins across the narrowest piece of a transfer function, as far as the limits allow.
const BINS_A_PIECE: f64 = 64.0;
/// Limits of the number of bins, before their width is rounded down to a power of two: tables take a megabyte at most.
const MIN_BINS: f64 = 1024.0;
const MAX_BINS: f64 = 8192.0;

/// Clearness 1 − α below which a medium counts as a wall: κ is 14 per unit distance there.
const NEARLY_A_WALL: f64 = 1e-6;

/// Medium at sixteen places: colour and extinction, and how the latter changes with the value.
pub(super) type Here<S> = [f32x16<S>; 5];

/// Bounds on how the medium changes over the values of a step.
pub(super) struct Changes<S: Simd> {
    /// Largest L.
    pub(super) steepest: f32x16<S>,
    /// Change of the slopes of κ and c.
    pub(super) kappa: f32x16<S>,
    pub(super) color: f32x16<S>,
    /// Change of the slope of κ at knots.
    knots: f32x16<S>,
    /// Change of κ″ between and at knots, and the largest κ″ between them.
    uneven: f32x16<S>,
    curvature: f32x16<S>,
}

impl<S: Simd> Changes<S> {
    /// Change of the slope of κ between knots.
    #[inline(always)]
    fn between_knots(&self) -> f32x16<S> {
        (self.kappa - self.knots).max(self.kappa * 0.0)
    }

    /// Bounds how far κ is from its chord over a span.
    #[inline(always)]
    pub(super) fn beside_chord(&self, span: f32x16<S>) -> f32x16<S> {
        let smooth = (self.between_knots() * 0.25).min(self.curvature * span * 0.125);
        (self.knots * 0.25 + smooth) * span
    }
}

/// Weight of the change of the slope of κ where κ is smooth but for knots that are known, and where it is not.
const SMOOTH: f32 = 1.0 / 12.0;
const ROUGH: f32 = 1.0 / 16.0;
/// Integral of |t(1 − t)/2 − 1/12| over t from 0 to 1, halved and rounded up.
const OF_CURVATURE: f32 = 0.016_1;

impl CostTable {
    /// Makes the tables for values from `low` to `high`, and lengths in units of `unit` world units, under light of `brightest` at most that changes with a colour by up to a `factor` times as much; `None` if there is no bound: under emission given on its own, and for a range
    /// without values or without length.
    pub(super) fn new(
        optics: &Optics,
        [low, high]: [f32; 2],
        unit: f64,
        [brightest, factor]: [f64; 2],
    ) -> Option<Self> {
        let range = f64::from(high) - f64::from(low);
        if optics.emits || !(range > 0.0 && range.is_finite()) {
            return None;
        }
        let pieces = optics.pieces().iter().map(|p| p.to - p.from);
        let narrowest = pieces.filter(|&width| width > 0.0).fold(range, f64::min);
        let bins = (BINS_A_PIECE * range / narrowest).clamp(MIN_BINS, MAX_BINS);
        // A width that is a power of two, and an origin that is a multiple of it, put control points at whole numbers on edges of bins.
        let width = libm::exp2(libm::floor(libm::log2(range / bins)));
        let even = libm::floor(f64::from(low) / width) * width;
        let origin = if f64::from(even as f32) == even { even } else { f64::from(low) };
        let bins = libm::ceil((f64::from(high) - origin) / width) as usize + 1;
        let brightest = brightest.max(1.0);
        let mut table = Builder {
            optics,
            unit,
            brightest,
            factor,
            width,
            last: None,
            steepness: 0.0,
            sums: [0.0; 5],
            is_aligned: true,
            rows: Vec::with_capacity(bins),
            changes: Vec::with_capacity(bins),
            bends: Vec::with_capacity(bins),
        };
        for bin in 0..bins {
            let from = origin + width * bin as f64;
            table.bin([from, from + width]);
        }
        // Where knots lie inside bins, all that is looked up is a line with knots at the edges of bins.
        if !table.is_aligned {
            let all = |changes: &[f32; 4]| [changes[2], 0.0, 0.0, 0.0];
            table.bends = table.changes.iter().map(|ends| ends.each_ref().map(all)).collect();
            table.sums[3] = table.sums[1];
        }
        let slack = table.sums.map(|sum| (sum * libm::exp2(-22.0)) as f32);
        Some(Self {
            optics: table.rows,
            changes: table.changes,
            bends: table.bends,
            bend: if table.is_aligned { SMOOTH } else { ROUGH },
            walls: walls(optics),
            origin: origin as f32,
            per_unit: (1.0 / width) as f32,
            slack,
            quarter: 0.25 * width as f32,
            brightest: brightest as f32 * (1.0 + 1e-6),
            factor: factor as f32 * (1.0 + 1e-6),
            misplaced: (range * libm::exp2(-23.0)) as f32,
        })
    }

    #[inline(always)]
    fn place<S: Simd>(&self, simd: S, value: f32x16<S>) -> f32x16<S> {
        let last = self.optics.len() as f32;
        ((value - self.origin) * self.per_unit).max(splat(simd, 0.0)).min(splat(simd, last))
    }

    /// Returns the medium at sixteen values, and how the colours change with the value.
    #[inline(always)]
    pub(super) fn medium<S: Simd>(&self, simd: S, value: f32x16<S>) -> (Here<S>, [f32x16<S>; 3]) {
        let x = self.place(simd, value);
        let index = x.to_int::<i32x16<S>>().min(i32x16::splat(simd, self.optics.len() as i32 - 1));
        let t = x - index.to_float::<f32x16<S>>();
        let index = index.to_array();
        let zero = f32x4::splat(simd, 0.0);
        let (mut low, mut high) = ([zero; LANES], [zero; LANES]);
        for i in 0..LANES {
            let ends = &self.optics[index[i] as u32 as usize];
            low[i] = f32x4::load_array_ref(simd, &ends[0]);
            high[i] = f32x4::load_array_ref(simd, &ends[1]);
        }
        let (low, high) = (transpose(low), transpose(high));
        let change = [high[0] - low[0], high[1] - low[1], high[2] - low[2], high[3] - low[3]];
        let per_unit = self.per_unit;
        let medium = [
            low[0] + t * change[0],
            low[1] + t * change[1],
            low[2] + t * change[2],
            low[3] + t * change[3],
            change[3] * per_unit,
        ];
        (medium, [change[0] * per_unit, change[1] * per_unit, change[2] * per_unit])
    }

    /// Returns `here`, or the medium at other values for `fresh` rays.
    #[inline(always)]
    pub(super) fn entered<S: Simd>(&self, simd: S, here: &Here<S>, fresh: mask32x16<S>, value: f32x16<S>) -> Here<S> {
        if fresh.all_false() {
            return *here;
        }
        let (there, _) = self.medium(simd, value);
        [
            pick(fresh, there[0], here[0]),
            pick(fresh, there[1], here[1]),
            pick(fresh, there[2], here[2]),
            pick(fresh, there[3], here[3]),
            pick(fresh, there[4], here[4]),
        ]
    }

    /// Returns how the medium changes over sixteen ranges of values.
    #[inline(always)]
    pub(super) fn changes<S: Simd>(&self, simd: S, low: f32x16<S>, high: f32x16<S>) -> Changes<S> {
        let most = i32x16::splat(simd, self.changes.len() as i32 - 1);
        let first = self.place(simd, low).to_int::<i32x16<S>>().min(most).to_array();
        let last = self.place(simd, high).to_int::<i32x16<S>>().min(most).to_array();
        let zero = f32x4::splat(simd, 0.0);
        let (mut before, mut behind) = ([zero; LANES], [zero; LANES]);
        let (mut bend_before, mut bend_behind) = ([zero; LANES], [zero; LANES]);
        let bends = &self.bends[..self.changes.len()];
        for i in 0..LANES {
            let (first, last) = (first[i] as u32 as usize, last[i] as u32 as usize);
            before[i] = f32x4::load_array_ref(simd, &self.changes[first][0]);
            behind[i] = f32x4::load_array_ref(simd, &self.changes[last][1]);
            bend_before[i] = f32x4::load_array_ref(simd, &bends[first][0]);
            bend_behind[i] = f32x4::load_array_ref(simd, &bends[last][1]);
        }
        let (before, behind) = (transpose(before), transpose(behind));
        let (bend_before, bend_behind) = (transpose(bend_before), transpose(bend_behind));
        let uneven = (bend_behind[1] - bend_before[1]) + self.slack[4];
        Changes {
            steepest: before[0] + ((behind[1] - before[1]) + self.slack[0]),
            kappa: (behind[2] - before[2]) + self.slack[1],
            color: (behind[3] - before[3]) + self.slack[2],
            knots: (bend_behind[0] - bend_before[0]) + self.slack[3],
            uneven,
            curvature: bend_before[2] + uneven,
        }
    }

    /// Bounds the error of an extinction that is looked up.
    #[inline(always)]
    pub(super) fn looked_up<S: Simd>(&self, changes: &Changes<S>) -> f32x16<S> {
        let quarter = self.quarter;
        let smooth = (changes.between_knots() * quarter).min(changes.curvature * (2.0 * quarter * quarter));
        changes.knots * quarter + smooth
    }

    /// Bounds what the mean of κ over a span is off by, with the change of slope from end to end times [`Self::bend`].
    #[inline(always)]
    pub(super) fn missed_bend<S: Simd>(&self, changes: &Changes<S>, span: f32x16<S>) -> f32x16<S> {
        // Slopes that are looked up are off by half a bin times κ″.
        let of_slopes = changes.curvature * (4.0 * self.quarter * SMOOTH);
        let smooth = (changes.between_knots() * self.bend).min(changes.uneven * span * OF_CURVATURE + of_slopes);
        (changes.knots * self.bend + smooth) * span
    }

    /// Returns infinity where a range of values meets a wall, and 0 elsewhere.
    #[inline(always)]
    pub(super) fn walls<S: Simd>(&self, simd: S, low: f32x16<S>, high: f32x16<S>) -> f32x16<S> {
        let mut found = splat(simd, 0.0);
        for &[from, to] in &self.walls {
            let meets = high.simd_ge(splat(simd, from)) & low.simd_le(splat(simd, to));
            found = pick(meets, splat(simd, f32::INFINITY), found);
        }
        found
    }
}

/// Returns the ranges of values with an opacity of 1 or nearly so, widened by rounding to f32.
fn walls(optics: &Optics) -> Vec<[f32; 2]> {
    let mut walls: Vec<[f32; 2]> = Vec::new();
    // A medium of a single value is in no bin.
    for piece in optics.pieces().iter().filter(|p| p.from == p.to || is_nearly_a_wall(optics, p)) {
        let steep = piece.opacity_slope.abs();
        // The part of the piece that is nearly opaque.
        let part = if steep > 0.0 { NEARLY_A_WALL / steep } else { f64::INFINITY };
        let [from, to] = match piece.opacity_slope {
            slope if slope > 0.0 => [(piece.to - part).max(piece.from), piece.to],
            slope if slope < 0.0 => [piece.from, (piece.from + part).min(piece.to)],
            _ => [piece.from, piece.to],
        };
        walls.push([(from as f32).next_down(), (to as f32).next_up()]);
    }
    walls
}

fn is_nearly_a_wall(optics: &Optics, piece: &Piece) -> bool {
    let ends = [piece.from, piece.to].map(|v| piece.clearness_at(if v.is_finite() { v } else { 0.0 }));
    optics.rule == vr_core::OpacityRule::Power && ends.iter().any(|&clear| clear < NEARLY_A_WALL)
}

/// Tables in the making, bin after bin.
struct Builder<'a> {
    optics: &'a Optics,
    unit: f64,
    brightest: f64,
    factor: f64,
    width: f64,
    /// Medium and slopes where the last part ended.
    last: Option<Ends>,
    /// L of the last bin.
    steepness: f64,
    /// Changes so far of L, and of the slopes of κ and c; of the former at knots alone, and of κ″.
    sums: [f64; 5],
    /// True if no knot lies inside a bin.
    is_aligned: bool,
    rows: Vec<[[f32; 4]; 2]>,
    changes: Vec<[[f32; 4]; 2]>,
    bends: Vec<[[f32; 4]; 2]>,
}

/// Medium at a value, on one side of it.
#[derive(Clone, Copy)]
struct Ends {
    kappa: f64,
    color: [f64; 3],
    kappa_slope: f64,
    color_slope: [f64; 3],
    curvature: f64,
}

impl Builder<'_> {
    fn bin(&mut self, [from, to]: [f64; 2]) {
        let (mut steepest, mut start) = (0.0f64, None);
        let meeting = self.optics.meeting(from, to).iter().filter(|p| p.from < to && p.to > from);
        let pieces: Vec<Piece> = meeting.copied().collect();
        self.is_aligned &= pieces.len() == 1;
        for piece in &pieces {
            let ends = [from.max(piece.from), to.min(piece.to)].map(|v| self.ends(piece, v));
            let [a, b] = &ends;
            if let Some(last) = self.last {
                self.join(&last, a);
            }
            start.get_or_insert((*a, self.sums));
            self.sums[1] += (b.kappa_slope - a.kappa_slope).abs();
            self.sums[4] += (b.curvature - a.curvature).abs();
            for end in &ends {
                let color = end.color_slope.iter().fold(0.0f64, |m, s| m.max(s.abs()));
                steepest =
                    steepest.max(self.brightest * end.kappa_slope.abs() + a.kappa.max(b.kappa) * self.factor * color);
            }
            self.last = Some(*b);
        }
        let (first, before) = start.expect("pieces are everywhere");
        let last = self.last.expect("pieces are everywhere");
        let row = |end: &Ends| [end.color[0], end.color[1], end.color[2], end.kappa].map(|x| x as f32);
        self.rows.push([row(&first), row(&last)]);
        steepest *= 1.0 + 1e-6;
        self.sums[0] += (steepest - self.steepness).abs();
        self.steepness = steepest;
        let changes = |sums: &[f64; 5]| [steepest, self.sums[0], sums[1], sums[2]].map(|x| x as f32);
        self.changes.push([changes(&before), changes(&self.sums)]);
        let curvature = first.curvature * (1.0 + 1e-6);
        let bends = |sums: &[f64; 5]| [sums[3], sums[4], curvature, 0.0].map(|x| x as f32);
        self.bends.push([bends(&before), bends(&self.sums)]);
    }

    fn ends(&self, piece: &Piece, value: f64) -> Ends {
        let per_length = self.unit / self.optics.unit;
        let clear = piece.clearness_at(value).clamp(NEARLY_A_WALL, 1.0);
        let opacity = piece.opacity_at(value).clamp(0.0, 1.0);
        let (kappa, slope, curvature) = match self.optics.rule {
            vr_core::OpacityRule::Extinction => (opacity, piece.opacity_slope, 0.0),
            vr_core::OpacityRule::Power => {
                let slope = piece.opacity_slope / clear;
                (self.optics.rate(opacity.min(1.0 - NEARLY_A_WALL), clear), slope, slope * slope)
            }
        };
        let source = piece.source_at(value);
        Ends {
            kappa: kappa * per_length,
            color: source,
            kappa_slope: slope * per_length,
            color_slope: piece.source_slope,
            curvature: curvature * per_length,
        }
    }

    /// Adds the changes of slope, and the jumps, between two neighbouring parts. A jump counts as four times its slope over a bin: a quarter of a bin times that is the
    /// jump itself, which a step across it costs at least.
    fn join(&mut self, last: &Ends, next: &Ends) {
        let most = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        let knot = (next.kappa_slope - last.kappa_slope).abs() + 4.0 / self.width * (next.kappa - last.kappa).abs();
        self.sums[1] += knot;
        self.sums[3] += knot;
        self.sums[4] += (next.curvature - last.curvature).abs();
        let color = most(&next.color_slope, &last.color_slope) + 4.0 / self.width * most(&next.color, &last.color);
        self.sums[2] += self.factor * color;
    }
}
