//! Positions of a view's slices, and the slabs into which they cut a ray.

use glam::DVec3;
use vr_core::{ParameterError, Placement, Projection, View};

use crate::texture_slicer::{Proxy, TextureSlicer};

/// The slices of a view, numbered by a coordinate u that grows along rays: slice k is where u = k, and its slab is where |u − k| ≤ ½.
///
/// Whatever slices are, u grows linearly along each ray. So a ray is cut at equal distances, which differ from ray to ray where slices are planes and
/// rays are not parallel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slices {
    kind: Kind,
    /// World distance of two neighbours, at a right angle to them.
    pub(crate) distance: f64,
    /// True if that is corrected for the angle between a ray and the slices.
    correction: bool,
    /// World length of a whole slab; `None`: it differs from ray to ray.
    length: Option<f64>,
    /// ½ where slabs are to end on slices, 0 where slices are in the middle of them.
    shift: f64,
}

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// u = gradient · (index − middle).
    Planes { gradient: DVec3, middle: DVec3 },
    /// u = (distance − radius) / distance of two.
    Shells { radius: f64 },
    /// u = ± index along the axis · slices to a layer.
    Stack { axis: usize, per_layer: f64 },
}

impl Slices {
    /// The slices that a renderer takes for a view of a grid. `on_faces`: a fragment needs the values at both ends of its slab.
    ///
    /// Planes are counted from the middle of the grid's box, and so are shells: the picture does not depend on how far away the eye is.
    ///
    /// # Errors
    /// A camera that makes no sense.
    pub(crate) fn new(
        renderer: &TextureSlicer,
        view: &View,
        placement: &Placement,
        dims: [usize; 3],
        on_faces: bool,
    ) -> Result<Self, ParameterError> {
        let forward = view.camera.frame()?.z_axis;
        let perspective = matches!(view.camera.projection, Projection::Perspective { .. });
        let distance = renderer.slice_spacing * placement.spacing().min_element();
        let middle = 0.5 * DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let gradient = placement.axes().transpose() * forward;
        let (kind, distance) = match renderer.proxy {
            Proxy::Shells if perspective => {
                let radius = (placement.origin() - view.camera.eye + placement.axes() * middle).length();
                (Kind::Shells { radius }, distance)
            }
            Proxy::Planes | Proxy::Shells => (Kind::Planes { gradient: gradient / distance, middle }, distance),
            Proxy::Stacks => {
                let axis = stack_axis(forward, placement);
                let per_layer = f64::from(renderer.per_layer());
                let row = placement.inverse_axes().transpose().col(axis);
                (Kind::Stack { axis, per_layer }, 1.0 / (row.length() * per_layer))
            }
        };
        let shift = if on_faces && matches!(kind, Kind::Stack { .. }) { 0.5 } else { 0.0 };
        let mut slices = Self { kind, distance, correction: renderer.correction, length: Some(distance), shift };
        if slices.correction && !matches!(kind, Kind::Shells { .. }) {
            let ahead = (placement.inverse_axes() * forward).to_array();
            // Light in a stack is that of slabs met at a right angle, whatever the view: so it is not made anew for each.
            let keeps_light = renderer.holds_light() && matches!(kind, Kind::Stack { .. });
            let even = !perspective && !keeps_light;
            slices.length = even.then(|| 1.0 / slices.coordinate([0.0; 3], ahead, 0.0)[1]);
        }
        Ok(slices)
    }

    /// The axis of a stack.
    pub(crate) fn axis(&self) -> Option<usize> {
        match self.kind {
            Kind::Stack { axis, .. } => Some(axis),
            _ => None,
        }
    }

    /// World length of a slab for which tables are made: that of all whole ones, if they are equally long.
    pub(crate) fn table_length(&self) -> f64 {
        self.length.unwrap_or(self.distance)
    }

    /// True if whole slabs are equally long along all rays, as far as opacity goes.
    pub(crate) fn are_even(&self) -> bool {
        self.length.is_some()
    }

    /// u at s = 0 of a ray, and what it grows by per world unit: at least 0. `origin` and `direction` are in index space, `offset` is the world distance
    /// from the eye to s = 0.
    #[inline(always)]
    pub(crate) fn coordinate(&self, origin: [f64; 3], direction: [f64; 3], offset: f64) -> [f64; 2] {
        let [at, slope] = match self.kind {
            Kind::Planes { gradient: g, middle: m } => [
                g.x * (origin[0] - m.x) + g.y * (origin[1] - m.y) + g.z * (origin[2] - m.z),
                g.x * direction[0] + g.y * direction[1] + g.z * direction[2],
            ],
            Kind::Shells { radius } => [(offset - radius) / self.distance, 1.0 / self.distance],
            Kind::Stack { axis, per_layer } => [origin[axis] * per_layer, direction[axis] * per_layer],
        };
        let sign = if slope < 0.0 { -1.0 } else { 1.0 };
        [sign * at - self.shift, sign * slope]
    }

    /// True for rays along which a stack's index falls: they meet its layers in the other order.
    pub(crate) fn fall_along(&self, direction: [f64; 3]) -> bool {
        matches!(self.kind, Kind::Stack { axis, .. } if direction[axis] < 0.0)
    }

    /// u of points of the world, gradient · point − offset, for rays along which a stack's index falls or does not; `None` where slices are no planes.
    pub(crate) fn linear(&self, falling: bool, placement: &Placement) -> Option<(DVec3, f64)> {
        let (gradient, at) = match self.kind {
            Kind::Planes { gradient, middle } => (gradient, gradient.dot(middle)),
            Kind::Shells { .. } => return None,
            Kind::Stack { axis, per_layer } => (DVec3::AXES[axis] * if falling { -per_layer } else { per_layer }, 0.0),
        };
        let world = placement.inverse_axes().transpose() * gradient;
        Some((world, world.dot(placement.origin()) + at + self.shift))
    }

    /// Radius of the shell numbered 0; `None` where slices are planes.
    pub(crate) fn radius(&self) -> Option<f64> {
        match self.kind {
            Kind::Shells { radius } => Some(radius),
            _ => None,
        }
    }

    /// Length that counts for a fragment's opacity, of a length of its ray, in table lengths. `slope`: of u along the ray.
    #[inline(always)]
    pub(crate) fn ratio(&self, length: f64, slope: f64) -> f64 {
        let counted = if self.correction { length } else { length * slope * self.distance };
        counted / self.table_length()
    }
}

/// The axis whose layers the view crosses most often.
fn stack_axis(forward: DVec3, placement: &Placement) -> usize {
    let along = (placement.inverse_axes() * forward).abs().to_array();
    // Of equals the first, whatever rounding says.
    (0..3).rev().reduce(|best, a| if along[a] >= along[best] * (1.0 - 1e-12) { a } else { best }).unwrap_or(0)
}

/// The slabs of one ray: from number `first` to `last`, cut off at where the ray enters and leaves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slabs {
    pub(crate) first: f64,
    pub(crate) last: f64,
    at: f64,
    pub(crate) slope: f64,
    start: f64,
    end: f64,
}

impl Slabs {
    /// Slabs of a ray with the given coordinate ([`Slices::coordinate`]), from distance `start` to `end`.
    #[inline(always)]
    pub(crate) fn new([at, slope]: [f64; 2], start: f64, end: f64) -> Self {
        let first = (at + slope * start + 0.5).floor();
        let last = (at + slope * end - 0.5).ceil();
        Self { first, last: if last > first { last } else { first }, at, slope, start, end }
    }

    /// Number of the slab in the middle: samples are counted from it.
    #[inline(always)]
    pub(crate) fn middle(&self) -> f64 {
        (0.5 * (self.first + self.last)).floor()
    }

    /// Distance at which the coordinate is `u`, which must lie within the ray where it goes through more than one slab.
    #[inline(always)]
    pub(crate) fn distance_of(&self, u: f64) -> f64 {
        let s = (u - self.at) / self.slope;
        // Rounding; NaN where a ray goes along its only slab.
        let s = if s > self.start { s } else { self.start };
        if s < self.end { s } else { self.end }
    }

    /// Distance at which the first slab ends.
    #[inline(always)]
    pub(crate) fn first_end(&self) -> f64 {
        if self.first == self.last { self.end } else { self.distance_of(self.first + 0.5) }
    }

    /// Distance at which the last slab begins.
    #[inline(always)]
    pub(crate) fn last_begin(&self) -> f64 {
        if self.first == self.last { self.start } else { self.distance_of(self.last - 0.5) }
    }

    /// Begin and end of a slab by its number.
    pub(crate) fn part(&self, number: f64) -> [f64; 2] {
        let begin = if number == self.first { self.start } else { self.distance_of(number - 0.5) };
        let end = if number == self.last { self.end } else { self.distance_of(number + 0.5) };
        [begin, end]
    }

    /// Number of slabs.
    pub(crate) fn count(&self) -> u64 {
        (self.last - self.first) as u64 + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_are_all_of_a_ray() {
        for (at, slope, start, end) in [
            (0.3, 2.0, -1.7, 4.1),
            (0.0, 1.0, 0.5, 2.5),
            (5.2, 0.0, -1.0, 1.0),
            (0.1, 1e-3, 0.0, 3.0),
            (-7.5, 3.0, 0.0, 1.0),
        ] {
            let slabs = Slabs::new([at, slope], start, end);
            let mut reached = start;
            for k in 0..slabs.count() {
                let [begin, end] = slabs.part(slabs.first + k as f64);
                assert!(begin == reached && end >= begin, "{at} {slope}");
                assert!((end - begin) * slope <= 1.0 + 1e-12);
                reached = end;
            }
            assert_eq!(reached, end);
            let whole = slabs.part(slabs.first);
            assert_eq!([whole[1], slabs.part(slabs.last)[0]], [slabs.first_end(), slabs.last_begin()]);
        }
    }
}
