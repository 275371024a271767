//! `[labels]`: labels beside the volume, and how each is drawn.

use serde::{Deserialize, Serialize};

use super::file_name::FileName;

/// `[labels]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelsSection {
    /// A file of labels, relative to the scene file ([`crate::read_labels`]).
    pub file: FileName,
    /// A list of their names and colours, relative to the scene file ([`crate::read_label_list`]).
    pub names: Option<FileName>,
    /// True for a mask: what has a label is drawn as the volume, and nothing else is.
    #[serde(default)]
    pub mask: bool,
    /// The way in which labels are drawn that no entry speaks of; solid if absent.
    #[serde(rename = "as")]
    pub look: Option<LabelLook>,
    /// Choices about single labels, the later of two about one coming first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub label: Vec<LabelSection>,
}

/// `[[labels.label]]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LabelSection {
    /// The label, or its name; 0 is the background.
    pub label: LabelName,
    /// Linear RGB; that of the file, or one of many that differ, if absent.
    pub color: Option<[f64; 3]>,
    /// Opacity of a solid in one unit distance, or factor on the volume's opacities; that of the file, or 1, if absent.
    pub opacity: Option<f64>,
    /// False for vacuum.
    pub visible: Option<bool>,
    /// The way in which it is drawn.
    #[serde(rename = "as")]
    pub look: Option<LabelLook>,
}

/// A label by its number or its name.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum LabelName {
    /// Its number.
    Number(i32),
    /// Its name, as the file or the list has it; case does not matter.
    Name(String),
}

impl Default for LabelName {
    fn default() -> Self {
        Self::Number(0)
    }
}

/// The way in which a label is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LabelLook {
    /// One colour and one opacity: a lit surface at its boundary.
    Solid,
    /// The volume's opacities in the label's colour.
    Tinted,
    /// The volume as it is.
    Volume,
}
