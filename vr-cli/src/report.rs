//! `vr report`.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use vr_core::{Control, RenderError};
use vr_study::StudyError;
use vr_study::baseline::Baseline;
use vr_study::report::{csv, headline_plot, headline_table, page};
use vr_study::subject::{Subject, reduced};
use vr_study::suite::{Report, Run, Suite};

use crate::args::{ReportArgs, SuiteName};
use crate::console::Console;
use crate::failure::Failure;
use crate::heap::Heap;
use crate::inputs::Inputs;
use crate::progress::under_bar;
use crate::scene_setup::{Setup, named_scene};
use crate::{exact_cache, renderers};

/// Largest number of pixels of the pictures of a user's own scene, where no size was asked for.
const QUICK_PIXELS: f64 = 128.0 * 128.0;
const FULL_PIXELS: f64 = 320.0 * 320.0;

/// Measures a suite, writes its page and its tables, and prints a summary.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the folder; figures that are worse than a baseline.
pub fn run(args: &ReportArgs, console: Console, control: &Control) -> Result<(), Failure> {
    args.scene.image.check_opaque()?;
    // Read the command line, the baseline and the scene.
    let suite = match args.suite {
        SuiteName::Quick => Suite::Quick,
        SuiteName::Full => Suite::Full,
        SuiteName::Hard => Suite::Hard,
        SuiteName::Scaling => Suite::Scaling,
    };
    let chosen = renderers::chosen(&args.renderers)?;
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?;
    let setup = named_scene(&args.scene, console)?;
    if let Some(setup) = &setup {
        setup.note_unused_renderer("renderers are measured under settings of their own", console);
    }
    if setup.is_some() && matches!(suite, Suite::Hard | Suite::Scaling) {
        console.note(&format!("the suite {} has scenes of its own: the one that was named is not used", suite.name()));
    }
    // Protect every file that is read.
    let journal = args.output.join(format!("journal-{}.jsonl", suite.name()));
    let read = setup.iter().flat_map(|setup| setup.inputs.iter().cloned()).chain(args.baseline.clone());
    let inputs = Inputs::new("a file that is read", read);
    let written = FILES.iter().map(|name| args.output.join(name));
    written.chain([journal.clone()]).try_for_each(|place| inputs.protect("--output", &place))?;
    fs::create_dir_all(&args.output).map_err(|e| cannot_write(&args.output, &e))?;
    // Measure; a journal keeps what is done.
    let cache = exact_cache::open(&args.cache);
    let run = Run {
        renderers: &chosen,
        own: setup.as_ref().map(|setup| subject(setup, args, suite)),
        untimed: args.untimed,
        cache: &cache,
        meter: Some(&Heap),
        journal: Some(&journal),
    };
    let measured =
        under_bar(console, control, "measuring", |progress| run.run(suite, (control, &|share| progress.report(share))));
    let report = measured.map_err(|e| match (e, &setup) {
        (StudyError::Render(RenderError::Cancelled), _) => {
            Failure::failed(format!("cancelled; the same command takes it up again ({})", journal.display()))
        }
        (StudyError::Render(e), Some(setup)) => setup.render_failure(e),
        (other, _) => Failure::failed(other),
    })?;

    // Write the page, and compare with the baseline.
    let now = Baseline::of(&report.subjects);
    let files = write(&report, &now, &args.output)?;
    let worse = baseline.map_or_else(Vec::new, |then| then.regressions(&now));
    console.result(
        &text(&report, &files, &worse),
        &Json { report: &report, files: &files, worse_than_baseline: &worse },
    )?;
    let (failed, failing) = (report.failed_cases(), report.failing_orders());
    match &worse[..] {
        [] if failed + failing > 0 => {
            Err(Failure::failed(format!("{failed} hard cases failed, and {failing} orders are not as documented")))
        }
        [] => Ok(()),
        [first, rest @ ..] => Err(Failure::failed(format!("worse than the baseline: {first}; {} more", rest.len()))),
    }
}

fn subject(setup: &Setup, args: &ReportArgs, suite: Suite) -> Subject {
    let mut view = setup.view.clone();
    if args.scene.scene.is_none() && args.scene.image.size.is_none() {
        view = reduced(&view, if suite == Suite::Quick { QUICK_PIXELS } else { FULL_PIXELS });
    }
    let stem = |path: &PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let file = args.scene.volume.path.as_ref().or(args.scene.scene.as_ref()).and_then(stem);
    let name = setup.phantom.clone().or(file).unwrap_or_else(|| "scene".to_owned());
    let phantom = setup.phantom.as_deref().and_then(vr_core::phantom::by_name).map(Into::into);
    Subject { name, title: setup.title.clone(), scene: setup.scene.clone(), view, phantom }
}

fn read_baseline(path: &Path) -> Result<Baseline, Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::failed(format!("{}: {e}", path.display()));
    let text = fs::read_to_string(path).map_err(|e| failed(&e))?;
    serde_json::from_str(&text).map_err(|e| failed(&e))
}

fn cannot_write(path: &Path, e: &std::io::Error) -> Failure {
    Failure::failed(format!("{}: cannot be written: {e}", path.display()))
}

/// Names of the files that [`write()`] may make.
const FILES: [&str; 6] = [PAGE, REPORT, POINTS, ERRORS, HEADLINE_PLOT, HEADLINE_TABLE];
const PAGE: &str = "index.html";
const REPORT: &str = "report.json";
const POINTS: &str = "points.csv";
const ERRORS: &str = "errors.json";
const HEADLINE_PLOT: &str = "headline.svg";
const HEADLINE_TABLE: &str = "headline.md";

/// Writes everything; returns what was written, the page first.
fn write(report: &Report, errors: &Baseline, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut files =
        vec![(PAGE, page(report).map_err(Failure::failed)?.into_bytes()), (REPORT, pretty(report)?.into_bytes())];
    if !report.subjects.is_empty() {
        files.push((POINTS, csv(&report.subjects).map_err(Failure::failed)?));
        files.push((ERRORS, (pretty(errors)? + "\n").into_bytes()));
        files.push((HEADLINE_PLOT, headline_plot(&report.subjects).map_err(Failure::failed)?.into_bytes()));
        files.push((HEADLINE_TABLE, headline_table(&report.subjects).into_bytes()));
    }
    let write = |(name, bytes): (&str, Vec<u8>)| {
        let path = folder.join(name);
        vr_io::write_bytes(&path, &bytes).map_err(Failure::failed)?;
        Ok(path)
    };
    files.into_iter().map(write).collect()
}

fn pretty(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value).map_err(Failure::failed)
}

#[derive(Serialize)]
struct Json<'a> {
    #[serde(flatten)]
    report: &'a Report,
    files: &'a [PathBuf],
    worse_than_baseline: &'a [String],
}

fn text(report: &Report, files: &[PathBuf], worse: &[String]) -> String {
    let mut text = String::new();
    if report.subjects.iter().flat_map(|s| &s.points).any(|p| p.times.is_some()) {
        text += &headline_table(&report.subjects);
        text += "\n";
    }
    if !report.orders.is_empty() {
        let (all, failing) = (report.orders.len(), report.failing_orders());
        text += &format!("orders     {all} measured, {failing} not as documented\n");
    }
    if !report.stability.is_empty() {
        let (all, failed) = (report.stability.len(), report.failed_cases());
        text += &format!("hard cases {all} pictures, {failed} unexplained failures\n");
    }
    for growth in &report.growth {
        let exponent = growth.exponent.map_or_else(String::new, |p| format!(", exponent {p:.2}"));
        text += &format!("growth     {} with {}{exponent}\n", growth.renderer, growth.grown.word());
    }
    for line in worse {
        text += &format!("worse      {line}\n");
    }
    let names: Vec<String> = files.iter().map(|p| p.display().to_string()).collect();
    text + &format!("took       {:.1} s\nwrote      {}\n", report.seconds, names.join(", "))
}
