//! One measured point: a renderer under a setting, on a subject.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vr_core::Options;

use crate::figures::ErrorFigures;
use crate::timing::Times;

/// Cost and error of one contestant on one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The subject's name.
    pub subject: String,
    /// The renderer.
    pub renderer: String,
    /// Its setting.
    pub setting: String,
    /// The options that make the setting; all others are at their defaults.
    pub options: Options,
    /// Documented order of convergence; `None` for an exact or an adaptive method.
    pub order: Option<f64>,
    /// Documented error floor.
    pub error_floor: f64,
    /// `None` where nothing was timed.
    pub times: Option<Times>,
    /// Bytes beyond the scene that were needed at once; `None` where nobody counts.
    pub peak_bytes: Option<u64>,
    /// Counts of the work, by name.
    pub counts: BTreeMap<String, u64>,
    /// Against the canonical pixels.
    pub error: ErrorFigures,
    /// Against what the renderer itself integrates, where that is something else.
    pub own_error: Option<ErrorFigures>,
    /// Against the field as a function, where it is known as one.
    pub function_error: Option<ErrorFigures>,
}

impl Point {
    /// `raycast midpoint 0.5`.
    pub fn contestant(&self) -> String {
        format!("{} {}", self.renderer, self.setting)
    }

    /// Milliseconds of a frame and RMSE: where the point lies in a plot. Not finite where nothing was timed.
    pub fn pair(&self) -> (f64, f64) {
        (self.times.map_or(f64::NAN, |t| t.frame.median), self.error.rmse)
    }
}

/// A contestant that cannot draw a subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Refusal {
    /// The contestant.
    pub contestant: String,
    /// What it cannot do.
    pub feature: String,
}
