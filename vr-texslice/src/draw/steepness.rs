//! Opacity that follows the gradient, of sixteen fragments at a time: after a first classification has told which of them have any light at all.

use fearless_simd::Simd;
use vr_core::Real;
use vr_kernels::vector::{LANES, Lanes, OpticsTable, SegmentTable, Shade, StepOptics};

use super::chunk::{CHUNK, Chunk};
use super::classify::integrate;
use crate::medium::without_extinction;

/// Medium of fragments by value and gradient.
#[derive(Clone, Copy)]
pub(crate) enum Steepness<'a> {
    /// Samples by a table of their optics: a factor on the extinction, or a mixture of rows.
    Samples { shade: Shade<'a>, optics: &'a OpticsTable },
    /// Samples one by one in f64: light and opacity by stored number, length in table lengths and gradient per step of texture coordinates.
    Exact(&'a (dyn Fn(f32, f32, [f32; 3]) -> [f32; 4] + Sync)),
    /// A factor on the extinction of segments; `emits`: emission is given on its own, which no factor changes.
    SegmentFactor { factor: Shade<'a>, table: &'a SegmentTable, emits: bool },
    /// Segments one by one: light and opacity by the stored numbers in front and at the back, world length and gradient.
    Segments(&'a (dyn Fn([f32; 2], f32, [f32; 3]) -> [f32; 4] + Sync)),
}

/// Factor below which emission is divided by this one: nothing that f32 can show is left of extinction.
const SMALLEST_FACTOR: f32 = 1e-12;

impl Steepness<'_> {
    /// Classifies a chunk's samples anew, for slabs so long in table lengths, by their values and gradients.
    #[inline(never)]
    pub(crate) fn classify<S: Simd>(&self, simd: S, ratio: &Lanes, chunk: &mut Chunk) {
        simd.vectorize(
            #[inline(always)]
            || {
                for j in 0..chunk.len {
                    let lit = chunk.lit(simd, j);
                    if lit == 0 {
                        continue;
                    }
                    let (value, gradient, light) = (&chunk.value[j], &chunk.gradient[j], &mut chunk.light[j]);
                    match *self {
                        Self::Samples { shade, optics } => {
                            let row = optics.rows().at(simd, value.load(simd));
                            let row = [Lanes::new(row[0]), Lanes::new(row[1]), Lanes::new(row[2]), Lanes::new(row[3])];
                            let optics = StepOptics { value: *value, row, length: *ratio, emits: optics.emits };
                            shade.modulate(simd, gradient, &optics, light);
                        }
                        Self::Exact(medium) => {
                            for i in (0..LANES).filter(|i| lit >> i & 1 == 1) {
                                let found = medium(value.0[i], ratio.0[i], gradient.each_ref().map(|g| g.0[i]));
                                (0..4).for_each(|c| light[c].0[i] = found[c]);
                            }
                        }
                        Self::SegmentFactor { .. } | Self::Segments(_) => {}
                    }
                }
            },
        );
    }

    /// Integrates a chunk's segments anew, each so long in world units, by the gradients in their middles; see [`integrate`].
    #[inline(never)]
    pub(crate) fn integrate<S: Simd>(
        &self,
        simd: S,
        before: &Lanes,
        length: &[Lanes; CHUNK],
        backwards: bool,
        chunk: &mut Chunk,
    ) {
        // The ends of the segment at a sample, in front and at the back.
        let ends = |chunk: &Chunk, j: usize, i: usize| {
            let begin = if j == 0 { before } else { &chunk.value[j - 1] };
            let [begin, end] = [begin.0[i], chunk.value[j].0[i]];
            if backwards { [end, begin] } else { [begin, end] }
        };
        match *self {
            Self::SegmentFactor { factor, table, emits } => {
                let factor: [Lanes; CHUNK] = std::array::from_fn(|j| {
                    let found = if j < chunk.len { factor.factors(simd, &chunk.gradient[j]) } else { Lanes::ZERO };
                    Lanes(found.0.map(|f| if emits && f > 0.0 { f.max(SMALLEST_FACTOR) } else { f }))
                });
                let stretched =
                    std::array::from_fn(|j| Lanes(std::array::from_fn(|i| length[j].0[i] * factor[j].0[i])));
                integrate(simd, table, before, &stretched, backwards, chunk);
                for j in 0..chunk.len {
                    for i in 0..LANES {
                        let f = factor[j].0[i];
                        if chunk.light[j][3].0[i].is_nan() {
                            continue;
                        }
                        if f == 0.0 {
                            // No wall is met either.
                            let ends = ends(chunk, j, i);
                            let table = &**table.pre_integrated();
                            let found = without_extinction(table, ends, emits, length[j].0[i].to_f64());
                            (0..4).for_each(|c| chunk.light[j][c].0[i] = found[c] as f32);
                        } else if emits {
                            (0..3).for_each(|c| chunk.light[j][c].0[i] /= f);
                        }
                    }
                }
            }
            Self::Segments(medium) => {
                for j in 0..chunk.len {
                    for i in 0..LANES {
                        if (0..4).any(|c| chunk.light[j][c].0[i] > 0.0) {
                            let gradient = chunk.gradient[j].each_ref().map(|g| g.0[i]);
                            let found = medium(ends(chunk, j, i), length[j].0[i], gradient);
                            (0..4).for_each(|c| chunk.light[j][c].0[i] = found[c]);
                        }
                    }
                }
            }
            Self::Samples { .. } | Self::Exact(_) => {}
        }
    }
}
