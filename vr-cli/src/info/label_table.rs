//! Labels of a volume, listed.

use std::path::Path;

use serde::Serialize;
use vr_core::Volume;
use vr_core::labels::LabelCounts;
use vr_io::{FileInfo, LabelEntry, LoadedLabels};
use vr_look::Kind;

use crate::args::InfoArgs;
use crate::failure::Failure;
use crate::number;

/// Labels of a volume, with the number of their voxels.
#[derive(Serialize)]
pub struct LabelTable {
    /// Name of the cubed unit.
    #[serde(skip)]
    unit: String,
    /// One row for each label that a voxel has or a file names, ascending.
    rows: Vec<Row>,
}

#[derive(Serialize)]
struct Row {
    label: i32,
    name: Option<String>,
    /// Linear RGB.
    color: Option<[f64; 3]>,
    voxels: usize,
    /// World volume.
    volume: f64,
}

impl LabelTable {
    /// Lists the labels of a volume that holds some: by the kind of its values, by its file, or because a list of names comes with it. `None`
    /// for any other.
    ///
    /// # Errors
    /// A list of names that cannot be read; values that are no labels beside one.
    pub fn of(args: &InfoArgs, volume: &Volume, info: Option<&FileInfo>, kind: &Kind) -> Result<Option<Self>, Failure> {
        let names = args.label_names.as_deref();
        let is_labels = matches!(kind, Kind::Labels(_));
        // Segments have names in the header of their file, and may lie in layers that the volume does not show.
        let has_segments = |path: &&Path| info.is_some() && vr_io::has_segments(path);
        let segmented = args.volume.path.as_deref().filter(has_segments);
        // A volume of values: no list is asked for, and counting takes long.
        if !is_labels && names.is_none() && segmented.is_none() {
            return Ok(None);
        }
        let found = match segmented {
            Some(path) => vr_io::read_labels(path, names)
                .map(|LoadedLabels { map, entries, .. }| (map.counts().clone(), entries))
                .map_err(Failure::failed),
            None => {
                let grid = volume.grid().ok_or_else(|| Failure::failed("only grids have labels"))?;
                let entries = names.map(vr_io::read_label_list).transpose().map_err(Failure::failed)?;
                LabelCounts::new(grid.values())
                    .map(|counts| (counts, entries.unwrap_or_default()))
                    .map_err(Failure::failed)
            }
        };
        let (counts, entries) = match found {
            Ok(found) => found,
            Err(e) if names.is_some() => return Err(e),
            // The survey saw whole numbers, and others lie between.
            Err(_) => return Ok(None),
        };
        let is_labels = is_labels || !entries.is_empty();
        let unit = match info.and_then(|info| info.units.as_deref()) {
            Some(unit) => format!("{unit}³"),
            None => "volume".to_owned(),
        };
        Ok(is_labels.then(|| Self { unit, rows: rows(&counts, &entries) }))
    }

    /// Returns the rows as text.
    pub fn text(&self) -> String {
        let mut text = format!("\n{:>11} {:>12} {:>14}  name\n", "label", "voxels", self.unit);
        for Row { label, name, voxels, volume, .. } in &self.rows {
            let name = name.as_deref().unwrap_or(if *label == 0 { "background" } else { "" });
            let line =
                format!("{label:>11} {:>12} {:>14}  {name}", number::count(*voxels as u64), number::value(*volume));
            text += line.trim_end();
            text.push('\n');
        }
        text
    }
}

fn rows(counts: &LabelCounts, entries: &[LabelEntry]) -> Vec<Row> {
    let mut labels: Vec<i32> = counts.labels().iter().copied().chain(entries.iter().map(|e| e.label)).collect();
    labels.sort_unstable();
    labels.dedup();
    let row = |label: i32| {
        let entry = entries.iter().find(|e| e.label == label);
        let voxels = counts.count(label);
        Row {
            label,
            name: entry.and_then(|e| e.name.clone()),
            color: entry.and_then(|e| e.color),
            voxels,
            volume: voxels as f64 * counts.voxel_volume(),
        }
    };
    // A list of an atlas names hundreds that are not there.
    labels.into_iter().map(row).filter(|row| row.voxels > 0 || entries.len() <= MAX_ABSENT).collect()
}

/// Largest list of names of which those without a voxel are listed, too.
const MAX_ABSENT: usize = 32;
