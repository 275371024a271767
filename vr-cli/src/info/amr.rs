//! `vr info` of an adaptive mesh.

use serde::Serialize;
use vr_core::AmrGrid;
use vr_io::LoadedVolume;
use vr_look::Histogram;

use crate::info::facts::Facts;
use crate::info::lines::COLUMNS;
use crate::number;

/// Description of an adaptive mesh.
#[derive(Serialize)]
pub struct AmrInfo<'a> {
    #[serde(flatten)]
    facts: Facts<'a>,
    levels: Vec<Level>,
    /// `cells` or `points`: to which the values belong.
    values_of: &'static str,
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
    pub fn new(title: &'a str, loaded: &'a LoadedVolume, grid: &AmrGrid) -> Self {
        let (min, max) = grid.value_range();
        let level = |level: usize| Level {
            ratio: grid.ratio_of(level),
            spacing: grid.spacing_of(level).to_array(),
            blocks: grid.blocks_of(level).len(),
            leaf_cells: grid.leaf_cells(level),
        };
        Self {
            facts: Facts::new(title, loaded, grid.bounds(), Some((min, max))),
            levels: (0..grid.levels()).map(level).collect(),
            values_of: grid.centring().name(),
            finest_dims: grid.finest_dims(),
            bytes: grid.bytes(),
            range: [min, max],
            missing: grid.missing_values(),
            repeated: grid.repeated_values(),
            histogram: histogram(grid, COLUMNS),
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut lines = self.facts.begin("values");
        let (leaves, blocks) =
            self.levels.iter().fold((0, 0), |(cells, blocks), l| (cells + l.leaf_cells, blocks + l.blocks));
        lines.add(
            "size",
            format!("{} levels, {blocks} blocks, {leaves} cells, values of {}", self.levels.len(), self.values_of),
        );
        for (number, Level { ratio, spacing, blocks, leaf_cells }) in self.levels.iter().enumerate() {
            let spacing = number::triple(spacing.map(number::value), " × ");
            let refined =
                if number > 0 { format!(", refined by {}", number::triple(*ratio, "×")) } else { String::new() };
            lines.add(
                &format!("level {number}"),
                format!(
                    "{blocks} block{}, {leaf_cells} cells that are not refined, spacing {spacing}{refined}",
                    if *blocks == 1 { "" } else { "s" }
                ),
            );
        }
        let uniform = self.finest_dims.iter().map(|&n| n as f64).product::<f64>();
        let bytes = self.bytes as f64;
        lines.add(
            "memory",
            format!(
                "{:.1} MB; a uniform grid of {} as fine everywhere takes {:.1} MB",
                bytes / 1e6,
                number::triple(self.finest_dims, "×"),
                4.0 * uniform / 1e6
            ),
        );
        lines.add("bounds", self.facts.bounds());
        let [min, max] = self.range.map(number::value);
        lines.add("values", format!("{min} to {max}"));
        if self.missing > 0 {
            lines.add("missing", format!("{} values, around which is vacuum", self.missing));
        }
        if self.repeated > 0 {
            lines.add(
                "repeated",
                format!("{} values that two blocks of a level both have, and are equal", self.repeated),
            );
        }
        self.facts.end(lines, Some(&Histogram::of_shares(self.range, &self.histogram)), "volume")
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
        let loaded = LoadedVolume { volume: grid.clone().into(), info: None, transfer: None, notes: Vec::new() };
        let info = AmrInfo::new("two", &loaded, &grid);
        assert_eq!((info.histogram[0], info.histogram[COLUMNS - 1]), (0.5, 0.5));
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
