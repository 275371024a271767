//! Rays as a scene's numbers define them, in double-double, and bounds on the errors of the f64 that they are rounded to.
//!
//! `vr_core::Rays` gives renderers the same rays in f64. Far from the volume, or where axes are nearly parallel, its rounding moves a
//! ray by much more than the rounding of an index; the reference follows the ray that was meant.

use glam::DMat3;
use vr_core::{Clip, IndexRay, ParameterError, Placement, Projection, Ray, View};

use crate::double::{Double, Double3, power_of_two_below};
use vr_core::bound::Bound;

/// A world ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactRay {
    pub(crate) origin: Double3,
    /// Unit vector.
    pub(crate) direction: Double3,
}

impl From<&Ray> for ExactRay {
    /// The ray of just these numbers.
    fn from(ray: &Ray) -> Self {
        Self { origin: ray.origin.into(), direction: Double3::from(ray.direction) }
    }
}

/// The rays of a view.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactRays {
    eye: Double3,
    right: Double3,
    up: Double3,
    ahead: Double3,
    /// World size of a pixel, as in `vr_core::Rays`.
    pixel: Double,
    parallel: bool,
    size: [u32; 2],
    supersampling: f64,
}

impl ExactRays {
    /// # Errors
    /// Same as for [`vr_core::Rays::new`].
    pub(crate) fn new(view: &View) -> Result<Self, ParameterError> {
        view.validate()?;
        view.camera.frame()?;
        let camera = &view.camera;
        let eye = Double3::from(camera.eye);
        let ahead = (Double3::from(camera.target) - eye).normalized();
        let right = ahead.cross(Double3::from(camera.up).normalized()).normalized();
        let (parallel, height) = match camera.projection {
            Projection::Orthographic { height } => (true, Double::from(height)),
            Projection::Perspective { fov } => {
                let (sin, cos) = Double::radians(fov).scaled(0.5).sin_cos();
                (false, (sin / cos).scaled(2.0))
            }
        };
        Ok(Self {
            eye,
            right,
            up: right.cross(ahead),
            ahead,
            pixel: height / Double::from(f64::from(view.size[1])),
            parallel,
            size: view.size,
            supersampling: f64::from(view.supersampling),
        })
    }

    /// The ray through a point of the image, in pixels from its top left corner: the centre of a pixel, or of a subpixel.
    pub(crate) fn at(&self, x: f64, y: f64) -> ExactRay {
        let right = (self.exact(x) - Double::from(0.5 * f64::from(self.size[0]))) * self.pixel;
        let up = (Double::from(0.5 * f64::from(self.size[1])) - self.exact(y)) * self.pixel;
        let offset = self.right * right + self.up * up;
        if self.parallel {
            ExactRay { origin: self.eye + offset, direction: self.ahead }
        } else {
            ExactRay { origin: self.eye, direction: (self.ahead + offset).normalized() }
        }
    }

    /// A subpixel's centre before it was rounded: an odd number of half subpixels.
    fn exact(&self, x: f64) -> Double {
        let halves = 2.0 * self.supersampling * x;
        let nearest = halves.round();
        if (halves - nearest).abs() < 1e-6 {
            Double::from(nearest) / Double::from(2.0 * self.supersampling)
        } else {
            Double::from(x)
        }
    }
}

/// Rounding of a position in f64, by the sizes of the numbers that it is made of: some ten operations.
const POSITION_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// A grid's map from the world to its index space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactPlacement {
    origin: Double3,
    axes: [Double3; 3],
    /// Its rows.
    inverse: [Double3; 3],
    dims: [usize; 3],
    /// Bound on the shift of an index, per axis, by the rounding of the axes themselves (directions normalised, times spacings).
    axes_off: [f64; 3],
}

/// Rounding of a component of an axis: a normalised vector times a spacing.
const AXIS_ROUNDING: f64 = 4.0 * f64::EPSILON;

impl ExactPlacement {
    pub(crate) fn new(placement: &Placement, dims: [usize; 3]) -> Self {
        let columns = [placement.axes().x_axis, placement.axes().y_axis, placement.axes().z_axis];
        // Scaled by powers of two, so that the determinant neither underflows nor overflows.
        let scales = columns.map(|c| power_of_two_below(c.abs().max_element()));
        let unit: [Double3; 3] = std::array::from_fn(|a| Double3::from(columns[a]).map(|x| x.scaled(1.0 / scales[a])));
        let determinant = unit[0].dot(unit[1].cross(unit[2]));
        let inverse: [Double3; 3] = std::array::from_fn(|a| {
            let row = unit[(a + 1) % 3].cross(unit[(a + 2) % 3]);
            row.map(|x| (x / determinant).scaled(1.0 / scales[a]))
        });
        let axes_off = std::array::from_fn(|a| {
            let off = |b: usize| {
                let column = columns[b].to_array();
                // An axis along a world axis is as exact as its spacing.
                if column.iter().filter(|x| **x != 0.0).count() < 2 {
                    return 0.0;
                }
                let moved: f64 = (0..3).map(|c| (inverse[a].0[c].round() * column[c]).abs()).sum();
                AXIS_ROUNDING * moved * (dims[b] - 1) as f64
            };
            off(0) + off(1) + off(2)
        });
        Self { origin: placement.origin().into(), axes: columns.map(Double3::from), inverse, dims, axes_off }
    }

    /// The rows of the inverse, rounded: world to index.
    pub(crate) fn inverse(&self) -> DMat3 {
        DMat3::from_cols(self.inverse[0].round(), self.inverse[1].round(), self.inverse[2].round()).transpose()
    }

    /// Relative error of a world gradient, per unit of its rows: the turn of the axes by rounding.
    pub(crate) fn axes_error(&self) -> f64 {
        let dims = self.dims;
        (0..3).map(|a| self.axes_off[a] / (dims[a].max(2) - 1) as f64).fold(0.0, f64::max)
    }

    /// The part of a ray inside the box and the clip, up to the world distance `far`: as `IndexRay::new`.
    ///
    /// Rounding decides on which side of a face a ray is that lies in it, and whether one that only touches the box has a part inside.
    /// Pixels are defined by the f64 rays of `vr_core::Rays`, so `rounded`, which returns that ray's part, decides these cases.
    pub(crate) fn chord(
        &self,
        ray: &ExactRay,
        clip: &Clip,
        far: f64,
        rounded: impl Fn() -> Option<IndexRay>,
    ) -> Option<IndexChord> {
        // The ray in index space, its distances counted from the point nearest to the middle of the box.
        let last = self.dims.map(|n| (n - 1) as f64);
        let middle = (0..3).fold(self.origin, |sum, a| sum + self.axes[a] * Double::from(0.5 * last[a]));
        let offset = (middle - ray.origin).dot(ray.direction).round();
        let world = ray.origin + ray.direction * Double::from(offset);
        let base = world - self.origin;
        let mut origin = self.inverse.map(|row| row.dot(base));
        let direction = self.inverse.map(|row| row.dot(ray.direction));
        // Sizes of the numbers that a position is made of in f64, and what a sum of products of them may be rounded by.
        let sizes: [f64; 3] = std::array::from_fn(|c| {
            let moved = (ray.direction.0[c].round() * offset).abs();
            ray.origin.0[c].round().abs() + self.origin.0[c].round().abs() + moved
        });
        let rounding =
            |row: Double3| POSITION_ROUNDING * (0..3).map(|c| (row.0[c].round() * sizes[c]).abs()).sum::<f64>();
        let reach = (0..3).map(|a| 0.5 * last[a] * self.axes[a].round().length()).sum();
        let rounded = || rounded().map(|ray| [ray.start, ray.end].map(|s| s + (ray.offset - offset)));
        let ends = [-offset, far - offset];
        let mut part =
            Part { ends, off: [Bound::ZERO; 2], rounding: [POSITION_ROUNDING * offset.abs(); 2], reach, rounded };
        // Cut it by the faces of the box, the crop box and the planes.
        for a in 0..3 {
            let faces = [0.0, last[a]];
            part.keep_between(origin[a], direction[a], faces, [self.axes_off[a], rounding(self.inverse[a])]);
            let at = origin[a].round();
            if direction[a].round() == 0.0 && !(0.0..=last[a]).contains(&at) {
                // Taken for inside: not beyond the face.
                origin[a] = Double::from(at.clamp(0.0, last[a]));
            }
        }
        if let Some((low, high)) = clip.crop {
            for a in 0..3 {
                let off = [0.0, POSITION_ROUNDING * sizes[a]];
                part.keep_between(world.0[a], ray.direction.0[a], [low[a], high[a]], off);
            }
        }
        for plane in &clip.planes {
            let normal = Double3::from(plane.normal);
            let above = normal.dot(world) - Double::from(plane.offset);
            let off = [0.0, rounding(normal) + POSITION_ROUNDING * plane.offset.abs()];
            part.keep_between(above, normal.dot(ray.direction), [0.0, f64::INFINITY], off);
        }
        let [start, end] = part.decided();
        if start.is_nan() || end.is_nan() || start >= end {
            return None;
        }
        // Bound the errors of positions on what is left.
        let farthest = start.abs().max(end.abs());
        let position_error = std::array::from_fn(|a| {
            // The numbers themselves, and the product and the sum that make a position of them.
            let (o, d) = (origin[a], direction[a]);
            let run = d.round().abs() * farthest;
            o.rest().abs()
                + d.rest().abs() * farthest
                + f64::EPSILON * (run + o.round().abs() * f64::from(run > 0.0))
                + self.axes_off[a]
        });
        let index = IndexRay {
            origin: glam::DVec3::from_array(origin.map(Double::round)),
            direction: glam::DVec3::from_array(direction.map(Double::round)),
            start,
            end,
            offset,
        };
        Some(IndexChord { ray: index, position_error, end_error: part.off.map(Bound::value) })
    }
}

/// A ray's part in a volume, in index space, with the error of its numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IndexChord {
    pub(crate) ray: IndexRay,
    /// Upper bounds of the error of a position, in index steps.
    pub(crate) position_error: [f64; 3],
    /// Upper bounds of the errors of its start and of its end, in world units.
    pub(crate) end_error: [f64; 2],
}

struct Part<F> {
    ends: [f64; 2],
    off: [Bound; 2],
    /// Upper bounds of the rounding of each end in f64, in world units.
    rounding: [f64; 2],
    /// Upper bound of |s| inside the box.
    reach: f64,
    /// Computes the ends as f64 arithmetic has them; `None` if that finds no part inside.
    rounded: F,
}

impl<F: Fn() -> Option<[f64; 2]>> Part<F> {
    /// The ends, or those of f64 arithmetic if rounding decides whether there is anything between them.
    fn decided(&self) -> [f64; 2] {
        let [start, end] = self.ends;
        if (end - start).abs() <= self.rounding[0] + self.rounding[1] {
            return (self.rounded)().unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
        }
        self.ends
    }

    /// Keeps the s with low ≤ x + s·slope ≤ high, where x is off by `error` at most, and in f64 by `rounding`.
    fn keep_between(&mut self, x: Double, slope: Double, [low, high]: [f64; 2], [error, rounding]: [f64; 2]) {
        let (at, rate) = (x.round(), slope.round());
        // In a limit, all the way: f64 decides.
        if (at - low).abs().min((at - high).abs()) <= rounding && rate.abs() * self.reach <= rounding {
            let [start, end] = (self.rounded)().unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            self.ends = [self.ends[0].max(start), self.ends[1].min(end)];
            return;
        }
        if rate == 0.0 {
            // Parallel: all or nothing. 0/0 would be NaN.
            if !(low..=high).contains(&at) {
                self.ends[1] = f64::NEG_INFINITY;
            }
            return;
        }
        let at = |limit: f64| {
            if limit.is_infinite() { limit / rate } else { ((Double::from(limit) - x) / slope).round() }
        };
        let (a, b) = (at(low), at(high));
        // Rounded once from the quotient.
        let off = |s: f64| Bound::new(0.5 * f64::EPSILON * s) + Bound::new(error / rate.abs());
        let moved = |s: f64| rounding / rate.abs() + POSITION_ROUNDING * s.abs();
        if a.min(b) > self.ends[0] {
            self.ends[0] = a.min(b);
            (self.off[0], self.rounding[0]) = (off(self.ends[0]), moved(self.ends[0]));
        }
        if a.max(b) < self.ends[1] {
            self.ends[1] = a.max(b);
            (self.off[1], self.rounding[1]) = (off(self.ends[1]), moved(self.ends[1]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use vr_core::{Camera, Rays};

    fn view(eye: DVec3, projection: Projection) -> View {
        View::new(Camera { eye, target: DVec3::new(1.0, 1.5, 2.0), up: DVec3::new(0.1, 1.0, 0.2), projection }, [7, 5])
    }

    #[test]
    fn rays_and_chords_are_those_of_the_renderers_to_rounding() {
        let axes = DMat3::from_cols(DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 2.0, 0.0), DVec3::new(0.0, 0.3, 0.7));
        let placement = Placement::new(DVec3::new(0.5, -1.0, 0.25), axes).unwrap();
        let dims = [4, 5, 6];
        let exact_placement = ExactPlacement::new(&placement, dims);
        let clip = Clip {
            crop: Some((DVec3::splat(-3.0), DVec3::new(3.0, 6.0, 2.9))),
            planes: vec![vr_core::Plane { normal: DVec3::new(1.0, 2.0, 0.5), offset: 0.75 }],
        };
        let mut hits = 0;
        for projection in [Projection::Orthographic { height: 7.0 }, Projection::Perspective { fov: 40.0 }] {
            let view = view(DVec3::new(9.0, -5.0, 7.0), projection);
            let (rays, exact) = (Rays::new(&view).unwrap(), ExactRays::new(&view).unwrap());
            for i in 0..35 {
                let (x, y) = (f64::from(i % 7) + 0.5, f64::from(i / 7) + 0.5);
                let (ray, precise) = (rays.at(x, y), exact.at(x, y));
                assert!((ray.origin - precise.origin.round()).length() < 1e-14);
                assert!((ray.direction - precise.direction.round()).length() < 1e-15);
                let far = f64::INFINITY;
                let (a, b) = (
                    IndexRay::new(&ray, &placement, dims, &clip, far),
                    exact_placement.chord(&precise, &clip, far, || unreachable!("no ray in a face")),
                );
                assert_eq!(a.is_some(), b.is_some());
                let (Some(a), Some(b)) = (a, b) else { continue };
                hits += 1;
                assert!((a.start + a.offset - b.ray.start - b.ray.offset).abs() < 1e-13);
                assert!((a.end + a.offset - b.ray.end - b.ray.offset).abs() < 1e-13);
                assert!((a.at(a.start) - b.ray.at(b.ray.start)).length() < 1e-13);
                assert!(b.position_error.iter().all(|&e| e > 0.0 && e < 2e-14), "{b:?}");
            }
        }
        assert!(hits > 8, "{hits}");
    }

    #[test]
    fn a_ray_in_a_face_is_where_renderers_have_it() {
        // Rays along faces of the box, whose places no f64 holds exactly: the sum of two of them decides.
        let origin = DVec3::new(-61.188_975_791_226_845, 83.846_193_078_629_67, 6.981_876_542_898_195);
        let axes = DMat3::from_diagonal(DVec3::new(1.926_049_110_543_03, 1.0, 1.0));
        let placement = Placement::new(origin, axes).unwrap();
        let exact = ExactPlacement::new(&placement, [6, 3, 3]);
        let (clip, far) = (Clip::default(), f64::INFINITY);
        let mut hits = [0; 2];
        for shift in 0..64 {
            // A unit in the last place more each time.
            let side = 7.981_876_542_898_195 + f64::from(shift - 32) * 8.0 * f64::EPSILON;
            let eye = DVec3::new(-38.076_386_464_710_48, 84.846_193_078_629_67, side);
            let target = DVec3 { x: -57.336_877_570_140_786, ..eye };
            let camera = Camera { eye, target, up: DVec3::Y, projection: Projection::Orthographic { height: 3.0 } };
            let view = View::new(camera, [7, 6]);
            let (rays, exact_rays) = (Rays::new(&view).unwrap(), ExactRays::new(&view).unwrap());
            for x in 0..7 {
                let (x, y) = (f64::from(x) + 0.5, 2.5);
                let core = IndexRay::new(&rays.at(x, y), &placement, [6, 3, 3], &clip, far);
                let chord = exact.chord(&exact_rays.at(x, y), &clip, far, || core);
                assert_eq!(chord.is_some(), core.is_some(), "{shift} {x}");
                hits[usize::from(chord.is_some())] += 1;
                if let Some(chord) = chord {
                    assert!((0.0..=2.0).contains(&chord.ray.at(chord.ray.start).z), "{chord:?}");
                }
            }
        }
        assert!(hits.iter().all(|&n| n > 64), "{hits:?}");
    }

    #[test]
    fn a_ray_that_touches_a_corner_has_what_renderers_have() {
        // From a corner of the volume outwards: of some rays f64 has a last bit inside.
        let placement = Placement::from_spacing([0.5; 3]).unwrap();
        let (dims, clip, far) = ([4, 3, 3], Clip::default(), f64::INFINITY);
        let exact = ExactPlacement::new(&placement, dims);
        let projection = Projection::Perspective { fov: 90.0 };
        let (eye, target) = (DVec3::new(0.75, 0.5, 1.0), DVec3::new(0.75, -0.5, 2.0));
        let view = View::new(Camera { eye, target, up: DVec3::X, projection }, [8, 8]);
        let (rays, exact_rays) = (Rays::new(&view).unwrap(), ExactRays::new(&view).unwrap());
        let mut hits = [0; 2];
        for y in 0..8 {
            for x in 0..8 {
                let (x, y) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
                let core = IndexRay::new(&rays.at(x, y), &placement, dims, &clip, far);
                let chord = exact.chord(&exact_rays.at(x, y), &clip, far, || core);
                assert_eq!(chord.is_some(), core.is_some(), "{x} {y}: {chord:?} {core:?}");
                hits[usize::from(core.is_some())] += 1;
            }
        }
        assert!(hits.iter().all(|&n| n > 4), "{hits:?}");
    }

    #[test]
    fn a_far_ray_keeps_its_digits() {
        // The same ray from near and from 10⁶ diagonals away, which numbers of few bits say exactly.
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let exact = ExactPlacement::new(&placement, [9, 9, 9]);
        let chord = |distance: f64| {
            let eye = DVec3::new(4.0, 4.0, 4.0) + DVec3::new(3.0, 4.0, 12.0) * distance;
            let projection = Projection::Orthographic { height: 6.0 };
            let camera = Camera { eye, target: DVec3::splat(4.0), up: DVec3::Y, projection };
            let rays = ExactRays::new(&View::new(camera, [9, 9])).unwrap();
            exact.chord(&rays.at(2.5, 6.5), &Clip::default(), f64::INFINITY, || None).unwrap().ray
        };
        let (near, far) = (chord(1.0), chord(1e6));
        assert!((near.origin - far.origin).length() < 2e-15 && (near.start - far.start).abs() < 2e-15);
    }
}
