//! Progress bars on a terminal.

use std::cell::Cell;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressFinish, ProgressStyle};
use vr_core::Control;

use crate::console::Console;

/// Number of steps of a bar; renderers report fractions.
const STEPS: u64 = 1000;

/// Runs work under a bar with a label. The bar is drawn on stderr where that is a terminal, and gone when the work is done.
pub fn under_bar<T>(console: Console, control: &Control, label: &str, work: impl FnOnce(&Control) -> T) -> T {
    let target = if console.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
    // Gone, too, where the work unwinds.
    let bar = ProgressBar::with_draw_target(Some(STEPS), target).with_finish(ProgressFinish::AndClear);
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

/// Bar of frames, with their number and the time that remains. Drawn on stderr where that is a terminal, and gone when it is dropped.
pub struct FrameBar {
    bar: ProgressBar,
    /// True once a frame was drawn: frames that are there already say nothing about the time of others.
    has_drawn: Cell<bool>,
}

impl FrameBar {
    /// A bar of a number of frames.
    pub fn new(console: Console, count: u64) -> Self {
        let target = if console.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(count), target);
        let style = ProgressStyle::with_template("frame {pos} of {len} {wide_bar} {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        bar.tick();
        Self { bar, has_drawn: Cell::new(false) }
    }

    /// Counts a frame that was there.
    pub fn kept(&self) {
        self.bar.inc(1);
        if !self.has_drawn.get() {
            self.bar.reset_eta();
        }
    }

    /// Counts a frame that was drawn.
    pub fn drawn(&self) {
        self.has_drawn.set(true);
        self.bar.inc(1);
    }
}

impl Drop for FrameBar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
