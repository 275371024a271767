//! Opacity that follows the gradient: the factor on extinction, with a bound of what it is off by.

use std::sync::Arc;

use vr_core::{Scene, Shading};

use super::normals::Normals;
use super::series::Series;

/// Factors on extinction by the gradient's magnitude.
#[derive(Clone, Debug)]
pub(super) struct Modulation {
    shading: Arc<Shading>,
    /// Smallest and largest factor.
    extremes: [f64; 2],
}

/// Factor on a part of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factor {
    pub(super) series: Series,
    /// Bounds of its values.
    pub(super) range: [f64; 2],
}

/// Rounding of a magnitude and of its factor.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

impl Modulation {
    /// Returns the factors of a scene; `None` where it has none.
    pub(super) fn new(scene: &Scene) -> Option<Self> {
        let shading = scene.shading.as_ref().filter(|shading| !shading.gradient_opacity.is_empty())?;
        let shading = Arc::clone(scene.has_gradient_opacity().then_some(shading)?);
        let factors = || shading.gradient_opacity.iter().map(|point| point.1);
        let extremes = [factors().fold(f64::INFINITY, f64::min), factors().fold(0.0, f64::max)];
        Some(Self { shading, extremes })
    }

    /// Returns the largest factor.
    pub(super) fn largest(&self) -> f64 {
        self.extremes[1]
    }

    /// Returns the factor on the part [from, to] of a cell, 0 to 1.
    pub(super) fn on(&self, normals: &Normals, part: [f64; 2]) -> Factor {
        let Some(slopes) = normals.on(part) else {
            return match normals {
                Normals::Absent => self.between([0.0; 2]),
                _ => Factor { series: Series::between(self.extremes[0], self.extremes[1]), range: self.extremes },
            };
        };
        // The magnitude, as a series where it is far enough from 0, else by its range.
        let root = slopes.square.power(0.5).map(|root| root.times(slopes.unit));
        let [low, high] = slopes.square.range().map(|square| square.max(0.0).sqrt() * slopes.unit);
        let mut range = [low * (1.0 - ROUNDING), high * (1.0 + ROUNDING)];
        if let Some([low, high]) = root.map(|root| root.range()) {
            range = [range[0].max(low), range[1].min(high)];
        }
        let bounded = self.between(range);
        let Some(root) = root else { return bounded };
        // A line by the magnitude, half way between the bounds of what the factor differs from it by.
        let [m0, m1] = range;
        let ends = range.map(|m| self.shading.modulation(m));
        let slope = if m1 > m0 { (ends[1] - ends[0]) / (m1 - m0) } else { 0.0 };
        if !slope.is_finite() {
            return bounded;
        }
        let (mut below, mut above) = (0.0f64, 0.0f64);
        for &(m, factor) in self.shading.gradient_opacity.iter().filter(|point| point.0 > m0 && point.0 < m1) {
            let off = factor - (ends[0] + slope * (m - m0));
            (below, above) = (below.min(off), above.max(off));
        }
        let line = root.times(slope).plus(&Series::constant(ends[0] - slope * m0 + 0.5 * (below + above)));
        let rest = line.rest + 0.5 * (above - below) + ROUNDING * (slope.abs() * m1 + bounded.range[1]);
        Factor { series: Series { rest, ..line }.or(bounded.series), range: bounded.range }
    }

    /// Returns the factor where no more is known than bounds of the magnitude.
    fn between(&self, [low, high]: [f64; 2]) -> Factor {
        let inside = self.shading.gradient_opacity.iter().filter(|point| point.0 > low && point.0 < high);
        let ends = [low, high].map(|m| self.shading.modulation(m));
        let all = || inside.clone().map(|point| point.1).chain(ends);
        let (min, max) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        let is_one = min == max;
        // Between two points the factor is rounded.
        let range = if is_one { [min; 2] } else { [min * (1.0 - ROUNDING), max * (1.0 + ROUNDING)] };
        Factor { series: Series::between(range[0], range[1]), range }
    }
}

impl Factor {
    /// True if nothing absorbs.
    pub(super) fn is_nothing(&self) -> bool {
        self.range[1] <= 0.0
    }

    /// True if all absorbs that does without it.
    pub(super) fn is_something(&self) -> bool {
        self.range[0] > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::Shading;

    fn modulation(points: &[(f64, f64)]) -> Modulation {
        let shading = Arc::new(Shading { gradient_opacity: points.to_vec(), ..Shading::default() });
        let extremes = [0.0, shading.largest_modulation()];
        Modulation { shading, extremes }
    }

    #[test]
    fn factors_are_within_their_bounds() {
        let modulation = modulation(&[(0.3, 0.0), (0.7, 0.2), (1.5, 1.0), (2.0, 0.4)]);
        let mut known = 0;
        for i in 0..400 {
            let x = |k: u32| f64::from((i * 7919 + k * 104_729) % 2003) / 2003.0 - 0.5;
            let powers = [[x(1), x(2), x(3), x(4)], [x(5), x(6), 0.0, 0.0], [x(7), 0.0, 0.0, x(8)]];
            let normals = Normals::Along { powers, off: 0.0, unit: 2.0, corners: None };
            let middle = 0.5 + 0.8 * x(9);
            for half in [0.1, 0.01, 1e-4] {
                let part = [(middle - half).max(0.0), (middle + half).min(1.0)];
                let factor = modulation.on(&normals, part);
                known += usize::from(factor.series.rest < 1e-3);
                for j in 0..=32 {
                    let t = f64::from(j) / 16.0 - 1.0;
                    let s = 0.5 * (part[0] + part[1]) + 0.5 * (part[1] - part[0]) * t;
                    let g = powers.map(|p| 2.0 * (p[0] + s * (p[1] + s * (p[2] + s * p[3]))));
                    let want = modulation.shading.modulation((g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt());
                    let c = factor.series.c;
                    let got = c[0] + t * (c[1] + t * (c[2] + t * c[3]));
                    assert!((got - want).abs() <= factor.series.rest + 1e-15, "{got} {want} {factor:?}");
                    assert!(factor.range[0] <= want && want <= factor.range[1], "{want} {factor:?}");
                }
            }
        }
        assert!(known > 700, "{known}");
    }

    #[test]
    fn what_is_flat_has_the_first_factor() {
        let modulation = modulation(&[(0.0, 0.25), (1.0, 1.0)]);
        let factor = modulation.on(&Normals::Absent, [0.0, 1.0]);
        assert_eq!((factor.series, factor.range), (Series::constant(0.25), [0.25; 2]));
        assert_eq!(modulation.on(&Normals::Unknown, [0.0, 1.0]).range, [0.0, 1.0]);
    }
}
