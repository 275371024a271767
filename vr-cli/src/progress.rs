//! Progress bars on a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use vr_core::Control;

use crate::console::Console;

/// Number of steps of a bar; renderers report fractions.
const STEPS: u64 = 1000;

/// Runs work under a bar with a label. The bar is drawn on stderr where that is a terminal, and gone when the work is done.
pub fn under_bar<T>(console: Console, control: &Control, label: &str, work: impl FnOnce(&Control) -> T) -> T {
    let target = if console.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    let bar = ProgressBar::with_draw_target(Some(STEPS), target);
    let style = ProgressStyle::with_template("{prefix:<24} {wide_bar} {percent:>3} % {eta:>4}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.set_prefix(label.to_owned());
    let handle = bar.clone();
    let result = work(&control.clone().with_progress(move |fraction| {
        handle.set_position((fraction * STEPS as f64) as u64);
    }));
    bar.finish_and_clear();
    result
}
