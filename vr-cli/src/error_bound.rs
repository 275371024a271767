//! Outcome of an error bound (`--max-error`).

use serde::Serialize;
use vr_core::Counts;
use vr_study::error_bound::is_kept;

use crate::failure::Failure;
use crate::number;

/// The error bound of a picture, and its outcome.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ErrorBound {
    /// Bound of the error of every pixel, in units of max(1, the picture's largest magnitude).
    max_error: f64,
    /// True if every pixel is proven to be within it.
    kept: bool,
    /// Rays that are not proven to be within it.
    unbounded: u64,
    /// Largest bound of any of these; `null` where one has none.
    max_bound: Option<f64>,
    /// Rays that meet the volume.
    #[serde(skip)]
    rays: u64,
    /// True if each pixel is one ray.
    #[serde(skip)]
    one_ray: bool,
}

impl ErrorBound {
    /// Judges a bound by the counts of the picture, of which each pixel is the mean of `supersampling`² rays.
    pub fn new(max_error: f64, counts: &Counts, supersampling: u32) -> Self {
        let Counts { rays, unbounded, max_unbounded, .. } = *counts;
        let kept = is_kept(max_error, counts);
        let max_bound = (unbounded > 0 && max_unbounded.is_finite()).then_some(max_unbounded);
        Self {
            max_error,
            kept,
            unbounded: if kept { 0 } else { unbounded },
            max_bound,
            rays,
            one_ray: supersampling == 1,
        }
    }

    /// Returns the outcome in one line.
    pub fn line(&self) -> String {
        let error = number::small(self.max_error);
        if self.kept {
            return format!("error bound proven: every pixel within {error}");
        }
        let what = if self.one_ray { "pixels" } else { "rays (pixels are means of several)" };
        let by_how_much = match self.max_bound {
            Some(bound) => format!("the largest bound found there is {}", number::small(bound)),
            None => "no bound at all was found for some of them".to_owned(),
        };
        format!(
            "error bound not proven: {} of {} {what} could not be proven to be within {error}; {by_how_much}",
            number::count(self.unbounded),
            number::count(self.rays)
        )
    }

    /// Ends the command with an exit code of its own where the bound is not proven.
    ///
    /// # Errors
    /// [`Failure::Unproven`].
    pub fn outcome(&self) -> Result<(), Failure> {
        if self.kept { Ok(()) } else { Err(Failure::Unproven(self.line())) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_ray_breaks_a_bound() {
        let mut counts = Counts { rays: 20, ..Counts::default() };
        assert!(ErrorBound::new(1e-3, &counts, 1).outcome().is_ok());
        // Within the bound that was asked for, if not within the stricter one of the options.
        counts.count_unbounded(9e-4);
        assert!(ErrorBound::new(1e-3, &counts, 1).outcome().is_ok());
        counts.count_unbounded(0.25);
        let line = ErrorBound::new(1e-3, &counts, 1).outcome().unwrap_err().to_string();
        assert!(line.contains("2 of 20 pixels") && line.contains("2.50e-1"), "{line}");
        counts.count_unbounded(f64::NAN);
        let line = ErrorBound::new(1e-3, &counts, 2).line();
        assert!(line.contains("3 of 20 rays") && line.contains("no bound at all"), "{line}");
    }
}
