//! Boxes in the plane of value and gradient magnitude, and the two-dimensional transfer function that they come to.

use vr_core::ControlPoint;
use vr_core::optics::{depth_of_opacity, opacity_of_depth};
use vr_io::TransferRowSection;

/// Part of a box, on either side, over which it fades out.
const SOFT: f64 = 0.25;
/// Largest opacity of a row of a transfer function.
const MAX_OPACITY: f64 = 0.999;

/// A box with soft edges: what has a value and a gradient magnitude inside has a colour and an opacity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferBox {
    /// Values from and to.
    values: [f64; 2],
    /// Gradient magnitudes from and to, in value per world unit.
    gradients: [f64; 2],
    /// Linear RGB.
    color: [f64; 3],
    /// Opacity of a unit distance in the middle.
    opacity: f64,
}

impl TransferBox {
    /// Parses a box: values from and to, magnitudes from and to, red, green, blue, opacity.
    ///
    /// # Errors
    /// A message in words for other than eight numbers, ends that are not in order, or a colour or opacity that there is not.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers: Vec<f64> = text.split(',').map_while(|n| n.trim().parse().ok()).collect();
        let &[v0, v1, g0, g1, r, g, b, opacity] = &numbers[..] else {
            return Err("expected eight numbers: values from, to, gradients from, to, red, green, blue, opacity".into());
        };
        if text.split(',').count() != 8 || numbers.iter().any(|n| !n.is_finite()) {
            return Err("expected eight finite numbers, as in 100,200,5,40,1,0.8,0.6,0.5".to_owned());
        }
        if v0 >= v1 || g0 >= g1 || g0 < 0.0 {
            return Err(
                "values and gradients must each go from a smaller number to a larger one, gradients from 0 on".into()
            );
        }
        if !(0.0..=MAX_OPACITY).contains(&opacity) || [r, g, b].iter().any(|c| !(0.0..=1e12).contains(c)) {
            return Err("colours must not be negative, the opacity must be 0 to 0.999".to_owned());
        }
        Ok(Self { values: [v0, v1], gradients: [g0, g1], color: [r, g, b], opacity })
    }

    /// Values and magnitudes between which the box fades in, and out again. One that begins at a magnitude of 0 is whole there.
    fn edges(&self) -> [[f64; 4]; 2] {
        let edge = |[from, to]: [f64; 2]| {
            let soft = SOFT * (to - from);
            [from, from + soft, to - soft, to]
        };
        let (values, mut gradients) = (edge(self.values), edge(self.gradients));
        if gradients[0] == 0.0 {
            gradients[1] = 0.0;
        }
        [values, gradients]
    }

    /// Rows of the boxes: at every magnitude at which one begins or ends to fade, each with the points of all boxes there.
    ///
    /// Boxes that overlap are mixed: their extinctions add up, and their colours are weighted by them.
    pub fn rows(boxes: &[Self]) -> Vec<TransferRowSection> {
        let knots = |axis: usize| {
            let mut knots: Vec<f64> = boxes.iter().flat_map(|b| b.edges()[axis]).collect();
            knots.sort_by(f64::total_cmp);
            knots.dedup();
            knots
        };
        let (values, gradients) = (knots(0), knots(1));
        let row = |&gradient: &f64| TransferRowSection {
            gradient,
            points: values.iter().map(|&value| mixed(boxes, value, gradient)).collect(),
        };
        gradients.iter().map(row).collect()
    }
}

/// Point of all boxes together at a place of the plane.
fn mixed(boxes: &[TransferBox], value: f64, gradient: f64) -> ControlPoint {
    let mut depth = 0.0;
    let mut light = [0.0; 3];
    // A place at which all boxes are clear has the colour of those that end there: it is mixed with theirs beside it.
    let (mut edge, mut count) = ([0.0; 3], 0.0);
    for one in boxes {
        let [values, gradients] = one.edges();
        // The opacity rises in a straight line by the value; by the magnitude the extinction does, as between rows.
        let opacity = one.opacity * trapezoid(values, value);
        let own = depth_of_opacity(opacity) * trapezoid(gradients, gradient);
        depth += own;
        (0..3).for_each(|c| light[c] += own * one.color[c]);
        if values[0] <= value && value <= values[3] {
            count += 1.0;
            (0..3).for_each(|c| edge[c] += one.color[c]);
        }
    }
    let color = match (depth > 0.0, count > 0.0) {
        (true, _) => light.map(|c| c / depth),
        (false, true) => edge.map(|c| c / count),
        (false, false) => [0.0; 3],
    };
    ControlPoint::new(value, color, opacity_of_depth(depth).min(MAX_OPACITY))
}

/// 0 outside of four ascending numbers, 1 between the inner ones, straight lines between.
fn trapezoid([a, b, c, d]: [f64; 4], x: f64) -> f64 {
    if (b..=c).contains(&x) {
        1.0
    } else if x <= a || x >= d {
        0.0
    } else if x < b {
        (x - a) / (b - a)
    } else {
        (d - x) / (d - c)
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{OpacityRule, TransferFunction};
    use vr_io::TransferPoints;

    use super::*;

    fn function(boxes: &[&str]) -> TransferFunction {
        let boxes: Vec<TransferBox> = boxes.iter().map(|text| TransferBox::parse(text).unwrap()).collect();
        TransferPoints::ByGradient(TransferBox::rows(&boxes)).function(OpacityRule::Power, 1.0).unwrap()
    }

    fn opacity(transfer: &TransferFunction, value: f64, magnitude: f64) -> f64 {
        transfer.mixture(value, magnitude).step(1.0)[3]
    }

    #[test]
    fn a_box_is_whole_inside_and_clear_outside() {
        let transfer = function(&["100,200,10,50,1,0.5,0,0.8"]);
        for (value, magnitude) in [(150.0, 30.0), (125.0, 20.0), (175.0, 40.0)] {
            assert!((opacity(&transfer, value, magnitude) - 0.8).abs() < 1e-12, "{value} {magnitude}");
            let light = transfer.mixture(value, magnitude).step(1.0);
            assert!((light[1] / light[0] - 0.5).abs() < 1e-12);
        }
        for (value, magnitude) in [(99.0, 30.0), (201.0, 30.0), (150.0, 9.0), (150.0, 51.0), (150.0, 0.0)] {
            assert_eq!(opacity(&transfer, value, magnitude), 0.0, "{value} {magnitude}");
        }
        assert!((opacity(&transfer, 112.5, 30.0) - 0.4).abs() < 1e-12, "half of it half way");
    }

    #[test]
    fn a_box_from_zero_on_holds_what_is_flat() {
        let transfer = function(&["0,1,0,4,1,1,1,0.5"]);
        assert!((opacity(&transfer, 0.5, 0.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn boxes_add_up_where_they_meet_and_keep_their_colors() {
        let transfer = function(&["0,10,0,4,1,0,0,0.5", "5,15,0,4,0,1,0,0.5", "30,40,6,9,0,0,1,0.2"]);
        assert!((opacity(&transfer, 7.5, 1.0) - 0.75).abs() < 1e-9);
        let at = |value, magnitude| transfer.mixture(value, magnitude).step(1.0);
        assert!(at(3.0, 1.0)[0] > 0.4 && at(3.0, 1.0)[2] == 0.0);
        assert!(at(12.0, 1.0)[1] > 0.4 && at(35.0, 7.5)[2] > 0.19);
        assert_eq!(opacity(&transfer, 20.0, 1.0), 0.0);
        // The rows of one box do not change another.
        assert!((opacity(&transfer, 3.0, 2.0) - 0.5).abs() < 1e-9);
    }

    #[test]
    fn boxes_that_are_none_are_refused() {
        for (text, word) in [
            ("1,2,3", "eight numbers"),
            ("1,2,3,4,1,1,1,x", "eight numbers"),
            ("1,2,3,4,1,1,1,0.5,9", "eight"),
            ("2,1,3,4,1,1,1,0.5", "smaller number"),
            ("1,2,4,3,1,1,1,0.5", "smaller number"),
            ("1,2,-1,3,1,1,1,0.5", "from 0 on"),
            ("1,2,3,4,1,1,1,1", "0.999"),
            ("1,2,3,4,-1,1,1,0.5", "negative"),
            ("nan,2,3,4,1,1,1,0.5", "finite"),
        ] {
            let message = TransferBox::parse(text).unwrap_err();
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}
