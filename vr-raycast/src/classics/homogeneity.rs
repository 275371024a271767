//! Regions in which the medium is nearly the same: a tree over blocks of the volume, and the error of a long step in each node.

use std::sync::Arc;

use rayon::prelude::*;
use vr_core::{Filter, GridVolume, Scene, TransferFunction};
use vr_kernels::ranges::LevelRanges;

use super::straightness::bends;
use crate::caster::{RayCaster, Step, Traversal};
use crate::error_bound::optics::{Extremes, Optics};

/// Map from every block of 4³ cells to the largest node of an octree around it that a ray may cross in one step.
///
/// Laur and Hanrahan 1991 (*Hierarchical splatting*) and Danskin and Hanrahan 1992 (*Fast algorithms for volume ray tracing*) keep a mean
/// and an error per node. Here a node has the range of its values, from which the ranges of κ and of the source follow exactly. A step of
/// length l through a node, with one sample anywhere in it, is off (see `error_bound/README.md` for why errors add up as they do)
///
/// * in its transparency by at most l·Δκ·e^(−κ₀l), where κ lies in [κ₀, κ₀ + Δκ]; and so a pixel by T·M times that, T being the
///   transmittance in front and M the largest radiance from behind;
/// * in its light by Δc·α, where the source is a colour c; or, where it is an emission q given on its own, by l·Δq and, for what it absorbs
///   itself, by l²·Δκ·q/2, which M takes in.
///
/// A node of a density emitter is homogeneous where Δκ·M ≤ (ε/4)(1/D + κ₀) and Δc·κ₁ ≤ (ε/4)(1/D + κ₁), with D the diagonal of the
/// volume, ε the error asked for, κ₁ = κ₀ + Δκ. The long steps of a ray do not overlap, so that Σ l ≤ D; and as x·e^(−x) ≤ 1 − e^(−x),
/// Σ T·κ₀·l·e^(−κ₀l) ≤ Σ T·α ≤ 1. So all of them together are off by at most ε/4 (1 + 1) for transparency and as much for light: ε.
/// With emission on its own it is Δκ·M ≤ ε/(2D) and Δq ≤ ε/(2D).
///
/// In a nearly linear field, the sample in the middle of a step knows more: along the step, a linear function is as much above its
/// middle value before it as below it behind. So for a trilinear field, within `bend` of a linear function in the node, Δκ may be replaced by
/// 2(|κ′|·bend + what κ as a function of the value differs from linear); and Δc by the same of c, and, as front and back do not count alike, half of
/// κ₁/κ₀·e^(κ₁l) − 1 times the amplitude of what is linear. This is done for nodes of one and two blocks' edge.
///
/// A byte per block is 1.6 % of a volume of bytes, the distances from linear are 7 %; the ranges, kept with the volume, are 3 %.
#[derive(Clone, Debug)]
pub(crate) struct Homogeneity {
    blocks: [usize; 3],
    bytes: Vec<u8>,
    /// Distance of the field from linear in nodes of one and of two blocks' edge; it does not depend on the transfer function.
    bends: Arc<[Vec<f32>; 2]>,
}

/// Node that sets the step of a ray in a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Node {
    /// Node of 2^level blocks an edge in which nothing is visible.
    Clear(u32),
    /// Node of 2^level blocks an edge that a ray may cross in one step.
    Homogeneous(u32),
    /// No such node: short steps.
    Mixed,
}

const MIXED: u8 = 255;
/// Number that is added to the level where nothing is visible.
const CLEAR: u8 = 128;

/// Range of levels of a node, and true if a part of it is vacuum.
#[derive(Clone, Copy)]
struct Range {
    levels: [u8; 2],
    holed: bool,
    /// Distance of the field from a linear function; +∞ where it is unknown.
    bend: f32,
}

impl Range {
    fn with(self, other: Self) -> Self {
        let [a, b] = [self.levels, other.levels];
        Self { levels: [a[0].min(b[0]), a[1].max(b[1])], holed: self.holed || other.holed, bend: f32::INFINITY }
    }
}

/// Makes the map that a caster asks for, if any. `then` is one made for the same volume, and true if the same could be seen of it.
pub(crate) fn homogeneity(
    caster: &RayCaster,
    scene: &Scene,
    volume: &GridVolume,
    then: Option<(&Arc<Homogeneity>, bool)>,
) -> Option<Arc<Homogeneity>> {
    match (caster.step, then) {
        (Step::Homogeneous { .. }, _) if caster.traversal != Traversal::Samples => None,
        (Step::Homogeneous { .. }, Some((map, true))) => Some(Arc::clone(map)),
        (Step::Homogeneous { error, .. }, then) => {
            let last = then.map(|(map, _)| map.as_ref());
            Some(Arc::new(Homogeneity::new(volume, &scene.transfer, error, last)))
        }
        _ => None,
    }
}

impl Homogeneity {
    /// Cells along the edge of a block.
    pub(crate) const EDGE: usize = LevelRanges::EDGE;

    /// Makes the map of a volume under a transfer function; `last` is one made for the same volume.
    fn new(volume: &GridVolume, transfer: &TransferFunction, error: f64, last: Option<&Self>) -> Self {
        let make = || {
            [0, 1].map(|level| {
                if volume.filter() == Filter::Trilinear { bends(volume, Self::EDGE << level) } else { Vec::new() }
            })
        };
        let bends = last.map_or_else(|| Arc::new(make()), |last| Arc::clone(&last.bends));
        let levels = LevelRanges::of_volume(volume);
        let blocks = levels.blocks();
        let verdicts = Verdicts::new(volume, &levels, transfer, error);
        let mut nodes: Vec<Range> = levels
            .ranges()
            .iter()
            .enumerate()
            .map(|(i, &range)| Range { levels: range, holed: levels.has_hole(i), bend: f32::INFINITY })
            .collect();
        let mut bytes = vec![MIXED; nodes.len()];
        let mut size = blocks;
        for level in 0..u32::from(CLEAR) {
            for (node, &bend) in nodes.iter_mut().zip(bends.get(level as usize).into_iter().flatten()) {
                node.bend = bend;
            }
            // From the leaves up: what a larger node says counts.
            let found: Vec<Verdict> = nodes.par_iter().with_min_len(1 << 10).map(|&n| verdicts.of(n, level)).collect();
            let scale = |i: usize| i >> level;
            for z in 0..blocks[2] {
                for y in 0..blocks[1] {
                    let row = (z * blocks[1] + y) * blocks[0];
                    let above = (scale(z) * size[1] + scale(y)) * size[0];
                    for x in 0..blocks[0] {
                        match found[above + scale(x)] {
                            Verdict::Clear => bytes[row + x] = CLEAR + level as u8,
                            Verdict::Homogeneous => bytes[row + x] = level as u8,
                            Verdict::Mixed => {}
                        }
                    }
                }
            }
            if size == [1; 3] {
                break;
            }
            (nodes, size) = parents(&nodes, size);
        }
        Self { blocks, bytes, bends }
    }

    /// Blocks along x, y, z.
    pub(crate) fn blocks(&self) -> [usize; 3] {
        self.blocks
    }

    /// Returns the node that sets the step of a ray in a block.
    pub(crate) fn at(&self, [x, y, z]: [usize; 3]) -> Node {
        match self.bytes[(z * self.blocks[1] + y) * self.blocks[0] + x] {
            MIXED => Node::Mixed,
            clear @ CLEAR.. => Node::Clear(u32::from(clear - CLEAR)),
            level => Node::Homogeneous(u32::from(level)),
        }
    }
}

/// Joins nodes to those of twice the edge.
fn parents(nodes: &[Range], size: [usize; 3]) -> (Vec<Range>, [usize; 3]) {
    let half = size.map(|n| n.div_ceil(2));
    let mut parents = Vec::with_capacity(half.iter().product());
    for z in 0..half[2] {
        for y in 0..half[1] {
            for x in 0..half[0] {
                let child = |i: usize| {
                    let at = |c: usize, a: usize| (2 * c + (i >> a & 1)).min(size[a] - 1);
                    nodes[(at(z, 2) * size[1] + at(y, 1)) * size[0] + at(x, 0)]
                };
                parents.push((1..8).fold(child(0), |range, i| range.with(child(i))));
            }
        }
    }
    (parents, half)
}

#[derive(Clone, Copy, PartialEq)]
enum Verdict {
    Clear,
    Homogeneous,
    Mixed,
}

/// Medium over every range of levels that there is.
struct Verdicts {
    table: Vec<Option<Medium>>,
    emits: bool,
    /// The diagonal of the volume, and the longest way through a block.
    across: f64,
    block: f64,
    /// The largest radiance from behind.
    max_light: f64,
    error: f64,
}

/// A medium over a range of values.
#[derive(Clone, Copy)]
struct Medium {
    /// Smallest and largest κ.
    kappa: [f64; 2],
    /// Differences of the source.
    width: f64,
    /// Slopes of κ and of the source by the value, and their distances from linear.
    bent: [[f64; 2]; 2],
    clear: bool,
}

impl Verdicts {
    fn new(volume: &GridVolume, levels: &LevelRanges, transfer: &TransferFunction, error: f64) -> Self {
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let optics = Optics::new(transfer, volume.calibration(), f64::from(low.abs().max(high.abs())));
        let corners = volume.corners();
        let across = (0..4).map(|i| corners[i].distance(corners[7 - i])).fold(0.0, f64::max);
        let max_light = optics.brightest * if optics.emits { 1.5 * across } else { 1.0 };
        // A range may fall short of the field by a hundredth of a level; and what cubic filters overshoot belongs to the outermost levels.
        let spacing = levels.stored(1) - levels.stored(0);
        let room = LevelRanges::SLACK * spacing + optics.knot_error;
        let overshoots = matches!(volume.filter(), Filter::BSpline | Filter::CatmullRom);
        let medium = |first: usize, last: usize| {
            let (first, last) = (first as u8, last as u8);
            let from = if overshoots && first == 0 { f64::NEG_INFINITY } else { levels.stored(first) - room };
            let to = if overshoots && last == u8::MAX { f64::INFINITY } else { levels.stored(last) + room };
            let e: Extremes = optics.extremes(from, to);
            let bent =
                if from.is_finite() && to.is_finite() { optics.bent(from, to) } else { [[0.0, f64::INFINITY]; 2] };
            Medium {
                kappa: e.rate.map(|r| r / optics.unit),
                width: e.source_width(),
                bent: [bent[0].map(|x| x / optics.unit), bent[1]],
                clear: e.rate[1] == 0.0 && (!optics.emits || e.source.iter().all(|s| s[1] == 0.0)),
            }
        };
        let table =
            (0..1usize << 16).into_par_iter().map(|i| (i >> 8 <= i & 255).then(|| medium(i >> 8, i & 255))).collect();
        let block = Homogeneity::EDGE as f64 * volume.placement().spacing().element_sum();
        Self { table, emits: optics.emits, across, block, max_light: max_light.max(1.0), error }
    }

    fn of(&self, range: Range, level: u32) -> Verdict {
        let Some(m) = self.table[usize::from(range.levels[0]) << 8 | usize::from(range.levels[1])] else {
            return Verdict::Clear;
        };
        if m.clear {
            return Verdict::Clear;
        }
        let [least, largest] = m.kappa;
        if range.holed || !largest.is_finite() {
            return Verdict::Mixed;
        }
        let bend = f64::from(range.bend);
        let straight = |[slope, off]: [f64; 2]| 2.0 * (if slope == 0.0 { 0.0 } else { slope * bend } + off);
        let spread = largest - least;
        let opacity = spread.min(straight(m.bent[0])) * self.max_light;
        let keeps = if self.emits {
            // What an emission absorbs itself changes along the step: no more than its own range can tell.
            spread * self.max_light <= 0.5 * self.error / self.across && m.width <= 0.5 * self.error / self.across
        } else {
            let length = self.block * f64::from(1u32 << level);
            let uneven = 0.5 * (largest / least * libm::exp(largest * length) - 1.0);
            let straight = straight(m.bent[1]);
            // Where nothing need absorb, any place may count alone.
            let light = m.width.min(straight + 0.5 * (m.width + straight) * uneven);
            opacity <= 0.25 * self.error * (1.0 / self.across + least)
                && light * largest <= 0.25 * self.error * (1.0 / self.across + largest)
        };
        if keeps { Verdict::Homogeneous } else { Verdict::Mixed }
    }
}
