//! Transfer function as tables: the medium of a value, and the cost of not knowing the value exactly.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16, mask32x16};
use vr_kernels::vector::{packed_rows, pick, rows_at, splat, transpose_packed};

use super::super::optics::{Optics, Piece};

/// Medium over the stored numbers of a volume, and bounds on how it changes, in equal bins.
///
/// A slab that is dh long, in front of which the ray has a transmittance T and behind which there is the radiance I, changes the pixel by T (κ(c − I)) dh. With c and I in [0, M],
/// a value that changes by df therefore changes it by at most T · L · df · dh, where L = M |κ′| + κ |c′|.
#[derive(Clone, Debug)]
pub(super) struct CostTable {
    /// Colour and extinction per unit length at the start and the end of each bin.
    optics: Vec<[[f32; 4]; 2]>,
    /// Sums up to the start and the end of each bin: of the changes of L from bin to bin, and of the changes of the slopes of κ and of c. What changes at the edge between
    /// two bins is in the start of the second. At the start, L of the bin is taken from its sum: the difference to an end further on is the largest L between.
    changes: Vec<[[f32; 4]; 2]>,
    /// Ranges of values for which packets have no bound: walls, and opacities close to 1.
    walls: Vec<[f32; 2]>,
    origin: f32,
    per_unit: f32,
    /// A quarter of the width of a bin, in stored units. Times the change of slope in the bin, it bounds the error of what is looked up there.
    pub(super) quarter: f32,
    /// Bounds on the rounding error of the differences of these sums.
    slack: [f32; 3],
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
}

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
            sums: [0.0; 3],
            rows: Vec::with_capacity(bins),
            changes: Vec::with_capacity(bins),
        };
        for bin in 0..bins {
            let from = origin + width * bin as f64;
            table.bin([from, from + width]);
        }
        let slack = table.sums.map(|sum| (sum * libm::exp2(-22.0)) as f32);
        Some(Self {
            optics: table.rows,
            changes: table.changes,
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
        let low = rows_at(simd, index, |n| &self.optics[n][0]);
        let high = rows_at(simd, index, |n| &self.optics[n][1]);
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
        let from = packed_rows(simd, first, |n| &self.changes[n][0]);
        let to = packed_rows(simd, last, |n| &self.changes[n][1]);
        let [steepest, kappa, color, _] =
            transpose_packed([to[0] - from[0], to[1] - from[1], to[2] - from[2], to[3] - from[3]]);
        Changes { steepest: steepest + self.slack[0], kappa: kappa + self.slack[1], color: color + self.slack[2] }
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
    /// Changes so far of L, and of the slopes of κ and c.
    sums: [f64; 3],
    rows: Vec<[[f32; 4]; 2]>,
    changes: Vec<[[f32; 4]; 2]>,
}

/// Medium at a value, on one side of it.
#[derive(Clone, Copy)]
struct Ends {
    kappa: f64,
    color: [f64; 3],
    kappa_slope: f64,
    color_slope: [f64; 3],
}

impl Builder<'_> {
    fn bin(&mut self, [from, to]: [f64; 2]) {
        let (mut steepest, mut start) = (0.0f64, None);
        let meeting = self.optics.meeting(from, to).iter().filter(|p| p.from < to && p.to > from);
        let pieces: Vec<Piece> = meeting.copied().collect();
        for piece in &pieces {
            let ends = [from.max(piece.from), to.min(piece.to)].map(|v| self.ends(piece, v));
            let [a, b] = &ends;
            if let Some(last) = self.last {
                self.join(&last, a);
            }
            start.get_or_insert((*a, self.sums));
            self.sums[1] += (b.kappa_slope - a.kappa_slope).abs();
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
        let changes = |[steepness, kappa, color]: [f64; 3]| [steepness, kappa, color, 0.0].map(|x| x as f32);
        self.changes.push([changes([self.sums[0] - steepest, before[1], before[2]]), changes(self.sums)]);
    }

    fn ends(&self, piece: &Piece, value: f64) -> Ends {
        let per_length = self.unit / self.optics.unit;
        let clear = piece.clearness_at(value).clamp(NEARLY_A_WALL, 1.0);
        let opacity = piece.opacity_at(value).clamp(0.0, 1.0);
        let (kappa, slope) = match self.optics.rule {
            vr_core::OpacityRule::Extinction => (opacity, piece.opacity_slope),
            vr_core::OpacityRule::Power => {
                (self.optics.rate(opacity.min(1.0 - NEARLY_A_WALL), clear), piece.opacity_slope / clear)
            }
        };
        let source = piece.source_at(value);
        Ends {
            kappa: kappa * per_length,
            color: source,
            kappa_slope: slope * per_length,
            color_slope: piece.source_slope,
        }
    }

    /// Adds the changes of slope, and the jumps, between two neighbouring parts. A jump counts as four times its slope over a bin: a quarter of a bin times that is the
    /// jump itself, which a step across it costs at least.
    fn join(&mut self, last: &Ends, next: &Ends) {
        let most = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        self.sums[1] +=
            (next.kappa_slope - last.kappa_slope).abs() + 4.0 / self.width * (next.kappa - last.kappa).abs();
        let color = most(&next.color_slope, &last.color_slope) + 4.0 / self.width * most(&next.color, &last.color);
        self.sums[2] += self.factor * color;
    }
}
