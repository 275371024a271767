//! Measured point: a renderer under a setting, on a subject.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vr_core::Options;

use crate::figures::ErrorFigures;
use crate::timing::Times;

/// Cost and error of one candidate on one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The subject's name.
    pub subject: String,
    /// The renderer.
    pub renderer: String,
    /// Name of the setting.
    pub setting: String,
    /// The options that make the setting; all others are at their defaults.
    pub options: Options,
    /// Documented order of convergence; `None` for an exact or an adaptive method.
    pub order: Option<f64>,
    /// Documented error floor.
    pub error_floor: f64,
    /// Times; `None` where nothing was timed.
    pub times: Option<Times>,
    /// Bytes beyond the scene that were needed at once; `None` where there is no meter.
    pub peak_bytes: Option<u64>,
    /// Counts of the work, by name.
    pub counts: BTreeMap<String, u64>,
    /// Error against the reference.
    pub error: ErrorFigures,
    /// Error against the renderer's own model, where that differs from the scene.
    pub own_error: Option<ErrorFigures>,
    /// Error against the field as a function, where it is known as one.
    pub function_error: Option<ErrorFigures>,
}

impl Point {
    /// Returns the full name of the candidate, such as `raycast midpoint 0.5`.
    pub fn candidate(&self) -> String {
        format!("{} {}", self.renderer, self.setting)
    }

    /// Returns the place of the point in a plot: milliseconds of a frame, and RMSE. Not finite where nothing was timed.
    pub fn pair(&self) -> (f64, f64) {
        (self.times.map_or(f64::NAN, |t| t.frame.median), self.error.rmse)
    }
}

/// Refusal of a candidate that cannot draw a subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// The candidate.
    #[serde(rename = "contestant")]
    pub candidate: String,
    /// The feature that it lacks.
    pub feature: String,
}
