//! A ray through one cell, by itself.

use vr_core::cells::FACES;

use crate::camera_space::{Axis, CameraVertex, ShearedVertex, side};
use crate::walk::Part;

/// True if the edge from `a` to `b` goes around the axis counterclockwise. If the axis meets it, the axis is taken to lie a little to the right, and less
/// above; if that does not tell, because both vertices are in one place, their numbers do. Swapping the vertices turns the answer, so that of the cells around
/// an edge each ray has one, and no ray is lost between them.
#[inline(always)]
fn goes_around<const N: usize>(
    side: f64,
    (a, b): (&ShearedVertex<N>, &ShearedVertex<N>),
    (name_a, name_b): (u32, u32),
) -> bool {
    if side != 0.0 {
        return side > 0.0;
    }
    let (right, above) = (a.y - b.y, b.x - a.x);
    if right != 0.0 {
        return right > 0.0;
    }
    if above != 0.0 { above > 0.0 } else { name_a < name_b }
}

/// Number of the edge between two corners of a cell.
const EDGE: [[usize; 4]; 4] = [[0, 0, 1, 2], [0, 0, 3, 4], [1, 3, 0, 5], [2, 4, 5, 0]];
/// Corners of each edge.
const ENDS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Returns the part of a ray inside a cell; `None` where it does not meet it.
#[inline]
pub(super) fn crossing<const N: usize>(
    axis: &Axis,
    names: [u32; 4],
    vertices: &[CameraVertex<N>],
    nudge: f64,
) -> Option<Part<N>> {
    let mut moved = *axis;
    for tries in 1..=4 {
        match attempt(&moved, names, vertices) {
            [None, None] => return None,
            [Some((near, near_at)), Some((far, far_at))] => {
                let ends = [near, far].map(|depth| depth * axis.length);
                return (ends[0] < ends[1]).then_some(Part { ends, at: [near_at, far_at] });
            }
            // Rounding has the ray enter and not leave: it is aside by less than that of the cell.
            _ => moved = axis.nudged([nudge * f64::from(tries), -0.618 * nudge * f64::from(tries)]),
        }
    }
    None
}

/// A depth, and the attributes there.
type Place<const N: usize> = (f64, [f64; N]);

/// The places at which a ray enters a cell and leaves it.
#[inline(always)]
fn attempt<const N: usize>(axis: &Axis, names: [u32; 4], vertices: &[CameraVertex<N>]) -> [Option<Place<N>>; 2] {
    let corners = names.map(|v| axis.shear(&vertices[v as usize]));
    let sides = ENDS.map(|[i, j]| side(&corners[i], &corners[j]));
    let around: [bool; 6] = std::array::from_fn(|e| {
        let [i, j] = ENDS[e];
        goes_around(sides[e], (&corners[i], &corners[j]), (names[i], names[j]))
    });
    let mut found = [None, None];
    for [i, j, k] in FACES {
        let directed = |a: usize, b: usize| around[EDGE[a][b]] == (a < b);
        let turn = directed(i, j);
        if directed(j, k) != turn || directed(k, i) != turn {
            continue;
        }
        // Counterclockwise from outside: the ray comes in.
        let weights = [EDGE[j][k], EDGE[k][i], EDGE[i][j]].map(|e| sides[e].abs());
        let sum: f64 = weights.iter().sum();
        let [u, v, w] = if sum > 0.0 { weights.map(|w| w / sum) } else { [1.0 / 3.0; 3] };
        let [a, b, c] = [i, j, k].map(|n| &corners[n]);
        let depth = a.depth * u + b.depth * v + c.depth * w;
        let at = std::array::from_fn(|n| a.attributes[n] * u + b.attributes[n] * v + c.attributes[n] * w);
        found[usize::from(!turn)] = Some((depth, at));
    }
    found
}
