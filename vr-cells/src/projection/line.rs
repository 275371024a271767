//! Linear functions on the screen.

use super::screen_mesh::area;

/// The function `a x + b y + c`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
}

impl Line {
    /// A function that is the same everywhere.
    pub(super) fn constant(c: f64) -> Self {
        Self { a: 0.0, b: 0.0, c }
    }

    /// Twice the area of the triangle of two places and a third, which it is a function of. Swapping the two changes the sign and no digit.
    pub(super) fn edge([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> Self {
        let (a, b) = (ay - by, bx - ax);
        Self { a, b, c: -(a * ax + b * ay) }
    }

    /// The function that has given values at three places, of which twice the area is known and not 0.
    pub(super) fn through(at: [[f64; 2]; 3], values: [f64; 3], twice_area: f64) -> Self {
        let [p, q, r] = at;
        let (dq, dr) = (values[1] - values[0], values[2] - values[0]);
        let a = (dq * (r[1] - p[1]) - dr * (q[1] - p[1])) / twice_area;
        let b = (dr * (q[0] - p[0]) - dq * (r[0] - p[0])) / twice_area;
        Self { a, b, c: values[0] - a * p[0] - b * p[1] }
    }

    pub(super) fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.a * x + self.b * y + self.c
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self { a: self.a * factor, b: self.b * factor, c: self.c * factor }
    }

    /// True if places where it is 0 count as positive: for an edge or for the same edge turned around, never for both.
    pub(super) fn owns_zero(&self) -> bool {
        self.a > 0.0 || (self.a == 0.0 && self.b > 0.0)
    }

    /// True if a value of it counts as positive.
    pub(super) fn is_positive(&self, value: f64) -> bool {
        value > 0.0 || (value == 0.0 && self.owns_zero())
    }
}

/// Calls `visit` with the samples in a triangle, of those before `size` in both axes, and the shares of the corners there. Of two triangles that share an edge
/// one has the samples on it.
pub(super) fn samples_in(mut corners: [[f64; 2]; 3], size: [u32; 2], visit: &mut dyn FnMut([u32; 2], [f64; 3])) {
    let mut twice_area = area(corners);
    let is_turned = twice_area < 0.0;
    if is_turned {
        corners.swap(1, 2);
        twice_area = -twice_area;
    }
    if !twice_area.is_finite() || twice_area == 0.0 {
        return;
    }
    let [a, b, c] = corners;
    let lines = [Line::edge(b, c), Line::edge(c, a), Line::edge(a, b)];
    let range = |axis: usize| {
        let low = a[axis].min(b[axis]).min(c[axis]);
        let high = a[axis].max(b[axis]).max(c[axis]);
        let first = (low - 0.5).ceil().max(0.0) as u32;
        let last = (high + 0.5).floor().clamp(0.0, f64::from(size[axis])) as u32;
        first..last
    };
    for y in range(1) {
        for x in range(0) {
            let at = [f64::from(x) + 0.5, f64::from(y) + 0.5];
            let values = lines.map(|line| line.at(at));
            if (0..3).all(|i| lines[i].is_positive(values[i])) {
                let [u, v, w] = values.map(|value| value / twice_area);
                visit([x, y], if is_turned { [u, w, v] } else { [u, v, w] });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_around_a_place_share_its_samples() {
        // A fan around a sample's centre, with corners on others.
        let middle = [4.5, 4.5];
        let rim = [[0.5, 0.5], [8.5, 0.5], [8.5, 8.5], [4.5, 8.5], [0.5, 8.5]];
        let mut hits = [[0; 9]; 9];
        for i in 0..rim.len() {
            let corners = [rim[i], middle, rim[(i + 1) % rim.len()]];
            samples_in(corners, [9; 2], &mut |[x, y], shares| {
                hits[y as usize][x as usize] += 1;
                let back: f64 = (0..3).map(|k| shares[k] * corners[k][0]).sum();
                assert!((back - f64::from(x) - 0.5).abs() < 1e-12);
            });
        }
        for y in 1..8 {
            assert!((1..8).all(|x| hits[y][x] == 1), "{hits:?}");
        }
    }
}
