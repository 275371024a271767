//! Number of intervals of a table, so that knots of the transfer function fall onto their ends.

/// Number of intervals to make: the one between half of `max` and `max` for which the fewest knots lie inside of intervals. And whether
/// none does.
pub(super) fn find_intervals(knots: &[f64], low: f64, high: f64, max: usize) -> (usize, bool) {
    if high <= low {
        return (1, true);
    }
    let inner: Vec<f64> = knots.iter().filter(|&&k| k > low && k < high).map(|k| (k - low) / (high - low)).collect();
    let missed = |n: usize| {
        let off = |&&x: &&f64| (x * n as f64 - libm::round(x * n as f64)).abs() > ALIGNED;
        inner.iter().filter(off).count()
    };
    let best = (max / 2..=max).rev().map(|n| (missed(n), n)).min_by_key(|&(m, _)| m);
    best.map_or((max, false), |(m, n)| (n, m == 0))
}

/// Largest distance, in intervals, of a knot from the end of one that still counts as there: the places of f32 values are known to 10⁻³.
pub(super) const ALIGNED: f64 = 1e-6;

/// Largest factor by which a table may be longer than the field needs, if its intervals then fit the knots.
pub(super) const MAX_EXCESS: f64 = 4.0;
