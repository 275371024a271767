//! Index of things by their boxes: the supports of scattered points, the cells of a mesh.

use glam::DVec3;

use crate::cancel;
use crate::parallel::{collect, join};

/// A balanced tree of boxes around items that are numbered from 0.
///
/// An item is a point of four dimensions, its middle and its radius; each node is cut in the middle of its items, across the longest
/// of the four extents. So a few large items among many small ones come into boxes of their own, and do not widen the others';
/// whatever the distribution, there are ⌈log₂(n/8)⌉ levels. The tree depends on the items alone, not on the number of threads.
#[derive(Clone)]
pub(crate) struct BoxTree {
    /// Items by leaf.
    order: Vec<u32>,
    /// Node j of level l is number 2ˡ + j; its children are 2j and 2j + 1 of the next level.
    boxes: Vec<Bounds>,
    levels: u32,
    /// Origin of positions: the middle of all.
    middle: DVec3,
    /// Half the extent of all.
    reach: DVec3,
}

impl std::fmt::Debug for BoxTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // All of it follows from the items.
        f.debug_struct("BoxTree").field("levels", &self.levels).finish_non_exhaustive()
    }
}

/// An axis-parallel box.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bounds {
    /// Its lowest corner.
    pub(crate) low: DVec3,
    /// Its highest corner.
    pub(crate) high: DVec3,
}

impl Bounds {
    const NOTHING: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    fn join(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn moved(self, by: DVec3) -> Self {
        Self { low: self.low + by, high: self.high + by }
    }
}

/// A straight line through the tree: relative to its middle, between two distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalLine {
    /// Position at distance 0.
    pub(crate) origin: DVec3,
    /// Unit vector.
    pub(crate) direction: DVec3,
    /// Distances at which it begins and ends.
    pub(crate) ends: [f64; 2],
}

/// The largest number of items of a leaf.
const LEAF: usize = 8;
/// Nodes of fewer items are arranged by one thread.
const ALONE: usize = 1 << 13;

/// An item while the tree is made.
#[derive(Clone, Copy, Default)]
struct Item {
    /// Middle, radius.
    at: [f64; 4],
    number: u32,
}

impl BoxTree {
    /// The tree of `count` items, at least one, whose boxes lie inside `all`. `key` tells the middle and the radius of an item, by which the tree
    /// is cut, and `bounds` its box.
    pub(crate) fn new(
        count: usize,
        all: (DVec3, DVec3),
        key: impl Fn(usize) -> (DVec3, f64) + Sync + Send,
        bounds: impl Fn(usize) -> Bounds + Sync + Send,
    ) -> Self {
        let (low, high) = all;
        let middle = 0.5 * low + 0.5 * high;
        let item = |number: usize| {
            let (at, radius) = key(number);
            let [x, y, z] = (at - middle).to_array();
            Item { at: [x, y, z, radius], number: number as u32 }
        };
        let levels = count.div_ceil(LEAF).next_power_of_two().trailing_zeros();
        // Leaves are copied once, from those that are found side by side.
        let bytes = count * (size_of::<Item>() + size_of::<u32>()) + 3 * (size_of::<Bounds>() << levels);
        cancel::claim("the tree of boxes", bytes as u64);
        let mut items: Vec<Item> = collect(count, item);
        arrange(&mut items, count, levels, 0, 0);

        // The boxes of the leaves, then those of the nodes above.
        let leaves = 1usize << levels;
        let mut boxes = vec![Bounds::NOTHING; leaves];
        let around = |leaf: usize| {
            let in_leaf = &items[first(count, levels, leaf)..first(count, levels, leaf + 1)];
            in_leaf.iter().fold(Bounds::NOTHING, |b, item| b.join(bounds(item.number as usize).moved(-middle)))
        };
        boxes.extend(collect(leaves, around));
        for node in (1..leaves).rev() {
            boxes[node] = boxes[2 * node].join(boxes[2 * node + 1]);
        }
        let order = items.into_iter().map(|item| item.number).collect();
        Self { order, boxes, levels, middle, reach: 0.5 * (high - low) }
    }

    /// Origin of positions: the middle of all.
    pub(crate) fn middle(&self) -> DVec3 {
        self.middle
    }

    /// Upper bound, a generous one, of the error of a coordinate of about this size.
    fn slack(&self, at: DVec3) -> f64 {
        16.0 * f64::EPSILON * (self.reach.max_element() + at.abs().max_element())
    }

    /// Visits every item whose box holds a position, relative to the middle, and a few others.
    pub(crate) fn each_around(&self, at: DVec3, visit: impl FnMut(usize)) {
        let slack = DVec3::splat(self.slack(at));
        let (low, high) = (at - slack, at + slack);
        self.each(|b| b.low.cmple(high).all() && b.high.cmpge(low).all(), visit);
    }

    /// Visits every item whose box a line meets, and a few others.
    pub(crate) fn each_along(&self, line: &LocalLine, visit: impl FnMut(usize)) {
        let entry = self.entry(line);
        self.each(|b| entry(b, line.ends[1]).is_some(), visit);
    }

    /// Visits items whose boxes a line meets, the nearer ones first, as long as their boxes begin before the nearest distance that a visit has told.
    pub(crate) fn nearest_along(&self, line: &LocalLine, mut visit: impl FnMut(usize) -> Option<f64>) {
        let (leaves, slack) = (1usize << self.levels, self.slack(line.origin));
        let entry = self.entry(line);
        let mut end = line.ends[1];
        // Nodes that wait, with the distances at which the line enters them: at most one at each level.
        let mut waiting = [(1usize, f64::NEG_INFINITY); 33];
        let mut depth = usize::from(entry(&self.boxes[1], end).is_some());
        while depth > 0 {
            depth -= 1;
            let (mut node, start) = waiting[depth];
            if start > end + slack {
                continue;
            }
            // Goes down to a leaf by the nearer child.
            while node != 0 && node < leaves {
                let children = [2 * node, 2 * node + 1].map(|child| Some((child, entry(&self.boxes[child], end)?)));
                node = match children {
                    [Some(a), Some(b)] => {
                        let (near, far) = if b.1 < a.1 { (b, a) } else { (a, b) };
                        waiting[depth] = far;
                        depth += 1;
                        near.0
                    }
                    [Some(one), None] | [None, Some(one)] => one.0,
                    [None, None] => 0,
                };
            }
            if node == 0 {
                continue;
            }
            let (count, leaf) = (self.order.len(), node - leaves);
            for &number in &self.order[first(count, self.levels, leaf)..first(count, self.levels, leaf + 1)] {
                end = visit(number as usize).map_or(end, |found| end.min(found));
            }
        }
    }

    /// Distance at which a line, up to an end, enters a box, which is widened by rounding; `None` where it misses it.
    fn entry(&self, line: &LocalLine) -> impl Fn(&Bounds, f64) -> Option<f64> + use<> {
        let slack = DVec3::splat(self.slack(line.origin));
        let rate = line.direction.recip();
        let parallel = line.direction.cmpeq(DVec3::ZERO);
        let LocalLine { origin, ends: [first, _], .. } = *line;
        move |b, mut end| {
            let (low, high) = (b.low - slack - origin, b.high + slack - origin);
            let (a, c) = (low * rate, high * rate);
            let mut start = first;
            for axis in 0..3 {
                if !parallel.test(axis) {
                    start = start.max(a[axis].min(c[axis]));
                    end = end.min(a[axis].max(c[axis]));
                } else if low[axis] > 0.0 || high[axis] < 0.0 {
                    return None;
                }
            }
            (start <= end + slack.x).then_some(start)
        }
    }

    /// Visits the items of every leaf that can be reached through boxes that are `wanted`.
    fn each(&self, wanted: impl Fn(&Bounds) -> bool, mut visit: impl FnMut(usize)) {
        let leaves = 1usize << self.levels;
        // At most one waits at each level.
        let mut waiting = [0usize; 33];
        let (mut depth, mut node) = (0, 1);
        loop {
            if wanted(&self.boxes[node]) {
                if node < leaves {
                    waiting[depth] = 2 * node + 1;
                    depth += 1;
                    node *= 2;
                    continue;
                }
                let (count, leaf) = (self.order.len(), node - leaves);
                for &number in &self.order[first(count, self.levels, leaf)..first(count, self.levels, leaf + 1)] {
                    visit(number as usize);
                }
            }
            if depth == 0 {
                return;
            }
            depth -= 1;
            node = waiting[depth];
        }
    }
}

/// The first item of a leaf: all have the same number of them, give or take one.
fn first(count: usize, levels: u32, leaf: usize) -> usize {
    ((count as u64 * leaf as u64) >> levels) as usize
}

/// Brings the items of the node `node` of level `level` into the order of its leaves.
fn arrange(items: &mut [Item], count: usize, levels: u32, level: u32, node: usize) {
    if level == levels {
        return;
    }
    let (mut low, mut high) = ([f64::INFINITY; 4], [f64::NEG_INFINITY; 4]);
    for item in &*items {
        for a in 0..4 {
            low[a] = low[a].min(item.at[a]);
            high[a] = high[a].max(item.at[a]);
        }
    }
    let extent = |a: &usize| high[*a] - low[*a];
    let axis = (0..4).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
    let leaf = |node: usize, level: u32| node << (levels - level);
    let begin = first(count, levels, leaf(node, level));
    let half = first(count, levels, leaf(2 * node + 1, level + 1)) - begin;
    if half < items.len() {
        items.select_nth_unstable_by(half, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.number.cmp(&b.number)));
    }
    let alone = items.len() < ALONE;
    let (left, right) = items.split_at_mut(half);
    let go = |part, child| arrange(part, count, levels, level + 1, child);
    if alone {
        go(left, 2 * node);
        go(right, 2 * node + 1);
    } else {
        join(|| go(left, 2 * node), || go(right, 2 * node + 1));
    }
}
