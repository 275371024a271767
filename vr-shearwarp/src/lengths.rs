//! Opacity corrected for how far apart slices are along a ray, by a table.
//!
//! Along one ray that distance is the same everywhere. Parallel rays all have the same: the table is of their samples. In perspective it grows
//! towards the picture's edge. The table is then of the shortest distance there can be, straight along the axis, and each texel has a ratio
//! to that by which optical depths grow.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::splat;

use crate::codes::Code;
use crate::composite::cells::STEPS_F32;
use crate::factorization::{Factorization, IndexView};
use crate::optics::{Entry, Optics};

/// The table of a view, and how much longer the texels' samples are than its entries.
pub(crate) struct Lengths<P: Code> {
    pub(crate) table: Box<P::Table>,
    /// None where the table is of the samples' own length.
    pub(crate) ratios: Option<Ratios>,
}

/// Ratio of each texel's distance between slices to that of the table.
///
/// Its square is a quadratic of x in each row: `bend·(x − middle)² + min`, in which nothing cancels.
pub(crate) struct Ratios {
    bend: f32,
    /// Middle and minimum of each row.
    rows: Vec<[f32; 2]>,
}

impl<P: Code> Lengths<P> {
    /// `spacing`: part of a voxel from slice to slice. Without `correction` every sample stands for the same length as in a view straight
    /// along the axis, which is wrong and shows what correction is for. `entry`: what the table holds.
    pub(crate) fn new(
        optics: &Optics,
        view: &IndexView,
        factorization: &Factorization,
        spacing: f64,
        correction: bool,
        entry: Entry,
    ) -> Self {
        if !view.is_perspective() || !correction {
            let length = length(view, factorization, [0.0; 2], correction) * spacing;
            return Self { table: P::table(optics.entries(length, entry)), ratios: None };
        }
        let shortest = length(view, factorization, [0.0; 2], false);
        let table = P::table(optics.entries(shortest * spacing, entry));
        Self { table, ratios: Some(Ratios::new(view, factorization, shortest)) }
    }
}

impl Ratios {
    fn new(view: &IndexView, factorization: &Factorization, shortest: f64) -> Self {
        // A texel's step along its ray is linear in x: from three texels of a row the quadratic is known.
        let square = |x: f64, y: usize| (length(view, factorization, [x, y as f64], true) / shortest).powi(2);
        let [width, height] = factorization.size;
        let reach = width as f64;
        let row = |y: usize| {
            let [a, b, c] = [0.0, reach, 2.0 * reach].map(|x| square(x, y));
            let bend = 0.5 * (a - 2.0 * b + c) / (reach * reach);
            let middle = -0.5 * ((b - a) / reach - bend * reach) / bend;
            (bend, [middle, square(middle, y)])
        };
        Self { bend: row(0).0 as f32, rows: (0..height).map(|y| row(y).1.map(|v| v as f32)).collect() }
    }

    /// The ratios of sixteen texels from (x, y) on.
    #[inline(always)]
    pub(crate) fn lanes<S: Simd>(&self, simd: S, x: usize, y: usize) -> f32x16<S> {
        let [middle, min] = self.rows[y];
        let off = f32x16::load_array_ref(simd, &STEPS_F32) + splat(simd, x as f32) - middle;
        (off * off * self.bend + min).sqrt()
    }

    /// The ratio of one texel.
    #[cfg(test)]
    pub(crate) fn at(&self, x: usize, y: usize) -> f64 {
        let [middle, min] = self.rows[y].map(f64::from);
        ((x as f64 - middle).powi(2) * f64::from(self.bend) + min).sqrt()
    }
}

/// World length that a sample of a texel's ray stands for, were slices a voxel apart.
pub(crate) fn length(view: &IndexView, factorization: &Factorization, [x, y]: [f64; 2], correction: bool) -> f64 {
    let mut step = factorization.step(x, y);
    if !correction {
        let along = factorization.axes[2];
        step = glam::DVec3::AXES[along];
    }
    view.world_length(step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::passes::{TexelLattice, passes};
    use glam::DVec3;
    use vr_core::{Camera, Placement, Projection, View};

    #[test]
    fn ratios_are_those_of_the_lengths() {
        let camera = Camera {
            eye: DVec3::new(90.0, 35.0, 60.0),
            target: DVec3::new(10.0, 20.0, 30.0),
            up: DVec3::Y,
            projection: Projection::Perspective { fov: 80.0 },
        };
        let placement = Placement::from_spacing([1.0, 1.5, 0.7]).unwrap();
        let view = IndexView::new(&View::new(camera, [64, 64]), &placement).unwrap();
        let last = DVec3::new(40.0, 30.0, 90.0);
        let passes = passes(&view, [DVec3::ZERO, last], last, TexelLattice { texel: 0.5, nearest: false }).unwrap();
        assert!(!passes.is_empty());
        for pass in &passes {
            let f = &pass.factorization;
            let shortest = length(&view, f, [0.0; 2], false);
            let ratios = Ratios::new(&view, f, shortest);
            for (x, y) in [(0, 0), (f.size[0] - 1, 0), (f.size[0] / 2, f.size[1] / 3), (1, f.size[1] - 1)] {
                let wanted = length(&view, f, [x as f64, y as f64], true) / shortest;
                assert!((ratios.at(x, y) / wanted - 1.0).abs() < 1e-6, "{x} {y}: {} {wanted}", ratios.at(x, y));
            }
        }
    }
}
