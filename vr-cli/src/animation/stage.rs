//! The scene of an animation, as cameras need to know it.

use glam::DVec3;
use vr_core::{Camera, Projection};
use vr_io::FileInfo;
use vr_look::Survey;

use crate::args::{CameraArgs, Fit};
use crate::scene_setup::Setup;

/// Things to be shown, and the freedom of the cameras that show them.
pub struct Stage<'a> {
    /// The camera of a still picture.
    pub camera: Camera,
    /// True if nothing places the camera but angles: it goes where everything visible is seen.
    pub is_free: bool,
    /// True if flags place the camera at a point: angles cannot.
    pub is_placed: bool,
    /// True if angles alone would make a camera free: flags give it neither a place nor a height, nor ask for the box.
    pub fits: bool,
    /// Unit vector that is up.
    pub up: DVec3,
    /// World positions that enclose all that is visible, where cameras may be fitted to it.
    pub visible: Vec<DVec3>,
    /// Width of the picture over its height.
    pub aspect: f64,
    bounds: (DVec3, DVec3),
    info: Option<&'a FileInfo>,
    has_height: bool,
    usual_angles: (f64, f64),
}

impl<'a> Stage<'a> {
    /// Looks at a scene that is set up.
    pub fn new(args: &CameraArgs, setup: &'a Setup) -> Self {
        let (scene, view) = (&setup.scene, &setup.view);
        let is_placed = args.eye.is_some() || args.target.is_some() || args.up.is_some();
        let has_angles = args.azimuth.is_some() || args.elevation.is_some();
        let section = setup.file.camera.unwrap_or_default();
        let by_angles = !is_placed && (has_angles || section.is_framed());
        let has_height = args.height.is_some() || (section.is_framed() && section.height.is_some());
        let fits = !is_placed && !has_height && args.fit == Fit::Visible;
        let bounds = scene.bounds();
        let upright = vr_io::framing(bounds, setup.info.as_ref(), (0.0, 0.0), None).up;
        let mut stage = Self {
            camera: view.camera,
            is_free: by_angles && fits,
            is_placed,
            fits,
            up: if by_angles { upright } else { view.camera.up.normalize() },
            visible: Vec::new(),
            aspect: view.aspect(),
            bounds,
            info: setup.info.as_ref(),
            has_height,
            usual_angles: section.angles(vr_io::default_angles(setup.info.as_ref())),
        };
        // A camera of the scene file is free to follow keys with angles.
        if fits {
            stage.visible = Survey::of(&scene.volume).visible(&scene.transfer, scene.compositing, &view.clip);
            let surfaces = scene.surfaces.as_ref().map(|surfaces| surfaces.bounds());
            stage.visible.extend(surfaces.into_iter().flat_map(corners));
        }
        stage
    }

    /// Returns the angles in degrees of a still picture that nothing places.
    pub fn usual_angles(&self) -> (f64, f64) {
        self.usual_angles
    }

    /// Returns a camera that sees the whole box from an azimuth and elevation in degrees, of the still picture's kind.
    pub fn around(&self, angles: (f64, f64)) -> Camera {
        let fov = match self.camera.projection {
            Projection::Perspective { fov } => Some(fov),
            Projection::Orthographic { .. } => None,
        };
        let whole = vr_io::framing(self.bounds, self.info, angles, fov);
        // A height that a flag gives is kept.
        if self.has_height { Camera { projection: self.camera.projection, ..whole } } else { whole }
    }
}

/// Corners of a box.
fn corners((low, high): (DVec3, DVec3)) -> impl Iterator<Item = DVec3> {
    let choose = move |i: usize, axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
    (0..8).map(move |i| DVec3::new(choose(i, 0), choose(i, 1), choose(i, 2)))
}
