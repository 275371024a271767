//! Flags over the keys of `[camera]`.

use vr_core::ParameterError;
use vr_io::{CameraSection, ProjectionName, USUAL_FOV};

use crate::args::{CameraArgs, Fit};

/// Returns the keys of a camera as flags change them: each flag sets its own key, and what does not go with that goes.
///
/// # Errors
/// Flags that do not go together.
pub fn overridden(args: &CameraArgs, own: CameraSection) -> Result<CameraSection, ParameterError> {
    match (args.projection, args.fov, args.height) {
        (Some(ProjectionName::Orthographic), Some(fov), _) => {
            return Err(ParameterError::new("camera.fov", fov, "an orthographic camera has a height, not an angle"));
        }
        (Some(ProjectionName::Perspective), _, Some(height)) => {
            return Err(ParameterError::new("camera.height", height, "a perspective camera has a fov, not a height"));
        }
        _ => {}
    }
    let mut section = own;
    if (args.azimuth.is_some() || args.elevation.is_some()) && own.eye.is_some() {
        // Angles take the place of the eye, and show everything: what was right from there goes with it.
        section = CameraSection { projection: own.projection, fov: own.fov, ..CameraSection::default() };
    }
    if args.fit == Fit::Box && section.is_framed() {
        section.height = None;
    }
    if args.eye.is_some() {
        (section.azimuth, section.elevation) = (None, None);
    }
    section.azimuth = args.azimuth.or(section.azimuth);
    section.elevation = args.elevation.or(section.elevation);
    section.eye = args.eye.map(Into::into).or(section.eye);
    section.target = args.target.map(Into::into).or(section.target);
    section.up = args.up.map(Into::into).or(section.up);
    section.projection = match (args.projection, args.fov, args.height) {
        (Some(projection), ..) => projection,
        (None, Some(_), _) => ProjectionName::Perspective,
        (None, None, Some(_)) => ProjectionName::Orthographic,
        (None, None, None) => section.projection,
    };
    match (own.projection, section.projection) {
        (ProjectionName::Orthographic, ProjectionName::Perspective) => section.height = None,
        (ProjectionName::Perspective, ProjectionName::Orthographic) => {
            let fov = section.fov.take().unwrap_or(USUAL_FOV);
            // What lies at the target keeps its size.
            let distance = section.eye.zip(section.target).map(|(eye, target)| eye.distance(target));
            section.height = distance.map(|distance| 2.0 * distance * (0.5 * fov.to_radians()).tan());
        }
        _ => {}
    }
    section.height = args.height.or(section.height);
    section.fov = args.fov.or(section.fov);
    Ok(section)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use glam::DVec3;

    use super::*;

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        camera: CameraArgs,
    }

    fn section(flags: &str, own: CameraSection) -> Result<CameraSection, ParameterError> {
        let flags = Flags::parse_from(std::iter::once("vr").chain(flags.split_whitespace()));
        overridden(&flags.camera, own)
    }

    const ORTHOGRAPHIC: ProjectionName = ProjectionName::Orthographic;
    const PERSPECTIVE: ProjectionName = ProjectionName::Perspective;

    #[test]
    fn a_flag_changes_its_own_key_alone() {
        let own = CameraSection {
            azimuth: Some(1.0),
            elevation: Some(2.0),
            target: Some(DVec3::X),
            height: Some(3.0),
            ..CameraSection::default()
        };
        for (flags, expected) in [
            ("", own),
            ("--azimuth 9", CameraSection { azimuth: Some(9.0), ..own }),
            ("--elevation 9", CameraSection { elevation: Some(9.0), ..own }),
            ("--target 0,1,0", CameraSection { target: Some(DVec3::Y), ..own }),
            ("--up 0,0,1", CameraSection { up: Some(DVec3::Z), ..own }),
            ("--height 9", CameraSection { height: Some(9.0), ..own }),
            ("--projection orthographic", own),
            // What does not go with it goes.
            ("--eye 0,0,9", CameraSection { eye: Some(DVec3::Z * 9.0), azimuth: None, elevation: None, ..own }),
            ("--projection perspective", CameraSection { projection: PERSPECTIVE, height: None, ..own }),
            ("--fov 9", CameraSection { projection: PERSPECTIVE, height: None, fov: Some(9.0), ..own }),
        ] {
            assert_eq!(section(flags, own), Ok(expected), "{flags}");
        }
        let perspective = CameraSection { projection: PERSPECTIVE, height: None, fov: Some(50.0), ..own };
        for (flags, expected) in [
            ("--azimuth 9", CameraSection { azimuth: Some(9.0), ..perspective }),
            ("--projection perspective --fit box", perspective),
            ("--height 9", CameraSection { projection: ORTHOGRAPHIC, fov: None, height: Some(9.0), ..perspective }),
            ("--projection orthographic", CameraSection { projection: ORTHOGRAPHIC, fov: None, ..perspective }),
        ] {
            assert_eq!(section(flags, perspective), Ok(expected), "{flags}");
        }
    }

    #[test]
    fn angles_show_everything_again_and_the_target_keeps_its_size() {
        let place = CameraSection { eye: Some(DVec3::Z * 4.0), target: Some(DVec3::ZERO), ..CameraSection::default() };
        let placed = CameraSection { up: Some(DVec3::Y), height: Some(3.0), ..place };
        let seen_from = CameraSection { azimuth: Some(9.0), ..CameraSection::default() };
        assert_eq!(section("--azimuth 9", placed), Ok(seen_from));
        let perspective = CameraSection { projection: PERSPECTIVE, fov: Some(90.0), ..place };
        let seen_from = CameraSection { projection: PERSPECTIVE, fov: Some(90.0), ..seen_from };
        assert_eq!(section("--azimuth 9", perspective), Ok(seen_from));
        let flat = section("--projection orthographic", perspective).unwrap();
        assert!((flat.height.unwrap() - 8.0).abs() < 1e-12 && flat.fov.is_none());
        // The extent that is asked for is that of the box.
        let framed = CameraSection { height: Some(3.0), ..CameraSection::default() };
        assert_eq!(section("--fit box", framed), Ok(CameraSection::default()));
        assert_eq!(section("--fit box", placed), Ok(placed));
    }

    #[test]
    fn flags_that_do_not_go_together_are_named() {
        let field = |flags: &str| section(flags, CameraSection::default()).unwrap_err().field;
        assert_eq!(field("--projection orthographic --fov 9"), "camera.fov");
        assert_eq!(field("--projection perspective --height 9"), "camera.height");
    }
}
