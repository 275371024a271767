//! `vr report`.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use vr_core::cancel::catch_stopped;
use vr_core::{Control, Options, RenderError};
use vr_io::AnnotationsSection;
use vr_study::StudyError;
use vr_study::baseline::Baseline;
use vr_study::origin::{Origin, shell_line};
use vr_study::report::{csv, headline_plot, headline_table, is_page, page};
use vr_study::subject::{Subject, reduced};
use vr_study::suite::{Report, Run, Suite};

use crate::args::{ReportArgs, SuiteName};
use crate::console::Console;
use crate::failure::Failure;
use crate::heap::Heap;
use crate::inputs::Inputs;
use crate::picture_record::record_of;
use crate::progress::under_bar;
use crate::renderers::StatedRenderer;
use crate::scene_file::read_from;
use crate::scene_setup::{Setup, named_scene};
use crate::{exact_cache, output_file, renderers, report_summary};

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
    let mut setup = named_scene(&args.scene, console)?;
    if let Some(setup) = &setup {
        setup.note_unused_renderer("renderers are measured under settings of their own", console);
        setup.note_unused_annotations(console);
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
    if !args.force {
        check_folder(&args.output, &journal)?;
    }
    let own = setup.as_mut().map(|setup| own_subject(setup, args, suite)).transpose()?;
    fs::create_dir_all(&args.output).map_err(|e| cannot_write(&args.output, &e))?;
    // Measure; a journal keeps what is done.
    let cache = exact_cache::open(&args.cache, console);
    let run = Run {
        renderers: &chosen,
        own: own.as_ref().map(|(subject, _)| subject.clone()),
        untimed: args.untimed,
        cache: &cache,
        meter: Some(&Heap),
        command: Some(shell_line(
            &std::iter::once("vr".to_owned()).chain(std::env::args().skip(1)).collect::<Vec<_>>(),
        )),
        journal: Some(&journal),
    };
    let measured = under_bar(console, control, "measuring", |progress| {
        // Cancelled anywhere, the journal has what was done.
        catch_stopped(|| run.run(suite, (control, &|share| progress.report(share))))
    });
    let report = measured.map_err(|e| match (e, &setup) {
        (StudyError::Render(RenderError::Cancelled), _) => {
            Failure::failed(format!("cancelled; the same command takes it up again ({})", journal.display()))
        }
        (StudyError::Render(e), Some(setup)) => setup.render_failure(e),
        (other, _) => Failure::failed(other),
    })?;

    // Write the page, and compare with the baseline.
    let now = Baseline::of(&report.subjects);
    let scene = own.map(|(_, scene)| scene).filter(|_| !report.subjects.is_empty());
    let files = write(&report, &now, scene, &args.output)?;
    let worse = baseline.map_or_else(Vec::new, |then| then.regressions(&now));
    console.result(
        &report_summary::text(&report, &files, &worse, args.all),
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

/// Returns the subject that flags name, and the scene file by which its pictures are made again. The view of the set-up becomes the subject's.
fn own_subject(setup: &mut Setup, args: &ReportArgs, suite: Suite) -> Result<(Subject, String), Failure> {
    if args.scene.scene.is_none() && args.scene.image.size.is_none() {
        setup.view = reduced(&setup.view, if suite == Suite::Quick { QUICK_PIXELS } else { FULL_PIXELS });
    }
    let stem = |path: &PathBuf| path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let file = args.scene.volume.path.as_ref().or(args.scene.scene.as_ref()).and_then(stem);
    let name = setup.phantom.clone().or(file).unwrap_or_else(|| "scene".to_owned());
    let phantom = setup.phantom.as_deref().and_then(vr_core::phantom::by_name).map(Into::into);

    // Each command names the renderer and its options: the scene file is to say nothing of them.
    let usual = renderers::named(renderers::usual(&setup.scene)).map_err(Failure::failed)?;
    let stated = StatedRenderer::of(&*usual, None);
    let mut file = read_from(setup.complete_file(&stated), &args.output, setup);
    file.annotations = AnnotationsSection::default();
    (file.render.renderer, file.render.options, file.render.max_error) = (None, Options::new(), None);
    let heading = format!("Scene of the report about {}, for any renderer.", setup.title);
    let text = vr_io::commented_scene(&file, &heading, &[]).map_err(Failure::failed)?;
    let origin = Origin {
        scene: ["--scene", SCENE].map(str::to_owned).to_vec(),
        camera: Vec::new(),
        record: Some(record_of(setup, &stated, None)?),
        note: Some(format!("The commands are to be run in the folder of this page, where {SCENE} is.")),
    };
    let (title, scene, view) = (setup.title.clone(), setup.scene.clone(), setup.view.clone());
    Ok((Subject { name, title, scene, view, phantom, origin }, text))
}

/// Refuses a folder in which a report would replace files that are not from an earlier report.
fn check_folder(folder: &Path, journal: &Path) -> Result<(), Failure> {
    let page = folder.join(PAGE);
    let is_ours = journal.exists() || vr_io::read_text(&page, LONGEST).is_ok_and(|text| is_page(&text));
    match FILES.iter().map(|name| folder.join(name)).find(|file| file.exists()) {
        Some(file) if !is_ours => Err(Failure::usage(format!(
            "--output: {} is there, and the folder holds no earlier report; name another folder, or replace it by --force",
            file.display()
        ))),
        _ => Ok(()),
    }
}

/// Longest page or baseline that is read.
const LONGEST: u64 = 1 << 28;

fn read_baseline(path: &Path) -> Result<Baseline, Failure> {
    let failed = |e: &dyn std::fmt::Display| Failure::failed(format!("{}: {e}", path.display()));
    let text = vr_io::read_text(path, LONGEST).map_err(|e| failed(&e))?;
    serde_json::from_str(&text).map_err(|e| failed(&e))
}

fn cannot_write(path: &Path, e: &std::io::Error) -> Failure {
    Failure::failed(format!("{}: cannot be written: {e}", path.display()))
}

/// Names of the files that [`write()`] may make.
const FILES: [&str; 7] = [PAGE, REPORT, POINTS, ERRORS, HEADLINE_PLOT, HEADLINE_TABLE, SCENE];
const PAGE: &str = "index.html";
const REPORT: &str = "report.json";
const POINTS: &str = "points.csv";
const ERRORS: &str = "errors.json";
const HEADLINE_PLOT: &str = "headline.svg";
const HEADLINE_TABLE: &str = "headline.md";
const SCENE: &str = "scene.toml";

/// Writes everything, the text of a scene file among it if there is one; returns what was written, the page first.
fn write(report: &Report, errors: &Baseline, scene: Option<String>, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut files =
        vec![(PAGE, page(report).map_err(Failure::failed)?.into_bytes()), (REPORT, pretty(report)?.into_bytes())];
    if !report.subjects.is_empty() {
        files.push((POINTS, csv(&report.subjects).map_err(Failure::failed)?));
        files.push((ERRORS, (pretty(errors)? + "\n").into_bytes()));
        files.push((HEADLINE_PLOT, headline_plot(&report.subjects).map_err(Failure::failed)?.into_bytes()));
        files.push((HEADLINE_TABLE, headline_table(&report.subjects).into_bytes()));
    }
    files.extend(scene.map(|text| (SCENE, text.into_bytes())));
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
    #[serde(serialize_with = "output_file::as_texts")]
    files: &'a [PathBuf],
    worse_than_baseline: &'a [String],
}
