//! `vr render`.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use vr_core::{Control, Counts, Frame, Model, Rendered, Uncertainty};
use vr_io::PngOptions;
use vr_physics::metrics::{Metrics, subgrid};
use vr_study::figures::ErrorFigures;
use vr_study::reference::{ReferencePixels, SUBGRID};

use crate::annotate::{self, Annotations};
use crate::args::{Background, ErrorMeasure, RenderArgs, RendererArgs};
use crate::console::Console;
use crate::error_bound::ErrorBound;
use crate::error_map::ErrorMap;
use crate::failure::Failure;
use crate::picture_record::record_of;
use crate::progress::under_bar;
use crate::renderers::StatedRenderer;
use crate::scene_setup::{Configured, Setup};
use crate::target::Chosen;
use crate::{blank, error_map, exact_cache, number, output_file, show, target};

/// Renders, writes, measures the error, and prints all figures.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the files to be written.
pub fn run(args: &RenderArgs, console: Console, control: &Control) -> Result<(), Failure> {
    // Check the command line and the files before anything is computed.
    for path in &args.output.outputs {
        output_file::check(path, &["png", "exr"])?;
    }
    args.output.check_png_options()?;
    error_map::check(&args.output)?;
    annotate::check(&args.annotations)?;
    show::check(args.show, console)?;
    if let (Some(flag), false, None) = (args.annotations.flag(), args.output.has_png(), args.show.show) {
        let message =
            "no picture is a PNG: OpenEXR holds data, which nothing is drawn over; must go with -o FILE.png or --show";
        return Err(Failure::usage(format!("{flag}: {message}")));
    }
    // A target of RMSE chooses settings of its own.
    let mut setup = match args.target.target_rmse {
        Some(_) => Setup::new(&args.scene, console)?,
        None => Setup::for_renderer(&args.scene, &args.renderer, console)?,
    };
    setup.protect(args.output.places(), args.output.replace)?;
    annotate::apply(&args.annotations, &mut setup)?;
    let setup = setup;
    let (scene, view) = (&setup.scene, &setup.view);
    let annotations = Annotations::new(&setup, console)?;
    // Draw the picture.
    let cache = exact_cache::open(&args.cache, console);
    let drawn = match args.target.target_rmse {
        Some(target) => target::draw((target, args.target.search), &args.renderer, &setup, &cache, console, control)?,
        None => draw(&args.renderer, &setup, console, control)?,
    };
    let frame = &drawn.frame;
    if let Some(note) = blank::note(frame, scene, view) {
        console.note(&note);
    }
    let transparent = args.scene.image.background == Some(Background::Transparent);
    let png = args.output.png();
    let png = PngOptions { background: scene.background, alpha: png.alpha || transparent, ..png };
    let annotated = annotations.map(|annotations| annotations.over(frame, &png, console));
    if let Some(protocol) = args.show.show {
        show::print(protocol, annotated.as_ref().unwrap_or(frame), &png)?;
    }

    // Measure the error, unless neither output nor a map shows it.
    let unseen = console.quiet && !console.json && args.output.error_map.is_none();
    let wanted = if unseen { ErrorMeasure::None } else { args.output.error };
    let pixels = match wanted {
        ErrorMeasure::None => None,
        ErrorMeasure::Subgrid => Some(subgrid(SUBGRID, view.size)),
        ErrorMeasure::Full => Some(subgrid(u32::MAX, view.size)),
    };
    let solve = |pixels| {
        let solve = |control: &Control| cache.solve((scene, view), &Model::Canonical, pixels, control);
        under_bar(console, control, "measuring the error", solve)
    };
    let (exact, unsolved) = match pixels.map(solve).transpose() {
        Ok(exact) => (exact, Ok(())),
        Err(e) => (None, Err(setup.render_failure(e))),
    };

    // Write the pictures, even where their error could not be measured.
    let error = exact.map(|exact| (exact.judge(frame), exact));
    let record = (!args.output.no_record).then(|| record_of(&setup, &drawn.stated, error.as_ref())).transpose()?;
    for path in &args.output.outputs {
        // An EXR is data, which nothing is drawn over.
        let over = annotated.as_ref().filter(|_| output_file::is_png(path));
        let picture = over.unwrap_or(frame);
        match record.clone() {
            Some(mut record) => {
                if over.is_some() {
                    record.scene.annotations = setup.file.annotations.clone();
                }
                vr_io::write_with_record(path, picture, &png, record)
            }
            None => vr_io::write(path, picture, &png),
        }
        .map_err(Failure::failed)?;
    }
    unsolved?;
    let map = match (&args.output.error_map, &error) {
        (Some(path), Some((_, exact))) => Some(error_map::write(path, exact, frame)?),
        _ => None,
    };

    let summary = Summary { setup: &setup, drawn: &drawn, error, map, outputs: &args.output.outputs };
    console.result(&summary.text(), &summary.json())?;
    drawn.error_bound.map_or(Ok(()), |bound| bound.outcome())
}

/// Picture, its time and its work.
pub struct Drawn {
    /// Name of the renderer.
    pub renderer: String,
    /// The picture.
    pub frame: Frame,
    /// The work.
    pub counts: Counts,
    /// Time of the preparation.
    pub prepare: Duration,
    /// Time of the picture.
    pub render: Duration,
    /// Outcome of the error bound, where one was asked for.
    pub error_bound: Option<ErrorBound>,
    /// The renderer as the record states it.
    pub stated: StatedRenderer,
    /// Choice of the renderer and its setting, where `--target-rmse` made it.
    pub chosen: Option<Chosen>,
}

/// Draws with the renderer that flags or the scene file ask for.
///
/// # Errors
/// Errors of [`Setup::renderer`]; a scene that the renderer does not draw.
pub fn draw(args: &RendererArgs, setup: &Setup, console: Console, control: &Control) -> Result<Drawn, Failure> {
    let Configured { renderer, max_error, stated, .. } = setup.renderer(args, console)?;
    let start = Instant::now();
    let mut prepared = under_bar(console, control, "preparing", |control| renderer.prepare(&setup.scene, control))
        .map_err(|e| setup.render_failure(e))?;
    let prepare = start.elapsed();
    let start = Instant::now();
    let Rendered { frame, stats } = under_bar(console, control, "rendering", |c| prepared.render(&setup.view, c))
        .map_err(|e| setup.render_failure(e))?;
    let (renderer, render, counts) = (renderer.name().to_owned(), start.elapsed(), stats.counts);
    let error_bound = max_error.map(|bound| ErrorBound::new(bound, &counts, setup.view.supersampling));
    Ok(Drawn { renderer, frame, counts, prepare, render, error_bound, chosen: None, stated })
}

/// A line on the errors that a picture itself knows.
fn own_errors(uncertainty: &Uncertainty) -> String {
    let (rms, largest) = (number::small(uncertainty.rms()), number::small(uncertainty.largest()));
    match uncertainty {
        Uncertainty::StandardError(_) => {
            format!("noise    standard error of a component {rms} (RMS), largest {largest}\n")
        }
        Uncertainty::Bound(_) => {
            format!("error    of a component at most {largest}, by the renderer's own account ({rms} RMS)\n")
        }
    }
}

/// Summary of a rendering, to be printed.
struct Summary<'a> {
    setup: &'a Setup,
    drawn: &'a Drawn,
    error: Option<(Metrics, ReferencePixels)>,
    map: Option<ErrorMap>,
    outputs: &'a [PathBuf],
}

/// Errors that a picture itself knows, for JSON.
#[derive(Serialize)]
struct OwnErrors {
    kind: &'static str,
    rms: f64,
    largest: f64,
}

impl OwnErrors {
    fn of(uncertainty: &Uncertainty) -> Self {
        let kind = match uncertainty {
            Uncertainty::StandardError(_) => "standard error",
            Uncertainty::Bound(_) => "bound",
        };
        Self { kind, rms: uncertainty.rms(), largest: uncertainty.largest() }
    }
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    renderer: &'a str,
    size: [u32; 2],
    prepare_seconds: f64,
    render_seconds: f64,
    rays: u64,
    samples: u64,
    skipped: u64,
    terminated: u64,
    unbounded: u64,
    repeated: u64,
    #[serde(rename = "promise")]
    error_bound: Option<&'a ErrorBound>,
    chosen: Option<&'a Chosen>,
    error: Option<ErrorFigures>,
    own_errors: Option<OwnErrors>,
    error_map: Option<&'a ErrorMap>,
    #[serde(serialize_with = "output_file::as_texts")]
    outputs: &'a [PathBuf],
    notes: &'a [String],
}

impl Summary<'_> {
    fn text(&self) -> String {
        let Counts { rays, samples, skipped, terminated, repeated, .. } = self.drawn.counts;
        let [w, h] = self.setup.view.size;
        let mut text = format!("scene    {}, {w}x{h} pixels, {}\n", self.setup.title, self.drawn.renderer);
        if let Some(chosen) = &self.drawn.chosen {
            text += &chosen.text();
        }
        let Drawn { prepare, render, .. } = *self.drawn;
        text += &format!("time     prepare {}, render {}\n", number::time(prepare), number::time(render));
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
        if let Some(bound) = &self.drawn.error_bound {
            text += &bound.line();
            text.push('\n');
        }
        if let Some((metrics, exact)) = &self.error {
            let all = u64::from(w) * u64::from(h);
            text += &format!("error    {metrics}\n");
            text += &format!(
                "         on {} of {all} pixels, against the reference ({}; {})\n",
                exact.count(),
                exact.certainty_text(),
                number::time(exact.time)
            );
            if let Some(account) = exact.noise_account(&self.drawn.frame) {
                text += &format!("         {account}\n");
            }
        }
        text += &self.drawn.frame.uncertainty().map(own_errors).unwrap_or_default();
        if let Some(map) = &self.map {
            text += &map.text(u64::from(w) * u64::from(h));
        }
        let outputs: Vec<String> = self.outputs.iter().map(|p| p.display().to_string()).collect();
        text + &format!("wrote    {}\n", outputs.join(", "))
    }

    fn json(&self) -> Json<'_> {
        let Counts { rays, samples, skipped, terminated, unbounded, repeated, .. } = self.drawn.counts;
        Json {
            volume: &self.setup.title,
            renderer: &self.drawn.renderer,
            size: self.setup.view.size,
            prepare_seconds: self.drawn.prepare.as_secs_f64(),
            render_seconds: self.drawn.render.as_secs_f64(),
            rays,
            samples,
            skipped,
            terminated,
            unbounded,
            repeated,
            error_bound: self.drawn.error_bound.as_ref(),
            chosen: self.drawn.chosen.as_ref(),
            error: self.error.as_ref().map(|(_, exact)| ErrorFigures::new(exact, &self.drawn.frame)),
            own_errors: self.drawn.frame.uncertainty().map(OwnErrors::of),
            error_map: self.map.as_ref(),
            outputs: self.outputs,
            notes: &self.setup.notes,
        }
    }
}
