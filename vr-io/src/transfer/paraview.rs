//! ParaView's colour maps: JSON files with colours, a colour space to interpolate them in, and opacities.

use std::path::Path;

use serde::Deserialize;
use vr_core::ControlPoint;

use crate::error::{FieldError, FileError, shown};
use crate::regular_file;

use super::color_space::ColorSpace;
use super::curves::{self, growing, merge};
use super::{opacity, stretched};

/// A colour map as control points: linear-light colours, with opacity.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorMap {
    /// Name in the file.
    pub name: String,
    /// Control points over the file's own range of values.
    pub points: Vec<ControlPoint>,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
}

impl ColorMap {
    /// The control points moved to another range of values, as ParaView does when it shows other data. A range of one value
    /// is widened, so that the value lies in the middle.
    pub fn over(&self, range: (f64, f64)) -> Vec<ControlPoint> {
        stretched(&self.points, range)
    }
}

/// A colour map as it stands in the file. Unknown keys are ParaView's business.
#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Entry {
    #[serde(default)]
    name: String,
    #[serde(default = "rgb")]
    color_space: String,
    #[serde(default, rename = "RGBPoints")]
    rgb_points: Vec<f64>,
    #[serde(default)]
    points: Vec<f64>,
}

fn rgb() -> String {
    "RGB".to_owned()
}

/// Reads every colour map of a file; at least one.
///
/// The colours in such files are sRGB-encoded, and are interpolated in the file's colour space; what lies between two points
/// is followed by as many straight pieces in linear light as keep the difference below what 8 bits show. Opacities between
/// points with a midpoint of 0.5 and no sharpness are linear, and exact.
///
/// # Errors
/// A [`FileError`] naming the file and the field.
pub fn read_color_maps(path: impl AsRef<Path>) -> Result<Vec<ColorMap>, FileError> {
    let path = path.as_ref();
    let text = regular_file::read_text(path, regular_file::MAX_TEXT).map_err(|e| FileError::new(path, e))?;
    parse_color_maps(&text, path)
}

/// Reads every colour map of a text; `path` is what errors call it. See [`read_color_maps`].
///
/// # Errors
/// A [`FileError`] naming the file and the field.
pub fn parse_color_maps(text: &str, path: &Path) -> Result<Vec<ColorMap>, FileError> {
    let syntax = |found: String| {
        let allowed = "must be ParaView's list of colour maps".to_owned();
        FieldError { field: "JSON".to_owned(), found, allowed }.in_file(path)
    };
    // The list may be one map alone.
    let value: serde_json::Value = serde_json::from_str(text).map_err(|e| syntax(e.to_string()))?;
    let values = match value {
        serde_json::Value::Array(list) => list,
        one => vec![one],
    };
    if values.is_empty() {
        return Err(syntax("an empty list".to_owned()));
    }
    values
        .into_iter()
        .map(|v| {
            let entry: Entry = serde_json::from_value(v).map_err(|e| syntax(e.to_string()))?;
            color_map(entry).map_err(|e| e.in_file(path))
        })
        .collect()
}

fn color_map(entry: Entry) -> Result<ColorMap, FieldError> {
    let mut notes = Vec::new();
    let space = ColorSpace::from_name(&entry.color_space, &mut notes)?;
    let (rows, rest) = entry.rgb_points.as_chunks::<4>();
    if rows.is_empty() || !rest.is_empty() {
        let found = format!("{} numbers", entry.rgb_points.len());
        let allowed = "must be groups of value, red, green, blue (no indexed colours)";
        return Err(FieldError::new("RGBPoints", found, allowed));
    }
    let colors = curves::colors(rows, space, |row, number| format!("RGBPoints[{}]", 4 * row + number))?;
    let opacity = if entry.points.is_empty() {
        growing(&colors, &mut notes)
    } else {
        let (rows, rest) = entry.points.as_chunks::<4>();
        if !rest.is_empty() {
            let found = format!("{} numbers", entry.points.len());
            return Err(FieldError::new("Points", found, "must be groups of value, opacity, midpoint, sharpness"));
        }
        opacity::opacities(rows, |row, number| format!("Points[{}]", 4 * row + number))?
    };
    Ok(ColorMap { name: shown(&entry.name), points: merge(&colors, &opacity), notes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::transfer::{cool_warm, linear_to_srgb};
    use vr_core::{OpacityRule, TransferFunction};

    fn one(text: &str) -> Result<ColorMap, FileError> {
        parse_color_maps(text, Path::new("map.json")).map(|mut maps| maps.remove(0))
    }

    #[test]
    fn diverging_is_the_cool_warm_map() {
        let map = one(r#"[{"ColorSpace": "Diverging", "Name": "Cool to Warm", "NanColor": [1, 1, 0], "Creator": "x",
                 "RGBPoints": [0, 0.2298057, 0.298717966, 0.753683153, 1, 0.705673158, 0.01555616, 0.150232812]}]"#)
        .unwrap();
        assert_eq!(map.name, "Cool to Warm");
        let tf = TransferFunction::new(map.points, OpacityRule::Power, 1.0).unwrap();
        for k in 0..=100 {
            let t = f64::from(k) / 100.0;
            let (found, expected) = (tf.at(t), cool_warm(t));
            for c in 0..3 {
                let error = linear_to_srgb(found.color[c]) - linear_to_srgb(expected[c]);
                assert!(error.abs() < 1.5 / 255.0, "{t} {found:?} {expected:?}");
            }
            // No opacities in the file: a ramp, and that is said.
            assert!((found.opacity - t).abs() < 1e-12);
        }
        assert!(map.notes[0].contains("no opacities"));
    }

    #[test]
    fn rgb_is_interpolated_before_the_srgb_curve() {
        let map =
            one(r#"{"RGBPoints": [-1, 0, 0, 0, 1, 1, 1, 1], "Points": [-1, 0, 0.5, 0, 1, 0.8, 0.5, 0]}"#).unwrap();
        let tf = TransferFunction::new(map.points, OpacityRule::Power, 1.0).unwrap();
        assert!((linear_to_srgb(tf.at(0.0).color[1]) - 0.5).abs() < 1.0 / 255.0);
        assert!((tf.at(0.5).opacity - 0.6).abs() < 1e-12);
    }

    #[test]
    fn steps_have_the_colour_of_their_upper_end() {
        let map = one(r#"{"ColorSpace": "Step", "RGBPoints": [0,1,0,0, 1,0,1,0, 2,0,0,1]}"#).unwrap();
        let tf = TransferFunction::new(map.points, OpacityRule::Power, 1.0).unwrap();
        assert_eq!(tf.at(0.5).color, [0.0, 1.0, 0.0]);
        assert_eq!(tf.at(1.5).color, [0.0, 0.0, 1.0]);
        assert_eq!(tf.at(-1.0).color, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn moves_to_other_ranges() {
        let map = one(r#"{"RGBPoints": [0,1,0,0, 10,1,0,0], "Points": [0,0,0.5,0, 5,1,0.5,0, 10,0,0.5,0]}"#).unwrap();
        let values: Vec<f64> = map.over((100.0, 300.0)).iter().map(|p| p.value).collect();
        assert_eq!(values, [100.0, 200.0, 300.0]);
        assert!(TransferFunction::new(map.over((7.0, 7.0)), OpacityRule::Power, 1.0).is_ok());
    }

    #[test]
    fn names_what_is_wrong() {
        for (text, word) in [
            ("{", "map.json: JSON: found EOF"),
            ("[]", "an empty list"),
            ("[7]", "must be ParaView's list"),
            (r#"{"IndexedColors": [1,0,0]}"#, "RGBPoints: found 0 numbers"),
            (r#"{"RGBPoints": [0,1,0]}"#, "RGBPoints: found 3 numbers"),
            (r#"{"RGBPoints": [1,0,0,0, 0,1,1,1]}"#, "RGBPoints[4]: found 0; values must be finite and in ascending"),
            (r#"{"RGBPoints": [1,0,7,0]}"#, "RGBPoints[2]: found 7; colours"),
            (r#"{"RGBPoints": [1,0,0,0], "ColorSpace": "XYZ"}"#, "ColorSpace: found XYZ; must be RGB"),
            (r#"{"RGBPoints": [1,0,0,0], "Points": [0,2,0.5,0]}"#, "Points[1]: found 2; opacities must be in [0, 1]"),
            (r#"{"RGBPoints": [1,0,0,0], "Points": [0,1,2]}"#, "Points: found 3 numbers"),
        ] {
            let message = one(text).unwrap_err().to_string();
            assert!(message.contains(word) && !message.contains('\n'), "{message}");
        }
    }
}
