//! PLY, text and binary of either byte order (Turk 1994): vertices with normals and colours, and faces.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess, PropertyAccessResult};
use vr_core::TriangleMesh;
use vr_core::transfer::srgb_to_linear;

use super::{LoadedMesh, fan, note_of_fans};
use crate::error::{FieldError, FileErrorKind};

pub(super) fn read(bytes: &[u8]) -> Result<LoadedMesh, FileErrorKind> {
    let mut reader = Reader::new(bytes);
    let (vertices, faces) = (Parser::<Vertex>::new(), Parser::<Face>::new());
    let header = vertices.read_header(&mut reader).map_err(|e| damaged(&e, true))?;
    let is_text = header.encoding == Encoding::Ascii;
    let in_data = |e: ParseError| damaged(&e, is_text);
    // Read vertices and faces; other elements are parsed to find the ones behind them.
    let mut read_vertices = None;
    let mut read_faces = None;
    for (name, element) in &header.elements {
        hold_against_length(element, reader.get_ref().len())?;
        match name.as_str() {
            "vertex" => {
                let has = |names: [&str; 3]| names.iter().all(|&n| element.properties.contains_key(n));
                if !has(["x", "y", "z"]) {
                    return Err(
                        FieldError::new("element vertex", "no x, y and z", "every vertex has a position").into()
                    );
                }
                let all = vertices.read_payload_for_element(&mut reader, element, &header).map_err(in_data)?;
                read_vertices = Some((all, has(["nx", "ny", "nz"]), has(["red", "green", "blue"])));
            }
            _ => {
                let all = faces.read_payload_for_element(&mut reader, element, &header).map_err(in_data)?;
                if name == "face" {
                    read_faces = Some(all);
                }
            }
        }
    }
    let missing = |what| FieldError::new("header", format!("no element {what}"), "a surface has vertices and faces");
    let (vertices, with_normals, with_colors) = read_vertices.ok_or_else(|| missing("vertex"))?;
    let faces = read_faces.ok_or_else(|| missing("face"))?;

    // Cut faces into triangles.
    let mut triangles = Vec::with_capacity(faces.len());
    for (i, Face { corners }) in faces.iter().enumerate() {
        if corners.len() < 3 {
            let allowed = "a face has three vertices or more, in vertex_indices";
            return Err(FieldError::new(format!("face {i}"), format!("{} of them", corners.len()), allowed).into());
        }
        triangles.extend(fan(corners));
    }
    let notes = note_of_fans(faces.iter().filter(|face| face.corners.len() > 3).count());
    let mut mesh = TriangleMesh::new(vertices.iter().map(|v| v.position).collect(), triangles)?;
    if with_normals {
        mesh = mesh.with_normals(vertices.iter().map(|v| v.normal).collect())?;
    }
    if with_colors {
        mesh = mesh.with_colors(vertices.iter().map(|v| v.color.map(|x| srgb_to_linear(x) as f32)).collect())?;
    }
    let format = if is_text { "PLY (text)" } else { "PLY (binary)" };
    Ok(LoadedMesh { mesh, format, notes })
}

/// Turns the library's error into one line: its first, since the others quote the file. A line number is given for text alone: in binary
/// data it counts nothing that the reader of the message could look up.
fn damaged(error: &ParseError, is_text: bool) -> FieldError {
    const MAX_CHARS: usize = 160;
    let message = error.to_string();
    let line = error.line().map(|n| format!("Line {n}: "));
    let message = line.and_then(|prefix| message.strip_prefix(&prefix)).unwrap_or(&message);
    FieldError {
        field: error.line().filter(|_| is_text).map_or_else(|| "data".to_owned(), |n| format!("line {n}")),
        found: message
            .lines()
            .next()
            .unwrap_or_default()
            .chars()
            .take(MAX_CHARS)
            .flat_map(char::escape_debug)
            .collect(),
        allowed: "the data must be what the header says".to_owned(),
    }
}

/// Refuses more of an element than the rest of the file can hold: entries without properties would take no bytes and never end.
fn hold_against_length(element: &ElementDef, rest: usize) -> Result<(), FieldError> {
    // A digit, or a byte: nothing is shorter.
    let min_bytes = element.properties.len().max(1);
    let needed = element.count as u128 * min_bytes as u128;
    if needed > rest as u128 || (element.properties.is_empty() && element.count > 0) {
        let found = format!("{} of {} properties each", element.count, element.properties.len());
        let allowed = format!("must fit in the {rest} bytes that follow");
        return Err(FieldError::new(format!("element {}", element.name), found, allowed));
    }
    Ok(())
}

struct Vertex {
    position: DVec3,
    normal: [f32; 3],
    /// Stored colour, from 0 to 1.
    color: [f64; 3],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: DVec3::ZERO, normal: [0.0; 3], color: [1.0; 3] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some((number, one)) = number(&property) else { return PropertyAccessResult::Ignored };
        match name {
            "x" => self.position.x = number,
            "y" => self.position.y = number,
            "z" => self.position.z = number,
            "nx" => self.normal[0] = number as f32,
            "ny" => self.normal[1] = number as f32,
            "nz" => self.normal[2] = number as f32,
            "red" => self.color[0] = number / one,
            "green" => self.color[1] = number / one,
            "blue" => self.color[2] = number / one,
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A number of any type, and what stands for full intensity in that type; `None` for a list.
fn number(property: &Property) -> Option<(f64, f64)> {
    Some(match *property {
        Property::Char(x) => (x.into(), i8::MAX.into()),
        Property::UChar(x) => (x.into(), u8::MAX.into()),
        Property::Short(x) => (x.into(), i16::MAX.into()),
        Property::UShort(x) => (x.into(), u16::MAX.into()),
        Property::Int(x) => (x.into(), i32::MAX.into()),
        Property::UInt(x) => (x.into(), u32::MAX.into()),
        Property::Float(x) => (x.into(), 1.0),
        Property::Double(x) => (x, 1.0),
        _ => return None,
    })
}

/// A face, or an entry of an element that is not looked at.
struct Face {
    corners: Vec<u32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        // What is no index becomes one that no file has vertices for.
        fn indices<T: Copy + TryInto<u32>>(list: &[T]) -> Vec<u32> {
            list.iter().map(|&i| i.try_into().unwrap_or(u32::MAX)).collect()
        }
        self.corners = match &property {
            Property::ListChar(list) => indices(list),
            Property::ListUChar(list) => indices(list),
            Property::ListShort(list) => indices(list),
            Property::ListUShort(list) => indices(list),
            Property::ListInt(list) => indices(list),
            Property::ListUInt(list) => indices(list),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}
