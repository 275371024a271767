//! Extinction as a function of the value.

use vr_core::{OpacityRule, TransferFunction};

/// Extinction of a transfer function's values, without the colours: most look-ups of a path ask for no more.
#[derive(Clone, Debug)]
pub(super) struct ExtinctionCurve {
    /// Values at which the pieces begin, ascending: −∞ for the first.
    begins: Vec<f64>,
    pieces: Vec<Piece>,
    rule: OpacityRule,
    per_unit: f64,
    /// Extinction of opacity 1, and the largest there is.
    wall: f64,
}

/// Opacities of a range of values, linear between both ends.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: f64,
    /// 0 where the opacity is constant.
    width: f64,
    opacity: [f64; 2],
}

impl ExtinctionCurve {
    /// The extinction of a transfer function, at most that of a wall.
    pub fn new(transfer: &TransferFunction, wall: f64) -> Self {
        let segments = transfer.segments();
        let piece = |segment: &vr_core::transfer::Segment| {
            let width = segment.to - segment.from;
            let width = if width.is_finite() { width } else { 0.0 };
            Piece { from: segment.from, width, opacity: [segment.start.opacity, segment.end.opacity] }
        };
        Self {
            begins: segments.iter().map(|segment| segment.from).collect(),
            pieces: segments.iter().map(piece).collect(),
            rule: transfer.rule(),
            per_unit: 1.0 / transfer.unit_distance(),
            wall,
        }
    }

    /// Extinction at a value.
    #[inline]
    pub fn at(&self, value: f64) -> f64 {
        let number = self.begins.partition_point(|&from| from <= value);
        let Piece { from, width, opacity: [start, end] } = self.pieces[number.max(1) - 1];
        let opacity = if width == 0.0 { start } else { start + (value - from) / width * (end - start) };
        self.of_opacity(opacity.clamp(0.0, 1.0))
    }

    /// Extinction of an opacity.
    #[inline]
    pub fn of_opacity(&self, opacity: f64) -> f64 {
        let depth = match self.rule {
            OpacityRule::Power => depth_of_opacity(opacity),
            OpacityRule::Extinction => opacity,
        };
        (depth * self.per_unit).min(self.wall)
    }
}

/// Opacity below which the series is exact to the last bits.
const SMALL: f64 = 0.1;

/// −ln(1 − α): 2 artanh(α/(2 − α)), whose series ends at the 11th power for small α.
#[inline]
fn depth_of_opacity(opacity: f64) -> f64 {
    if opacity > SMALL {
        return -libm::log1p(-opacity);
    }
    let s = opacity / (2.0 - opacity);
    let z = s * s;
    let tail = (1.0 / 3.0 + z * (1.0 / 5.0)) + z * z * ((1.0 / 7.0 + z * (1.0 / 9.0)) + z * z * (1.0 / 11.0));
    2.0 * (s + s * z * tail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::ControlPoint;

    #[test]
    fn series_and_logarithm_are_one() {
        for k in 0..=2000 {
            let opacity = f64::from(k) * 1e-4;
            let (found, wanted) = (depth_of_opacity(opacity), -libm::log1p(-opacity));
            // The first term left out is s^13/13 of s, below 3e-17.
            assert!((found - wanted).abs() <= 4.0 * f64::EPSILON * wanted, "{opacity}: {found} for {wanted}");
        }
        assert_eq!(depth_of_opacity(1.0), f64::INFINITY);
    }

    #[test]
    fn curves_are_those_of_the_transfer_function() {
        let points = vec![
            ControlPoint::new(-1.0, [1.0; 3], 0.0),
            ControlPoint::new(0.5, [1.0; 3], 0.7),
            ControlPoint::new(0.5, [1.0; 3], 0.01),
            ControlPoint::new(2.0, [1.0; 3], 1.0),
        ];
        for rule in [OpacityRule::Power, OpacityRule::Extinction] {
            let transfer = TransferFunction::new(points.clone(), rule, 0.3).unwrap();
            let curve = ExtinctionCurve::new(&transfer, 1e3);
            for k in -300..=300 {
                let value = f64::from(k) * 0.01;
                let wanted = transfer.extinction_at(value).min(1e3);
                assert!((curve.at(value) - wanted).abs() <= 8.0 * f64::EPSILON * wanted, "{value}");
            }
            for end in [f64::NEG_INFINITY, f64::INFINITY] {
                assert_eq!(curve.at(end), transfer.extinction_at(end).min(1e3));
            }
        }
    }
}
