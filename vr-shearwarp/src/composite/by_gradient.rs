//! Samples whose opacity follows the gradient, or that are shaded by the trilinear filter's own, or have colours of their own.
//!
//! The medium is a mixture of the nodes of its steepness, extinction and emission linear in the gradient's length: so each node has a table of
//! light and optical depth that absorb nothing yet, and a sample is their weighted sum before it becomes opacity.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16};
use vr_core::ColorGrid;
use vr_kernels::vector::{LANES, splat, step_of_thickness, transpose};

use super::cells::{Columns, Edges, Places, values};
use super::gradients::{GradientShading, Gradients, lengths};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use super::over::{Over, UNSHADED, of_depth};
use crate::codes::Code;
use crate::lengths::Lengths;

/// Over and accumulate of samples that look at the gradient.
pub(crate) struct ByGradient<'a, P: Code, const PRE_CLASSIFIED: bool> {
    /// Compositing.
    pub(crate) over: Over<'a, P, PRE_CLASSIFIED, UNSHADED>,
    /// The medium at lengths of the gradient, in their order.
    pub(crate) nodes: &'a [Node<P>],
    pub(crate) gradients: &'a Gradients<'a>,
    /// Colours of voxels, channel by channel, by which light is multiplied before it reflects; `None` where they have none.
    pub(crate) colors: Option<[&'a [u16]; 3]>,
    pub(crate) shading: &'a GradientShading<'a>,
}

/// Tables of the medium at one length of the gradient, and which lengths have a share of it.
pub(crate) struct Node<P: Code> {
    pub(crate) lengths: Lengths<P>,
    pub(crate) hat: Hat,
}

/// Share of a node among steepnesses: 1 at the node, falling linearly to 0 at its neighbours; 1 beyond the first and the last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hat {
    /// Steepness at which the share begins to rise, and the rise.
    up: [f32; 2],
    /// Steepness at which it begins to fall, and the fall.
    down: [f32; 2],
}

/// A step of the share that is as steep as a number can be.
const STEEPEST: f32 = 1e30;

impl Hat {
    /// Hats of nodes in ascending order.
    pub(crate) fn of_nodes(nodes: &[f64]) -> Vec<Self> {
        // Finite in f32, however large the lengths.
        let slope = |from: f64, to: f64| {
            let rise = (to - from).recip() as f32;
            [(from as f32).min(STEEPEST), rise.clamp(STEEPEST.recip(), STEEPEST)]
        };
        let hat = |i: usize| Self {
            up: if i == 0 { [-1.0, STEEPEST] } else { slope(nodes[i - 1], nodes[i]) },
            down: nodes.get(i + 1).map_or([f32::MAX, 1.0], |&next| slope(nodes[i], next)),
        };
        (0..nodes.len()).map(hat).collect()
    }

    pub(crate) fn at(self, steepness: f32) -> f32 {
        let ramp = |[from, rise]: [f32; 2]| ((steepness - from) * rise).clamp(0.0, 1.0);
        (ramp(self.up) - ramp(self.down)).max(0.0)
    }

    #[inline(always)]
    fn lanes<S: Simd>(self, simd: S, steepness: f32x16<S>) -> f32x16<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let up = ((steepness - self.up[0]) * self.up[1]).max(zero).min(one);
        let down = ((steepness - self.down[0]) * self.down[1]).max(zero).min(one);
        (up - down).max(zero)
    }
}

impl<P: Code, const PRE_CLASSIFIED: bool> Kernel for ByGradient<'_, P, PRE_CLASSIFIED> {
    const CLOSES: bool = true;

    #[inline(always)]
    fn add<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: Chunk,
        shares: Option<&[f32; LANES]>,
        row: &mut Row<'_>,
    ) -> Added {
        let places = columns.places::<S, UNIT>(simd, edges.last);
        let mut ratio = splat(simd, 1.0);
        if let Some(ratios) = &self.over.lengths.ratios {
            ratio = ratios.lanes(simd, at.x, at.y);
        }
        if let Some(shares) = shares {
            ratio *= f32x16::load_array_ref(simd, shares).max(splat(simd, 0.0));
        }
        let samples = if PRE_CLASSIFIED {
            step_of_thickness(simd, self.of_voxels(simd, edges, &places, &at), ratio)
        } else {
            of_depth(simd, self.of_values::<S, N, UNIT>(simd, edges, &places, &at), ratio)
        };
        self.over.composite(simd, samples, &at, row)
    }

    fn end<S: Simd>(&self, simd: S, row: &mut Row<'_>) {
        self.over.end(simd, row);
    }

    fn finish(&self, seen: &Seen<'_>, texel: &mut [f32; 4]) -> f64 {
        self.over.finish(seen, texel)
    }
}

impl<P: Code, const PRE_CLASSIFIED: bool> ByGradient<'_, P, PRE_CLASSIFIED> {
    /// Light and optical depth of sixteen samples by interpolated values and gradients, shaded.
    #[inline(always)]
    fn of_values<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        places: &Places<S>,
        at: &Chunk,
    ) -> [f32x16<S>; 4] {
        let gradient = self.gradients.at::<S, P, N, UNIT>(simd, self.over.voxels, edges, places);
        let steepness = lengths(gradient);
        let mut sum = [splat(simd, 0.0); 4];
        for node in self.nodes {
            let share = node.hat.lanes(simd, steepness);
            if !share.simd_gt(splat(simd, 0.0)).any_true() {
                continue;
            }
            let sample = self.over.of_values::<S, N, UNIT>(simd, &node.lengths.table, edges, places, at.n);
            for c in 0..4 {
                sum[c] += sample[c] * share;
            }
        }
        if let Some(colors) = &self.colors {
            let tint = tints::<S, N, UNIT>(simd, colors, edges, places);
            for c in 0..3 {
                sum[c] *= tint[c];
            }
        }
        self.shading.shaded(simd, at, gradient, sum)
    }

    /// Light and opacity of sixteen samples between voxels that are classified by their values and the lengths of their gradients, shaded.
    #[inline(always)]
    fn of_voxels<S: Simd, const N: usize>(
        &self,
        simd: S,
        edges: &Edges<N>,
        places: &Places<S>,
        at: &Chunk,
    ) -> [f32x16<S>; 4] {
        let mut sum = [splat(simd, 0.0); 4];
        for e in 0..N {
            for right in 0..2 {
                // The voxels at one corner of the cells.
                let mut rows = [f32x4::splat(simd, 0.0); LANES];
                let (mut gradient, mut tint) = ([[0.0; LANES]; 3], [[1.0; LANES]; 3]);
                for i in 0..at.n {
                    let voxel = edges.at[e] + right + places.first + places.cell[i] as usize;
                    for (c, channel) in self.colors.iter().flatten().enumerate() {
                        tint[c][i] = f32::from(channel[voxel]) * PER_WHITE;
                    }
                    let [x, y, z] = self.gradients.at_voxel(voxel);
                    let steepness = (x * x + y * y + z * z).sqrt();
                    for node in self.nodes {
                        let row = self.over.row(&node.lengths.table, self.over.voxels[voxel]);
                        rows[i] += f32x4::load_array_ref(simd, row) * node.hat.at(steepness);
                    }
                    (gradient[0][i], gradient[1][i], gradient[2][i]) = (x, y, z);
                }
                let gradient = [
                    f32x16::load_array_ref(simd, &gradient[0]),
                    f32x16::load_array_ref(simd, &gradient[1]),
                    f32x16::load_array_ref(simd, &gradient[2]),
                ];
                let mut samples = of_depth(simd, transpose(rows), splat(simd, 1.0));
                for c in 0..3 {
                    samples[c] *= f32x16::load_array_ref(simd, &tint[c]);
                }
                let samples = self.shading.shaded(simd, at, gradient, samples);
                let weight = places.weight_of_voxels(simd, right) * edges.of_voxels[e];
                for c in 0..4 {
                    sum[c] += samples[c] * weight;
                }
            }
        }
        sum
    }
}

/// Light of a colour by its stored number.
pub(crate) const PER_WHITE: f32 = 1.0 / ColorGrid::WHITE as f32;

/// Colours at sixteen texels, where values are taken: interpolated, or those of the nearest voxels.
#[inline(always)]
pub(super) fn tints<S: Simd, const N: usize, const UNIT: bool>(
    simd: S,
    channels: &[&[u16]; 3],
    edges: &Edges<N>,
    places: &Places<S>,
) -> [f32x16<S>; 3] {
    let mut tint = [splat(simd, PER_WHITE); 3];
    for c in 0..3 {
        tint[c] *= values::<S, u16, N, UNIT>(simd, channels[c], edges, places);
    }
    tint
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hats_share_out_every_steepness() {
        let nodes = [0.0, 1.0, 1.5, 4.0];
        let hats = Hat::of_nodes(&nodes);
        for (steepness, want) in [
            (0.0, [1.0, 0.0, 0.0, 0.0]),
            (0.25, [0.75, 0.25, 0.0, 0.0]),
            (1.0, [0.0, 1.0, 0.0, 0.0]),
            (1.25, [0.0, 0.5, 0.5, 0.0]),
            (4.0, [0.0, 0.0, 0.0, 1.0]),
            (90.0, [0.0, 0.0, 0.0, 1.0]),
        ] {
            let got: Vec<f32> = hats.iter().map(|hat| hat.at(steepness)).collect();
            assert!(got.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-6), "{steepness}: {got:?}");
        }
        assert_eq!(Hat::of_nodes(&[3.0])[0].at(0.0), 1.0);
        assert_eq!(Hat::of_nodes(&[3.0, 7.0])[0].at(0.0), 1.0);
    }
}
