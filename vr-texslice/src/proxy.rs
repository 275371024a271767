//! Proxy geometry of a view: its slabs, front to back, and the polygons that are rasterised for each.
//!
//! A fragment is a ray's part of a slab, and a ray may meet a slab without meeting the slice in its middle: at the rim of the box. So what is rasterised
//! is the slab's surface, as far as it is turned to the eye: the polygon in which its near face cuts the box (a quad of a stack's layer, where no clip cuts
//! it), and the strips of the box's own faces between its two faces. Each ray enters a slab once, so their pixels are the slab's, once each.
//!
//! Rasterisers round corners to a part of a pixel, and rays are what fragments are of. So slabs are drawn a little larger than they are, by more than
//! rounding, and each fragment asks whether its ray has a part of the slab, as a fragment program discards what a card's rasteriser has added.

use glam::{DVec2, DVec3};
use vr_core::{ParameterError, View};

use crate::fragments::Setup;
use crate::geometry::{Body, HalfSpace, Polygon, SUBPIXELS, box_corners, half_spaces};
use crate::projection::ScreenProjection;

#[cfg(test)]
mod tests;

/// Part of a pixel by which slabs are drawn larger: more than the diagonal of what corners are rounded to.
const MARGIN: f64 = 4.0 / SUBPIXELS as f64;

/// A slab: the rays along which a stack's index falls, or those along which it does not, and a number on them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slab {
    pub(crate) falling: bool,
    pub(crate) number: f64,
}

/// The slabs of a view. Points are given from the eye.
pub(crate) struct ProxyGeometry<'a> {
    setup: Setup<'a>,
    screen: ScreenProjection,
    /// The part of the box that the clip keeps and that lies before the eye.
    body: Body,
    /// World distance by which everything is larger than it is.
    margin: f64,
    /// Length of the box's diagonal.
    extent: f64,
    perspective: bool,
}

impl<'a> ProxyGeometry<'a> {
    /// # Errors
    /// A camera that makes no sense.
    pub(crate) fn new(view: &View, setup: &Setup<'a>) -> Result<Self, ParameterError> {
        let screen = ScreenProjection::new(view)?;
        let eye = screen.eye();
        let perspective = view.camera.projection.is_perspective();
        let last = DVec3::from_array(setup.dims.map(|n| (n - 1) as f64));
        let corners = box_corners(setup.placement, DVec3::ZERO, last).map(|c| c - eye);
        let extent = (corners[7] - corners[0]).length();
        let farthest = corners.iter().map(|c| screen.forward().dot(*c)).fold(0.0, f64::max);
        let margin = MARGIN * screen.pixel_at(farthest);
        // Index distances by which faces are further out.
        let rows = setup.placement.inverse_axes().transpose();
        let outwards = margin * DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let corners = box_corners(setup.placement, -outwards, last + outwards).map(|c| c - eye);
        // In perspective, what is in the plane through the eye is nowhere on the screen.
        let near = if perspective { 1e-9 * (farthest + extent) } else { -margin };
        let sides = half_spaces(&view.clip).into_iter().map(|side| side.seen_from(eye).loosened(margin));
        let before = HalfSpace { normal: screen.forward(), offset: near };
        let body = Body::new(&corners, sides.chain([before]));
        Ok(Self { setup: *setup, screen, body, margin, extent, perspective })
    }

    /// Returns all slabs that rays can have, front to back along every ray.
    pub(crate) fn slabs(&self) -> Vec<Slab> {
        let mut slabs = Vec::new();
        // Rays that are parallel meet a stack in one order.
        let ahead = self.setup.placement.inverse_axes() * self.screen.forward();
        let falls = self.setup.slices.fall_along(ahead.to_array());
        let both = self.perspective && self.setup.slices.axis().is_some();
        for falling in [false, true].into_iter().filter(|&falling| both || falling == falls) {
            let [first, last] = self.numbers(falling);
            // Nothing is left of the box: first is +∞.
            let mut number = first;
            while number <= last {
                slabs.push(Slab { falling, number });
                number += 1.0;
            }
        }
        slabs
    }

    /// The numbers of the first slab and the last.
    fn numbers(&self, falling: bool) -> [f64; 2] {
        let slices = self.setup.slices;
        let ends = |u: &mut dyn Iterator<Item = f64>| {
            u.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], u| [low.min(u), high.max(u)])
        };
        // u at the eye, which is where rays begin in perspective.
        let ([low, high], at_eye) = if let Some((gradient, offset)) = self.linear(falling) {
            (ends(&mut self.body.corners().map(|c| gradient.dot(c) - offset)), -offset)
        } else {
            let radius = slices.radius().unwrap_or_default();
            let nearest = (radius - self.extent).max(0.0);
            let u = |distance: f64| (distance - radius) / slices.distance;
            let [_, high] = ends(&mut self.body.corners().map(|c| u(c.length())));
            ([u(nearest), high], u(0.0))
        };
        let low = if self.perspective { low.max(at_eye) } else { low };
        // Rounding may have moved an end past a half.
        [(low + 0.5 - 1e-6).floor(), (high - 0.5 + 1e-6).ceil()]
    }

    /// u of points: gradient · point − offset.
    fn linear(&self, falling: bool) -> Option<(DVec3, f64)> {
        let (gradient, offset) = self.setup.slices.linear(falling, self.setup.placement)?;
        Some((gradient, offset - gradient.dot(self.screen.eye())))
    }

    /// The half spaces between which a slab lies. Within the picture, a shell lies between two planes.
    fn between(&self, slab: Slab) -> [HalfSpace; 2] {
        let slices = self.setup.slices;
        let (gradient, low, high) = match self.linear(slab.falling) {
            Some((gradient, offset)) => (gradient, slab.number - 0.5 + offset, slab.number + 0.5 + offset),
            None => {
                let radius = |u: f64| slices.radius().unwrap_or_default() + u * slices.distance;
                let nearest = radius(slab.number - 0.5).max(0.0) * self.screen.smallest_cosine();
                (self.screen.forward(), nearest, radius(slab.number + 0.5))
            }
        };
        let sides = [HalfSpace { normal: gradient, offset: low }, HalfSpace { normal: -gradient, offset: -high }];
        sides.map(|side| side.loosened(self.margin))
    }

    /// The polygons of a slab that are rasterised, on the screen (x and y, in pixels), `shift` added.
    pub(crate) fn polygons(&self, slab: Slab, shift: DVec2) -> Vec<Polygon> {
        let solid = self.between(slab).iter().fold(self.body.clone(), |body, side| body.cut(side));
        let (count, sum) = solid.corners().fold((0u32, DVec3::ZERO), |(n, sum), c| (n + 1, sum + c));
        let inner = sum / f64::from(count.max(1));
        let seen = solid.faces().iter().filter(|face| self.is_turned_to_eye(face, inner));
        let project = |c: &DVec3| (self.screen.at_arm(*c) + shift).extend(0.0);
        seen.map(|face| Polygon { corners: face.corners.iter().map(project).collect() }).collect()
    }

    /// True unless a face of a body around a point is surely turned away from the eye. A sliver drawn in excess costs nothing.
    fn is_turned_to_eye(&self, face: &Polygon, inner: DVec3) -> bool {
        let (area, corner) = (face.area_vector(), face.corners[0]);
        let outwards = if area.dot(corner - inner) < 0.0 { -area } else { area };
        let along = self.screen.along(corner);
        outwards.dot(along) <= 1e-9 * along.length() * self.extent * self.extent
    }
}
