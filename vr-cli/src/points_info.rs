//! `vr info` of scattered points.

use serde::Serialize;
use vr_core::PointSet;
use vr_core::transfer::Preset;
use vr_io::FileInfo;

use crate::number;

/// Description of scattered points.
#[derive(Serialize)]
pub struct PointsInfo<'a> {
    volume: &'a str,
    file: Option<File<'a>>,
    points: usize,
    /// World corners, lower and upper, of the box around all supports.
    bounds: [[f64; 3]; 2],
    kernel: &'static str,
    /// Smallest and largest radius of the points.
    radius: [f32; 2],
    weight_sum: f64,
    /// Smallest and largest value that a point carries.
    values: [f32; 2],
    /// Bounds of the field that the points make.
    field: [f64; 2],
    presets: Vec<&'static str>,
    notes: &'a [String],
}

#[derive(Serialize)]
struct File<'a> {
    format: &'a str,
    encoding: &'a str,
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Columns that may be chosen with `--value` and `--column`.
    columns: &'a [String],
}

impl<'a> PointsInfo<'a> {
    pub fn new(title: &'a str, points: &PointSet, info: Option<&'a FileInfo>, notes: &'a [String]) -> Self {
        let (low, high) = points.bounds();
        let (min, max) = points.value_range();
        Self {
            volume: title,
            file: info.map(|i| File {
                format: i.format,
                encoding: i.encoding,
                scalar: i.scalar.name(),
                columns: &i.columns,
            }),
            points: points.count(),
            bounds: [low.to_array(), high.to_array()],
            kernel: points.kernel().name(),
            radius: ends(points.radii()),
            weight_sum: points.weights().iter().map(|&w| f64::from(w)).sum(),
            values: ends(points.values()),
            field: [min, max],
            presets: Preset::suggest((min, max), false).iter().map(|preset| preset.name()).collect(),
            notes,
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut text = format!("volume       {}\n", self.volume);
        let mut line = |name: &str, what: String| text += &format!("{name:<12} {what}\n");
        if let Some(File { format, encoding, scalar, columns }) = &self.file {
            line("format", format!("{format}, {encoding}, positions {scalar}"));
            if !columns.is_empty() {
                line("columns", columns.join(", "));
            }
        }
        line("size", format!("{} points, spread by a {} kernel", self.points, self.kernel));
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        line("bounds", format!("{low} to {high}, with all supports"));
        let range = |[low, high]: [f64; 2]| format!("{} to {}", number::value(low), number::value(high));
        line("radii", range(self.radius.map(f64::from)));
        line("weights", format!("{} in all", number::value(self.weight_sum)));
        line("values", range(self.values.map(f64::from)));
        line("field", format!("within {}", range(self.field)));
        line("try", format!("--transfer {}", self.presets.join(" | ")));
        text
    }
}

/// Returns the smallest and largest of the numbers.
fn ends(numbers: &[f32]) -> [f32; 2] {
    numbers.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}
