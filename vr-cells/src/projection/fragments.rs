//! Fragments of cells along one ray, in order: every operator, in f64.

use std::ops::ControlFlow;

use vr_core::CellMesh;
use vr_core::cells::CellValues;

use crate::camera_space::{Axis, CameraVertex};
use crate::walk::Part;

use super::bins::Bins;
use super::crossing::crossing;

/// A mesh in a view, cell by cell.
pub(super) struct Fragments<'a, const N: usize> {
    pub(super) mesh: &'a CellMesh,
    pub(super) vertices: &'a [CameraVertex<N>],
    pub(super) bins: &'a Bins,
    /// A length far below what matters.
    pub(super) nudge: f64,
}

impl<const N: usize> Fragments<'_, N> {
    /// Calls `take` with every part of a ray inside a cell between two distances, in order.
    ///
    /// Parts are sorted along each ray: cells that cannot be sorted as wholes, because they overlap in a ring, need nothing else.
    pub(super) fn along(
        &self,
        axis: &Axis,
        at: [f64; 2],
        [from, to]: [f64; 2],
        found: &mut Vec<Part<N>>,
        take: &mut dyn FnMut(&Part<N>) -> ControlFlow<()>,
    ) {
        found.clear();
        let of_cells = match self.mesh.values() {
            CellValues::Cells(values) => Some(values),
            CellValues::Vertices(_) => None,
        };
        for cell in self.bins.near(at) {
            let names = self.mesh.cells()[cell as usize];
            let Some(mut part) = crossing(axis, names, self.vertices, self.nudge) else { continue };
            if let Some(values) = of_cells {
                part.at.iter_mut().for_each(|at| at[0] = values[cell as usize]);
            }
            found.push(part);
        }
        // By their middles: two that meet in a face differ there by more than rounding.
        let middle = |part: &Part<N>| part.ends[0] + part.ends[1];
        found.sort_unstable_by(|a, b| middle(a).total_cmp(&middle(b)));
        let mut reached = from;
        for &part in found.iter() {
            if let Some(part) = part.within([reached, to]) {
                reached = part.ends[1];
                if take(&part).is_break() {
                    return;
                }
            }
        }
    }
}
