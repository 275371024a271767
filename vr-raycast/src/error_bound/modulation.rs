//! Opacity that follows the gradient: factors on extinction, and shares of the rows of a transfer function, with a bound of what they are off by.

use vr_core::{Scene, factor_at};

use super::normals::Normals;
use super::series::Series;

/// Effect of the gradient's magnitude on the medium.
#[derive(Clone, Debug)]
pub(super) enum Modulation {
    /// It multiplies extinction by a factor.
    Factor(Factors),
    /// It mixes the rows of the transfer function, each of which has a share. They are in order of their magnitudes.
    Rows { magnitudes: Vec<f64>, shares: Vec<Factors> },
}

/// Factor by the gradient's magnitude: linear between points, constant outside.
#[derive(Clone, Debug)]
pub(super) struct Factors {
    points: Vec<(f64, f64)>,
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

/// Magnitude of the gradient on a part of a cell.
struct Magnitude {
    /// `None` where only bounds are known.
    series: Option<Series>,
    /// Bounds of it.
    range: [f64; 2],
}

/// Rounding of a magnitude and of its factor.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

impl Modulation {
    /// Returns that of a scene; `None` where opacity does not follow the gradient.
    pub(super) fn new(scene: &Scene) -> Option<Self> {
        if !scene.has_gradient_opacity() {
            return None;
        }
        let rows = scene.transfer.rows();
        if rows.is_empty() {
            return Some(Self::Factor(Factors::new(scene.shading.as_ref()?.gradient_opacity.clone())));
        }
        let magnitudes: Vec<f64> = rows.iter().map(|row| row.gradient).collect();
        let share = |i: usize| {
            let around = i.saturating_sub(1)..(i + 2).min(magnitudes.len());
            Factors::new(around.map(|k| (magnitudes[k], if k == i { 1.0 } else { 0.0 })).collect())
        };
        let shares = (0..magnitudes.len()).map(share).collect();
        Some(Self::Rows { magnitudes, shares })
    }

    /// Returns the largest factor.
    pub(super) fn largest(&self) -> f64 {
        match self {
            Self::Factor(factors) => factors.extremes[1],
            Self::Rows { .. } => 1.0,
        }
    }

    /// Returns the factor on the part [from, to] of a cell, 0 to 1; `None` where rows are mixed.
    pub(super) fn on(&self, normals: &Normals, part: [f64; 2]) -> Option<Factor> {
        let Self::Factor(factors) = self else { return None };
        Some(factors.at(&Magnitude::on(normals, part)))
    }

    /// Returns the rows that have a share on the part [from, to] of a cell, 0 to 1, with these; `None` where no rows are mixed.
    pub(super) fn shares(&self, normals: &Normals, part: [f64; 2]) -> Option<Vec<(usize, Series)>> {
        let Self::Rows { magnitudes, shares } = self else { return None };
        let magnitude = Magnitude::on(normals, part);
        let [low, high] = magnitude.range;
        let first = magnitudes.partition_point(|&m| m <= low).max(1) - 1;
        let end = (magnitudes.partition_point(|&m| m < high) + 1).min(magnitudes.len());
        let all = (first..end.max(first + 1)).map(|i| (i, shares[i].at(&magnitude)));
        Some(all.filter(|(_, share)| !share.is_nothing()).map(|(i, share)| (i, share.series)).collect())
    }
}

impl Magnitude {
    /// Returns it on the part [from, to] of a cell, 0 to 1: as a series where it is far enough from 0, else by its range.
    fn on(normals: &Normals, part: [f64; 2]) -> Self {
        let Some(slopes) = normals.on(part) else {
            let is_absent = matches!(normals, Normals::Absent);
            return Self { series: None, range: [0.0, if is_absent { 0.0 } else { f64::INFINITY }] };
        };
        let series = slopes.square.power(0.5).map(|root| root.times(slopes.unit));
        let [low, high] = slopes.square.range().map(|square| square.max(0.0).sqrt() * slopes.unit);
        let mut range = [low * (1.0 - ROUNDING), high * (1.0 + ROUNDING)];
        if let Some([low, high]) = series.map(|series| series.range()) {
            range = [range[0].max(low), range[1].min(high)];
        }
        Self { series, range }
    }
}

impl Factors {
    fn new(points: Vec<(f64, f64)>) -> Self {
        let factors = || points.iter().map(|point| point.1);
        let extremes = [factors().fold(f64::INFINITY, f64::min), factors().fold(0.0, f64::max)];
        Self { points, extremes }
    }

    fn at(&self, magnitude: &Magnitude) -> Factor {
        let bounded = self.between(magnitude.range);
        let Some(root) = magnitude.series else { return bounded };
        // A line by the magnitude, half way between the bounds of what the factor differs from it by.
        let [m0, m1] = magnitude.range;
        let ends = [m0, m1].map(|m| factor_at(&self.points, m));
        let slope = if m1 > m0 { (ends[1] - ends[0]) / (m1 - m0) } else { 0.0 };
        if !slope.is_finite() {
            return bounded;
        }
        let (mut below, mut above) = (0.0f64, 0.0f64);
        for &(m, factor) in self.points.iter().filter(|point| point.0 > m0 && point.0 < m1) {
            let off = factor - (ends[0] + slope * (m - m0));
            (below, above) = (below.min(off), above.max(off));
        }
        let line = root.times(slope).plus(&Series::constant(ends[0] - slope * m0 + 0.5 * (below + above)));
        let rest = line.rest + 0.5 * (above - below) + ROUNDING * (slope.abs() * m1 + bounded.range[1]);
        Factor { series: Series { rest, ..line }.or(bounded.series), range: bounded.range }
    }

    /// Returns the factor where no more is known than bounds of the magnitude.
    fn between(&self, [low, high]: [f64; 2]) -> Factor {
        let inside = self.points.iter().filter(|point| point.0 > low && point.0 < high);
        let ends = [low, high].map(|m| factor_at(&self.points, m));
        let all = || inside.clone().map(|point| point.1).chain(ends);
        let (min, max) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
        // Between two points the factor is rounded.
        let range = if min == max { [min; 2] } else { [min * (1.0 - ROUNDING), max * (1.0 + ROUNDING)] };
        Factor { series: Series::between(range[0], range[1]), range }
    }
}

impl Factor {
    /// True if nothing absorbs.
    pub(super) fn is_nothing(&self) -> bool {
        self.range[1] <= 0.0
    }

    /// True if whatever absorbs without the factor absorbs with it.
    pub(super) fn is_something(&self) -> bool {
        self.range[0] > 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_within_their_bounds() {
        let factors = Factors::new(vec![(0.3, 0.0), (0.7, 0.2), (1.5, 1.0), (2.0, 0.4)]);
        let mut known = 0;
        for i in 0..400 {
            let x = |k: u32| f64::from((i * 7919 + k * 104_729) % 2003) / 2003.0 - 0.5;
            let powers = [[x(1), x(2), x(3), x(4)], [x(5), x(6), 0.0, 0.0], [x(7), 0.0, 0.0, x(8)]];
            let normals = Normals::Along { powers, off: 0.0, unit: 2.0, corners: None };
            let middle = 0.5 + 0.8 * x(9);
            for half in [0.1, 0.01, 1e-4] {
                let part = [(middle - half).max(0.0), (middle + half).min(1.0)];
                let factor = factors.at(&Magnitude::on(&normals, part));
                known += usize::from(factor.series.rest < 1e-3);
                for j in 0..=32 {
                    let t = f64::from(j) / 16.0 - 1.0;
                    let s = 0.5 * (part[0] + part[1]) + 0.5 * (part[1] - part[0]) * t;
                    let g = powers.map(|p| 2.0 * (p[0] + s * (p[1] + s * (p[2] + s * p[3]))));
                    let magnitude = (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]).sqrt();
                    let want = factor_at(&factors.points, magnitude);
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
        let modulation = Modulation::Factor(Factors::new(vec![(0.0, 0.25), (1.0, 1.0)]));
        let factor = modulation.on(&Normals::Absent, [0.0, 1.0]).unwrap();
        assert_eq!((factor.series, factor.range), (Series::constant(0.25), [0.25; 2]));
        let [low, high] = modulation.on(&Normals::Unknown, [0.0, 1.0]).unwrap().range;
        assert!((low - 0.25).abs() < 1e-12 && (high - 1.0).abs() < 1e-12);
    }

    #[test]
    fn rows_share_what_there_is() {
        let magnitudes = vec![0.0, 1.0, 3.0];
        let shares =
            [vec![(0.0, 1.0), (1.0, 0.0)], vec![(0.0, 0.0), (1.0, 1.0), (3.0, 0.0)], vec![(1.0, 0.0), (3.0, 1.0)]];
        let rows = Modulation::Rows { magnitudes, shares: shares.map(Factors::new).to_vec() };
        let at = |magnitude: f64| {
            let powers = [[magnitude, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]];
            let normals = Normals::Along { powers, off: 0.0, unit: 1.0, corners: None };
            rows.shares(&normals, [0.0, 1.0]).unwrap()
        };
        for (magnitude, want) in
            [(0.25, vec![(0, 0.75), (1, 0.25)]), (2.5, vec![(1, 0.25), (2, 0.75)]), (9.0, vec![(2, 1.0)])]
        {
            let got = at(magnitude);
            assert_eq!(got.len(), want.len(), "{magnitude}: {got:?}");
            for ((row, share), (want_row, want_share)) in got.into_iter().zip(want) {
                assert!(row == want_row && (share.c[0] - want_share).abs() <= share.rest + 1e-15 && share.rest < 1e-13);
            }
        }
        assert_eq!(rows.shares(&Normals::Unknown, [0.0, 1.0]).unwrap().len(), 3);
        assert_eq!(rows.shares(&Normals::Absent, [0.0, 1.0]).unwrap(), [(0, Series::constant(1.0))]);
    }
}
