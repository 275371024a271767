//! Steps of a ray through a grid with labels, each within one label.

use glam::DVec3;
use vr_core::labels::LabelledGrid;
use vr_core::{Clip, Field, IndexRay, Placement, Ray};

use super::bands::Bands;
use crate::leap::VisibleBlocks;
use crate::packet::listed::{RaySteps, StepList};
use crate::walk::{Lattice, cut_steps};

/// Steps of one length, each of which ends early where the label changes: those of the plain engine's `cut_walk`, but for those in vacuum or in blocks of the grid in which
/// nothing can be seen.
pub(super) struct LabelSteps<'a> {
    pub(super) field: &'a LabelledGrid,
    pub(super) bands: &'a Bands,
    /// Blocks of the grid in which something can be seen; `None` where all are looked at.
    pub(super) visible: Option<&'a VisibleBlocks>,
    /// Box in which the plain engine's rays begin, and what cuts it.
    pub(super) lattice: (&'a Placement, [usize; 3]),
    pub(super) clip: &'a Clip,
    /// World length of a step.
    pub(super) step: f64,
}

impl RaySteps for LabelSteps<'_> {
    fn list(&self, ray: &Ray, [from, to]: [f64; 2], list: &mut StepList) {
        // Steps are counted from where the ray meets the box of the field: the grid's own box may be turned in it.
        let (placement, dims) = self.lattice;
        let Some(whole) = IndexRay::new(ray, placement, dims, self.clip, f64::INFINITY) else { return };
        let mut jumps = Vec::new();
        self.field.jumps(ray, [from, to], &mut jumps);
        jumps.iter_mut().for_each(|s| *s -= from);
        let start = (whole.start + whole.offset - from).min(0.0);
        cut_steps(&Lattice::new(start, to - from, self.step), &jumps, &mut list.steps);
        let blocks = self.visible.map(|visible| BlocksAlong::new(visible, self.field, ray, from));
        // Between two jumps one label holds.
        let (mut next_jump, mut band, mut is_known) = (0, None, false);
        let kinds = &mut list.kinds;
        list.steps.retain(|&(begin, length)| {
            let middle = begin + 0.5 * length;
            if middle <= 0.0 {
                return false;
            }
            while jumps.get(next_jump).is_some_and(|&jump| jump <= middle) {
                next_jump += 1;
                is_known = false;
            }
            if !is_known {
                is_known = true;
                band = self.bands.of(self.field.code_at(ray.origin + ray.direction * (from + middle)));
            }
            let Some(band) = band else { return false };
            let is_seen = self.bands.is_solid(band) || blocks.as_ref().is_none_or(|blocks| blocks.is_seen(middle));
            if is_seen {
                kinds.push(band);
            }
            is_seen
        });
    }
}

/// Blocks of a grid along a ray.
struct BlocksAlong<'a> {
    visible: &'a VisibleBlocks,
    /// Place in blocks at distance 0, and its change per unit of distance.
    base: DVec3,
    along: DVec3,
    last: DVec3,
}

impl<'a> BlocksAlong<'a> {
    fn new(visible: &'a VisibleBlocks, field: &LabelledGrid, ray: &Ray, from: f64) -> Self {
        let (placement, grid) = (field.volume().placement(), visible.grid());
        let per_block = 1.0 / grid.edge as f64;
        Self {
            visible,
            base: placement.to_index(ray.origin + ray.direction * from) * per_block,
            along: placement.inverse_axes() * ray.direction * per_block,
            last: DVec3::from_array(grid.blocks.map(|n| (n - 1) as f64)),
        }
    }

    /// True if something can be seen in the block at a distance.
    #[inline]
    fn is_seen(&self, distance: f64) -> bool {
        let block = (self.base + self.along * distance).clamp(DVec3::ZERO, self.last);
        // `as` rounds down what is not negative.
        self.visible.at(block.to_array().map(|x| x as usize))
    }
}
