//! Error map of `vr render --error-map`: where a picture is wrong, and by how much.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vr_core::Frame;
use vr_io::PngOptions;
use vr_physics::spread;
use vr_study::reference::{ReferencePixels, SUBGRID};

use crate::args::{ErrorMeasure, OutputArgs};
use crate::failure::Failure;
use crate::{heat_map, inputs, output_file};

/// Error map that was written.
#[derive(Debug, Serialize)]
pub struct ErrorMap {
    path: PathBuf,
    /// Number of pixels at which the error is known; between them it is interpolated.
    known_pixels: usize,
    /// True if the error of other pixels is interpolated.
    interpolated: bool,
    /// True if the noise of random paths hides small errors.
    has_noise: bool,
}

/// Checks, before the work begins, that the map can be drawn and written.
///
/// # Errors
/// A name that tells no format, a place that cannot be, a picture that goes there, too, or no pixels to compare.
pub fn check(output: &OutputArgs) -> Result<(), Failure> {
    let Some(path) = &output.error_map else { return Ok(()) };
    output_file::check(path, &["png", "exr"])?;
    if output.error == ErrorMeasure::None {
        return Err(Failure::usage("--error-map: no pixels are compared; must go with --error subgrid or full"));
    }
    output.outputs.iter().try_for_each(|picture| inputs::apart(("--error-map", path), ("the picture", picture)))
}

/// Draws and writes the map of a frame's error against its reference, which was solved on all pixels or on the subgrid.
///
/// PNG: the largest error of any component, in units of max(1, largest magnitude of the solution), interpolated on its
/// logarithmic scale; grey where noise hides it. EXR: frame − solution per component in the same units, interpolated as it is.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, exact: &ReferencePixels, frame: &Frame) -> Result<ErrorMap, Failure> {
    let size = frame.size();
    let all = size[0] as usize * size[1] as usize;
    let known = exact.count();
    // Which of the two it is follows from the number, but where both are the same.
    let n = if known == all { u32::MAX } else { SUBGRID };
    let map = if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        let errors = spread(n, size, &exact.signed(frame)).into_iter().map(|e| e.map(|c| c as f32)).collect();
        Frame::new(size, errors, None)
    } else {
        heat_map::draw(size, exact.error_map(frame, n))
    };
    vr_io::write(path, &map, &PngOptions::default()).map_err(Failure::failed)?;
    Ok(ErrorMap { path: path.into(), known_pixels: known, interpolated: known < all, has_noise: exact.has_noise() })
}

impl ErrorMap {
    /// Returns one line for people.
    pub fn text(&self, all: u64) -> String {
        let how = if self.interpolated {
            format!("interpolated between {} of {all} pixels", self.known_pixels)
        } else {
            "at every pixel".to_owned()
        };
        let noise = if self.has_noise { "; grey: no more than chance makes" } else { "" };
        format!("map      {}: error {how}{noise}\n", self.path.display())
    }
}
