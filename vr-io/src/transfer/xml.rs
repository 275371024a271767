//! Transfer functions in XML: ParaView's old colour maps, VTK's volume properties, and 3D Slicer's presets (`presets.xml`, scenes).

use roxmltree::{Document, Node};

use crate::error::{FieldError, shown};

use super::TransferFile;
use super::color_space::ColorSpace;
use super::curves::{colors, growing, merge};
use super::opacity::opacities;
use super::polyline::Polyline;
use super::slicer::{self, rows};
use super::volume_property::VolumeProperty;

/// Reads the first transfer function of a document.
pub(super) fn parse(text: &str) -> Result<TransferFile, FieldError> {
    let document = Document::parse(text).map_err(|e| FieldError::new("XML", e, "must be a well-formed document"))?;
    let root = document.root_element();
    let all = |name: &'static str| root.descendants().filter(move |n| n.tag_name().name() == name);
    let several = |count: usize, what: &str, file: &mut TransferFile| {
        if count > 1 {
            file.notes.push(format!("there are {count} {what}: the first one, {}, is used", shown(&file.name)));
        }
    };
    // 3D Slicer's presets are attributes; VTK's properties are elements.
    let mut presets = all("VolumeProperty").filter(|n| n.has_attribute("scalarOpacity"));
    if let Some(first) = presets.next() {
        let mut file = slicer_preset(first)?;
        several(1 + presets.count(), "volume properties", &mut file);
        return Ok(file);
    }
    if let Some(first) = all("ColorMap").next() {
        let mut file = color_map(first)?;
        several(all("ColorMap").count(), "colour maps", &mut file);
        return Ok(file);
    }
    if all("ColorTransferFunction").next().is_some() || all("PiecewiseFunction").next().is_some() {
        return vtk_property(root);
    }
    let allowed =
        "must be a ColorMap of ParaView, or a VolumeProperty, ColorTransferFunction or PiecewiseFunction of VTK";
    Err(FieldError::new("XML", root.tag_name().name(), allowed))
}

/// ParaView's `<ColorMap>` of `<Point x= o= r= g= b=>`.
fn color_map(node: Node<'_, '_>) -> Result<TransferFile, FieldError> {
    let mut notes = Vec::new();
    let space = ColorSpace::from_name(node.attribute("space").unwrap_or("RGB"), &mut notes)?;
    if node.attribute("indexedLookup").is_some_and(|a| a == "true" || a == "1") {
        return Err(FieldError::new("indexedLookup", "true", "categories are no transfer function: must be false"));
    }
    let (mut color, mut opacity) = (Vec::new(), Vec::new());
    let mut has_opacity = true;
    for (k, point) in node.children().filter(|n| n.has_tag_name("Point")).enumerate() {
        let [x, r, g, b] = ["x", "r", "g", "b"].map(|name| number(point, k, name));
        let x = x?;
        color.push([x, r?, g?, b?]);
        has_opacity &= point.has_attribute("o");
        if has_opacity {
            opacity.push([x, number(point, k, "o")?, 0.5, 0.0]);
        }
    }
    if color.is_empty() {
        return Err(FieldError::new("ColorMap", "no Point", "must have one at least"));
    }
    let line = colors(&color, space, |row, k| format!("Point {}, {}", row + 1, ["x", "r", "g", "b"][k]))?;
    let opacity = if has_opacity {
        opacities(&opacity, |row, _| format!("Point {}, o", row + 1))?
    } else {
        growing(&line, &mut notes)
    };
    let name = shown(node.attribute("name").unwrap_or_default());
    Ok(TransferFile { name, notes, ..TransferFile::of_points("ParaView's XML", merge(&line, &opacity), false) })
}

/// 3D Slicer's `<VolumeProperty scalarOpacity="n x a …" …>`.
fn slicer_preset(node: Node<'_, '_>) -> Result<TransferFile, FieldError> {
    const PARTS: [&str; 3] = ["scalarOpacity", "gradientOpacity", "colorTransfer"];
    let text = |name: &str| node.attribute(name).unwrap_or_default();
    let coefficient = |name: &str, usual: f64| match node.attribute(name) {
        Some(text) => text.trim().parse().map_err(|_| FieldError::new(name, text, "must be a number")),
        None => Ok(usual),
    };
    let shading = [
        coefficient("ambient", 0.1)?,
        coefficient("diffuse", 0.7)?,
        coefficient("specular", 0.2)?,
        coefficient("specularPower", 10.0)?,
    ];
    let file = VolumeProperty {
        is_nearest: text("interpolation") == "0",
        shading: (text("shade") == "1").then_some(shading),
        opacity: rows::<2>(PARTS[0], text(PARTS[0]))?.into_iter().map(|[x, a]| [x, a, 0.5, 0.0]).collect(),
        gradient: rows::<2>(PARTS[1], text(PARTS[1]))?,
        color: rows::<4>(PARTS[2], text(PARTS[2]))?,
        unit_distance: None,
    }
    .into_file(slicer::FORMAT, PARTS)?;
    Ok(TransferFile { name: shown(text("name")), ..file })
}

/// VTK's `<VolumeProperty>` of components, or its functions alone.
fn vtk_property(root: Node<'_, '_>) -> Result<TransferFile, FieldError> {
    const FORMAT: &str = "VTK's XML";
    let is = |name: &'static str| move |n: &Node<'_, '_>| n.tag_name().name() == name;
    let component = root.descendants().find(is("Component")).unwrap_or(root);
    let under = |n: Node<'_, '_>, parent: &str| n.parent().is_some_and(|p| p.tag_name().name() == parent);
    let functions = || component.descendants().filter(is("PiecewiseFunction"));
    let color = component.descendants().find(is("ColorTransferFunction"));
    let gradient = functions().find(|&n| under(n, "GradientOpacity"));
    let opacity = functions().find(|&n| under(n, "ScalarOpacity"));
    let opacity =
        opacity.or_else(|| functions().find(|&n| !under(n, "GradientOpacity") && !under(n, "GrayTransferFunction")));
    // A grey function takes the place of colours.
    let grey = functions().find(|&n| under(n, "GrayTransferFunction"));
    let color = match (color, grey) {
        (Some(color), _) => color_points(color)?,
        (None, Some(grey)) => value_points(grey)?.into_iter().map(|[x, v, ..]| [x, v, v, v]).collect(),
        (None, None) => Vec::new(),
    };
    let attribute = |name: &str| component.attribute(name).and_then(|text| text.trim().parse::<f64>().ok());
    let coefficients = [
        attribute("Ambient").unwrap_or(0.1),
        attribute("Diffuse").unwrap_or(0.7),
        attribute("Specular").unwrap_or(0.2),
        attribute("SpecularPower").unwrap_or(10.0),
    ];
    // A function alone: white under opacities, or colours that grow more opaque.
    if color.is_empty() || opacity.is_none() {
        let mut notes = Vec::new();
        let points = match opacity {
            Some(opacity) => {
                notes.push("there are no colours: all is white".to_owned());
                let line = opacities(&value_points(opacity)?, |row, _| format!("Point {}", row + 1))?;
                merge(&Polyline(vec![(line.range().0, [1.0; 3])]), &line)
            }
            None if color.is_empty() => {
                return Err(FieldError::new("XML", "no Point", "a function must have one at least"));
            }
            None => {
                let line = colors(&color, ColorSpace::Rgb, |row, _| format!("Point {}", row + 1))?;
                merge(&line, &growing(&line, &mut notes))
            }
        };
        return Ok(TransferFile { notes, ..TransferFile::of_points(FORMAT, points, true) });
    }
    VolumeProperty {
        is_nearest: root.attribute("InterpolationType") == Some("0"),
        shading: (component.attribute("Shade") == Some("1")).then_some(coefficients),
        opacity: opacity.map(value_points).transpose()?.unwrap_or_default(),
        gradient: gradient.map(value_points).transpose()?.unwrap_or_default().iter().map(|p| [p[0], p[1]]).collect(),
        color,
        unit_distance: attribute("ScalarOpacityUnitDistance"),
    }
    .into_file(FORMAT, ["ScalarOpacity", "GradientOpacity", "ColorTransferFunction"])
}

/// `<Point X= Value= MidPoint= Sharpness=>`.
fn value_points(function: Node<'_, '_>) -> Result<Vec<[f64; 4]>, FieldError> {
    let points = function.children().filter(|n| n.has_tag_name("Point")).enumerate();
    let row = |(k, point): (usize, Node<'_, '_>)| {
        let or = |name: &str, usual: f64| if point.has_attribute(name) { number(point, k, name) } else { Ok(usual) };
        Ok([number(point, k, "X")?, number(point, k, "Value")?, or("MidPoint", 0.5)?, or("Sharpness", 0.0)?])
    };
    points.map(row).collect()
}

/// `<Point X= Value="r g b">`.
fn color_points(function: Node<'_, '_>) -> Result<Vec<[f64; 4]>, FieldError> {
    let points = function.children().filter(|n| n.has_tag_name("Point")).enumerate();
    let row = |(k, point): (usize, Node<'_, '_>)| {
        let text = point.attribute("Value").unwrap_or_default();
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        let [r, g, b] = numbers[..] else {
            return Err(FieldError::new(format!("Point {}, Value", k + 1), text, "must be red, green and blue"));
        };
        Ok([number(point, k, "X")?, r, g, b])
    };
    points.map(row).collect()
}

/// A number of the point that comes `k`-th.
fn number(point: Node<'_, '_>, k: usize, name: &str) -> Result<f64, FieldError> {
    let text = point.attribute(name).unwrap_or_default();
    text.trim().parse().map_err(|_| FieldError::new(format!("Point {}, {name}", k + 1), text, "must be a number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{OpacityRule, TransferFunction};

    fn transfer(file: &TransferFile) -> TransferFunction {
        TransferFunction::new(file.points.clone(), OpacityRule::Power, 1.0).unwrap()
    }

    #[test]
    fn paraview_color_maps_are_relative() {
        let file = parse(
            r#"<ColorMaps><ColorMap name="Two" space="HSV"><Point x="0" o="0" r="1" g="0" b="0"/>
               <Point x="1" o="0.5" r="0" g="0" b="1"/></ColorMap><ColorMap name="Other"/></ColorMaps>"#,
        )
        .unwrap();
        assert!(!file.absolute && file.name == "Two" && file.notes[0].contains("2 colour maps"), "{:?}", file.notes);
        let middle = transfer(&file).at(0.5);
        // Half-way by hue is magenta.
        assert!((middle.opacity - 0.25).abs() < 1e-12 && middle.color[0] > 0.9 && middle.color[2] > 0.9, "{middle:?}");
    }

    #[test]
    fn slicer_presets_are_absolute() {
        let file = parse(
            r#"<MRML><VolumeProperty name="CT-X" interpolation="1" shade="1" diffuse="0.6" ambient="0.2" specular="0.3" specularPower="15"
               scalarOpacity="4 -3024 0 1000 0.8" gradientOpacity="4 0 1 255 1" colorTransfer="8 -3024 0 0 0 1000 1 1 1"/></MRML>"#,
        )
        .unwrap();
        assert!(file.absolute && file.name == "CT-X");
        assert_eq!(file.shading.as_ref().unwrap().power, 15.0);
        assert_eq!(transfer(&file).at(1000.0).opacity, 0.8);
    }

    #[test]
    fn vtk_properties_and_functions() {
        let colors = r#"<ColorTransferFunction Size="2"><Point X="0" Value="1 0 0"/><Point X="10" Value="0 1 0"/></ColorTransferFunction>"#;
        let ramp = r#"<PiecewiseFunction><Point X="0" Value="0" MidPoint="0.25" Sharpness="0"/><Point X="8" Value="0.4"/></PiecewiseFunction>"#;
        let gradient = r#"<PiecewiseFunction><Point X="0" Value="0"/><Point X="50" Value="1"/></PiecewiseFunction>"#;
        let text = format!(
            r#"<VolumeProperty InterpolationType="1"><Component Index="0" Shade="1" Ambient="0.3"><RGBTransferFunction>{colors}
            </RGBTransferFunction><GradientOpacity>{gradient}</GradientOpacity><ScalarOpacity>{ramp}</ScalarOpacity></Component></VolumeProperty>"#
        );
        let file = parse(&text).unwrap();
        assert_eq!(transfer(&file).at(2.0).opacity, 0.2, "half at the midpoint");
        assert_eq!(file.gradient_per_voxel, [(0.0, 0.0), (50.0, 1.0)]);
        assert_eq!(file.shading.as_ref().unwrap().ambient, 0.3);
        let alone = parse(colors).unwrap();
        assert!(alone.notes[0].contains("no opacities") && transfer(&alone).at(10.0).opacity == 1.0);
        let white = parse(ramp).unwrap();
        assert_eq!(transfer(&white).at(8.0).color, [1.0; 3]);
    }

    #[test]
    fn names_what_is_wrong() {
        for (text, word) in [
            ("<a", "XML: found"),
            ("<VTKFile/>", "found VTKFile; must be a ColorMap"),
            ("<ColorMap/>", "no Point"),
            (r#"<ColorMap><Point x="0" o="0" r="1" g="0"/></ColorMap>"#, "Point 1, b: found nothing; must be a number"),
            (r#"<ColorMap><Point x="0" o="3" r="1" g="0" b="0"/></ColorMap>"#, "Point 1, o: found 3"),
            (r#"<ColorMap space="XYZ"><Point x="0" o="0" r="1" g="0" b="0"/></ColorMap>"#, "ColorSpace: found XYZ"),
            ("<ColorTransferFunction/>", "no Point"),
            ("<PiecewiseFunction/>", "Point 1: found nothing; must have one point"),
            (
                r#"<ColorTransferFunction><Point X="0" Value="1"/></ColorTransferFunction>"#,
                "must be red, green and blue",
            ),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
