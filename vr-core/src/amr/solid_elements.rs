//! Elements of a brick that are not vacuum.

use glam::DVec3;

use super::block::AmrCentring;
use super::bricks::EDGE;
use super::check::each_index;
use super::element::Element;
use super::grid::AmrGrid;
use super::level::{corner, plus};

/// Elements of a brick, each a bit: set for leaves in which there is a field. They stand in Morton's order, so that the elements of an aligned cube
/// are bits beside each other, and a ray crosses the largest cube of one kind at once.
#[derive(Clone, Debug)]
pub(super) struct SolidElements {
    words: Box<[u64]>,
    /// Binary logarithm of the number of elements along its edge.
    max_size: u32,
}

/// Cube of elements that are all solid, or none of which is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ElementCube {
    /// Lowest element, from the first of the brick on.
    pub(super) first: [i64; 3],
    /// Number of elements along its edge.
    pub(super) edge: i64,
    pub(super) is_solid: bool,
}

impl SolidElements {
    /// The elements of the cells `from` up to `to`, which is excluded, of a level, that no finer ones cover.
    pub(super) fn new(grid: &AmrGrid, level: usize, from: [i64; 3], to: [i64; 3]) -> Self {
        let elements = grid.centring.elements();
        let max_size = (EDGE * elements).trailing_zeros();
        let mut words = vec![0u64; 1 << (3 * max_size - 6)];
        let samples = SamplesAround::new(grid, level, from, to);
        for cell in each_index(from, to).filter(|&cell| !grid.is_covered(level, cell)) {
            let first = cell.map(|i| i * elements);
            for node in each_index(first, plus(first, [elements; 3])) {
                let is_solid = samples
                    .is_solid(node)
                    .unwrap_or_else(|| !grid.rim_value(Element { level, node }, DVec3::splat(0.5)).is_nan());
                let place = morton(std::array::from_fn(|a| node[a] - from[a] * elements));
                words[place / 64] |= u64::from(is_solid) << (place % 64);
            }
        }
        Self { words: words.into(), max_size }
    }

    /// The largest aligned cube of one kind around an element, counted from the first of the brick on.
    pub(super) fn cube_at(&self, element: [i64; 3]) -> ElementCube {
        let place = morton(element);
        let is_solid = self.words[place / 64] >> (place % 64) & 1 == 1;
        let whole = if is_solid { u64::MAX } else { 0 };
        let is_even = |size: &u32| {
            let count = 1usize << (3 * size);
            let first = place & !(count - 1);
            if count < 64 {
                let bits = (1u64 << count) - 1;
                (self.words[first / 64] ^ whole) >> (first % 64) & bits == 0
            } else {
                self.words[first / 64..(first + count) / 64].iter().all(|&word| word == whole)
            }
        };
        let size = (1..=self.max_size).take_while(is_even).last().unwrap_or(0);
        ElementCube { first: element.map(|i| i >> size << size), edge: 1 << size, is_solid }
    }
}

/// Samples in and around a brick, looked up once.
struct SamplesAround {
    first: [i64; 3],
    dims: [i64; 3],
    /// True for a sample that has a value; `None` where values in the middles of cells are not all that counts.
    has_value: Option<Vec<bool>>,
}

impl SamplesAround {
    fn new(grid: &AmrGrid, level: usize, from: [i64; 3], to: [i64; 3]) -> Self {
        let (first, end) = (from.map(|i| i - 1), to.map(|i| i + 1));
        let dims = plus(end, first.map(|i| -i));
        let has_value = (grid.centring == AmrCentring::Cells)
            .then(|| each_index(first, end).map(|at| !grid.sample(level, at).is_nan()).collect());
        Self { first, dims, has_value }
    }

    /// True for an element all samples around which have values; `None` if that has to be found out otherwise.
    fn is_solid(&self, node: [i64; 3]) -> Option<bool> {
        let has_value = self.has_value.as_ref()?;
        let low = node.map(|n| (n - 1) >> 1);
        let is_there = |i: usize| {
            let at: [i64; 3] = std::array::from_fn(|a| low[a] + corner(i)[a] - self.first[a]);
            has_value[((at[2] * self.dims[1] + at[1]) * self.dims[0] + at[0]) as usize]
        };
        (0..8).all(is_there).then_some(true)
    }
}

/// Place in Morton's order of an element with coordinates below 16.
fn morton(element: [i64; 3]) -> usize {
    let spread = |i: i64| (i & 1 | (i & 2) << 2 | (i & 4) << 4 | (i & 8) << 6) as usize;
    spread(element[0]) | spread(element[1]) << 1 | spread(element[2]) << 2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cubes_are_of_one_kind_and_as_large_as_can_be() {
        // All is solid but the lowest layer.
        let mut words = vec![u64::MAX; 64];
        for at in each_index([0; 3], [16, 16, 1]) {
            let place = morton(at);
            words[place / 64] &= !(1 << (place % 64));
        }
        let elements = SolidElements { words: words.into(), max_size: 4 };
        let cube = |at| elements.cube_at(at);
        assert_eq!(cube([5, 9, 0]), ElementCube { first: [5, 9, 0], edge: 1, is_solid: false });
        assert_eq!(cube([5, 9, 1]), ElementCube { first: [5, 9, 1], edge: 1, is_solid: true });
        assert_eq!(cube([5, 9, 3]), ElementCube { first: [4, 8, 2], edge: 2, is_solid: true });
        assert_eq!(cube([5, 9, 6]), ElementCube { first: [4, 8, 4], edge: 4, is_solid: true });
        assert_eq!(cube([5, 9, 15]), ElementCube { first: [0, 8, 8], edge: 8, is_solid: true });
        let all = SolidElements { words: vec![0; 8].into(), max_size: 3 };
        assert_eq!(all.cube_at([7; 3]), ElementCube { first: [0; 3], edge: 8, is_solid: false });
    }
}
