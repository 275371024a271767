//! Colour of a value that was picked of a ray, with a bound on its error.

use vr_core::bound::{Bound, largest};
use vr_core::field::{FieldLine, LineColor, Poly};

use crate::crossings::crossings;
use crate::value_operators::{Stretch, rounding};

/// Colour by which that of the transfer function is multiplied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PickedColor {
    /// Linear light of red, green and blue, between 0 and 1.
    pub rgb: [f64; 3],
    /// Upper bound of the error of each channel.
    pub error: f64,
}

impl PickedColor {
    /// The colour of places that have none of their own.
    pub const WHITE: Self = Self { rgb: [1.0; 3], error: 0.0 };

    /// The colour at a place of a stretch, where the place is off by at most `off`, in units of half the stretch.
    pub(crate) fn at(color: &LineColor, t: f64, off: Bound) -> Self {
        let drift = |p: &Poly| {
            let slope = p.derivative();
            let steepest = Bound::new(slope.at(0.0)) + slope.spread(1.0);
            let moved = if steepest == Bound::ZERO || off == Bound::ZERO { Bound::ZERO } else { steepest * off };
            moved.min(1.0) + rounding(p)
        };
        let error = color.channels.iter().map(drift).fold(Bound::ZERO, Bound::max) + color.error;
        Self { rgb: color.at(t), error: error.value() }
    }

    /// The colour at the place of an extreme, found at `t` in the stretch `index`; `sign` is 1 for a largest value and −1 for a smallest. Every
    /// other place at which the field comes within the error of the extreme may be the true one.
    pub(crate) fn of_extreme(
        line: &dyn FieldLine,
        stretches: &[Stretch],
        (index, t): (usize, f64),
        (sign, value, error): (f64, f64, Bound),
    ) -> Self {
        let Some(color) = line.color(stretches[index].from, stretches[index].to) else { return Self::WHITE };
        let picked = Self::at(&color, t, Bound::ZERO);
        let exact = |s: &Stretch| s.model.field.is_constant() && s.doubt() == Bound::ZERO;
        // A value that is known exactly, which none behind it equals: of equals the nearest is taken.
        let near = |s: &Stretch| sign * s.model.field.at(0.0) >= sign * value - (error * 2.0).value();
        let surely = stretches.iter().position(|s| exact(s) && near(s));
        let mut apart = Bound::new(picked.error);
        for (i, stretch) in stretches.iter().enumerate() {
            let (p, doubt) = (&stretch.model.field, stretch.doubt());
            let limit = sign * value - (error * 2.0 + doubt * 2.0).value();
            if sign * p.coefficients()[0] + p.spread(1.0) < limit {
                continue;
            }
            if let Some(first) = surely.filter(|&first| first < i) {
                let level = stretches[first].model.field.at(0.0);
                let [low, high] =
                    if exact(stretch) { [p.at(0.0); 2] } else { stretch.model.limits.unwrap_or(UNLIMITED) };
                let exceeds = if sign > 0.0 { high > level } else { low < level };
                if !exceeds {
                    continue;
                }
            }
            let Some(color) = line.color(stretch.from, stretch.to) else { return Self::WHITE };
            let parts = if exact(stretch) { vec![[-1.0; 2]] } else { parts_beyond(p, sign, limit) };
            for [a, b] in parts {
                let part = color.restricted(a, b);
                let far =
                    (0..3).map(|c| (part.channels[c].at(0.0) - picked.rgb[c]).abs() + part.channels[c].spread(1.0));
                apart = apart.max(Bound::new(largest(far)) + color.error);
            }
        }
        Self { error: apart.min(1.0).value(), ..picked }
    }

    /// The mean colour of the parts of a line that are not vacuum.
    pub(crate) fn mean(line: &dyn FieldLine, stretches: &[Stretch]) -> Self {
        let (mut sums, mut length, mut doubt) = ([0.0; 3], 0.0, Bound::ZERO);
        for Stretch { from, to, misplaced, .. } in stretches {
            let Some(color) = line.color(*from, *to) else { return Self::WHITE };
            let half = 0.5 * (to - from);
            for (sum, channel) in sums.iter_mut().zip(&color.channels) {
                *sum += half * channel.integral();
            }
            length += to - from;
            let rounded = largest(color.channels.iter().map(rounding));
            doubt += (Bound::new(color.error) + rounded) * (to - from);
            // Twice: of the integral and, times the mean, of the length.
            let off = misplaced[0] + misplaced[1] + 2.0 * f64::EPSILON * from.abs().max(to.abs());
            doubt += off * 2.0;
        }
        let sums_rounded = 2.0 * f64::EPSILON * stretches.len() as f64;
        let error = (doubt / length + sums_rounded).min(1.0);
        Self { rgb: sums.map(|sum| sum / length), error: error.value() }
    }
}

/// Limits of a stretch of which none are known.
const UNLIMITED: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// Parts of [−1, 1] in which a polynomial times `sign` is at least `limit`, a little wider for what roots are off by.
fn parts_beyond(p: &Poly, sign: f64, limit: f64) -> Vec<[f64; 2]> {
    const WIDER: f64 = 1e-6;
    let mut ends = vec![-1.0, 1.0];
    crossings(p, &[sign * limit], &mut ends);
    ends.sort_by(f64::total_cmp);
    let beyond = |w: &&[f64]| w[1] > w[0] && sign * p.at(0.5 * (w[0] + w[1])) >= limit;
    ends.windows(2).filter(beyond).map(|w| [w[0] - WIDER, w[1] + WIDER]).collect()
}
