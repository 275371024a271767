//! Headers in XML: `VoreenData` with volumes, each of raw data, metadata, and data derived from these, which are left out.

use std::io::Read;
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3, DVec4};
use roxmltree::{Document, Node};
use vr_core::Calibration;

use crate::error::{FieldError, FileError};
use crate::layout::{Axis, Layout, Role};
use crate::notes::{Assumption, Notes};
use crate::read::{Description, ReadOptions};
use crate::regular_file;
use crate::scalar::ScalarType;
use crate::world::Space;

use super::{place, raw};

/// Longest header, in bytes: pictures and histograms are in it too.
const LONGEST: u64 = 1 << 26;

/// True if the beginning of a file is that of such a header.
pub(crate) fn is_vvd(head: &[u8]) -> bool {
    let mark = b"<VoreenData";
    head.trim_ascii_start().starts_with(b"<") && head.windows(mark.len()).any(|w| w == mark)
}

/// Describes the volume of a header.
pub(crate) fn describe(path: &Path, options: &ReadOptions) -> Result<Description, FileError> {
    let in_file = |e: FieldError| e.in_file(path);
    let mut notes = Notes::default();
    let mut text = String::new();
    let file = regular_file::open(path).map_err(|e| FileError::new(path, e))?;
    file.take(LONGEST).read_to_string(&mut text).map_err(|e| FileError::new(path, e))?;
    let document = Document::parse(&text).map_err(|e| in_file(FieldError::new("XML", e, "must be well-formed")))?;
    let volumes: Vec<Node<'_, '_>> = document.descendants().filter(|n| n.has_tag_name("Volume")).collect();
    let volume = choose(path, &volumes, options)?;
    let data = child(volume, "RawData")
        .ok_or_else(|| in_file(FieldError::new("RawData", "nothing", "the element is required")))?;

    let (scalar, components) = format(required(data, "format").map_err(in_file)?).map_err(in_file)?;
    let mut axes = vec![Axis { size: components, role: Role::of_components(components, scalar) }];
    for name in ["x", "y", "z"] {
        let found = required(data, name).map_err(in_file)?;
        let size = found.parse().ok().filter(|&n: &usize| n > 0);
        let size =
            size.ok_or_else(|| in_file(FieldError::new(format!("RawData {name}"), found, "must be 1 or more")))?;
        axes.push(Axis { size, role: Role::Space });
    }
    // The frame is chosen already.
    let layout = Layout::new(path, &axes, &ReadOptions { frame: None, ..options.clone() })?;
    let layout = Layout { frames: volumes.len(), ..layout };

    let meta = Meta { volume };
    let spacing = meta.vector("Spacing").map_err(in_file)?;
    if spacing.is_none() {
        notes.assume(Assumption::Spacing, "no Spacing in the header: 1, 1, 1 is assumed");
    }
    let offset = meta.vector("Offset").map_err(in_file)?;
    let matrix = meta.matrix("Transformation").map_err(in_file)?.unwrap_or(DMat4::IDENTITY);
    let placement = place(path, offset.unwrap_or(DVec3::ZERO), spacing.unwrap_or(DVec3::ONE), matrix)?;
    let calibration = meta.calibration(scalar, &mut notes).map_err(in_file)?;
    let data_file = data_file(path, data).map_err(in_file)?;
    Ok(Description {
        format: "Voreen (vvd)",
        header: path.into(),
        source: raw(&data_file, scalar, &mut notes).into(),
        layout,
        placement,
        placed_by: if spacing.is_some() { "Spacing" } else { "assumed" },
        calibration,
        space: Space::Own,
        units: None,
        scan: None,
        notes,
    })
}

/// The volume of the frame that the options name.
fn choose<'a, 'i>(path: &Path, volumes: &[Node<'a, 'i>], options: &ReadOptions) -> Result<Node<'a, 'i>, FileError> {
    let count = volumes.len();
    let chosen = options.frame.unwrap_or(0);
    volumes.get(chosen).copied().ok_or_else(|| {
        let field = if count == 0 { "Volume" } else { "frame" };
        FieldError::new(field, chosen, format!("the file has {count} volumes")).in_file(path)
    })
}

fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|n| n.has_tag_name(name))
}

fn required<'a>(data: Node<'a, '_>, name: &str) -> Result<&'a str, FieldError> {
    let missing = || FieldError::new(format!("RawData {name}"), "nothing", "the attribute is required");
    data.attribute(name).ok_or_else(missing)
}

/// `uint8`, or `Vector3(uint8)`: the type and the number of components.
fn format(text: &str) -> Result<(ScalarType, usize), FieldError> {
    let vector = text.strip_prefix("Vector").and_then(|rest| rest.strip_suffix(')')?.split_once('('));
    let (count, name) = vector.unwrap_or(("1", text));
    let count = count.parse().ok().filter(|n| (1..=4).contains(n));
    count.and_then(|count| Some((ScalarType::from_name(name)?, count))).ok_or_else(|| {
        FieldError::new(
            "RawData format",
            text,
            "must be int8 to uint64, float or double, or Vector2(…) to Vector4(…) of these",
        )
    })
}

/// The raw file: named by an attribute, or, since version 5, by a list of paths of which one may be there.
fn data_file(path: &Path, data: Node<'_, '_>) -> Result<PathBuf, FieldError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let names: Vec<&str> = match data.attribute("filename") {
        Some(name) => vec![name],
        None => child(data, "Paths")
            .into_iter()
            .flat_map(|p| p.descendants())
            .filter_map(|n| n.attribute("value"))
            .collect(),
    };
    let paths = || names.iter().map(|name| folder.join(name.replace('\\', "/")));
    let first = paths().find(|p| crate::memory_folder::is_file(p)).or_else(|| paths().next());
    first.ok_or_else(|| FieldError::new("RawData filename", "nothing", "the attribute is required"))
}

/// Metadata of a volume, by name.
struct Meta<'a, 'i> {
    volume: Node<'a, 'i>,
}

impl<'a, 'i> Meta<'a, 'i> {
    /// The element with the value.
    fn value(&self, name: &str) -> Option<Node<'a, 'i>> {
        let items = child(self.volume, "MetaData")?;
        let item = items.children().find(|n| n.has_tag_name("MetaItem") && n.attribute("name") == Some(name))?;
        child(item, "value")
    }

    fn vector(&self, name: &str) -> Result<Option<DVec3>, FieldError> {
        let Some(value) = self.value(name) else { return Ok(None) };
        let [x, y, z] = ["x", "y", "z"].map(|axis| number(name, value, axis));
        Ok(Some(DVec3::new(x?, y?, z?)))
    }

    /// Four rows.
    fn matrix(&self, name: &str) -> Result<Option<DMat4>, FieldError> {
        let Some(value) = self.value(name) else { return Ok(None) };
        let mut rows = [DVec4::ZERO; 4];
        for (i, row) in rows.iter_mut().enumerate() {
            let tag = format!("row{i}");
            let found =
                child(value, &tag).ok_or_else(|| FieldError::new(name, "no such row", format!("must have {tag}")))?;
            let [x, y, z, w] = ["x", "y", "z", "w"].map(|axis| number(name, found, axis));
            *row = DVec4::new(x?, y?, z?, w?);
        }
        let matrix = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose();
        if rows[3] != DVec4::W {
            return Err(FieldError::new(name, format_args!("the last row {}", rows[3]), "must be 0, 0, 0, 1"));
        }
        Ok(Some(matrix))
    }

    /// The real-world mapping is one of normalized values: integers divided by the largest one of their type.
    fn calibration(&self, scalar: ScalarType, notes: &mut Vec<String>) -> Result<Calibration, FieldError> {
        const NAME: &str = "RealWorldMapping";
        let Some(value) = self.value(NAME) else { return Ok(Calibration::default()) };
        let largest = match scalar {
            ScalarType::U8 => f64::from(u8::MAX),
            ScalarType::I8 => f64::from(i8::MAX),
            ScalarType::U16 => f64::from(u16::MAX),
            ScalarType::I16 => f64::from(i16::MAX),
            ScalarType::U32 => f64::from(u32::MAX),
            ScalarType::I32 => f64::from(i32::MAX),
            ScalarType::U64 => u64::MAX as f64,
            ScalarType::I64 => i64::MAX as f64,
            ScalarType::F32 | ScalarType::F64 => 1.0,
        };
        if let Some(unit) = value.attribute("unit").filter(|u| !u.is_empty()) {
            notes.push(format!("the header gives values in {}", crate::error::shown(unit)));
        }
        Ok(Calibration { slope: number(NAME, value, "scale")? / largest, intercept: number(NAME, value, "offset")? })
    }
}

fn number(field: &str, node: Node<'_, '_>, name: &str) -> Result<f64, FieldError> {
    let text = node.attribute(name).unwrap_or_default();
    let wrong = || FieldError::new(format!("{field} {name}"), text, "must be a number");
    text.parse().map_err(|_| wrong())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voreen::tests::described_and_loaded;

    fn load(raw: &str, meta: &str, data: &[u8]) -> Result<(Description, Vec<u16>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.vvd");
        let text = format!(
            "<?xml version=\"1.0\" ?>\n<VoreenData version=\"1\"><Volumes><Volume>{raw}<MetaData>{meta}</MetaData></Volume></Volumes></VoreenData>"
        );
        assert!(is_vvd(text.as_bytes()));
        std::fs::write(&path, text).unwrap();
        std::fs::write(folder.path().join("a.raw"), data).unwrap();
        described_and_loaded(describe, &path)
    }

    const RAW: &str = r#"<RawData filename="a.raw" format="uint16" x="4" y="3" z="2" />"#;

    fn item(name: &str, value: &str) -> String {
        format!(r#"<MetaItem name="{name}" type="T">{value}</MetaItem>"#)
    }

    #[test]
    fn metadata_place_and_scale() {
        let data: Vec<u8> = (0..24u16).flat_map(|i| (300 * i).to_le_bytes()).collect();
        let rows = "<row0 x=\"0\" y=\"-1\" z=\"0\" w=\"10\"/><row1 x=\"1\" y=\"0\" z=\"0\" w=\"20\"/><row2 x=\"0\" y=\"0\" z=\"1\" w=\"30\"/><row3 x=\"0\" y=\"0\" z=\"0\" w=\"1\"/>";
        let meta = [
            item("Offset", r#"<value x="1" y="2" z="3" />"#),
            item("Spacing", r#"<value x="2" y="3" z="4" />"#),
            item("Transformation", &format!("<value>{rows}</value>")),
            item("RealWorldMapping", r#"<value scale="131070" offset="-5" unit="HU" />"#),
        ];
        let (description, found) = load(RAW, &meta.concat(), &data).unwrap();
        assert_eq!(found, (0..24).map(|i| 300 * i).collect::<Vec<u16>>());
        // (1, 1, 1) is at (3, 5, 7), turned and moved.
        assert_eq!(description.placement.to_world(DVec3::ONE), DVec3::new(5.0, 23.0, 37.0));
        assert_eq!(description.calibration, Calibration { slope: 2.0, intercept: -5.0 });
        let paths = r#"<RawData format="uint16" x="4" y="3" z="2"><Paths><paths><item value="/gone/a.raw"/><item value="a.raw"/></paths></Paths></RawData>"#;
        assert_eq!(load(paths, "", &data).unwrap().1, found);
    }

    #[test]
    fn formats() {
        assert_eq!(format("Vector3(int16)"), Ok((ScalarType::I16, 3)));
        assert_eq!(format("float"), Ok((ScalarType::F32, 1)));
        for bad in ["Vector9(uint8)", "Tensor2(float)", "", "Vector3(uint8"] {
            assert!(format(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        for (raw, meta, word) in [
            (RAW.to_owned(), String::new(), "claims 48 bytes of voxels, found 8"),
            (RAW.replace("a.raw", "b.raw"), String::new(), "b.raw"),
            (RAW.replace("\"3\"", "\"0\""), String::new(), "RawData y: found 0"),
            (RAW.replace("\"3\"", "\"-3\""), String::new(), "RawData y: found -3"),
            (RAW.replace("\"3\"", "\"99999999999\""), String::new(), "dims"),
            (RAW.replace("z=", "t="), String::new(), "RawData z: found nothing"),
            (RAW.replace("filename", "name"), String::new(), "RawData filename: found nothing"),
            (RAW.replace("uint16", "quaternion"), String::new(), "RawData format: found quaternion"),
            (RAW.to_owned(), item("Spacing", r#"<value x="0" y="1" z="1" />"#), "spacing of axis 0"),
            (RAW.to_owned(), item("Spacing", r#"<value x="one" y="1" z="1" />"#), "Spacing x: found one"),
            (
                RAW.to_owned(),
                item("Transformation", "<value><row0 x=\"1\" y=\"1\" z=\"1\" w=\"1\"/></value>"),
                "must have row1",
            ),
            (String::new(), String::new(), "RawData: found nothing"),
            ("<RawData".to_owned(), String::new(), "XML: found"),
        ] {
            let message = load(&raw, &meta, &[0; 8]).map(|_| ()).unwrap_err();
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    }
}
