//! Gradients as VTK's mappers take them: central differences at the voxels, interpolated trilinearly.

use crate::filter::Lattice;
use crate::real::Real;
use crate::voxel::Voxel;

/// The gradient per index step at a voxel: central differences, one-sided at the faces of the box.
#[inline]
pub fn gradient_at_sample<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, index: [usize; 3]) -> [R; 3] {
    std::array::from_fn(|a| {
        let (mut low, mut high) = (index, index);
        low[a] = index[a].saturating_sub(1);
        high[a] = (index[a] + 1).min(lattice.dims[a] - 1);
        let rise = lattice.at::<R>(high[0], high[1], high[2]) - lattice.at::<R>(low[0], low[1], low[2]);
        rise / R::from_index(high[a] - low[a])
    })
}

/// The gradient per index step at any position: trilinear between those of the eight voxels around it.
#[inline]
pub fn gradient_between_samples<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> [R; 3] {
    let cell: [(usize, R); 3] = std::array::from_fn(|a| lattice.cell(a, p[a]));
    let mut sum = [R::ZERO; 3];
    for corner in 0..8 {
        let high = |a: usize| corner >> a & 1;
        let weight = |a: usize| if high(a) == 1 { cell[a].1 } else { R::ONE - cell[a].1 };
        let w = weight(0) * weight(1) * weight(2);
        let g = gradient_at_sample::<T, R>(lattice, std::array::from_fn(|a| cell[a].0 + high(a)));
        for a in 0..3 {
            sum[a] += w * g[a];
        }
    }
    sum
}

/// The gradient per index step at any position, as [`gradient_between_samples`] has it, and how it changes over a step of an extent in index space:
/// its derivative there, times the step.
#[inline]
pub fn gradient_and_turn<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3], step: [R; 3]) -> [[R; 3]; 2] {
    let cell: [(usize, R); 3] = std::array::from_fn(|a| lattice.cell(a, p[a]));
    let (mut sum, mut turn) = ([R::ZERO; 3], [R::ZERO; 3]);
    for corner in 0..8 {
        let high = |a: usize| corner >> a & 1;
        let weight = |a: usize| if high(a) == 1 { cell[a].1 } else { R::ONE - cell[a].1 };
        let change = |a: usize| if high(a) == 1 { step[a] } else { -step[a] };
        let [x, y, z] = [weight(0), weight(1), weight(2)];
        let (w, moved) = (x * y * z, change(0) * y * z + x * change(1) * z + x * y * change(2));
        let g = gradient_at_sample::<T, R>(lattice, std::array::from_fn(|a| cell[a].0 + high(a)));
        for a in 0..3 {
            sum[a] += w * g[a];
            turn[a] += moved * g[a];
        }
    }
    [sum, turn]
}
