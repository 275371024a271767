//! From values to light and opacity.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_core::transfer::PreIntegrated;
use vr_core::vector::{LANES, Lanes, OpticsTable, Rows, depth_of_opacity, light_of, opacity_of_depth, pick, splat};

use super::chunk::Chunk;

/// How fragments are classified.
#[derive(Clone, Copy)]
pub(crate) enum Classifier<'a> {
    /// By a look-up in a table of whole slabs, where all are equally long; other lengths by their optical depth.
    Table { rows: Rows<'a>, optics: &'a OpticsTable, even: bool },
    /// One by one in f64, where no table tells apart all that the transfer function does: light and opacity of a stored number and a length in table
    /// lengths.
    Exact(&'a (dyn Fn(f32, f32) -> [f32; 4] + Sync)),
    /// As segments between two values.
    Segments(&'a PreIntegrated<f32>),
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
                    chunk.light[j] = [Lanes::of(r), Lanes::of(g), Lanes::of(b), Lanes::of(a)];
                }
            }
            Classifier::Table { optics, .. } => {
                let ratio = ratio.load(simd);
                for j in 0..chunk.len {
                    let value = chunk.value[j].load(simd);
                    let found = optics.rows().at(simd, value);
                    let [r, g, b, a] = light_of(simd, found, ratio, optics.emits);
                    let a = where_defined(simd, value, a);
                    chunk.light[j] = [Lanes::of(r), Lanes::of(g), Lanes::of(b), Lanes::of(a)];
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
                    let [r, g, b, a] = corrected(simd, light, ratio);
                    chunk.light[j] = [Lanes::of(r), Lanes::of(g), Lanes::of(b), Lanes::of(a)];
                }
            }
            Classifier::Done { .. } | Classifier::Segments(_) | Classifier::Values => {}
        },
    );
}

/// Vacuum stays NaN: whatever a table has said of it.
#[inline(always)]
fn where_defined<S: Simd>(simd: S, value: f32x16<S>, alpha: f32x16<S>) -> f32x16<S> {
    pick(value.simd_eq(value), alpha, splat(simd, f32::NAN))
}

/// Light and opacity of a slab `ratio` times as long: α′ = 1 − (1 − α)^ratio, and light grows with it.
#[inline(always)]
fn corrected<S: Simd>(simd: S, [r, g, b, alpha]: [f32x16<S>; 4], ratio: f32x16<S>) -> [f32x16<S>; 4] {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let corrected = opacity_of_depth(simd, depth_of_opacity(simd, alpha) * ratio);
    let clear = alpha.simd_le(zero);
    // Where nothing absorbs, light grows with the length itself.
    let share = pick(clear, ratio, corrected / pick(clear, one, alpha));
    [r * share, g * share, b * share, where_defined(simd, alpha, pick(clear, zero, corrected))]
}

/// Light and opacity of segments that end at the values of a chunk; each begins where the one before it ended, the first at `before`. `length`: of each of
/// them, in world units.
pub(crate) fn integrate(
    table: &PreIntegrated<f32>,
    before: &mut Lanes,
    length: impl Fn(usize, usize) -> f32,
    backwards: bool,
    chunk: &mut Chunk,
) {
    for j in 0..chunk.len {
        for i in 0..LANES {
            let (mut front, mut back) = (before.0[i], chunk.value[j].0[i]);
            if backwards {
                (front, back) = (back, front);
            }
            let segment = table.segment(front, back, length(j, i));
            for c in 0..4 {
                chunk.light[j][c].0[i] = segment[c];
            }
        }
        *before = chunk.value[j];
    }
}
