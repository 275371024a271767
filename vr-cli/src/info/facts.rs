//! Facts that `vr info` tells of every kind of volume but uniform grids.

use glam::DVec3;
use serde::Serialize;
use vr_core::transfer::Preset;
use vr_io::{FileInfo, LoadedVolume};
use vr_look::Histogram;
use vr_look::Survey;

use crate::info::lines::Lines;
use crate::number;

/// Title, file, box, look and presets of a volume.
#[derive(Serialize)]
pub struct Facts<'a> {
    volume: &'a str,
    /// `null` for a phantom.
    file: Option<File<'a>>,
    /// World corners, lower and upper, of the box around the volume.
    bounds: [[f64; 3]; 2],
    presets: Vec<&'static str>,
    look: String,
    notes: &'a [String],
}

#[derive(Serialize)]
struct File<'a> {
    format: &'a str,
    encoding: &'a str,
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Time steps in the file.
    frames: usize,
    /// Components of the array that is taken.
    components: usize,
    /// Arrays or columns that may be chosen with `--value`.
    arrays: &'a [String],
}

impl<'a> Facts<'a> {
    /// Collects the facts of a volume whose values have this range, if any is finite.
    pub fn new(title: &'a str, loaded: &'a LoadedVolume, bounds: (DVec3, DVec3), range: Option<(f64, f64)>) -> Self {
        let info = loaded.info.as_ref();
        let look = Survey::of(&loaded.volume).look(&info.map(FileInfo::hints).unwrap_or_default());
        Self {
            volume: title,
            file: info.map(|i| File {
                format: i.format,
                encoding: i.encoding,
                scalar: i.scalar.name(),
                frames: i.frames,
                components: i.components,
                arrays: &i.columns,
            }),
            bounds: [bounds.0.to_array(), bounds.1.to_array()],
            presets: range.map_or_else(Vec::new, |r| Preset::suggest(r, false).iter().map(|p| p.name()).collect()),
            look: look.reason,
            notes: &loaded.notes,
        }
    }

    /// Returns the first lines for people: the title and the file, in which `stored` are of the type that it names.
    pub fn begin(&self, stored: &str) -> Lines {
        let mut lines = Lines::default();
        lines.add("volume", self.volume);
        if let Some(File { format, encoding, scalar, frames, components, arrays }) = &self.file {
            lines.add("format", format!("{format}, {encoding}, {stored} {scalar}"));
            if !arrays.is_empty() {
                lines.add("arrays", arrays.join(", "));
            }
            if *frames > 1 {
                lines.add("series", format!("{frames} frames, one of which is shown"));
            }
            if *components > 1 {
                lines.add("components", format!("{components} of the array; their length or one of them is shown"));
            }
        }
        lines
    }

    /// Corners of the box, for people.
    pub fn bounds(&self) -> String {
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        format!("{low} to {high}")
    }

    /// Adds the last lines for people: the look, presets to try, and a histogram whose columns are as high as the logarithm of `height`.
    pub fn end(&self, mut lines: Lines, histogram: Option<&Histogram>, height: &str) -> String {
        lines.look(&self.look, &self.presets);
        if let Some(histogram) = histogram {
            lines.histogram(histogram, height);
        }
        lines.into_text()
    }
}
