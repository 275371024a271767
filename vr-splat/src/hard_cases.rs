//! What the hard cases of `vr-physics` may cost: the largest errors that the documentation allows itself.

use crate::splatting::Splatting;

impl Splatting {
    /// See [`vr_core::Renderer::hard_case_error`]: measured errors of the default settings, and half as much again.
    pub(crate) fn documented_error(&self, case: &str) -> Option<f64> {
        if *self != Self::default() {
            return None;
        }
        Some(match case {
            "opaque-wall" | "thin-shell" => 1.0,
            _ => return None,
        })
    }
}
