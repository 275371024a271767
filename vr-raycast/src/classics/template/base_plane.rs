//! Base plane: the plane that the rays start from, and the part of the volume that they pass.

use glam::DVec3;
use vr_core::{Clip, ParameterError, Placement, Ray, View};

/// Parallel rays through the voxels of the volume's face that looks at the eye most.
///
/// With w the axis of the volume along which a ray goes on fastest and u, v the two others, the ray of pixel (i, j) is at
/// (i + t·slope_u, j + t·slope_v) in slice t, counted from the face on. All rays step alike: where one ray's samples are, and between
/// which voxels, is the template of all.
#[derive(Clone, Debug)]
pub(crate) struct BasePlane {
    /// Index axes of u, v and w.
    pub(crate) axes: [usize; 3],
    /// Samples along u, v and w.
    pub(crate) dims: [usize; 3],
    /// True if slices are met from the last one on.
    pub(crate) reversed: bool,
    /// Steps along u and v per slice; between −1 and 1.
    pub(crate) slope: [f64; 2],
    /// World length of a ray's way from one slice to the next.
    pub(crate) slice: f64,
    /// First pixel along u and v; below 0 where rays enter by other faces.
    pub(crate) first: [i64; 2],
    /// Pixels along u and v.
    pub(crate) size: [usize; 2],
    /// Half spaces that bound the part of the volume that is kept, in u, v and t along the rays.
    kept: Vec<HalfSpace>,
    direction: DVec3,
}

/// Half space of the points where at + along·(i, j, t) is not negative.
#[derive(Clone, Copy, Debug)]
struct HalfSpace {
    at: f64,
    along: [f64; 3],
}

impl BasePlane {
    /// Makes the base plane of a grid for an orthographic view.
    ///
    /// # Errors
    /// Same as for [`vr_core::Camera::frame`].
    pub(crate) fn new(view: &View, placement: &Placement, samples: [usize; 3]) -> Result<Self, ParameterError> {
        let forward = view.camera.frame()?.z_axis;
        let direction = placement.inverse_axes() * forward;
        let speed = direction.abs();
        let w = if speed.x >= speed.y && speed.x >= speed.z {
            0
        } else if speed.y >= speed.z {
            1
        } else {
            2
        };
        let axes = [usize::from(w == 0), if w == 2 { 1 } else { 2 }, w];
        let dims = axes.map(|a| samples[a]);
        let slope = [0, 1].map(|k| direction[axes[k]] / speed[w]);
        let depth = (dims[2] - 1) as f64;
        let drift = slope.map(|s| s * depth);
        // One more where that is between pixels, for the interpolation on the screen.
        let first = drift.map(|d| (-d.max(0.0)).floor() as i64);
        let size = [0, 1].map(|k| (dims[k] as i64 + (-drift[k].min(0.0)).ceil() as i64 - first[k]) as usize);
        let mut plane = Self {
            axes,
            dims,
            reversed: direction[w] < 0.0,
            slope,
            slice: 1.0 / speed[w],
            first,
            size,
            kept: Vec::new(),
            direction,
        };
        plane.kept = plane.kept_by(&view.clip, view.camera.eye, forward, placement);
        Ok(plane)
    }

    /// Returns the half spaces of the clip, and that before the eye.
    fn kept_by(&self, clip: &Clip, eye: DVec3, forward: DVec3, placement: &Placement) -> Vec<HalfSpace> {
        let mut planes = vec![(forward, forward.dot(eye))];
        planes.extend(clip.planes.iter().map(|p| (p.normal, p.offset)));
        if let Some((low, high)) = clip.crop {
            for axis in DVec3::AXES {
                planes.extend([(axis, axis.dot(low)), (-axis, -axis.dot(high))]);
            }
        }
        let in_index = |(normal, offset): (DVec3, f64)| {
            let along = placement.axes().transpose() * normal;
            let [u, v, w] = self.axes.map(|a| along[a]);
            let face = if self.reversed { (self.dims[2] - 1) as f64 } else { 0.0 };
            let forward = if self.reversed { -w } else { w };
            let per_slice = u * self.slope[0] + v * self.slope[1] + forward;
            HalfSpace { at: normal.dot(placement.origin()) - offset + w * face, along: [u, v, per_slice] }
        };
        planes.into_iter().map(in_index).collect()
    }

    /// Returns the index along w of slice t.
    pub(crate) fn slice_index(&self, t: usize) -> usize {
        if self.reversed { self.dims[2] - 1 - t } else { t }
    }

    /// Returns the pixels of a row whose rays are inside volume and clip at `t`, where they have moved by `moved`.
    pub(crate) fn pixels_inside(&self, row: i64, t: f64, moved: [f64; 2]) -> std::ops::Range<i64> {
        let v = row as f64 + moved[1];
        if !(0.0..=(self.dims[1] - 1) as f64).contains(&v) {
            return 0..0;
        }
        let (mut low, mut high) = (-moved[0], (self.dims[0] - 1) as f64 - moved[0]);
        for half in &self.kept {
            let rest = half.at + half.along[1] * row as f64 + half.along[2] * t;
            let bound = -rest / half.along[0];
            match half.along[0] {
                0.0 if rest < 0.0 => return 0..0,
                0.0 => {}
                slope if slope > 0.0 => low = low.max(bound),
                _ => high = high.min(bound),
            }
        }
        let first = low.ceil().max(self.first[0] as f64) as i64;
        let last = high.floor().min((self.first[0] + self.size[0] as i64) as f64) as i64;
        first..(last + 1).max(first)
    }

    /// Returns the point where a ray of the view meets the plane, in pixels from the first one, and its world distance.
    pub(crate) fn meet(&self, ray: &Ray, placement: &Placement) -> ([f64; 2], f64) {
        let origin = placement.to_index(ray.origin);
        let w = self.axes[2];
        let face = if self.reversed { (self.dims[2] - 1) as f64 } else { 0.0 };
        let distance = (face - origin[w]) / self.direction[w];
        let at = |k: usize| origin[self.axes[k]] + distance * self.direction[self.axes[k]] - self.first[k] as f64;
        ([at(0), at(1)], distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Camera, Projection, Rays};

    fn looking_along(direction: [f64; 3]) -> View {
        let eye = DVec3::new(4.0, 5.0, 6.0) - 50.0 * DVec3::from(direction).normalize();
        let target = DVec3::new(4.0, 5.0, 6.0);
        let up = DVec3::new(0.1, 0.9, 0.3);
        View::new(Camera { eye, target, up, projection: Projection::Orthographic { height: 20.0 } }, [16, 16])
    }

    #[test]
    fn the_face_that_looks_at_the_eye_and_the_way_from_it() {
        let placement = Placement::from_spacing([1.0, 2.0, 0.5]).unwrap();
        let plane = |d| BasePlane::new(&looking_along(d), &placement, [10, 6, 30]).unwrap();
        // In index steps: (1, 0.1, 0.8), (0.2, −1, 0), (0, 0.5, 2).
        for (d, axes, reversed) in [
            ([1.0, 0.2, 0.4], [1, 2, 0], false),
            ([0.4, -4.0, 0.0], [0, 2, 1], true),
            ([0.0, 1.0, 1.0], [0, 1, 2], false),
        ] {
            let p = plane(d);
            assert_eq!((p.axes, p.reversed), (axes, reversed));
            assert!(p.slope.iter().all(|s| s.abs() <= 1.0));
        }
    }

    #[test]
    fn every_ray_that_meets_the_volume_meets_the_plane_in_its_pixels() {
        let placement = Placement::from_spacing([1.0, 2.0, 0.5]).unwrap();
        for d in [[1.0, 0.2, 0.4], [-0.4, 3.0, 0.1], [0.3, 0.5, -0.2], [-1.0, -1.0, -1.0]] {
            let view = looking_along(d);
            let plane = BasePlane::new(&view, &placement, [10, 6, 30]).unwrap();
            let rays = Rays::new(&view).unwrap();
            for k in 0..1600 {
                let ray = rays.at(f64::from(k % 40) * 0.4, f64::from(k / 40) * 0.4);
                let part = vr_core::IndexRay::new(&ray, &placement, [10, 6, 30], &view.clip, f64::INFINITY);
                let Some(part) = part else { continue };
                let (at, distance) = plane.meet(&ray, &placement);
                for a in 0..2 {
                    assert!(at[a] >= -1e-9 && at[a] <= (plane.size[a] - 1) as f64 + 1e-9, "{at:?} {:?}", plane.size);
                }
                // The point half way is where the plane's own geometry has it, and inside.
                let middle = 0.5 * (part.start + part.end) + part.offset;
                let index = placement.to_index(ray.origin + ray.direction * middle);
                let t = (middle - distance) / plane.slice;
                for a in 0..2 {
                    let u = at[a] + plane.first[a] as f64 + t * plane.slope[a];
                    assert!((u - index[plane.axes[a]]).abs() < 1e-9);
                }
                let row = at[1].round() as i64 + plane.first[1];
                let moved = plane.slope.map(|s| s * t);
                let inside = plane.pixels_inside(row, t, moved);
                for i in inside {
                    assert!((-1e-9..=(plane.dims[0] - 1) as f64 + 1e-9).contains(&(i as f64 + moved[0])));
                }
            }
        }
    }
}
