//! Fewer points for a curve: those that a straight line between its neighbours would miss by more than a tolerance (Douglas and
//! Peucker 1973, "Algorithms for the reduction of the number of points required to represent a digitized line or its caricature").

/// Numbers of the points that are kept, the first and the last among them. `at` gives the coordinates of a point, the first of which is
/// where it lies along the curve.
pub(crate) fn simplified<const N: usize>(count: usize, tolerance: f64, at: &impl Fn(usize) -> [f64; N]) -> Vec<usize> {
    let mut kept = vec![0];
    if count > 1 {
        divide(0, count - 1, tolerance, at, &mut kept);
    }
    kept
}

/// Adds what is kept behind `first`, up to `last`.
fn divide<const N: usize>(
    first: usize,
    last: usize,
    tolerance: f64,
    at: &impl Fn(usize) -> [f64; N],
    kept: &mut Vec<usize>,
) {
    let (a, b) = (at(first), at(last));
    let mut worst = (0.0, first);
    for i in first + 1..last {
        let p = at(i);
        let t = if b[0] > a[0] { (p[0] - a[0]) / (b[0] - a[0]) } else { 0.0 };
        let off = (1..N).map(|k| (p[k] - (a[k] + t * (b[k] - a[k]))).abs()).fold(0.0, f64::max);
        if off > worst.0 {
            worst = (off, i);
        }
    }
    if worst.0 > tolerance {
        divide(first, worst.1, tolerance, at, kept);
        divide(worst.1, last, tolerance, at, kept);
    } else {
        kept.push(last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_kept() {
        let hat = |i: usize| [i as f64, (5.0 - (i as f64 - 5.0).abs()) / 5.0];
        assert_eq!(simplified(11, 1e-9, &hat), [0, 5, 10]);
        assert_eq!(simplified(1, 1e-9, &hat), [0]);
    }
}
