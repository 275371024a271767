//! `vr diff`: the difference of two pictures, wherever they come from.

mod comparison;
#[cfg(feature = "flip")]
mod flip;
mod report;
mod screen;

use std::path::Path;

use vr_core::Frame;
use vr_io::{Picture, PngOptions, read_picture};

use crate::args::DiffArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::inputs::Inputs;
use crate::{heat_map, number, output_file};

use comparison::Comparison;
use report::{Report, Side};

/// Reads, compares, draws, and prints.
///
/// # Errors
/// Any fault of the command line, the pictures, or the files to be written; pictures of different sizes; and an RMSE
/// above the one that is allowed, after everything else is done.
pub fn run(args: &DiffArgs, console: Console) -> Result<(), Failure> {
    // Check the command line and the files before anything is computed.
    let inputs = Inputs::new("a picture to be compared", [args.reference.clone(), args.picture.clone()]);
    for path in &args.outputs {
        output_file::check(path, &["png", "exr"])?;
        inputs.permit("--output", path, args.replace)?;
    }
    if !args.background.iter().all(|c| c.is_finite()) {
        return Err(Failure::usage(format!("--background: found {:?}; must be finite", args.background)));
    }
    // Read both pictures, which must have one size.
    let read = |path: &Path| read_picture(path, args.encode.into()).map_err(Failure::failed);
    let (reference, picture) = (read(&args.reference)?, read(&args.picture)?);
    let [a, b] = [reference.frame.size(), picture.frame.size()];
    if a != b {
        return Err(Failure::failed(format!(
            "pictures of different sizes cannot be compared: {} has {}x{} pixels, {} has {}x{}",
            args.reference.display(),
            a[0],
            a[1],
            args.picture.display(),
            b[0],
            b[1]
        )));
    }
    // Compare, and write the maps.
    let comparison = Comparison::new(&reference, &picture, args.background);
    for path in &args.outputs {
        vr_io::write(path, &map(path, &comparison), &PngOptions::default()).map_err(Failure::failed)?;
    }
    // Measure both as a screen shows them, and print.
    let shown = |p: &Picture| screen::shown(&p.frame, args.background);
    let [a, b] = [shown(&reference), shown(&picture)];
    let report = Report {
        reference: Side::new(&args.reference, &reference, args.encode),
        picture: Side::new(&args.picture, &picture, args.encode),
        comparison: &comparison,
        background: args.background,
        ssim: vr_physics::ssim(comparison.size, &screen::luma(&a), &screen::luma(&b)),
        #[cfg(feature = "flip")]
        flip: flip::mean(comparison.size, &a, &b),
        outputs: &args.outputs,
    };
    console.result(&report.text(), &report.json())?;
    let rmse = comparison.metrics.rmse;
    match args.fail_above {
        Some(max_rmse) if rmse > max_rmse => Err(Failure::failed(format!(
            "{}: RMSE {} is above {}",
            args.picture.display(),
            number::small(rmse),
            number::small(max_rmse)
        ))),
        _ => Ok(()),
    }
}

/// Returns the picture of the difference that a name asks for.
fn map(path: &Path, comparison: &Comparison) -> Frame {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        let signed = comparison.differences().map(|e| e.map(|c| c as f32)).collect();
        Frame::new(comparison.size, signed, None)
    } else {
        heat_map::draw(comparison.size, comparison.errors())
    }
}
