//! Base plane: the plane that the rays start from, and the part of the volume that they pass.

use glam::DVec3;
use vr_core::{Clip, IndexRay, ParameterError, Placement, Ray, Rays, View};

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
    /// Pixels along u and v: those that the view interpolates between.
    pub(crate) size: [usize; 2],
    /// World direction of the rays.
    pub(crate) forward: DVec3,
    /// Half spaces of the clip, in u, v and t along the rays.
    kept: Vec<HalfSpace>,
    /// World distance from the plane through the eye to a pixel (u, v) of the base plane: at + along·(u, v, 0).
    before: HalfSpace,
    direction: DVec3,
}

/// Largest distance, in voxels, by which a ray may leave its row of voxels through rounding of its direction alone.
const ROUNDING: f64 = 1e-9;

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
        let depth = (dims[2] - 1) as f64;
        // A ray along an axis stays in its row: the rows in the faces of the box would be lost otherwise.
        let slope =
            [0, 1].map(|k| direction[axes[k]] / speed[w]).map(|s| if s.abs() * depth < ROUNDING { 0.0 } else { s });
        let drift = slope.map(|s| s * depth);
        // One more where that is between pixels, for the interpolation on the screen.
        let first = drift.map(|d| (-d.max(0.0)).floor() as i64);
        let size = [0, 1].map(|k| (dims[k] as i64 + (-drift[k].min(0.0)).ceil() as i64 - first[k]) as usize);
        let none = HalfSpace { at: 0.0, along: [0.0; 3] };
        let reversed = direction[w] < 0.0;
        let slice = 1.0 / speed[w];
        let mut plane =
            Self { axes, dims, reversed, slope, slice, first, size, forward, kept: vec![], before: none, direction };
        plane.before = plane.half_space(forward, forward.dot(view.camera.eye), placement);
        plane.kept = plane.kept_by(&view.clip, placement);
        plane.leave_out_unseen(view, placement)?;
        Ok(plane)
    }

    /// Leaves out the pixels that lie beyond the picture.
    fn leave_out_unseen(&mut self, view: &View, placement: &Placement) -> Result<(), ParameterError> {
        let rays = Rays::new(view)?;
        let [w, h] = view.size.map(f64::from);
        let corners = [[0.0, 0.0], [w, 0.0], [0.0, h], [w, h]].map(|[x, y]| self.meet(&rays.at(x, y), placement).0);
        for a in 0..2 {
            // `as` saturates, far beyond any volume. The nearest pixel may be one beside those between which a point lies.
            let low = corners.iter().map(|at| at[a]).fold(f64::INFINITY, f64::min).floor() as i64;
            let high = corners.iter().map(|at| at[a]).fold(f64::NEG_INFINITY, f64::max).ceil() as i64;
            let size = self.size[a] as i64;
            let (low, end) = (low.clamp(0, size), high.saturating_add(1).clamp(0, size));
            self.first[a] += low;
            self.size[a] = (end - low).max(0) as usize;
        }
        Ok(())
    }

    /// Returns the half spaces of the clip.
    fn kept_by(&self, clip: &Clip, placement: &Placement) -> Vec<HalfSpace> {
        let mut planes: Vec<(DVec3, f64)> = clip.planes.iter().map(|p| (p.normal, p.offset)).collect();
        if let Some((low, high)) = clip.crop {
            for axis in DVec3::AXES {
                planes.extend([(axis, axis.dot(low)), (-axis, -axis.dot(high))]);
            }
        }
        planes.into_iter().map(|(normal, offset)| self.half_space(normal, offset, placement)).collect()
    }

    /// Returns the world half space normal·x ≥ offset in u, v and t along the rays.
    fn half_space(&self, normal: DVec3, offset: f64, placement: &Placement) -> HalfSpace {
        let along = placement.axes().transpose() * normal;
        let [u, v, w] = self.axes.map(|a| along[a]);
        let per_slice = normal.dot(self.forward) * self.slice;
        HalfSpace { at: normal.dot(placement.origin()) - offset + w * self.face(), along: [u, v, per_slice] }
    }

    /// Returns the index along w of the face that looks at the eye.
    fn face(&self) -> f64 {
        if self.reversed { (self.dims[2] - 1) as f64 } else { 0.0 }
    }

    /// Returns the index along w of slice t.
    pub(crate) fn slice_index(&self, t: usize) -> usize {
        if self.reversed { self.dims[2] - 1 - t } else { t }
    }

    /// Returns the part of the ray of a pixel that lies in volume and clip, and before a world distance from the plane through the eye. Its
    /// distances are from the base plane. `None` where nothing of positive length is left.
    pub(crate) fn part(&self, pixel: [i64; 2], far: f64) -> Option<IndexRay> {
        let at = pixel.map(|i| i as f64);
        let offset = self.before.of(at);
        let depth = (self.dims[2] - 1) as f64 * self.slice;
        let (mut start, mut end) = ((-offset).max(0.0), depth.min(far - offset));
        // Keeps the distances at which x + slope·s is not negative.
        let mut keep = |x: f64, slope: f64| {
            if slope > 0.0 {
                start = start.max(-x / slope);
            } else if slope < 0.0 {
                end = end.min(-x / slope);
            } else if x < 0.0 {
                end = f64::NEG_INFINITY;
            }
        };
        for a in 0..2 {
            let slope = self.slope[a] / self.slice;
            keep(at[a], slope);
            keep((self.dims[a] - 1) as f64 - at[a], -slope);
        }
        self.kept.iter().for_each(|half| keep(half.of(at), half.along[2] / self.slice));
        let (origin, mut direction) = (self.place(pixel), DVec3::ZERO);
        let per_slice = [self.slope[0], self.slope[1], if self.reversed { -1.0 } else { 1.0 }];
        (0..3).for_each(|k| direction[self.axes[k]] = per_slice[k] / self.slice);
        (start < end).then_some(IndexRay { origin, direction, start, end, offset })
    }

    /// Returns the index-space position of the voxel so many index steps along u, v and w from a pixel, or of the nearest one inside.
    pub(crate) fn voxel(&self, pixel: [i64; 2], steps: [i64; 3]) -> [f64; 3] {
        let inside = |k: usize, i: i64| i.clamp(0, self.dims[k] as i64 - 1) as usize;
        let at =
            [inside(0, pixel[0] + steps[0]), inside(1, pixel[1] + steps[1]), self.slice_index(inside(2, steps[2]))];
        let mut voxel = [0.0; 3];
        (0..3).for_each(|k| voxel[self.axes[k]] = at[k] as f64);
        voxel
    }

    /// Returns the index-space position of a pixel, which may lie beyond the volume.
    pub(crate) fn place(&self, pixel: [i64; 2]) -> DVec3 {
        let mut at = DVec3::ZERO;
        (at[self.axes[0]], at[self.axes[1]], at[self.axes[2]]) = (pixel[0] as f64, pixel[1] as f64, self.face());
        at
    }

    /// Returns the point where a ray of the view meets the plane, in pixels from the first one, and its world distance.
    pub(crate) fn meet(&self, ray: &Ray, placement: &Placement) -> ([f64; 2], f64) {
        let origin = placement.to_index(ray.origin);
        let w = self.axes[2];
        let distance = (self.face() - origin[w]) / self.direction[w];
        let at = |k: usize| origin[self.axes[k]] + distance * self.direction[self.axes[k]] - self.first[k] as f64;
        ([at(0), at(1)], distance)
    }
}

impl HalfSpace {
    /// Value on the base plane.
    fn of(&self, [u, v]: [f64; 2]) -> f64 {
        self.at + self.along[0] * u + self.along[1] * v
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
                let part = IndexRay::new(&ray, &placement, [10, 6, 30], &view.clip, f64::INFINITY);
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
            }
        }
    }
}
