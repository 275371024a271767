//! Cameras that see all of something, each from its side, without a change of scale between them.

use glam::DVec3;
use vr_core::Camera;

use crate::fit::fit;

/// Number of cameras that are asked what they see; of more, some here and there.
const MAX_ASKED: usize = 96;

/// Returns cameras that look the way `cameras` do, all with one scale and one distance from `pivot`, as near as they can all see all of
/// `points`: what turns before them neither grows nor shrinks, nor leaves the picture. `aspect` is the picture's width over its height.
///
/// The cameras form one rigid rig: the pivot is at the same place in each of their pictures. Of more than 96 cameras, 96 or more decide.
/// Without points, or where the first camera sees nothing, they are returned as they are.
#[must_use]
pub fn fit_together(cameras: &[Camera], pivot: DVec3, points: &[DVec3], aspect: f64) -> Vec<Camera> {
    let Some((first, Ok(frame))) = cameras.first().map(|camera| (camera, camera.frame())) else {
        return cameras.to_vec();
    };
    // All that any camera sees, moved before the first one.
    let step = cameras.len().div_ceil(MAX_ASKED);
    let frames = cameras.iter().step_by(step).filter_map(|camera| camera.frame().ok());
    let seen: Vec<DVec3> =
        frames.flat_map(|own| points.iter().map(move |&p| pivot + frame * (own.transpose() * (p - pivot)))).collect();
    let whole = Camera { eye: first.eye + (pivot - first.target), target: pivot, ..*first };
    let fitted = fit(&whole, &seen, aspect);
    if fitted == whole {
        return cameras.to_vec();
    }
    // The place of the rig's one camera, as each camera has it about the pivot.
    let [eye, target] = [fitted.eye, fitted.target].map(|p| frame.transpose() * (p - pivot));
    let placed = |camera: &Camera| match camera.frame() {
        Ok(own) => Camera {
            eye: pivot + own * eye,
            target: pivot + own * target,
            up: own.y_axis,
            projection: fitted.projection,
        },
        Err(_) => *camera,
    };
    cameras.iter().map(placed).collect()
}

/// Returns the centre of a small ball about points, for cameras to turn about: its radius is within a few percent of the smallest. `None`
/// without points.
#[must_use]
pub fn centre_of(points: &[DVec3]) -> Option<DVec3> {
    /// Number of steps; after n of them the radius is within 1/√n of the smallest (Bădoiu and Clarkson 2003).
    const STEPS: usize = 400;
    let mut centre = *points.first()?;
    for step in 1..=STEPS {
        let farthest = points.iter().max_by(|a, b| a.distance_squared(centre).total_cmp(&b.distance_squared(centre)));
        centre += (farthest? - centre) / (step + 1) as f64;
    }
    Some(centre)
}

/// Returns the point about which points turn in the smallest circles about an axis of that direction, a vector of any length but 0. It lies
/// half-way between the ends of the points along the axis. `None` without points.
#[must_use]
pub fn pivot_of(points: &[DVec3], axis: DVec3) -> Option<DVec3> {
    let axis = axis.normalize();
    let flat: Vec<DVec3> = points.iter().map(|&p| p - axis * axis.dot(p)).collect();
    let along = points.iter().map(|p| axis.dot(*p));
    let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    centre_of(&flat).map(|centre| centre + axis * (0.5 * (low + high)))
}

#[cfg(test)]
mod tests {
    use vr_core::Projection;

    use super::*;

    /// Corners of a box that is long along one axis and off centre.
    fn corners() -> Vec<DVec3> {
        let at = |i: usize, a: usize, low: f64, high: f64| if i >> a & 1 == 0 { low } else { high };
        (0..8).map(|i| DVec3::new(at(i, 0, 3.0, 9.0), at(i, 1, -1.0, 1.0), at(i, 2, 4.0, 6.0))).collect()
    }

    fn turntable(fov: Option<f64>, count: usize) -> Vec<Camera> {
        let first = Camera::framing((DVec3::splat(-9.0), DVec3::splat(9.0)), 0.0, 25.0, fov);
        (0..count).map(|i| first.turned(first.target, DVec3::Y, 360.0 * i as f64 / count as f64)).collect()
    }

    /// Largest distance from the middle of the picture that any camera sees a point at, along x and y; 1 is the edge.
    fn largest(cameras: &[Camera], points: &[DVec3], aspect: f64) -> [f64; 2] {
        let mut largest = [0.0f64; 2];
        for camera in cameras {
            let frame = camera.frame().unwrap();
            for p in points {
                let v = frame.transpose() * (*p - camera.eye);
                assert!(v.z > 0.0, "behind the eye");
                let half = match camera.projection {
                    Projection::Orthographic { height } => 0.5 * height,
                    Projection::Perspective { fov } => v.z * (0.5 * fov.to_radians()).tan(),
                };
                largest = [largest[0].max((v.x / (half * aspect)).abs()), largest[1].max((v.y / half).abs())];
            }
        }
        largest
    }

    #[test]
    fn a_turn_sees_everything_at_one_scale() {
        let points = corners();
        let pivot = pivot_of(&points, DVec3::Y).unwrap();
        assert!(pivot.distance(DVec3::new(6.0, 0.0, 5.0)) < 0.2, "{pivot}");
        for (fov, aspect) in [(None, 1.0), (None, 2.0), (Some(30.0), 1.0), (Some(50.0), 0.5)] {
            let cameras = fit_together(&turntable(fov, 48), pivot, &points, aspect);
            let [x, y] = largest(&cameras, &points, aspect);
            assert!(x <= 0.9 + 1e-9 && y <= 0.9 + 1e-9 && x.max(y) > 0.87, "{x} {y}");
            let distance = |camera: &Camera| camera.eye.distance(pivot);
            for camera in &cameras {
                assert_eq!(camera.projection, cameras[0].projection);
                assert!((distance(camera) / distance(&cameras[0]) - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn of_many_cameras_some_decide() {
        let points = corners();
        let pivot = pivot_of(&points, DVec3::Y).unwrap();
        let [few, many] = [96, 960].map(|count| fit_together(&turntable(None, count), pivot, &points, 1.0));
        assert_eq!((few[0].eye, many[0].eye), (few[0].eye, few[0].eye));
        assert_eq!(many.len(), 960);
    }

    #[test]
    fn nothing_to_see_leaves_the_cameras() {
        let cameras = turntable(None, 5);
        assert_eq!(fit_together(&cameras, DVec3::ZERO, &[], 1.0), cameras);
        assert!(fit_together(&[], DVec3::ZERO, &corners(), 1.0).is_empty());
        assert!(centre_of(&[]).is_none() && pivot_of(&[], DVec3::Y).is_none());
    }
}
