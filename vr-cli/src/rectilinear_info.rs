//! `vr info` of a rectilinear grid.

use serde::Serialize;
use vr_core::RectilinearGrid;
use vr_core::resample::Integral;
use vr_core::transfer::Preset;
use vr_io::FileInfo;

use crate::histogram::Histogram;
use crate::number;

/// Number of columns and rows of the drawn histogram.
const DRAWN: (usize, usize) = (72, 8);

/// Description of a rectilinear grid.
#[derive(Serialize)]
pub struct RectilinearInfo<'a> {
    volume: &'a str,
    file: Option<File<'a>>,
    /// Values along x, y and z.
    dims: [usize; 3],
    /// World corners, lower and upper.
    bounds: [[f64; 3]; 2],
    /// Smallest, mean and largest step of each axis.
    steps: [[f64; 3]; 3],
    /// Cubic units that are not vacuum.
    total_volume: f64,
    /// Number of values that are missing.
    missing: usize,
    /// Smallest and largest value, if there is any.
    range: Option<[f64; 2]>,
    presets: Vec<&'static str>,
    look: &'a str,
    notes: &'a [String],
    #[serde(skip)]
    histogram: Option<Histogram>,
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
    /// Arrays that may be chosen with `--value`.
    arrays: &'a [String],
}

impl<'a> RectilinearInfo<'a> {
    pub fn new(
        title: &'a str,
        volume: &vr_core::Volume,
        grid: &RectilinearGrid,
        info: Option<&'a FileInfo>,
        look: &'a str,
        notes: &'a [String],
    ) -> Self {
        let (low, high) = grid.bounds();
        let range = grid.value_range();
        let stats = grid.lattice().value_stats();
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
            dims: grid.dims(),
            bounds: [low.to_array(), high.to_array()],
            steps: grid.axes().each_ref().map(|axis| [axis.smallest_step(), axis.mean_step(), axis.largest_step()]),
            total_volume: Integral::of(volume).map_or(f64::NAN, |integral| integral.volume),
            missing: stats.nan + stats.infinite,
            range: range.map(|(low, high)| [low, high]),
            presets: range.map_or_else(Vec::new, |r| Preset::suggest(r, false).iter().map(|p| p.name()).collect()),
            look,
            notes,
            histogram: Histogram::of(grid.lattice(), DRAWN.0),
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut text = format!("volume       {}\n", self.volume);
        let mut line = |name: &str, what: String| text += &format!("{name:<12} {what}\n");
        if let Some(File { format, encoding, scalar, frames, components, arrays }) = &self.file {
            line("format", format!("{format}, {encoding} {scalar}"));
            if !arrays.is_empty() {
                line("arrays", arrays.join(", "));
            }
            if *frames > 1 {
                line("series", format!("{frames} frames, one of which is shown"));
            }
            if *components > 1 {
                line("components", format!("{components} of the array; their length or one of them is shown"));
            }
        }
        line("size", format!("{} values where uneven planes meet", number::triple(self.dims, "×")));
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        line("bounds", format!("{low} to {high}"));
        for (axis, steps) in ["x", "y", "z"].into_iter().zip(self.steps) {
            let [least, mean, largest] = steps.map(number::value);
            line(&format!("steps on {axis}"), format!("{least} to {largest}, {mean} in the mean"));
        }
        let filled = number::value(self.total_volume);
        line("cells", format!("{filled} cubic units; {} values are missing", self.missing));
        if let Some([min, max]) = self.range.map(|range| range.map(number::value)) {
            line("values", format!("{min} to {max}"));
        }
        line("look", self.look.trim_start_matches("look: ").to_owned());
        if !self.presets.is_empty() {
            line("try", format!("--transfer {}", self.presets.join(" | ")));
        }
        if let Some(histogram) = &self.histogram {
            text += &format!("\nhistogram (height: logarithm of the number of values)\n{}", histogram.draw(DRAWN.1));
        }
        text
    }
}
