//! The camera of a scene that names none.

use glam::DVec3;
use vr_core::Camera;

use crate::read::FileInfo;

/// Azimuth and elevation in degrees from which a scene without a camera is seen: slightly from above and the right; a patient's face from
/// its front, turned as little as depth needs.
pub fn default_angles(info: Option<&FileInfo>) -> (f64, f64) {
    if is_patient(info) { (15.0, 10.0) } else { (30.0, 20.0) }
}

fn is_patient(info: Option<&FileInfo>) -> bool {
    info.is_some_and(|file| file.space.is_patient())
}

/// A camera that sees all of a volume's `bounds` from an azimuth and elevation in degrees, as [`Camera::framing`] does; but a
/// patient, whose world is RAS, stands: azimuth 0 looks into the face, and the head is up.
pub fn framing(
    bounds: (DVec3, DVec3),
    info: Option<&FileInfo>,
    (azimuth, elevation): (f64, f64),
    fov: Option<f64>,
) -> Camera {
    let camera = Camera::framing(bounds, azimuth, elevation, fov);
    if !is_patient(info) {
        return camera;
    }
    // From +z to anterior, +y; from +y up to superior, +z. What is to the right of −z is then to the patient's left.
    let stand = |v: DVec3| DVec3::new(-v.x, v.z, v.y);
    Camera { eye: camera.target + stand(camera.eye - camera.target), up: stand(camera.up), ..camera }
}
