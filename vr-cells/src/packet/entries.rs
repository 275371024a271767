//! Sides of the mesh by which the rays of a tile enter it.

use vr_core::CellMesh;
use vr_core::cells::FACES;

use super::projected::{Projected, ScreenVertex};
use crate::entries::SurfaceFace;

/// A ray's place on the screen: x and y in pixels from the middle, and what they lack.
pub(crate) type Place = [f32; 4];

/// A side by which a ray enters.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Number of the ray in its tile.
    pub(crate) ray: u32,
    pub(crate) depth: f64,
    pub(crate) face: SurfaceFace,
}

/// A side that a ray goes through: x and y of its corners, the vertices that they are, and the barycentric coordinates of the ray's place on it.
pub(crate) struct Gate {
    pub(crate) corners: [[f32; 2]; 3],
    pub(crate) names: [u32; 3],
    pub(crate) weights: [f32; 3],
}

impl Gate {
    /// The side of a cell as a ray sees it; `None` if the ray does not enter through it.
    ///
    /// The same sums and products as in [`super::march`], so that no ray falls between two sides.
    #[inline]
    pub(crate) fn new(mesh: &CellMesh, projected: &Projected, face: SurfaceFace, ray: &Place) -> Option<Self> {
        let cell = mesh.cells()[face.cell as usize];
        let names = FACES[usize::from(face.across)].map(|i| cell[i]);
        let corners = names.map(|vertex| {
            let ScreenVertex { place, depth_value: [depth, ..] } = projected.vertices[vertex as usize];
            let scale = depth * projected.widening + 1.0;
            [0, 1].map(|a| ((place[a] - ray[a]) + (place[a + 2] - ray[a + 2])) * scale)
        });
        let side = |a: usize, b: usize| corners[a][0] * corners[b][1] - corners[a][1] * corners[b][0];
        let weights = [side(1, 2), side(2, 0), side(0, 1)];
        let inside = weights.iter().all(|&w| w >= 0.0) && weights.iter().any(|&w| w > 0.0);
        inside.then_some(Self { corners, names, weights })
    }

    /// Interpolates a value of the corners at the ray's place.
    pub(crate) fn at_place(&self, of_corners: [f64; 3]) -> f64 {
        let ([a, b, c], [u, v, w]) = (of_corners, self.weights.map(f64::from));
        (a * u + b * v + c * w) / (u + v + w)
    }

    /// Depth and value of the ray's place.
    pub(crate) fn depth_value(&self, projected: &Projected) -> [f64; 2] {
        let of_corners = self.names.map(|name| projected.vertices[name as usize].depth_value());
        [0, 1].map(|i| self.at_place(of_corners.map(|corner| corner[i])))
    }
}

/// The rays of a tile: rows of places, ascending on both axes of the picture.
pub(crate) struct Grid<'a> {
    pub(crate) places: &'a [Place],
    /// Rays in a row.
    pub(crate) across: usize,
    /// x of the first ray and y of the first row in pixels from the middle, and the distance to the next.
    pub(crate) first: [f64; 2],
    pub(crate) spacing: f64,
}

impl Grid<'_> {
    /// Appends where the rays of the grid enter by a face.
    pub(crate) fn enter(&self, mesh: &CellMesh, projected: &Projected, face: SurfaceFace, out: &mut Vec<Entry>) {
        let cell = mesh.cells()[face.cell as usize];
        let corners = FACES[usize::from(face.across)].map(|i| {
            let place = projected.vertices[cell[i] as usize].place;
            [0, 1].map(|a| f64::from(place[a]) + f64::from(place[a + 2]))
        });
        // Faces that turn away are no entries; rounding does not turn one that is wider than this.
        let [a, b, c] = corners;
        let (ab, ac) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
        let (area, size) = (ab[0] * ac[1] - ab[1] * ac[0], ab[0].abs().max(ab[1].abs()) * ac[0].abs().max(ac[1].abs()));
        if area < -1e-5 * size {
            return;
        }
        // The rays in the box around it, with one to spare. Rows go down the picture, where y falls.
        let rows = self.places.len() / self.across;
        let range = |axis: usize, sign: f64, count: usize| {
            let place = |x: f64| sign * (x - self.first[axis]) / self.spacing;
            let ends = corners.map(|c| place(c[axis]));
            let (low, high) = (ends[0].min(ends[1]).min(ends[2]), ends[0].max(ends[1]).max(ends[2]));
            (low - 1.0).clamp(0.0, count as f64) as usize..(high + 2.0).clamp(0.0, count as f64) as usize
        };
        let columns = range(0, 1.0, self.across);
        for y in range(1, -1.0, rows) {
            for x in columns.clone() {
                let ray = y * self.across + x;
                if let Some(gate) = Gate::new(mesh, projected, face, &self.places[ray]) {
                    out.push(Entry { ray: ray as u32, depth: gate.depth_value(projected)[0], face });
                }
            }
        }
    }
}
