//! `vr bench`.

use std::time::{Duration, Instant};

use vr_core::{Control, Counts, Frame, Model, Prepared, RenderError, Renderer, View};
use vr_physics::metrics::subgrid;
use vr_study::reference::{ReferencePixels, SUBGRID};

use crate::args::{BenchArgs, TimingArgs};
use crate::bench_report::Report;
use crate::console::Console;
use crate::error_bound::ErrorBound;
use crate::failure::Failure;
use crate::process;
use crate::progress::under_bar;
use crate::scene_setup::{Configured, Setup};

/// Prepares once, draws frame after frame, and prints their times and work.
///
/// # Errors
/// Any fault of the command line, the volume, or the scene.
pub fn run(args: &BenchArgs, console: Console, control: &Control) -> Result<(), Failure> {
    args.scene.image.check_opaque()?;
    let setup = Setup::for_renderer(&args.scene, &args.renderer, console)?;
    let Configured { renderer, options, max_error, .. } = setup.renderer(&args.renderer, console)?;
    let measured =
        under_bar(console, control, "timing", |progress| measure(&*renderer, &setup, args.timing, control, progress))
            .map_err(|e| setup.render_failure(e))?;
    // Before the reference, which uses memory of its own.
    let peak_bytes = process::peak_bytes();
    let error = args.timing.error.then(|| judge(&setup, &measured.first, console, control)).transpose()?;
    let error_bound = max_error.map(|bound| ErrorBound::new(bound, &measured.counts(), setup.view.supersampling));
    let report = Report {
        setup: &setup,
        renderer: &*renderer,
        options: &options,
        timing: args.timing,
        threads: control.threads(),
        measured: &measured,
        peak_bytes,
        error_bound,
        error: error.as_ref().map(|exact| (exact.judge(&measured.first), exact)),
    };
    console.result(&report.text(), &report.json())?;
    error_bound.map_or(Ok(()), |bound| bound.outcome())
}

/// Measurements of a renderer.
pub struct Measured {
    /// Time of the preparation.
    pub prepare: Duration,
    /// Every timed frame, in order.
    pub frames: Vec<Timed>,
    /// The picture of frame 0: the scene's own view.
    pub first: Frame,
}

impl Measured {
    /// Returns the work of all timed frames.
    fn counts(&self) -> Counts {
        let mut all = Counts::default();
        self.frames.iter().for_each(|frame| all += frame.counts);
        all
    }
}

/// Time and work of one frame.
pub struct Timed {
    /// Wall-clock time.
    pub wall: Duration,
    /// CPU time of all threads, where the system counts it.
    pub cpu: Option<Duration>,
    /// Work.
    pub counts: Counts,
}

/// Times preparation and frames under `control`, which reports no progress: drawing the bar would be timed, too. `progress` reports it
/// between frames.
fn measure(
    renderer: &dyn Renderer,
    setup: &Setup,
    timing: TimingArgs,
    control: &Control,
    progress: &Control,
) -> Result<Measured, RenderError> {
    let start = Instant::now();
    let mut prepared = renderer.prepare(&setup.scene, control)?;
    let prepare = start.elapsed();
    let of_turn = |frame: i64| turned(&setup.view, frame, timing.azimuth_step);
    // Views that no timed frame repeats, and from which the first of those follows as each follows from the one before.
    for frame in -i64::from(timing.warm_up)..0 {
        prepared.render(&of_turn(frame), control)?;
    }
    let (frame_0, first) = timed(&mut *prepared, &setup.view, control)?;
    let mut frames = vec![frame_0];
    for frame in 1..timing.frames {
        progress.report(f64::from(frame) / f64::from(timing.frames));
        frames.push(timed(&mut *prepared, &of_turn(frame.into()), control)?.0);
    }
    Ok(Measured { prepare, frames, first })
}

/// Returns the view of a frame: the scene's own, turned about the camera's target.
fn turned(view: &View, frame: i64, step: f64) -> View {
    View { camera: view.camera.orbit(frame as f64 * step, 0.0), ..view.clone() }
}

fn timed(prepared: &mut dyn Prepared, view: &View, control: &Control) -> Result<(Timed, Frame), RenderError> {
    let (start, cpu) = (Instant::now(), process::cpu_time());
    let rendered = prepared.render(view, control)?;
    let (wall, cpu) =
        (start.elapsed(), process::cpu_time().zip(cpu).map(|(after, before)| after.saturating_sub(before)));
    Ok((Timed { wall, cpu, counts: rendered.stats.counts }, rendered.frame))
}

/// Compares the first frame with the reference.
fn judge(setup: &Setup, frame: &Frame, console: Console, control: &Control) -> Result<ReferencePixels, Failure> {
    let pixels = subgrid(SUBGRID, frame.size());
    under_bar(console, control, "measuring the error", |control| {
        ReferencePixels::solve((&setup.scene, &setup.view), &Model::Canonical, pixels, control)
    })
    .map_err(|e| setup.render_failure(e))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::Camera;

    use super::*;

    #[test]
    fn frames_turn_about_the_target_and_frame_0_is_the_own_view() {
        let bounds = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(5.0, 4.0, 6.0));
        let view = View::new(Camera::framing(bounds, 30.0, 20.0, Some(30.0)), [4, 4]);
        let arm = |v: &View| v.camera.eye - v.camera.target;
        assert!((arm(&turned(&view, 0, 10.0)) - arm(&view)).length() < 1e-12 * arm(&view).length());
        let quarter = turned(&view, 9, 10.0);
        assert_eq!(quarter.camera.target, view.camera.target);
        assert!((arm(&quarter).length() / arm(&view).length() - 1.0).abs() < 1e-12);
        // About the up vector: what lies along it stays.
        let up = view.camera.up.normalize();
        let across = |v: &View| arm(v) - up * arm(v).dot(up);
        assert!((arm(&quarter) - arm(&view)).dot(up).abs() < 1e-12 * arm(&view).length());
        assert!(across(&quarter).dot(across(&view)).abs() < 1e-12 * arm(&view).length_squared());
        // Backwards and forwards.
        assert!((arm(&turned(&quarter, -9, 10.0)) - arm(&view)).length() < 1e-12 * arm(&view).length());
    }
}
