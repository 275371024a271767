//! `vr render`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use vr_core::{Control, Counts, Model, Rendered};
use vr_io::PngOptions;
use vr_physics::metrics::{Metrics, subgrid};

use crate::args::{ErrorMeasure, RenderArgs};
use crate::console::Console;
use crate::error_map::ErrorMap;
use crate::failure::Failure;
use crate::judge::{ErrorJson, Exact, SUBGRID};
use crate::progress::under_bar;
use crate::scene_setup::Setup;
use crate::{error_map, number, output_file};

/// Renders, writes, measures, tells.
///
/// # Errors
/// Whatever goes wrong with the command line, the volume, the scene, or the files to be written.
pub fn run(args: &RenderArgs, console: Console, control: &Control) -> Result<(), Failure> {
    for path in &args.output.outputs {
        output_file::check(path, &["png", "exr"])?;
    }
    error_map::check(&args.output)?;
    let setup = Setup::new(&args.scene, console)?;
    let renderer = setup.renderer(&args.renderer)?;
    let (scene, view) = (&setup.scene, &setup.view);

    let start = Instant::now();
    let mut prepared = under_bar(console, control, "preparing", |control| renderer.prepare(scene, control))
        .map_err(|e| setup.render_failure(e))?;
    let prepare = start.elapsed();
    let start = Instant::now();
    let Rendered { frame, stats } = under_bar(console, control, "rendering", |control| prepared.render(view, control))
        .map_err(|e| setup.render_failure(e))?;
    let render = start.elapsed();
    let png = PngOptions { background: scene.background, ..args.output.png() };
    for path in &args.output.outputs {
        vr_io::write(path, &frame, &png).map_err(Failure::failed)?;
    }

    // Nobody would see it.
    let unseen = console.quiet && !console.json && args.output.error_map.is_none();
    let wanted = if unseen { ErrorMeasure::None } else { args.output.error };
    let pixels = match wanted {
        ErrorMeasure::None => None,
        ErrorMeasure::Subgrid => Some(subgrid(SUBGRID, view.size)),
        ErrorMeasure::Full => Some(subgrid(u32::MAX, view.size)),
    };
    let exact = pixels
        .map(|pixels| {
            under_bar(console, control, "measuring the error", |control| {
                Exact::solve((scene, view), &Model::Canonical, pixels, control)
            })
        })
        .transpose()
        .map_err(|e| setup.render_failure(e))?;
    let map = match (&args.output.error_map, &exact) {
        (Some(path), Some(exact)) => Some(under_bar(console, control, "error map", |control| {
            error_map::write(path, &setup, exact, &frame, control)
        })?),
        _ => None,
    };

    let done = Done {
        setup: &setup,
        renderer: renderer.name(),
        prepare,
        render,
        counts: stats.counts,
        error: exact.map(|exact| (exact.judge(&frame), exact)),
        map,
        outputs: &args.output.outputs,
    };
    console.result(&done.text(), &done.json())
}

/// What there is to tell.
struct Done<'a> {
    setup: &'a Setup,
    renderer: &'static str,
    prepare: Duration,
    render: Duration,
    counts: Counts,
    error: Option<(Metrics, Exact)>,
    map: Option<ErrorMap>,
    outputs: &'a [PathBuf],
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    renderer: &'static str,
    size: [u32; 2],
    prepare_seconds: f64,
    render_seconds: f64,
    rays: u64,
    samples: u64,
    skipped: u64,
    terminated: u64,
    unbounded: u64,
    repeated: u64,
    error: Option<ErrorJson>,
    error_map: Option<&'a ErrorMap>,
    outputs: &'a [PathBuf],
    notes: &'a [String],
}

impl Done<'_> {
    fn text(&self) -> String {
        let Counts { rays, samples, skipped, terminated, unbounded, repeated } = self.counts;
        let [w, h] = self.setup.view.size;
        let mut text = format!("scene    {}, {w}x{h} pixels, {}\n", self.setup.title, self.renderer);
        text += &format!("time     prepare {}, render {}\n", number::time(self.prepare), number::time(self.render));
        text += &format!(
            "work     {} rays, {} samples, {} skipped, {} rays ended early\n",
            number::count(rays),
            number::count(samples),
            number::count(skipped),
            number::count(terminated)
        );
        if repeated > 0 {
            text += &format!("         {} rays done again in higher precision\n", number::count(repeated));
        }
        if unbounded > 0 {
            text += &format!(
                "promise  not kept for {} of {} rays: no bound within it was found there (the truth jumps, or nearly)\n",
                number::count(unbounded),
                number::count(rays)
            );
        }
        if let Some((metrics, exact)) = &self.error {
            let all = u64::from(w) * u64::from(h);
            text += &format!("error    {metrics}\n");
            text += &format!(
                "         on {} of {all} pixels, against the exact solution ({}; {})\n",
                exact.count(),
                exact.certainty_text(),
                number::time(exact.time)
            );
        }
        if let Some(map) = &self.map {
            text += &map.text(u64::from(w) * u64::from(h));
        }
        let outputs: Vec<String> = self.outputs.iter().map(|p| p.display().to_string()).collect();
        text + &format!("wrote    {}\n", outputs.join(", "))
    }

    fn json(&self) -> Json<'_> {
        let Counts { rays, samples, skipped, terminated, unbounded, repeated } = self.counts;
        Json {
            volume: &self.setup.title,
            renderer: self.renderer,
            size: self.setup.view.size,
            prepare_seconds: self.prepare.as_secs_f64(),
            render_seconds: self.render.as_secs_f64(),
            rays,
            samples,
            skipped,
            terminated,
            unbounded,
            repeated,
            error: self.error.as_ref().map(|(metrics, exact)| ErrorJson::new(metrics, exact)),
            error_map: self.map.as_ref(),
            outputs: self.outputs,
            notes: &self.setup.notes,
        }
    }
}
