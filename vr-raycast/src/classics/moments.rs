//! Octree of means and variances of the field.

use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{Filter, GridVolume, LatticeVisitor, Voxel};

use super::homogeneity::Homogeneity;

/// Mean of the field in each node of an octree over the blocks, and its root mean square deviation from that, in stored units (Danskin and Hanrahan
/// 1992, *Fast algorithms for volume ray tracing*, keep a pyramid of averages and errors).
///
/// Samples count by the part of the node that is nearest to them: half at a face, a quarter at an edge. So a node's mean is exactly that
/// of the field, trilinear or nearest. And so is the mean square for the filter nearest; a trilinear value is a mean of its cell's corners, and
/// the square of a mean is at most the mean of the squares: there it is a bound. Both hold for any number in the place of the mean, and so for the mean
/// rounded to f32.
///
/// Missing samples count by the values that stand in for them; nodes with missing samples are never crossed at their mean. A node takes eight bytes, which is
/// 14 % of a volume of bytes.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    levels: Vec<Level>,
}

/// Nodes of one size.
#[derive(Clone, Debug)]
struct Level {
    size: [usize; 3],
    nodes: Vec<Moment>,
}

/// Mean and root mean square deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    pub(crate) mean: f32,
    pub(crate) deviation: f32,
}

/// Sums of a node: its cells, the mean, and the mean square deviation.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    cells: f64,
    mean: f64,
    square: f64,
}

impl Sums {
    const NOTHING: Self = Self { cells: 0.0, mean: 0.0, square: 0.0 };

    fn with(self, other: Self) -> Self {
        let cells = self.cells + other.cells;
        let (a, b) = (self.cells / cells, other.cells / cells);
        let apart = other.mean - self.mean;
        Self { cells, mean: self.mean + b * apart, square: a * self.square + b * other.square + a * b * apart * apart }
    }

    fn moment(self) -> Moment {
        // Rounding of sums of a few hundred numbers in f64, and of the mean to f32.
        let deviation = self.square.sqrt() * (1.0 + 1e-6) + 1.5e-7 * self.mean.abs();
        Moment { mean: self.mean as f32, deviation: deviation as f32 }
    }
}

impl Moments {
    /// Makes the octree of a volume; `None` where the field in a node depends on samples beyond it.
    pub(crate) fn new(volume: &GridVolume) -> Option<Self> {
        if !matches!(volume.filter(), Filter::Trilinear | Filter::Nearest) {
            return None;
        }
        let edge = Homogeneity::EDGE;
        let cells = volume.dims().map(|n| n - 1);
        let mut size = cells.map(|n| n.div_ceil(edge));
        let block = |b: usize| {
            let first = [b % size[0], b / size[0] % size[1], b / (size[0] * size[1])].map(|i| i * edge);
            let last = std::array::from_fn(|a| (first[a] + edge).min(cells[a]));
            volume.with_lattice(Block { first, last })
        };
        let mut sums: Vec<Sums> = collect(size.iter().product(), block);
        let mut levels = Vec::new();
        loop {
            levels.push(Level { size, nodes: sums.iter().map(|s| s.moment()).collect() });
            if size == [1; 3] {
                return Some(Self { levels });
            }
            (sums, size) = parents(&sums, size);
        }
    }

    /// Returns the moments of the node of a level around a block.
    pub(crate) fn at(&self, level: u32, block: [usize; 3]) -> Moment {
        let Level { size, nodes } = &self.levels[level as usize];
        let [x, y, z] = block.map(|b| b >> level);
        nodes[(z * size[1] + y) * size[0] + x]
    }

    /// Returns the moments of all nodes of a level, x fastest.
    pub(crate) fn of_level(&self, level: u32) -> &[Moment] {
        &self.levels[level as usize].nodes
    }
}

/// Joins nodes to those of twice the edge.
fn parents(nodes: &[Sums], size: [usize; 3]) -> (Vec<Sums>, [usize; 3]) {
    let half = size.map(|n| n.div_ceil(2));
    let mut parents = Vec::with_capacity(half.iter().product());
    for z in 0..half[2] {
        for y in 0..half[1] {
            for x in 0..half[0] {
                let mut sum = Sums::NOTHING;
                for i in 0..8 {
                    let at = [2 * x + (i & 1), 2 * y + (i >> 1 & 1), 2 * z + (i >> 2)];
                    if (0..3).all(|a| at[a] < size[a]) {
                        sum = sum.with(nodes[(at[2] * size[1] + at[1]) * size[0] + at[0]]);
                    }
                }
                parents.push(sum);
            }
        }
    }
    (parents, half)
}

/// The closed block of samples `first ..= last`.
struct Block {
    first: [usize; 3],
    last: [usize; 3],
}

impl LatticeVisitor for Block {
    type Output = Sums;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Sums {
        let Self { first, last } = self;
        let cells: f64 = (0..3).map(|a| (last[a] - first[a]) as f64).product();
        let part = |a: usize, i: usize| if i == first[a] || i == last[a] { 0.5 } else { 1.0 };
        let mean_of = |f: &dyn Fn(f64) -> f64| {
            let mut sum = 0.0;
            for z in first[2]..=last[2] {
                for y in first[1]..=last[1] {
                    let row = &lattice.samples[lattice.offset(first[0], y, z)..=lattice.offset(last[0], y, z)];
                    let inner = |(i, s): (usize, &T)| part(0, first[0] + i) * f(f64::from(s.to_f32()));
                    sum += part(1, y) * part(2, z) * row.iter().enumerate().map(inner).sum::<f64>();
                }
            }
            sum / cells
        };
        let mean = mean_of(&|s| s);
        Sums { cells, mean, square: mean_of(&|s| (s - mean) * (s - mean)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume};

    /// Moments of every node against sums over the node's samples, each by its part.
    #[test]
    fn nodes_have_the_moments_of_their_samples() {
        let dims = [14usize, 10, 6];
        let value = |x: usize, y: usize, z: usize| (x * x * 3 + y * 7 + z * x * 2) as f32 * 0.25;
        let make = || -> Volume {
            let sample = |i: usize| value(i % 14, i / 14 % 10, i / 140);
            let placement = Placement::from_spacing([1.0; 3]).unwrap();
            UniformGrid::<f32>::new(dims, (0..840).map(sample).collect::<Vec<_>>(), placement, Calibration::default())
                .unwrap()
                .into()
        };
        let volume = make();
        let moments = Moments::new(volume.grid().unwrap()).unwrap();
        assert_eq!(moments.levels.len(), 3);
        for level in 0..3u32 {
            let edge = Homogeneity::EDGE << level;
            let size = moments.levels[level as usize].size;
            for b in 0..size.iter().product::<usize>() {
                let at = [b % size[0], b / size[0] % size[1], b / (size[0] * size[1])];
                let ends: [[usize; 2]; 3] =
                    std::array::from_fn(|a| [at[a] * edge, ((at[a] + 1) * edge).min(dims[a] - 1)]);
                let (mut n, mut sum, mut squares) = (0.0, 0.0, 0.0);
                for z in ends[2][0]..=ends[2][1] {
                    for y in ends[1][0]..=ends[1][1] {
                        for x in ends[0][0]..=ends[0][1] {
                            let part: f64 = [x, y, z]
                                .iter()
                                .zip(ends)
                                .map(|(i, ends)| if ends.contains(i) { 0.5 } else { 1.0 })
                                .product();
                            let v = f64::from(value(x, y, z));
                            (n, sum, squares) = (n + part, sum + part * v, squares + part * v * v);
                        }
                    }
                }
                let (mean, square) = (sum / n, squares / n - (sum / n).powi(2));
                let got = moments.at(level, at.map(|i| i << level));
                assert!((f64::from(got.mean) - mean).abs() < 1e-5 * mean.abs().max(1.0), "{got:?} {mean}");
                assert!((f64::from(got.deviation) - square.max(0.0).sqrt()).abs() < 1e-3, "{got:?} {square}");
            }
        }
    }
}
