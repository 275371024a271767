//! Light of stretches, sixteen at once.
//!
//! On a stretch the colour c is linear from c₀ to c₁. With the optical depth τ(t) up to a part t of it, by parts:
//! ∫ κ c e^(−τ) = c₁ (1 − e^(−τ(1))) − (c₁ − c₀) ∫ (1 − e^(−τ(t))) dt. The last integral is taken by Gauss's rule of four points, and τ at the points
//! by its collocation, which is exact for extinctions that are linear.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};
use vr_core::OpacityRule;
use vr_kernels::vector::{LANES, Vectorized, depth_of_opacity, opacity_of_depth, splat, transpose};

use super::segments::Segments;
use super::stretches::{Row, Stretches};

/// Nodes of Gauss's rule of four points on [0, 1], and its weights.
const NODES: [f32; 4] = [0.069_431_84, 0.330_009_5, 0.669_990_5, 0.930_568_16];
const WEIGHTS: [f32; 4] = [0.173_927_42, 0.326_072_58, 0.326_072_58, 0.173_927_42];
/// Integrals from 0 to each node of the polynomial through the four nodes.
const UP_TO_NODE: [[f32; 4]; 4] = [
    [0.086_963_71, -0.026_604_18, 0.012_627_463, -0.003_555_149_7],
    [0.188_118_12, 0.163_036_29, -0.027_880_43, 0.006_735_500_6],
    [0.167_191_92, 0.353_953, 0.163_036_29, -0.014_190_695],
    [0.177_482_26, 0.313_445_12, 0.352_676_76, 0.086_963_71],
];

/// Integrates all stretches.
pub(crate) struct Integral<'a> {
    pub(crate) segments: &'a Segments,
    pub(crate) stretches: &'a mut Stretches,
}

impl Vectorized for Integral<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { segments, stretches } = self;
        let count = stretches.rows.len();
        let padded = count.next_multiple_of(LANES);
        stretches.rows.resize(padded, [0.0; 4]);
        stretches.light.resize(padded, [0.0; 4]);
        let (rows, _) = stretches.rows.as_chunks::<LANES>();
        let (light, _) = stretches.light.as_chunks_mut::<LANES>();
        match segments.rule {
            OpacityRule::Extinction => {
                for (rows, light) in rows.iter().zip(light) {
                    integrate::<S, false>(simd, segments, rows, light);
                }
            }
            OpacityRule::Power => {
                for (rows, light) in rows.iter().zip(light) {
                    integrate::<S, true>(simd, segments, rows, light);
                }
            }
        }
        stretches.rows.truncate(count);
    }
}

/// Light and opacity of sixteen stretches.
#[inline(always)]
fn integrate<S: Simd, const POWER: bool>(
    simd: S,
    segments: &Segments,
    rows: &[Row; LANES],
    light: &mut [[f32; 4]; LANES],
) {
    // What the stretches are, and the ends of their pieces.
    let zero = f32x4::splat(simd, 0.0);
    let (mut of_rows, mut start, mut grown) = ([zero; LANES], [zero; LANES], [zero; LANES]);
    for j in 0..LANES {
        of_rows[j] = f32x4::load_array_ref(simd, &rows[j]);
        let piece = &segments.rows[rows[j][3].to_bits() as usize];
        start[j] = f32x4::load_array_ref(simd, &piece[0]);
        grown[j] = f32x4::load_array_ref(simd, &piece[1]);
    }
    let [from, to, length, _] = transpose(of_rows);
    let (start, grown) = (transpose(start), transpose(grown));
    let more = to - from;

    // Depth of each node, for the whole stretch at its extinction.
    let first = start[3] + grown[3] * from;
    let change = grown[3] * more;
    let dense = length * segments.dense;
    let mut steep = [splat(simd, 0.0); 4];
    for k in 0..4 {
        let opacity = first + change * NODES[k];
        steep[k] = if POWER { depth_of_opacity(simd, opacity) * dense } else { opacity * dense };
    }
    // Opacity up to each node, and of the whole.
    let mut mean = splat(simd, 0.0);
    let mut depth = splat(simd, 0.0);
    for k in 0..4 {
        let row = UP_TO_NODE[k];
        let before = steep[0] * row[0] + steep[1] * row[1] + steep[2] * row[2] + steep[3] * row[3];
        mean += opacity_of_depth(simd, before.max(splat(simd, 0.0))) * WEIGHTS[k];
        depth += steep[k] * WEIGHTS[k];
    }
    let opacity = opacity_of_depth(simd, depth);

    // The light of each colour.
    let of = |c: usize| -> f32x16<S> {
        let change = grown[c] * more;
        (start[c] + grown[c] * to) * opacity - change * mean
    };
    let found = [of(0).to_array(), of(1).to_array(), of(2).to_array(), opacity.to_array()];
    for j in 0..LANES {
        light[j] = [found[0][j], found[1][j], found[2][j], found[3][j]];
    }
}
