//! The camera of a view, changed by flags.

use glam::DVec3;
use vr_core::{Camera, ParameterError, Projection};
use vr_io::{CameraSection, FileInfo, ProjectionName, USUAL_FOV};
use vr_look::fit;

use crate::args::{CameraArgs, Fit};

/// Things in the scene that an automatic camera has to show.
pub struct Sight<'a> {
    /// Bounds of volume and mesh.
    pub bounds: (DVec3, DVec3),
    /// World positions that enclose what is visible.
    pub visible: &'a dyn Fn() -> &'a [DVec3],
    /// Width of the picture over its height.
    pub aspect: f64,
    /// Header of the volume's file, which tells a patient's orientation.
    pub info: Option<&'a FileInfo>,
    /// Azimuth and elevation in degrees where no flag says other ones.
    pub angles: (f64, f64),
}

/// True if flags leave nothing of a camera that a scene file says by angles alone: all is to be framed anew.
pub fn frame_anew(args: &CameraArgs, section: &CameraSection) -> bool {
    section.is_framed() && (args.projection.is_some() || args.fov.is_some() || args.fit == Fit::Box)
}

/// Returns the scene's camera, or else one that sees all of the volume, changed by flags.
///
/// # Errors
/// A camera that sees nothing.
pub fn apply(args: &CameraArgs, own: Option<Camera>, sight: &Sight<'_>) -> Result<Camera, ParameterError> {
    match (args.projection, args.fov, args.height) {
        (Some(ProjectionName::Orthographic), Some(fov), _) => {
            return Err(ParameterError::new("camera.fov", fov, "an orthographic camera has a height, not an angle"));
        }
        (Some(ProjectionName::Perspective), _, Some(height)) => {
            return Err(ParameterError::new("camera.height", height, "a perspective camera has a fov, not a height"));
        }
        _ => {}
    }
    let fov = match (args.projection, args.fov, own.map(|camera| camera.projection)) {
        (_, Some(fov), _) => Some(fov),
        (Some(ProjectionName::Orthographic), ..) => None,
        (None, None, Some(Projection::Perspective { fov })) if args.height.is_none() => Some(fov),
        (None, ..) => None,
        (Some(ProjectionName::Perspective), None, Some(Projection::Perspective { fov })) => Some(fov),
        (Some(ProjectionName::Perspective), ..) => Some(USUAL_FOV),
    };
    let mut camera = match own {
        Some(own) if args.azimuth.is_none() && args.elevation.is_none() => own,
        _ => whole_volume(args, fov, sight)?,
    };
    camera.projection = match (fov, args.height, camera.projection) {
        (Some(fov), ..) => Projection::Perspective { fov },
        (None, Some(height), _) => Projection::Orthographic { height },
        // What lies at the target keeps its size.
        (None, None, Projection::Perspective { fov }) => {
            let distance = camera.eye.distance(camera.target);
            Projection::Orthographic { height: 2.0 * distance * (0.5 * fov.to_radians()).tan() }
        }
        (None, None, orthographic) => orthographic,
    };
    camera.eye = args.eye.map_or(camera.eye, DVec3::from);
    camera.target = args.target.map_or(camera.target, DVec3::from);
    camera.up = args.up.map_or(camera.up, DVec3::from);
    camera.frame()?;
    Ok(camera)
}

fn whole_volume(args: &CameraArgs, fov: Option<f64>, sight: &Sight<'_>) -> Result<Camera, ParameterError> {
    let Sight { bounds, visible, aspect, info, angles } = *sight;
    let (azimuth, elevation) = (args.azimuth.unwrap_or(angles.0), args.elevation.unwrap_or(angles.1));
    for (field, angle) in [("camera.azimuth", azimuth), ("camera.elevation", elevation)] {
        if !angle.is_finite() {
            return Err(ParameterError::new(field, angle, "must be finite"));
        }
    }
    if let Some(fov) = fov {
        // A wrong angle is to be named, not the eye that it would put somewhere.
        Camera { projection: Projection::Perspective { fov }, ..Camera::framing(bounds, 0.0, 0.0, None) }.frame()?;
    }
    let whole = vr_io::framing(bounds, info, (azimuth, elevation), fov);
    Ok(match args.fit {
        Fit::Box => whole,
        Fit::Visible => fit(&whole, visible(), aspect),
    })
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        camera: CameraArgs,
    }

    fn camera(flags: &str, own: Option<Camera>) -> Result<Camera, ParameterError> {
        let flags = Flags::parse_from(std::iter::once("vr").chain(flags.split_whitespace()));
        let visible = [DVec3::NEG_ONE, DVec3::ONE];
        let bounds = (DVec3::NEG_ONE, DVec3::ONE);
        let sight = Sight { bounds, visible: &|| &visible, aspect: 1.0, info: None, angles: (30.0, 20.0) };
        apply(&flags.camera, own, &sight)
    }

    #[test]
    fn flags_change_what_they_name() {
        let radius = 3.0f64.sqrt();
        let visible = camera("", None).unwrap();
        let whole = camera("--fit box", None).unwrap();
        let height = |camera: Camera| match camera.projection {
            Projection::Orthographic { height } => height,
            Projection::Perspective { .. } => f64::NAN,
        };
        assert!(height(visible) < height(whole));
        assert_eq!(whole.projection, Projection::Orthographic { height: 2.0 * radius });
        let side = camera("--azimuth 90 --elevation 0", None).unwrap();
        assert!((side.eye.normalize() - DVec3::X).length() < 1e-12);
        let near = camera("--fov 60 --fit box", None).unwrap();
        assert!((near.eye.length() - 2.0 * radius).abs() < 1e-12, "farther for a narrower angle");
        let moved = camera("--eye 0,0,-9 --height 4", Some(near)).unwrap();
        assert_eq!((moved.eye, moved.projection), (DVec3::Z * -9.0, Projection::Orthographic { height: 4.0 }));
        assert_eq!(camera("", Some(near)).unwrap(), near);
    }

    #[test]
    fn wrong_flags_are_named() {
        let field = |flags: &str| camera(flags, None).unwrap_err().field;
        assert_eq!(field("--fov 0"), "camera.fov");
        assert_eq!(field("--fov 180 --azimuth 3"), "camera.fov");
        assert_eq!(field("--azimuth nan"), "camera.azimuth");
        assert_eq!(field("--eye 0,0,0"), "camera.eye");
        assert_eq!(field("--up 0,0,0"), "camera.up");
        assert_eq!(field("--height=-1"), "camera.height");
    }
}
