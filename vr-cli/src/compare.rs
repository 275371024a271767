//! `vr compare`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::Serialize;
use vr_core::resample::{ResampleFilter, Resampling};
use vr_core::{Control, Model, Prepared, RenderError, Rendered, Renderer, View};
use vr_physics::metrics::{Metrics, subgrid};
use vr_study::candidate::Candidate;
use vr_study::figures::ErrorFigures;
use vr_study::origin::setting_flags;
use vr_study::reference::ReferencePixels;

use crate::args::CompareArgs;
use crate::console::Console;
use crate::contact_sheet::{self, Entry};
use crate::failure::Failure;
use crate::progress::under_bar;
use crate::ranking::{self, Rank, candidates, is_default};
use crate::renderers::StatedRenderer;
use crate::scene_setup::Setup;
use crate::sheet_record::{self, SinglePicture};
use crate::table::Table;
use crate::{number, output_file, renderers, resampled};

/// Size of the pictures where none is given: the reference of every pixel takes seconds.
const DEFAULT_SIZE: [u32; 2] = [192, 192];
/// Number of frames per setting; the median of their times counts.
const FRAMES: usize = 3;
/// Time after which no further frame is drawn.
const PATIENCE: Duration = Duration::from_secs(2);
/// Number of pictures and rows without `--all`: two rows of pictures and a table that fit a screen.
const MAX_SHOWN: usize = 12;
/// Renderer that draws the grid that a volume is resampled to.
const GRID_RENDERER: &str = "raycast";
/// Largest number of voxels of that grid.
const MAX_RESAMPLED: usize = 1 << 21;
/// Rows and columns of the subgrid of pixels on which a renderer is judged against its own model.
const SUBGRID: u32 = 16;

/// Renders with every renderer and setting, judges each, draws the sheet, and prints the table.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the sheet.
pub fn run(args: &CompareArgs, console: Console, control: &Control) -> Result<(), Failure> {
    output_file::check(&args.output, &["png"])?;
    args.scene.image.check_opaque()?;
    let candidates = candidates(&renderers::chosen(&args.renderers)?).map_err(Failure::failed)?;
    let mut setup = Setup::new(&args.scene, console)?;
    setup.protect([("--output", &*args.output)], args.replace)?;
    if let Some(folder) = &args.pictures {
        let places: Vec<PathBuf> = candidates.iter().map(|c| sheet_record::place_of(folder, &c.name())).collect();
        setup.protect(places.iter().map(|place| ("--pictures", place.as_path())), args.replace)?;
    }
    setup.note_unused_renderer("renderers are compared under settings of their own", console);
    setup.note_unused_annotations(console);
    if args.scene.scene.is_none() && args.scene.image.size.is_none() {
        setup.view.size = DEFAULT_SIZE;
    }
    let (scene, view) = (&setup.scene, &setup.view);
    // Solve every pixel exactly.
    let every_pixel = subgrid(u32::MAX, view.size);
    let exact = under_bar(console, control, "reference", |control| {
        ReferencePixels::solve((scene, view), &Model::Canonical, every_pixel, control)
    })
    .map_err(|e| setup.render_failure(e))?;

    // Draw with every renderer and setting that can draw the scene.
    let mut results = Vec::new();
    let mut refused: BTreeMap<&str, usize> = BTreeMap::new();
    for candidate in &candidates {
        let name = candidate.name();
        let measure = |control: &Control| measure(&*candidate.configured, &setup, &exact, control);
        match under_bar(console, control, &name, measure) {
            Ok(measured) => {
                let (rmse, seconds) = (measured.metrics.rmse, measured.render.as_secs_f64());
                results.push(Compared {
                    name,
                    candidate,
                    grid: None,
                    rank: Rank { is_default: is_default(candidate), rmse, seconds },
                    measured,
                });
            }
            Err(e @ RenderError::Unsupported { .. }) => {
                *refused.entry(&candidate.renderer).or_default() += 1;
                if args.all {
                    console.note(&format!("{name} is left out: {e}"));
                }
            }
            Err(e) => return Err(setup.render_failure(e)),
        }
    }
    if !refused.is_empty() && !args.all {
        let refused: Vec<String> = refused.iter().map(|(name, count)| format!("{name} ({count})")).collect();
        console.note(&format!(
            "settings that do not draw this scene are left out: {}; --all tells why",
            refused.join(", ")
        ));
    }
    if results.is_empty() {
        return Err(Failure::failed("no renderer can draw this scene"));
    }
    results.sort_by(|a, b| a.rank.order(&b.rank));
    // Beside the volume itself, the grid that it can be resampled to.
    let grid = resampled_setup(&setup, &candidates, console, control)?;
    if let Some((title, grid, candidate)) = &grid {
        let measured =
            under_bar(console, control, title, |control| measure(&*candidate.configured, grid, &exact, control))
                .map_err(|e| setup.render_failure(e))?;
        let (rmse, seconds) = (measured.metrics.rmse, measured.render.as_secs_f64());
        let rank = Rank { is_default: true, rmse, seconds };
        // Among those that are shown, and not the first, whose scene the sheet's record has.
        let place = results.len().min(MAX_SHOWN - 1);
        results.insert(place, Compared { name: title.clone(), candidate, grid: Some(grid), rank, measured });
    }
    // Draw the sheet, and print the table.
    let shown = &results[..if args.all { results.len() } else { results.len().min(MAX_SHOWN) }];
    let mut entries = Vec::new();
    for result in shown {
        let (name, caption, measured) = (result.title(), caption(&result.measured), &result.measured);
        entries.push(Entry { name, caption, frame: &measured.rendered.frame, errors: &measured.errors });
    }
    let heading = format!("{}: pictures above maps of their error", setup.title);
    let sheet = contact_sheet::draw(&heading, &entries, scene.background);
    let stated: Vec<StatedRenderer> =
        shown.iter().map(|result| StatedRenderer::of(&*result.candidate.configured, None)).collect();
    let singles: Vec<SinglePicture<'_>> =
        shown.iter().zip(&stated).map(|(result, stated)| result.single(&setup, stated)).collect();
    let files = sheet_record::write((&args.output, &sheet), ("compare", true), &singles, args.pictures.as_deref())?;
    // Renderers are asked for their features only where the answers are read.
    let silent = console.json || console.quiet;
    let text = if silent { String::new() } else { text(&setup, &exact, shown, results.len(), args) };
    console.result(&text, &json(&setup, &exact, &results, &files, args))
}

/// Returns the scene of the grid that a volume is resampled to, with a title and the setting that draws it: where the volume is no grid, its values can be
/// interpolated, and the renderer of grids is among those that are compared.
fn resampled_setup<'a>(
    setup: &Setup,
    candidates: &'a [Candidate],
    console: Console,
    control: &Control,
) -> Result<Option<(String, Setup, &'a Candidate)>, Failure> {
    let interpolates = setup.scene.volume.field().is_some_and(|field| !field.values_are_codes());
    let candidate = candidates.iter().find(|c| c.renderer == GRID_RENDERER && is_default(c));
    let Some(candidate) = candidate.filter(|_| interpolates) else { return Ok(None) };
    let choices = Resampling { filter: ResampleFilter::Box, max_finest: MAX_RESAMPLED, ..Resampling::default() };
    let made = resampled::run(&setup.scene.volume, &choices, console, control)?;
    made.notes().iter().for_each(|note| console.note(note));
    let title = format!("resampled {}, {GRID_RENDERER}", number::triple(made.grid.dims(), "×"));
    Ok(Some((title, setup.around_grid(&made), candidate)))
}

/// Renderer with one setting, and its place among the others.
struct Compared<'a> {
    name: String,
    candidate: &'a Candidate,
    /// Scene of the grid that the volume was resampled to, if that is drawn.
    grid: Option<&'a Setup>,
    rank: Rank,
    measured: Measured,
}

impl Compared<'_> {
    /// Returns the picture as it is recorded.
    fn single<'s>(&'s self, setup: &'s Setup, stated: &'s StatedRenderer) -> SinglePicture<'s> {
        let mut flags = setting_flags(self.candidate);
        if let Some(resample) = self.grid.and_then(|grid| grid.file.volume.resample) {
            flags.extend(resampled::flags(&resample));
        }
        let setup = self.grid.unwrap_or(setup);
        SinglePicture { name: self.name.clone(), flags, setup, stated, frame: &self.measured.rendered.frame }
    }

    /// Returns the name for people.
    fn title(&self) -> String {
        let says_so = self.name.ends_with("default");
        if self.rank.is_default && !says_so { format!("{} (default)", self.name) } else { self.name.clone() }
    }
}

/// Measurements of one renderer with one setting.
struct Measured {
    prepare: Duration,
    /// Median time of a frame.
    render: Duration,
    rendered: Rendered,
    /// Error against the correct pixels.
    metrics: Metrics,
    errors: Vec<f64>,
    /// Error against the reference of the renderer's own model, where that is another.
    own: Option<Metrics>,
}

fn measure(
    renderer: &dyn Renderer,
    setup: &Setup,
    exact: &ReferencePixels,
    control: &Control,
) -> Result<Measured, RenderError> {
    let (scene, view) = (&setup.scene, &setup.view);
    let start = Instant::now();
    let mut prepared = renderer.prepare(scene, control)?;
    let prepare = start.elapsed();
    let started = Instant::now();
    let (time, mut rendered) = timed(&mut *prepared, view, control)?;
    let mut times = vec![time];
    while times.len() < FRAMES && started.elapsed() < PATIENCE {
        let (time, again) = timed(&mut *prepared, view, control)?;
        times.push(time);
        rendered = again;
    }
    times.sort_unstable();
    let own = match prepared.own_model(view)? {
        None => None,
        Some(model) => {
            let pixels = subgrid(SUBGRID, view.size);
            Some(ReferencePixels::solve((scene, view), &model, pixels, control)?.judge(&rendered.frame))
        }
    };
    Ok(Measured {
        prepare,
        render: times[times.len() / 2],
        metrics: exact.judge(&rendered.frame),
        errors: exact.significant_errors(&rendered.frame),
        own,
        rendered,
    })
}

/// Draws a frame; returns it and its time.
fn timed(prepared: &mut dyn Prepared, view: &View, control: &Control) -> Result<(Duration, Rendered), RenderError> {
    let start = Instant::now();
    let rendered = prepared.render(view, control)?;
    Ok((start.elapsed(), rendered))
}

/// Returns time and error of a picture in a few words.
fn caption(measured: &Measured) -> String {
    format!("{}, RMSE {}", number::time(measured.render), number::small(measured.metrics.rmse))
}

/// Returns the table: a summary that fits a terminal, or all figures of all settings and the features of the renderers.
fn text(setup: &Setup, exact: &ReferencePixels, shown: &[Compared<'_>], count: usize, args: &CompareArgs) -> String {
    let all = args.all;
    let header = ["renderer and setting", "prepare", "render", "RMSE", "max error"];
    let more = ["samples", "bias", "p99", "PSNR/dB", "own model: max"];
    let mut table = Table::new(&header.into_iter().chain(more.into_iter().filter(|_| all)).collect::<Vec<_>>());
    for result in shown {
        let m = &result.measured;
        let Metrics { max, rmse, bias, p99, psnr, .. } = m.metrics;
        let row =
            [result.title(), number::time(m.prepare), number::time(m.render), number::small(rmse), number::small(max)];
        let more = || {
            [
                number::count(m.rendered.stats.counts.samples),
                number::small(bias),
                number::small(p99),
                format!("{psnr:.1}"),
                m.own.map_or_else(|| "-".to_owned(), |own| number::small(own.max)),
            ]
        };
        table.row(row.into_iter().chain(if all { more().to_vec() } else { Vec::new() }));
    }
    let [w, h] = setup.view.size;
    let mut text = format!(
        "{}, {w}x{h} pixels\nreference: {}, {}\n\n{table}\n\
         Order: defaults first; then the fastest within RMSE {}; then the least wrong.\n",
        setup.title,
        exact.certainty_text(),
        number::time(exact.time),
        number::small(ranking::RMSE),
    );
    for result in shown {
        if let Some(account) = exact.noise_account(&result.measured.rendered.frame) {
            text += &format!("{}: {account}\n", result.title());
        }
    }
    if all {
        text += &format!(
            "Own model: against what the renderer itself integrates, done exactly, on {SUBGRID}x{SUBGRID} pixels.\n"
        );
    } else if count > shown.len() {
        text += &format!("{} of {count} settings; --all shows the others and all figures.\n", shown.len());
    } else {
        text += "--all shows all figures.\n";
    }
    text += &format!("Wrote {}: pictures above maps of their error.\n", args.output.display());
    if let Some(folder) = &args.pictures {
        text += &format!("Wrote each picture into {}: vr rerun draws it again.\n", folder.display());
    }
    if all { text + "\n" + &renderers::feature_table() } else { text }
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    size: [u32; 2],
    renderers: Vec<RendererJson<'a>>,
    output: String,
    /// The sheet, and the single pictures if they were asked for.
    #[serde(serialize_with = "output_file::as_texts")]
    files: &'a [PathBuf],
    notes: &'a [String],
}

#[derive(Serialize)]
struct RendererJson<'a> {
    name: &'a str,
    #[serde(rename = "default")]
    is_default: bool,
    prepare_seconds: f64,
    render_seconds: f64,
    samples: u64,
    error: ErrorFigures,
    own_model_max_error: Option<f64>,
}

fn json<'a>(
    setup: &'a Setup,
    exact: &ReferencePixels,
    results: &'a [Compared<'_>],
    files: &'a [PathBuf],
    args: &CompareArgs,
) -> Json<'a> {
    let renderer = |Compared { name, rank, measured: m, .. }: &'a Compared<'_>| RendererJson {
        name,
        is_default: rank.is_default,
        prepare_seconds: m.prepare.as_secs_f64(),
        render_seconds: m.render.as_secs_f64(),
        samples: m.rendered.stats.counts.samples,
        error: ErrorFigures::new(exact, &m.rendered.frame),
        own_model_max_error: m.own.map(|own| own.max),
    };
    Json {
        volume: &setup.title,
        size: setup.view.size,
        renderers: results.iter().map(renderer).collect(),
        output: args.output.display().to_string(),
        files,
        notes: &setup.notes,
    }
}
