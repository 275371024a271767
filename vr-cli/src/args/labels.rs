//! Flags of the labels beside a volume.

use std::path::PathBuf;

use clap::Args;
use vr_io::{LabelLook, LabelName, LabelSection};

use super::value;

/// `[labels]`.
#[derive(Debug, Args)]
#[command(next_help_heading = "Labels")]
pub struct LabelArgs {
    /// Labels beside the volume: a mask or segmentation of any format that is read (.seg.nrrd, NIfTI, ...), each label a lit solid in a colour of
    /// its own
    #[arg(long, value_name = "FILE", conflicts_with = "mask")]
    pub labels: Option<PathBuf>,
    /// Show the volume only where the labels of this file are not 0
    #[arg(long, value_name = "FILE")]
    pub mask: Option<PathBuf>,
    /// Names and colours of the labels: a list of ITK-SNAP, FreeSurfer or Slicer
    #[arg(long, value_name = "FILE")]
    pub label_names: Option<PathBuf>,
    /// Style of the labels: solid, tinted (the volume in the label's colour) or volume
    #[arg(long, value_name = "LOOK", value_parser = value::word::<LabelLook>)]
    pub labels_as: Option<LabelLook>,
    /// Style of one label, by its number (0 is the background) or name, as in liver:color=0.6,0.1,0.05:opacity=0.5:visible=yes:as=solid; may
    /// be repeated
    #[arg(long, value_name = "LABEL:KEY=VALUE:...", value_parser = label)]
    pub label: Vec<LabelSection>,
}

/// Parses a choice about a label: `3:color=1,0,0:opacity=0.5`.
fn label(text: &str) -> Result<LabelSection, String> {
    const EXPECTED: &str =
        "expected a label and what to do with it, as in 3:color=1,0,0:opacity=0.5:visible=yes:as=solid";
    let mut parts = text.split(':');
    let name = parts.next().map(str::trim).filter(|name| !name.is_empty() && !name.contains('=')).ok_or(EXPECTED)?;
    let mut section = LabelSection { label: LabelName::Name(name.to_owned()), ..LabelSection::default() };
    let mut any = false;
    for part in parts {
        let (key, word) = part.split_once('=').ok_or_else(|| format!("'{part}': {EXPECTED}"))?;
        let wrong = |why: String| format!("{key}: {why}");
        match key.trim() {
            "color" | "colour" => section.color = Some(value::triple(word).map_err(wrong)?),
            "opacity" => {
                let opacity = word.trim().parse().map_err(|_| wrong("expected a number from 0 to 1".to_owned()))?;
                section.opacity = Some(opacity);
            }
            "visible" => {
                section.visible = Some(match word.trim() {
                    "yes" | "true" => true,
                    "no" | "false" => false,
                    _ => return Err(wrong("expected yes or no".to_owned())),
                });
            }
            "as" => section.look = Some(value::word(word.trim()).map_err(wrong)?),
            _ => return Err(format!("unknown key '{key}'; must be color, opacity, visible or as")),
        }
        any = true;
    }
    if any { Ok(section) } else { Err(EXPECTED.to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_about_a_label_is_read() {
        let choice = label("left lung:colour=1,0.5,0:opacity=0.25:visible=no:as=tinted").unwrap();
        let wanted = LabelSection {
            label: LabelName::Name("left lung".to_owned()),
            color: Some([1.0, 0.5, 0.0]),
            opacity: Some(0.25),
            visible: Some(false),
            look: Some(LabelLook::Tinted),
        };
        assert_eq!(choice, wanted);
        for wrong in
            ["", "3", "color=1,0,0", "3:color=1,0", "3:visible=maybe", "3:as=mesh", "3:colr=1,0,0", "3:opacity"]
        {
            assert!(label(wrong).is_err(), "{wrong}");
        }
    }
}
