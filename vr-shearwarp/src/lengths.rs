//! Opacity corrected for how far apart slices are along a ray, by tables.
//!
//! Along one ray that distance is the same everywhere. Parallel rays all have the same: one table serves a view. In perspective it grows
//! towards the picture's edge: texels are put into classes whose lengths are half a percent apart, each with its table, so that an optical
//! depth is off by a quarter of a percent at most.

use crate::codes::Code;
use crate::factorization::{Factorization, IndexView};
use crate::optics::Optics;

/// The classes of a view's texels, and their tables.
pub(crate) struct Lengths<P: Code> {
    tables: Vec<Box<P::Table>>,
    /// For each row of texels, where classes end and which they are; one for all rows where there is but one class.
    rows: Vec<Vec<(u32, u16)>>,
    single: bool,
}

/// Lengths of neighbouring classes differ by this part.
const STEP: f64 = 0.005;
/// Classes from one exact table to the next; between, opacities are interpolated, to 10⁻⁴.
const EXACT_EVERY: usize = 8;

impl<P: Code> Lengths<P> {
    /// `spacing`: part of a voxel from slice to slice. Without `correction` every sample stands for the same length as in a view straight
    /// along the axis, which is wrong and shows what correction is for.
    pub(crate) fn new(
        optics: &Optics,
        view: &IndexView,
        factorization: &Factorization,
        spacing: f64,
        correction: bool,
    ) -> Self {
        let length = |x: f64, y: f64| length(view, factorization, [x, y], correction) * spacing;
        let [width, height] = factorization.size;
        if !view.is_perspective() || !correction {
            let tables = vec![optics.table::<P>(length(0.0, 0.0))];
            return Self { tables, rows: vec![vec![(u32::MAX, 0)]], single: true };
        }
        let square = |x: usize, y: usize| length(x as f64, y as f64).powi(2);
        // The squared length is a quadratic of x: known from three texels of a row.
        let coefficients = |y: usize| {
            let [a, b, c] = [0, 1, 2].map(|x| square(x, y));
            let bend = 0.5 * (a - 2.0 * b + c);
            [a, b - a - bend, bend]
        };
        let at = |q: [f64; 3], x: usize| q[0] + x as f64 * (q[1] + x as f64 * q[2]);
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        let rows: Vec<[f64; 3]> = (0..height).map(coefficients).collect();
        for &q in &rows {
            let lowest = if q[2] > 0.0 { (-0.5 * q[1] / q[2]).clamp(0.0, (width - 1) as f64) } else { 0.0 };
            for x in [0, width - 1, lowest.floor() as usize] {
                least = least.min(at(q, x));
                most = most.max(at(q, x));
            }
        }
        let least = least.sqrt();
        let classes = (libm::log(most.sqrt() / least) / STEP).round().max(0.0) as usize + 1;
        // Squares of the lengths where one class ends and the next begins.
        let bounds: Vec<f64> = (0..classes).map(|k| (least * libm::exp((k as f64 + 0.5) * STEP)).powi(2)).collect();
        let rows = rows.iter().map(|&q| {
            let mut stretches = Vec::new();
            let mut class = 0;
            for x in 0..width {
                let here = at(q, x);
                let before = class;
                while class + 1 < classes && here > bounds[class] {
                    class += 1;
                }
                while class > 0 && here <= bounds[class - 1] {
                    class -= 1;
                }
                if x > 0 && class != before {
                    stretches.push((x as u32, before as u16));
                }
            }
            stretches.push((u32::MAX, class as u16));
            stretches
        });
        Self { rows: rows.collect(), tables: tables::<P>(optics, least, classes), single: false }
    }

    /// The table of a texel's class, and the first texel behind it that may have another.
    #[inline(always)]
    pub(crate) fn at(&self, x: usize, y: usize) -> (&P::Table, usize) {
        if self.single {
            return (&self.tables[0], usize::MAX);
        }
        let row = &self.rows[y];
        let (end, class) = row[row.partition_point(|&(end, _)| end as usize <= x)];
        (&self.tables[usize::from(class)], end as usize)
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

fn tables<P: Code>(optics: &Optics, least: f64, classes: usize) -> Vec<Box<P::Table>> {
    let length = |class: usize| least * libm::exp(class as f64 * STEP);
    let exact = |class: usize| -> Vec<[f32; 4]> { optics.entries(length(class)).collect() };
    let mut tables = Vec::with_capacity(classes);
    let mut next = exact(0);
    for first in (0..classes).step_by(EXACT_EVERY) {
        let here = std::mem::take(&mut next);
        if first + 1 < classes {
            next = exact(first + EXACT_EVERY);
        }
        tables.push(P::table(here.iter().copied()));
        for class in (first + 1)..(first + EXACT_EVERY).min(classes) {
            let t = (length(class) - length(first)) / (length(first + EXACT_EVERY) - length(first));
            let mix = |(a, b): (&[f32; 4], &[f32; 4])| std::array::from_fn(|c| a[c] + t as f32 * (b[c] - a[c]));
            tables.push(P::table(here.iter().zip(&next).map(mix)));
        }
    }
    tables
}
