//! Judgement of error bounds by the counts of a picture.

use vr_core::Counts;

/// True if every pixel of a picture is proven to be within the bound that was asked for.
///
/// # Examples
/// ```
/// use vr_core::Counts;
/// use vr_study::error_bound::is_kept;
///
/// let mut counts = Counts { rays: 20, ..Counts::default() };
/// assert!(is_kept(1e-3, &counts));
/// // Within the bound that was asked for, if not within the stricter one of a renderer's options.
/// counts.count_unbounded(9e-4);
/// assert!(is_kept(1e-3, &counts));
/// counts.count_unbounded(f64::NAN);
/// assert!(!is_kept(1e-3, &counts));
/// ```
pub fn is_kept(max_error: f64, counts: &Counts) -> bool {
    // Options are stricter than the bound that was asked for; storing a pixel as f32 adds to its bound.
    counts.unbounded == 0 || counts.max_unbounded + f64::from(f32::EPSILON) <= max_error
}
