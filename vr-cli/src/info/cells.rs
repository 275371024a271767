//! `vr info` of a mesh of cells.

use serde::Serialize;
use vr_core::CellMesh;
use vr_core::cells::{CellValues, NO_CELL};
use vr_io::LoadedVolume;
use vr_look::Histogram;

use crate::info::facts::Facts;
use crate::info::lines::COLUMNS;
use crate::number;

/// Description of a mesh of cells.
#[derive(Serialize)]
pub struct CellsInfo<'a> {
    #[serde(flatten)]
    facts: Facts<'a>,
    /// Number of tetrahedra.
    cells: usize,
    /// Number of vertices that belong to one.
    vertices: usize,
    /// `vertices` or `cells`: to which the values belong.
    values_of: &'static str,
    /// Volume of all cells together.
    total_volume: f64,
    /// Edge of a cube of six cells of the mean volume.
    mean_size: f64,
    /// Faces without a neighbour.
    surface_faces: usize,
    /// Smallest and largest value.
    range: [f64; 2],
    repairs: Repairs,
    /// Shares of the volume in equal bins over `range`.
    histogram: Vec<f64>,
}

/// Number of cells that were put right or left out.
#[derive(Serialize)]
struct Repairs {
    inverted: usize,
    degenerate: usize,
    duplicate: usize,
    missing: usize,
    crowded_faces: usize,
}

impl<'a> CellsInfo<'a> {
    pub fn new(title: &'a str, loaded: &'a LoadedVolume, mesh: &CellMesh) -> Self {
        let (min, max) = mesh.value_range();
        let mut used = vec![false; mesh.vertices().len()];
        mesh.cells().iter().flatten().for_each(|&v| used[v as usize] = true);
        let (total_volume, histogram) = histogram(mesh, COLUMNS);
        let r = mesh.repairs();
        Self {
            facts: Facts::new(title, loaded, mesh.bounds(), Some((min, max))),
            cells: mesh.cells().len(),
            vertices: used.into_iter().filter(|&used| used).count(),
            values_of: match mesh.values() {
                CellValues::Vertices(_) => "vertices",
                CellValues::Cells(_) => "cells",
            },
            total_volume,
            mean_size: mesh.mean_spacing(),
            surface_faces: mesh.neighbours().iter().flatten().filter(|&&n| n == NO_CELL).count(),
            range: [min, max],
            repairs: Repairs {
                inverted: r.inverted,
                degenerate: r.degenerate,
                duplicate: r.duplicate,
                missing: r.missing,
                crowded_faces: r.crowded_faces,
            },
            histogram,
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut lines = self.facts.begin("positions");
        lines.add(
            "size",
            format!("{} tetrahedra, {} vertices, values of {}", self.cells, self.vertices, self.values_of),
        );
        lines.add("bounds", self.facts.bounds());
        let (total, mean) = (number::value(self.total_volume), number::value(self.mean_size));
        lines.add("cells", format!("{total} cubic units in all; six make a cube of {mean} in the mean"));
        lines.add("surface", format!("{} faces without a neighbour", self.surface_faces));
        let [min, max] = self.range.map(number::value);
        lines.add("values", format!("{min} to {max}"));
        let Repairs { inverted, degenerate, duplicate, missing, crowded_faces } = self.repairs;
        if inverted + degenerate + duplicate + missing + crowded_faces > 0 {
            lines.add(
                "repairs",
                format!(
                    "{inverted} inverted, {degenerate} flat, {duplicate} repeated, {missing} without a value; {crowded_faces} crowded faces"
                ),
            );
        }
        self.facts.end(lines, Some(&Histogram::of_shares(self.range, &self.histogram)), "volume")
    }
}

/// Volume of all cells, and its shares by value, in equal bins over the range of the values. Each cell is sampled where it is divided evenly.
fn histogram(mesh: &CellMesh, bins: usize) -> (f64, Vec<f64>) {
    /// Parts of each edge.
    const STEPS: usize = 4;
    let places: Vec<[f64; 4]> = (0..STEPS)
        .flat_map(|i| (0..STEPS - i).flat_map(move |j| (0..STEPS - i - j).map(move |k| [i, j, k])))
        .map(|[i, j, k]| {
            let [b, c, d] = [i, j, k].map(|n| (n as f64 + 0.25) / STEPS as f64);
            [1.0 - b - c - d, b, c, d]
        })
        .collect();
    let (low, high) = mesh.value_range();
    let scale = if high > low { bins as f64 / (high - low) } else { 0.0 };
    let (mut total, mut volumes) = (0.0, vec![0.0; bins]);
    for cell in 0..mesh.cells().len() {
        let [a, b, c, d] = mesh.corners(cell);
        let volume = (b - a).cross(c - a).dot(d - a) / 6.0;
        total += volume;
        let corners = mesh.corner_values(cell);
        for place in &places {
            let value: f64 = place.iter().zip(corners).map(|(weight, value)| weight * value).sum();
            let bin = ((value - low) * scale) as usize;
            volumes[bin.min(bins - 1)] += volume / places.len() as f64;
        }
    }
    volumes.iter_mut().for_each(|volume| *volume /= total);
    (total, volumes)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn shares_of_the_volume_add_up() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_Z];
        let mesh =
            CellMesh::new(vertices, vec![[0, 1, 2, 3], [0, 2, 1, 4]], CellValues::Cells(vec![1.0, 3.0])).unwrap();
        let (total, shares) = histogram(&mesh, 4);
        assert!((total - 1.0 / 3.0).abs() < 1e-15);
        assert!((shares[0] - 0.5).abs() < 1e-12 && (shares[3] - 0.5).abs() < 1e-12, "{shares:?}");
        let loaded = LoadedVolume { volume: mesh.clone().into(), info: None, transfer: None, notes: Vec::new() };
        let info = CellsInfo::new("two", &loaded, &mesh);
        assert_eq!((info.cells, info.vertices, info.surface_faces), (2, 5, 6));
        assert!(info.text().contains("size         2 tetrahedra, 5 vertices, values of cells"), "{}", info.text());
    }
}
