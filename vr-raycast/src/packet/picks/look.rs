//! Samples of the image by the numbers that rays picked.

use vr_core::image_order::ImageSample;
use vr_core::{Ray, Real};
use vr_kernels::vector::Operator;

use crate::pipeline::{Pipeline, SurfaceLook};
use crate::ray_value::RayValue;
use crate::tracer::RaySample;

/// Part of a step by which a place in f32 may lie before the begin of a field, several times over.
const BEHIND: f64 = 1e-4;

/// Number that a ray picked.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PickedNumber {
    /// Calibrated value.
    pub(crate) value: f64,
    /// World distance along the ray, from its own origin; of no meaning in a mean.
    pub(crate) depth: f64,
    /// Mean colour of the ray, where its places have any and a mean is picked.
    pub(crate) color: Option<[f64; 3]>,
}

/// Look of what is picked, by the plain engine's transfer function, colours and shading.
pub(crate) struct PickLook<'a, 'p, R> {
    plain: &'p Pipeline<'a, R>,
    operator: Operator,
    /// Shading of surfaces, where there are any.
    surface: Option<SurfaceLook<'a, R>>,
}

impl<'a, 'p, R: Real> PickLook<'a, 'p, R> {
    pub(crate) fn new(plain: &'p Pipeline<'a, R>, operator: Operator) -> Self {
        let is_surface = matches!(operator, Operator::First { .. });
        Self { plain, operator, surface: plain.surface_look().filter(|_| is_surface) }
    }

    /// Sample of the ray through a place of the image.
    pub(crate) fn sample(&mut self, number: PickedNumber, spot: &ImageSample) -> RaySample {
        let point = self.plain.scene.transfer.at(number.value);
        let is_surface = matches!(self.operator, Operator::First { .. });
        let [r, g, b] = point.color;
        let mut value = RayValue { rgba: if is_surface { [r, g, b, 1.0] } else { point.pixel() }, depth: number.depth };
        if self.operator == Operator::Average {
            // A mean lies nowhere in particular.
            value.depth = RayValue::NOTHING.depth;
            if let Some(color) = number.color {
                (0..3).for_each(|c| value.rgba[c] *= color[c]);
            }
            return value.into();
        }
        let has_colors = self.plain.colors.is_some();
        if has_colors || self.surface.is_some() {
            let ray = self.plain.rays.at(spot.x, spot.y);
            // Where rounding has put the begin of a field into vacuum, the field is a little behind it.
            let behind = number.depth + BEHIND * self.plain.walks.step;
            if has_colors {
                let color = self.plain.color_at(&ray, self.place(&ray, [number.depth, behind]));
                (0..3).for_each(|c| value.rgba[c] *= color[c]);
            }
            if let Some(surface) = &mut self.surface {
                surface.shade(&ray, &mut value, behind);
            }
        }
        value.into()
    }

    /// The first of two depths, or the second where a field is there alone.
    fn place(&self, ray: &Ray, [depth, behind]: [f64; 2]) -> f64 {
        let Some(field) = self.plain.scene.volume.field() else { return depth };
        let is_field = |depth: f64| field.value(ray.origin + ray.direction * depth).is_some();
        if !is_field(depth) && is_field(behind) { behind } else { depth }
    }
}
