//! Transfer function in stored units, and its exact ranges.

use vr_core::transfer::{Optical, Segment};
use vr_core::{Calibration, OpacityRule, TransferFunction};

/// Transfer function as the error bound needs it: pieces over *stored* numbers, in which opacity and source are linear.
///
/// The *source* is the colour of a density emitter, or the emission per world unit where that is given on its own.
#[derive(Clone, Debug)]
pub(crate) struct Optics {
    pieces: Vec<Piece>,
    pub(crate) rule: OpacityRule,
    /// World length that opacities belong to.
    pub(crate) unit: f64,
    /// True if the source is emission given on its own.
    pub(crate) emits: bool,
    /// The largest component of the source.
    pub(crate) brightest: f64,
    /// Largest error of a knot's place by the calibration's rounding, in stored units.
    pub(crate) knot_error: f64,
    /// True if knots need no conversion to stored numbers, and so are exact: the calibration is the identity.
    pub(crate) knots_are_exact: bool,
    pub(super) transfer: TransferFunction,
    pub(super) calibration: Calibration,
    /// Those of its rows, the pieces of which end at the same values; none where it has none. No row is beyond the function itself.
    pub(super) rows: Vec<Self>,
}

/// Range of stored numbers in which opacity and source are linear.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    pub(crate) from: f64,
    pub(crate) to: f64,
    /// Opacity and source at both ends; the same on the two outermost pieces.
    ends: [Optical; 2],
    pub(crate) opacity_slope: f64,
    pub(crate) source_slope: [f64; 3],
    /// Largest slopes of opacity and of the source's components, here and on both sides.
    pub(crate) steepest_opacity: f64,
    pub(crate) steepest_source: f64,
    /// True for a wall: α = 1 throughout under the power rule.
    pub(crate) opaque: bool,
    /// True if nothing absorbs and nothing shines.
    pub(crate) clear: bool,
    /// Reach, at the lower and the upper end, of the neighbour that joins without a jump and is no wall; 0 where none does.
    pub(crate) joined: [f64; 2],
    emits: bool,
}

/// Extremes of a medium over a range of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremes {
    /// Smallest and largest optical depth per unit distance; +∞ where α = 1 under the power rule.
    pub(crate) rate: [f64; 2],
    /// Smallest and largest optical depth per unit distance without walls: of the medium before a wall begins.
    pub(crate) before_wall: f64,
    /// Smallest and largest value of every component of the source.
    pub(crate) source: [[f64; 2]; 3],
    /// True if there is a wall in the range.
    pub(crate) wall: bool,
}

impl Extremes {
    /// Returns those of a medium that is one of two, or anything between.
    fn or(&self, other: &Self) -> Self {
        let both = |a: [f64; 2], b: [f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            rate: both(self.rate, other.rate),
            before_wall: self.before_wall.max(other.before_wall),
            source: std::array::from_fn(|c| both(self.source[c], other.source[c])),
            wall: self.wall || other.wall,
        }
    }

    /// Returns the largest difference of two values of a component of the source.
    pub(crate) fn source_width(&self) -> f64 {
        self.source.iter().map(|s| s[1] - s[0]).fold(0.0, f64::max)
    }
}

impl Piece {
    fn new(segment: &Segment, calibration: Calibration, transfer: &TransferFunction) -> Self {
        let (mut from, mut to) = (calibration.stored(segment.from), calibration.stored(segment.to));
        let mut ends = [segment.start, segment.end];
        if from > to {
            (from, to) = (to, from);
            ends.reverse();
        }
        let emits = transfer.has_emission();
        let span = to - from;
        let slope = |a: f64, b: f64| if a == b || !span.is_finite() { 0.0 } else { (b - a) / span };
        let source = ends.map(|e| if emits { e.emission } else { e.color });
        let opaque = transfer.rule() == OpacityRule::Power && segment.is_opaque();
        Self {
            from,
            to,
            opacity_slope: slope(ends[0].opacity, ends[1].opacity),
            source_slope: std::array::from_fn(|c| slope(source[0][c], source[1][c])),
            ends,
            steepest_opacity: 0.0,
            steepest_source: 0.0,
            opaque,
            clear: segment.is_clear(),
            joined: [0.0; 2],
            emits,
        }
    }

    fn source_of(&self, end: usize) -> [f64; 3] {
        if self.emits { self.ends[end].emission } else { self.ends[end].color }
    }

    /// Returns the end from which values are reckoned: the one named, or the other where that is not finite.
    fn anchor(&self, wanted: usize) -> (usize, f64) {
        let at = [self.from, self.to];
        if at[wanted].is_finite() { (wanted, at[wanted]) } else { (1 - wanted, at[1 - wanted]) }
    }

    /// Returns the opacity at a stored number, on the piece's line.
    pub(crate) fn opacity_at(&self, stored: f64) -> f64 {
        if self.opacity_slope == 0.0 {
            return self.ends[0].opacity;
        }
        // From the end where it is less: no digits are lost near 0.
        let (end, at) = self.anchor(usize::from(self.ends[1].opacity < self.ends[0].opacity));
        self.ends[end].opacity + self.opacity_slope * (stored - at)
    }

    /// Returns 1 − opacity, with all digits near 0.
    pub(crate) fn clearness_at(&self, stored: f64) -> f64 {
        if self.opacity_slope == 0.0 {
            return 1.0 - self.ends[0].opacity;
        }
        let (end, at) = self.anchor(usize::from(self.ends[1].opacity > self.ends[0].opacity));
        (1.0 - self.ends[end].opacity) - self.opacity_slope * (stored - at)
    }

    /// Returns the source at a stored number, on the piece's line.
    pub(crate) fn source_at(&self, stored: f64) -> [f64; 3] {
        let (end, at) = self.anchor(0);
        let source = self.source_of(end);
        std::array::from_fn(|c| {
            let slope = self.source_slope[c];
            if slope == 0.0 { source[c] } else { source[c] + slope * (stored - at) }
        })
    }

    /// Returns a number in the piece: its start, or, where that is not finite, one before its end.
    pub(super) fn inside(&self) -> f64 {
        if self.from.is_finite() { self.from } else { self.to.next_down() }
    }

    /// Returns the largest slope of a component of the source.
    pub(crate) fn source_steepness(&self) -> f64 {
        self.source_slope.iter().fold(0.0, |m, s| m.max(s.abs()))
    }

    /// True if numbers within `noise` of [low, high] are in the piece, or so little beyond a kink that the piece's own line is at most
    /// 4 · (steepest slope) · noise from the truth there.
    pub(crate) fn holds(&self, low: f64, high: f64, noise: f64) -> bool {
        let end = |inside: bool, within: bool, joined: f64| inside || (within && !self.opaque && joined >= 2.0 * noise);
        end(low - noise >= self.from, low >= self.from - noise, self.joined[0])
            && end(high + noise <= self.to, high <= self.to + noise, self.joined[1])
    }
}

impl Optics {
    /// Returns the optics of a transfer function, for stored numbers of at most `largest`.
    pub(crate) fn new(transfer: &TransferFunction, calibration: Calibration, largest: f64) -> Self {
        let mut pieces: Vec<Piece> = transfer.segments().iter().map(|s| Piece::new(s, calibration, transfer)).collect();
        if calibration.slope < 0.0 {
            pieces.reverse();
        }
        let n = pieces.len();
        let own: Vec<(f64, f64)> = pieces.iter().map(|p| (p.opacity_slope.abs(), p.source_steepness())).collect();
        let lines: Vec<Piece> = pieces.clone();
        for (i, p) in pieces.iter_mut().enumerate() {
            for &(opacity, source) in &own[i.saturating_sub(1)..(i + 2).min(n)] {
                p.steepest_opacity = p.steepest_opacity.max(opacity);
                p.steepest_source = p.steepest_source.max(source);
            }
            let joins = |other: &Piece, mine: usize, theirs: usize| p.ends[mine] == other.ends[theirs] && !other.opaque;
            if i > 0 && joins(&lines[i - 1], 0, 1) {
                p.joined[0] = lines[i - 1].to - lines[i - 1].from;
            }
            if i + 1 < n && joins(&lines[i + 1], 1, 0) {
                p.joined[1] = lines[i + 1].to - lines[i + 1].from;
            }
        }
        // Rows have the same pieces: what holds of one holds of all, or of none.
        let rows: Vec<Self> =
            transfer.rows().iter().map(|row| Self::new(&row.transfer, calibration, largest)).collect();
        for (i, p) in pieces.iter_mut().enumerate() {
            for row in &rows {
                let own = &row.pieces[i];
                p.steepest_opacity = p.steepest_opacity.max(own.steepest_opacity);
                p.steepest_source = p.steepest_source.max(own.steepest_source);
                p.joined = std::array::from_fn(|end| p.joined[end].min(own.joined[end]));
            }
        }
        let size = transfer.points().iter().map(|p| p.value.abs()).fold(0.0, f64::max) + calibration.intercept.abs();
        let emits = transfer.has_emission();
        Self {
            pieces,
            rule: transfer.rule(),
            unit: transfer.unit_distance(),
            emits,
            brightest: if emits { transfer.brightest_emission() } else { transfer.brightest_color() },
            knots_are_exact: calibration == Calibration::default(),
            knot_error: 8.0 * f64::EPSILON * (size / calibration.slope.abs()).max(largest),
            transfer: transfer.clone(),
            calibration,
            rows,
        }
    }

    /// Returns the piece of a stored number.
    pub(crate) fn piece_at(&self, stored: f64) -> &Piece {
        let i = self.pieces.partition_point(|p| p.from <= stored);
        &self.pieces[i.max(1) - 1]
    }

    /// Returns the knot in the middle of those inside the open range.
    pub(crate) fn knot_between(&self, low: f64, high: f64) -> Option<f64> {
        let first = self.pieces.partition_point(|p| p.from <= low);
        let end = self.pieces.partition_point(|p| p.from < high);
        (first < end).then(|| self.pieces[usize::midpoint(first, end)].from)
    }

    /// Returns all pieces, in the order of their values.
    pub(super) fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Returns the pieces that the closed range meets.
    pub(super) fn meeting(&self, low: f64, high: f64) -> &[Piece] {
        let first = self.pieces.partition_point(|p| p.to < low).min(self.pieces.len() - 1);
        let end = self.pieces.partition_point(|p| p.from <= high).max(first + 1);
        &self.pieces[first..end]
    }

    /// True if nothing absorbs and nothing shines over a closed range.
    pub(crate) fn is_clear(&self, low: f64, high: f64) -> bool {
        self.meeting(low, high).iter().all(|p| {
            p.clear
                || [low, high].iter().all(|&v| {
                    let v = v.clamp(p.from, p.to);
                    p.opacity_at(v) == 0.0 && (!self.emits || p.source_at(v) == [0.0; 3])
                })
        })
    }

    /// Returns the extremes of the medium over a closed range of stored numbers.
    pub(crate) fn extremes(&self, low: f64, high: f64) -> Extremes {
        if let Some((first, rest)) = self.rows.split_first() {
            // A mixture is nowhere beyond all of them.
            return rest.iter().fold(first.extremes(low, high), |all, row| all.or(&row.extremes(low, high)));
        }
        let (inf, none) = (f64::INFINITY, f64::NEG_INFINITY);
        let mut e = Extremes { rate: [inf, 0.0], before_wall: 0.0, source: [[inf, none]; 3], wall: false };
        for p in self.meeting(low, high) {
            e.wall |= p.opaque;
            for v in [low.clamp(p.from, p.to), high.clamp(p.from, p.to)] {
                let rate = self.rate(p.opacity_at(v).clamp(0.0, 1.0), p.clearness_at(v).clamp(0.0, 1.0));
                e.rate = [e.rate[0].min(rate), e.rate[1].max(rate)];
                if !p.opaque {
                    e.before_wall = e.before_wall.max(rate);
                }
                let source = p.source_at(v);
                for (range, s) in e.source.iter_mut().zip(source) {
                    *range = [range[0].min(s.max(0.0)), range[1].max(s)];
                }
            }
        }
        e
    }

    /// Returns how κ·unit and the source depend on the value over a closed range of finite numbers: for each, the slope of a linear function, and a
    /// bound on how far it is from that.
    ///
    /// The linear function is the chord of the range. Between knots −ln(1 − α) is convex, and so at most (b − a)/4 times the difference of
    /// its end slopes below its own chord there.
    pub(crate) fn bent(&self, low: f64, high: f64) -> [[f64; 2]; 2] {
        let span = high - low;
        let rate = |p: &Piece, v: f64| self.rate(p.opacity_at(v).clamp(0.0, 1.0), p.clearness_at(v).clamp(0.0, 1.0));
        let pieces = self.meeting(low, high);
        let (first, last) = (&pieces[0], &pieces[pieces.len() - 1]);
        let chord = |a: f64, b: f64| if span > 0.0 { (b - a) / span } else { 0.0 };
        let start = rate(first, low);
        let slope = chord(start, rate(last, high));
        let sources = [first.source_at(low), last.source_at(high)];
        let slopes: [f64; 3] = std::array::from_fn(|c| chord(sources[0][c], sources[1][c]));
        let (mut off, mut source_off) = (0.0f64, 0.0f64);
        for p in pieces {
            let ends = [low.clamp(p.from, p.to), high.clamp(p.from, p.to)];
            let sag = match self.rule {
                OpacityRule::Extinction => 0.0,
                OpacityRule::Power => {
                    let steep = ends.map(|v| p.opacity_slope / p.clearness_at(v).max(0.0));
                    0.25 * (ends[1] - ends[0]) * (steep[1] - steep[0]).abs()
                }
            };
            for v in ends {
                off = off.max((rate(p, v) - start - slope * (v - low)).abs() + sag);
                let source = p.source_at(v);
                for c in 0..3 {
                    source_off = source_off.max((source[c] - sources[0][c] - slopes[c] * (v - low)).abs());
                }
            }
        }
        let steepest = slopes.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        [[slope.abs(), off], [steepest, source_off]]
    }

    /// Returns the steepest slopes of κ·unit and of the source by the value over a closed range of finite numbers; both +∞ where anything jumps in it, or a wall is.
    #[cfg(feature = "classics")]
    pub(crate) fn steepest(&self, low: f64, high: f64) -> [f64; 2] {
        let pieces = self.meeting(low, high);
        if pieces.iter().any(|p| p.opaque) || pieces.windows(2).any(|p| p[0].ends[1] != p[1].ends[0]) {
            return [f64::INFINITY; 2];
        }
        let mut steepest = [0.0f64; 2];
        for p in pieces {
            // −ln(1 − α) is convex: it is steepest at an end.
            for v in [low.clamp(p.from, p.to), high.clamp(p.from, p.to)] {
                let rate = match self.rule {
                    _ if p.opacity_slope == 0.0 => 0.0,
                    OpacityRule::Extinction => p.opacity_slope.abs(),
                    OpacityRule::Power => p.opacity_slope.abs() / p.clearness_at(v).max(0.0),
                };
                steepest[0] = steepest[0].max(rate);
            }
            steepest[1] = steepest[1].max(p.source_steepness());
        }
        steepest
    }

    /// Returns what κ·unit and the source may change by for each unit that a value of a closed range is off by, or a little beyond; both +∞ where anything jumps in it,
    /// or a wall is.
    pub(super) fn sensitivity(&self, low: f64, high: f64) -> [f64; 2] {
        if !self.rows.is_empty() {
            let rows = self.rows.iter().map(|row| row.sensitivity(low, high));
            return rows.fold([0.0; 2], |all: [f64; 2], own| std::array::from_fn(|i| all[i].max(own[i])));
        }
        let pieces = self.meeting(low, high);
        if pieces.iter().any(|p| p.opaque) || pieces.windows(2).any(|p| p[0].ends[1] != p[1].ends[0]) {
            return [f64::INFINITY; 2];
        }
        pieces.iter().fold([0.0; 2], |[rate, source]: [f64; 2], p| {
            let clearness = match self.rule {
                OpacityRule::Extinction => 1.0,
                OpacityRule::Power => {
                    let ends = [low, high].map(|v| p.clearness_at(v.clamp(p.from, p.to)));
                    ends[0].min(ends[1]).max(0.0)
                }
            };
            let own = if p.steepest_opacity == 0.0 { 0.0 } else { p.steepest_opacity / clearness };
            [rate.max(own), source.max(p.steepest_source)]
        })
    }

    /// Returns the optical depth per unit distance of an opacity, of which the complement is given, too.
    pub(crate) fn rate(&self, opacity: f64, clearness: f64) -> f64 {
        match self.rule {
            OpacityRule::Extinction => opacity,
            OpacityRule::Power if opacity < 0.5 => -libm::log1p(-opacity),
            OpacityRule::Power => -libm::log(clearness),
        }
    }

    /// Returns a bound of the optical depth of a part of a cubic in which α reaches 1 at points, but not over a length.
    ///
    /// On the pieces that end at such a knot v, 1 − α = |slope|·|f − v|. With |f − v| ≥ W somewhere on the whole cubic, which is
    /// `whole` long, each of its three roots adds at most l (1 + ln(whole/l)) to ∫ −ln(|f − v|/W) ds over a part of length l = `part`,
    /// wherever the root lies. `farthest` gives W for a knot. What pieces that do not touch 1 absorb comes on top.
    pub(crate) fn depth_at_touch(
        &self,
        low: f64,
        high: f64,
        farthest: impl Fn(f64) -> f64,
        part: f64,
        whole: f64,
    ) -> f64 {
        let (mut touched, mut least, mut others) = (f64::NAN, f64::INFINITY, 0.0f64);
        for p in self.meeting(low, high).iter().filter(|p| !p.opaque) {
            let mut touches = false;
            for v in [p.from, p.to] {
                if p.opacity_slope != 0.0 && (low..=high).contains(&v) && p.clearness_at(v) <= 0.0 {
                    if touched == v || touched.is_nan() {
                        touched = v;
                        least = least.min(p.opacity_slope.abs() * farthest(v));
                        touches = true;
                    } else {
                        return f64::INFINITY;
                    }
                }
            }
            if !touches {
                for v in [low.clamp(p.from, p.to), high.clamp(p.from, p.to)] {
                    others = others.max(self.rate(p.opacity_at(v).clamp(0.0, 1.0), p.clearness_at(v).clamp(0.0, 1.0)));
                }
            }
        }
        if !(least > 0.0 && least.is_finite()) {
            return f64::INFINITY;
        }
        let roots = 3.0 * (1.0 + libm::log((whole / part).max(1.0)));
        part / self.unit * (roots - libm::log(least.min(1.0)) + others)
    }

    /// Returns the medium at one stored number, as the transfer function gives it: depth per unit distance (+∞ in a wall) and source.
    pub(crate) fn exactly(&self, stored: f64) -> (f64, [f64; 3]) {
        let o = self.transfer.at(self.calibration.value(stored));
        let source = if self.emits { o.emission } else { o.color };
        (self.rate(o.opacity, 1.0 - o.opacity), source)
    }
}
