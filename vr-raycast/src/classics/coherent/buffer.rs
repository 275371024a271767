//! Coherence buffer: the cells that can be seen first, kept from picture to picture.

use glam::DVec3;
use rayon::prelude::*;
use vr_core::{Control, GridVolume, RenderError, View};
use vr_kernels::ranges::RangeBlocks;

use super::cells::{CellMask, EDGE, LookInto, Sight};
use crate::near_depths::{Band, NearDepths};
use crate::projection::{Footprint, MARGIN, Projection};

/// Blocks along the edge of a group: what hides a group hides all of its blocks at once.
const GROUP: usize = 4;

/// Rows of tiles that one task fills.
const BAND: u32 = 8;

/// Visibility of the blocks of 8³ cells under one transfer function: which can be seen and, of those that earlier pictures met
/// first, which of their cells.
pub(crate) struct CoherenceBuffer {
    sight: Sight,
    cells: [usize; 3],
    blocks: [usize; 3],
    kinds: Vec<Kind>,
    groups: Vec<[usize; 3]>,
    /// Index of each block's mask, or [`UNKNOWN`].
    known: Vec<u32>,
    masks: Vec<CellMask>,
    /// Blocks that the last picture met first, and of which no more is known yet.
    met: Vec<u32>,
}

/// Index of a block that no picture has looked into.
const UNKNOWN: u32 = u32::MAX;

/// Part of a block that can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// No part of it.
    Clear,
    /// Some part, hidden behind six solid neighbours.
    Buried,
    /// All of it, as far as its largest and smallest number tell, or nothing is known. Such blocks are never looked into.
    Solid,
    /// Some part of it.
    Partial,
}

impl CoherenceBuffer {
    /// Makes a buffer that knows the ranges of the blocks alone. It holds as long as volume and visibility do.
    pub(crate) fn new(volume: &GridVolume, sight: Sight) -> Self {
        let ranges = RangeBlocks::of_volume(volume, EDGE);
        let blocks = ranges.blocks();
        // The field of the wider filters depends on more than a cell's corners: their blocks stay whole.
        let divisible = volume.filter().reach() == 0;
        let seen = |range: &vr_kernels::ranges::BlockRange| {
            if range.is_empty() || !sight(range.low, range.high) {
                Kind::Clear
            } else if divisible && !(sight(range.low, range.low) && sight(range.high, range.high)) {
                Kind::Partial
            } else {
                Kind::Solid
            }
        };
        let kinds: Vec<Kind> = ranges.ranges().par_iter().map(seen).collect();
        let at = |b: [usize; 3]| (b[2] * blocks[1] + b[1]) * blocks[0] + b[0];
        let place = |i: usize| [i % blocks[0], i / blocks[0] % blocks[1], i / (blocks[0] * blocks[1])];
        let buried = |b: [usize; 3]| {
            (0..3).all(|a| {
                let stands =
                    |k: usize| kinds[at(std::array::from_fn(|i| if i == a { k } else { b[i] }))] == Kind::Solid;
                b[a] > 0 && b[a] + 1 < blocks[a] && stands(b[a] - 1) && stands(b[a] + 1)
            })
        };
        let kinds: Vec<Kind> = (0..kinds.len())
            .into_par_iter()
            .map(|i| if kinds[i] != Kind::Clear && buried(place(i)) { Kind::Buried } else { kinds[i] })
            .collect();
        let mut groups: Vec<[usize; 3]> =
            (0..kinds.len()).filter(|&i| kinds[i] != Kind::Clear).map(|i| place(i).map(|b| b / GROUP)).collect();
        groups.sort_unstable_by_key(|g| [g[2], g[1], g[0]]);
        groups.dedup();
        let cells = volume.dims().map(|n| n - 1);
        let known = vec![UNKNOWN; kinds.len()];
        Self { sight, cells, blocks, kinds, groups, known, masks: Vec::new(), met: Vec::new() }
    }

    /// Projects the visible cells of a view; returns its near depths.
    ///
    /// Whatever the buffer knows, every point that can be seen lies at or behind the depth of its tile; the more it knows, the nearer.
    ///
    /// # Errors
    /// A camera that makes no sense, or [`RenderError::Cancelled`].
    pub(crate) fn project(
        &mut self,
        volume: &GridVolume,
        view: &View,
        control: &Control,
    ) -> Result<NearDepths, RenderError> {
        control.check()?;
        self.learn(volume, control);
        let projection = Projection::new(view, volume.placement())?;
        // With the eye in the volume, rays begin inside blocks, and any cell may be the first.
        let all = self.box_of([0; 3], self.cells);
        let inside = projection.footprint(&projection.stencil(all.1), all.0).is_some_and(|f| f.depth == 0.0);
        let groups = self.groups_front_to_back(&projection);
        let mut near = NearDepths::nothing(view.size);
        let this = &*self;
        let fill = |mut band: Band<'_>| this.fill(&mut band, &projection, &groups, inside);
        let met: Vec<Vec<u32>> = control.run(|| near.bands(BAND).map(fill).collect());
        self.met = met.concat();
        self.met.sort_unstable();
        self.met.dedup();
        Ok(near)
    }

    /// Looks into the blocks that the last picture met first.
    fn learn(&mut self, volume: &GridVolume, control: &Control) {
        let met = std::mem::take(&mut self.met);
        if met.is_empty() {
            return;
        }
        assert_eq!(volume.filter().reach(), 0, "a cell's field depends on its own corners alone");
        let look = |&i: &u32| volume.with_lattice(LookInto { block: self.place(i), sight: &self.sight });
        let masks: Vec<CellMask> = control.run(|| met.par_iter().map(look).collect());
        for (block, mask) in met.into_iter().zip(masks) {
            self.known[block as usize] = self.masks.len() as u32;
            self.masks.push(mask);
        }
    }

    fn place(&self, block: u32) -> [usize; 3] {
        let i = block as usize;
        [i % self.blocks[0], i / self.blocks[0] % self.blocks[1], i / (self.blocks[0] * self.blocks[1])]
    }

    /// Returns centre and half edges of the box of some cells, widened by the margin.
    fn box_of(&self, first: [usize; 3], count: [usize; 3]) -> (DVec3, DVec3) {
        let low: [f64; 3] = first.map(|i| i as f64);
        let high: [f64; 3] = std::array::from_fn(|a| (first[a] + count[a]).min(self.cells[a]) as f64);
        let (low, high) = (DVec3::from(low), DVec3::from(high));
        (0.5 * (low + high), 0.5 * (high - low) + MARGIN)
    }

    /// Returns the groups that the picture may show, roughly from near to far.
    fn groups_front_to_back(&self, projection: &Projection) -> Vec<([usize; 3], Footprint)> {
        let edge = GROUP * EDGE;
        let mut seen: Vec<_> = self
            .groups
            .iter()
            .filter_map(|&g| {
                let (centre, half) = self.box_of(g.map(|i| i * edge), [edge; 3]);
                Some((g, projection.footprint(&projection.stencil(half), centre)?))
            })
            .collect();
        seen.sort_by(|a, b| a.1.depth.total_cmp(&b.1.depth));
        seen
    }

    /// Fills a band of tiles; returns the blocks that stand in front there without being known any better.
    fn fill(
        &self,
        band: &mut Band<'_>,
        projection: &Projection,
        groups: &[([usize; 3], Footprint)],
        inside: bool,
    ) -> Vec<u32> {
        let forward = projection.forward();
        let whole = projection.stencil(DVec3::splat(0.5 * EDGE as f64 + MARGIN));
        let cell = projection.stencil(DVec3::splat(0.5 + MARGIN));
        let mut met = Vec::new();
        for (group, footprint) in groups {
            if !band.shows(footprint) {
                continue;
            }
            for k in 0..GROUP.pow(3) {
                // Front to back within the group, too.
                let step = [k % GROUP, k / GROUP % GROUP, k / GROUP.pow(2)];
                let block: [usize; 3] = std::array::from_fn(|a| {
                    let step = if forward[a] < 0.0 { GROUP - 1 - step[a] } else { step[a] };
                    group[a] * GROUP + step
                });
                if (0..3).any(|a| block[a] >= self.blocks[a]) {
                    continue;
                }
                let index = (block[2] * self.blocks[1] + block[1]) * self.blocks[0] + block[0];
                let kind = self.kinds[index];
                if kind == Kind::Clear || (kind == Kind::Buried && !inside) {
                    continue;
                }
                let first = block.map(|b| b * EDGE);
                let (centre, half) = self.box_of(first, [EDGE; 3]);
                let is_whole = (0..3).all(|a| first[a] + EDGE <= self.cells[a]);
                let own = if is_whole { whole } else { projection.stencil(half) };
                let Some(footprint) = projection.footprint(&own, centre).filter(|f| band.shows(f)) else { continue };
                if inside || self.known[index] == UNKNOWN {
                    band.put(&footprint);
                    if kind == Kind::Partial && !inside {
                        met.push(index as u32);
                    }
                    continue;
                }
                let corner = centre - half + (MARGIN + 0.5);
                let sides = projection.sides(centre, half);
                for p in self.masks[self.known[index] as usize].front(sides) {
                    let centre = corner + DVec3::from_array(p.map(|i| i as f64));
                    if let Some(footprint) = projection.footprint(&cell, centre) {
                        band.put(&footprint);
                    }
                }
            }
        }
        met
    }
}
