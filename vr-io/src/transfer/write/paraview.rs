//! ParaView's colour maps as JSON.

use serde::Serialize;

use super::{TransferSource, display_points};

/// A colour map with the keys that ParaView exports.
#[derive(Serialize)]
#[serde(rename_all = "PascalCase")]
struct Entry<'a> {
    color_space: &'static str,
    creator: &'static str,
    default_map: bool,
    name: &'a str,
    nan_color: [f64; 3],
    /// Value, opacity, midpoint, sharpness.
    points: Vec<f64>,
    #[serde(rename = "RGBPoints")]
    rgb_points: Vec<f64>,
}

/// A list of one colour map.
pub(super) fn text(source: &TransferSource<'_>) -> String {
    let shown = display_points(source.transfer);
    let entry = Entry {
        color_space: "RGB",
        creator: "vr",
        default_map: true,
        name: source.name,
        nan_color: [0.0; 3],
        points: shown.iter().flat_map(|p| [p.value, p.opacity, 0.5, 0.0]).collect(),
        rgb_points: shown.iter().flat_map(|p| [p.value, p.color[0], p.color[1], p.color[2]]).collect(),
    };
    // Numbers and words: nothing that JSON refuses.
    serde_json::to_string_pretty(&[entry]).unwrap_or_default() + "\n"
}

#[cfg(test)]
mod tests {
    use vr_core::transfer::Preset;
    use vr_core::{OpacityRule, TransferFunction};

    use super::*;

    #[test]
    fn has_the_keys_that_paraview_writes() {
        let transfer =
            TransferFunction::new(Preset::CtBone.points((-1024.0, 3071.0)), OpacityRule::Power, 1.0).unwrap();
        let text =
            text(&TransferSource { name: "ct-bone", transfer: &transfer, shading: None, gradient_per_voxel: &[] });
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let map = &value[0];
        assert_eq!((map["Name"].as_str(), map["ColorSpace"].as_str()), (Some("ct-bone"), Some("RGB")));
        let length = |key: &str| map[key].as_array().map_or(0, Vec::len);
        assert!(length("RGBPoints") % 4 == 0 && length("RGBPoints") == length("Points") && length("Points") >= 20);
        assert_eq!(length("NanColor"), 3);
        assert_eq!(map["Points"][0].as_f64(), Some(150.0));
    }
}
