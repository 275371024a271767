//! From values to light and opacity.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::tables::{PreIntegrated, TablePlace};
use vr_kernels::vector::{
    LANES, Lanes, OpticsTable, Rows, opacity_of_depth, pick, source_weight, splat, step_light, step_of_thickness,
};

use super::chunk::{CHUNK, Chunk};

/// Classification of fragments.
#[derive(Clone, Copy)]
pub(crate) enum Classifier<'a> {
    /// By a look-up in a table of whole slabs, where all are equally long; other lengths by their optical depth.
    Table { rows: Rows<'a>, optics: &'a OpticsTable, even: bool },
    /// One by one in f64, where no table tells apart all that the transfer function does: light and opacity of a stored number and a length in table
    /// lengths.
    Exact(&'a (dyn Fn(f32, f32) -> [f32; 4] + Sync)),
    /// Integrates segments between two values; `brightest`: no stretch shines brighter, channel by channel, where emission is not given on its own.
    Segments { table: &'a PreIntegrated<f32>, brightest: Option<[f32; 3]> },
    /// Texels are light and opacity of one table length.
    Done { even: bool },
    /// Not at all: the operator picks a value.
    Values,
}

/// Turns the values of a chunk into light and opacity of slabs so long, in table lengths. `outer`: the first or the last of rays, and no whole ones.
#[inline(never)]
pub(crate) fn classify<S: Simd>(simd: S, with: &Classifier<'_>, ratio: &Lanes, outer: bool, chunk: &mut Chunk) {
    simd.vectorize(
        #[inline(always)]
        || match *with {
            Classifier::Table { rows, even: true, .. } if !outer => {
                for j in 0..chunk.len {
                    let value = chunk.value[j].load(simd);
                    let [r, g, b, a] = rows.at(simd, value);
                    let a = where_defined(simd, value, a);
                    chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
            }
            Classifier::Table { optics, .. } => {
                let ratio = ratio.load(simd);
                for j in 0..chunk.len {
                    let value = chunk.value[j].load(simd);
                    let found = optics.rows().at(simd, value);
                    let [r, g, b, a] = step_light(simd, found, ratio, optics.emits);
                    let a = where_defined(simd, value, a);
                    chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
            }
            Classifier::Exact(light) => {
                for j in 0..chunk.len {
                    for i in 0..LANES {
                        let found = light(chunk.value[j].0[i], ratio.0[i]);
                        (0..4).for_each(|c| chunk.light[j][c].0[i] = found[c]);
                    }
                }
            }
            Classifier::Done { even } if outer || !even => {
                let ratio = ratio.load(simd);
                for j in 0..chunk.len {
                    let [r, g, b, a] = &chunk.light[j];
                    let light = [r.load(simd), g.load(simd), b.load(simd), a.load(simd)];
                    let [r, g, b, corrected] = step_of_thickness(simd, light, ratio);
                    let a = where_defined(simd, light[3], corrected);
                    chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
            }
            Classifier::Done { .. } | Classifier::Segments { .. } | Classifier::Values => {}
        },
    );
}

/// Vacuum stays NaN: whatever a table has said of it.
#[inline(always)]
fn where_defined<S: Simd>(simd: S, value: f32x16<S>, alpha: f32x16<S>) -> f32x16<S> {
    pick(value.simd_eq(value), alpha, splat(simd, f32::NAN))
}

/// Light and opacity of segments that end at the values of a chunk, each so long in world units; each begins where the one before it ended, the first at
/// `before`.
///
/// The table's own arithmetic ([`PreIntegrated::segment`]), the exponential and all behind it for sixteen segments at a time. Opaque walls are left to the
/// table.
#[inline(never)]
pub(crate) fn integrate<S: Simd>(
    simd: S,
    (table, brightest): (&PreIntegrated<f32>, Option<[f32; 3]>),
    before: &Lanes,
    length: &[Lanes; CHUNK],
    backwards: bool,
    chunk: &mut Chunk,
) {
    if table.has_walls() {
        return walled(table, before, length, backwards, chunk);
    }
    simd.vectorize(
        #[inline(always)]
        || {
            let mut near = [TablePlace { row: 0, fraction: 0.0 }; LANES];
            for i in 0..LANES {
                near[i] = table.place(before.0[i]);
            }
            for j in 0..chunk.len {
                let (mut mean, mut front, mut back) = ([Lanes::ZERO; 4], [Lanes::ZERO; 4], [Lanes::ZERO; 4]);
                for i in 0..LANES {
                    let far = table.place(chunk.value[j].0[i]);
                    let (m, p, q) = (table.mean_between(near[i], far), table.at(near[i]), table.at(far));
                    for c in 0..4 {
                        (mean[c].0[i], front[c].0[i], back[c].0[i]) = (m[c], p[c], q[c]);
                    }
                    near[i] = far;
                }
                if backwards {
                    (front, back) = (back, front);
                }
                let (zero, one, h) = (splat(simd, 0.0), splat(simd, 1.0), length[j].load(simd));
                let kappa = mean[3].load(simd);
                let tau = kappa * h;
                let alpha = where_defined(simd, kappa, opacity_of_depth(simd, tau));
                let weight = source_weight(simd, tau, alpha);
                let (tau_a, tau_b) = (front[3].load(simd) * h, back[3].load(simd) * h);
                let fade = one / (tau * (tau * 1.5 + 6.0) + 12.0);
                let product = tau_a * tau_b;
                let thin = product.simd_le(zero);
                let moment = fade * pick(thin, one, tau * tau / pick(thin, one, product)).min(one);
                for c in 0..3 {
                    let turned = front[c].load(simd) * h * tau_b - back[c].load(simd) * h * tau_a;
                    let mut light = (mean[c].load(simd) * h * weight + moment * turned).max(zero);
                    if let Some(max) = brightest {
                        light = light.min(alpha * max[c]);
                    }
                    chunk.light[j][c] = Lanes::new(light);
                }
                chunk.light[j][3] = Lanes::new(alpha);
            }
        },
    );
}

/// One by one: segments may end at a wall.
fn walled(table: &PreIntegrated<f32>, before: &Lanes, length: &[Lanes; CHUNK], backwards: bool, chunk: &mut Chunk) {
    let mut near = *before;
    for j in 0..chunk.len {
        for i in 0..LANES {
            let (mut front, mut back) = (near.0[i], chunk.value[j].0[i]);
            if backwards {
                (front, back) = (back, front);
            }
            let segment = table.segment(front, back, length[j].0[i]);
            for c in 0..4 {
                chunk.light[j][c].0[i] = segment[c];
            }
        }
        near = chunk.value[j];
    }
}
