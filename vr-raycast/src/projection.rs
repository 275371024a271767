//! Projection of boxes of the volume onto the picture.

use glam::DVec3;
use vr_core::{ParameterError, Placement, Projection as Kind, View};

/// Pixels along the edge of the tiles in which depths are kept: those of one packet of rays.
pub(crate) const TILE: u32 = 4;

/// Fraction of a cell's edge by which boxes are widened: more than a kernel's f32 positions can be off on grids of up to 2¹⁵ samples a side.
pub(crate) const MARGIN: f64 = 1.0 / 32.0;

/// An affine function of index space.
#[derive(Clone, Copy, Debug)]
struct Affine {
    at_zero: f64,
    per_step: DVec3,
}

impl Affine {
    fn at(&self, p: DVec3) -> f64 {
        self.at_zero + self.per_step.dot(p)
    }

    /// Returns the largest difference, over a box, from the value at the centre.
    fn reach(&self, half: DVec3) -> f64 {
        self.per_step.abs().dot(half)
    }

    fn minus(&self, factor: f64, other: &Self) -> Self {
        Self { at_zero: self.at_zero - factor * other.at_zero, per_step: self.per_step - factor * other.per_step }
    }
}

/// Projection from index space to the picture: pixel (x/w, y/w) at depth z along the view, all affine in the index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Projection {
    /// Functions of x, y, w and z.
    rows: [Affine; 4],
    /// Functions that are not negative inside the picture's right and bottom edge.
    far_edges: [Affine; 2],
    size: [u32; 2],
    rays: Rays,
}

/// Rays in index space.
#[derive(Clone, Copy, Debug)]
enum Rays {
    /// Rays parallel to a unit vector.
    Along(DVec3),
    /// Rays from a point.
    From(DVec3),
}

/// Largest component of a unit vector that may be rounding.
const PARALLEL: f64 = 1e-9;

/// Tiles of the picture that a box may cover, ends included, and the smallest depth along the view that it may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    pub(crate) low: [u32; 2],
    pub(crate) high: [u32; 2],
    pub(crate) depth: f64,
}

/// Boxes of one size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stencil {
    reach: [f64; 4],
    reach_to_far_edges: [f64; 2],
}

impl Projection {
    /// Returns the projection of a grid's index space in a view.
    ///
    /// # Errors
    /// Same as for [`vr_core::Camera::frame`].
    pub(crate) fn new(view: &View, placement: &Placement) -> Result<Self, ParameterError> {
        let frame = view.camera.frame()?;
        let eye = placement.origin() - view.camera.eye;
        // In world units per direction of the camera.
        let along = |axis: DVec3| Affine { at_zero: axis.dot(eye), per_step: placement.axes().transpose() * axis };
        let z = along(frame.z_axis);
        let [width, height] = view.size.map(f64::from);
        let (w, pixel) = match view.camera.projection {
            Kind::Orthographic { height: world } => (Affine { at_zero: 1.0, per_step: DVec3::ZERO }, world / height),
            Kind::Perspective { fov } => (z, 2.0 * libm::tan(0.5 * fov.to_radians()) / height),
        };
        let from_middle = |axis: DVec3, size: f64| along(axis / pixel).minus(-0.5 * size, &w);
        let (x, y) = (from_middle(frame.x_axis, width), from_middle(-frame.y_axis, height));
        // w·size − x.
        let negative = |row: Affine| Affine { at_zero: -row.at_zero, per_step: -row.per_step };
        let far_edges = [(width, x), (height, y)].map(|(size, at)| negative(at.minus(size, &w)));
        let rays = match view.camera.projection {
            Kind::Orthographic { .. } => Rays::Along((placement.inverse_axes() * frame.z_axis).normalize()),
            Kind::Perspective { .. } => Rays::From(placement.to_index(view.camera.eye)),
        };
        Ok(Self { rows: [x, y, w, z], far_edges, size: view.size, rays })
    }

    /// Returns the gradient of the depth, per index step.
    pub(crate) fn forward(&self) -> DVec3 {
        self.rows[3].per_step
    }

    /// Returns the sides from which rays come to the points of a box: per axis, true if from below and true if from above.
    pub(crate) fn sides(&self, centre: DVec3, half: DVec3) -> [[bool; 2]; 3] {
        std::array::from_fn(|a| match self.rays {
            // Where rays go across the axis, rounding included, from both.
            Rays::Along(direction) => [direction[a] > -PARALLEL, direction[a] < PARALLEL],
            Rays::From(eye) => [eye[a] < centre[a] + half[a], eye[a] > centre[a] - half[a]],
        })
    }

    /// Returns the place of an index position in the picture, in pixels, and its depth along the view; `None` where it is not before the eye.
    #[cfg(feature = "classics")]
    pub(crate) fn point(&self, p: DVec3) -> Option<([f64; 2], f64)> {
        let [x, y, w, z] = self.rows.map(|row| row.at(p));
        (w > 0.0 && z > 0.0).then(|| ([x / w, y / w], z))
    }

    /// Prepares the projection of boxes of given half edges.
    pub(crate) fn stencil(&self, half: DVec3) -> Stencil {
        Stencil {
            reach: self.rows.map(|row| row.reach(half)),
            reach_to_far_edges: self.far_edges.map(|row| row.reach(half)),
        }
    }

    /// Returns the tiles that a box around an index position covers, or more; `None` where it lies outside the picture or behind the eye.
    ///
    /// Bounds of quotients of intervals: a box may seem larger than it is, never smaller, and never farther.
    #[inline]
    pub(crate) fn footprint(&self, stencil: &Stencil, centre: DVec3) -> Option<Footprint> {
        let [x, y, w, z] = self.rows.map(|row| row.at(centre));
        let [reach_x, reach_y, reach_w, reach_z] = stencil.reach;
        if z + reach_z < 0.0 {
            return None;
        }
        let (nearest, farthest) = (w - reach_w, w + reach_w);
        let depth = (z - reach_z).max(0.0);
        if nearest <= NEAR * farthest {
            // It reaches behind the eye, and may cover anything unless one side of the picture rules it out.
            let beyond = |a: usize| self.far_edges[a].at(centre) + stencil.reach_to_far_edges[a] < 0.0;
            let outside = x + reach_x < 0.0 || y + reach_y < 0.0 || beyond(0) || beyond(1);
            let last = self.size.map(|n| (n - 1) / TILE);
            return (!outside).then_some(Footprint { low: [0; 2], high: last, depth });
        }
        let range = |middle: f64, reach: f64| {
            let (low, high) = (middle - reach, middle + reach);
            (
                if low >= 0.0 { low / farthest } else { low / nearest },
                if high >= 0.0 { high / nearest } else { high / farthest },
            )
        };
        let ranges = [range(x, reach_x), range(y, reach_y)];
        let mut footprint = Footprint { low: [0; 2], high: [0; 2], depth };
        for a in 0..2 {
            let (low, high) = ranges[a];
            if high < 0.0 || low > f64::from(self.size[a]) {
                return None;
            }
            // `as` saturates.
            footprint.low[a] = (low.max(0.0) as u32 / TILE).min((self.size[a] - 1) / TILE);
            footprint.high[a] = (high as u32 / TILE).min((self.size[a] - 1) / TILE);
        }
        Some(footprint)
    }
}

/// Fraction of a box's largest distance that its smallest must exceed for its outline to be worth computing.
const NEAR: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;
    use vr_core::{Camera, Rays};

    #[test]
    fn points_land_where_the_rays_go() {
        let axes = DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, 0.7, 0.1), DVec3::new(0.3, 0.0, 2.5));
        let placement = Placement::new(DVec3::new(5.0, -7.0, 3.0), axes).unwrap();
        let middle = placement.to_world(DVec3::new(8.0, 9.0, 4.0));
        for fov in [None, Some(40.0)] {
            let camera = Camera::framing((middle - 9.0, middle + 9.0), 30.0, 20.0, fov);
            let view = View::new(camera, [150, 83]);
            let projection = Projection::new(&view, &placement).unwrap();
            let rays = Rays::new(&view).unwrap();
            let point = projection.stencil(DVec3::ZERO);
            for (x, y) in [(0.5, 0.5), (75.0, 41.0), (149.5, 80.1), (12.3, 66.6)] {
                for s in [1.0, 20.0, 45.0] {
                    let ray = rays.at(x, y);
                    let index = placement.to_index(ray.origin + s * ray.direction);
                    let footprint = projection.footprint(&point, index).unwrap();
                    let depth = s * ray.direction.dot(camera.frame().unwrap().z_axis);
                    assert!((footprint.depth - depth).abs() < 1e-9);
                    assert_eq!(footprint.low, [x, y].map(|t: f64| t as u32 / TILE));
                    assert_eq!(footprint.low, footprint.high);
                }
            }
        }
    }

    #[test]
    fn boxes_cover_what_their_rays_meet() {
        let placement = Placement::from_spacing([1.0, 0.5, 2.0]).unwrap();
        for (eye, fov) in [([40.0, 9.0, 3.0], Some(50.0)), ([6.0, 2.0, 9.0], Some(80.0)), ([30.0, 20.0, -20.0], None)] {
            let target = DVec3::new(4.0, 2.0, 8.0);
            let projection = fov.map_or(Kind::Orthographic { height: 12.0 }, |fov| Kind::Perspective { fov });
            let camera = Camera { eye: eye.into(), target, up: DVec3::Y, projection };
            let view = View::new(camera, [61, 47]);
            let (rays, projection) = (Rays::new(&view).unwrap(), Projection::new(&view, &placement).unwrap());
            let forward = camera.frame().unwrap().z_axis;
            let half = DVec3::new(1.5, 2.0, 0.5);
            let stencil = projection.stencil(half);
            let mut met = 0;
            for centre in [[4.0, 4.0, 4.0], [6.0, 3.0, 4.5], [2.0, 8.0, 1.0]].map(DVec3::from) {
                let footprint = projection.footprint(&stencil, centre);
                for y in 0..47 {
                    for x in 0..61 {
                        let ray = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5);
                        for s in (0..600).map(|k| 0.1 * f64::from(k)) {
                            let p = placement.to_index(ray.origin + s * ray.direction) - centre;
                            if p.abs().cmple(half).all() {
                                met += 1;
                                let f = footprint.expect("it is in the picture");
                                let tile = [x / TILE, y / TILE];
                                assert!((0..2).all(|a| f.low[a] <= tile[a] && tile[a] <= f.high[a]));
                                assert!(f.depth <= s * ray.direction.dot(forward) + 1e-9);
                                break;
                            }
                        }
                    }
                }
            }
            assert!(met > 20, "{met}");
        }
    }
}
