//! Opacity that follows the steepness of the field, at sixteen places.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use std::sync::Arc;
use vr_core::{Shading, TransferFunction};

use super::shade::{Shade, largest, world};
use super::{LANES, Lanes, OpticsTable, pick, splat, step_light};

/// Factor on the extinction by the magnitude of the gradient: linear between points, constant outside.
#[derive(Clone, Debug)]
pub struct Modulation {
    /// Magnitude in the units of the gradients, and factor.
    points: Vec<[f32; 2]>,
}

/// Medium of a transfer function by gradient: extinction and emission, mixed from those of its rows.
#[derive(Clone, Debug)]
pub struct RowMixture {
    /// Share of each row by the magnitude of the gradient.
    shares: Vec<Modulation>,
    /// Table of each row.
    tables: Arc<[OpticsTable]>,
}

/// Optical properties of steps, which a gradient changes.
#[derive(Clone, Copy, Debug)]
pub struct StepOptics {
    /// Stored numbers.
    pub value: Lanes,
    /// (r, g, b, κ): a row of an `OpticsTable`.
    pub row: [Lanes; 4],
    /// Length, in the table's unit.
    pub length: Lanes,
    /// True if the row holds emission, which no factor changes.
    pub emits: bool,
}

impl Modulation {
    /// The factors of a shading for gradients in units of so many of its own; `None` if it has none.
    pub fn new(shading: &Shading, unit: f64) -> Option<Self> {
        Self::of_points(&shading.gradient_opacity, unit)
    }

    fn of_points(points: &[(f64, f64)], unit: f64) -> Option<Self> {
        let point = |&(magnitude, factor): &(f64, f64)| [(magnitude / unit) as f32, factor as f32];
        let points: Vec<[f32; 2]> = points.iter().map(point).collect();
        (!points.is_empty()).then_some(Self { points })
    }

    /// Factors at sixteen gradients.
    #[inline(always)]
    fn factor<S: Simd>(&self, simd: S, w: [f32x16<S>; 3]) -> f32x16<S> {
        // Scaled by its largest component, so that the square neither underflows nor overflows.
        let one = splat(simd, 1.0);
        let longest = largest(w);
        let scale = one / pick(longest.simd_gt(splat(simd, 0.0)), longest, one);
        let n = [w[0] * scale, w[1] * scale, w[2] * scale];
        let magnitude = longest * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        let mut factor = splat(simd, self.points[0][1]);
        for (i, &[at, value]) in self.points.iter().enumerate() {
            let rise = match self.points.get(i + 1) {
                Some(next) if next[0] > at => (next[1] - value) / (next[0] - at),
                _ => 0.0,
            };
            let beyond = magnitude - at;
            factor = pick(beyond.simd_ge(splat(simd, 0.0)), splat(simd, value) + beyond * rise, factor);
        }
        factor
    }
}

impl RowMixture {
    /// The rows of a transfer function, by a table of each, for gradients in units of so many values per world unit; `None` if it has none.
    pub fn new(transfer: &TransferFunction, tables: Arc<[OpticsTable]>, unit: f64) -> Option<Self> {
        let nodes: Vec<f64> = transfer.rows().iter().map(|row| row.gradient).collect();
        // A row has all of the share at its own magnitude, and none at its neighbours'.
        let hat = |i: usize| -> Vec<(f64, f64)> {
            let neighbours = i.saturating_sub(1)..(i + 2).min(nodes.len());
            neighbours.map(|k| (nodes[k], f64::from(u8::from(k == i)))).collect()
        };
        let shares = (0..nodes.len()).filter_map(|i| Modulation::of_points(&hat(i), unit)).collect();
        (!nodes.is_empty()).then_some(Self { shares, tables })
    }

    /// Rows of the mixture at stored numbers and world gradients: colour, or emission where tables hold that, and extinction.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, value: f32x16<S>, w: [f32x16<S>; 3]) -> [f32x16<S>; 4] {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let emits = self.emits();
        let mut sum = [zero; 4];
        for (share, table) in self.shares.iter().zip(&*self.tables) {
            let share = share.factor(simd, w);
            if share.simd_gt(zero).any_true() {
                let row = table.rows().at(simd, value);
                let kappa = row[3] * share;
                let weight = if emits { share } else { kappa };
                sum = [sum[0] + row[0] * weight, sum[1] + row[1] * weight, sum[2] + row[2] * weight, sum[3] + kappa];
            }
        }
        if emits {
            return sum;
        }
        let per_kappa = one / pick(sum[3].simd_gt(zero), sum[3], one);
        [sum[0] * per_kappa, sum[1] * per_kappa, sum[2] * per_kappa, sum[3]]
    }

    /// True if emission is given on its own.
    pub fn emits(&self) -> bool {
        self.tables.first().is_some_and(|table| table.emits)
    }
}

impl Shade<'_> {
    /// Factors of [`modulation`](super::PacketShading::modulation) on the extinction at gradients; 1 where it has none.
    #[inline(never)]
    pub fn factors<S: Simd>(&self, simd: S, gradient: &[Lanes; 3]) -> Lanes {
        let Some(modulation) = &self.shading.modulation else { return Lanes([1.0; LANES]) };
        let mut factors = Lanes::ZERO;
        simd.vectorize(
            #[inline(always)]
            || {
                let gradient = [gradient[0].load(simd), gradient[1].load(simd), gradient[2].load(simd)];
                factors = Lanes::new(modulation.factor(simd, world(&self.shading.to_world, gradient)));
            },
        );
        factors
    }

    /// Makes light and opacity of steps anew by their gradients: of those that absorb, their extinction times the [`factors`](Self::factors); or of those
    /// that any row shows, by the [mixture](RowMixture) of the rows.
    #[inline(never)]
    pub fn modulate<S: Simd>(&self, simd: S, gradient: &[Lanes; 3], optics: &StepOptics, light: &mut [Lanes; 4]) {
        if let Some(rows) = &self.shading.rows {
            self.mix(simd, rows, gradient, optics, light);
            return;
        }
        let Some(modulation) = &self.shading.modulation else { return };
        simd.vectorize(
            #[inline(always)]
            || {
                let gradient = [gradient[0].load(simd), gradient[1].load(simd), gradient[2].load(simd)];
                let factor = modulation.factor(simd, world(&self.shading.to_world, gradient));
                let [r, g, b, kappa] = &optics.row;
                let row = [r.load(simd), g.load(simd), b.load(simd), kappa.load(simd) * factor];
                let changed = step_light(simd, row, optics.length.load(simd), optics.emits);
                let absorbs = light[3].load(simd).simd_gt(splat(simd, 0.0));
                for c in 0..4 {
                    light[c] = Lanes::new(pick(absorbs, changed[c], light[c].load(simd)));
                }
            },
        );
    }

    #[inline(never)]
    fn mix<S: Simd>(
        &self,
        simd: S,
        rows: &RowMixture,
        gradient: &[Lanes; 3],
        optics: &StepOptics,
        light: &mut [Lanes; 4],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let gradient = [gradient[0].load(simd), gradient[1].load(simd), gradient[2].load(simd)];
                let mixed = rows.at(simd, optics.value.load(simd), world(&self.shading.to_world, gradient));
                let changed = step_light(simd, mixed, optics.length.load(simd), rows.emits());
                let largest = light[0].load(simd).max(light[1].load(simd)).max(light[2].load(simd));
                let shows = largest.max(light[3].load(simd)).simd_gt(splat(simd, 0.0));
                for c in 0..4 {
                    light[c] = Lanes::new(pick(shows, changed[c], light[c].load(simd)));
                }
            },
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    #[test]
    fn factors_are_those_of_the_shading() {
        let shading =
            Shading { gradient_opacity: vec![(0.5, 0.25), (2.0, 1.0), (2.0, 3.0), (4.0, 0.0)], ..Shading::default() };
        let modulation = Modulation::new(&shading, 2.0).unwrap();
        for gradient in [[0.0f64; 3], [0.1, 0.0, 0.2], [0.6, -0.6, 0.3], [1.0, 0.0, 0.0], [0.0, 0.0, -1.5], [9.0; 3]] {
            let [x, y, z] = gradient.map(|g| g as f32);
            let found = dispatch!(Level::new(), simd => {
                modulation.factor(simd, [splat(simd, x), splat(simd, y), splat(simd, z)])[3]
            });
            let magnitude = 2.0 * gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
            let want = shading.modulation(magnitude) as f32;
            assert!((found - want).abs() < 1e-5, "{gradient:?}: {found} for {want}");
        }
        assert!(Modulation::new(&Shading::default(), 1.0).is_none());
    }
}
