//! Rounding of the places at which a clip cuts rays.

use crate::ray::Ray;
use crate::view::Clip;

/// Bound on the error of an end of a ray's part that a clip sets; 0 if none of its faces does.
pub(crate) fn clip_error(ray: &Ray, clip: &Clip, offset: f64, at: f64) -> f64 {
    let place = ray.origin + ray.direction * (offset + at);
    let reach = ray.origin.abs() + ray.direction.abs() * (offset.abs() + at.abs());
    let mut largest = 0.0f64;
    let mut face = |distance: f64, size: f64, rate: f64| {
        let error = 8.0 * f64::EPSILON * (size + distance.abs());
        if distance.abs() <= 4.0 * error && rate != 0.0 {
            largest = largest.max(2.0 * error / rate.abs());
        }
    };
    if let Some((low, high)) = clip.crop {
        for a in 0..3 {
            for side in [low[a], high[a]] {
                face(place[a] - side, reach[a] + side.abs(), ray.direction[a]);
            }
        }
    }
    for plane in &clip.planes {
        let size = plane.normal.abs().dot(reach) + plane.offset.abs();
        face(plane.normal.dot(place) - plane.offset, size, plane.normal.dot(ray.direction));
    }
    largest
}
