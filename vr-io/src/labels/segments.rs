//! Segments of a 3D Slicer segmentation: names, colours, labels and layers, as its NRRD header has them.
//!
//! The keys are `Segment0_Name`, `Segment0_Color` (sRGB from 0 to 1), `Segment0_LabelValue` and `Segment0_Layer`, and so on; the extents say nothing
//! that the voxels do not, and the reference's offset is in the origin already
//! (<https://slicer.readthedocs.io/en/latest/developer_guide/modules/segmentations.html>).

use std::collections::BTreeMap;
use std::path::Path;

use vr_core::labels::{LabelError, LabelMap};
use vr_core::transfer::srgb_to_linear;

use super::entry::LabelEntry;
use crate::error::{FieldError, FileError};
use crate::nrrd::segment_keys;

/// Largest number of segments: more than any atlas has.
const MAX_SEGMENTS: usize = 1 << 16;

/// Segments of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Segments {
    all: Vec<Segment>,
    /// True if two layers have a label in common, so that all are numbered anew.
    renumbered: bool,
}

#[derive(Clone, Debug, PartialEq)]
struct Segment {
    name: Option<String>,
    color: Option<[f64; 3]>,
    /// Label in its layer.
    value: i32,
    layer: usize,
}

impl Segments {
    /// The segments that the header of a file lists; `None` where it is no NRRD file, or lists none.
    pub(super) fn of_file(path: &Path) -> Result<Option<Self>, FileError> {
        match segment_keys(path)? {
            Some(keys) => Self::of_keys(&keys).map_err(|e| e.in_file(path)),
            None => Ok(None),
        }
    }

    fn of_keys(keys: &BTreeMap<String, String>) -> Result<Option<Self>, FieldError> {
        // Files of before 2020 have a mask in a layer of its own for each segment.
        let old = !keys.keys().any(|key| key.ends_with("_LabelValue") || key.ends_with("_Layer"));
        let mut all = Vec::new();
        for i in 0..MAX_SEGMENTS {
            let key = |what: &str| format!("Segment{i}_{what}");
            let text = |what: &str| keys.get(&key(what)).map(String::as_str);
            if ["ID", "Name", "LabelValue"].iter().all(|what| text(what).is_none()) {
                break;
            }
            let number = |what: &str, default: i64, allowed: &str| match text(what) {
                None => Ok(default),
                Some(word) => word.parse().map_err(|_| FieldError::new(key(what), word, allowed)),
            };
            let value = number("LabelValue", 1, "must be a whole number")?;
            let value = i32::try_from(value)
                .map_err(|_| FieldError::new(key("LabelValue"), value, "must be below 2147483648"))?;
            let layer = number("Layer", if old { i as i64 } else { 0 }, "must be the number of a layer, from 0")?;
            let layer = usize::try_from(layer).ok().filter(|&n| n < MAX_SEGMENTS);
            let layer = layer.ok_or_else(|| {
                FieldError::new(key("Layer"), text("Layer").unwrap_or_default(), "must be from 0 to 65535")
            })?;
            let color = match text("Color") {
                None => None,
                Some(words) => Some(
                    color(words)
                        .ok_or_else(|| FieldError::new(key("Color"), words, "must be three numbers from 0 to 1"))?,
                ),
            };
            all.push(Segment { name: text("Name").map(str::to_owned), color, value, layer });
        }
        if all.is_empty() {
            return Ok(None);
        }
        let shared = |(i, a): (usize, &Segment)| all[..i].iter().any(|b| a.value == b.value && a.layer != b.layer);
        let renumbered = all.iter().enumerate().any(shared);
        Ok(Some(Self { all, renumbered }))
    }

    /// Number of layers.
    pub(super) fn layers(&self) -> usize {
        self.all.iter().map(|s| s.layer + 1).max().unwrap_or(1)
    }

    /// Label of a layer's value in the whole: 0 for what is no segment.
    fn label(&self, layer: usize, value: i32) -> i32 {
        let place = self.all.iter().position(|s| s.layer == layer && s.value == value);
        match place {
            Some(i) if self.renumbered => i as i32 + 1,
            Some(_) => value,
            None => 0,
        }
    }

    /// Lays a layer over those before it, which `map` holds.
    pub(super) fn overlaid(&self, map: LabelMap, layer: &LabelMap, number: usize) -> Result<LabelMap, LabelError> {
        // The first layer has its own numbers still.
        let below = |value: i32| if number == 1 { self.label(0, value) } else { value };
        map.combined(layer, |below_value, above| match self.label(number, above) {
            0 => below(below_value),
            label => label,
        })
    }

    /// Name and colour of each.
    pub(super) fn into_entries(self, notes: &mut Vec<String>) -> Vec<LabelEntry> {
        if self.renumbered {
            notes.push(
                "layers of segments share labels: the segments are numbered 1, 2, … in the order of the file"
                    .to_owned(),
            );
        }
        let label = |i: usize, s: &Segment| if self.renumbered { i as i32 + 1 } else { s.value };
        let entry = |(i, s): (usize, &Segment)| LabelEntry {
            label: label(i, s),
            name: s.name.clone(),
            color: s.color,
            opacity: None,
            visible: None,
        };
        self.all.iter().enumerate().map(entry).collect()
    }
}

/// A colour in sRGB, from 0 to 1.
fn color(words: &str) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = words.split_whitespace().map(|w| w.parse().ok()).collect();
    let color: [f64; 3] = numbers?.try_into().ok()?;
    color.iter().all(|c| (0.0..=1.0).contains(c)).then(|| color.map(srgb_to_linear))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(all: &[(&str, &str)]) -> BTreeMap<String, String> {
        all.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect()
    }

    #[test]
    fn segments_have_names_colours_and_layers() {
        let found = keys(&[
            ("Segment0_ID", "Segment_1"),
            ("Segment0_Name", "left lung"),
            ("Segment0_Color", "1 0 0.5"),
            ("Segment0_LabelValue", "3"),
            ("Segment1_ID", "Segment_2"),
            ("Segment1_LabelValue", "3"),
            ("Segment1_Layer", "1"),
            ("Segmentation_ContainedRepresentationNames", "Binary labelmap|"),
        ]);
        let segments = Segments::of_keys(&found).unwrap().unwrap();
        assert_eq!((segments.layers(), segments.renumbered), (2, true));
        assert_eq!([segments.label(0, 3), segments.label(1, 3), segments.label(1, 2)], [1, 2, 0]);
        let mut notes = Vec::new();
        let entries = segments.into_entries(&mut notes);
        assert_eq!((entries[0].label, entries[0].name.as_deref(), notes.len()), (1, Some("left lung"), 1));
        assert_eq!(entries[0].color.unwrap()[..2], [1.0, 0.0]);
        assert_eq!(Segments::of_keys(&keys(&[("vr slope", "1")])).unwrap(), None);
    }

    #[test]
    fn wrong_keys_are_named() {
        let refused = |key: &str, value: &str| {
            Segments::of_keys(&keys(&[("Segment0_ID", "a"), (key, value)])).unwrap_err().to_string()
        };
        assert!(refused("Segment0_Color", "1 0").starts_with("Segment0_Color: found 1 0; must be three numbers"));
        assert!(refused("Segment0_LabelValue", "x").contains("must be a whole number"));
        assert!(refused("Segment0_Layer", "-1").contains("from 0 to 65535"));
    }
}
