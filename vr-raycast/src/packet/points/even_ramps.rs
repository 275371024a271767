//! Values numbered so that all ramps of a transfer function are equally wide.

use fearless_simd::Simd;
use fearless_simd::f32x16;
use fearless_simd::prelude::*;
use vr_core::{ControlPoint, TransferFunction};
use vr_kernels::vector::{Lanes, pick, splat};

/// Map from values to places, linear between the control points of a transfer function, which lie at 0, 1, 2 and so on: a table over places has as many
/// entries for the narrowest ramp as for the widest, where one over values has none to spare for ramps over several orders of magnitude.
#[derive(Clone, Debug)]
pub(super) struct EvenRamps {
    /// Value of each control point, and places per value behind it.
    knots: Vec<[f32; 2]>,
}

/// Largest number of control points: each costs four instructions a sample.
const MAX_KNOTS: usize = 32;

impl EvenRamps {
    /// Returns the map of a transfer function, and the same function of places. `None` of one that has rows by gradient, too few or too many control points,
    /// or ramps that f32 does not tell apart.
    pub(super) fn of(transfer: &TransferFunction) -> Option<(Self, TransferFunction)> {
        let points = transfer.points();
        let mut values: Vec<f64> = points.iter().map(|point| point.value).collect();
        values.dedup();
        if transfer.has_rows() || !(2..=MAX_KNOTS).contains(&values.len()) {
            return None;
        }
        let rate = |i: usize| {
            // Beyond the last one, the places of the ramp before it go on.
            let pair = &values[i.min(values.len() - 2)..][..2];
            (1.0 / (pair[1] - pair[0])) as f32
        };
        let knots: Vec<[f32; 2]> = values.iter().enumerate().map(|(i, &value)| [value as f32, rate(i)]).collect();
        let is_told = knots.iter().all(|[_, rate]| rate.is_normal()) && knots.is_sorted_by(|a, b| a[0] < b[0]);
        let place = |value: f64| values.partition_point(|&v| v < value) as f64;
        let evened = points.iter().map(|point| ControlPoint { value: place(point.value), ..*point }).collect();
        let evened = TransferFunction::new(evened, transfer.rule(), transfer.unit_distance()).ok()?;
        is_told.then_some((Self { knots }, evened))
    }

    /// Places of sixteen values.
    #[inline(always)]
    pub(super) fn places<S: Simd>(&self, simd: S, value: f32x16<S>) -> Lanes {
        let [first, rate] = self.knots[0];
        let mut place = (value - first) * rate;
        for (i, &[knot, rate]) in self.knots.iter().enumerate() {
            let beyond = value - knot;
            place = pick(beyond.simd_ge(splat(simd, 0.0)), beyond * rate + i as f32, place);
        }
        Lanes::new(place)
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use vr_core::OpacityRule;
    use vr_kernels::vector::LANES;

    use super::*;

    #[test]
    fn the_function_of_a_place_is_that_of_its_value() {
        let point = |value, opacity: f64| ControlPoint::new(value, [opacity, 0.5, 1.0 - opacity], opacity);
        let points = vec![
            point(0.05, 0.0),
            point(0.5, 0.006),
            point(5.0, 0.03),
            point(5.0, 0.9),
            point(50.0, 0.15),
            point(500.0, 0.6),
        ];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
        let (ramps, evened) = EvenRamps::of(&transfer).unwrap();
        assert_eq!(evened.points().iter().map(|p| p.value).collect::<Vec<_>>(), [0.0, 1.0, 2.0, 2.0, 3.0, 4.0]);
        let values: [f32; LANES] = std::array::from_fn(|i| {
            [-3.0, 0.0, 0.05, 0.0501, 0.2, 0.5, 1.0, 4.99, 5.0, 5.01, 30.0, 50.0, 60.0, 499.0, 500.0, 9e4][i]
        });
        let places = dispatch!(Level::new(), simd => ramps.places(simd, f32x16::load_array_ref(simd, &values))).0;
        assert!(places.is_sorted());
        for (value, place) in values.into_iter().zip(places) {
            let (want, found) = (transfer.at(f64::from(value)), evened.at(f64::from(place)));
            let off = (want.opacity - found.opacity).abs().max((want.color[0] - found.color[0]).abs());
            assert!(off < 1e-6, "{value} at {place}: {found:?} for {want:?}");
        }
    }

    #[test]
    fn functions_without_ramps_or_with_too_many_have_none() {
        let of = |count: usize| {
            let points = (0..count).map(|i| ControlPoint::new(i as f64 * 0.1, [1.0; 3], 0.5)).collect();
            EvenRamps::of(&TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap()).is_some()
        };
        assert!(of(2) && of(MAX_KNOTS) && !of(1) && !of(MAX_KNOTS + 1));
    }
}
