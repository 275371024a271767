//! Distance of every point to its k-th nearest neighbour.
//!
//! Own code: of the k-d trees at hand, one stops early where points coincide, one takes quadratic time there, and one four times as long.

use vr_core::parallel;

type Position = [f64; 3];

/// Parts of so many points are searched one by one.
const LEAF: usize = 16;
/// Runs of so many points are searched for on one thread.
const RUN: usize = 1 << 10;
/// Parts of so many points are split on another thread.
const ALONE: usize = 1 << 14;

/// The distance from each point to its `k`-th nearest other point, which coincident ones are, too; `k` must be below their number. Results
/// depend on the positions alone.
pub(super) fn distances(positions: &[Position], k: usize) -> Vec<f64> {
    let mut tree = Tree {
        points: positions.iter().enumerate().map(|(id, &position)| (position, id)).collect(),
        axes: vec![0; positions.len()],
    };
    split(&mut tree.points, &mut tree.axes);
    // In the order of the tree: one search finds warm what the one before it left, and knows how far it has to look at most.
    let mut found = vec![0.0; positions.len()];
    parallel::each_part(found.chunks_mut(RUN).zip(tree.points.chunks(RUN)), |_, (found, points)| {
        let (mut nearest, mut before, mut distance) = (Nearest::new(k + 1), [0.0; 3], f64::INFINITY);
        for (found, (position, _)) in found.iter_mut().zip(*points) {
            // A little more, lest rounding cuts off the farthest.
            let max_distance = (distance + squared(&before, position).sqrt()) * (1.0 + 1e-9);
            nearest.clear(max_distance * max_distance);
            tree.search(0..positions.len(), position, [0.0; 3], &mut nearest);
            (before, distance) = (*position, nearest.farthest().sqrt());
            *found = distance;
        }
    });
    let mut distances = vec![0.0; positions.len()];
    for (&(_, id), distance) in tree.points.iter().zip(found) {
        distances[id] = distance;
    }
    distances
}

/// A balanced k-d tree (Bentley 1975, "Multidimensional binary search trees used for associative searching") without nodes: each part
/// of the list is split at its middle.
struct Tree {
    points: Vec<(Position, usize)>,
    /// Axis that each part is split across, at the part's middle.
    axes: Vec<u8>,
}

/// Orders a part: what is below its middle point along the axis of its largest extent comes first.
fn split(points: &mut [(Position, usize)], axes: &mut [u8]) {
    if points.len() <= LEAF {
        return;
    }
    let extent = |axis: usize| {
        let ends = points
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (p, _)| (low.min(p[axis]), high.max(p[axis])));
        ends.1 - ends.0
    };
    let extents = [extent(0), extent(1), extent(2)];
    let axis = (1..3).fold(0, |best, axis| if extents[axis] > extents[best] { axis } else { best });
    let middle = points.len() / 2;
    // The number decides between equals, so that there is one order.
    points.select_nth_unstable_by(middle, |(a, i), (b, j)| a[axis].total_cmp(&b[axis]).then(i.cmp(j)));
    axes[middle] = axis as u8;
    let (low, high) = points.split_at_mut(middle);
    let (low_axes, high_axes) = axes.split_at_mut(middle);
    // The middle point and its axis stay where they are.
    let (high, high_axes) = (&mut high[1..], &mut high_axes[1..]);
    if low.len() < ALONE {
        split(low, low_axes);
        split(high, high_axes);
    } else {
        parallel::join(|| split(low, low_axes), || split(high, high_axes));
    }
}

impl Tree {
    /// Looks through a part of the list, `offset` away from the searched position along each axis.
    fn search(&self, part: std::ops::Range<usize>, at: &Position, offset: Position, nearest: &mut Nearest) {
        if part.len() <= LEAF {
            self.points[part].iter().for_each(|(p, _)| nearest.offer(squared(p, at)));
            return;
        }
        let middle = part.start + part.len() / 2;
        let axis = usize::from(self.axes[middle]);
        let (split, _) = &self.points[middle];
        let beyond = at[axis] - split[axis];
        let (low, high) = (part.start..middle, middle + 1..part.end);
        let (near, far) = if beyond < 0.0 { (low, high) } else { (high, low) };
        self.search(near, at, offset, nearest);
        nearest.offer(squared(split, at));
        let mut offset = offset;
        offset[axis] = beyond;
        if squared(&offset, &[0.0; 3]) < nearest.farthest() {
            self.search(far, at, offset, nearest);
        }
    }
}

fn squared(a: &Position, b: &Position) -> f64 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

/// The smallest of the squared distances offered, in ascending order.
struct Nearest(Vec<f64>);

impl Nearest {
    fn new(count: usize) -> Self {
        Self(vec![f64::INFINITY; count])
    }

    /// Forgets all; as many as are kept are known to be nearer than the square root of `max_squared`.
    fn clear(&mut self, max_squared: f64) {
        self.0.fill(max_squared);
    }

    fn farthest(&self) -> f64 {
        self.0.last().copied().unwrap_or(f64::INFINITY)
    }

    fn offer(&mut self, squared: f64) {
        let mut place = self.0.len() - 1;
        if squared >= self.0[place] {
            return;
        }
        while place > 0 && self.0[place - 1] > squared {
            self.0[place] = self.0[place - 1];
            place -= 1;
        }
        self.0[place] = squared;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Compares all pairs.
    fn naive(positions: &[Position], k: usize) -> Vec<f64> {
        let one = |at: &Position| {
            let mut all: Vec<f64> = positions.iter().map(|p| squared(p, at)).collect();
            all.sort_by(f64::total_cmp);
            all[k].sqrt()
        };
        positions.iter().map(one).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]
        #[test]
        fn the_tree_finds_what_all_pairs_tell(
            // Few coordinates, so that many coincide.
            cells in prop::collection::vec(prop::array::uniform3(-4i8..4), 20..300),
            scale in prop::sample::select(vec![1.0, 1e-9, 1e9]),
            k in 1usize..19,
        ) {
            let positions: Vec<Position> = cells.iter().map(|c| c.map(|x| f64::from(x).powi(3) * scale)).collect();
            prop_assert_eq!(distances(&positions, k), naive(&positions, k));
        }
    }

    #[test]
    fn a_hundred_thousand_at_one_place_are_no_trouble() {
        assert!(distances(&vec![[1.0, 2.0, 3.0]; 100_000], 58).iter().all(|&d| d == 0.0));
    }
}
