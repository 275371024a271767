//! `vr info` of a rectilinear grid.

use serde::Serialize;
use vr_core::RectilinearGrid;
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
    /// World corners, lower and upper, of the box around all values.
    bounds: [[f64; 3]; 2],
    /// Smallest and largest distance of neighbouring values along each axis.
    steps: [[f64; 2]; 3],
    /// Smallest and largest value; `None` where none is finite.
    range: Option<[f64; 2]>,
    /// Values that are missing: the cells around them are vacuum.
    missing: usize,
    /// Number of values in equal bins over `range`.
    histogram: Vec<u64>,
    presets: Vec<&'static str>,
    look: &'a str,
    notes: &'a [String],
}

#[derive(Serialize)]
struct File<'a> {
    format: &'a str,
    encoding: &'a str,
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Components of the array that is taken.
    components: usize,
    /// Arrays that may be chosen with `--value`.
    arrays: &'a [String],
}

impl<'a> RectilinearInfo<'a> {
    pub fn new(
        title: &'a str,
        grid: &RectilinearGrid,
        info: Option<&'a FileInfo>,
        look: &'a str,
        notes: &'a [String],
    ) -> Self {
        let (low, high) = grid.bounds();
        let steps = grid.axes().each_ref().map(|axis| {
            let widths = axis.places().windows(2).map(|pair| pair[1] - pair[0]);
            widths.fold([f64::INFINITY, 0.0], |[low, high], width| [low.min(width), high.max(width)])
        });
        let range = grid.value_range();
        let stats = grid.lattice().value_stats();
        Self {
            volume: title,
            file: info.map(|i| File {
                format: i.format,
                encoding: i.encoding,
                scalar: i.scalar.name(),
                components: i.components,
                arrays: &i.columns,
            }),
            dims: grid.dims(),
            bounds: [low.to_array(), high.to_array()],
            steps,
            range: range.map(|(low, high)| [low, high]),
            missing: stats.nan + stats.infinite,
            histogram: Histogram::of(grid.lattice(), DRAWN.0).map(|h| h.counts).unwrap_or_default(),
            presets: range
                .map_or_else(Vec::new, |range| Preset::suggest(range, false))
                .iter()
                .map(|p| p.name())
                .collect(),
            look,
            notes,
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut text = format!("volume       {}\n", self.volume);
        let mut line = |name: &str, what: String| text += &format!("{name:<12} {what}\n");
        if let Some(File { format, encoding, scalar, components, arrays }) = &self.file {
            line("format", format!("{format}, {encoding} {scalar}"));
            line("arrays", arrays.join(", "));
            if *components > 1 {
                line("components", format!("{components} of the array; their length or one of them is shown"));
            }
        }
        line("size", format!("{} values between uneven planes", number::triple(self.dims, "×")));
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        line("bounds", format!("{low} to {high}"));
        for (name, [low, high]) in ["x", "y", "z"].into_iter().zip(self.steps) {
            line(&format!("steps in {name}"), format!("{} to {}", number::value(low), number::value(high)));
        }
        let range = self.range.map(|ends| ends.map(number::value));
        line("values", range.map_or("none is finite".to_owned(), |[low, high]| format!("{low} to {high}")));
        if self.missing > 0 {
            line("missing", format!("{}; the cells around them are vacuum", self.missing));
        }
        line("look", self.look.trim_start_matches("look: ").to_owned());
        if !self.presets.is_empty() {
            line("try", format!("--transfer {}", self.presets.join(" | ")));
        }
        let Some([low, high]) = self.range else { return text };
        let drawn = Histogram { range: (low, high), counts: self.histogram.clone() }.draw(DRAWN.1);
        text + &format!("\nhistogram (height: logarithm of the count)\n{drawn}")
    }
}

#[cfg(test)]
mod tests {
    use vr_core::rectilinear::Centering;

    use super::*;

    #[test]
    fn planes_and_values_are_told() {
        let axes = [vec![0.0, 1.0, 10.0], vec![0.0, 1.0], vec![0.0, 2.0]];
        let mut values: Vec<f32> = (0..12u8).map(f32::from).collect();
        values[5] = f32::NAN;
        let grid = RectilinearGrid::new(axes, values, Centering::Points).unwrap();
        let info = RectilinearInfo::new("planes", &grid, None, "look: plain", &[]);
        assert_eq!((info.dims, info.steps[0], info.missing), ([3, 2, 2], [1.0, 9.0], 1));
        let text = info.text();
        assert!(text.contains("size         3×2×2 values between uneven planes"), "{text}");
        assert!(text.contains("steps in x   1 to 9") && text.contains("missing      1;"), "{text}");
    }
}
