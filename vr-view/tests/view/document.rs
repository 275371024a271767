//! Documents: what edits change, what they refuse, and how they are taken back.

use vr_core::ControlPoint;
use vr_view::session::{Edit, EditError, Quality};

use crate::common::document;

fn points(opacity: f64) -> Vec<ControlPoint> {
    vec![ControlPoint::new(0.0, [0.2, 0.4, 0.6], 0.0), ControlPoint::new(1.0, [1.0, 0.5, 0.0], opacity)]
}

#[test]
fn edits_are_undone_gesture_by_gesture() {
    let mut d = document("fog", 8, [32, 32]);
    let start = d.file();
    let transfer = |opacity| Edit::Transfer { points: points(opacity) };
    // A drag of many edits is one change.
    d.apply(&Edit::Gesture { begins: true }).unwrap();
    for opacity in [0.1, 0.2, 0.3] {
        d.apply(&transfer(opacity)).unwrap();
    }
    d.apply(&Edit::Gesture { begins: false }).unwrap();
    d.apply(&transfer(0.9)).unwrap();
    d.apply(&Edit::Orbit { right: 90.0, up: 0.0 }).unwrap();
    let turned = d.view().camera;
    assert_eq!(d.history(), [true, false]);
    let opacity = |d: &vr_view::session::Document| d.scene().transfer.points()[1].opacity;
    d.apply(&Edit::Undo).unwrap();
    assert_eq!(opacity(&d), 0.3);
    d.apply(&Edit::Undo).unwrap();
    assert_eq!((d.file().transfer, d.history()), (start.transfer, [false, true]));
    assert!(matches!(d.apply(&Edit::Undo), Err(EditError::NoHistory(_))));
    d.apply(&Edit::Redo).unwrap();
    d.apply(&Edit::Redo).unwrap();
    assert_eq!((opacity(&d), d.history()), (0.9, [true, false]));
    assert_eq!(d.view().camera, turned, "the camera is not part of what is undone");
    // A new change leaves nothing to make again.
    d.apply(&Edit::Undo).unwrap();
    d.apply(&transfer(0.5)).unwrap();
    assert!(matches!(d.apply(&Edit::Redo), Err(EditError::NoHistory(_))));
    // An edit that changes nothing is none.
    d.apply(&transfer(0.5)).unwrap();
    d.apply(&Edit::Undo).unwrap();
    assert_eq!(opacity(&d), 0.3);
}

#[test]
fn what_is_refused_changes_nothing() {
    let mut d = document("fog", 8, [32, 32]);
    let (file, revision) = (d.file(), d.scene_revision());
    let wrong = vec![ControlPoint::new(1.0, [1.0; 3], 0.5), ControlPoint::new(0.0, [1.0; 3], 2.0)];
    for edit in [
        Edit::Transfer { points: wrong },
        Edit::Transfer { points: Vec::new() },
        Edit::UnitDistance { length: -1.0 },
        Edit::Preset { name: "viridus".to_owned() },
        Edit::Crop { corners: Some([[0.5; 3], [-0.5; 3]]) },
        Edit::Planes { planes: vec![vr_core::Plane { normal: glam::DVec3::ZERO, offset: 0.0 }] },
        Edit::Background { color: [f32::NAN, 0.0, 0.0] },
        Edit::Renderer { name: "oracle".to_owned() },
        Edit::Size { size: [0, 5] },
        Edit::Size { size: [8192, 8192] },
        Edit::Zoom { factor: 0.0, at: [0.0; 2] },
        Edit::FieldOfView { degrees: 180.0 },
        Edit::Camera { camera: vr_io::CameraSection::default() },
        Edit::Orbit { right: f64::NAN, up: 0.0 },
    ] {
        let refused = d.apply(&edit).map(|change| format!("{change:?}"));
        assert!(refused.is_err(), "{edit:?} is {refused:?}");
        assert!(!refused.unwrap_err().to_string().is_empty());
        assert_eq!((d.file(), d.scene_revision(), d.history()), (file.clone(), revision, [false; 2]), "{edit:?}");
    }
}

#[test]
fn narrow_pictures_show_what_was_to_be_seen() {
    let mut d = document("fog", 8, [32, 32]);
    let height = |d: &vr_view::session::Document| d.view().camera.projection.height();
    let start = height(&d);
    for (size, factor) in [([100, 50], 1.0), ([50, 100], 2.0), ([64, 64], 1.0)] {
        d.apply(&Edit::Size { size }).unwrap();
        assert!((height(&d) / start - factor).abs() < 1e-12, "{size:?}");
    }
    // A camera that was moved stays as it is, until it is reset.
    d.apply(&Edit::Orbit { right: 1.0, up: 0.0 }).unwrap();
    d.apply(&Edit::Size { size: [50, 100] }).unwrap();
    assert!((height(&d) / start - 1.0).abs() < 1e-12);
    d.apply(&Edit::ResetCamera).unwrap();
    assert!((height(&d) / start - 2.0).abs() < 1e-12);
}

#[test]
fn a_name_that_is_nearly_right_is_named() {
    let mut d = document("fog", 8, [32, 32]);
    let refused = d.apply(&Edit::Preset { name: "viridus".to_owned() }).map(|_| ()).unwrap_err().to_string();
    assert!(refused.contains("viridis"), "{refused}");
}

#[test]
fn qualities_are_those_of_the_renderer() {
    let mut d = document("fog", 8, [32, 32]);
    assert_eq!(d.quality(), Some(Quality::Proven));
    assert_eq!(d.qualities(), [Quality::Draft, Quality::Normal, Quality::Fine, Quality::Proven]);
    d.apply(&Edit::Quality { quality: Quality::Fine }).unwrap();
    assert_eq!((d.quality(), d.file().render.max_error), (Some(Quality::Fine), None));
    assert!(d.qualities().contains(&Quality::Proven));
    d.apply(&Edit::Quality { quality: Quality::Proven }).unwrap();
    assert_eq!((d.quality(), d.file().render.max_error), (Some(Quality::Proven), Some(4e-3)));
    d.apply(&Edit::Undo).unwrap();
    // Shear-warp promises nothing, and has no settings by error.
    d.apply(&Edit::Renderer { name: "shearwarp".to_owned() }).unwrap();
    assert_eq!((d.quality(), d.qualities(), d.file().render.max_error), (None, Vec::new(), None));
    for quality in [Quality::Fine, Quality::Proven] {
        assert!(d.apply(&Edit::Quality { quality }).is_err());
    }
    d.apply(&Edit::Renderer { name: "raycast".to_owned() }).unwrap();
    assert_eq!(d.quality(), Some(Quality::Proven));
    d.apply(&Edit::Undo).unwrap();
    d.apply(&Edit::Undo).unwrap();
    assert_eq!(d.quality(), Some(Quality::Fine));
}
