//! How far the field is from a linear function, block by block.

use rayon::prelude::*;
use vr_core::filter::Lattice;
use vr_core::{LatticeVisitor, UniformVolume, Voxel};

/// For each block of `edge`³ cells (x fastest), a bound on how far the trilinear field in it is from some linear function, in stored units.
///
/// The linear function has the slopes that take the mean of each face to the mean of the opposite one. A trilinear function less a linear
/// one is trilinear: it is farthest from 0 at a sample.
pub(crate) fn bends(volume: &UniformVolume, edge: usize) -> Vec<f32> {
    volume.with_lattice(Bends { edge })
}

struct Bends {
    edge: usize,
}

impl LatticeVisitor for Bends {
    type Output = Vec<f32>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Vec<f32> {
        let cells = lattice.dims.map(|n| n - 1);
        let [bx, by, bz] = cells.map(|n| n.div_ceil(self.edge));
        let block = |b: usize| {
            let first = [b % bx, b / bx % by, b / (bx * by)].map(|i| i * self.edge);
            let last = std::array::from_fn(|a| (first[a] + self.edge).min(cells[a]));
            bend(&lattice, first, last)
        };
        (0..bx * by * bz).into_par_iter().with_min_len(64).map(block).collect()
    }
}

/// Of the closed block of samples `first ..= last`.
fn bend<T: Voxel>(lattice: &Lattice<'_, T>, first: [usize; 3], last: [usize; 3]) -> f32 {
    // Twice the position less the block's middle: whole numbers, that sum to 0 along an axis.
    let away = |a: usize, i: usize| (2 * i) as f32 - (first[a] + last[a]) as f32;
    let origin: f32 = lattice.at(first[0], first[1], first[2]);
    let mut slope = [0.0f32; 3];
    let mut weight = [0.0f32; 3];
    let each = |f: &mut dyn FnMut([usize; 3], f32)| {
        for z in first[2]..=last[2] {
            for y in first[1]..=last[1] {
                let row = &lattice.samples[lattice.offset(first[0], y, z)..=lattice.offset(last[0], y, z)];
                for (x, s) in (first[0]..=last[0]).zip(row) {
                    f([x, y, z], s.to_f32() - origin);
                }
            }
        }
    };
    each(&mut |p, s| {
        for a in 0..3 {
            let d = away(a, p[a]);
            slope[a] += d * s;
            weight[a] += d * d;
        }
    });
    let slope: [f32; 3] = std::array::from_fn(|a| slope[a] / weight[a]);
    let (mut low, mut high, mut size) = (f32::INFINITY, f32::NEG_INFINITY, 0.0f32);
    each(&mut |p, s| {
        let linear = slope[0] * away(0, p[0]) + slope[1] * away(1, p[1]) + slope[2] * away(2, p[2]);
        (low, high, size) = (low.min(s - linear), high.max(s - linear), size.max(s.abs() + linear.abs()));
    });
    // Four roundings of numbers up to `size`.
    0.5 * (high - low) + 8.0 * f32::EPSILON * size
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume};

    fn of(f: impl Fn(usize, usize, usize) -> f32) -> Vec<f32> {
        let dims = [10, 6, 5];
        let samples = (0..300).map(|i| f(i % 10, i / 10 % 6, i / 60)).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into();
        bends(volume.uniform().unwrap(), 4)
    }

    #[test]
    fn linear_is_straight_and_a_step_is_not() {
        let straight = of(|x, y, z| 1e3 + x as f32 - 2.0 * y as f32 + 0.5 * z as f32);
        assert_eq!(straight.len(), 3 * 2);
        assert!(straight.iter().all(|&d| d < 1e-4), "{straight:?}");
        let bent = of(|x, _, _| if x == 2 { 1.0 } else { 0.0 });
        assert!(bent[0] >= 0.5 && bent[1] < 1e-6, "{bent:?}");
        // z² on −2 … 2: the best line is 2 away from 0 and 4.
        let square = of(|_, _, z| (z as f32 - 2.0).powi(2));
        assert!((square[0] - 2.0).abs() < 1e-5, "{square:?}");
    }
}
