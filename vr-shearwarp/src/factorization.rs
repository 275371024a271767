//! The viewing transformation as a permutation, a shear and a two-dimensional warp (Lacroute & Levoy 1994).

use glam::{DMat3, DVec2, DVec3};
use vr_core::{ParameterError, Placement, View};

/// A view in the index space of a grid: where rays start, and how they go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct IndexView {
    /// The eye.
    pub(crate) eye: DVec3,
    /// Vectors of one pixel to the right, one pixel down, and straight ahead. In perspective right and down are on the plane one world
    /// unit ahead.
    right: DVec3,
    down: DVec3,
    ahead: DVec3,
    size: [u32; 2],
    perspective: bool,
    /// World vectors of index steps.
    axes: DMat3,
}

impl IndexView {
    pub(crate) fn new(view: &View, placement: &Placement) -> Result<Self, ParameterError> {
        view.validate()?;
        let frame = view.camera.frame()?;
        let projection = view.camera.projection;
        let pixel = projection.height() / f64::from(view.size[1]);
        let inverse = placement.inverse_axes();
        Ok(Self {
            eye: inverse * (view.camera.eye - placement.origin()),
            right: inverse * (frame.x_axis * pixel),
            down: inverse * (frame.y_axis * -pixel),
            ahead: inverse * frame.z_axis,
            size: view.size,
            perspective: projection.is_perspective(),
            axes: placement.axes(),
        })
    }

    pub(crate) fn is_perspective(&self) -> bool {
        self.perspective
    }

    /// Width and height of the picture in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Straight ahead.
    pub(crate) fn ahead(&self) -> DVec3 {
        self.ahead
    }

    /// World vector of an index vector.
    pub(crate) fn world_vector(&self, index: DVec3) -> DVec3 {
        self.axes * index
    }

    /// World length of an index vector.
    pub(crate) fn world_length(&self, index: DVec3) -> f64 {
        self.world_vector(index).length()
    }

    /// Origin and direction, as linear functions of (x, y, 1): the columns of two matrices.
    pub(crate) fn origins(&self) -> DMat3 {
        if self.perspective {
            return DMat3::from_cols(DVec3::ZERO, DVec3::ZERO, self.eye);
        }
        DMat3::from_cols(self.right, self.down, self.eye - self.corner())
    }

    /// Directions of rays as a linear function of (x, y, 1) in pixels from the picture's top left corner; not normalised.
    pub(crate) fn directions(&self) -> DMat3 {
        if !self.perspective {
            return DMat3::from_cols(DVec3::ZERO, DVec3::ZERO, self.ahead);
        }
        DMat3::from_cols(self.right, self.down, self.ahead - self.corner())
    }

    fn corner(&self) -> DVec3 {
        0.5 * f64::from(self.size[0]) * self.right + 0.5 * f64::from(self.size[1]) * self.down
    }
}

/// The axes of the volume as a principal axis orders them: u along the scan lines, v from line to line, w from slice to slice.
///
/// Scan lines lie along x where they can: there the samples themselves do.
pub(crate) const fn axes_of(principal: usize) -> [usize; 3] {
    match principal {
        0 => [1, 2, 0],
        1 => [0, 2, 1],
        _ => [0, 1, 2],
    }
}

/// The components of an index vector in the order u, v, w.
pub(crate) fn permuted(v: DVec3, axes: [usize; 3]) -> DVec3 {
    DVec3::new(v[axes[0]], v[axes[1]], v[axes[2]])
}

/// One principal axis: how slices shear, and how the intermediate image is warped.
///
/// Intermediate image: texel (x, y) stands for the ray through the point (u, v) = `origin` + `spacing`·(x, y) of the plane w = `plane`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factorization {
    pub(crate) axes: [usize; 3],
    /// +1 where slices lie front to back by growing w, −1 otherwise.
    pub(crate) sign: f64,
    /// Position of the intermediate image on the principal axis: at the volume's back, where perspective shows the most voxels.
    pub(crate) plane: f64,
    /// (u, v) of texel (0, 0).
    pub(crate) origin: DVec2,
    /// Voxels from texel to texel.
    pub(crate) spacing: f64,
    /// Width and height of the intermediate image.
    pub(crate) size: [usize; 2],
    /// The eye (u, v, w), in perspective.
    eye: Option<DVec3>,
    /// du/dw and dv/dw of parallel rays.
    slope: DVec2,
    /// From (x, y, 1) of the screen to homogeneous (u, v) of the plane; the weight is positive in front of the eye.
    to_plane: DMat3,
}

/// Placement of a slice under the intermediate image: u = `offset.x` + `scale`·x, v = `offset.y` + `scale`·y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SliceMap {
    pub(crate) offset: DVec2,
    pub(crate) scale: f64,
}

impl Factorization {
    /// For one principal axis; `sign` says which way along it rays go. The image has no extent yet: [`Self::framed`] gives it one.
    pub(crate) fn new(view: &IndexView, principal: usize, sign: f64, plane: f64) -> Self {
        let axes = axes_of(principal);
        let rows = |m: DMat3| DMat3::from_cols_array_2d(&m.to_cols_array_2d().map(|c| axes.map(|a| c[a]))).transpose();
        let (origin, direction) = (rows(view.origins()), rows(view.directions()));
        let ahead = permuted(view.ahead, axes);
        // A ray o + t·d meets the plane at t = (plane − o_w)/d_w. In perspective d is linear in (x, y, 1) and o is not; with parallel rays
        // it is the other way round. Either way u·weight is linear.
        let to_plane = if view.perspective {
            let eye = permuted(view.eye, axes);
            let line = |a: usize| sign * (eye[a] * direction.col(2) + (plane - eye.z) * direction.col(a));
            DMat3::from_cols(line(0), line(1), sign * direction.col(2)).transpose()
        } else {
            let line = |a: usize| {
                let slope = ahead[a] / ahead.z;
                origin.col(a) - slope * origin.col(2) + DVec3::new(0.0, 0.0, slope * plane)
            };
            DMat3::from_cols(line(0), line(1), DVec3::Z).transpose()
        };
        let slope = if view.perspective { DVec2::ZERO } else { DVec2::new(ahead.x, ahead.y) / ahead.z };
        Self {
            axes,
            sign,
            plane,
            origin: DVec2::ZERO,
            spacing: 1.0,
            size: [0, 0],
            eye: view.perspective.then(|| permuted(view.eye, axes)),
            slope,
            to_plane,
        }
    }

    /// The same with an image that covers (u, v) from `low` to `high` on the plane.
    pub(crate) fn framed(self, low: DVec2, high: DVec2, spacing: f64) -> Self {
        let texels = |a: usize| ((high[a] - low[a]) / spacing).ceil().max(0.0) as usize + 1;
        Self { origin: low, spacing, size: [texels(0), texels(1)], ..self }
    }

    /// From (x, y, 1) of the screen to homogeneous (u, v) of the plane.
    pub(crate) fn plane_of_screen(&self) -> DMat3 {
        self.to_plane
    }

    /// The warp's inverse: from (x, y, 1), in pixels of the screen, to homogeneous texels.
    pub(crate) fn texels_of_screen(&self) -> DMat3 {
        let scale = DMat3::from_cols(
            DVec3::new(1.0 / self.spacing, 0.0, 0.0),
            DVec3::new(0.0, 1.0 / self.spacing, 0.0),
            DVec3::new(-self.origin.x / self.spacing, -self.origin.y / self.spacing, 1.0),
        );
        scale * self.to_plane
    }

    /// The eye's w, in perspective.
    pub(crate) fn eye(&self) -> Option<DVec3> {
        self.eye
    }

    /// Placement of the slice at w under the image: the shear, with a scale in perspective.
    pub(crate) fn slice(&self, w: f64) -> SliceMap {
        match self.eye {
            None => SliceMap { offset: self.origin + self.slope * (w - self.plane), scale: self.spacing },
            Some(eye) => {
                let near = (w - eye.z) / (self.plane - eye.z);
                let eye_uv = DVec2::new(eye.x, eye.y);
                SliceMap { offset: eye_uv + (self.origin - eye_uv) * near, scale: self.spacing * near }
            }
        }
    }

    /// du/dw and dv/dw of a texel's ray.
    #[inline(always)]
    pub(crate) fn slope(&self, x: f64, y: f64) -> DVec2 {
        match self.eye {
            None => self.slope,
            Some(eye) => {
                (self.origin + self.spacing * DVec2::new(x, y) - DVec2::new(eye.x, eye.y)) / (self.plane - eye.z)
            }
        }
    }

    /// The index vector (x, y, z) of one step forward along w on a texel's ray.
    pub(crate) fn step(&self, x: f64, y: f64) -> DVec3 {
        let slope = self.slope(x, y);
        let mut step = DVec3::ZERO;
        step[self.axes[0]] = slope.x;
        step[self.axes[1]] = slope.y;
        step[self.axes[2]] = 1.0;
        step
    }
}

/// The factors as matrices, whose product is the view: screen ← image ← sheared ← permuted ← index, homogeneous.
#[cfg(test)]
pub(crate) mod matrices {
    use glam::{DMat4, DVec4};

    use super::*;

    /// P: (x, y, z, 1) to (u, v, w, 1).
    pub(crate) fn permutation(f: &Factorization) -> DMat4 {
        let mut p = DMat4::ZERO;
        for (row, &axis) in f.axes.iter().enumerate() {
            p.col_mut(axis)[row] = 1.0;
        }
        p.w_axis.w = 1.0;
        p
    }

    /// S: (u, v, w, 1) to homogeneous texels (x, y, 1), by the scale and the offset of the slice at each w.
    pub(crate) fn shear(f: &Factorization) -> [DVec4; 3] {
        // Linear in w: known from two slices. Texels of a point are (u − offset(w))/scale(w); the weight is scale(w)/spacing.
        let at = |w: f64| f.slice(w);
        let (zero, one) = (at(0.0), at(1.0));
        let row = |a: usize| {
            let unit = if a == 0 { DVec4::X } else { DVec4::Y };
            (unit - DVec4::new(0.0, 0.0, one.offset[a] - zero.offset[a], zero.offset[a])) / f.spacing
        };
        let weight = DVec4::new(0.0, 0.0, one.scale - zero.scale, zero.scale) / f.spacing;
        [row(0), row(1), weight]
    }

    /// The warp: homogeneous texels to homogeneous pixels.
    pub(crate) fn warp(f: &Factorization) -> DMat3 {
        f.texels_of_screen().inverse()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;
    use vr_core::{Camera, Projection, Rays};

    use super::*;

    fn placement() -> Placement {
        let turned = DMat3::from_rotation_z(0.3) * DMat3::from_rotation_x(-0.2);
        Placement::oriented(DVec3::new(10.0, -4.0, 3.0), [0.5, 0.7, 1.9], turned).unwrap()
    }

    fn views() -> Vec<View> {
        let p = placement();
        let centre = p.to_world(DVec3::new(8.0, 9.0, 5.0));
        let directions = [(1.0, 0.2, 0.1), (-0.3, 1.0, 0.2), (0.1, -0.4, -1.0), (0.5, 0.5, 0.500001), (0.0, 0.0, 1.0)];
        let projections = [Projection::Orthographic { height: 12.0 }, Projection::Perspective { fov: 40.0 }];
        let mut views = Vec::new();
        for d in directions {
            for projection in projections {
                let eye = centre + 40.0 * DVec3::from(d).normalize();
                let up = DVec3::new(0.1, 1.0, 0.3);
                views.push(View::new(Camera { eye, target: centre, up, projection }, [31, 20]));
            }
        }
        views
    }

    fn factorizations(view: &View) -> Vec<Factorization> {
        let index = IndexView::new(view, &placement()).unwrap();
        let all = (0..3).filter(|&a| index.ahead[a].abs() > 0.2 * index.ahead.abs().max_element()).map(|a| {
            let f = Factorization::new(&index, a, index.ahead[a].signum(), 7.0);
            f.framed(DVec2::new(-3.0, 2.5), DVec2::new(20.0, 18.0), 0.5)
        });
        all.collect()
    }

    /// Rows of the view matrix: homogeneous pixels of an index position.
    fn view_matrix(view: &View) -> [DVec4; 3] {
        let p = placement();
        let frame = view.camera.frame().unwrap();
        let [w, h] = view.size.map(f64::from);
        let line = |v: DVec3, add: f64| {
            let axes = p.axes().transpose() * v;
            DVec4::new(axes.x, axes.y, axes.z, v.dot(p.origin() - view.camera.eye) + add)
        };
        match view.camera.projection {
            Projection::Orthographic { height } => {
                let pixel = height / h;
                [line(frame.x_axis / pixel, 0.5 * w), line(-frame.y_axis / pixel, 0.5 * h), DVec4::W]
            }
            Projection::Perspective { fov } => {
                let pixel = 2.0 * (0.5 * fov.to_radians()).tan() / h;
                [
                    line(frame.x_axis / pixel + frame.z_axis * 0.5 * w, 0.0),
                    line(-frame.y_axis / pixel + frame.z_axis * 0.5 * h, 0.0),
                    line(frame.z_axis, 0.0),
                ]
            }
        }
    }

    #[test]
    fn the_product_of_the_factors_is_the_view() {
        for view in views() {
            for f in factorizations(&view) {
                let (p, s, m) = (matrices::permutation(&f), matrices::shear(&f), matrices::warp(&f));
                // Rows of S·P, then of M·S·P.
                let sheared = s.map(|row| p.transpose() * row);
                let product: [DVec4; 3] =
                    std::array::from_fn(|i| (0..3).map(|k| sheared[k] * m.col(k)[i]).fold(DVec4::ZERO, |a, b| a + b));
                let wanted = view_matrix(&view);
                // Homogeneous: up to one factor.
                let factor = wanted[2].length() / product[2].length() * wanted[2].dot(product[2]).signum();
                let size = wanted.iter().map(|r| r.abs().max_element()).fold(0.0, f64::max);
                for i in 0..3 {
                    let off = (product[i] * factor - wanted[i]).abs().max_element();
                    assert!(off <= 1e-12 * size, "{view:?} axis {}: off by {off:e} of {size}", f.axes[2]);
                }
            }
        }
    }

    #[test]
    fn texels_are_the_rays_of_vr_core() {
        for view in views() {
            let rays = Rays::new(&view).unwrap();
            for f in factorizations(&view) {
                for (x, y) in [(0.5, 0.5), (30.5, 0.5), (12.25, 19.5), (15.5, 10.0)] {
                    let ray = rays.at(x, y);
                    let texel = f.texels_of_screen() * DVec3::new(x, y, 1.0);
                    // Another axis may be the principal one of rays at the picture's edge.
                    if texel.z <= 0.0 {
                        continue;
                    }
                    let (tx, ty) = (texel.x / texel.z, texel.y / texel.z);
                    for w in [0.0, 3.5, 7.0, 11.0] {
                        let map = f.slice(w);
                        let uv = map.offset + map.scale * DVec2::new(tx, ty);
                        let mut index = DVec3::ZERO;
                        (index[f.axes[0]], index[f.axes[1]], index[f.axes[2]]) = (uv.x, uv.y, w);
                        let from_ray = placement().to_world(index) - ray.origin;
                        let across = from_ray - ray.direction * from_ray.dot(ray.direction);
                        assert!(across.length() < 1e-11, "{across}");
                        let ahead = placement().axes() * (f.step(tx, ty) * f.sign);
                        assert!((ahead.normalize() - ray.direction).length() < 1e-12);
                    }
                }
            }
        }
    }
}
