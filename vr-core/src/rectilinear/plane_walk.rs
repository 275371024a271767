//! Walk of a ray through the boxes between three families of planes.

use glam::DVec3;

/// Walk of a ray from box to box, as the planes between them are crossed: one plane at a time, so that no box is left out, and none comes twice.
#[derive(Clone, Debug)]
pub(super) struct PlaneWalk {
    axes: [AxisWalk; 3],
    at: f64,
    end: f64,
}

/// Part of a ray in one box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BoxPart {
    /// Distance at which the ray enters the box.
    pub(super) from: f64,
    /// Distance at which it leaves it.
    pub(super) to: f64,
    /// Number of the box along each axis.
    pub(super) number: [usize; 3],
}

#[derive(Clone, Copy, Debug)]
struct AxisWalk {
    origin: f64,
    /// Distance per world unit along the axis.
    per_unit: f64,
    /// Number of the box that the ray is in.
    number: usize,
    /// Distance at which the ray leaves it.
    leaves: f64,
}

impl AxisWalk {
    /// Sets the distance of the plane by which the ray leaves the box; infinite where there is no further box.
    #[inline]
    fn look_ahead(&mut self, planes: &[f64]) {
        let (plane, is_last) = match self.per_unit > 0.0 {
            true => (self.number + 1, self.number + 2 >= planes.len()),
            false => (self.number, self.number == 0),
        };
        // A ray along the planes, and one so nearly so that no plane is near, leaves by none.
        let is_parallel = !self.per_unit.is_finite();
        self.leaves =
            if is_last || is_parallel { f64::INFINITY } else { (planes[plane] - self.origin) * self.per_unit };
    }
}

impl PlaneWalk {
    /// Begins at a distance of a ray, in the boxes of these numbers between planes that rise, and goes on to another distance.
    #[inline]
    pub(super) fn new(
        planes: [&[f64]; 3],
        [origin, direction]: [DVec3; 2],
        [from, to]: [f64; 2],
        number: [usize; 3],
    ) -> Self {
        let axes = std::array::from_fn(|a| {
            let per_unit = 1.0 / direction[a];
            let mut axis = AxisWalk { origin: origin[a], per_unit, number: number[a], leaves: f64::INFINITY };
            axis.look_ahead(planes[a]);
            axis
        });
        Self { axes, at: from, end: to }
    }

    /// Returns the next part, which has a length; the planes must be those that the walk began with.
    #[inline]
    pub(super) fn next(&mut self, planes: [&[f64]; 3]) -> Option<BoxPart> {
        while self.at < self.end {
            let [x, y, z] = self.axes.each_ref().map(|axis| axis.leaves);
            let axis = if x <= y && x <= z { 0 } else { 1 + usize::from(z < y) };
            let to = self.axes[axis].leaves.min(self.end);
            let number = self.axes.each_ref().map(|axis| axis.number);
            let walk = &mut self.axes[axis];
            if walk.leaves < self.end {
                walk.number = if walk.per_unit > 0.0 { walk.number + 1 } else { walk.number - 1 };
                walk.look_ahead(planes[axis]);
            }
            if to > self.at {
                let from = std::mem::replace(&mut self.at, to);
                return Some(BoxPart { from, to, number });
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn walked(direction: DVec3, [from, to]: [f64; 2], number: [usize; 3]) -> Vec<BoxPart> {
        let planes = [0.0, 1.0, 3.0, 3.5];
        let planes = [&planes[..]; 3];
        let origin = DVec3::new(0.5, 0.25, 3.25);
        let mut walk = PlaneWalk::new(planes, [origin, direction], [from, to], number);
        std::iter::from_fn(|| walk.next(planes)).collect()
    }

    #[test]
    fn boxes_are_those_between_the_planes() {
        let part = |from, to, number| BoxPart { from, to, number };
        let along = walked(DVec3::X, [0.0, 3.0], [0, 0, 2]);
        assert_eq!(along, [part(0.0, 0.5, [0, 0, 2]), part(0.5, 2.5, [1, 0, 2]), part(2.5, 3.0, [2, 0, 2])]);
        let across = walked(DVec3::new(1.0, 1.0, -1.0), [0.0, 4.0], [0, 0, 2]);
        let want = [
            part(0.0, 0.25, [0, 0, 2]),
            part(0.25, 0.5, [0, 0, 1]),
            part(0.5, 0.75, [1, 0, 1]),
            part(0.75, 2.25, [1, 1, 1]),
            part(2.25, 2.5, [1, 1, 0]),
            part(2.5, 2.75, [2, 1, 0]),
            // Beyond the last plane it stays where it is.
            part(2.75, 4.0, [2, 2, 0]),
        ];
        assert_eq!(across, want);
    }

    #[test]
    fn directions_that_are_nearly_nothing_cross_nothing() {
        let along = walked(DVec3::new(1e-320, -0.0, 1e-300), [0.0, 3.0], [0, 0, 2]);
        assert_eq!(along, [BoxPart { from: 0.0, to: 3.0, number: [0, 0, 2] }]);
    }
}
