//! `vr info` of an adaptive mesh.

use serde::Serialize;
use vr_core::AmrGrid;
use vr_core::transfer::Preset;
use vr_io::FileInfo;

use crate::histogram::Histogram;
use crate::number;

/// Number of columns and rows of the drawn histogram.
const DRAWN: (usize, usize) = (72, 8);
/// Parts that the whole volume counts in the drawn histogram.
const PARTS: f64 = 1e6;

/// Description of an adaptive mesh.
#[derive(Serialize)]
pub struct AmrInfo<'a> {
    volume: &'a str,
    file: Option<File<'a>>,
    levels: Vec<Level>,
    /// `cells` or `points`: to which the values belong.
    values_of: &'static str,
    /// World corners, lower and upper, of the box around all values.
    bounds: [[f64; 3]; 2],
    /// Cells of a uniform grid over the same box that is as fine everywhere.
    finest_dims: [u64; 3],
    /// Bytes of memory.
    bytes: usize,
    /// Smallest and largest value.
    range: [f64; 2],
    /// Values that are not finite, of which there is vacuum.
    missing: usize,
    /// Values that two blocks of a level both have.
    repeated: usize,
    /// Shares of the volume in equal bins over `range`.
    histogram: Vec<f64>,
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
    /// Time steps in the file.
    frames: usize,
    /// Arrays that may be chosen with `--value`.
    arrays: &'a [String],
}

#[derive(Serialize)]
struct Level {
    /// Cells of this level along the edges of a cell of the level before.
    ratio: [u32; 3],
    spacing: [f64; 3],
    blocks: usize,
    /// Cells that no finer ones cover.
    leaf_cells: usize,
}

impl<'a> AmrInfo<'a> {
    pub fn new(title: &'a str, grid: &AmrGrid, info: Option<&'a FileInfo>, look: &'a str, notes: &'a [String]) -> Self {
        let (low, high) = grid.bounds();
        let (min, max) = grid.value_range();
        let level = |level: usize| Level {
            ratio: grid.ratio_of(level),
            spacing: grid.spacing_of(level).to_array(),
            blocks: grid.blocks_of(level).len(),
            leaf_cells: grid.leaf_cells(level),
        };
        Self {
            volume: title,
            file: info.map(|i| File {
                format: i.format,
                encoding: i.encoding,
                scalar: i.scalar.name(),
                frames: i.frames,
                arrays: &i.columns,
            }),
            levels: (0..grid.levels()).map(level).collect(),
            values_of: grid.centring().name(),
            bounds: [low.to_array(), high.to_array()],
            finest_dims: grid.finest_dims(),
            bytes: grid.bytes(),
            range: [min, max],
            missing: grid.missing_values(),
            repeated: grid.repeated_values(),
            histogram: histogram(grid, DRAWN.0),
            presets: Preset::suggest((min, max), false).iter().map(|preset| preset.name()).collect(),
            look,
            notes,
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut text = format!("volume       {}\n", self.volume);
        let mut line = |name: &str, what: String| text += &format!("{name:<12} {what}\n");
        if let Some(File { format, encoding, scalar, frames, arrays }) = &self.file {
            line("format", format!("{format}, {encoding}, values {scalar}"));
            line("arrays", arrays.join(", "));
            if *frames > 1 {
                line("series", format!("{frames} frames, one of which is shown"));
            }
        }
        let (leaves, blocks) =
            self.levels.iter().fold((0, 0), |(cells, blocks), l| (cells + l.leaf_cells, blocks + l.blocks));
        line(
            "size",
            format!("{} levels, {blocks} blocks, {leaves} cells, values of {}", self.levels.len(), self.values_of),
        );
        for (number, Level { ratio, spacing, blocks, leaf_cells }) in self.levels.iter().enumerate() {
            let spacing = number::triple(spacing.map(number::value), " × ");
            let refined =
                if number > 0 { format!(", refined by {}", number::triple(*ratio, "×")) } else { String::new() };
            line(
                &format!("level {number}"),
                format!(
                    "{blocks} block{}, {leaf_cells} cells that are not refined, spacing {spacing}{refined}",
                    if *blocks == 1 { "" } else { "s" }
                ),
            );
        }
        let uniform = self.finest_dims.iter().map(|&n| n as f64).product::<f64>();
        let bytes = self.bytes as f64;
        line(
            "memory",
            format!(
                "{:.1} MB; a uniform grid of {} as fine everywhere takes {:.1} MB",
                bytes / 1e6,
                number::triple(self.finest_dims, "×"),
                4.0 * uniform / 1e6
            ),
        );
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        line("bounds", format!("{low} to {high}"));
        let [min, max] = self.range.map(number::value);
        line("values", format!("{min} to {max}"));
        if self.missing > 0 {
            line("missing", format!("{} values, around which is vacuum", self.missing));
        }
        if self.repeated > 0 {
            line("repeated", format!("{} values that two blocks of a level both have, and are equal", self.repeated));
        }
        line("look", self.look.trim_start_matches("look: ").to_owned());
        if !self.presets.is_empty() {
            line("try", format!("--transfer {}", self.presets.join(" | ")));
        }
        // Whatever occurs at all counts.
        let counts = self.histogram.iter().map(|share| (share * PARTS).ceil() as u64).collect();
        let drawn = Histogram { range: (self.range[0], self.range[1]), counts }.draw(DRAWN.1);
        text + &format!("\nhistogram (height: logarithm of the volume)\n{drawn}")
    }
}

/// Shares of the volume by value, in equal bins over the range of the values.
fn histogram(grid: &AmrGrid, bins: usize) -> Vec<f64> {
    let (low, high) = grid.value_range();
    let scale = if high > low { bins as f64 / (high - low) } else { 0.0 };
    let mut volumes = vec![0.0; bins];
    grid.each_leaf(|level, value| {
        if !value.is_nan() {
            let bin = ((f64::from(value) - low) * scale) as usize;
            volumes[bin.min(bins - 1)] += grid.spacing_of(level).element_product();
        }
    });
    let total: f64 = volumes.iter().sum();
    volumes.iter().map(|volume| volume / total).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use vr_core::amr::{AmrBlock, AmrCentring};

    use super::*;

    #[test]
    fn levels_are_told_and_shares_of_the_volume_add_up() {
        let block = |level, dims: [usize; 3], value| {
            let values = vec![value; dims.iter().product()];
            AmrBlock { level, first: [0; 3], dims, values }
        };
        let blocks = vec![block(0, [4; 3], 1.0), block(1, [8, 8, 4], 3.0)];
        let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![[2; 3]], blocks, AmrCentring::Cells).unwrap();
        let info = AmrInfo::new("two", &grid, None, "look: plain", &[]);
        assert_eq!((info.histogram[0], info.histogram[DRAWN.0 - 1]), (0.5, 0.5));
        let text = info.text();
        assert!(text.contains("size         2 levels, 2 blocks, 288 cells, values of cells"), "{text}");
        assert!(
            text.contains(
                "level 1      1 block, 256 cells that are not refined, spacing 0.5 × 0.5 × 0.5, refined by 2×2×2"
            ),
            "{text}"
        );
        assert!(text.contains("a uniform grid of 8×8×8 as fine"), "{text}");
    }
}
