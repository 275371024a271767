//! The part of a volume that a view shows, in index space: a box, cut by half spaces.

use glam::DVec3;
use vr_core::{Placement, Projection, RenderError, View};

use crate::capabilities::last_sample;

/// Half space of index space: all p with `normal`·p ≥ `offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HalfSpace {
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
}

impl HalfSpace {
    /// Converts the half space `normal`·x ≥ `offset` of the world.
    fn of_world(placement: &Placement, normal: DVec3, offset: f64) -> Self {
        Self { normal: placement.axes().transpose() * normal, offset: offset - normal.dot(placement.origin()) }
    }

    /// Minimum and maximum of `normal`·p − `offset` over a box.
    fn range(&self, [low, high]: [DVec3; 2]) -> [f64; 2] {
        let (a, b) = (self.normal * low, self.normal * high);
        [a.min(b).element_sum() - self.offset, a.max(b).element_sum() - self.offset]
    }
}

/// The part of a volume that a view shows; never empty.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
    /// Half spaces that cut the box; those that hold all of it are left out.
    pub(crate) planes: Vec<HalfSpace>,
}

impl Region {
    /// Computes the part of a volume of `dims` samples that a view shows; `None` if it shows nothing.
    ///
    /// # Errors
    /// [`RenderError::Parameter`] if the camera has no direction.
    pub(crate) fn of(view: &View, placement: &Placement, dims: [usize; 3]) -> Result<Option<Self>, RenderError> {
        let mut region = Self { low: DVec3::ZERO, high: last_sample(dims), planes: Vec::new() };
        let mut planes = Vec::new();
        if let Some((low, high)) = view.clip.crop {
            let inverse = placement.inverse_axes();
            let straight = |axis: DVec3| axis.to_array().iter().filter(|&&c| c != 0.0).count() == 1;
            if [inverse.x_axis, inverse.y_axis, inverse.z_axis].into_iter().all(straight) {
                // Parallel to the volume's axes: a smaller box.
                let (a, b) = (inverse * (low - placement.origin()), inverse * (high - placement.origin()));
                (region.low, region.high) = (a.min(b).max(region.low), a.max(b).min(region.high));
            } else {
                for axis in 0..3 {
                    planes.push(HalfSpace::of_world(placement, DVec3::AXES[axis], low[axis]));
                    planes.push(HalfSpace::of_world(placement, -DVec3::AXES[axis], -high[axis]));
                }
            }
        }
        planes.extend(view.clip.planes.iter().map(|p| HalfSpace::of_world(placement, p.normal, p.offset)));
        if let Projection::Orthographic { .. } = view.camera.projection {
            // Parallel rays start at the plane through the eye. In perspective slices do that: they start at the eye.
            let ahead = view.camera.frame()?.z_axis;
            planes.push(HalfSpace::of_world(placement, ahead, ahead.dot(view.camera.eye)));
        }
        for plane in planes {
            let [min, max] = plane.range([region.low, region.high]);
            if max < 0.0 {
                return Ok(None);
            }
            if min < 0.0 {
                region.planes.push(plane);
            }
        }
        Ok(region.low.cmplt(region.high).all().then_some(region))
    }

    /// Lower and upper corner of the box.
    pub(crate) fn corners(&self) -> [DVec3; 2] {
        [self.low, self.high]
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;
    use vr_core::{Camera, Plane};

    use super::*;

    fn view(projection: Projection) -> View {
        let camera =
            Camera { eye: DVec3::new(1.0, 2.0, -5.0), target: DVec3::new(1.0, 2.0, 9.0), up: DVec3::Y, projection };
        View::new(camera, [8, 8])
    }

    #[test]
    fn only_what_cuts_the_box_is_kept() {
        let placement =
            Placement::new(DVec3::new(-1.0, 0.0, 2.0), DMat3::from_diagonal(DVec3::new(0.5, 2.0, 1.0))).unwrap();
        let of = |view: &View| Region::of(view, &placement, [9, 5, 7]).unwrap();
        let mut parallel = view(Projection::Orthographic { height: 4.0 });
        assert!(of(&parallel).unwrap().planes.is_empty());
        // Eye and target inside: what is behind the eye is cut away, unless in perspective, where no ray goes there.
        parallel.camera.eye.z = 4.0;
        let seen = of(&parallel).unwrap();
        assert_eq!(seen.corners(), [DVec3::ZERO, DVec3::new(8.0, 4.0, 6.0)]);
        assert_eq!(seen.planes, [HalfSpace { normal: DVec3::Z, offset: 2.0 }]);
        let mut perspective = view(Projection::Perspective { fov: 40.0 });
        perspective.camera.eye.z = 4.0;
        assert!(of(&perspective).unwrap().planes.is_empty());
        // Behind everything.
        parallel.camera.eye.z = 8.5;
        assert!(of(&parallel).is_none());
    }

    #[test]
    fn a_turned_crop_box_and_clip_planes_are_half_spaces() {
        let mut view = view(Projection::Orthographic { height: 4.0 });
        let straight = Placement::from_spacing([1.0; 3]).unwrap();
        let turned = Placement::oriented(DVec3::ZERO, [1.0; 3], DMat3::from_rotation_z(0.3)).unwrap();
        view.clip.crop = Some((DVec3::new(1.0, 1.5, 1.0), DVec3::new(3.0, 3.0, 90.0)));
        let region = Region::of(&view, &straight, [9, 9, 9]).unwrap().unwrap();
        assert_eq!(
            (region.corners(), region.planes.len()),
            ([DVec3::new(1.0, 1.5, 1.0), DVec3::new(3.0, 3.0, 8.0)], 0)
        );
        // Five faces of the crop box cut the volume.
        assert_eq!(Region::of(&view, &turned, [9, 9, 9]).unwrap().unwrap().planes.len(), 5);
        view.clip.planes.push(Plane { normal: DVec3::new(-2.0, 0.0, 0.0), offset: -4.0 });
        let region = Region::of(&view, &straight, [9, 9, 9]).unwrap().unwrap();
        assert_eq!(region.planes, [HalfSpace { normal: DVec3::new(-2.0, 0.0, 0.0), offset: -4.0 }]);
        view.clip.planes.push(Plane { normal: DVec3::X, offset: 4.5 });
        assert!(Region::of(&view, &straight, [9, 9, 9]).unwrap().is_none());
    }
}
