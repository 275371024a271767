//! Regions in which the medium is nearly the same: a tree over blocks of the volume, and the error of a long step in each node.

use std::sync::Arc;

use vr_core::parallel::collect;
use vr_core::{Compositing, Filter, GridVolume, Scene, TransferFunction};
use vr_kernels::ranges::LevelRanges;

use super::moments::Moments;
use super::straightness::bends;
use crate::caster::{RayCaster, Step, Traversal};
use crate::error_bound::optics::{Extremes, Optics};
use crate::leap::VisibleBlocks;

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
/// *Shading* multiplies c by a factor and adds a highlight, both between bounds that the lights give, whatever the gradient: Δc is widened by
/// them, and nothing is known to be linear. *Accumulate* cuts a ray where its opacity reaches a level, inside a step, too. A bound E of the error at all
/// places along the ray, insides of steps included, bounds the cut one by (1 + M)·E: at the place of the computed cut light is off by E,
/// opacity by E, and light changes by at most M per opacity. So it takes ε/(1 + M), and the widths, which hold for parts of a step as well, without
/// what is linear, which cancels over whole steps alone.
///
/// **By variance** ([`Step::Variance`]), a node may be crossed in one step at the mean m of its field ([`Moments`]), too, by what its variance tells of the
/// *picture's RMSE*. With e = M·|κ(f) − κ(m)| + κ₁·|c(f) − c(m)| (|q(f) − q(m)| for an emission), a ray is off by at most ∫ e ds ≤ √(D ∫ e² ds)
/// over its mean steps. The mean square over parallel rays that cover an area A is at most D/A ∫ e² dV; and the volume's V ≤ A·D. So where the root mean
/// square of e over each node is at most ε/(2D), the RMSE is at most ε/2; and |κ(f) − κ(m)| is in the root mean square at most the
/// smaller of Δκ and σ times the steepest slope of κ over the node's range: the variance times what the transfer function makes of it. (No maximum follows from
/// a variance but one so wide that ranges are always better: a ray may meet nothing but outliers.) The other ε/2 goes to nodes by their ranges,
/// as above. In perspective, where near nodes fill more pixels, the share of a node counts with the square of (its farthest depth/its nearest).
///
/// A byte per block is 1.6 % of a volume of bytes, the distances from linear are 7 %; the ranges, kept with the volume, are 3 %.
#[derive(Clone, Debug)]
pub(crate) struct Homogeneity {
    blocks: [usize; 3],
    bytes: Vec<u8>,
    /// Distance of the field from linear in nodes of one and of two blocks' edge; it does not depend on the transfer function.
    bends: Arc<[Vec<f32>; 2]>,
    /// Nodes that may be crossed at their mean; `None` where ranges alone decide.
    means: Option<Means>,
}

/// Nodes that may be crossed at the mean of their field.
#[derive(Clone, Debug)]
struct Means {
    moments: Arc<Moments>,
    /// Level of the largest such node around each block, or [`MIXED`].
    levels: Vec<u8>,
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

/// Byte of a block in no such node: below those of clear ones.
const MIXED: u8 = CLEAR - 1;
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
        (Step::Homogeneous { .. } | Step::Variance { .. }, _) if caster.traversal != Traversal::Samples => None,
        (Step::Homogeneous { .. } | Step::Variance { .. }, Some((map, true))) => Some(Arc::clone(map)),
        (step @ (Step::Homogeneous { error, .. } | Step::Variance { error, .. }), then) => {
            let last = then.map(|(map, _)| map.as_ref());
            let by_variance = matches!(step, Step::Variance { .. });
            Some(Arc::new(Homogeneity::new(volume, scene, error, by_variance, last)))
        }
        _ => None,
    }
}

impl Homogeneity {
    /// Cells along the edge of a block.
    pub(crate) const EDGE: usize = LevelRanges::EDGE;

    /// Makes the map of a volume under a transfer function; `last` is one made for the same volume.
    fn new(volume: &GridVolume, scene: &Scene, error: f64, by_variance: bool, last: Option<&Self>) -> Self {
        let make = || {
            [0, 1].map(|level| {
                if volume.filter() == Filter::Trilinear { bends(volume, Self::EDGE << level) } else { Vec::new() }
            })
        };
        let bends = last.map_or_else(|| Arc::new(make()), |last| Arc::clone(&last.bends));
        let levels = LevelRanges::of_volume(volume);
        let blocks = levels.blocks();
        let verdicts = Verdicts::new(volume, &levels, scene, if by_variance { 0.5 * error } else { error });
        let last_means = last.and_then(|last| last.means.as_ref());
        let moments = || last_means.map(|m| Arc::clone(&m.moments)).or_else(|| Moments::new(volume).map(Arc::new));
        let mut means = by_variance.then(moments).flatten().map(|moments| {
            let levels = vec![MIXED; levels.ranges().len()];
            Means { moments, levels }
        });
        let mut nodes: Vec<Range> = levels
            .ranges()
            .iter()
            .enumerate()
            .map(|(i, &range)| Range { levels: range, holed: levels.has_hole(i), bend: f32::INFINITY })
            .collect();
        let mut bytes = vec![MIXED; nodes.len()];
        let mut size = blocks;
        for level in 0..u32::from(MIXED) {
            for (node, &bend) in nodes.iter_mut().zip(bends.get(level as usize).into_iter().flatten()) {
                node.bend = bend;
            }
            // From the leaves up: what a larger node says counts.
            let found: Vec<Verdict> = collect(nodes.len(), |i| verdicts.of(nodes[i], level));
            let spread: Vec<bool> = means.as_ref().map_or_else(Vec::new, |means| {
                let moments = means.moments.of_level(level);
                collect(nodes.len(), |i| verdicts.allow_mean(nodes[i], moments[i].deviation))
            });
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
                        if let Some(means) = &mut means
                            && spread[above + scale(x)]
                        {
                            means.levels[row + x] = level as u8;
                        }
                    }
                }
            }
            if size == [1; 3] {
                break;
            }
            (nodes, size) = parents(&nodes, size);
        }
        Self { blocks, bytes, bends, means }
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

    /// Returns the bytes of the blocks, x fastest, which [`Self::edges`] explains.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns, by the byte of a block, the cells along the edge of the node that sets the step in it: below 0 if the node is clear, 0 if there is none.
    pub(crate) fn edges() -> [f32; 256] {
        let edge = |level: u8| Self::EDGE as f32 * libm::exp2f(f32::from(level));
        std::array::from_fn(|byte| match byte as u8 {
            MIXED => 0.0,
            clear @ CLEAR.. => -edge(clear - CLEAR),
            level => edge(level),
        })
    }

    /// Returns the visible blocks, of twice the edge, of a volume with the given voxels along x, y, z.
    pub(crate) fn visible(&self, dims: [usize; 3]) -> VisibleBlocks {
        VisibleBlocks::of_halves(dims, Self::EDGE, &self.bytes, CLEAR)
    }

    /// True if some nodes may be crossed at the mean of their field.
    pub(crate) fn has_means(&self) -> bool {
        self.means.is_some()
    }

    /// Returns the level of the largest node around a block that may be crossed at the mean of its field, and this mean, where that node is larger
    /// than the one of [`at`](Self::at).
    pub(crate) fn mean_at(&self, block @ [x, y, z]: [usize; 3]) -> Option<(u32, f32)> {
        let means = self.means.as_ref()?;
        let i = (z * self.blocks[1] + y) * self.blocks[0] + x;
        let (level, own) = (means.levels[i], self.bytes[i]);
        let larger = level != MIXED && (own == MIXED || (own < CLEAR && level > own));
        larger.then(|| (u32::from(level), means.moments.at(u32::from(level), block).mean))
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

#[derive(Clone, Copy, Default, PartialEq)]
enum Verdict {
    Clear,
    Homogeneous,
    #[default]
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
    /// Steepest slopes of κ and of the source by the value; +∞ where they jump.
    steepest: [f64; 2],
    /// Largest difference that shading can add to that of two colours.
    beyond: f64,
    clear: bool,
}

impl Verdicts {
    fn new(volume: &GridVolume, levels: &LevelRanges, scene: &Scene, error: f64) -> Self {
        let transfer: &TransferFunction = &scene.transfer;
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let optics = Optics::new(transfer, volume.calibration(), f64::from(low.abs().max(high.abs())));
        let corners = volume.corners();
        let across = (0..4).map(|i| corners[i].distance(corners[7 - i])).fold(0.0, f64::max);
        // Bounds of the factor and of what is added to it; where the gradient is zero, colours stay.
        let shading = scene.reflection().filter(|shading| !shading.is_flat());
        let light = |c: usize| scene.lights.iter().map(|l| l.color[c]).sum::<f64>();
        let light = light(0).max(light(1)).max(light(2));
        let (factor, highlight) = shading.map_or(([1.0; 2], 0.0), |s| {
            ([s.ambient.min(1.0), (s.ambient + s.diffuse * light).max(1.0)], s.specular * light)
        });
        let brightest = optics.brightest * factor[1] + highlight;
        let max_light = (brightest * if optics.emits { 1.5 * across } else { 1.0 }).max(1.0);
        let cuts = matches!(scene.compositing, Compositing::Accumulate { .. });
        let error = if cuts { error / (1.0 + max_light) } else { error };
        // A range may fall short of the field by a hundredth of a level; and what cubic filters overshoot belongs to the outermost levels.
        let spacing = levels.stored(1) - levels.stored(0);
        let room = LevelRanges::SLACK * spacing + optics.knot_error;
        let overshoots = matches!(volume.filter(), Filter::BSpline | Filter::CatmullRom);
        let medium = |first: usize, last: usize| {
            let (first, last) = (first as u8, last as u8);
            let from = if overshoots && first == 0 { f64::NEG_INFINITY } else { levels.stored(first) - room };
            let to = if overshoots && last == u8::MAX { f64::INFINITY } else { levels.stored(last) + room };
            let e: Extremes = optics.extremes(from, to);
            let finite = from.is_finite() && to.is_finite();
            let unknown = [0.0, f64::INFINITY];
            let bent = if finite && !cuts { optics.bent(from, to) } else { [unknown; 2] };
            let bent = if shading.is_some() { [bent[0], unknown] } else { bent };
            let steepest = if finite { optics.steepest(from, to) } else { [f64::INFINITY; 2] };
            let largest = e.source.iter().map(|s| s[1]).fold(0.0, f64::max);
            let lit = |s: &[f64; 2]| s[1] * factor[1] + highlight - s[0] * factor[0];
            let width = if shading.is_some() { e.source.iter().map(lit).fold(0.0, f64::max) } else { e.source_width() };
            Medium {
                kappa: e.rate.map(|r| r / optics.unit),
                width,
                bent: [bent[0].map(|x| x / optics.unit), bent[1]],
                steepest: [steepest[0] / optics.unit, steepest[1] * factor[1]],
                beyond: largest * (factor[1] - factor[0]) + highlight,
                clear: e.rate[1] == 0.0 && (!optics.emits || e.source.iter().all(|s| s[1] == 0.0)),
            }
        };
        let table = collect(1 << 16, |i| (i >> 8 <= i & 255).then(|| medium(i >> 8, i & 255)));
        let block = Homogeneity::EDGE as f64 * volume.placement().spacing().element_sum();
        Self { table, emits: optics.emits, across, block, max_light, error }
    }

    /// True if a node may be crossed at the mean of its field, from which that deviates by so much in the root mean square.
    fn allow_mean(&self, range: Range, deviation: f32) -> bool {
        let Some(m) = self.table[usize::from(range.levels[0]) << 8 | usize::from(range.levels[1])] else {
            return false;
        };
        let [least, largest] = m.kappa;
        if range.holed || !largest.is_finite() {
            return false;
        }
        let deviation = f64::from(deviation);
        let apart = |slope: f64| if slope == 0.0 { 0.0 } else { slope * deviation };
        let opacity = (largest - least).min(apart(m.steepest[0])) * self.max_light;
        let light = m.width.min(apart(m.steepest[1]) + m.beyond) * if self.emits { 1.0 } else { largest };
        let share = 0.5 * self.error / self.across;
        opacity <= share && light <= share
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
