//! Two-dimensional transfer functions: rows of one-dimensional ones by the magnitude of the gradient.

use super::{ControlPoint, OpacityRule, Segment, TransferFunction};
use crate::error::ParameterError;
use crate::limits::MAX_MAGNITUDE;
use crate::optics::{opacity_of_depth, source_weight};

/// A row of a two-dimensional transfer function: the map from value to light and extinction where the gradient has one magnitude.
///
/// # Examples
/// ```
/// use vr_core::transfer::TransferRow;
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// // Flat regions are clear; boundaries, where the value changes by 8 and more a unit, are orange.
/// let row = |gradient, opacity| (gradient, vec![ControlPoint::new(0.0, [1.0, 0.5, 0.1], opacity)]);
/// let transfer = TransferFunction::of_rows(vec![row(0.0, 0.0), row(8.0, 0.5)], OpacityRule::Power, 1.0)?;
/// let opacity = |row: &TransferRow| row.transfer.at(7.0).opacity;
/// assert_eq!(transfer.rows().iter().map(opacity).collect::<Vec<_>>(), [0.0, 0.5]);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransferRow {
    /// Magnitude of the gradient, in value per world unit.
    pub gradient: f64,
    /// Transfer function at that magnitude. Its segments end at the values at which those of any row do.
    pub transfer: TransferFunction,
}

/// Rows on either side of a magnitude of the gradient, and the share of the upper one.
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// let row = |gradient| (gradient, vec![ControlPoint::new(0.0, [1.0; 3], 0.5)]);
/// let transfer = TransferFunction::of_rows(vec![row(0.0), row(2.0), row(4.0)], OpacityRule::Power, 1.0)?;
/// let mix = transfer.row_mix(3.5);
/// assert_eq!((mix.lower, mix.upper, mix.share), (1, 2, 0.75));
/// assert_eq!(transfer.row_mix(9.0).weights(), [(2, 1.0), (2, 0.0)], "constant beyond the last row");
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowMix {
    /// Index of the last row that is not above the magnitude, or of the first one.
    pub lower: usize,
    /// Index of the row after that, or the same where there is none.
    pub upper: usize,
    /// Share of the upper row, 0 to 1; the lower one has the rest.
    pub share: f64,
    /// Slope of the share by the magnitude; 0 below the first row and above the last.
    pub slope: f64,
}

impl RowMix {
    /// Returns both rows and their shares.
    pub fn weights(&self) -> [(usize, f64); 2] {
        [(self.lower, 1.0 - self.share), (self.upper, self.share)]
    }
}

/// Extinction κ and emission q of a medium, per world unit.
///
/// # Examples
/// ```
/// use vr_core::{ControlPoint, OpacityRule, TransferFunction};
///
/// let row = |gradient, opacity| (gradient, vec![ControlPoint::new(0.0, [0.5; 3], opacity)]);
/// let transfer = TransferFunction::of_rows(vec![row(0.0, 0.0), row(1.0, 0.8)], OpacityRule::Extinction, 1.0)?;
/// let half_way = transfer.mixture(0.0, 0.5);
/// assert_eq!((half_way.extinction, half_way.emission), (0.4, [0.2; 3]));
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mixture {
    /// κ.
    pub extinction: f64,
    /// q: κ·color, or the emission that is given on its own.
    pub emission: [f64; 3],
}

impl Mixture {
    /// Returns light (r, g, b) and opacity of a homogeneous step of `length` world units.
    pub fn step(&self, length: f64) -> [f64; 4] {
        let depth = self.extinction * length;
        let weight = length * source_weight(depth);
        let [r, g, b] = self.emission.map(|q| q * weight);
        [r, g, b, opacity_of_depth(depth)]
    }
}

/// Meaning of an opacity that a row may not have.
const NOT_OPAQUE: &str = "must be below 1 in a row: its extinction is infinite, and would be a wall wherever the row has any share; 0.999 at most";
/// Largest opacity of a row under the power rule.
const MAX_OPACITY: f64 = 0.999;

impl TransferFunction {
    /// A two-dimensional transfer function of value and magnitude of the gradient, by rows: (magnitude in value per world unit, points), in
    /// order of their magnitudes.
    ///
    /// Between two rows, extinction κ and emission q = κ·color (or that given on its own) are linear in the magnitude: a mixture of two
    /// media, in which one that is clear has no colour. They are constant below the first row and above the last.
    ///
    /// Methods that look at the value alone ([`Self::points`], [`Self::segments`], [`Self::at`], the brightest colours) then give upper bounds
    /// over all rows: where they are clear, every row is. [`Self::mixture`] is the medium itself.
    ///
    /// # Errors
    /// A [`ParameterError`] naming row and point: those of [`Self::new`]; no row; magnitudes that are not strictly increasing from 0 to
    /// 10⁶⁰; opacities above 0.999 under the power rule, for the walls that they would be; emission in some rows only.
    pub fn of_rows(
        rows: Vec<(f64, Vec<ControlPoint>)>,
        rule: OpacityRule,
        unit_distance: f64,
    ) -> Result<Self, ParameterError> {
        if rows.is_empty() {
            return Err(ParameterError::new("transfer.rows", "none", "must have at least one row"));
        }
        let mut made: Vec<TransferRow> = Vec::with_capacity(rows.len());
        for (i, (gradient, points)) in rows.into_iter().enumerate() {
            let field = |name: &str| format!("transfer.rows[{i}].{name}");
            if !(0.0..=MAX_MAGNITUDE).contains(&gradient) {
                let allowed = "must be a magnitude, 0 to 1e60, in value per world unit";
                return Err(ParameterError::new(field("gradient"), gradient, allowed));
            }
            if made.last().is_some_and(|last| last.gradient >= gradient) {
                let allowed = "rows must be in order of their gradients, no two of them the same";
                return Err(ParameterError::new(field("gradient"), gradient, allowed));
            }
            let transfer = Self::new(points, rule, unit_distance).map_err(|e| ParameterError {
                field: e.field.replacen("transfer", &format!("transfer.rows[{i}]"), 1),
                ..e
            })?;
            let opaque = transfer.points.iter().position(|p| p.opacity > MAX_OPACITY);
            if let (OpacityRule::Power, Some(k)) = (rule, opaque) {
                let found = transfer.points[k].opacity;
                return Err(ParameterError::new(field(&format!("points[{k}].opacity")), found, NOT_OPAQUE));
            }
            if made.first().is_some_and(|first| first.transfer.has_emission != transfer.has_emission) {
                let found = if transfer.has_emission { "emission" } else { "no emission" };
                let allowed = "emission must be given in all rows or in none";
                return Err(ParameterError::new(field("points"), found, allowed));
            }
            made.push(TransferRow { gradient, transfer });
        }
        cut_alike(&mut made);
        let bound = Self::new(upper_bound(&made), rule, unit_distance)?;
        Ok(Self { rows: made, ..bound })
    }

    /// Returns the rows of a two-dimensional transfer function; none of one by the value alone.
    pub fn rows(&self) -> &[TransferRow] {
        &self.rows
    }

    /// True if light and extinction follow the magnitude of the gradient as well as the value.
    pub fn has_rows(&self) -> bool {
        !self.rows.is_empty()
    }

    /// Returns the rows on either side of a magnitude. A NaN is taken for the largest.
    ///
    /// Panics if there are no rows: a bug in the caller.
    pub fn row_mix(&self, magnitude: f64) -> RowMix {
        let last = self.rows.len() - 1;
        let above = self.rows.partition_point(|row| row.gradient <= magnitude || magnitude.is_nan());
        if above == 0 || above > last {
            let only = above.min(last);
            return RowMix { lower: only, upper: only, share: 0.0, slope: 0.0 };
        }
        let (from, to) = (self.rows[above - 1].gradient, self.rows[above].gradient);
        let slope = 1.0 / (to - from);
        let share = ((magnitude - from) * slope).clamp(0.0, 1.0);
        RowMix { lower: above - 1, upper: above, share, slope }
    }

    /// Returns extinction and emission at a value and a magnitude of the gradient. A transfer function without rows does not look at the
    /// magnitude.
    pub fn mixture(&self, value: f64, magnitude: f64) -> Mixture {
        if self.rows.is_empty() {
            return self.medium(value, 1.0);
        }
        let mut sum = Mixture::default();
        for (row, weight) in self.row_mix(magnitude).weights().into_iter().filter(|w| w.1 > 0.0) {
            let part = self.rows[row].transfer.medium(value, weight);
            sum.extinction += part.extinction;
            (0..3).for_each(|c| sum.emission[c] += part.emission[c]);
        }
        sum
    }

    /// Returns a share of extinction and emission at a value, by this function's own points.
    fn medium(&self, value: f64, share: f64) -> Mixture {
        let at = self.at(value);
        let extinction = share * self.extinction(at.opacity);
        let emission = if self.has_emission {
            at.emission.map(|e| e * share)
        } else {
            // A wall that shines nowhere: not ∞·0.
            at.color.map(|c| if c == 0.0 { 0.0 } else { c * extinction })
        };
        Mixture { extinction, emission }
    }
}

/// Cuts the segments of all rows at the values at which those of any end, so that the same index is the same range of values.
fn cut_alike(rows: &mut [TransferRow]) {
    let mut knots: Vec<f64> = rows.iter().flat_map(|row| row.transfer.points.iter().map(|p| p.value)).collect();
    knots.sort_by(f64::total_cmp);
    // −0 and 0 are one value.
    knots.dedup_by(|a, b| a == b);
    let ends: Vec<f64> =
        std::iter::once(f64::NEG_INFINITY).chain(knots.iter().copied()).chain([f64::INFINITY]).collect();
    for row in rows {
        let own = &row.transfer;
        let cut = |pair: &[f64]| {
            let (from, to) = (pair[0], pair[1]);
            let start = if from.is_finite() { own.at(from) } else { own.at_below(to) };
            let end = if to.is_finite() { own.at_below(to) } else { start };
            Segment { from, to, start, end }
        };
        row.transfer.segments = ends.windows(2).map(cut).collect();
    }
}

/// Points of the piecewise linear function that no row exceeds: at each knot the largest of all rows, on either side of it. Between two knots
/// each row is linear, so that none goes above the line between the largest ends.
fn upper_bound(rows: &[TransferRow]) -> Vec<ControlPoint> {
    let has_emission = rows[0].transfer.has_emission;
    let count = rows[0].transfer.segments.len();
    let largest = |value: f64, at: &dyn Fn(&TransferRow) -> super::Optical| {
        let mut point =
            ControlPoint { emission: has_emission.then_some([0.0; 3]), ..ControlPoint::new(value, [0.0; 3], 0.0) };
        for at in rows.iter().map(at) {
            point.opacity = point.opacity.max(at.opacity);
            point.color = std::array::from_fn(|c| point.color[c].max(at.color[c]));
            point.emission = point.emission.map(|e| std::array::from_fn(|c| e[c].max(at.emission[c])));
        }
        point
    };
    let mut points = Vec::with_capacity(2 * count);
    for i in 1..count {
        let value = rows[0].transfer.segments[i].from;
        let below = largest(value, &|row| row.transfer.segments[i - 1].end);
        let above = largest(value, &|row| row.transfer.segments[i].start);
        // A jump of one row may not show in the bound, and is a jump all the same.
        let jumps = rows.iter().any(|row| row.transfer.segments[i - 1].end != row.transfer.segments[i].start);
        points.push(below);
        if jumps {
            points.push(above);
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(value: f64, color: f64, opacity: f64) -> ControlPoint {
        ControlPoint::new(value, [color, 1.0, 0.0], opacity)
    }

    fn two(rule: OpacityRule) -> TransferFunction {
        let low = vec![point(0.0, 0.2, 0.0), point(10.0, 0.4, 0.5)];
        let high = vec![point(-5.0, 0.8, 0.9), point(5.0, 0.6, 0.9), point(5.0, 0.6, 0.1), point(20.0, 0.6, 0.1)];
        TransferFunction::of_rows(vec![(1.0, low), (3.0, high)], rule, 2.0).unwrap()
    }

    #[test]
    fn one_row_and_two_the_same_are_the_function_by_value() {
        let points = vec![point(0.0, 0.2, 0.0), point(10.0, 0.4, 0.5), point(10.0, 0.4, 0.9)];
        let one = TransferFunction::new(points.clone(), OpacityRule::Power, 2.0).unwrap();
        for rows in [vec![(0.0, points.clone())], vec![(1.0, points.clone()), (5.0, points.clone())]] {
            let rows = TransferFunction::of_rows(rows, OpacityRule::Power, 2.0).unwrap();
            assert_eq!((rows.points(), rows.segments()), (one.points(), one.segments()));
            for (value, magnitude) in [(-3.0, 0.0), (4.0, 1.7), (10.0, 3.0), (99.0, 7.0)] {
                let (step, expected) = (rows.mixture(value, magnitude).step(0.7), one.step(value, 0.7));
                assert!((0..4).all(|c| (step[c] - expected[c]).abs() < 4.0 * f64::EPSILON), "{step:?} {expected:?}");
            }
        }
    }

    #[test]
    fn between_rows_media_are_mixed() {
        for rule in [OpacityRule::Power, OpacityRule::Extinction] {
            let transfer = two(rule);
            for value in [-7.0, 0.0, 2.5, 5.0, 7.0, 30.0] {
                let medium = |row: usize| {
                    let own = &transfer.rows()[row].transfer;
                    let kappa = own.extinction_at(value);
                    (kappa, own.at(value).color[0] * kappa)
                };
                let ((k0, q0), (k1, q1)) = (medium(0), medium(1));
                for (magnitude, share) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.25), (3.0, 1.0), (9.0, 1.0)] {
                    let at = transfer.mixture(value, magnitude);
                    assert!((at.extinction - (k0 + share * (k1 - k0))).abs() < 1e-15, "{value} {magnitude}");
                    assert!((at.emission[0] - (q0 + share * (q1 - q0))).abs() < 1e-15, "{value} {magnitude}");
                }
            }
        }
    }

    #[test]
    fn bounds_are_above_every_row_and_clear_where_all_are() {
        let transfer = two(OpacityRule::Power);
        let knots: Vec<f64> = transfer.segments()[1..].iter().map(|s| s.from).collect();
        assert_eq!(knots, [-5.0, 0.0, 5.0, 10.0, 20.0]);
        for k in -100..250 {
            let value = 0.1 * f64::from(k);
            for row in transfer.rows() {
                assert_eq!(row.transfer.segments().len(), transfer.segments().len());
                let (own, bound) = (row.transfer.at(value), transfer.at(value));
                assert!(own.opacity <= bound.opacity + 1e-15 && own.color[0] <= bound.color[0] + 1e-15, "{value}");
            }
        }
        // A jump between two rows' maxima stays one, though the bound goes on.
        let flat = vec![point(0.0, 0.5, 0.5)];
        let jump = vec![point(0.0, 0.5, 0.1), point(0.0, 0.5, 0.2)];
        let transfer = TransferFunction::of_rows(vec![(0.0, flat), (1.0, jump)], OpacityRule::Power, 1.0).unwrap();
        assert_eq!(transfer.points().len(), 2);
        let clear = |v| vec![point(v, 0.5, 0.0)];
        let clear = TransferFunction::of_rows(vec![(0.0, clear(0.0)), (1.0, clear(3.0))], OpacityRule::Power, 1.0);
        assert!(clear.unwrap().segments().iter().all(Segment::is_clear));
    }

    #[test]
    fn refuses_rows_that_make_no_sense() {
        let p = |opacity| vec![point(0.0, 0.5, opacity)];
        let field = |rows| TransferFunction::of_rows(rows, OpacityRule::Power, 1.0).unwrap_err().field;
        assert_eq!(field(vec![]), "transfer.rows");
        assert_eq!(field(vec![(-1.0, p(0.1))]), "transfer.rows[0].gradient");
        assert_eq!(field(vec![(f64::NAN, p(0.1))]), "transfer.rows[0].gradient");
        assert_eq!(field(vec![(0.0, p(0.1)), (0.0, p(0.1))]), "transfer.rows[1].gradient");
        assert_eq!(field(vec![(0.0, p(0.1)), (1.0, vec![])]), "transfer.rows[1].points");
        assert_eq!(field(vec![(0.0, p(0.1)), (1.0, p(1.5))]), "transfer.rows[1].points[0].opacity");
        assert_eq!(field(vec![(0.0, p(1.0))]), "transfer.rows[0].points[0].opacity");
        assert!(TransferFunction::of_rows(vec![(0.0, p(1.0))], OpacityRule::Extinction, 1.0).is_ok());
        let shining = ControlPoint { emission: Some([1.0; 3]), ..point(0.0, 0.5, 0.1) };
        assert_eq!(field(vec![(0.0, p(0.1)), (1.0, vec![shining])]), "transfer.rows[1].points");
    }
}
