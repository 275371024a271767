//! Output of `vr bench`.

use std::time::Duration;

use serde::Serialize;
use vr_core::{Options, Renderer};
use vr_physics::metrics::Metrics;
use vr_study::figures::ErrorFigures;
use vr_study::reference::ReferencePixels;

use crate::args::TimingArgs;
use crate::bench::{Measured, Timed};
use crate::error_bound::ErrorBound;
use crate::number;
use crate::scene_setup::Setup;
use crate::table::Table;

/// Report of a benchmark, to be printed.
pub struct Report<'a> {
    /// The scene.
    pub setup: &'a Setup,
    /// The renderer.
    pub renderer: &'a dyn Renderer,
    /// The options that were set.
    pub options: &'a Options,
    /// Frames and turns that were asked for.
    pub timing: TimingArgs,
    /// Number of threads.
    pub threads: usize,
    /// The measurements.
    pub measured: &'a Measured,
    /// Largest resident set in bytes.
    pub peak_bytes: Option<u64>,
    /// Outcome of the error bound of all frames, where one was asked for.
    pub error_bound: Option<ErrorBound>,
    /// Error of frame 0 against the reference.
    pub error: Option<(Metrics, &'a ReferencePixels)>,
}

/// JSON object for scripts. Figures that the system does not count are `null`.
#[derive(Serialize)]
pub struct Json<'a> {
    renderer: &'static str,
    /// The options that were set; all others are at their defaults.
    settings: &'a Options,
    threads: usize,
    prepare_ms: f64,
    /// Wall-clock time of each frame.
    frames_ms: Vec<f64>,
    median_ms: f64,
    min_ms: f64,
    max_ms: f64,
    /// CPU time of a frame, all threads together: the median.
    cpu_ms: Option<f64>,
    /// Samples of the field in a frame: the mean.
    samples: u64,
    peak_bytes: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "promise")]
    error_bound: Option<ErrorBound>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<ErrorFigures>,
}

impl Report<'_> {
    /// Returns the object for scripts.
    pub fn json(&self) -> Json<'_> {
        let frames = &self.measured.frames;
        let [min, median, max] = self.spread();
        Json {
            renderer: self.renderer.name(),
            settings: self.options,
            threads: self.threads,
            prepare_ms: ms(self.measured.prepare),
            frames_ms: frames.iter().map(|f| ms(f.wall)).collect(),
            median_ms: ms(median),
            min_ms: ms(min),
            max_ms: ms(max),
            cpu_ms: self.cpu().map(ms),
            samples: self.samples(),
            peak_bytes: self.peak_bytes,
            error_bound: self.error_bound,
            error: self.error.as_ref().map(|(_, exact)| ErrorFigures::new(exact, &self.measured.first)),
        }
    }

    /// Returns the text for people.
    pub fn text(&self) -> String {
        let [w, h] = self.setup.view.size;
        let TimingArgs { azimuth_step, warm_up, .. } = self.timing;
        let mut table = Table::new(&["frame", "azimuth", "time", "CPU time", "samples"]);
        for (k, Timed { wall, cpu, counts }) in self.measured.frames.iter().enumerate() {
            table.row([
                k.to_string(),
                number::value(k as f64 * azimuth_step),
                number::time(*wall),
                cpu.map_or_else(|| "-".to_owned(), number::time),
                number::count(counts.samples),
            ]);
        }
        let [min, median, max] = self.spread().map(number::time);
        let settings =
            self.options.0.iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(", ");
        let settings = if settings.is_empty() { "all at their defaults" } else { &settings };
        let mut text = format!("scene    {}, {w}x{h} pixels, {}\n", self.setup.title, self.renderer.name());
        text += &format!("settings {settings}\n\n{table}\n");
        text +=
            &format!("frame    median {median}, min {min}, max {max} on {}", counted(self.threads as u64, "thread"));
        text += &match warm_up {
            0 => " (no warm-up frame was drawn before)\n".to_owned(),
            n => format!(" (after {}, which count nowhere)\n", counted(n.into(), "warm-up frame")),
        };
        text += &format!("prepare  {}\n", number::time(self.measured.prepare));
        let per_second = self.samples() as f64 / self.spread()[1].as_secs_f64().max(f64::MIN_POSITIVE);
        text += &format!(
            "work     {} samples a frame, {} a second",
            number::count(self.samples()),
            number::count(per_second as u64)
        );
        text +=
            &self.cpu().map_or_else(|| "\n".to_owned(), |cpu| format!("; CPU time {} a frame\n", number::time(cpu)));
        if let Some(peak) = self.peak_bytes {
            text += &format!("memory   {} at the peak, the volume included\n", number::bytes(peak));
        }
        if let Some(bound) = &self.error_bound {
            text += &format!("{}, in all frames together\n", bound.line());
        }
        if let Some((metrics, exact)) = &self.error {
            text += &format!("error    {metrics}\n");
            text += &format!(
                "         of frame 0, on {} of its pixels, against the reference ({}; {})\n",
                exact.count(),
                exact.certainty_text(),
                number::time(exact.time)
            );
        }
        text
    }

    /// Returns the minimum, median and maximum time of a frame.
    fn spread(&self) -> [Duration; 3] {
        let mut walls: Vec<Duration> = self.measured.frames.iter().map(|f| f.wall).collect();
        let median = median(&mut walls);
        [walls[0], median, walls[walls.len() - 1]]
    }

    fn cpu(&self) -> Option<Duration> {
        self.measured.frames.iter().map(|f| f.cpu).collect::<Option<Vec<_>>>().map(|mut cpus| median(&mut cpus))
    }

    fn samples(&self) -> u64 {
        let frames = &self.measured.frames;
        let sum: u128 = frames.iter().map(|f| u128::from(f.counts.samples)).sum();
        (sum / frames.len() as u128) as u64
    }
}

/// Returns the median of at least one number: the middle one, or the mean of the two in the middle.
fn median(durations: &mut [Duration]) -> Duration {
    durations.sort_unstable();
    let n = durations.len();
    (durations[(n - 1) / 2] + durations[n / 2]) / 2
}

/// Returns a duration in milliseconds, to the nanosecond.
fn ms(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / 1e6
}

/// Formats a count of things: `1 thread`, `2 threads`.
fn counted(n: u64, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        let of = |times: &[u64]| {
            let mut durations: Vec<Duration> = times.iter().map(|&t| Duration::from_millis(t)).collect();
            ms(median(&mut durations))
        };
        assert_eq!((of(&[7]), of(&[9, 1]), of(&[9, 1, 2]), of(&[4, 9, 1, 2])), (7.0, 5.0, 2.0, 3.0));
    }

    #[test]
    fn numerals_agree() {
        assert_eq!((counted(1, "thread"), counted(2, "thread")), ("1 thread".into(), "2 threads".into()));
    }
}
