//! Outlines of triangles in the picture: the pixels that each may cover, more than it does and never fewer.

use glam::{DMat3, DVec2, DVec3};
use vr_core::{ParameterError, View};

/// Projection of the world onto the picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScreenProjection {
    eye: DVec3,
    frame: DMat3,
    perspective: bool,
    /// World size of a pixel: on the plane through the eye, or at distance 1 in perspective.
    pixel: f64,
    size: [u32; 2],
    /// The largest coordinate of where rays start.
    largest: f64,
}

/// Largest error of a position, relative to the largest coordinate: subtraction of the eye and three products make fewer than ten roundings.
const ROUNDINGS: f64 = 64.0 * f64::EPSILON;
/// Part of a pixel by which outlines are widened on top of that.
const MARGIN: f64 = 1e-3;
/// Points nearer to the eye's plane than this many slacks have no place in the picture that means anything.
const NEAR: f64 = 1e3;

/// Place of a triangle in the picture, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outline {
    /// Outside of the picture.
    Nowhere,
    /// Perhaps anywhere: it reaches behind the eye, or its place is not known well enough.
    Anywhere,
    /// Its corners in pixels from the top left, and how far its edges may be from the lines between them.
    Corners([DVec2; 3], f64),
}

impl ScreenProjection {
    /// The projection of a view.
    ///
    /// # Errors
    /// Same as for [`vr_core::Camera::frame`].
    pub(crate) fn new(view: &View) -> Result<Self, ParameterError> {
        let camera = &view.camera;
        let perspective = camera.projection.is_perspective();
        let pixel = camera.projection.height() / f64::from(view.size[1]);
        let mut largest = camera.eye.abs().max_element();
        if !perspective {
            largest += pixel * f64::from(view.size[0] + view.size[1]);
        }
        Ok(Self { eye: camera.eye, frame: camera.frame()?, perspective, pixel, size: view.size, largest })
    }

    /// Width and height in pixels.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The outline of a triangle.
    #[inline]
    pub(crate) fn outline(&self, corners: [DVec3; 3]) -> Outline {
        // An upper bound of how far rounding moves a corner, or a ray, in world units.
        let largest = corners.iter().fold(self.largest, |largest, p| largest.max(p.abs().max_element()));
        let slack = ROUNDINGS * largest;
        // The corners seen from the eye: to the right, up and ahead.
        let seen = corners.map(|p| self.frame.transpose() * (p - self.eye));
        let behind = |p: &DVec3| p.z < -slack;
        if seen.iter().all(behind) {
            return Outline::Nowhere;
        }
        let [half_width, half_height] = self.size.map(|n| 0.5 * f64::from(n));
        let mut depth = 1.0;
        if self.perspective {
            depth = seen[0].z.min(seen[1].z).min(seen[2].z);
            if depth <= NEAR * slack {
                return if self.is_aside(&seen, slack) { Outline::Nowhere } else { Outline::Anywhere };
            }
        }
        // Project the corners, in pixels, and widen the outline by what their rounding can move them.
        let mut reach: f64 = 0.0;
        let points = seen.map(|p| {
            let scale = if self.perspective { 1.0 / (p.z * self.pixel) } else { 1.0 / self.pixel };
            let (x, y) = (p.x * scale, -p.y * scale);
            reach = reach.max(x.abs()).max(y.abs());
            DVec2::new(half_width + x, half_height + y)
        });
        let margin = MARGIN + slack / depth * (1.0 / self.pixel + reach);
        if margin < 0.5 * f64::from(u32::MAX) { Outline::Corners(points, margin) } else { Outline::Anywhere }
    }

    /// True if one side of the picture has all corners outside of it. For perspective; they may be behind the eye.
    fn is_aside(&self, seen: &[DVec3; 3], slack: f64) -> bool {
        let [x, y] = self.size.map(|n| 0.5 * f64::from(n) * self.pixel);
        let beyond =
            |normal: DVec3, slope: f64| seen.iter().all(|p| normal.dot(*p) - slope * p.z > slack * (1.0 + slope));
        beyond(DVec3::X, x) || beyond(DVec3::NEG_X, x) || beyond(DVec3::Y, y) || beyond(DVec3::NEG_Y, y)
    }
}

/// The pixels, of `count`, whose centres are from `low` to `high`, first and end.
#[inline]
fn centres(low: f64, high: f64, count: u32) -> [u32; 2] {
    // `as` saturates, and makes 0 of NaN.
    let first = (low - 0.5).ceil().max(0.0) as u32;
    let end = ((high - 0.5).floor() + 1.0).max(0.0) as u32;
    [first.min(count), end.min(count)]
}

impl Outline {
    /// Rows that the triangle may cover, first and end; none where it covers no column.
    #[inline]
    pub(crate) fn rows(&self, size: [u32; 2]) -> [u32; 2] {
        match *self {
            Self::Nowhere => [0; 2],
            Self::Anywhere => [0, size[1]],
            Self::Corners([a, b, c], margin) => {
                let (low, high) = (a.min(b).min(c) - margin, a.max(b).max(c) + margin);
                let [left, right] = centres(low.x, high.x, size[0]);
                if left < right { centres(low.y, high.y, size[1]) } else { [0; 2] }
            }
        }
    }

    /// Columns that it may cover in a row, first and end.
    #[inline]
    pub(crate) fn columns(&self, row: u32, size: [u32; 2]) -> [u32; 2] {
        let Self::Corners(points, margin) = *self else { return [0, size[0]] };
        // The part of the outline inside the strip that is a margin to either side of the centres.
        let centre = f64::from(row) + 0.5;
        let (top, bottom) = (centre - margin, centre + margin);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..3 {
            let (p, q) = (points[i], points[(i + 1) % 3]);
            let (p, q) = if p.y <= q.y { (p, q) } else { (q, p) };
            if q.y < top || p.y > bottom {
                continue;
            }
            let at = |y: f64| p.x + (q.x - p.x) * ((y - p.y) / (q.y - p.y));
            let from = if p.y < top { at(top) } else { p.x };
            let to = if q.y > bottom { at(bottom) } else { q.x };
            left = left.min(from).min(to);
            right = right.max(from).max(to);
        }
        centres(left - margin, right + margin, size[0])
    }
}

#[cfg(test)]
mod tests {
    use vr_core::Projection;

    use super::*;

    #[test]
    fn a_row_has_the_columns_between_the_edges() {
        let triangle = Outline::Corners([DVec2::new(1.0, 1.0), DVec2::new(9.0, 1.0), DVec2::new(1.0, 9.0)], 1e-3);
        assert_eq!(triangle.rows([20, 20]), [1, 9]);
        // x from 1 to 10 − y.
        assert_eq!([1, 4, 8].map(|row| triangle.columns(row, [20, 20])), [[1, 9], [1, 6], [1, 2]]);
        assert_eq!(triangle.columns(4, [3, 20]), [1, 3]);
        assert_eq!(triangle.rows([1, 20]), [0, 0], "to the right of the picture");
    }

    #[test]
    fn across_the_eyes_plane_it_may_be_anywhere_or_aside() {
        let projection = Projection::Perspective { fov: 90.0 };
        let camera = vr_core::Camera { eye: DVec3::ZERO, target: DVec3::NEG_Z, up: DVec3::Y, projection };
        let screen = ScreenProjection::new(&View::new(camera, [10, 10])).unwrap();
        let outline = |x: f64, z: [f64; 3]| {
            screen.outline([DVec3::new(x, -1.0, z[0]), DVec3::new(x, 1.0, z[1]), DVec3::new(x + 0.1, 0.0, z[2])])
        };
        assert_eq!(outline(0.0, [1.0, 1.0, -1.0]), Outline::Anywhere);
        assert_eq!(outline(5.0, [1.0, 1.0, -1.0]), Outline::Nowhere, "to the right of all that is seen");
        assert_eq!(outline(-5.0, [1.0, 1.0, -1.0]), Outline::Nowhere);
        assert_eq!(outline(0.0, [1.0, 1.0, 1.0]), Outline::Nowhere, "behind");
        let Outline::Corners(points, margin) = outline(0.0, [-2.0, -2.0, -2.0]) else { panic!("ahead") };
        assert!((points[0] - DVec2::new(5.0, 7.5)).length() < 1e-12 && margin < 2.0 * MARGIN, "{points:?} {margin}");
    }

    #[test]
    fn what_is_between_two_centres_is_dropped() {
        let at = |x: f64, y: f64| DVec2::new(x, y);
        let small = Outline::Corners([at(4.6, 4.2), at(5.4, 4.2), at(5.0, 4.8)], 1e-3);
        assert_eq!(small.rows([20, 20]), [0, 0]);
        let large = Outline::Corners([at(-1e300, 4.2), at(1e300, 4.2), at(5.0, 1e300)], 1e-3);
        assert_eq!((large.rows([20, 20]), large.columns(7, [20, 20])), ([4, 20], [0, 20]));
    }
}
