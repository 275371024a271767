//! The `[transfer]` of a scene file, alone in a file or among other sections.

use std::path::Path;

use serde::Deserialize;

use crate::error::{FieldError, FileError};
use crate::scene::{ShadingSection, TransferPoints, TransferSection};

use super::TransferFile;

/// The sections that matter here; others are about a scene.
#[derive(Deserialize)]
struct Sections {
    transfer: Option<TransferSection>,
    shading: Option<ShadingSection>,
}

/// Reads the points of a scene file.
pub(super) fn parse(text: &str, path: &Path) -> Result<TransferFile, FileError> {
    let wrong = |field: &str, found: String, allowed: &str| FieldError::new(field, found, allowed).in_file(path);
    let sections: Sections = toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(0, |span| text[..span.start.min(text.len())].matches('\n').count() + 1);
        wrong(&format!("line {line}"), e.message().to_owned(), "must be TOML with [transfer], as in a scene file")
    })?;
    let allowed = "must have [transfer] with rows, or with points = [{ value = 0.0, color = [0.0, 0.0, 0.0], opacity = 0.0 }, ...]";
    let transfer = sections.transfer.ok_or_else(|| wrong("transfer", "nothing".to_owned(), allowed))?;
    let found = TransferPoints::of_section(&transfer).map_err(|e| wrong(&e.field, e.found, e.allowed))?;
    let (points, rows) = match found {
        Some(TransferPoints::ByValue(points)) => (points, Vec::new()),
        Some(TransferPoints::ByGradient(rows)) if !rows.is_empty() => (Vec::new(), rows),
        Some(TransferPoints::ByGradient(_)) => {
            return Err(wrong("transfer.rows", "none".to_owned(), "must have at least one row"));
        }
        None => return Err(wrong("transfer.points", "nothing".to_owned(), allowed)),
    };
    Ok(TransferFile {
        rows,
        shading: sections.shading.filter(|section| section.enabled).map(|section| section.shading()),
        unit_distance: transfer.unit_distance,
        opacity_rule: Some(transfer.opacity_rule),
        ..TransferFile::of_points("scene file", points, true)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::srgb_to_linear;
    use vr_core::{ControlPoint, OpacityRule};

    const TEXT: &str = "[transfer]\nunit_distance = 2.5\nopacity_rule = \"extinction\"\ncolors = \"srgb\"\npoints = [\n\
                        { value = -1.0, color = [1.0, 0.5, 0.0], opacity = 0.25 },\n]\n[shading]\nambient = 0.5\n[camera]\nx = 3\n";

    #[test]
    fn sections_of_a_scene_are_taken() {
        let file = parse(TEXT, Path::new("a.toml")).unwrap();
        assert_eq!((file.unit_distance, file.opacity_rule), (Some(2.5), Some(OpacityRule::Extinction)));
        assert_eq!(file.points, [ControlPoint::new(-1.0, [1.0, srgb_to_linear(0.5), 0.0], 0.25)]);
        assert_eq!(file.shading.unwrap().ambient, 0.5);
    }

    #[test]
    fn names_what_is_wrong() {
        for (text, word) in [
            ("[shading]\n", "a.toml: transfer: found nothing; must have [transfer]"),
            ("[transfer]\npreset = \"grey\"\n", "transfer.points: found nothing"),
            ("[transfer]\npoints = 3\n", "line 2: found"),
            ("[transfer]\npoint = 3\n", "line 2: found"),
        ] {
            let message = parse(text, Path::new("a.toml")).unwrap_err().to_string();
            assert!(message.contains(word) && !message.contains('\n'), "{message}");
        }
    }
}
