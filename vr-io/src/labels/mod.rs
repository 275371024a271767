//! Labels beside a volume: masks and segmentations of any format that is read, with names and colours from the file itself or from a list.

mod entry;
mod list;
mod segments;

use std::path::{Path, PathBuf};

use vr_core::Volume;
use vr_core::labels::LabelMap;

use crate::error::{FieldError, FileError};
use crate::notes::as_lines;
use crate::read::{FileInfo, Loaded, ReadOptions, each_once, read};

pub use entry::LabelEntry;
pub use list::{parse_label_list, read_label_list};

use segments::Segments;

/// Labels from a file.
#[derive(Clone, Debug)]
pub struct LoadedLabels {
    /// The labels, in the world of [`read()`].
    pub map: LabelMap,
    /// Every label that the file or the list names, ascending; some may have no voxel.
    pub entries: Vec<LabelEntry>,
    /// Everything that the file says about itself.
    pub info: FileInfo,
    /// Every file that was read, once each.
    pub files: Vec<PathBuf>,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
}

/// True if the header of a file lists segments, which have names and may lie in layers: [`read_labels`] tells more of them than [`read()`] does.
pub fn has_segments(path: impl AsRef<Path>) -> bool {
    Segments::of_file(path.as_ref()).is_ok_and(|segments| segments.is_some())
}

/// Reads labels: a volume of whole numbers in any format of [`read()`], and 3D Slicer's segmentations (`.seg.nrrd`) with the segments' names
/// and colours. `list` is a file of names and colours ([`read_label_list`]), which comes before the file's own.
///
/// Layers of a segmentation may overlap: a later layer covers an earlier one; labels that two layers share are numbered anew.
///
/// # Errors
/// A [`FileError`] that names the file, the field, what was found and what is allowed; among them a value that is no whole number.
pub fn read_labels(path: impl AsRef<Path>, list: Option<&Path>) -> Result<LoadedLabels, FileError> {
    let path = path.as_ref();
    let segments = Segments::of_file(path)?;
    let layers = segments.as_ref().map_or(1, Segments::layers);
    let first = (layers > 1).then_some(0);
    let loaded = read(path, &ReadOptions { component: first, ..ReadOptions::default() })?;
    let Loaded { info, mut notes, .. } = loaded;
    if layers > 1 && info.components != layers {
        let found = format!("{layers} layers of segments and {} of voxels", info.components);
        return Err(FieldError::new("Segment_Layer", found, "must be as many of both").in_file(path));
    }
    let (mut map, mut entries) = (label_map(path, &loaded.volume)?, Vec::new());
    if let Some(segments) = segments {
        for layer in 1..layers {
            let next = read(path, &ReadOptions { component: Some(layer), ..ReadOptions::default() })?;
            let next = label_map(path, &next.volume)?;
            map = segments.overlaid(map, &next, layer).map_err(|e| FileError::new(path, e))?;
        }
        if layers > 1 {
            notes.push(format!("{layers} layers of segments, which may overlap: a later one covers an earlier one"));
        }
        entries = segments.into_entries(&mut notes);
    }
    let mut files = info.files.clone();
    if let Some(list) = list {
        let named = read_label_list(list)?;
        entries.retain(|e| named.iter().all(|n| n.label != e.label));
        entries.extend(named);
        files.push(list.to_path_buf());
    }
    entries.sort_by_key(|e| e.label);
    Ok(LoadedLabels { map, entries, info, files: each_once(files), notes: as_lines(notes) })
}

fn label_map(path: &Path, volume: &Volume) -> Result<LabelMap, FileError> {
    let grid = volume
        .grid()
        .ok_or_else(|| FieldError::new("labels", volume.kind(), "must be voxels: a grid").in_file(path))?;
    LabelMap::new(grid.values()).map_err(|e| FileError::new(path, e))
}
