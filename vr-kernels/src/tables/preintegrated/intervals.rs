//! Into how many intervals a table is cut.

/// How many intervals to make: the number between half of `most` and `most` for which most knots are ends of intervals. And whether all
/// are.
pub(super) fn find_intervals(knots: &[f64], low: f64, high: f64, most: usize) -> (usize, bool) {
    if high <= low {
        return (1, true);
    }
    let inner: Vec<f64> = knots.iter().filter(|&&k| k > low && k < high).map(|k| (k - low) / (high - low)).collect();
    let missed = |n: usize| {
        let off = |&&x: &&f64| (x * n as f64 - libm::round(x * n as f64)).abs() > ALIGNED;
        inner.iter().filter(off).count()
    };
    let best = (most / 2..=most).rev().map(|n| (missed(n), n)).min_by_key(|&(m, _)| m);
    best.map_or((most, false), |(m, n)| (n, m == 0))
}

/// How far, in intervals, a knot may be from the end of one and still counts as there: the places of f32 values are known to 10⁻³.
pub(super) const ALIGNED: f64 = 1e-6;

/// A table may be so many times longer than the field needs, if its intervals then fit the knots.
pub(super) const MOST_EXCESS: f64 = 4.0;
