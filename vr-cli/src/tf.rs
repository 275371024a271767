//! `vr tf`.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use serde::Serialize;
use vr_core::transfer::{PresetUnit, TransferRow, linear_to_srgb};
use vr_core::{ControlPoint, OpacityRule, Shading, TransferFunction};
use vr_io::{
    LoadedScene, PngOptions, SceneFile, TRANSFER_EXTENSIONS, TransferPoints, TransferSection, TransferSource,
    VolumeSection,
};
use vr_look::Histogram;

use crate::args::TfArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::inputs::{Inputs, apart};
use crate::joint_histogram::JointHistogram;
use crate::overrides::names_file;
use crate::scene_setup::{Origin, title};
use crate::table::Table;
use crate::{number, output_file, tf_picture, tf_plane};

/// Bins of the histogram behind a drawing.
const BINS: usize = 256;

/// Prints a transfer function, draws it, and converts it.
///
/// # Errors
/// Any fault of the command line, the source, the volume, or the files to be written.
pub fn run(args: &TfArgs, console: Console) -> Result<(), Failure> {
    // Check what is written before anything is read.
    let extensions: Vec<&str> = TRANSFER_EXTENSIONS.into_iter().chain(["png"]).collect();
    for (k, path) in args.outputs.iter().enumerate() {
        output_file::check(path, &extensions)?;
        args.outputs[..k].iter().try_for_each(|other| apart(("-o", path), ("another output", other)))?;
    }
    let source = Source::of(&args.source);
    let has_volume = args.volume.path.is_some() || args.volume.phantom.is_some();
    let mut found = if has_volume { with_volume(&source, args)? } else { alone(&source, args)? };
    let inputs = Inputs::new("a file that is read", found.files.drain(..));
    args.outputs.iter().try_for_each(|path| inputs.permit("-o", path, args.replace))?;
    for note in &found.notes {
        console.note(note);
    }

    // Draw and convert.
    for path in &args.outputs {
        if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
            let picture = if found.transfer.has_rows() {
                tf_plane::draw(&found.transfer, found.joint.as_ref())
            } else {
                tf_picture::draw(&found.transfer, found.histogram.as_ref())
            };
            vr_io::write(path, &picture, &PngOptions::default()).map_err(Failure::failed)?;
            continue;
        }
        let source = TransferSource {
            name: &found.name,
            transfer: &found.transfer,
            shading: found.shading.as_ref(),
            gradient_per_voxel: &found.gradient_per_voxel,
        };
        let notes = vr_io::write_transfer(path, &source).map_err(Failure::failed)?;
        for note in notes {
            let note = format!("{}: {note}", path.display());
            console.note(&note);
            found.notes.push(note);
        }
    }
    console.result(&found.text(&args.outputs), &found.json(&args.outputs))
}

/// Source of a transfer function.
enum Source<'a> {
    Preset(Cow<'a, str>),
    File(&'a Path),
    Auto,
}

impl<'a> Source<'a> {
    /// Takes a word as `--transfer` does.
    fn of(word: &'a Path) -> Self {
        if names_file(word) {
            return Self::File(word);
        }
        match word.to_string_lossy() {
            word if word == "auto" => Self::Auto,
            name => Self::Preset(name),
        }
    }

    /// Name for formats that hold one.
    fn name(&self) -> String {
        match self {
            Self::Preset(name) => name.clone().into_owned(),
            Self::File(path) => path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned()),
            Self::Auto => "auto".to_owned(),
        }
    }
}

/// Transfer function, and what belongs to it.
struct Found {
    name: String,
    /// Description in a few words.
    title: String,
    transfer: TransferFunction,
    shading: Option<Shading>,
    gradient_per_voxel: Vec<(f64, f64)>,
    histogram: Option<Histogram>,
    /// Histogram by value and gradient, where the transfer function is of both.
    joint: Option<JointHistogram>,
    /// Files that were read.
    files: Vec<PathBuf>,
    notes: Vec<String>,
}

/// The transfer function that a volume would be drawn with.
fn with_volume(source: &Source<'_>, args: &TfArgs) -> Result<Found, Failure> {
    let mut origin = Origin::default();
    let mut volume = VolumeSection::default();
    origin.overrides.volume(&args.volume, &mut volume)?;
    let section = TransferSection {
        preset: if let Source::Preset(name) = source { Some(name.clone().into_owned()) } else { None },
        file: if let Source::File(path) = source { Some((*path).into()) } else { None },
        range: args.range,
        ..TransferSection::default()
    };
    if matches!(source, Source::Auto) && args.range.is_some() {
        return Err(Failure::usage("--range: the automatic look finds its own; a preset or a file is stretched"));
    }
    let transfer = (!matches!(source, Source::Auto)).then_some(section);
    let file = SceneFile { volume, transfer, ..SceneFile::default() };
    let loaded = vr_io::resolve_scene(&file, Path::new("")).map_err(|e| origin.scene_failure(e))?;
    let LoadedScene { scene, files, notes, .. } = loaded;
    Ok(Found {
        name: source.name(),
        title: format!("{} for {}", source.name(), title(&file.volume, &scene.volume)),
        transfer: (*scene.transfer).clone(),
        shading: scene.shading.as_deref().cloned(),
        gradient_per_voxel: Vec::new(),
        histogram: scene.volume.grid().and_then(|grid| Histogram::of(grid, BINS)),
        joint: scene
            .volume
            .grid()
            .filter(|_| scene.transfer.has_rows())
            .and_then(|grid| JointHistogram::of(grid, [BINS; 2])),
        files,
        notes,
    })
}

/// The transfer function by itself.
fn alone(source: &Source<'_>, args: &TfArgs) -> Result<Found, Failure> {
    let asked = match args.range {
        Some([low, high]) if low <= high && low.is_finite() && high.is_finite() => Some((low, high)),
        Some([low, high]) => {
            let message = format!("--range: found {low},{high}; must be two finite numbers, the smaller one first");
            return Err(Failure::usage(message));
        }
        None => None,
    };
    let found = |title: String, points: TransferPoints, rule, unit| {
        let transfer = points.function(rule, unit).map_err(Failure::failed)?;
        Ok(Found {
            name: source.name(),
            title,
            transfer,
            shading: None,
            gradient_per_voxel: Vec::new(),
            histogram: None,
            joint: None,
            files: Vec::new(),
            notes: Vec::new(),
        })
    };
    match source {
        Source::Auto => Err(Failure::usage("auto: found no volume; the look is found from one: vr tf auto VOLUME")),
        Source::Preset(name) => {
            let preset = vr_io::preset_by_name(name).map_err(Failure::usage)?;
            let usual = if preset.unit() == PresetUnit::Hounsfield { (-1024.0, 3071.0) } else { (0.0, 1.0) };
            let points = preset.points(asked.unwrap_or(usual));
            let title = format!("{preset}, in {}: {}", preset.unit().name(), preset.title());
            Ok(Found { shading: preset.shading(), ..found(title, points.into(), OpacityRule::Power, 1.0)? })
        }
        Source::File(path) => {
            let file = vr_io::read_transfer(path).map_err(Failure::failed)?;
            let points = file.transfer_points(asked);
            let name = if file.name.is_empty() { source.name() } else { file.name };
            let relative = if file.absolute { "" } else { ", to be spread over a volume's values" };
            let title = format!("{name} of {}, {}{relative}", path.display(), file.format);
            let rule = file.opacity_rule.unwrap_or_default();
            Ok(Found {
                name,
                shading: file.shading,
                gradient_per_voxel: file.gradient_per_voxel,
                files: vec![path.into()],
                notes: file.notes,
                ..found(title, points, rule, file.unit_distance.unwrap_or(1.0))?
            })
        }
    }
}

impl Found {
    fn text(&self, outputs: &[PathBuf]) -> String {
        let points = self.transfer.points();
        let mut text = format!("transfer {}\n", self.title);
        let rule = match self.transfer.rule() {
            OpacityRule::Power => "power",
            OpacityRule::Extinction => "extinction",
        };
        text += &format!("opacity  of a length of {}, {rule} rule\n", number::value(self.transfer.unit_distance()));
        if let Some(Shading { ambient, diffuse, specular, power, .. }) = &self.shading {
            text += &format!("shading  ambient {ambient}, diffuse {diffuse}, specular {specular}, power {power}\n");
        }
        match self.transfer.rows() {
            [] => text += &format!("\n{}", table(points)),
            rows => {
                for row in rows {
                    let magnitude = number::value(row.gradient);
                    text += &format!("\ngradient {magnitude} per world unit\n{}", table(row.transfer.points()));
                }
            }
        }
        if !outputs.is_empty() {
            let outputs: Vec<String> = outputs.iter().map(|p| p.display().to_string()).collect();
            text += &format!("\nwrote    {}\n", outputs.join(", "));
        }
        text
    }

    fn json<'a>(&'a self, outputs: &'a [PathBuf]) -> Json<'a> {
        let point = |p: &ControlPoint| PointJson {
            value: p.value,
            color: p.color,
            srgb: hex(p.color),
            opacity: p.opacity,
            emission: p.emission,
        };
        let points = |transfer: &TransferFunction| transfer.points().iter().map(point).collect();
        let row = |row: &TransferRow| RowJson { gradient: row.gradient, points: points(&row.transfer) };
        Json {
            name: &self.name,
            unit_distance: self.transfer.unit_distance(),
            opacity_rule: self.transfer.rule(),
            points: if self.transfer.has_rows() { Vec::new() } else { points(&self.transfer) },
            rows: self.transfer.rows().iter().map(row).collect(),
            shading: self.shading.as_ref().map(|s| ShadingJson {
                ambient: s.ambient,
                diffuse: s.diffuse,
                specular: s.specular,
                power: s.power,
            }),
            outputs,
            notes: &self.notes,
        }
    }
}

/// Lists points.
fn table(points: &[ControlPoint]) -> Table {
    let mut table = Table::new(&["value", "colour", "opacity"]);
    for p in points {
        table.row([number::value(p.value), hex(p.color), number::value(p.opacity)]);
    }
    table
}

/// A linear colour as it is on the screen: `#ffcc00`.
fn hex(color: [f64; 3]) -> String {
    let [r, g, b] = color.map(|c| (255.0 * linear_to_srgb(c.clamp(0.0, 1.0))).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[derive(Serialize)]
struct Json<'a> {
    name: &'a str,
    unit_distance: f64,
    opacity_rule: OpacityRule,
    points: Vec<PointJson>,
    /// Rows of a two-dimensional transfer function, which has no other points.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rows: Vec<RowJson>,
    shading: Option<ShadingJson>,
    #[serde(serialize_with = "output_file::as_texts")]
    outputs: &'a [PathBuf],
    notes: &'a [String],
}

#[derive(Serialize)]
struct RowJson {
    gradient: f64,
    points: Vec<PointJson>,
}

#[derive(Serialize)]
struct PointJson {
    value: f64,
    /// Linear light.
    color: [f64; 3],
    srgb: String,
    opacity: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    emission: Option<[f64; 3]>,
}

#[derive(Serialize)]
struct ShadingJson {
    ambient: f64,
    diffuse: f64,
    specular: f64,
    power: f64,
}
