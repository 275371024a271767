//! OBJ (Wavefront 1990s): of it, vertices with colours, normals, and faces.
//!
//! Own code, for these are three kinds of lines, and the library at hand computes indices that can overflow, which panics where that is
//! checked, and does not say in which line an error is.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::DVec3;
use vr_core::TriangleMesh;
use vr_core::transfer::srgb_to_linear;

use super::{LoadedMesh, fan, in_line, note_of_fans};
use crate::error::{FieldError, FileErrorKind};

/// Stands for the index of a normal where there is none.
const NONE: u32 = u32::MAX;

#[derive(Default)]
struct Contents {
    positions: Vec<DVec3>,
    /// Linear RGB; white for vertices without colour.
    colors: Vec<[f32; 3]>,
    colored: bool,
    normals: Vec<[f32; 3]>,
    /// Position and normal of each corner.
    triangles: Vec<[[u32; 2]; 3]>,
    polygons: usize,
}

pub(super) fn read(text: &str) -> Result<LoadedMesh, FileErrorKind> {
    let mut contents = Contents::default();
    let mut lines = text.lines().enumerate();
    while let Some((i, line)) = lines.next() {
        let mut line = Cow::from(line.trim());
        // A backslash at its end continues a line.
        while let Some(begun) = line.strip_suffix('\\') {
            let rest = lines.next().map_or("", |(_, rest)| rest);
            line = format!("{begun} {}", rest.trim()).into();
        }
        contents.line(i, &line)?;
    }
    contents.into_mesh()
}

impl Contents {
    fn line(&mut self, i: usize, line: &str) -> Result<(), FieldError> {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let numbers = words.map_while(|w| w.parse().ok()).collect::<Vec<f64>>();
                let Some(&[x, y, z]) = numbers.first_chunk() else {
                    return Err(in_line(i, line, "a vertex has three numbers, or six with a colour"));
                };
                self.positions.push(DVec3::new(x, y, z));
                // A single number more is a weight, of which surfaces of polygons know nothing.
                let color = numbers.get(3..6).and_then(|c| c.first_chunk::<3>());
                self.colored |= color.is_some();
                self.colors.push(color.map_or([1.0; 3], |c| c.map(|x| srgb_to_linear(x) as f32)));
            }
            Some("vn") => {
                let numbers = words.map_while(|w| w.parse().ok()).collect::<Vec<f32>>();
                let normal = numbers.first_chunk().ok_or_else(|| in_line(i, line, "a normal has three numbers"))?;
                self.normals.push(*normal);
            }
            Some("f") => {
                let wrong = || in_line(i, line, "a face has three corners or more, as in f 1 2 3 or f 1//1 2//1 3//1");
                let corners = words.map(|w| self.corner(w)).collect::<Option<Vec<_>>>().ok_or_else(wrong)?;
                if corners.len() < 3 {
                    return Err(wrong());
                }
                self.triangles.extend(fan(&corners));
                self.polygons += usize::from(corners.len() > 3);
            }
            // Textures, materials, groups, lines, points, curves; comments, and words that are none.
            _ => {}
        }
        Ok(())
    }

    /// `position`, `position/texture`, `position//normal` or `position/texture/normal`, counted from 0.
    fn corner(&self, word: &str) -> Option<[u32; 2]> {
        let mut parts = word.split('/');
        let position = index(parts.next()?, self.positions.len())?;
        let normal = match parts.nth(1) {
            Some(part) => index(part, self.normals.len())?,
            None => NONE,
        };
        Some([position, normal])
    }

    fn into_mesh(self) -> Result<LoadedMesh, FileErrorKind> {
        let Self { positions, colors, colored, normals, triangles, polygons } = self;
        let notes = note_of_fans(polygons);
        let mesh = if triangles.iter().flatten().all(|corner| corner[1] == NONE) {
            let mesh = TriangleMesh::new(positions, triangles.iter().map(|t| t.map(|corner| corner[0])).collect())?;
            if colored { mesh.with_colors(colors)? } else { mesh }
        } else {
            split(&positions, colored.then_some(&colors[..]), &normals, &triangles)?
        };
        Ok(LoadedMesh { mesh, format: "OBJ", notes })
    }
}

/// An index of a file, from 1 or, below 0, from the last of `count` backwards; now from 0.
fn index(word: &str, count: usize) -> Option<u32> {
    let index: i64 = word.parse().ok()?;
    let from_0 = if index < 0 { (count as i64).checked_add(index)? } else { index - 1 };
    // The last one stands for none.
    u32::try_from(from_0).ok().filter(|&i| i != NONE)
}

/// A surface whose vertices have one normal each: positions with several normals are repeated.
fn split(
    positions: &[DVec3],
    colors: Option<&[[f32; 3]]>,
    normals: &[[f32; 3]],
    triangles: &[[[u32; 2]; 3]],
) -> Result<TriangleMesh, FileErrorKind> {
    let missing = |what: &str, found: u32, count: usize| {
        let allowed = format!("there are {count}, counted from 1");
        FileErrorKind::field("faces", format!("{what} {}", u64::from(found) + 1), allowed)
    };
    let mut known = HashMap::new();
    let (mut at, mut facing, mut colored) = (Vec::new(), Vec::new(), Vec::new());
    let mut vertices = Vec::with_capacity(triangles.len());
    for triangle in triangles {
        let mut vertex = [0; 3];
        for (vertex, &[p, n]) in vertex.iter_mut().zip(triangle) {
            let next = at.len() as u32;
            *vertex = *known.entry([p, n]).or_insert(next);
            if *vertex == next {
                at.push(*positions.get(p as usize).ok_or_else(|| missing("vertex", p, positions.len()))?);
                // Zero stands for none.
                let normal = if n == NONE { Some(&[0.0; 3]) } else { normals.get(n as usize) };
                facing.push(*normal.ok_or_else(|| missing("normal", n, normals.len()))?);
                colored.extend(colors.map(|colors| colors[p as usize]));
            }
        }
        vertices.push(vertex);
    }
    let mesh = TriangleMesh::new(at, vertices)?.with_normals(facing)?;
    Ok(if colors.is_some() { mesh.with_colors(colored)? } else { mesh })
}
