//! Distance of the field from a linear function, block by block.

use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{GridVolume, LatticeVisitor, Voxel};

/// Returns, for each block of `edge`³ cells (x fastest), a bound of the distance of the trilinear field in it from some linear function, in stored units.
///
/// The linear function is the one of least squares, shifted to the middle of what is left. A trilinear function less a linear
/// one is trilinear: it is farthest from 0 at a sample.
pub(crate) fn bends(volume: &GridVolume, edge: usize) -> Vec<f32> {
    let cells = volume.dims().map(|n| n - 1);
    let [bx, by, bz] = cells.map(|n| n.div_ceil(edge));
    let block = |b: usize| {
        let first = [b % bx, b / bx % by, b / (bx * by)].map(|i| i * edge);
        let last = std::array::from_fn(|a| (first[a] + edge).min(cells[a]));
        volume.with_lattice(Block { first, last })
    };
    collect(bx * by * bz, block)
}

/// The closed block of samples `first ..= last`.
struct Block {
    first: [usize; 3],
    last: [usize; 3],
}

impl LatticeVisitor for Block {
    type Output = f32;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> f32 {
        bend(&lattice, self.first, self.last)
    }
}

fn bend<T: Voxel>(lattice: &Lattice<'_, T>, first: [usize; 3], last: [usize; 3]) -> f32 {
    // Twice the position less the block's middle: whole numbers that sum to 0 along an axis.
    let away = |a: usize, i: usize| (2 * i) as f32 - (first[a] + last[a]) as f32;
    let origin: f32 = lattice.at(first[0], first[1], first[2]);
    let mut slope = [0.0f32; 3];
    for_each_row(lattice, first, last, |y, z, row| {
        let (mut sum, mut along) = (0.0, 0.0);
        for (x, s) in row.iter().enumerate() {
            let s = s.to_f32() - origin;
            sum += s;
            along += away(0, first[0] + x) * s;
        }
        slope[0] += along;
        slope[1] += away(1, y) * sum;
        slope[2] += away(2, z) * sum;
    });
    // Σ away² over an axis of n + 1 samples is n (n + 1) (n + 2) / 3; every sample of the others counts once.
    let n: [f32; 3] = std::array::from_fn(|a| (last[a] - first[a]) as f32);
    let samples = (n[0] + 1.0) * (n[1] + 1.0) * (n[2] + 1.0);
    let slope: [f32; 3] = std::array::from_fn(|a| 3.0 * slope[a] / (samples * n[a] * (n[a] + 2.0)));
    let (mut low, mut high, mut size) = (f32::INFINITY, f32::NEG_INFINITY, 0.0f32);
    for_each_row(lattice, first, last, |y, z, row| {
        let across = slope[1] * away(1, y) + slope[2] * away(2, z);
        for (x, s) in row.iter().enumerate() {
            let (s, linear) = (s.to_f32() - origin, across + slope[0] * away(0, first[0] + x));
            let off = s - linear;
            low = if off < low { off } else { low };
            high = if off > high { off } else { high };
            size = if s.abs() > size { s.abs() } else { size };
        }
    });
    let steep = (0..3).map(|a| slope[a].abs() * n[a]).sum::<f32>();
    // Four roundings of numbers up to the sum of both.
    0.5 * (high - low) + 8.0 * f32::EPSILON * (size + steep)
}

#[inline(always)]
fn for_each_row<T: Voxel>(
    lattice: &Lattice<'_, T>,
    first: [usize; 3],
    last: [usize; 3],
    mut row: impl FnMut(usize, usize, &[T]),
) {
    for z in first[2]..=last[2] {
        for y in first[1]..=last[1] {
            row(y, z, &lattice.samples[lattice.offset(first[0], y, z)..=lattice.offset(last[0], y, z)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, Placement, UniformGrid, Volume};

    fn of(f: impl Fn(usize, usize, usize) -> f32) -> Vec<f32> {
        let dims = [10, 6, 5];
        let samples: Vec<f32> = (0..300).map(|i| f(i % 10, i / 10 % 6, i / 60)).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into();
        bends(volume.grid().unwrap(), 4)
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
