//! Table of all points that other programs read.

use crate::error::StudyError;
use crate::figures::ErrorFigures;
use crate::study::SubjectResult;

const HEADER: [&str; 26] = [
    "subject",
    "renderer",
    "setting",
    "options",
    "documented_order",
    "error_floor",
    "frame_ms_median",
    "frame_ms_least",
    "frame_ms_most",
    "prepare_ms_median",
    "rounds",
    "peak_bytes",
    "rays",
    "samples",
    "rmse",
    "max",
    "bias",
    "p99",
    "psnr_db",
    "pixels",
    "reference_error",
    "reference_error_is",
    "own_model_rmse",
    "own_model_max",
    "function_rmse",
    "function_max",
];

/// Returns points as comma-separated values, one row each below a header; figures that were not measured are empty.
///
/// # Errors
/// No failure is known: memory takes everything.
pub fn csv(results: &[SubjectResult]) -> Result<Vec<u8>, StudyError> {
    let failed = |e: csv::Error| StudyError::Io(std::io::Error::other(e));
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADER).map_err(failed)?;
    let number = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:e}"));
    for p in results.iter().flat_map(|r| &r.points) {
        let options: Vec<String> = p.options.0.iter().map(|(k, v)| format!("{k}={v}")).collect();
        let count = |name: &str| p.counts.get(name).map_or_else(String::new, u64::to_string);
        let pair = |f: &Option<ErrorFigures>| [number(f.as_ref().map(|f| f.rmse)), number(f.as_ref().map(|f| f.max))];
        let [own_rmse, own_max] = pair(&p.own_error);
        let [function_rmse, function_max] = pair(&p.function_error);
        let e = &p.error;
        writer
            .write_record([
                p.subject.clone(),
                p.renderer.clone(),
                p.setting.clone(),
                options.join(" "),
                number(p.order),
                number(Some(p.error_floor)),
                number(p.times.map(|t| t.frame.median)),
                number(p.times.map(|t| t.frame.min)),
                number(p.times.map(|t| t.frame.max)),
                number(p.times.map(|t| t.prepare.median)),
                p.times.map_or_else(String::new, |t| t.rounds.to_string()),
                p.peak_bytes.map_or_else(String::new, |b| b.to_string()),
                count("rays"),
                count("samples"),
                number(Some(e.rmse)),
                number(Some(e.max)),
                number(Some(e.bias)),
                number(Some(e.p99)),
                number(e.psnr),
                e.pixels.to_string(),
                number(Some(e.reference_error)),
                e.reference_error_is.clone(),
                own_rmse,
                own_max,
                function_rmse,
                function_max,
            ])
            .map_err(failed)?;
    }
    writer.into_inner().map_err(|e| StudyError::Io(e.into_error()))
}
