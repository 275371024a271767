//! A cell's projection: its outline, the place where it is thickest, and what is linear between (Shirley & Tuchman 1990).
//!
//! Every cell whose projection has an area falls into one of two cases. Either one of its faces covers all of the projection, and the vertex across from that
//! face is the apex (a triangle: classes 1 and, if faces are seen from their edges, 3 and 4), or two faces are seen from the front and two from behind, and
//! the apex is where the edge between the first two crosses that between the others (a quadrilateral: class 2). From the apex, thickness falls to 0 at the outline,
//! linearly in each of the triangles between; their minimum is taken, which needs no decision about the triangle.

use vr_core::cells::FACES;

use super::line::Line;
use super::screen_mesh::{Facing, ScreenVertex, area};

/// An edge of the outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimEdge {
    /// Positive inside.
    pub(super) line: Line,
    /// The part of the thickness at the apex that is there, as far as this edge goes: `line · scale + bias`.
    pub(super) scale: f64,
    pub(super) bias: f64,
    /// Corners of the cell at its ends.
    pub(super) ends: [usize; 2],
}

/// The face that is seen from the front, or from behind, as a linear function of the place; with a kink at an edge in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surface {
    pub(super) depth: Line,
    pub(super) value: Line,
    /// A function that is 0 at the kink and 1 at the farthest place behind it, by which, where positive, depth and value change.
    pub(super) kink: Option<(Line, [f64; 2])>,
}

/// A cell's projection.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    /// Three or four edges.
    pub(super) edges: [RimEdge; 4],
    pub(super) count: usize,
    /// The side that is a plane, or nearly: the front if `base_is_front`.
    pub(super) base: Surface,
    pub(super) base_is_front: bool,
    /// Depth and value of the other side less those of the base, at the apex.
    pub(super) rise: [f64; 2],
    /// Place of the apex.
    pub(super) apex: [f64; 2],
}

/// Depth and value, mixed.
fn mixed(a: &ScreenVertex, b: &ScreenVertex, t: f64) -> [f64; 2] {
    [a.depth + (b.depth - a.depth) * t, a.value + (b.value - a.value) * t]
}

impl Outline {
    /// The projection of a cell; `None` if it has no area.
    pub(super) fn new(corners: &[ScreenVertex; 4], facing: Facing) -> Option<Self> {
        let fronts: [bool; 4] = std::array::from_fn(|i| facing.is_front(i));
        let backs: [bool; 4] = std::array::from_fn(|i| facing.is_back(i));
        let count = |faces: &[bool; 4]| faces.iter().filter(|&&f| f).count();
        match (count(&fronts), count(&backs)) {
            (0, _) | (_, 0) => None,
            (1, _) => Self::of_face(corners, fronts.iter().position(|&f| f)?, true),
            (_, 1) => Self::of_face(corners, backs.iter().position(|&f| f)?, false),
            _ => Self::of_edges(corners, fronts),
        }
    }

    /// One face covers the projection; the vertex across is the apex.
    fn of_face(corners: &[ScreenVertex; 4], face: usize, base_is_front: bool) -> Option<Self> {
        let mut names = FACES[face];
        // Counterclockwise from outside is clockwise on a screen whose y goes down.
        if !base_is_front {
            names.swap(1, 2);
        }
        names.swap(1, 2);
        let at = names.map(|i| corners[i].at);
        let tip = &corners[face];
        let twice_area = area(at);
        if twice_area <= 0.0 {
            return None;
        }
        let plane = |values: [f64; 3]| Line::through(at, values, twice_area);
        let depth = plane(names.map(|i| corners[i].depth));
        let value = plane(names.map(|i| corners[i].value));
        let edge = |k: usize| {
            let (i, j) = (k, (k + 1) % 3);
            let line = Line::edge(at[i], at[j]);
            let height = area([at[i], at[j], tip.at]);
            // Beside a face that is seen from its edge, the cell is as thick as it is up to there.
            let (scale, bias) = if height > 0.0 { (1.0 / height, 0.0) } else { (0.0, 1.0) };
            RimEdge { line, scale, bias, ends: [names[i], names[j]] }
        };
        let edges = [edge(0), edge(1), edge(2), edge(2)];
        let rise = [tip.depth - depth.at(tip.at), tip.value - value.at(tip.at)];
        let base = Surface { depth, value, kink: None };
        Some(Self { edges, count: 3, base, base_is_front, rise, apex: tip.at })
    }

    /// Two faces are seen from the front: their common edge crosses that of the others.
    fn of_edges(corners: &[ScreenVertex; 4], fronts: [bool; 4]) -> Option<Self> {
        // A face seen from the front is across from an end of the edge behind.
        let mut behind = [0; 2];
        let mut before = [0; 2];
        let (mut b, mut f) = (0, 0);
        for i in 0..4 {
            if fronts[i] {
                behind[b] = i;
                b += 1;
            } else {
                before[f] = i;
                f += 1;
            }
        }
        let at = |i: usize| corners[i].at;
        let [first, last] = before;
        if area([at(first), at(behind[0]), at(last)]) < 0.0 {
            behind.swap(0, 1);
        }
        let [u, v] = behind;
        let (at_u, at_v) = (area([at(first), at(u), at(last)]), area([at(last), at(v), at(first)]));
        let (at_first, at_last) = (area([at(u), at(v), at(first)]).abs(), area([at(u), at(v), at(last)]).abs());
        if [at_u, at_v, at_first, at_last].into_iter().any(|area| area <= 0.0) {
            return None;
        }
        let along = at_first / (at_first + at_last);
        let across = at_u / (at_u + at_v);
        let front = mixed(&corners[first], &corners[last], along);
        let back = mixed(&corners[u], &corners[v], across);
        let edge = |i: usize, j: usize, height: f64| RimEdge {
            line: Line::edge(at(i), at(j)),
            scale: 1.0 / height,
            bias: 0.0,
            ends: [i, j],
        };
        let edges = [
            edge(first, u, along * at_u),
            edge(u, last, (1.0 - along) * at_u),
            edge(last, v, (1.0 - along) * at_v),
            edge(v, first, along * at_v),
        ];
        // The wider face in front is the base; the narrow one is what it has more behind their common edge.
        let (wide, narrow, names) =
            if at_u >= at_v { (at_u, v, [first, u, last]) } else { (at_v, u, [last, v, first]) };
        let plane = |values: [f64; 3]| Line::through(names.map(at), values, wide);
        let depth = plane(names.map(|i| corners[i].depth));
        let value = plane(names.map(|i| corners[i].value));
        let tip = &corners[narrow];
        let kink = Line::edge(at(names[0]), at(names[2])).scaled(1.0 / at_u.min(at_v));
        let more = [tip.depth - depth.at(tip.at), tip.value - value.at(tip.at)];
        let base = Surface { depth, value, kink: Some((kink, more)) };
        let apex = [0, 1].map(|a| at(first)[a] + (at(last)[a] - at(first)[a]) * along);
        Some(Self { edges, count: 4, base, base_is_front: true, rise: [back[0] - front[0], back[1] - front[1]], apex })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Facing of a cell by the areas of its faces.
    fn facing(corners: &[ScreenVertex; 4]) -> Facing {
        let mut bits = 0;
        for (i, face) in FACES.iter().enumerate() {
            let outward = -area(face.map(|k| corners[k].at));
            bits |= u8::from(outward > 0.0) << i | u8::from(outward < 0.0) << (i + 4);
        }
        Facing(bits)
    }

    /// Thickness at a place: between the farthest face in front and the nearest behind.
    fn thickness(corners: &[ScreenVertex; 4], facing: Facing, at: [f64; 2]) -> f64 {
        let (mut near, mut far) = (f64::NEG_INFINITY, f64::INFINITY);
        for (i, face) in FACES.iter().enumerate() {
            let places = face.map(|k| corners[k].at);
            if area(places) == 0.0 {
                continue;
            }
            let depth = Line::through(places, face.map(|k| corners[k].depth), area(places)).at(at);
            if facing.is_front(i) {
                near = near.max(depth);
            } else {
                far = far.min(depth);
            }
        }
        far - near
    }

    #[test]
    fn thickness_is_that_between_the_faces() {
        let mut state = 7u64;
        let mut random = |steps: f64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 40) as f64 / (1u64 << 24) as f64 * steps).floor() / steps
        };
        let mut classes = [0; 5];
        // On a coarse lattice vertices fall on edges and on each other.
        for steps in [1e6, 8.0, 4.0] {
            for _ in 0..400 {
                let mut corners = [(); 4].map(|()| ScreenVertex {
                    at: [random(steps) * 16.0, random(steps) * 16.0],
                    depth: random(steps) * 16.0,
                    value: random(steps),
                });
                let solid = |c: &[ScreenVertex; 4]| {
                    let d = |i: usize| {
                        glam::DVec3::new(c[i].at[0] - c[0].at[0], c[0].at[1] - c[i].at[1], c[i].depth - c[0].depth)
                    };
                    d(1).cross(d(2)).dot(d(3))
                };
                // Right, up and ahead are left-handed.
                if solid(&corners) > 0.0 {
                    corners.swap(2, 3);
                }
                if solid(&corners) == 0.0 {
                    continue;
                }
                let facing = facing(&corners);
                let Some(outline) = Outline::new(&corners, facing) else { continue };
                classes[outline.count] += 1;
                for _ in 0..50 {
                    let at = [random(1e6) * 16.0, random(1e6) * 16.0];
                    let edges = &outline.edges[..outline.count];
                    let is_inside = edges.iter().all(|e| e.line.is_positive(e.line.at(at)));
                    let share = edges.iter().map(|e| e.line.at(at) * e.scale + e.bias).fold(f64::INFINITY, f64::min);
                    let found = outline.rise[0].abs() * share;
                    let expected = thickness(&corners, facing, at);
                    if is_inside {
                        assert!((found - expected).abs() < 1e-9, "{corners:?} at {at:?}: {found} for {expected}");
                        let mut depth = outline.base.depth.at(at);
                        if let Some((kink, more)) = outline.base.kink {
                            depth += kink.at(at).max(0.0) * more[0];
                        }
                        let other = depth + outline.rise[0] * share;
                        assert_eq!(depth <= other, outline.base_is_front, "{corners:?} at {at:?}");
                    }
                }
            }
        }
        assert!(classes[3] > 300 && classes[4] > 200, "{classes:?}");
    }
}
