//! Pictures that a session gives, with what is known of them.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;
use vr_core::{Control, Frame, Model, RenderError, Rendered, Scene, View};
use vr_physics::Reference;
use vr_physics::metrics::{Metrics, subgrid};
use vr_study::error_bound::is_kept;
use vr_study::reference::ReferencePixels;

use super::navigation::height_at_target;

/// Number of a client of a session.
pub type ClientId = u64;

/// Picture as a screen shows it, with its time and its error.
#[derive(Clone, Debug)]
pub struct Picture {
    /// All that is said of it.
    pub head: Head,
    /// Red, green, blue and 255 of each pixel, row by row from the top: those of the PNG that `vr render` writes.
    pub rgba: Vec<u8>,
    /// Number of the last edit that it shows, of each client.
    pub answers: BTreeMap<ClientId, u64>,
}

/// Description of a picture.
#[derive(Clone, Debug, Serialize)]
pub struct Head {
    /// Number of the picture.
    pub picture: u64,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Width and height of the picture at rest.
    pub full_size: [u32; 2],
    /// Stage of refinement.
    pub stage: Stage,
    /// Name of the renderer.
    pub renderer: String,
    /// Milliseconds from the call of `render` to its frame.
    pub milliseconds: f64,
    /// Milliseconds of what had to be prepared before, none of which the next view needs again.
    pub prepare_milliseconds: f64,
    /// Error of the picture.
    pub error: PictureError,
    /// Orientation and scale, for marks over the picture.
    pub camera: Orientation,
}

/// Stage of a picture's refinement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Stage {
    /// While something moves: as many pixels as thirty pictures a second leave.
    Draft,
    /// At rest, on the way to all pixels: twice as many along each side as the picture before.
    Finer,
    /// All pixels, by the renderer's own setting.
    Sharp,
    /// The same, after its error was measured.
    Measured,
    /// All pixels, each within an error bound.
    Proven,
}

/// Error of a picture against the correct one, in units of max(1, its largest magnitude), and how it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum PictureError {
    /// Nothing is known yet.
    Unknown,
    /// The RMSE of the last picture of this stage that was compared with a better one; of another view, or another scene.
    Estimated {
        /// RMSE.
        rmse: f64,
    },
    /// Compared with the reference.
    Measured {
        /// RMSE of the pixels compared.
        rmse: f64,
        /// Largest error of these.
        max: f64,
        /// Number of pixels compared.
        pixels: usize,
        /// Number of pixels of the picture.
        of: u64,
    },
    /// Every pixel is proven to be within a bound.
    Proven {
        /// The bound of every pixel.
        bound: f64,
        /// RMSE of the pixels that were compared with the reference besides.
        rmse: Option<f64>,
    },
    /// The bound that was asked for is not proven for every pixel.
    Unproven {
        /// The bound that was asked for.
        bound: f64,
        /// Rays for which it is not proven.
        rays: u64,
        /// Largest bound of any of these; `None` where one has none.
        largest: Option<f64>,
        /// RMSE of the pixels that were compared with the reference besides.
        rmse: Option<f64>,
    },
}

/// Solves the pixels that a picture at rest is compared with: few enough that it takes a second at most. `None` for scenes without a reference, which are drawn all the same.
///
/// # Errors
/// Those of [`ReferencePixels::solve`], but [`RenderError::Unsupported`].
pub(super) fn compared(
    (scene, view): (&Scene, &View),
    control: &Control,
) -> Result<Option<ReferencePixels>, RenderError> {
    /// Parts along each side of the picture, of each of which a pixel is solved.
    const PARTS: u32 = 20;
    /// Tolerance of the reference, a thousandth of the error that pictures at rest aim at.
    const TOLERANCE: f64 = 1e-6;
    let pixels = subgrid(PARTS, view.size);
    match ReferencePixels::solve_by(&Reference::new(TOLERANCE), (scene, view), &Model::Canonical, pixels, control) {
        Err(RenderError::Unsupported(_)) => Ok(None),
        solved => solved.map(Some),
    }
}

impl PictureError {
    /// Error of a frame that was compared with the reference.
    pub(super) fn measured(reference: &ReferencePixels, frame: &Frame) -> Self {
        let Metrics { rmse, max, .. } = reference.judge(frame);
        let [w, h] = frame.size().map(u64::from);
        Self::Measured { rmse, max, pixels: reference.count(), of: w * h }
    }

    /// Error of a picture that was drawn under a bound, and compared with the reference where there is one.
    pub(super) fn under_bound(bound: f64, rendered: &Rendered, reference: Option<&ReferencePixels>) -> Self {
        let counts = &rendered.stats.counts;
        let rmse = reference.map(|reference| reference.judge(&rendered.frame).rmse);
        if is_kept(bound, counts) {
            return Self::Proven { bound, rmse };
        }
        let largest = Some(counts.max_unbounded).filter(|bound| bound.is_finite());
        Self::Unproven { bound, rays: counts.unbounded, largest, rmse }
    }
}

/// Orientation and scale of a view.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Orientation {
    /// World position of the eye.
    pub eye: DVec3,
    /// World vector to the right in the picture.
    pub right: DVec3,
    /// World vector up in the picture.
    pub up: DVec3,
    /// World vector along the line of sight.
    pub forward: DVec3,
    /// World height of the picture at the target.
    pub height: f64,
    /// Vertical angle in degrees; `None` for parallel rays.
    pub fov: Option<f64>,
}

impl Orientation {
    /// Orientation of a view whose camera is valid.
    pub(super) fn of(view: &View) -> Self {
        let camera = &view.camera;
        let frame = camera.frame().unwrap_or_default();
        let fov = match camera.projection {
            vr_core::Projection::Perspective { fov } => Some(fov),
            vr_core::Projection::Orthographic { .. } => None,
        };
        let (right, up, forward) = (frame.x_axis, frame.y_axis, frame.z_axis);
        Self { eye: camera.eye, right, up, forward, height: height_at_target(camera), fov }
    }
}
