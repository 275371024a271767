//! A camera that what is visible fills.

use glam::DVec3;
use vr_core::{Camera, Projection};

/// Part of the picture that is filled, in its larger direction.
const FILLED: f64 = 0.9;

/// The camera that looks the way `camera` does, moved and widened so that `points` fill nine tenths of the picture in one direction, and
/// fit in the other. `aspect` is the picture's width over its height.
///
/// Orthographic cameras change their height, perspective ones their distance; the field of view is kept. Without points, or where they lie
/// in one place, the camera stays.
#[must_use]
pub fn fit(camera: &Camera, points: &[DVec3], aspect: f64) -> Camera {
    let Ok(frame) = camera.frame() else { return *camera };
    let seen: Vec<DVec3> = points.iter().map(|&p| frame.transpose() * (p - camera.target)).collect();
    let Some((low, high)) = seen.iter().map(|&p| (p, p)).reduce(|(l, h), (p, _)| (l.min(p), h.max(p))) else {
        return *camera;
    };
    let size = high - low;
    if !(size.length() > 0.0 && size.is_finite()) {
        return *camera;
    }
    let distance = camera.eye.distance(camera.target);
    match camera.projection {
        Projection::Orthographic { .. } => {
            let height = size.y.max(size.x / aspect) / FILLED;
            if height <= 0.0 {
                return *camera;
            }
            let target = camera.target + frame * (0.5 * (low + high));
            // Before everything, as far as the picture is high.
            let back = (0.5 * size.z + height).max(distance);
            Camera {
                eye: target - frame.z_axis * back,
                target,
                projection: Projection::Orthographic { height },
                ..*camera
            }
        }
        Projection::Perspective { fov } => {
            // A point is in the picture if |y − y₀| ≤ k (d + z), with d the distance of the eye from z = 0: the narrowest pyramid about all
            // touches one point above and one below, which gives d and y₀; likewise x.
            let k = DVec3::new(FILLED * aspect, FILLED, 1.0) * libm::tan(0.5 * fov.to_radians());
            let touching = |axis: usize| {
                let above = seen.iter().map(|p| p[axis] - k[axis] * p.z).fold(f64::NEG_INFINITY, f64::max);
                let below = seen.iter().map(|p| -p[axis] - k[axis] * p.z).fold(f64::NEG_INFINITY, f64::max);
                (0.5 * (above - below), 0.5 * (above + below) / k[axis])
            };
            let ((x, by_width), (y, by_height)) = (touching(0), touching(1));
            // Never inside what is seen.
            let away = by_width.max(by_height).max(-low.z + 1e-3 * size.length());
            let middle = 0.5 * (low.z + high.z);
            let target = camera.target + frame * DVec3::new(x, y, middle);
            Camera { eye: target - frame.z_axis * (away + middle), target, ..*camera }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Bounds of points in the picture, which spans (−1, −1) to (1, 1).
    fn seen(camera: &Camera, points: &[DVec3], aspect: f64) -> (DVec3, DVec3) {
        let frame = camera.frame().unwrap();
        let at = |p: &DVec3| {
            let v = frame.transpose() * (*p - camera.eye);
            let half = match camera.projection {
                Projection::Orthographic { height } => 0.5 * height,
                Projection::Perspective { fov } => v.z * (0.5 * fov.to_radians()).tan(),
            };
            DVec3::new(v.x / (half * aspect), v.y / half, v.z)
        };
        points.iter().map(at).fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)))
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(9), ..ProptestConfig::default() })]

        #[test]
        fn points_fill_the_picture(
            raw in prop::collection::vec(prop::array::uniform3(-5.0f64..5.0), 3..20),
            angles in (-180.0f64..180.0, -80.0f64..80.0),
            fov in prop::option::of(10.0f64..90.0),
            aspect in 0.4f64..2.5,
        ) {
            let points: Vec<DVec3> = raw.into_iter().map(DVec3::from).collect();
            let whole = Camera::framing((DVec3::splat(-9.0), DVec3::splat(9.0)), angles.0, angles.1, fov);
            let camera = fit(&whole, &points, aspect);
            let (low, high) = seen(&camera, &points, aspect);
            let filled = (high - low) * 0.5;
            prop_assert!(low.z > 0.0, "behind the eye");
            prop_assert!(filled.x <= 0.9 + 1e-9 && filled.y <= 0.9 + 1e-9, "{filled}");
            // Perspective: one direction alone is filled unless the eye would be among the points.
            prop_assert!(filled.x.max(filled.y) > 0.85 || fov.is_some(), "{filled}");
            let forward = |c: &Camera| (c.target - c.eye).normalize();
            prop_assert!((forward(&camera) - forward(&whole)).length() < 1e-9);
        }
    }

    #[test]
    fn nothing_to_see_leaves_the_camera() {
        let whole = Camera::framing((DVec3::splat(-9.0), DVec3::splat(9.0)), 30.0, 20.0, None);
        assert_eq!(fit(&whole, &[], 1.0), whole);
        assert_eq!(fit(&whole, &[DVec3::ONE], 1.0), whole);
    }
}
