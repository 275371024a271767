//! Rays: the one function, in f64, from which all renderers and the reference take theirs.

use glam::{DMat3, DVec3};

use crate::camera::Projection;
use crate::error::ParameterError;
use crate::placement::Placement;
use crate::view::{Clip, View};

/// A ray in the world: `origin + s · direction`, s ≥ 0 in world units.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Clip, Plane, Ray};
///
/// let ray = Ray { origin: DVec3::ZERO, direction: DVec3::Z };
/// let clip = Clip { planes: vec![Plane { normal: DVec3::Z, offset: 2.0 }], ..Clip::default() };
/// assert_eq!(ray.inside(&clip), Some([2.0, f64::INFINITY]));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Position at which it starts.
    pub origin: DVec3,
    /// Unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// The first and the last distance at which the ray is inside the clip, ends included; `None` where it never is.
    pub fn inside(&self, clip: &Clip) -> Option<[f64; 2]> {
        let mut part = Interval { start: 0.0, end: f64::INFINITY };
        part.clip(clip, self.origin, self.direction);
        (part.start <= part.end).then_some([part.start, part.end])
    }
}

/// The rays of a view.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Camera, Rays, View};
///
/// let camera = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 0.0, 0.0, None);
/// let rays = Rays::new(&View::new(camera, [3, 3]))?;
/// // Through the centre of the pixel in the middle, and of the one on its right.
/// assert_eq!(rays.at(1.5, 1.5).origin, camera.eye);
/// assert!(rays.at(2.5, 1.5).origin.x > camera.eye.x);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rays {
    eye: DVec3,
    frame: DMat3,
    projection: Projection,
    size: [u32; 2],
    /// World size of a pixel: on the plane through the eye, or at distance 1 in perspective.
    pixel: f64,
}

impl Rays {
    /// The rays of a view.
    ///
    /// # Errors
    /// Same as for [`View::validate`].
    pub fn new(view: &View) -> Result<Self, ParameterError> {
        view.validate()?;
        let frame = view.camera.frame()?;
        let pixel = view.camera.projection.height() / f64::from(view.size[1]);
        Ok(Self { eye: view.camera.eye, frame, projection: view.camera.projection, size: view.size, pixel })
    }

    /// The ray through a point of the image, in pixels from its top left corner: pixel (i, j) has its centre at (i + ½, j + ½).
    pub fn at(&self, x: f64, y: f64) -> Ray {
        let right = (x - 0.5 * f64::from(self.size[0])) * self.pixel;
        let up = (0.5 * f64::from(self.size[1]) - y) * self.pixel;
        let offset = self.frame.x_axis * right + self.frame.y_axis * up;
        match self.projection {
            Projection::Orthographic { .. } => Ray { origin: self.eye + offset, direction: self.frame.z_axis },
            Projection::Perspective { .. } => {
                Ray { origin: self.eye, direction: (self.frame.z_axis + offset).normalize() }
            }
        }
    }
}

/// `N` rays, component by component, for vector code.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Camera, Rays, View};
///
/// let camera = Camera::framing((DVec3::NEG_ONE, DVec3::ONE), 30.0, 20.0, Some(30.0));
/// let rays = Rays::new(&View::new(camera, [64, 64]))?;
/// let packet = rays.packet(&[0.5, 1.5, 2.5, 3.5], &[0.5; 4]);
/// let third = rays.at(2.5, 0.5);
/// assert_eq!(packet.direction.map(|component| component[2]), third.direction.to_array());
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayPacket<const N: usize> {
    /// x, y and z of the positions at which the rays start.
    pub origin: [[f64; N]; 3],
    /// x, y and z of their unit vectors.
    pub direction: [[f64; N]; 3],
}

impl Rays {
    /// The rays through `N` points of the image at once: the same bits as from [`Rays::at`].
    #[inline(always)]
    pub fn packet<const N: usize>(&self, x: &[f64; N], y: &[f64; N]) -> RayPacket<N> {
        let [eye, to_right, to_up, ahead] =
            [self.eye, self.frame.x_axis, self.frame.y_axis, self.frame.z_axis].map(|v| v.to_array());
        let (middle_x, middle_y) = (0.5 * f64::from(self.size[0]), 0.5 * f64::from(self.size[1]));
        let mut offset = [[0.0; N]; 3];
        for axis in 0..3 {
            for i in 0..N {
                let right = (x[i] - middle_x) * self.pixel;
                let up = (middle_y - y[i]) * self.pixel;
                offset[axis][i] = to_right[axis] * right + to_up[axis] * up;
            }
        }
        let (mut origin, mut direction) = ([[0.0; N]; 3], [[0.0; N]; 3]);
        match self.projection {
            Projection::Orthographic { .. } => {
                for axis in 0..3 {
                    for i in 0..N {
                        origin[axis][i] = eye[axis] + offset[axis][i];
                        direction[axis][i] = ahead[axis];
                    }
                }
            }
            Projection::Perspective { .. } => {
                for i in 0..N {
                    let d: [f64; 3] = std::array::from_fn(|axis| ahead[axis] + offset[axis][i]);
                    let length_recip = 1.0 / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                    for axis in 0..3 {
                        origin[axis][i] = eye[axis];
                        direction[axis][i] = d[axis] * length_recip;
                    }
                }
            }
        }
        RayPacket { origin, direction }
    }
}

/// The part of a ray inside a uniform grid's box and the clip, in index space.
///
/// The origin is moved along the ray to the point nearest the middle of the box, so that indices stay small numbers and keep
/// their precision however far the eye or the world's origin may be. Distances stay world distances.
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::{Clip, IndexRay, Placement, Ray};
///
/// let placement = Placement::from_spacing([1.0, 1.0, 2.0])?;
/// let ray = Ray { origin: DVec3::new(0.5, 0.5, -10.0), direction: DVec3::Z };
/// let inside = IndexRay::new(&ray, &placement, [2, 2, 3], &Clip::default(), f64::INFINITY).expect("it meets the box");
/// assert_eq!(inside.length(), 4.0, "in world units");
/// assert_eq!(inside.at(inside.end), DVec3::new(0.5, 0.5, 2.0), "in voxels");
/// # Ok::<(), vr_core::GridError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndexRay {
    /// Index-space position at s = 0.
    pub origin: DVec3,
    /// Index steps per world unit of s.
    pub direction: DVec3,
    /// Distance at which the ray enters.
    pub start: f64,
    /// Distance at which it leaves; above `start`.
    pub end: f64,
    /// World distance from the ray's own origin to s = 0.
    pub offset: f64,
}

impl IndexRay {
    /// Cuts a ray by the box of a grid, the clip, and at the world distance `far` (an opaque layer, say); `None` where nothing
    /// of positive length is left.
    pub fn new(ray: &Ray, placement: &Placement, dims: [usize; 3], clip: &Clip, far: f64) -> Option<Self> {
        let last = DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let to_middle = placement.origin() - ray.origin + placement.axes() * (0.5 * last);
        let offset = to_middle.dot(ray.direction);
        let base = (ray.origin - placement.origin()) + ray.direction * offset;
        let origin = placement.inverse_axes() * base;
        let direction = placement.inverse_axes() * ray.direction;
        let mut part = Interval { start: -offset, end: far - offset };
        for a in 0..3 {
            part.keep_between(origin[a], direction[a], 0.0, last[a]);
        }
        let world = ray.origin + ray.direction * offset;
        part.clip(clip, world, ray.direction);
        (part.start < part.end).then_some(Self { origin, direction, start: part.start, end: part.end, offset })
    }

    /// Length of the part, in world units.
    pub fn length(&self) -> f64 {
        self.end - self.start
    }

    /// Index-space position at a distance.
    pub fn at(&self, s: f64) -> DVec3 {
        self.origin + self.direction * s
    }
}

struct Interval {
    start: f64,
    end: f64,
}

impl Interval {
    /// Keeps the s for which `origin + s·direction` is inside the clip.
    fn clip(&mut self, clip: &Clip, origin: DVec3, direction: DVec3) {
        if let Some((low, high)) = clip.crop {
            for a in 0..3 {
                self.keep_between(origin[a], direction[a], low[a], high[a]);
            }
        }
        for plane in &clip.planes {
            let (at, slope) = (plane.normal.dot(origin) - plane.offset, plane.normal.dot(direction));
            self.keep_between(at, slope, 0.0, f64::INFINITY);
        }
    }

    /// Keeps the s with low ≤ x + s·slope ≤ high.
    fn keep_between(&mut self, x: f64, slope: f64, low: f64, high: f64) {
        if slope == 0.0 {
            // Parallel: all or nothing. 0/0 would be NaN.
            if !(low <= x && x <= high) {
                self.end = f64::NEG_INFINITY;
            }
            return;
        }
        let (a, b) = ((low - x) / slope, (high - x) / slope);
        self.start = self.start.max(a.min(b));
        self.end = self.end.min(a.max(b));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Camera;

    fn unit_box() -> Placement {
        Placement::from_spacing([1.0; 3]).unwrap()
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> Ray {
        Ray { origin: origin.into(), direction: DVec3::from(direction).normalize() }
    }

    #[test]
    fn chord_is_the_box() {
        let r = IndexRay::new(
            &ray([2.0, 2.0, 50.0], [0.0, 0.0, -1.0]),
            &unit_box(),
            [5; 3],
            &Clip::default(),
            f64::INFINITY,
        );
        let r = r.unwrap();
        assert_eq!(r.length(), 4.0);
        assert_eq!(r.at(r.start), DVec3::new(2.0, 2.0, 4.0));
        assert_eq!(r.start + r.offset, 46.0);
    }

    #[test]
    fn starts_at_the_eye_inside_and_ends_at_the_layer() {
        let inside = ray([2.0, 2.0, 2.0], [0.0, 0.0, -1.0]);
        let r = IndexRay::new(&inside, &unit_box(), [5; 3], &Clip::default(), 1.5).unwrap();
        assert_eq!((r.start + r.offset, r.end + r.offset), (0.0, 1.5));
    }

    #[test]
    fn rays_in_a_face_count_and_beyond_it_do_not() {
        let at = |x: f64| {
            IndexRay::new(&ray([x, 2.0, 50.0], [0.0, 0.0, -1.0]), &unit_box(), [5; 3], &Clip::default(), f64::INFINITY)
        };
        assert!(at(4.0).is_some() && at(0.0).is_some());
        assert!(at(4.0f64.next_up()).is_none() && at(-1e-300).is_none());
    }

    #[test]
    fn crop_and_planes_cut() {
        let clip = Clip {
            crop: Some((DVec3::new(0.0, 0.0, 1.0), DVec3::new(4.0, 4.0, 3.5))),
            planes: vec![crate::view::Plane { normal: DVec3::new(0.0, 0.0, 2.0), offset: 5.0 }],
        };
        let r = IndexRay::new(&ray([2.0, 2.0, 50.0], [0.0, 0.0, -1.0]), &unit_box(), [5; 3], &clip, f64::INFINITY);
        let r = r.unwrap();
        assert_eq!((r.at(r.start).z, r.at(r.end).z), (3.5, 2.5));
    }

    #[test]
    fn packets_are_the_same_rays() {
        for projection in [Projection::Orthographic { height: 3.0 }, Projection::Perspective { fov: 50.0 }] {
            let camera =
                Camera { eye: DVec3::new(3.0, -5.0, 7.0), target: DVec3::new(0.1, 0.2, 0.3), up: DVec3::Y, projection };
            let rays = Rays::new(&View::new(camera, [7, 5])).unwrap();
            let (x, y) = ([0.5, 1.5, 6.5, 3.25], [0.5, 4.5, 2.5, 3.75]);
            let packet = rays.packet(&x, &y);
            for i in 0..4 {
                let one = rays.at(x[i], y[i]);
                assert_eq!(packet.origin.map(|a| a[i]), one.origin.to_array());
                assert_eq!(packet.direction.map(|a| a[i]), one.direction.to_array());
            }
        }
    }

    #[test]
    fn a_ray_is_inside_the_clip_between_its_faces() {
        let along = ray([1.0, 1.0, 9.0], [0.0, 0.0, -2.0]);
        assert_eq!(along.inside(&Clip::default()), Some([0.0, f64::INFINITY]));
        let crop = Some((DVec3::ZERO, DVec3::splat(4.0)));
        let plane = |offset| vec![crate::view::Plane { normal: DVec3::Z * 2.0, offset }];
        assert_eq!(along.inside(&Clip { crop, planes: vec![] }), Some([5.0, 9.0]));
        assert_eq!(along.inside(&Clip { crop, planes: plane(3.0) }), Some([5.0, 7.5]));
        assert_eq!(along.inside(&Clip { crop, planes: plane(8.0) }), Some([5.0, 5.0]), "a point is something");
        assert_eq!(along.inside(&Clip { crop, planes: plane(9.0) }), None);
        assert_eq!(ray([5.0, 1.0, 9.0], [0.0, 0.0, -1.0]).inside(&Clip { crop, planes: vec![] }), None);
    }

    #[test]
    fn row_zero_is_the_top_and_right_is_forward_cross_up() {
        let camera = Camera {
            eye: DVec3::new(0.0, 0.0, 10.0),
            target: DVec3::ZERO,
            up: DVec3::Y,
            projection: Projection::Orthographic { height: 4.0 },
        };
        let rays = Rays::new(&View::new(camera, [8, 4])).unwrap();
        let corner = rays.at(0.5, 0.5);
        assert_eq!(corner.origin, DVec3::new(-3.5, 1.5, 10.0));
        assert_eq!(corner.direction, DVec3::NEG_Z);
    }
}
