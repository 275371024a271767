//! Splines of rotations.

use glam::{DQuat, DVec3};

use super::Interpolation;
use super::spline::{ease, place};

/// A course through orientations at certain times, on the shortest way from each to the next.
///
/// [`Interpolation::Smooth`] is the cubic curve of unit quaternions by Kim, Kim and Shin (1995), whose angular velocity is continuous; at a
/// key it is the mean of those on both sides, and none where one of them is none. The others are spherical interpolation.
#[derive(Clone, Debug)]
pub(super) struct RotationSpline {
    times: Vec<f64>,
    orientations: Vec<DQuat>,
    /// Rotation vectors per second at each key, in the key's own frame.
    velocities: Vec<DVec3>,
    interpolation: Interpolation,
}

impl RotationSpline {
    /// A spline through one or more orientations at rising times.
    pub fn new(times: Vec<f64>, orientations: Vec<DQuat>, interpolation: Interpolation) -> Self {
        let lengths: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
        let pairs = orientations.windows(2).zip(&lengths);
        let speeds: Vec<DVec3> = pairs.map(|(q, length)| rotation_vector(q[0].conjugate() * q[1]) / *length).collect();
        let velocity = |k: usize| match (k.checked_sub(1).map(|before| speeds[before]), speeds.get(k)) {
            (None, None) => DVec3::ZERO,
            (None, Some(&only)) | (Some(only), None) => only,
            (Some(before), Some(&after)) if before == DVec3::ZERO || after == DVec3::ZERO => DVec3::ZERO,
            // The vector of a rotation is the same in the frames of both of its ends.
            (Some(before), Some(&after)) => {
                (lengths[k] * before + lengths[k - 1] * after) / (lengths[k - 1] + lengths[k])
            }
        };
        let velocities = (0..times.len()).map(velocity).collect();
        Self { times, orientations, velocities, interpolation }
    }

    /// Returns the orientation at a time; before the first and after the last key, theirs.
    pub fn at(&self, time: f64) -> DQuat {
        let (k, u) = place(&self.times, time);
        let from = self.orientations[k];
        let Some(&to) = self.orientations.get(k + 1).filter(|_| u > 0.0) else { return from };
        let whole = from.conjugate() * to;
        let way = match self.interpolation {
            Interpolation::Linear => rotation(rotation_vector(whole) * u),
            Interpolation::Ease => rotation(rotation_vector(whole) * ease(u)),
            Interpolation::Smooth => {
                let third = (self.times[k + 1] - self.times[k]) / 3.0;
                let (first, last) = (self.velocities[k] * third, self.velocities[k + 1] * third);
                let middle = rotation_vector(rotation(-first) * whole * rotation(-last));
                // Bernstein's polynomials, summed from the end.
                let rest = 1.0 - u;
                let shares = [1.0 - rest * rest * rest, ease(u), u * u * u];
                rotation(first * shares[0]) * rotation(middle * shares[1]) * rotation(last * shares[2])
            }
        };
        (from * way).normalize()
    }
}

/// The rotation of a vector: about it, by its length in radians. With libm's sine, for pictures must not depend on the machine.
fn rotation(vector: DVec3) -> DQuat {
    let angle = vector.length();
    if angle < 1e-150 {
        return DQuat::IDENTITY;
    }
    let (sin, cos) = libm::sincos(0.5 * angle);
    let axis = vector * (sin / angle);
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

/// The vector of a rotation, of π at most.
fn rotation_vector(rotation: DQuat) -> DVec3 {
    let q = if rotation.w < 0.0 { -rotation } else { rotation };
    let axis = DVec3::new(q.x, q.y, q.z);
    let sin = axis.length();
    if sin < 1e-150 { DVec3::ZERO } else { axis * (2.0 * libm::atan2(sin, q.w) / sin) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angle(a: DQuat, b: DQuat) -> f64 {
        rotation_vector(a.conjugate() * b).length()
    }

    fn spline(interpolation: Interpolation) -> RotationSpline {
        let vectors = [[0.1, 0.0, 0.0], [0.0, 1.2, 0.0], [0.0, 1.2, 0.0], [0.0, -1.0, 2.0], [2.9, 0.0, 0.1]];
        let times = vec![0.0, 1.0, 1.5, 3.0, 4.0];
        RotationSpline::new(times, vectors.iter().map(|&v| rotation(v.into())).collect(), interpolation)
    }

    #[test]
    fn keys_are_hit_and_the_course_is_smooth() {
        for interpolation in [Interpolation::Smooth, Interpolation::Linear, Interpolation::Ease] {
            let spline = spline(interpolation);
            for (k, &time) in spline.times.iter().enumerate() {
                assert_eq!(spline.at(time), spline.orientations[k]);
                assert!(angle(spline.at(time - 1e-9), spline.orientations[k]) < 1e-7, "continuous");
            }
            assert!(angle(spline.at(1.25), spline.orientations[1]) < 1e-12, "rests");
            assert_eq!(spline.at(9.0), spline.orientations[4]);
        }
        let smooth = spline(Interpolation::Smooth);
        let velocity = |t: f64| rotation_vector(smooth.at(t).conjugate() * smooth.at(t + 1e-6)) / 1e-6;
        assert!((velocity(3.0 - 1e-6) - velocity(3.0)).length() < 1e-3);
    }

    #[test]
    fn a_steady_turn_stays_one() {
        let times = vec![0.0, 1.0, 2.0, 3.0];
        let turns = (0..4).map(|i| rotation(DVec3::Y * f64::from(i))).collect();
        let smooth = RotationSpline::new(times, turns, Interpolation::Smooth);
        for i in 0..30 {
            let time = f64::from(i) * 0.1;
            assert!(angle(smooth.at(time), rotation(DVec3::Y * time)) < 1e-12);
        }
    }

    #[test]
    fn rotation_vectors_turn_back() {
        for v in [DVec3::ZERO, DVec3::X * 1e-9, DVec3::new(0.3, -1.0, 2.0), DVec3::Z * 3.1] {
            assert!((rotation_vector(rotation(v)) - v).length() < 1e-14);
            assert!((rotation_vector(-rotation(v)) - v).length() < 1e-14);
        }
    }
}
