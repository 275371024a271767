//! Directions that a gradient may have on a part of a cell.

/// Gradients at the samples of a cell, of which those in it are means.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corners {
    /// World gradients by component, then by sample, x fastest.
    pub(super) world: [[f64; 8]; 3],
    /// Bounds of what each of them is off by.
    pub(super) off: [f64; 8],
    /// Fractions of the cell, per axis, at which the ray enters and leaves, and what they are off by.
    pub(super) part: [[f64; 2]; 3],
    pub(super) misplaced: f64,
}

/// Cone that holds the directions of a gradient: that of up to eight unit vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    edges: [[f64; 3]; 8],
    count: usize,
    /// Bound of what a component of an edge is off by.
    off: f64,
    /// Lower bound of the length of any mean of the edges.
    shortest: f64,
}

/// Smallest length of a mean of a cone's edges. Wider cones say little.
const MIN_LENGTH: f64 = 0.2;
/// Largest error of an edge.
const MAX_OFF: f64 = 0.05;

impl Corners {
    /// Returns the cone on the part [from, to] of the way through the cell, 0 to 1; `None` where it would be too wide.
    ///
    /// The part lies in a box, which is widened by what positions are off by. In a box, a trilinear function is a mean of its values at the corners, and
    /// those are means of the cell's: no weight is below 0. So the gradient lies in the cone of the eight, however small it is.
    pub(super) fn cone(&self, [from, to]: [f64; 2]) -> Option<Cone> {
        let room = 2.0 * self.misplaced + 4.0 * f64::EPSILON;
        let sides = self.part.map(|[enters, leaves]| {
            let ends = [from, to].map(|t| (1.0 - t) * enters + t * leaves);
            [(ends[0].min(ends[1]) - room).max(0.0), (ends[0].max(ends[1]) + room).min(1.0)]
        });
        let within = |values: &[f64; 8]| {
            let mut values = *values;
            for (axis, [low, high]) in sides.into_iter().enumerate() {
                for i in (0..8).filter(|i| i >> axis & 1 == 0) {
                    let (a, b) = (values[i], values[i | 1 << axis]);
                    // Products of what is known to the last bit: nothing is lost where one side is 0.
                    values[i] = (1.0 - low) * a + low * b;
                    values[i | 1 << axis] = (1.0 - high) * a + high * b;
                }
            }
            values
        };
        let (world, off) = (self.world.each_ref().map(within), within(&self.off));
        let mut cone = Cone { edges: [[0.0; 3]; 8], count: 0, off: 0.0, shortest: 0.0 };
        let mut sum = [0.0; 3];
        for i in 0..8 {
            let g = [world[0][i], world[1][i], world[2][i]];
            let length = dot(&g, &g).sqrt();
            if length == 0.0 && off[i] == 0.0 {
                continue;
            }
            // A unit vector is off by twice what its vector is, relative to its length.
            let relative = 4.0 * off[i] / length;
            // Also false where the square of a length is no number.
            if !(relative <= MAX_OFF && length > 1e-140 && length < 1e140) {
                return None;
            }
            cone.off = cone.off.max(relative + 8.0 * f64::EPSILON);
            let edge = g.map(|x| x / length);
            sum = std::array::from_fn(|a| sum[a] + edge[a]);
            cone.edges[cone.count] = edge;
            cone.count += 1;
        }
        // A mean of the edges is at least as long as the shortest of their shadows on any direction.
        let length = dot(&sum, &sum).sqrt();
        if length < MIN_LENGTH {
            return None;
        }
        let shadow = |edge: &[f64; 3]| dot(edge, &sum) / length;
        cone.shortest = cone.edges[..cone.count].iter().map(shadow).fold(1.0, f64::min) - 2.0 * cone.off;
        (cone.shortest >= MIN_LENGTH).then_some(cone)
    }
}

impl Cone {
    /// Returns bounds of |n·v| for a unit vector v, n being any direction in the cone.
    pub(super) fn cosine(&self, v: &[f64; 3]) -> [f64; 2] {
        let edges = self.edges[..self.count].iter().map(|edge| dot(edge, v));
        let (low, high) = edges.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let (low, high) = (low - 2.0 * self.off, high + 2.0 * self.off);
        // The direction is a mean of the edges over its length, which is `shortest` to 1.
        let low = if low < 0.0 { low / self.shortest } else { low };
        let high = if high > 0.0 { high / self.shortest } else { high };
        let farthest = low.abs().max(high.abs()).min(1.0);
        if low > 0.0 {
            [low.min(1.0), farthest]
        } else if high < 0.0 {
            [(-high).min(1.0), farthest]
        } else {
            [0.0, farthest]
        }
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns the gradient at fractions of the cell.
    fn at(corners: &Corners, place: [f64; 3]) -> [f64; 3] {
        let weight =
            |i: usize| (0..3).map(|a| if i >> a & 1 == 1 { place[a] } else { 1.0 - place[a] }).product::<f64>();
        corners.world.map(|values| (0..8).map(|i| weight(i) * values[i]).sum())
    }

    fn strategy() -> impl Strategy<Value = Corners> {
        let component = prop_oneof![3 => Just(0.0), 1 => -1.0f64..1.0];
        let values = prop::array::uniform8(component);
        let end = || prop_oneof![1 => Just(0.0), 1 => Just(1.0), 2 => 0.0f64..1.0];
        let side = [end(), end()];
        (prop::array::uniform3(values), [side.clone(), side.clone(), side]).prop_map(|(world, part)| Corners {
            world,
            off: [0.0; 8],
            part,
            misplaced: 1e-13,
        })
    }

    proptest! {
        /// The cone holds the directions along the part, down to where the gradient is lost in rounding.
        #[test]
        fn holds_the_directions(corners in strategy(), ends in [0.0f64..1.0, 0.0f64..1.0], v in prop::array::uniform3(-1.0f64..1.0)) {
            let [from, to] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let length = dot(&v, &v).sqrt();
            prop_assume!(length > 0.1);
            let v = v.map(|x| x / length);
            for part in [[0.0, to], [from, to], [from, 1.0], [0.0, 1.0]] {
                let Some(cone) = corners.cone(part) else { continue };
                let [low, high] = cone.cosine(&v);
                for k in 0..=32 {
                    let t = part[0] + (part[1] - part[0]) * f64::from(k) / 32.0;
                    let g = at(&corners, corners.part.map(|[a, b]| (1.0 - t) * a + t * b));
                    let size = dot(&g, &g).sqrt();
                    if size > 1e-9 {
                        let x = dot(&g, &v).abs() / size;
                        prop_assert!(low - 1e-7 <= x && x <= high + 1e-7, "{x} not in {low} to {high}");
                    }
                }
            }
        }
    }

    #[test]
    fn one_gradient_alone_has_one_direction() {
        let mut world = [[0.0; 8]; 3];
        world[1][7] = -2.0;
        let corners = Corners { world, off: [0.0; 8], part: [[0.0, 0.5], [0.1, 0.2], [0.7, 0.3]], misplaced: 1e-13 };
        let [low, high] = corners.cone([0.0, 1.0]).unwrap().cosine(&[0.0, 0.6, 0.8]);
        assert!((low - 0.6).abs() < 1e-12 && (high - 0.6).abs() < 1e-12, "{low} {high}");
    }

    #[test]
    fn beside_a_face_without_gradients_a_cone_narrows() {
        // Gradients of two directions on the face that the ray goes away to.
        let mut world = [[0.0; 8]; 3];
        (world[0][1], world[1][3], world[2][7]) = (1.0, 1.0, 1.0);
        let corners = Corners { world, off: [0.0; 8], part: [[0.0, 1.0], [0.4, 0.5], [0.4, 0.5]], misplaced: 1e-13 };
        let width = |to: f64| {
            let [low, high] = corners.cone([0.0, to]).unwrap().cosine(&[0.0, 0.6, 0.8]);
            high - low
        };
        assert!(width(0.1) < 0.2 * width(1.0) && width(0.01) < 0.02 * width(1.0), "{} {}", width(0.1), width(1.0));
    }

    #[test]
    fn gradients_that_face_each_other_have_no_cone() {
        let mut world = [[0.0; 8]; 3];
        (world[0][0], world[0][7]) = (1.0, -1.0);
        let corners = Corners { world, off: [0.0; 8], part: [[0.0, 1.0]; 3], misplaced: 1e-13 };
        assert!(corners.cone([0.0, 1.0]).is_none() && corners.cone([0.3, 0.7]).is_none());
        // As far as the first outweighs the second all over the box, they have one.
        assert_eq!(corners.cone([0.0, 0.3]).unwrap().cosine(&[1.0, 0.0, 0.0])[1], 1.0);
    }
}
