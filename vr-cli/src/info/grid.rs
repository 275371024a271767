//! `vr info` of a uniform grid: facts, a histogram, and slices in a picture.

use std::path::Path;

use serde::Serialize;
use vr_core::transfer::Preset;
use vr_core::{Calibration, ColorGrid, GridVolume, VoxelType};
use vr_io::{FileInfo, LoadedVolume, PngOptions};
use vr_look::Histogram;
use vr_look::{Look, Survey};

use crate::args::InfoArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::info::label_table::LabelTable;
use crate::info::lines::{COLUMNS, Lines};
use crate::info::slices;
use crate::inputs::Inputs;
use crate::number;

/// Number of bins of the histogram in a picture.
const FINE: usize = 256;

/// Describes a grid, and draws its slices where that is asked for.
///
/// # Errors
/// A picture that cannot be written, labels that cannot be read.
pub fn run(
    args: &InfoArgs,
    title: &str,
    loaded: &LoadedVolume,
    uniform: &GridVolume,
    console: Console,
) -> Result<(), Failure> {
    let LoadedVolume { volume, info, notes, .. } = loaded;
    let patient = info.as_ref().is_some_and(|file| file.space.is_patient());
    let hints = info.as_ref().map(FileInfo::hints).unwrap_or_default();
    let suggest = |range| Preset::suggest(range, uniform.voxel_type().is_integer());
    if let Some(place) = &args.output {
        let files = info.iter().flat_map(|file| file.files.iter().cloned());
        Inputs::new("a file that is read", files).permit("--output", place, args.replace)?;
        let window = info.as_ref().and_then(|file| file.window);
        let fine = Histogram::of(uniform, FINE);
        let picture = slices::draw(uniform, patient, window, fine.as_ref());
        vr_io::write(place, &picture, &PngOptions::default()).map_err(Failure::failed)?;
    }
    let look = Survey::of(volume).look(&hints);
    let labels = LabelTable::of(args, volume, info.as_ref(), &look.kind)?;
    let description = GridInfo {
        title,
        file: info.as_ref(),
        uniform,
        colors: volume.colors().map(|colors| &**colors),
        histogram: Histogram::of(uniform, COLUMNS),
        // Presets are for numbers; colours are shown as they are.
        presets: volume.grid().and_then(|grid| grid.value_range()).map_or_else(Vec::new, suggest),
        picture: args.output.as_deref(),
        look,
        labels,
        notes,
    };
    console.result(&description.text(), &description.json())
}

/// Description of a uniform grid.
struct GridInfo<'a> {
    title: &'a str,
    /// File; `None` for a phantom.
    file: Option<&'a FileInfo>,
    uniform: &'a GridVolume,
    /// Colours of the voxels, where they have any.
    colors: Option<&'a ColorGrid>,
    histogram: Option<Histogram>,
    presets: Vec<Preset>,
    look: Look,
    /// Place of the slices, if they were drawn.
    picture: Option<&'a Path>,
    labels: Option<LabelTable>,
    notes: &'a [String],
}

impl GridInfo<'_> {
    fn text(&self) -> String {
        let u = self.uniform;
        let dims = u.dims();
        let mut lines = Lines::default();
        lines.add("volume", self.title);
        if let Some(file) = self.file {
            let mapped = if file.mapped { ", mapped into memory" } else { "" };
            let FileInfo { format, encoding, scalar, endian, .. } = file;
            lines.add("format", format!("{format}, {encoding} {scalar} {endian}{mapped}"));
            if let Some(colors) = self.colors {
                lines.add(
                    "colours",
                    format!("{} components; the value is {}", file.components, colors.value_source().name()),
                );
            }
            if file.frames > 1 || file.components > 1 && self.colors.is_none() {
                lines.add(
                    "series",
                    format!("{} frames of {} components; one of each is shown", file.frames, file.components),
                );
            }
        }
        if let Some(modality) = self.file.and_then(|f| f.modality.as_deref()) {
            lines.add("modality", modality.to_owned());
        }
        lines.add(
            "size",
            format!(
                "{} voxels of {}, {}",
                number::triple(dims, "×"),
                u.voxel_type(),
                number::bytes(self.colors.map_or(u.sample_bytes(), ColorGrid::sample_bytes) as u64)
            ),
        );
        let unit = self.file.and_then(|f| f.units.as_deref()).unwrap_or_default();
        let spacing = number::triple(u.placement().spacing().to_array().map(number::value), " ");
        lines.add("spacing", format!("{spacing} {unit}").trim_end().to_owned());
        lines.add("orientation", self.orientation());
        for row in self.matrix() {
            lines.add("", format!("[{:>11} {:>11} {:>11} {:>11}]", row[0], row[1], row[2], row[3]));
        }
        let Calibration { slope, intercept } = u.calibration();
        if u.calibration() != Calibration::default() {
            lines.add(
                "calibration",
                format!("value = {} · stored + {}", number::value(slope), number::value(intercept)),
            );
        }
        let range = u.value_range();
        lines.add(
            "values",
            range.map_or_else(
                || "none is finite".to_owned(),
                |(low, high)| format!("{} to {}", number::value(low), number::value(high)),
            ),
        );
        if let Some([low, high]) = self.file.and_then(|f| f.window) {
            lines.add("window", format!("{} to {}; --range takes it", number::value(low), number::value(high)));
        }
        let stats = u.value_stats();
        if stats.nan + stats.infinite > 0 {
            lines.add(
                "missing",
                format!("{} NaN, {} infinite; cells with such a corner are vacuum", stats.nan, stats.infinite),
            );
        }
        lines.look(&self.look.reason, &self.presets.iter().map(|p| p.name()).collect::<Vec<_>>());
        if let Some(labels) = &self.labels {
            lines.add_text(&labels.text());
        }
        if let Some(histogram) = &self.histogram {
            lines.histogram(histogram, "count");
        }
        if let Some(place) = self.picture {
            lines.add_text(&format!("\nwrote        {}\n", place.display()));
        }
        lines.into_text()
    }

    /// Describes the source of the world matrix, and the kind of world.
    fn orientation(&self) -> String {
        let Some(file) = self.file else { return "the phantom's own frame".to_owned() };
        let world = if file.space.is_patient() {
            format!(
                "index axes towards {}, world RAS (file: {})",
                vr_io::orientation(self.uniform.placement()),
                file.space
            )
        } else {
            "the file's own frame".to_owned()
        };
        format!("{world}, placed by {}; index to world:", file.placed_by)
    }

    /// Returns the rows of the matrix from (x, y, z, 1) to world positions.
    fn matrix(&self) -> [[String; 4]; 3] {
        let p = self.uniform.placement();
        let rows = p.axes().transpose().to_cols_array_2d();
        let origin = p.origin().to_array();
        std::array::from_fn(|r| [rows[r][0], rows[r][1], rows[r][2], origin[r]].map(number::value))
    }

    fn json(&self) -> Json<'_> {
        let u = self.uniform;
        let p = u.placement();
        let Calibration { slope, intercept } = u.calibration();
        Json {
            volume: self.title,
            file: self.file.map(FileJson::of),
            dims: u.dims(),
            voxel_type: u.voxel_type(),
            spacing: p.spacing().to_array(),
            origin: p.origin().to_array(),
            axes: p.axes().to_cols_array_2d(),
            slope,
            intercept,
            range: u.value_range().map(|(low, high)| [low, high]),
            nan: u.value_stats().nan,
            infinite: u.value_stats().infinite,
            histogram: self.histogram.as_ref().map(|h| &*h.counts),
            presets: self.presets.iter().map(|p| p.name()).collect(),
            look: &self.look.reason,
            output: self.picture,
            labels: self.labels.as_ref(),
            notes: self.notes,
        }
    }
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    file: Option<FileJson<'a>>,
    dims: [usize; 3],
    #[serde(rename = "type")]
    voxel_type: VoxelType,
    spacing: [f64; 3],
    origin: [f64; 3],
    /// World vectors from one voxel to the next along x, y and z.
    axes: [[f64; 3]; 3],
    slope: f64,
    intercept: f64,
    range: Option<[f64; 2]>,
    nan: usize,
    infinite: usize,
    /// Numbers of voxels in equal bins over `range`.
    histogram: Option<&'a [u64]>,
    presets: Vec<&'static str>,
    look: &'a str,
    output: Option<&'a Path>,
    labels: Option<&'a LabelTable>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct FileJson<'a> {
    format: &'a str,
    encoding: &'a str,
    #[serde(rename = "type")]
    scalar: &'static str,
    endian: String,
    space: &'static str,
    placed_by: &'a str,
    units: Option<&'a str>,
    frames: usize,
    components: usize,
    mapped: bool,
    /// Kind of the scanner; `null` but for DICOM.
    modality: Option<&'a str>,
    /// Lower and upper end of the values that a DICOM file wants shown.
    window: Option<[f64; 2]>,
}

impl<'a> FileJson<'a> {
    fn of(file: &'a FileInfo) -> Self {
        Self {
            format: file.format,
            encoding: file.encoding,
            scalar: file.scalar.name(),
            endian: file.endian.to_string(),
            space: file.space.name(),
            placed_by: file.placed_by,
            units: file.units.as_deref(),
            frames: file.frames,
            components: file.components,
            mapped: file.mapped,
            modality: file.modality.as_deref(),
            window: file.window,
        }
    }
}
