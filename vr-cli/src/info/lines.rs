//! Lines of `vr info` for people: a name, and what it is.

use std::fmt::Display;

use vr_look::Histogram;

use crate::histogram_drawing;

/// Number of columns of a drawn histogram.
pub const COLUMNS: usize = 72;
/// Number of rows of a drawn histogram.
const ROWS: usize = 8;

/// Text of lines, each of which begins with a name in a column of its own.
#[derive(Debug, Default)]
pub struct Lines(String);

impl Lines {
    /// Adds a line.
    pub fn add(&mut self, name: &str, text: impl Display) {
        self.0 += &format!("{name:<12} {text}\n");
    }

    /// Adds text that has lines of its own.
    pub fn add_text(&mut self, text: &str) {
        self.0 += text;
    }

    /// Adds the reason of the automatic look, and presets that suit the values.
    pub fn look(&mut self, reason: &str, presets: &[&str]) {
        self.add("look", reason.trim_start_matches("look: "));
        if !presets.is_empty() {
            self.add("try", format!("--transfer {}", presets.join(" | ")));
        }
    }

    /// Draws a histogram whose columns are as high as the logarithm of `height`.
    pub fn histogram(&mut self, histogram: &Histogram, height: &str) {
        self.0 += &format!(
            "\nhistogram (height: logarithm of the {height})\n{}",
            histogram_drawing::drawing(histogram, ROWS)
        );
    }

    /// Returns all lines.
    pub fn into_text(self) -> String {
        self.0
    }
}
