//! Light of stretches, sixteen at once.
//!
//! On a stretch the colour c is linear from c₀ to c₁. With the optical depth τ(t) up to a part t of it, by parts:
//! ∫ κ c e^(−τ) = c₁ (1 − e^(−τ(1))) − (c₁ − c₀) ∫ (1 − e^(−τ(t))) dt. The last integral is taken by Gauss's rule of four points, and τ at the points
//! by its collocation, which is exact for extinctions that are linear. Where something is shaded, the rule is applied to the light itself, and its
//! weights are scaled so that they sum to the opacity.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};
use vr_core::{OpacityRule, Shading};
use vr_kernels::vector::{
    LANES, PacketLights, SeenLights, Vectorized, depth_of_opacity, opacity_of_depth, pick, reflect, splat, transpose,
};

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
pub(crate) struct Integral<'a, const N: usize> {
    pub(crate) segments: &'a Segments,
    pub(crate) stretches: &'a mut Stretches<N>,
    pub(crate) lit: Option<Lit<'a>>,
}

/// Shading, and the lights as the ray of each lane sees them.
pub(crate) struct Lit<'a> {
    pub(crate) shading: &'a Shading,
    pub(crate) of_lanes: &'a [SeenLights],
    pub(crate) lights: &'a mut PacketLights,
}

impl<const N: usize> Vectorized for Integral<'_, N> {
    type Output = ();
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { segments, stretches, mut lit } = self;
        let count = stretches.rows.len();
        let padded = count.next_multiple_of(LANES);
        stretches.rows.resize(padded, [0.0; 4]);
        stretches.light.resize(padded, [0.0; 4]);
        if N > 1 {
            stretches.gradients.resize(padded, [[0.0; 4]; 2]);
            stretches.lanes.resize(padded, 0);
        }
        let (rows, _) = stretches.rows.as_chunks::<LANES>();
        let (light, _) = stretches.light.as_chunks_mut::<LANES>();
        for (i, (rows, light)) in rows.iter().zip(light).enumerate() {
            let steep = match segments.rule {
                OpacityRule::Extinction => Steep::of::<false>(simd, segments, rows),
                OpacityRule::Power => Steep::of::<true>(simd, segments, rows),
            };
            let found = match &mut lit {
                Some(lit) if N > 1 => {
                    let these = i * LANES..(i + 1) * LANES;
                    let lanes = &stretches.lanes[these.clone()];
                    let none = &lit.of_lanes[0];
                    let mut seen = [none; LANES];
                    for j in 0..LANES {
                        seen[j] = &lit.of_lanes[lanes[j] as usize];
                    }
                    lit.lights.gather(&seen);
                    steep.shaded(simd, &stretches.gradients[these], lit.shading, lit.lights)
                }
                _ => steep.plain(simd),
            };
            let found = [found[0].to_array(), found[1].to_array(), found[2].to_array(), found[3].to_array()];
            for j in 0..LANES {
                light[j] = [found[0][j], found[1][j], found[2][j], found[3][j]];
            }
        }
        stretches.rows.truncate(count);
    }
}

/// Extinctions of sixteen stretches, and what follows from them.
struct Steep<S: Simd> {
    /// Colours at the first ends, and how they change.
    first: [f32x16<S>; 3],
    change: [f32x16<S>; 3],
    /// Depth of the whole stretch at the extinction of each node, and opacity up to it.
    nodes: [f32x16<S>; 4],
    before: [f32x16<S>; 4],
    opacity: f32x16<S>,
}

impl<S: Simd> Steep<S> {
    #[inline(always)]
    fn of<const POWER: bool>(simd: S, segments: &Segments, rows: &[Row; LANES]) -> Self {
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

        // Depth of the whole stretch at each node's extinction.
        let alpha = start[3] + grown[3] * from;
        let change = grown[3] * more;
        let dense = length * segments.dense;
        let nothing = splat(simd, 0.0);
        let mut nodes = [nothing; 4];
        for k in 0..4 {
            let alpha = alpha + change * NODES[k];
            nodes[k] = if POWER { depth_of_opacity(simd, alpha) * dense } else { alpha * dense };
        }
        // Opacity up to each node, and of the whole.
        let (mut before, mut depth) = ([nothing; 4], nothing);
        for k in 0..4 {
            let row = UP_TO_NODE[k];
            let up_to = nodes[0] * row[0] + nodes[1] * row[1] + nodes[2] * row[2] + nodes[3] * row[3];
            before[k] = opacity_of_depth(simd, up_to.max(nothing));
            depth += nodes[k] * WEIGHTS[k];
        }
        Self {
            first: [start[0] + grown[0] * from, start[1] + grown[1] * from, start[2] + grown[2] * from],
            change: [grown[0] * more, grown[1] * more, grown[2] * more],
            nodes,
            before,
            opacity: opacity_of_depth(simd, depth),
        }
    }

    /// Light without shading, and opacity.
    #[inline(always)]
    fn plain(&self, simd: S) -> [f32x16<S>; 4] {
        let mut mean = splat(simd, 0.0);
        for k in 0..4 {
            mean += self.before[k] * WEIGHTS[k];
        }
        let mut light = [self.opacity; 4];
        for c in 0..3 {
            light[c] = (self.first[c] + self.change[c]) * self.opacity - self.change[c] * mean;
        }
        light
    }

    /// Light that is shaded by gradients which are linear between both ends, and opacity.
    #[inline(always)]
    fn shaded(&self, simd: S, gradients: &[[[f32; 4]; 2]], shading: &Shading, lights: &PacketLights) -> [f32x16<S>; 4] {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let none = f32x4::splat(simd, 0.0);
        let (mut from, mut to) = ([none; LANES], [none; LANES]);
        for j in 0..LANES {
            from[j] = f32x4::load_array_ref(simd, &gradients[j][0]);
            to[j] = f32x4::load_array_ref(simd, &gradients[j][1]);
        }
        let (from, to) = (transpose(from), transpose(to));
        let (mut light, mut sum) = ([zero; 3], zero);
        for k in 0..4 {
            let weight = (one - self.before[k]) * self.nodes[k] * WEIGHTS[k];
            let at = NODES[k];
            let gradient =
                [from[0] + (to[0] - from[0]) * at, from[1] + (to[1] - from[1]) * at, from[2] + (to[2] - from[2]) * at];
            let flat = gradient[0].abs().max(gradient[1].abs()).max(gradient[2].abs()).simd_le(zero);
            let reflected = reflect(simd, shading, lights, gradient);
            for c in 0..3 {
                let color = self.first[c] + self.change[c] * at;
                let lit = color * pick(flat, one, reflected[c]) + pick(flat, zero, reflected[3 + c]);
                light[c] += lit * weight;
            }
            sum += weight;
        }
        let some = sum.simd_gt(zero);
        let share = pick(some, self.opacity / pick(some, sum, one), zero);
        [light[0] * share, light[1] * share, light[2] * share, self.opacity]
    }
}
