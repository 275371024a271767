//! Sections of a radially symmetric kernel, tabulated.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};
use vr_kernels::vector::{LANES, splat, transpose};

use crate::kernel::{Radial, quadrature};

/// Intervals over the distance b of a line from the middle.
const ACROSS: usize = 512;
/// Intervals over the place z along the line.
const ALONG: usize = 128;

/// Places along the line that are integrated on their own.
const NEAR_MIDDLE: usize = 4;

/// G(b, z) = ∫₀ᶻ W along a line that passes the middle of a kernel at a distance b, both from 0 to 1.
///
/// Linear in b; from the nearest z onwards by the kernel's own value there. What a section between two places holds is a difference of two look-ups,
/// so that sections next to each other sum to the whole, whatever the table's error.
pub(crate) struct SectionTable {
    /// (G, W) over b, row by row of z. Rows end with an entry of zeros twice.
    entries: Vec<[f32; 2]>,
}

/// Entries to a row.
const ROW: usize = ACROSS + 2;

impl SectionTable {
    pub(crate) fn new(radial: &Radial) -> Self {
        let mut entries = vec![[0.0f32; 2]; (ALONG + 1) * ROW];
        for i in 0..ACROSS {
            let b = i as f64 / ACROSS as f64;
            let value = |z: f64| radial.at((b * b + z * z).sqrt());
            let mut sum = 0.0;
            for k in 0..=ALONG {
                let z = k as f64 / ALONG as f64;
                // Near the middle, where a kernel may have a kink, with more care; then step by step.
                if k < NEAR_MIDDLE {
                    sum = radial.along_line(b, z);
                } else {
                    sum += quadrature(z - 1.0 / ALONG as f64, z, 1, value);
                }
                entries[k * ROW + i] = [sum as f32, value(z) as f32];
            }
        }
        Self { entries }
    }

    /// G for b in [0, 1] and z in [−1, 1].
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, b: f32x16<S>, z: f32x16<S>) -> f32x16<S> {
        let along = z.abs() * ALONG as f32;
        let row: i32x16<S> = (along + 0.5).to_int();
        let onwards = (along - row.to_float::<f32x16<S>>()) * (1.0 / ALONG as f32);
        let across = b * ACROSS as f32;
        let column: i32x16<S> = across.to_int();
        let t = across - column.to_float::<f32x16<S>>();
        let index = (row * i32x16::splat(simd, ROW as i32) + column).to_array();
        let flat = self.entries.as_flattened();
        let mut pairs = [f32x4::splat(simd, 0.0); LANES];
        for i in 0..LANES {
            let o = 2 * (index[i] as u32 as usize);
            pairs[i] = f32x4::from_slice(simd, &flat[o..o + 4]);
        }
        let [g0, w0, g1, w1] = transpose(pairs);
        let g = g0 + t * (g1 - g0) + onwards * (w0 + t * (w1 - w0));
        // No more than is there, and with the sign of z.
        let size = g.max(splat(simd, 0.0));
        vr_kernels::vector::pick(z.simd_lt(splat(simd, 0.0)), -size, size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{Profile, Shape, SplatKernel};
    use fearless_simd::{Level, dispatch};
    use vr_core::PointKernel;

    #[inline(always)]
    fn look_up<S: Simd>(simd: S, table: &SectionTable, b: f32, z: f32) -> f32 {
        table.at(simd, splat(simd, b), splat(simd, z)).to_array()[3]
    }

    #[test]
    fn tables_are_what_quadrature_gives() {
        let shapes = [Shape::Gaussian, Shape::Cone].map(|s| SplatKernel::new(s).profile());
        for profile in shapes.into_iter().chain(PointKernel::ALL.map(Profile::point)) {
            let Profile::Radial(radial) = profile else { unreachable!("all of these are") };
            let table = SectionTable::new(&radial);
            let peak = 2.0 * radial.along_line(0.0, 1.0);
            let mut worst = 0.0f64;
            for i in 0..=100 {
                for k in -50..=50 {
                    let (b, z) = (f64::from(i) / 100.0, f64::from(k) / 50.0);
                    let got = dispatch!(Level::new(), simd => look_up(simd, &table, b as f32, z as f32));
                    worst = worst.max((f64::from(got) - radial.along_line(b, z)).abs());
                }
            }
            // h²/8 of the second derivative across, and half of a row's square of the slope along: 10⁻⁵ to 5·10⁻⁵ of the peak.
            assert!(worst < 5e-5 * peak, "{profile:?}: {worst:e} of {peak}");
        }
    }
}
