//! A mesh of cells along a ray.

use glam::DVec3;

use super::crossing::{CellCrossing, LocalRay};
use super::mesh::{CellMesh, CellValues};
use crate::bound::{Bound, largest};
use crate::box_tree::LocalLine;
use crate::clip_error::clip_error;
use crate::field::{Chord, Cut, FieldLine, LineModel, Poly, distinct_places};
use crate::ray::Ray;
use crate::view::Clip;

/// A mesh along a ray: cut at every face, and of degree 1 between two of them.
///
/// Distances are world units behind the offset of its [`Chord`].
#[derive(Debug)]
pub(super) struct CellLine<'a> {
    mesh: &'a CellMesh,
    gradients: Option<&'a [DVec3]>,
    crossings: Vec<CellCrossing>,
    /// Faces, ascending, each with a bound on its error.
    breaks: Vec<(f64, f64)>,
    /// Contents of the stretches between breaks.
    pieces: Vec<Piece>,
    offset: f64,
}

/// Content of the stretch between two breaks.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Number of the crossing, [`VACUUM`] for none.
    crossing: u32,
    /// Its depth in the middle.
    depth: f64,
    /// Bound on what is not known of the value: which cell the ray is in between two that it runs along, or beyond misplaced ends.
    unsure: f64,
}

const VACUUM: u32 = u32::MAX;

impl<'a> CellLine<'a> {
    /// The mesh along a ray; `None` where the ray meets no cell.
    pub(super) fn new(mesh: &'a CellMesh, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Self> {
        let [from, to] = ray.inside(clip)?;
        let (low, high) = mesh.bounds();
        let local = LocalRay::near(ray, 0.5 * low + 0.5 * high);
        let part = [from - local.offset, to.min(far) - local.offset];
        let clip_errors = part.map(|at| clip_error(ray, clip, local.offset, at));
        Self::between_ends(mesh, &local, part, clip_errors, gradients)
    }

    /// Appends the world distances between two at which the field jumps: where vacuum begins or ends and, for values of cells, all faces.
    pub(super) fn jumps(mesh: &CellMesh, ray: &Ray, part: [f64; 2], out: &mut Vec<f64>) {
        let (low, high) = mesh.bounds();
        let local = LocalRay::near(ray, 0.5 * low + 0.5 * high);
        let part = part.map(|s| s - local.offset);
        let Some(line) = CellLine::between_ends(mesh, &local, part, [0.0; 2], false) else { return };
        let all = matches!(mesh.values(), CellValues::Cells(_));
        let jumps = (0..line.breaks.len()).filter(|&i| all || line.borders_vacuum(i));
        out.extend(jumps.map(|i| line.breaks[i].0 + local.offset));
    }

    fn between_ends(
        mesh: &'a CellMesh,
        ray: &LocalRay,
        part: [f64; 2],
        end_errors: [f64; 2],
        gradients: bool,
    ) -> Option<Self> {
        if part[0] >= part[1] || part.iter().any(|s| s.is_nan()) {
            return None;
        }
        let tree = mesh.tree();
        let line = LocalLine { origin: ray.base - tree.middle(), direction: ray.direction, ends: part };
        let mut crossings: Vec<CellCrossing> = Vec::new();
        tree.each_along(&line, |cell| crossings.extend(CellCrossing::new(mesh, cell, ray, part)));
        crossings.sort_unstable_by(|a, b| a.ends[0].total_cmp(&b.ends[0]).then(a.cell.cmp(&b.cell)));

        // Order the faces; the first entry and the last exit are the ends of all.
        let entries = crossings.iter().map(|c| (c.ends[0], c.errors[0]));
        let exits = crossings.iter().map(|c| (c.ends[1], c.errors[1]));
        let nearer = |a: (f64, f64), b: (f64, f64)| if b.0 < a.0 { b } else { a };
        let farther = |a: (f64, f64), b: (f64, f64)| if b.0 > a.0 { b } else { a };
        let mut start = entries.clone().reduce(nearer)?;
        let mut end = exits.clone().reduce(farther)?;
        for (side, place) in [&mut start, &mut end].into_iter().enumerate() {
            if place.0 == part[side] {
                place.1 = end_errors[side];
            }
            place.1 += f64::EPSILON * place.0.abs();
        }
        let mut faces: Vec<(f64, f64)> = entries.chain(exits).collect();
        faces.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        let mut places = Vec::new();
        distinct_places([start, end], faces.clone(), &mut places);
        let error_at = |at: f64| {
            let same = faces.partition_point(|f| f.0 < at)..faces.partition_point(|f| f.0 <= at);
            let own = if at == start.0 { start.1.max(end_errors[0]) } else { 0.0 };
            own.max(largest(faces[same].iter().map(|f| f.1)))
        };
        let breaks: Vec<(f64, f64)> =
            places.iter().map(|&at| (at, if at == end.0 { end.1 } else { error_at(at) })).collect();

        let mut made = Self {
            mesh,
            gradients: if gradients { mesh.gradients() } else { None },
            crossings,
            breaks,
            pieces: Vec::new(),
            offset: ray.offset,
        };
        made.fill_pieces();
        Some(made)
    }

    /// Finds the cell of every piece: of several, the one that holds its middle deepest.
    fn fill_pieces(&mut self) {
        let middles: Vec<f64> = self.breaks.windows(2).map(|w| 0.5 * (w[0].0 + w[1].0)).collect();
        let mut pieces = vec![Piece { crossing: VACUUM, depth: f64::NEG_INFINITY, unsure: 0.0 }; middles.len()];
        for (number, crossing) in self.crossings.iter().enumerate() {
            let first = middles.partition_point(|&m| m <= crossing.ends[0]);
            for (middle, piece) in middles[first..].iter().zip(&mut pieces[first..]) {
                if *middle >= crossing.ends[1] {
                    break;
                }
                let depth = crossing.depth(*middle);
                if piece.crossing != VACUUM {
                    piece.unsure = piece.unsure.max(self.difference(crossing, piece.crossing, *middle));
                }
                if depth > piece.depth {
                    (piece.crossing, piece.depth) = (number as u32, depth);
                }
            }
        }
        // A misplaced face gives a stretch of one cell to its neighbour, which goes on with its own slope.
        for i in 1..pieces.len() {
            let [before, behind] = [pieces[i - 1].crossing, pieces[i].crossing];
            if before != VACUUM && behind != VACUUM {
                let slope = |crossing: u32| {
                    let crossing = &self.crossings[crossing as usize];
                    crossing.slope(self.mesh.corner_values(crossing.cell as usize)).abs()
                };
                let unsure = self.breaks[i].1 * (slope(before) + slope(behind));
                for piece in &mut pieces[i - 1..=i] {
                    piece.unsure = piece.unsure.max(unsure);
                }
            }
        }
        self.pieces = pieces;
    }

    /// Difference of the values of two crossings at a place.
    fn difference(&self, a: &CellCrossing, b: u32, at: f64) -> f64 {
        let value = |c: &CellCrossing| c.interpolated(self.mesh.corner_values(c.cell as usize), [at; 2]).0[0];
        (value(a) - value(&self.crossings[b as usize])).abs()
    }

    /// True if there is vacuum on one side of a break, at least.
    fn borders_vacuum(&self, at: usize) -> bool {
        let empty = |piece: Option<&Piece>| piece.is_none_or(|p| p.crossing == VACUUM);
        empty(at.checked_sub(1).and_then(|i| self.pieces.get(i))) || empty(self.pieces.get(at))
    }
}

impl FieldLine for CellLine<'_> {
    fn chord(&self) -> Chord {
        Chord { start: self.breaks[0].0, end: self.breaks[self.breaks.len() - 1].0, offset: self.offset }
    }

    /// Appends the places at which the ray comes out of vacuum: faces are far too many to name.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        let empty = |i: usize| self.pieces[i].crossing == VACUUM;
        let entries = (0..self.pieces.len()).filter(|&i| !empty(i) && (i == 0 || empty(i - 1)));
        out.extend(entries.map(|i| (self.breaks[i].0, Cut::Entry)));
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        out.extend(self.breaks.iter().map(|b| b.0));
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let middle = 0.5 * (from + to);
        let piece = self.breaks.partition_point(|b| b.0 <= middle).clamp(1, self.pieces.len()) - 1;
        let Piece { crossing, unsure, .. } = self.pieces[piece];
        let crossing = self.crossings.get(crossing as usize)?;
        let cell = crossing.cell as usize;
        let along = |corners: [f64; 4]| {
            let ([a, b], error) = crossing.interpolated(corners, [from, to]);
            let line = if a == b { Poly::constant(a) } else { Poly::new(&[0.5 * (a + b), 0.5 * (b - a)]) };
            (line, error)
        };
        let (field, error) = along(self.mesh.corner_values(cell));
        let gradient = self.gradients.map(|gradients| {
            let at = self.mesh.cells()[cell].map(|v| gradients[v as usize]);
            [0, 1, 2].map(|axis| along(at.map(|g| g[axis])))
        });
        Some(LineModel {
            field,
            field_error: (Bound::new(error) + unsure).value(),
            gradient: gradient.map(|g| g.map(|component| component.0)),
            gradient_error: gradient.map_or(0.0, |g| largest(g.map(|component| component.1))),
            limits: None,
            certain: true,
        })
    }

    fn misplaced(&self, at: f64) -> f64 {
        let place = self.breaks.partition_point(|b| b.0 < at);
        let jumps = || matches!(self.mesh.values(), CellValues::Cells(_)) || self.borders_vacuum(place);
        match self.breaks.get(place) {
            Some(&(found, error)) if found == at && jumps() => error,
            _ => 0.0,
        }
    }
}
