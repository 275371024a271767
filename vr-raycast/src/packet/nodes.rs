//! Steps of packets from node to node of an octree: each node is crossed in one step where the medium hardly changes in it.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{Cells, LANES, Lanes, pick, splat};

use super::leap::Leaper;
use super::local::NUDGE;
use crate::classics::Homogeneity;

/// Nodes as packets cross them. Distances are in smallest voxel edges.
#[derive(Clone, Copy)]
pub(crate) struct NodeSteps<'a> {
    pub(crate) map: &'a Homogeneity,
    /// Length of a short step.
    pub(crate) step: f32,
}

impl NodeSteps<'_> {
    /// Returns the lengths of steps from positions, in nodes of these edges: below 0 in clear ones, which stays as it is; 0 where steps are short. Writes the
    /// means of nodes that are crossed at these; NaN where the field is sampled.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
    pub(super) fn length<S: Simd>(
        &self,
        simd: S,
        leaper: &Leaper<S>,
        at: f32x16<S>,
        position: [f32x16<S>; 3],
        cells: &Cells<S>,
        edge: f32x16<S>,
        means: &mut Lanes,
    ) -> f32x16<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        // A short step as the sum rounds it: thousands of them must come to the way that they take.
        let short = (at + self.step) - at;
        let exit = leaper.to_node_exit(simd, position, cells, edge.max(one)) + NUDGE;
        let length = pick(edge.simd_lt(zero), edge, pick(edge.simd_gt(zero), exit.max(short), short));
        if self.map.has_means() { self.across_means(simd, leaper, position, cells, length, means) } else { length }
    }

    /// Returns the steps from positions to the ends of nodes that may be crossed at the mean of their field, where these are larger than the nodes that set
    /// the steps, and writes those means; the lengths as they are, and NaN, where there is no such node or it is shorter than a short step.
    #[inline(always)]
    fn across_means<S: Simd>(
        &self,
        simd: S,
        leaper: &Leaper<S>,
        position: [f32x16<S>; 3],
        cells: &Cells<S>,
        length: f32x16<S>,
        means: &mut Lanes,
    ) -> f32x16<S> {
        let cell = [cells.cell[0].to_array(), cells.cell[1].to_array(), cells.cell[2].to_array()];
        let mut edges = Lanes::ZERO;
        self.look_up(&cell, &mut edges, means);
        let (edge, mean) = (edges.load(simd), means.load(simd));
        let exit = leaper.to_node_exit(simd, position, cells, edge.max(splat(simd, 1.0))) + NUDGE;
        let is_crossed = edge.simd_gt(splat(simd, 0.0)) & exit.simd_ge(splat(simd, self.step));
        *means = Lanes::new(pick(is_crossed, mean, splat(simd, f32::NAN)));
        pick(is_crossed, exit, length)
    }

    /// Writes the edges of the nodes around cells that may be crossed at a mean, 0 where there is none, and the means.
    #[inline(never)]
    fn look_up(&self, cell: &[[i32; LANES]; 3], edges: &mut Lanes, means: &mut Lanes) {
        for i in 0..LANES {
            let block = [0, 1, 2].map(|a| cell[a][i] as usize / Homogeneity::EDGE);
            (edges.0[i], means.0[i]) = match self.map.mean_at(block) {
                Some((level, mean)) => ((Homogeneity::EDGE << level) as f32, mean),
                None => (0.0, 0.0),
            };
        }
    }
}
