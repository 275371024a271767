//! The way of a ray from cell to cell.

use std::ops::ControlFlow;

use vr_core::CellMesh;
use vr_core::cells::{CellValues, FACES, NO_CELL};

use crate::camera_space::{Attributes, Axis, CameraVertex, ShearedVertex, goes_around, side};
use crate::entries::{Entries, SurfaceFace};

/// A part of a ray inside one cell: the distances of its ends along the ray, and the attributes at both.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part<const N: usize> {
    pub(crate) ends: [f64; 2],
    pub(crate) at: [Attributes<N>; 2],
}

impl<const N: usize> Part<N> {
    /// Attributes at a fraction of the way.
    pub(crate) fn mixed(&self, t: f64) -> Attributes<N> {
        let [a, b] = &self.at;
        std::array::from_fn(|i| a[i] + (b[i] - a[i]) * t)
    }

    /// The part of it between two distances; `None` if nothing is left.
    pub(crate) fn within(self, [from, to]: [f64; 2]) -> Option<Self> {
        let [start, end] = self.ends;
        if from <= start && end <= to {
            return (start < end).then_some(self);
        }
        let ends = [start.max(from), end.min(to)];
        let at = ends.map(|s| self.mixed(((s - start) / (end - start)).clamp(0.0, 1.0)));
        (ends[0] < ends[1]).then_some(Self { ends, at })
    }
}

/// A mesh in a view.
pub(crate) struct Walker<'a, const N: usize> {
    mesh: &'a CellMesh,
    vertices: &'a [CameraVertex<N>],
    entries: &'a Entries<'a>,
    /// A length far below what matters, by which a ray is moved aside that rounding keeps on the spot.
    nudge: f64,
}

/// A face that a ray goes through, counterclockwise around it.
struct Gate<const N: usize> {
    corners: [ShearedVertex<N>; 3],
    names: [u32; 3],
    /// Barycentric coordinates of the ray's place, not normalised.
    weights: [f64; 3],
}

impl<const N: usize> Gate<N> {
    /// Depth of the ray's place on the face, and the attributes there.
    #[inline(always)]
    fn place(&self) -> (f64, Attributes<N>) {
        let [a, b, c] = &self.corners;
        // Rounding may make one that should be 0 negative.
        let [u, v, w] = self.weights.map(|w| w.max(0.0));
        let sum = u + v + w;
        // A face seen from its edge has no place of its own.
        let [u, v, w] = if sum > 0.0 { [u / sum, v / sum, w / sum] } else { [1.0 / 3.0; 3] };
        let depth = a.depth * u + b.depth * v + c.depth * w;
        (depth, std::array::from_fn(|i| a.attributes[i] * u + b.attributes[i] * v + c.attributes[i] * w))
    }
}

/// Reason for which a ray is begun again, a little aside.
struct Stuck;

/// Steps without progress after which a ray counts as stuck: more cells than meet in a vertex.
const PATIENCE: u32 = 256;

impl<'a, const N: usize> Walker<'a, N> {
    pub(crate) fn new(mesh: &'a CellMesh, vertices: &'a [CameraVertex<N>], entries: &'a Entries<'a>) -> Self {
        Self { mesh, vertices, entries, nudge: 1e-10 * mesh.mean_spacing() }
    }

    /// Calls `take` with every part of a ray inside a cell between two distances, in order.
    pub(crate) fn walk(
        &self,
        axis: &Axis,
        [x, y]: [f64; 2],
        part: [f64; 2],
        found: &mut Vec<(f64, SurfaceFace)>,
        take: &mut dyn FnMut(&Part<N>) -> ControlFlow<()>,
    ) {
        // Where the ray enters, in order.
        found.clear();
        for face in self.entries.near(x, y) {
            if let Some(gate) = self.gate(axis, face) {
                found.push((gate.place().0, face));
            }
        }
        found.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut reached = f64::NEG_INFINITY;
        for &(depth, face) in found.iter() {
            // On an edge of the surface two faces are entered at once, and the first way has gone through what lies behind the second.
            let tolerance = 1e-12 * (depth.abs() + reached.abs());
            if depth < reached - tolerance {
                continue;
            }
            let mut tries = 0u32;
            let mut moved = *axis;
            loop {
                match self.run(&moved, face, part, &mut reached, take) {
                    Ok(ControlFlow::Continue(())) => break,
                    Ok(ControlFlow::Break(())) => return,
                    Err(Stuck) if tries < 4 => {
                        tries += 1;
                        let by = self.nudge * f64::from(tries);
                        moved = axis.nudged([by, -0.618 * by]);
                    }
                    Err(Stuck) => break,
                }
            }
        }
    }

    /// The face as a gate into the mesh; `None` where the ray does not enter through it.
    #[inline]
    fn gate(&self, axis: &Axis, face: SurfaceFace) -> Option<Gate<N>> {
        let cell = self.mesh.cells()[face.cell as usize];
        // Counterclockwise from outside, which is where the ray comes from.
        let names = FACES[usize::from(face.across)].map(|i| cell[i]);
        let corners = names.map(|v| axis.shear(&self.vertices[v as usize]));
        let [a, b, c] = &corners;
        let weights = [side(b, c), side(c, a), side(a, b)];
        let inside = (0..3).all(|i| {
            let [from, to] = [(i + 1) % 3, (i + 2) % 3];
            goes_around(weights[i], [&corners[from], &corners[to]], [names[from], names[to]])
        });
        inside.then_some(Gate { corners, names, weights })
    }

    /// Walks from an entry to the next face of the surface.
    fn run(
        &self,
        axis: &Axis,
        face: SurfaceFace,
        part: [f64; 2],
        reached: &mut f64,
        take: &mut dyn FnMut(&Part<N>) -> ControlFlow<()>,
    ) -> Result<ControlFlow<()>, Stuck> {
        let Some(mut gate) = self.gate(axis, face) else { return Ok(ControlFlow::Continue(())) };
        let (mut walked, mut at) = gate.place();
        let mut cell = face.cell as usize;
        let mut patience = PATIENCE;
        let of_cells = match self.mesh.values() {
            CellValues::Cells(values) => Some(values),
            CellValues::Vertices(_) => None,
        };
        loop {
            // The vertex across, and the sides on which its edges pass.
            let names = self.mesh.cells()[cell];
            let [a, b, c] = gate.names;
            let d = names[0] ^ names[1] ^ names[2] ^ names[3] ^ a ^ b ^ c;
            let tip = axis.shear(&self.vertices[d as usize]);
            let [pa, pb, pc] = gate.corners;
            let (to_a, to_b, to_c) = (side(&pa, &tip), side(&pb, &tip), side(&pc, &tip));
            let around = [
                goes_around(to_a, [&pa, &tip], [a, d]),
                goes_around(to_b, [&pb, &tip], [b, d]),
                goes_around(to_c, [&pc, &tip], [c, d]),
            ];
            // The face that is left by has the ray on the inner side of both of its new edges. The vertex that is not on it names the neighbour.
            let left;
            (gate, left) = if !around[0] && around[1] {
                (Gate { corners: [pa, pb, tip], names: [a, b, d], weights: [to_b, -to_a, gate.weights[2]] }, c)
            } else if !around[1] && around[2] {
                (Gate { corners: [pb, pc, tip], names: [b, c, d], weights: [to_c, -to_b, gate.weights[0]] }, a)
            } else {
                (Gate { corners: [pc, pa, tip], names: [c, a, d], weights: [to_a, -to_c, gate.weights[1]] }, b)
            };
            let (next_depth, next_at) = gate.place();
            // What a way that got stuck has taken already is not taken again.
            let taken = walked.max(*reached);
            if next_depth > taken {
                patience = PATIENCE;
                let mut here = Part { ends: [walked, next_depth].map(|depth| depth * axis.length), at: [at, next_at] };
                if let Some(values) = of_cells {
                    here.at[0][0] = values[cell];
                    here.at[1][0] = values[cell];
                }
                if here.ends[0] >= part[1] {
                    return Ok(ControlFlow::Break(()));
                }
                let open = [part[0].max(taken * axis.length), part[1]];
                (walked, at, *reached) = (next_depth, next_at, next_depth);
                if let Some(here) = here.within(open)
                    && take(&here).is_break()
                {
                    return Ok(ControlFlow::Break(()));
                }
            } else {
                patience = if next_depth > walked { PATIENCE } else { patience - 1 };
                (walked, at) = (walked.max(next_depth), next_at);
                if patience == 0 {
                    return Err(Stuck);
                }
            }
            let across = names.iter().position(|&v| v == left).unwrap_or(0);
            let next = self.mesh.neighbours()[cell][across];
            if next == NO_CELL {
                return Ok(ControlFlow::Continue(()));
            }
            cell = next as usize;
        }
    }
}
