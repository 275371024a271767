//! STL, text and binary (3D Systems 1989): triangles, each with its three positions.
//!
//! Own code, for it is as long as the guards around a library would be: those at hand take any binary file that begins with `solid`
//! for text, stop after the first of several solids, and do not say in which line an error is.

use std::collections::HashMap;

use glam::DVec3;
use vr_core::TriangleMesh;

use super::{LoadedMesh, in_line};
use crate::error::{FieldError, FileErrorKind};

/// Bytes before the number of triangles, of which the first may say anything.
const TITLE: usize = 80;
/// Bytes before the first triangle.
const HEAD: usize = TITLE + 4;
/// Bytes of a triangle: a normal, three positions, and two bytes that programs use differently.
const FACET: usize = 50;

/// True if a file is STL in text. Binary files may begin with the same word; but then their length is what their header says.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let is_binary = claimed(bytes).is_some_and(|count| length(count) == bytes.len() as u64);
    // A null byte is in no text.
    let word = bytes.trim_ascii_start().get(..5);
    !is_binary
        && word.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && !bytes[..bytes.len().min(HEAD)].contains(&0)
}

/// The number of triangles that the header of a binary file tells.
fn claimed(bytes: &[u8]) -> Option<u32> {
    bytes.get(TITLE..)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

fn length(count: u32) -> u64 {
    HEAD as u64 + u64::from(count) * FACET as u64
}

pub(super) fn read_binary(bytes: &[u8]) -> Result<LoadedMesh, FileErrorKind> {
    let found = format!("{} bytes", bytes.len());
    let wrong = |allowed| FileErrorKind::field("length", &found, allowed);
    let count = claimed(bytes).ok_or_else(|| wrong(format!("a binary STL file has at least {HEAD}")))?;
    if length(count) != bytes.len() as u64 {
        return Err(wrong(format!("the header claims {count} triangles, which need {}", length(count))));
    }
    let mut soup = Soup::default();
    for facet in bytes[HEAD..].chunks_exact(FACET) {
        // Twelve numbers: the normal first.
        let numbers = facet.as_chunks::<4>().0;
        let number = |i: usize| f64::from(f32::from_le_bytes(numbers[i]));
        soup.add([3, 6, 9].map(|i| DVec3::new(number(i), number(i + 1), number(i + 2))))?;
    }
    soup.into_mesh("STL (binary)")
}

pub(super) fn read_text(text: &str) -> Result<LoadedMesh, FileErrorKind> {
    let mut soup = Soup::default();
    let mut facet: Option<Vec<DVec3>> = None;
    let mut ended = true;
    for (i, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        let word = words.next().unwrap_or_default().to_ascii_lowercase();
        match (word.as_str(), &mut facet) {
            ("", _) | ("outer" | "endloop", Some(_)) => {}
            ("solid", None) => ended = false,
            ("endsolid", None) => ended = true,
            ("facet", None) => facet = Some(Vec::with_capacity(3)),
            ("vertex", Some(corners)) => {
                let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
                let [x, y, z] = numbers[..] else {
                    return Err(in_line(i, line.trim(), "a vertex has three numbers").into());
                };
                corners.push(DVec3::new(x, y, z));
            }
            ("endfacet", Some(corners)) => {
                let allowed = "a facet has three vertices";
                let corners =
                    corners[..].try_into().map_err(|_| in_line(i, format!("{} of them", corners.len()), allowed))?;
                soup.add(corners)?;
                facet = None;
            }
            (_, None) => return Err(in_line(i, line.trim(), "facet or endsolid comes here").into()),
            (_, Some(_)) => {
                return Err(in_line(i, line.trim(), "outer loop, vertex, endloop or endfacet comes here").into());
            }
        }
    }
    if facet.is_some() || !ended {
        return Err(
            FieldError::new("end of the file", "an open facet or solid", "endfacet and endsolid close them").into()
        );
    }
    soup.into_mesh("STL (text)")
}

/// Triangles, with equal positions made one.
#[derive(Default)]
struct Soup {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    known: HashMap<[u64; 3], u32>,
}

impl Soup {
    fn add(&mut self, corners: [DVec3; 3]) -> Result<(), FieldError> {
        let mut triangle = [0; 3];
        for (vertex, corner) in triangle.iter_mut().zip(corners) {
            // 0 and −0 are one place.
            let corner = corner + DVec3::ZERO;
            let next = u32::try_from(self.positions.len())
                .map_err(|_| FieldError::new("size", "more than 2^32 vertices", "must have fewer"))?;
            *vertex = *self.known.entry(corner.to_array().map(f64::to_bits)).or_insert(next);
            if *vertex == next {
                self.positions.push(corner);
            }
        }
        self.triangles.push(triangle);
        Ok(())
    }

    fn into_mesh(self, format: &'static str) -> Result<LoadedMesh, FileErrorKind> {
        let mesh = TriangleMesh::new(self.positions, self.triangles)?;
        Ok(LoadedMesh { mesh, format, notes: Vec::new() })
    }
}
