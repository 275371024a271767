//! Separable filters of four taps per axis.

use super::{Filter, Lattice, Reconstruction};
use crate::real::Real;
use crate::voxel::Voxel;

/// A kernel of four taps along one axis: voxels i − 1, i, i + 1, i + 2 around the cell [i, i + 1].
pub trait Taps4: Copy + Send + Sync + 'static {
    /// The filter that it makes.
    const FILTER: Filter;
    /// The weights at fraction `t` in [0, 1]; they sum to 1.
    fn weights<R: Real>(t: R) -> [R; 4];
    /// Their derivatives by `t`; they sum to 0.
    fn derivatives<R: Real>(t: R) -> [R; 4];
}

/// The three-dimensional filter of a one-dimensional kernel: the product along the axes.
#[derive(Clone, Copy, Debug)]
pub struct Separable<K>(K);

impl<K: Taps4> Reconstruction for Separable<K> {
    const FILTER: Filter = K::FILTER;

    #[inline(always)]
    fn value<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> R {
        let cell: [(usize, R); 3] = std::array::from_fn(|a| lattice.cell(a, p[a]));
        let index: [[usize; 4]; 3] = std::array::from_fn(|a| K::FILTER.taps(cell[a].0, lattice.dims[a]));
        let w: [[R; 4]; 3] = std::array::from_fn(|a| K::weights(cell[a].1));
        let mut sum = R::ZERO;
        for k in 0..4 {
            let mut plane = R::ZERO;
            for j in 0..4 {
                let o = lattice.offset(0, index[1][j], index[2][k]);
                let mut line = R::ZERO;
                for i in 0..4 {
                    line += w[0][i] * R::from_f32(lattice.samples[o + index[0][i]].to_f32());
                }
                plane += w[1][j] * line;
            }
            sum += w[2][k] * plane;
        }
        sum
    }

    #[inline(always)]
    fn value_and_gradient<T: Voxel, R: Real>(lattice: &Lattice<'_, T>, p: [R; 3]) -> (R, [R; 3]) {
        let cell: [(usize, R); 3] = std::array::from_fn(|a| lattice.cell(a, p[a]));
        let index: [[usize; 4]; 3] = std::array::from_fn(|a| K::FILTER.taps(cell[a].0, lattice.dims[a]));
        let w: [[R; 4]; 3] = std::array::from_fn(|a| K::weights(cell[a].1));
        let d: [[R; 4]; 3] = std::array::from_fn(|a| K::derivatives(cell[a].1));
        let (mut value, mut gradient) = (R::ZERO, [R::ZERO; 3]);
        for k in 0..4 {
            let (mut plane, mut plane_x, mut plane_y) = (R::ZERO, R::ZERO, R::ZERO);
            for j in 0..4 {
                let o = lattice.offset(0, index[1][j], index[2][k]);
                let (mut line, mut line_x) = (R::ZERO, R::ZERO);
                for i in 0..4 {
                    let s = R::from_f32(lattice.samples[o + index[0][i]].to_f32());
                    line += w[0][i] * s;
                    line_x += d[0][i] * s;
                }
                plane += w[1][j] * line;
                plane_x += w[1][j] * line_x;
                plane_y += d[1][j] * line;
            }
            value += w[2][k] * plane;
            gradient[0] += w[2][k] * plane_x;
            gradient[1] += w[2][k] * plane_y;
            gradient[2] += d[2][k] * plane;
        }
        (value, gradient)
    }
}
