//! 3D Slicer's volume properties as JSON (`.vp.json`), from version 5.9 on.

use serde::Deserialize;

use crate::error::FieldError;

use super::TransferFile;
use super::slicer::FORMAT;
use super::volume_property::VolumeProperty;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Document {
    volume_properties: Vec<Property>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Property {
    #[serde(default)]
    interpolation_type: String,
    components: Vec<Component>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Component {
    #[serde(default)]
    shade: bool,
    #[serde(default)]
    lighting: Lighting,
    #[serde(default)]
    disable_gradient_opacity: bool,
    scalar_opacity_unit_distance: Option<f64>,
    rgb_transfer_function: Function<ColorPoint>,
    scalar_opacity: Function<OpacityPoint>,
    #[serde(default)]
    gradient_opacity: Function<OpacityPoint>,
}

/// VTK's defaults.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Lighting {
    ambient: f64,
    diffuse: f64,
    specular: f64,
    specular_power: f64,
}

impl Default for Lighting {
    fn default() -> Self {
        Self { ambient: 0.1, diffuse: 0.7, specular: 0.2, specular_power: 10.0 }
    }
}

#[derive(Deserialize)]
struct Function<P> {
    points: Vec<P>,
}

impl<P> Default for Function<P> {
    fn default() -> Self {
        Self { points: Vec::new() }
    }
}

#[derive(Deserialize)]
struct ColorPoint {
    x: f64,
    color: [f64; 3],
}

#[derive(Deserialize)]
struct OpacityPoint {
    x: f64,
    y: f64,
    #[serde(default = "half")]
    midpoint: f64,
    #[serde(default)]
    sharpness: f64,
}

fn half() -> f64 {
    0.5
}

/// Reads volume properties; `None` where a text is other JSON.
pub(super) fn parse(text: &str) -> Option<Result<TransferFile, FieldError>> {
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    value.get("volumeProperties")?;
    Some(serde_json::from_value(value).map_err(|e| syntax(e.to_string())).and_then(file))
}

fn syntax(found: String) -> FieldError {
    FieldError::new("JSON", found, "must be a volume property of 3D Slicer, version 1")
}

fn file(document: Document) -> Result<TransferFile, FieldError> {
    let properties = document.volume_properties.len();
    let Some(property) = document.volume_properties.into_iter().next() else {
        return Err(FieldError::new("volumeProperties", "none", "must hold one at least"));
    };
    let components = property.components.len();
    let Some(component) = property.components.into_iter().next() else {
        return Err(FieldError::new("components", "none", "must hold one at least"));
    };
    let Lighting { ambient, diffuse, specular, specular_power } = component.lighting;
    let gradient = if component.disable_gradient_opacity { Vec::new() } else { component.gradient_opacity.points };
    let mut file = VolumeProperty {
        is_nearest: property.interpolation_type.eq_ignore_ascii_case("nearest"),
        shading: component.shade.then_some([ambient, diffuse, specular, specular_power]),
        opacity: component.scalar_opacity.points.iter().map(|p| [p.x, p.y, p.midpoint, p.sharpness]).collect(),
        gradient: gradient.iter().map(|p| [p.x, p.y]).collect(),
        color: component
            .rgb_transfer_function
            .points
            .iter()
            .map(|p| [p.x, p.color[0], p.color[1], p.color[2]])
            .collect(),
        unit_distance: component.scalar_opacity_unit_distance,
    }
    .into_file(FORMAT, ["scalarOpacity", "gradientOpacity", "rgbTransferFunction"])?;
    if properties > 1 || components > 1 {
        file.notes.push(format!("of {properties} volume properties and {components} components the first is used"));
    }
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"{"@schema": "volume-property-schema-v1.0.0.json#", "volumeProperties": [{"effectiveRange": [0, 9],
        "interpolationType": "linear", "components": [{"shade": true, "lighting": {"diffuse": 1.0, "ambient": 0.2, "specular": 0.0,
        "specularPower": 1.0}, "scalarOpacityUnitDistance": 2.5,
        "rgbTransferFunction": {"type": "colorTransferFunction", "points": [{"x": 0, "color": [0, 0, 0]}, {"x": 9, "color": [1, 1, 1]}]},
        "scalarOpacity": {"type": "piecewiseLinearFunction", "points": [{"x": 0, "y": 0}, {"x": 9, "y": 0.5, "midpoint": 0.5}]}}]}]}"#;

    #[test]
    fn reads_what_slicer_writes() {
        let file = parse(TEXT).unwrap().unwrap();
        assert_eq!(file.unit_distance, Some(2.5));
        assert_eq!(file.shading.as_ref().map(|s| (s.diffuse, s.ambient)), Some((1.0, 0.2)));
        let ends = (file.points[0], file.points[file.points.len() - 1]);
        assert_eq!((ends.0.value, ends.0.opacity, ends.1.value, ends.1.opacity), (0.0, 0.0, 9.0, 0.5));
        assert!(ends.1.color.iter().all(|c| (c - 1.0).abs() < 1e-12));
    }

    #[test]
    fn names_what_is_wrong() {
        let message = |text: &str| parse(text).unwrap().unwrap_err().to_string();
        assert!(message(r#"{"volumeProperties": []}"#).contains("volumeProperties: found none"));
        assert!(message(r#"{"volumeProperties": [{"components": []}]}"#).contains("components: found none"));
        assert!(message(r#"{"volumeProperties": 3}"#).contains("JSON: found"));
        assert!(message(&TEXT.replace("\"y\": 0.5", "\"y\": 7")).contains("scalarOpacity, point 2: found 7"));
        assert!(parse("[]").is_none() && parse("{").is_none());
    }
}
