//! A volume as the uniform grid that it is resampled to, and the error of its picture.

use serde::Serialize;
use vr_core::resample::{Correction, ResampleError, Resampled, Resampling, Resolution, resample};
use vr_core::{Control, Model, Scene, Volume};
use vr_io::{LoadedVolume, ResampleSection, SceneFile};
use vr_physics::metrics::subgrid;
use vr_study::figures::ErrorFigures;
use vr_study::reference::ReferencePixels;

use crate::args::ErrorMeasure;
use crate::console::Console;
use crate::failure::Failure;
use crate::progress::under_bar;
use crate::{number, renderers};

/// Size of the picture of which the error is measured.
const SIZE: [u32; 2] = [256, 256];
/// Parts along each side of the picture, of each of which a pixel is compared.
const PARTS: u32 = 48;

/// Resamples a volume.
///
/// # Errors
/// A resolution that makes no grid, or a volume that cannot be resampled.
pub fn run(volume: &Volume, choices: &Resampling, console: Console, control: &Control) -> Result<Resampled, Failure> {
    let made = under_bar(console, control, "resampling", |control| resample(volume, choices, control));
    made.map_err(|e| match e {
        ResampleError::Cancelled => Failure::failed(e),
        _ => Failure::usage(format!("--resample: {e}")),
    })
}

/// Account of a resampling in results.
#[derive(Serialize)]
pub struct Account {
    dims: [usize; 3],
    filter: &'static str,
    /// Part of the voxels that is vacuum.
    vacuum_share: f64,
    /// Integral of the field, of the volume and of the grid.
    integral: [f64; 2],
    /// False if that of the volume is an estimate.
    integral_is_exact: bool,
    /// Their difference by that of the volume.
    integral_error: f64,
    /// Factor on every voxel that conserves the integral, if there is one.
    factor: Option<f64>,
    /// Addend to every voxel that conserves the integral, if there is one.
    shift: Option<f64>,
    /// Error of the picture of the grid against the reference of the volume itself, if it was measured.
    picture: Option<ErrorFigures>,
}

impl Account {
    pub fn new(resampled: &Resampled, picture: Option<ErrorFigures>) -> Self {
        let finite = |x: f64| if x.is_finite() { x } else { f64::MAX };
        Self {
            dims: resampled.grid.dims(),
            filter: resampled.choices.filter.name(),
            vacuum_share: resampled.vacuum_share(),
            integral: [resampled.before.value, resampled.after.value],
            integral_is_exact: resampled.before.is_exact,
            integral_error: finite(resampled.integral_error()),
            factor: if let Some(Correction::Factor(f)) = resampled.correction { Some(f) } else { None },
            shift: if let Some(Correction::Shift(s)) = resampled.correction { Some(s) } else { None },
            picture,
        }
    }
}

/// Error of the picture of a resampled volume: drawn with defaults, against the reference of the volume as it was, in the view and look that
/// it has where none is named; `None` if no pixels are compared.
///
/// # Errors
/// Any fault of the scene.
pub fn picture_error(
    loaded: &LoadedVolume,
    resampled: &Resampled,
    measure: ErrorMeasure,
    console: Console,
    control: &Control,
) -> Result<Option<ErrorFigures>, Failure> {
    let mut file = SceneFile::default();
    file.image.size = SIZE;
    let around = vr_io::resolve_scene_around(&file, std::path::Path::new(""), loaded.clone());
    let whole = around.map_err(Failure::failed)?;
    let (scene, view) = (&whole.scene, &whole.view);
    let pixels = match measure {
        ErrorMeasure::None => return Ok(None),
        ErrorMeasure::Subgrid => subgrid(PARTS, view.size),
        ErrorMeasure::Full => subgrid(u32::MAX, view.size),
    };
    let exact = under_bar(console, control, "measuring the error", |control| {
        ReferencePixels::solve((scene, view), &Model::Canonical, pixels, control)
    });
    let exact = exact.map_err(Failure::failed)?;
    let drawn = Scene { volume: Volume::from(resampled.grid.clone()), ..scene.clone() };
    let renderer = renderers::named(renderers::usual(&drawn)).map_err(Failure::failed)?;
    let frame = under_bar(console, control, "drawing the grid", |control| {
        renderer.prepare(&drawn, control)?.render(view, control)
    });
    let frame = frame.map_err(Failure::failed)?.frame;
    Ok(Some(ErrorFigures::new(&exact, &frame)))
}

/// Returns the note on the error of the picture.
pub fn picture_note(picture: &ErrorFigures) -> String {
    let (rmse, max) = (number::small(picture.rmse), number::small(picture.max));
    format!("resampled: its picture differs from that of the volume itself by RMSE {rmse}, at most {max}")
}

/// Returns the flags that resample a volume as a section of a scene file does.
pub fn flags(section: &ResampleSection) -> Vec<String> {
    let size = match section.choices().resolution {
        Resolution::Finest => "finest".to_owned(),
        Resolution::Dims(dims) => number::triple(dims, "x"),
        Resolution::Spacing(spacing) => spacing.to_string(),
    };
    let mut flags =
        vec!["--resample".to_owned(), size, "--resample-filter".to_owned(), section.filter.name().to_owned()];
    flags.extend(section.conserve.then(|| "--conserve".to_owned()));
    flags
}
