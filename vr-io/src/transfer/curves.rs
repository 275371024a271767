//! Points of colour and points of opacity, as VTK's programs have them, and the control points that both come to.

use vr_core::ControlPoint;
use vr_core::transfer::srgb_to_linear;

use crate::error::FieldError;

use super::color_space::{self, ColorSpace};
use super::polyline::{Polyline, resample};

/// Linear-light colours over values, from rows of value, red, green and blue (sRGB). `field` names a number of a row.
pub(super) fn colors(
    points: &[[f64; 4]],
    space: ColorSpace,
    field: impl Fn(usize, usize) -> String,
) -> Result<Polyline<3>, FieldError> {
    if points.is_empty() {
        return Err(FieldError::new(field(0, 0), "nothing", "must have one point at least"));
    }
    for (i, [value, color @ ..]) in points.iter().enumerate() {
        if !value.is_finite() || (i > 0 && *value < points[i - 1][0]) {
            return Err(FieldError::new(field(i, 0), value, "values must be finite and in ascending order"));
        }
        if let Some(c) = color.iter().position(|c| !(0.0..=1.0).contains(c)) {
            return Err(FieldError::new(field(i, 1 + c), color[c], "colours must be in [0, 1]"));
        }
    }
    let linear = |[_, r, g, b]: [f64; 4]| [r, g, b].map(srgb_to_linear);
    let mut line = vec![(points[0][0], linear(points[0]))];
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        if space == ColorSpace::Step {
            // The whole interval has the colour of its upper end.
            line.push((a[0], linear(b)));
            line.push((b[0], linear(b)));
        } else {
            let at = |t: f64| space.between([a[1], a[2], a[3]], [b[1], b[2], b[3]], t);
            resample(a[0], b[0], at, color_space::differ, &mut line);
        }
    }
    Ok(Polyline(line))
}

/// Opacity that grows from 0 to 1 over the range of colours: what ParaView shows where a file has none.
pub(super) fn growing(colors: &Polyline<3>, notes: &mut Vec<String>) -> Polyline<1> {
    notes.push("the colour map has no opacities: they grow from 0 to 1 over its range".to_owned());
    let (low, high) = colors.range();
    Polyline(vec![(low, [0.0]), (high, [1.0])])
}

/// Control points at every value where either bends; two where either jumps.
pub(super) fn merge(colors: &Polyline<3>, opacity: &Polyline<1>) -> Vec<ControlPoint> {
    let mut values: Vec<f64> = colors.0.iter().map(|p| p.0).chain(opacity.0.iter().map(|p| p.0)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut points = Vec::new();
    for v in values {
        let below = ControlPoint::new(v, colors.below(v), opacity.below(v)[0]);
        let above = ControlPoint::new(v, colors.above(v), opacity.above(v)[0]);
        if below != above {
            points.push(below);
        }
        points.push(above);
    }
    points
}
