//! Piecewise linear curves over a value, with jumps; and how other curves become one.

/// Points in ascending order; two at one value are a jump. Constant outside.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Polyline<const N: usize>(pub Vec<(f64, [f64; N])>);

impl<const N: usize> Polyline<N> {
    /// First and last value.
    pub fn range(&self) -> (f64, f64) {
        let value = |p: Option<&(f64, [f64; N])>| p.map_or(0.0, |p| p.0);
        (value(self.0.first()), value(self.0.last()))
    }

    /// The limit from below.
    pub fn below(&self, x: f64) -> [f64; N] {
        self.at(x, self.0.partition_point(|p| p.0 < x))
    }

    /// The limit from above.
    pub fn above(&self, x: f64) -> [f64; N] {
        self.at(x, self.0.partition_point(|p| p.0 <= x))
    }

    /// Value on the piece that ends with point `i`.
    fn at(&self, x: f64, i: usize) -> [f64; N] {
        let Some(&(x1, b)) = self.0.get(i) else { return self.0.last().map_or([0.0; N], |p| p.1) };
        let Some(&(x0, a)) = i.checked_sub(1).and_then(|i| self.0.get(i)) else { return b };
        if x == x0 {
            a
        } else if x == x1 {
            b
        } else {
            lerp(a, b, (x - x0) / (x1 - x0))
        }
    }
}

fn lerp<const N: usize>(a: [f64; N], b: [f64; N], t: f64) -> [f64; N] {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

/// Appends what follows a curve from `x0` (where the line is to stand already) to `x1`, as straight pieces that do not
/// `differ` from it. `at` takes the fraction of the way.
pub(super) fn resample<const N: usize>(
    x0: f64,
    x1: f64,
    at: impl Fn(f64) -> [f64; N],
    differ: fn([f64; N], [f64; N]) -> bool,
    line: &mut Vec<(f64, [f64; N])>,
) {
    /// 2¹⁰ pieces: enough for the steep beginning of the sRGB curve, and few enough to bake.
    const DEEPEST: u32 = 10;
    // Pieces yet to do, the next one last.
    let mut pieces = vec![(0.0, 1.0, 0)];
    while let Some((t0, t1, depth)) = pieces.pop() {
        let (a, b) = (at(t0), at(t1));
        let bent = [0.25, 0.5, 0.75].iter().any(|&s| differ(lerp(a, b, s), at(t0 + s * (t1 - t0))));
        if bent && depth < DEEPEST {
            let middle = 0.5 * (t0 + t1);
            pieces.push((middle, t1, depth + 1));
            pieces.push((t0, middle, depth + 1));
        } else {
            let x = if t1 == 1.0 { x1 } else { x0 + t1 * (x1 - x0) };
            line.push((x, b));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_have_two_sides() {
        let p = Polyline(vec![(0.0, [0.0]), (1.0, [1.0]), (1.0, [5.0]), (2.0, [6.0])]);
        assert_eq!((p.below(1.0), p.above(1.0)), ([1.0], [5.0]));
        assert_eq!((p.below(0.5), p.above(1.5)), ([0.5], [5.5]));
        assert_eq!((p.below(-1.0), p.above(9.0)), ([0.0], [6.0]));
    }

    #[test]
    fn straight_lines_need_no_more_points() {
        let differ = |a: [f64; 1], b: [f64; 1]| (a[0] - b[0]).abs() > 1e-3;
        let mut line = vec![(2.0, [0.0])];
        resample(2.0, 4.0, |t| [3.0 * t], differ, &mut line);
        assert_eq!(line, [(2.0, [0.0]), (4.0, [3.0])]);
        resample(4.0, 5.0, |t| [3.0 + t * t], differ, &mut line);
        assert!((10..40).contains(&line.len()));
        let p = Polyline(line);
        assert!((p.below(4.3)[0] - 3.09).abs() < 2e-3);
    }
}
