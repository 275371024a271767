//! Convex polygons in space: cut by half spaces, measured, triangulated.

use glam::DVec3;

/// Keeps normal·x ≥ offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace {
    /// Points into what is kept; any length.
    pub normal: DVec3,
    /// Smallest value of normal·x that is kept.
    pub offset: f64,
}

impl HalfSpace {
    /// The same half space for points given from another origin.
    #[must_use]
    pub fn seen_from(&self, origin: DVec3) -> Self {
        Self { normal: self.normal, offset: self.offset - self.normal.dot(origin) }
    }

    /// Its boundary moved outwards by a distance.
    #[must_use]
    pub fn loosened(&self, by: f64) -> Self {
        Self { normal: self.normal, offset: self.offset - by * self.normal.length() }
    }

    /// Distance of a point from the boundary, positive inside, times the normal's length.
    fn depth(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// A convex polygon: its corners in order. Fewer than three enclose nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Polygon {
    /// The corners, counter-clockwise seen against the direction in which its maker looked.
    pub corners: Vec<DVec3>,
}

impl Polygon {
    /// Part of it that lies in a half space (Sutherland & Hodgman 1974, "Reentrant polygon clipping").
    ///
    /// The crossing of an edge with the boundary is computed from the corner inside to that outside, so polygons that share an edge are cut at the
    /// same point of it only if both walk it from the same side; [`crossing`] is what makes it so: it sorts the ends.
    #[must_use]
    pub fn clipped(&self, half: &HalfSpace) -> Self {
        let n = self.corners.len();
        let mut corners = Vec::with_capacity(n + 1);
        for i in 0..n {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % n]);
            let (da, db) = (half.depth(a), half.depth(b));
            if da >= 0.0 {
                corners.push(a);
            }
            // An end on the boundary is its own crossing.
            if (da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0) {
                corners.push(crossing(half, a, b));
            }
        }
        Self { corners }
    }

    /// ½ Σ cᵢ × cᵢ₊₁ relative to the first corner: as long as the area is large, along the normal of a counter-clockwise polygon.
    pub fn area_vector(&self) -> DVec3 {
        let origin = self.corners.first().copied().unwrap_or_default();
        self.corners.windows(2).map(|pair| 0.5 * (pair[0] - origin).cross(pair[1] - origin)).sum()
    }

    /// A fan of triangles about the first corner, each in the order of the polygon.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let first = self.corners.first().copied();
        self.corners.windows(2).skip(1).filter_map(move |pair| first.map(|f| [f, pair[0], pair[1]]))
    }
}

/// Intersection of a boundary with the edge between two points on either side of it: the same bits, whichever of them is named first.
pub fn crossing(boundary: &HalfSpace, a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = if a.to_array() <= b.to_array() { (a, b) } else { (b, a) };
    let (da, db) = (boundary.depth(a), boundary.depth(b));
    let t = da / (da - db);
    a + t * (b - a)
}
