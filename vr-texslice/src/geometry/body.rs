//! Rest of a volume's box under a clip: a convex body, and the cuts of slices through it.

use glam::DVec3;
use vr_core::{Clip, Placement};

use super::polygon::{HalfSpace, Polygon, crossing};

/// A convex body in the world, by its faces.
#[derive(Clone, Debug)]
pub struct Body {
    faces: Vec<Polygon>,
}

/// The corners of each face of a box, in order around it.
const FACES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];

/// The eight corners of a box of cells, from index `low` to `high`, in the world.
pub fn box_corners(placement: &Placement, low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|c| {
        let pick = |axis: usize| if c >> axis & 1 == 1 { high[axis] } else { low[axis] };
        placement.to_world(DVec3::new(pick(0), pick(1), pick(2)))
    })
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
    /// Cuts a box by half spaces.
    pub fn new(corners: &[DVec3; 8], sides: impl IntoIterator<Item = HalfSpace>) -> Self {
        let faces = FACES.iter().map(|f| Polygon { corners: f.iter().map(|&c| corners[c]).collect() }).collect();
        sides.into_iter().fold(Self { faces }, |body, half| body.cut(&half))
    }

    /// The part of it in a half space: its faces, cut, and the slice of its boundary.
    #[must_use]
    pub fn cut(&self, half: &HalfSpace) -> Self {
        let mut faces: Vec<Polygon> =
            self.faces.iter().map(|f| f.clipped(half)).filter(|f| f.corners.len() > 2).collect();
        let lid = self.slice(half);
        if lid.corners.len() > 2 {
            faces.push(lid);
        }
        Self { faces }
    }

    /// The polygon in which a plane, normal·x = offset, cuts it: counter-clockwise seen from where the normal points to; of a box, three to six corners
    /// on its edges. None where the plane misses the body, or only touches it.
    ///
    /// A point on an edge is computed from the two ends in an order of their own, so bodies that share an edge are cut at the same bits of it.
    pub fn slice(&self, plane: &HalfSpace) -> Polygon {
        let inside = |p: DVec3| plane.normal.dot(p) >= plane.offset;
        let cut = |face: &Polygon| {
            let next = face.corners.iter().cycle().skip(1);
            let edges = face.corners.iter().zip(next).filter(|(a, b)| inside(**a) != inside(**b));
            edges.map(|(a, b)| crossing(plane, *a, *b)).collect::<Vec<_>>()
        };
        around(self.faces.iter().flat_map(cut).collect(), plane.normal)
    }

    /// Its faces: convex, in no order of their own, each walked in either direction. None: nothing is left of it.
    pub fn faces(&self) -> &[Polygon] {
        &self.faces
    }

    /// The corners of its faces: each corner at least once.
    pub fn corners(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.faces.iter().flat_map(|face| face.corners.iter().copied())
    }
}

/// The half spaces that a clip keeps.
pub fn half_spaces(clip: &Clip) -> Vec<HalfSpace> {
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
