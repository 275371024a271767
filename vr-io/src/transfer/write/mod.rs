//! Transfer functions out, in the format that the file's name asks for.

mod lut;
mod paraview;
mod slicer;
mod table;

use std::path::Path;

use vr_core::transfer::linear_to_srgb;
use vr_core::{Light, OpacityRule, Shading, TransferFunction};

use crate::atomic::write_bytes;
use crate::error::WriteError;
use crate::scene::{SceneFile, ShadingSection, TransferSection};
use crate::toml_table::table_of;

use super::polyline::resample;

/// The extensions of files that [`write_transfer`] writes.
pub const TRANSFER_EXTENSIONS: [&str; 6] = ["json", "vp", "csv", "tsv", "toml", "lut"];

/// A transfer function to be written, and what belongs to it.
#[derive(Clone, Copy, Debug)]
pub struct TransferSource<'a> {
    /// Name for formats that hold one.
    pub name: &'a str,
    /// The transfer function.
    pub transfer: &'a TransferFunction,
    /// Shading for formats that hold it.
    pub shading: Option<&'a Shading>,
    /// Factor on the extinction at differences from one voxel to the next, as in [`super::TransferFile`]; 3D Slicer's files hold it.
    pub gradient_per_voxel: &'a [(f64, f64)],
}

/// Writes a transfer function as what the name says: `.json` (ParaView), `.vp` (3D Slicer), `.csv` and `.tsv` (value, red, green, blue, opacity),
/// `.toml` (the `[transfer]` and `[shading]` of a scene file, every digit of it) or `.lut` (ImageJ: 256 colours).
///
/// All but TOML hold the colours of the screen, and straight lines between points there: points are added until 8 bits do not show the
/// difference. Returns notes on what the format does not hold, one line each.
///
/// # Errors
/// A [`WriteError`] naming the file: another extension, or rows by gradient or emission of its own, which only TOML holds; no part of it is left behind then.
pub fn write_transfer(path: impl AsRef<Path>, source: &TransferSource<'_>) -> Result<Vec<String>, WriteError> {
    let path = path.as_ref();
    let encode = |message: String| WriteError::Encode { path: path.into(), message };
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if source.transfer.has_emission() && extension != "toml" {
        let message = "emission of its own is held by .toml alone; the other formats have colour and opacity";
        return Err(encode(message.to_owned()));
    }
    if source.transfer.has_rows() && extension != "toml" {
        let message = "rows by gradient are held by .toml alone; the other formats know values, and no gradients";
        return Err(encode(message.to_owned()));
    }
    let mut notes = Vec::new();
    let bytes = match extension.as_str() {
        "json" => paraview::text(source),
        "vp" => slicer::text(source, &mut notes),
        "csv" => table::text(source, ','),
        "tsv" => table::text(source, '\t'),
        "lut" => {
            notes.push("a colour table holds 256 colours, and neither values nor opacities".to_owned());
            write_bytes(path, &lut::bytes(source.transfer))?;
            return Ok(notes);
        }
        "toml" => toml(source).map_err(|e| encode(e.to_string()))?,
        other => {
            let found = if other.is_empty() { "nothing" } else { other };
            return Err(encode(format!("extension: found {found}; must be {}", TRANSFER_EXTENSIONS.join(", "))));
        }
    };
    if extension != "toml" {
        let unit = source.transfer.unit_distance();
        notes.push(format!("opacities belong to a length of {unit}, which the format does not hold"));
        if source.shading.is_some() && extension != "vp" {
            notes.push("shading is left out: .vp and .toml hold it".to_owned());
        }
    }
    if !source.gradient_per_voxel.is_empty() && extension != "vp" {
        notes.push("gradient opacity is left out: .vp alone holds it by voxels".to_owned());
    }
    write_bytes(path, bytes.as_bytes())?;
    Ok(notes)
}

/// The sections of a scene file.
fn toml(source: &TransferSource<'_>) -> Result<String, crate::scene::SceneFileError> {
    let file = SceneFile {
        transfer: Some(TransferSection::describe(source.transfer)),
        shading: source.shading.map(|shading| ShadingSection::describe(shading, &[Light::default()])),
        ..SceneFile::default()
    };
    let sections: toml::Table =
        table_of(&file)?.into_iter().filter(|(key, _)| key == "transfer" || key == "shading").collect();
    toml::to_string(&sections).map_err(|e| crate::scene::SceneFileError::Text { message: e.to_string() })
}

/// A point as programs of VTK's family have it: value, sRGB colour, opacity of a unit distance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DisplayPoint {
    value: f64,
    color: [f64; 3],
    opacity: f64,
}

/// Points between which straight lines of sRGB and of opacity follow a transfer function. No two share a value: a jump is a step of a
/// millionth of the range, for VTK keeps one point at a value.
fn display_points(transfer: &TransferFunction) -> Vec<DisplayPoint> {
    let points = transfer.points();
    // Opacity of a unit distance, whatever the rule.
    let opacity = |alpha: f64| match transfer.rule() {
        OpacityRule::Power => alpha,
        OpacityRule::Extinction => -libm::expm1(-alpha),
    };
    // Colours beyond white are white on a screen.
    let at = |color: [f64; 3], alpha: f64| {
        let [r, g, b] = color.map(|c| linear_to_srgb(c.clamp(0.0, 1.0)));
        [r, g, b, opacity(alpha)]
    };
    let differ = |a: [f64; 4], b: [f64; 4]| (0..4).any(|k| (a[k] - b[k]).abs() > 0.5 / 255.0);
    let mut line = vec![(points[0].value, at(points[0].color, points[0].opacity))];
    for pair in points.windows(2) {
        let (a, b) = (&pair[0], &pair[1]);
        if a.value == b.value {
            line.push((b.value, at(b.color, b.opacity)));
            continue;
        }
        let mix = |t: f64| {
            let mixed = |a: f64, b: f64| a + t * (b - a);
            let color = std::array::from_fn(|c| mixed(a.color[c], b.color[c]));
            at(color, mixed(a.opacity, b.opacity))
        };
        resample(a.value, b.value, mix, differ, &mut line);
    }
    let step = 1e-6 * (points[points.len() - 1].value - points[0].value).max(1e-6 * points[0].value.abs());
    let mut shown: Vec<DisplayPoint> = Vec::with_capacity(line.len());
    for (value, [r, g, b, opacity]) in line {
        let value = shown.last().map_or(value, |last| if value > last.value { value } else { last.value + step });
        shown.push(DisplayPoint { value, color: [r, g, b].map(readable), opacity: readable(opacity) });
    }
    shown
}

/// A number of 0 to 1 with as many digits as anybody needs.
fn readable(x: f64) -> f64 {
    (x.clamp(0.0, 1.0) * 1e6).round() / 1e6
}

/// Colour on the screen at a value.
fn display_color(transfer: &TransferFunction, value: f64) -> [f64; 3] {
    transfer.at(value).color.map(|c| linear_to_srgb(c.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{TransferFile, read_transfer};
    use vr_core::ControlPoint;
    use vr_core::transfer::Preset;

    fn round_trip(source: &TransferSource<'_>, name: &str) -> (TransferFile, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let notes = write_transfer(&path, source).unwrap();
        (read_transfer(&path).unwrap(), notes)
    }

    /// Largest difference of what is on the screen, at 1000 values.
    fn difference(a: &TransferFunction, b: &TransferFunction) -> [f64; 2] {
        let (low, high) = (a.points()[0].value, a.points()[a.points().len() - 1].value);
        let mut worst = [0.0f64; 2];
        for k in 0..=1000 {
            // Beside jumps, which may be moved by a millionth.
            let value = low + (high - low) * (f64::from(k) + 0.013) / 1000.026;
            let (x, y) = (display_color(a, value), display_color(b, value));
            worst[0] = (0..3).map(|c| (x[c] - y[c]).abs()).fold(worst[0], f64::max);
            worst[1] = worst[1].max((a.at(value).opacity - b.at(value).opacity).abs());
        }
        worst
    }

    #[test]
    fn every_preset_survives_every_format() {
        for preset in Preset::ALL {
            let points = preset.points((-1024.0, 3071.0));
            let transfer = TransferFunction::new(points, OpacityRule::Power, 0.7).unwrap();
            let shading = preset.shading();
            let source = TransferSource {
                name: preset.name(),
                transfer: &transfer,
                shading: shading.as_ref(),
                gradient_per_voxel: &[],
            };
            for name in ["a.json", "a.vp", "a.csv", "a.tsv", "a.toml"] {
                let (file, notes) = round_trip(&source, name);
                // Writing and reading each stay within what 8 bits show: half a step, and one step.
                let back = TransferFunction::new(file.points.clone(), OpacityRule::Power, 0.7).unwrap();
                let [color, opacity] = difference(&transfer, &back);
                assert!(color < 1.6 / 255.0 && opacity < 0.6 / 255.0, "{preset} {name}: {color} {opacity}");
                let holds_shading = matches!(name, "a.vp" | "a.toml");
                assert_eq!(file.shading, shading.clone().filter(|_| holds_shading), "{preset} {name}");
                assert_eq!(notes.is_empty(), name == "a.toml");
            }
            assert_eq!(round_trip(&source, "a.toml").0.points, transfer.points(), "every digit");
        }
    }

    #[test]
    fn jumps_stay_and_extinction_becomes_opacity() {
        let points = vec![
            ControlPoint::new(0.0, [0.0; 3], 0.0),
            ControlPoint::new(5.0, [1.0; 3], 0.5),
            ControlPoint::new(5.0, [0.2; 3], 0.9),
            ControlPoint::new(10.0, [0.2; 3], 1.0),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
        let shown = display_points(&transfer);
        assert!(shown.windows(2).all(|w| w[0].value < w[1].value));
        let source = TransferSource { name: "x", transfer: &transfer, shading: None, gradient_per_voxel: &[] };
        let back = round_trip(&source, "a.vp").0;
        let back = TransferFunction::new(back.points, OpacityRule::Power, 1.0).unwrap();
        for value in [2.5, 4.9, 5.1, 9.0] {
            let (a, b) = (transfer.step(value, 1.0), back.step(value, 1.0));
            assert!((a[3] - b[3]).abs() < 1.0 / 255.0, "{value}: {a:?} {b:?}");
        }
    }

    #[test]
    fn color_tables_hold_256_colours() {
        let transfer = TransferFunction::new(Preset::Viridis.points((0.0, 9.0)), OpacityRule::Power, 1.0).unwrap();
        let (file, _) = round_trip(
            &TransferSource { name: "v", transfer: &transfer, shading: None, gradient_per_voxel: &[] },
            "v.lut",
        );
        let back = TransferFunction::new(file.over((0.0, 9.0)), OpacityRule::Power, 1.0).unwrap();
        assert!(difference(&transfer, &back)[0] < 1.6 / 255.0);
        assert!(file.notes.iter().any(|note| note.contains("no opacities")));
    }

    #[test]
    fn what_no_format_holds_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let flame = ControlPoint { emission: Some([1.0; 3]), ..ControlPoint::new(0.0, [0.0; 3], 0.0) };
        let transfer = TransferFunction::new(vec![flame], OpacityRule::Power, 1.0).unwrap();
        let source = TransferSource { name: "x", transfer: &transfer, shading: None, gradient_per_voxel: &[] };
        let message = |name: &str| write_transfer(folder.path().join(name), &source).unwrap_err().to_string();
        assert!(message("a.json").contains("emission"));
        assert!(write_transfer(folder.path().join("a.toml"), &source).unwrap().is_empty());
        let plain =
            TransferFunction::new(vec![ControlPoint::new(0.0, [0.0; 3], 0.5)], OpacityRule::Power, 1.0).unwrap();
        let source = TransferSource { transfer: &plain, ..source };
        let message = write_transfer(folder.path().join("a.doc"), &source).unwrap_err().to_string();
        assert!(message.contains("extension: found doc; must be json"), "{message}");
        // One point alone is a transfer function, too.
        for name in ["b.json", "b.vp", "b.csv", "b.lut"] {
            write_transfer(folder.path().join(name), &source).unwrap();
            read_transfer(folder.path().join(name)).unwrap();
        }
    }
}
