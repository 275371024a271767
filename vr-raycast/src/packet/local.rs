//! March of packets in steps of the length that each place asks for.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};
use vr_kernels::vector::{Cells, LANES, Lanes, PacketLights, Sums, pick, splat, step_light};

use super::fields::PacketField;
use super::gaps::outside_holes;
use super::leap::{Leaper, block_index};
use super::march::{Medium, PacketResult, Path, finish, shaded};
#[cfg(feature = "classics")]
use super::nodes::NodeSteps;
use super::setup::Packet;
use crate::step_map::{CLEAR, Cuts, StepMap};

/// Step map in the form that packets read. Distances are in smallest voxel edges, which are the packet's steps.
#[derive(Clone, Copy)]
pub(crate) struct LocalSteps<'a> {
    bytes: &'a [u8],
    blocks: [usize; 3],
    /// Step to take, by the byte of the map; for clear blocks −1 − n, where n is the number of clear blocks around in each direction.
    by_byte: &'a [f32; 256],
    /// Faces at which steps end.
    faces: Faces<'a>,
}

/// Faces at which the field jumps, and steps end.
#[derive(Clone, Copy)]
enum Faces<'a> {
    None,
    /// Faces of cells in these blocks, which have missing voxels in them or next to them.
    Holes(&'a [bool]),
    /// Faces of voxels; those of cells, too, if `cells`.
    Voxels {
        cells: bool,
        /// Longest step between faces.
        length: f32,
    },
    /// Faces of the nodes of an octree.
    #[cfg(feature = "classics")]
    Nodes(NodeSteps<'a>),
}

/// Returns the table in which [`LocalSteps`] looks bytes up.
pub(crate) fn by_byte(map: &StepMap, voxel: f64) -> [f32; 256] {
    std::array::from_fn(|b| match map.steps().get(b) {
        Some(&step) => (f64::from(step) / voxel) as f32,
        None => -(b.saturating_sub(usize::from(CLEAR)) as f32) - 1.0,
    })
}

/// Distance of the look ahead from the begin of a step, so that the step counts for the block that it leads into: beyond the rounding of a position.
pub(super) const NUDGE: f32 = 1.0 / 1024.0;

/// Largest rest of a ray that is not worth a step: below the rounding of a position.
pub(crate) const REST: f32 = 1e-5;

impl<'a> LocalSteps<'a> {
    /// `voxel` is the world length of the smallest voxel edge.
    pub(crate) fn new(map: &'a StepMap, by_byte: &'a [f32; 256], voxel: f64) -> Self {
        let faces = match map.cuts() {
            Cuts::None => Faces::None,
            Cuts::Holes(blocks) => Faces::Holes(blocks),
            Cuts::Voxels { cells, length } => {
                Faces::Voxels { cells: *cells, length: (f64::from(*length) / voxel) as f32 }
            }
        };
        Self { bytes: map.bytes(), blocks: map.blocks(), by_byte, faces }
    }

    /// Steps from node to node, by the edges of the nodes of each byte of their map.
    #[cfg(feature = "classics")]
    pub(crate) fn of_nodes(nodes: NodeSteps<'a>, edges: &'a [f32; 256]) -> Self {
        Self { bytes: nodes.map.bytes(), blocks: nodes.map.blocks(), by_byte: edges, faces: Faces::Nodes(nodes) }
    }

    /// Returns the entries of `by_byte` for the blocks of sixteen cells.
    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, cells: &Cells<S>) -> f32x16<S> {
        let index = block_index(cells, StepMap::EDGE.trailing_zeros(), self.blocks);
        let mut lanes = Lanes::ZERO;
        for i in 0..LANES {
            lanes.0[i] = self.by_byte[usize::from(self.bytes[index[i] as u32 as usize])];
        }
        lanes.load(simd)
    }

    /// Moves rays in clear blocks on, until at least half of those that go on are in visible ones. Returns these, and the lengths that the blocks of their
    /// positions ask for; `means` as [`or_means`] takes them.
    #[inline(always)]
    pub(crate) fn leap<S: Simd>(
        &self,
        simd: S,
        ray: &Path<S>,
        leaper: &Leaper<S>,
        at: &mut f32x16<S>,
        stop: f32x16<S>,
        means: &mut Lanes,
    ) -> (mask32x16<S>, f32x16<S>) {
        let mut live = at.simd_lt(stop - REST);
        let mut length;
        loop {
            let (position, cells) = ray.cells(simd, *at + NUDGE);
            length = self.at(simd, &cells);
            let clear = live & length.simd_lt(splat(simd, 0.0));
            if clear.all_false() {
                break;
            }
            let visible = live & !clear;
            *at = pick(clear, *at + NUDGE + self.exit(simd, leaper, position, &cells, -length), *at);
            live = visible;
            let walking = at.simd_lt(stop - REST);
            let (known, all) = (visible.to_bitmask().count_ones(), walking.to_bitmask().count_ones());
            if known * 2 >= all {
                break;
            }
            live = walking;
        }
        if !matches!(self.faces, Faces::None) {
            let (position, here) = ray.cells(simd, *at + NUDGE);
            length = self.cut(simd, leaper, *at, position, &here, length, means);
        }
        (live, length)
    }

    /// Returns the steps from a position in a clear block to where those that are known to be clear end; `clear` is its entry of `by_byte`, without the sign.
    #[inline(always)]
    fn exit<S: Simd>(
        &self,
        simd: S,
        leaper: &Leaper<S>,
        position: [f32x16<S>; 3],
        cells: &Cells<S>,
        clear: f32x16<S>,
    ) -> f32x16<S> {
        #[cfg(feature = "classics")]
        if let Faces::Nodes(_) = self.faces {
            return leaper.to_node_exit(simd, position, cells, clear);
        }
        leaper.exit(simd, position, cells, clear)
    }

    /// True if some steps go through all of a node at a mean that is known.
    #[inline(always)]
    fn has_means(&self) -> bool {
        #[cfg(feature = "classics")]
        if let Faces::Nodes(nodes) = self.faces {
            return nodes.map.has_means();
        }
        false
    }

    /// Returns the lengths that the blocks of positions ask for; below 0 in clear ones. `means` as [`or_means`] takes them.
    #[inline(always)]
    pub(crate) fn length<S: Simd>(
        &self,
        simd: S,
        ray: &Path<S>,
        leaper: &Leaper<S>,
        at: f32x16<S>,
        means: &mut Lanes,
    ) -> f32x16<S> {
        let (position, cells) = ray.cells(simd, at + NUDGE);
        let length = self.at(simd, &cells);
        self.cut(simd, leaper, at, position, &cells, length, means)
    }

    /// Returns steps from positions that end at the next face, where blocks ask for that. Those of clear blocks stay below 0. Writes the means of nodes that
    /// are crossed at these, as [`or_means`] takes them.
    #[inline(always)]
    #[cfg_attr(not(feature = "classics"), expect(unused_variables, reason = "what steps between nodes need"))]
    #[expect(clippy::too_many_arguments, reason = "lanes in registers: what held them would be kept in memory")]
    fn cut<S: Simd>(
        &self,
        simd: S,
        leaper: &Leaper<S>,
        at: f32x16<S>,
        position: [f32x16<S>; 3],
        cells: &Cells<S>,
        length: f32x16<S>,
        means: &mut Lanes,
    ) -> f32x16<S> {
        let zero = splat(simd, 0.0);
        match self.faces {
            Faces::None => length,
            Faces::Holes(blocks) => {
                let index = block_index(cells, StepMap::EDGE.trailing_zeros(), self.blocks);
                let mut longest = Lanes::new(leaper.to_face(position, cells).max(zero) + NUDGE);
                for i in 0..LANES {
                    if !blocks[index[i] as u32 as usize] {
                        longest.0[i] = f32::INFINITY;
                    }
                }
                length.min(longest.load(simd))
            }
            // Whatever the block asks for: the field is constant between these faces.
            Faces::Voxels { cells: of_cells, length: longest } => {
                let mut face = leaper.to_voxel_face(simd, position, cells);
                if of_cells {
                    face = face.min(leaper.to_face(position, cells));
                }
                pick(length.simd_lt(zero), length, (face.max(zero) + NUDGE).min(splat(simd, longest)))
            }
            #[cfg(feature = "classics")]
            Faces::Nodes(nodes) => nodes.length(simd, leaper, at, position, cells, length, means),
        }
    }
}

/// Returns values, or the means that stand for them; NaN where there is none.
#[inline(always)]
fn or_means<S: Simd>(simd: S, value: f32x16<S>, means: &Lanes) -> f32x16<S> {
    let mean = means.load(simd);
    pick(mean.simd_eq(mean), mean, value)
}

/// Walks each ray on its own: over clear blocks to their end, and through the rest in steps of the length that the block of their
/// begin asks for. Rays that are in clear blocks leap while those in visible ones wait, but only as long as they are more.
#[inline(always)]
pub(crate) fn local<S: Simd, T: PacketField>(
    simd: S,
    medium: &Medium<'_, T>,
    lengths: LocalSteps<'_>,
    packet: &Packet,
    max_light: &Lanes,
    lights: &PacketLights,
    stages: &mut [T::Stage; 2],
) -> PacketResult {
    let ray = Path::new(simd, medium.dims, packet);
    let leaper = Leaper::new(simd, StepMap::EDGE.trailing_zeros(), packet, medium.dims);
    let (zero, never) = (splat(simd, 0.0), splat(simd, f32::NEG_INFINITY));
    let negligible = splat(simd, medium.negligible);
    let max_light = max_light.load(simd);
    let rows = medium.optics.rows();
    let mut at = packet.first.load(simd);
    let mut stop = packet.stop.load(simd);
    let mut sums = Sums::new(simd);
    let mut samples = 0;
    let mut means = [Lanes::ZERO; 2];
    loop {
        let (mut live, mut length) = lengths.leap(simd, &ray, &leaper, &mut at, stop, &mut means[0]);
        let bits = live.to_bitmask();
        if bits == 0 {
            break;
        }
        samples += bits.count_ones();
        let [now, next] = stages;
        // What is not live may have any length.
        length = length.max(zero).min(stop - at).max(zero);
        let (_, cells) = ray.cells(simd, at + length * 0.5);
        medium.field.fetch(simd, &cells, now);
        // The next step of those that go on in a visible block: while the first waits for its samples, those of the second are fetched.
        let then = pick(live, at + length, at);
        let length_then = lengths.length(simd, &ray, &leaper, then, &mut means[1]);
        let visible = live & length_then.simd_ge(zero);
        let length_then = length_then.max(zero).min(stop - then).max(zero);
        let (_, cells_then) = ray.cells(simd, then + length_then * 0.5);
        medium.field.fetch(simd, &cells_then, next);
        // Classify both samples, and composite them front to back.
        let mut value = medium.field.value(simd, &cells, now);
        let mut value_then = medium.field.value(simd, &cells_then, next);
        if lengths.has_means() {
            value = or_means(simd, value, &means[0]);
            value_then = or_means(simd, value_then, &means[1]);
        }
        let optics = rows.at(simd, value);
        let optics_then = rows.at(simd, value_then);
        let light = step_light(simd, optics, length, medium.optics.emits);
        let light = shaded(simd, medium, lights, live, &ray, (&cells, length), light, now);
        let light = outside_holes(simd, medium.vacuum, &cells, live, light);
        let light_then = step_light(simd, optics_then, length_then, medium.optics.emits);
        let light_then = shaded(simd, medium, lights, live, &ray, (&cells_then, length_then), light_then, next);
        let light_then = outside_holes(simd, medium.vacuum, &cells_then, live, light_then);
        stop = pick(sums.add_up_to(simd, medium.level, live, [at, length], light), never, stop);
        stop = pick((sums.clear(simd) * max_light).simd_le(negligible), never, stop);
        live = visible & then.simd_lt(stop - REST);
        samples += live.to_bitmask().count_ones();
        stop = pick(sums.add_up_to(simd, medium.level, live, [then, length_then], light_then), never, stop);
        stop = pick((sums.clear(simd) * max_light).simd_le(negligible), never, stop);
        at = pick(live, then + length_then, then);
    }
    finish(simd, &sums, packet, stop.simd_le(never), samples)
}
