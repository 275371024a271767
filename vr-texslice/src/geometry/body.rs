//! Rest of a volume's box under a clip: a convex body, and the cuts of slices through it.

use glam::{DVec2, DVec3};
use vr_core::{Clip, Placement};

use super::polygon::{HalfSpace, Polygon, crossing};

/// A convex body in the world, by its faces.
#[derive(Clone, Debug)]
pub struct Body {
    faces: Vec<Polygon>,
}

/// The two ends of each edge of a box, as numbers of corners: bit a of a number is the side along axis a.
const EDGES: [[usize; 2]; 12] =
    [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];

/// The corners of each face of a box, in order around it.
const FACES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];

/// The eight corners of a box of cells, from index `low` to `high`, in the world.
pub fn box_corners(placement: &Placement, low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|c| {
        let pick = |axis: usize| if c >> axis & 1 == 1 { high[axis] } else { low[axis] };
        placement.to_world(DVec3::new(pick(0), pick(1), pick(2)))
    })
}

/// The polygon in which a plane, normal·x = offset, cuts a box: three to six corners on its edges, counter-clockwise seen from where the normal
/// points to; none where it misses it, or only touches it.
///
/// A point on an edge is computed from the two ends in an order of their own, so boxes that share an edge are cut at the same bits of it.
pub fn slice_of_box(corners: &[DVec3; 8], plane: &HalfSpace) -> Polygon {
    let side = |c: usize| plane.normal.dot(corners[c]) >= plane.offset;
    let cut = EDGES.iter().filter(|[a, b]| side(*a) != side(*b));
    let points: Vec<DVec3> = cut.map(|&[a, b]| crossing(plane, corners[a], corners[b])).collect();
    around(points, plane.normal)
}

/// Points of a convex polygon in order, counter-clockwise seen from where the normal points to. Points that coincide are one.
fn around(mut points: Vec<DVec3>, normal: DVec3) -> Polygon {
    let count = points.len();
    if count < 3 {
        return Polygon::default();
    }
    let centre = points.iter().sum::<DVec3>() / count as f64;
    let right = normal.normalize().any_orthonormal_vector();
    let up = normal.normalize().cross(right);
    // A number that grows with the angle: no arc tangent needed.
    let turn = |p: &DVec3| {
        let d = *p - centre;
        let (x, y) = (d.dot(right), d.dot(up));
        let part = y / (x.abs() + y.abs()).max(f64::MIN_POSITIVE);
        if x >= 0.0 { part } else { 2.0 - part }
    };
    points.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
    points.dedup();
    if points.len() > 1 && points[0] == points[points.len() - 1] {
        points.pop();
    }
    if points.len() < 3 { Polygon::default() } else { Polygon { corners: points } }
}

impl Body {
    /// Cuts a box by a clip.
    pub fn new(corners: &[DVec3; 8], clip: &Clip) -> Self {
        let mut faces: Vec<Polygon> =
            FACES.iter().map(|f| Polygon { corners: f.iter().map(|&c| corners[c]).collect() }).collect();
        for half in half_spaces(clip) {
            // The new face: between the points at which the old ones are cut.
            let mut rim = Vec::new();
            for face in &faces {
                let n = face.corners.len();
                for i in 0..n {
                    let (a, b) = (face.corners[i], face.corners[(i + 1) % n]);
                    let inside = |p: DVec3| half.normal.dot(p) >= half.offset;
                    if inside(a) != inside(b) {
                        rim.push(crossing(&half, a, b));
                    }
                }
            }
            faces = faces.iter().map(|f| f.clipped(&half)).filter(|f| f.corners.len() > 2).collect();
            let lid = around(rim, half.normal);
            if lid.corners.len() > 2 {
                faces.push(lid);
            }
        }
        Self { faces }
    }

    /// The corners of the part between two parallel planes, normal·x from `low` to `high`: each at least once.
    pub fn slab(&self, normal: DVec3, low: f64, high: f64) -> Vec<DVec3> {
        let sides = [HalfSpace { normal, offset: low }, HalfSpace { normal: -normal, offset: -high }];
        let part = |face: &Polygon| sides.iter().fold(face.clone(), |f, side| f.clipped(side));
        self.faces.iter().flat_map(|face| part(face).corners).collect()
    }
}

/// The half spaces that a clip keeps.
fn half_spaces(clip: &Clip) -> Vec<HalfSpace> {
    let mut all: Vec<HalfSpace> =
        clip.planes.iter().map(|p| HalfSpace { normal: p.normal, offset: p.offset }).collect();
    if let Some((low, high)) = clip.crop {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            all.push(HalfSpace { normal: axis, offset: axis.dot(low) });
            all.push(HalfSpace { normal: -axis, offset: -axis.dot(high) });
        }
    }
    all
}

/// The convex hull of points of the image, counter-clockwise where y grows downwards from the top (so clockwise on a sheet of paper): Andrew 1979,
/// "Another efficient algorithm for convex hulls in two dimensions".
pub fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return Vec::new();
    }
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    if hull.len() < 3 { Vec::new() } else { hull }
}
