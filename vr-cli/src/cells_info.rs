//! `vr info` of a mesh of cells.

use serde::Serialize;
use vr_core::CellMesh;
use vr_core::cells::CellValues;
use vr_core::transfer::Preset;
use vr_io::FileInfo;

use crate::histogram::Histogram;
use crate::number;

/// Number of columns and rows of the drawn histogram.
const DRAWN: (usize, usize) = (72, 8);
/// Parts that the whole volume counts in the drawn histogram.
const PARTS: f64 = 1e6;

/// Description of a mesh of cells.
#[derive(Serialize)]
pub struct CellsInfo<'a> {
    volume: &'a str,
    file: Option<File<'a>>,
    /// Number of tetrahedra.
    cells: usize,
    /// Number of vertices that belong to one.
    vertices: usize,
    /// `vertices` or `cells`: to which the values belong.
    values_of: &'static str,
    /// World corners, lower and upper, of the box around all cells.
    bounds: [[f64; 3]; 2],
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
    presets: Vec<&'static str>,
    look: &'a str,
    notes: &'a [String],
}

#[derive(Serialize)]
struct File<'a> {
    format: &'a str,
    encoding: &'a str,
    #[serde(rename = "type")]
    scalar: &'static str,
    /// Time steps in the file.
    frames: usize,
    /// Components of the array that is taken.
    components: usize,
    /// Arrays that may be chosen with `--value`.
    arrays: &'a [String],
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
    pub fn new(
        title: &'a str,
        mesh: &CellMesh,
        info: Option<&'a FileInfo>,
        look: &'a str,
        notes: &'a [String],
    ) -> Self {
        let (low, high) = mesh.bounds();
        let (min, max) = mesh.value_range();
        let mut used = vec![false; mesh.vertices().len()];
        mesh.cells().iter().flatten().for_each(|&v| used[v as usize] = true);
        let (total_volume, histogram) = histogram(mesh, DRAWN.0);
        let r = mesh.repairs();
        Self {
            volume: title,
            file: info.map(|i| File {
                format: i.format,
                encoding: i.encoding,
                scalar: i.scalar.name(),
                frames: i.frames,
                components: i.components,
                arrays: &i.columns,
            }),
            cells: mesh.cells().len(),
            vertices: used.into_iter().filter(|&used| used).count(),
            values_of: match mesh.values() {
                CellValues::Vertices(_) => "vertices",
                CellValues::Cells(_) => "cells",
            },
            bounds: [low.to_array(), high.to_array()],
            total_volume,
            mean_size: mesh.mean_spacing(),
            surface_faces: mesh.neighbours().iter().flatten().filter(|&&n| n == vr_core::cells::NO_CELL).count(),
            range: [min, max],
            repairs: Repairs {
                inverted: r.inverted,
                degenerate: r.degenerate,
                duplicate: r.duplicate,
                missing: r.missing,
                crowded_faces: r.crowded_faces,
            },
            histogram,
            presets: Preset::suggest((min, max), false).iter().map(|preset| preset.name()).collect(),
            look,
            notes,
        }
    }

    /// Returns lines for people.
    pub fn text(&self) -> String {
        let mut text = format!("volume       {}\n", self.volume);
        let mut line = |name: &str, what: String| text += &format!("{name:<12} {what}\n");
        if let Some(File { format, encoding, scalar, frames, components, arrays }) = &self.file {
            line("format", format!("{format}, {encoding}, positions {scalar}"));
            line("arrays", arrays.join(", "));
            if *frames > 1 {
                line("series", format!("{frames} frames, one of which is shown"));
            }
            if *components > 1 {
                line("components", format!("{components} of the array; their length or one of them is shown"));
            }
        }
        line("size", format!("{} tetrahedra, {} vertices, values of {}", self.cells, self.vertices, self.values_of));
        let [low, high] = self.bounds.map(|corner| number::triple(corner.map(number::value), " "));
        line("bounds", format!("{low} to {high}"));
        let (total, mean) = (number::value(self.total_volume), number::value(self.mean_size));
        line("cells", format!("{total} cubic units in all; six make a cube of {mean} in the mean"));
        line("surface", format!("{} faces without a neighbour", self.surface_faces));
        let [min, max] = self.range.map(number::value);
        line("values", format!("{min} to {max}"));
        let Repairs { inverted, degenerate, duplicate, missing, crowded_faces } = self.repairs;
        if inverted + degenerate + duplicate + missing + crowded_faces > 0 {
            line(
                "repairs",
                format!(
                    "{inverted} inverted, {degenerate} flat, {duplicate} repeated, {missing} without a value; {crowded_faces} crowded faces"
                ),
            );
        }
        line("look", self.look.trim_start_matches("look: ").to_owned());
        if !self.presets.is_empty() {
            line("try", format!("--transfer {}", self.presets.join(" | ")));
        }
        // Whatever occurs at all counts.
        let counts = self.histogram.iter().map(|share| (share * PARTS).ceil() as u64).collect();
        let drawn = Histogram { range: (self.range[0], self.range[1]), counts }.draw(DRAWN.1);
        text + &format!("\nhistogram (height: logarithm of the volume)\n{drawn}")
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
        let info = CellsInfo::new("two", &mesh, None, "look: plain", &[]);
        assert_eq!((info.cells, info.vertices, info.surface_faces), (2, 5, 6));
        assert!(info.text().contains("size         2 tetrahedra, 5 vertices, values of cells"), "{}", info.text());
    }
}
