//! All voxels, with rows along u: the volume's own samples where x is u, a transposed copy where y is.

use std::borrow::Cow;

use vr_core::parallel::each_part;

use super::PAD;
use super::pyramid::{EDGE, VisibleBlocks};

/// The axes (u, v, w) of a principal axis w, and where a voxel (u, v, k) lies in the dense array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    /// Axes among x, y, z that are u, v and w.
    pub axes: [usize; 3],
    /// Samples along u, v and w.
    pub size: [usize; 3],
    /// From one sample to the next along u, v and w; along u it is 1.
    pub strides: [usize; 3],
}

impl Layout {
    /// Layout of a volume seen along the principal axis `w`.
    pub fn new(dims: [usize; 3], w: usize) -> Self {
        let [x, y, z] = dims;
        let (axes, strides) = match w {
            0 => ([1, 2, 0], [1, y, y * z]),
            1 => ([0, 2, 1], [1, x * y, x]),
            _ => ([0, 1, 2], [1, x, x * y]),
        };
        Self { axes, size: axes.map(|a| dims[a]), strides }
    }

    /// Position of a voxel (u, v, k) in the dense array.
    #[inline]
    pub fn offset(&self, [u, v, k]: [usize; 3]) -> usize {
        u + v * self.strides[1] + k * self.strides[2]
    }

    /// x, y, z of a voxel (u, v, k).
    #[inline]
    pub fn position(&self, voxel: [usize; 3]) -> [usize; 3] {
        let mut p = [0; 3];
        for (axis, i) in self.axes.into_iter().zip(voxel) {
            p[axis] = i;
        }
        p
    }

    /// Rows of cells of a layer.
    pub fn cell_rows(&self) -> usize {
        self.size[1] - 1
    }

    /// Layers of cells with `N` edges: the layers themselves, or the slabs between them.
    pub fn cell_layers<const N: usize>(&self) -> usize {
        self.size[2] - usize::from(N == 4)
    }
}

/// All voxels of a volume with rows along u.
#[derive(Clone, Debug)]
pub(crate) struct Dense<'a, T: Clone> {
    /// Layout of the voxels.
    pub layout: Layout,
    /// The voxels; a transposed copy has [`PAD`] more behind them.
    pub samples: Cow<'a, [T]>,
}

impl<'a, T: Copy + Default + Send + Sync> Dense<'a, T> {
    /// Voxels of a volume seen along the principal axis `w`: copies only where w = 0.
    pub fn new(samples: &'a [T], dims: [usize; 3], w: usize) -> Self {
        let samples = if w == 0 { Cow::Owned(transposed(samples, dims)) } else { Cow::Borrowed(samples) };
        Self { layout: Layout::new(dims, w), samples }
    }

    /// Like [`Self::new`], but where it copies, only voxels of blocks that may be visible are sure to be copied. [`super::packed()`] reads no
    /// others, nor do runs of these blocks.
    pub fn visible(samples: &'a [T], dims: [usize; 3], w: usize, blocks: &VisibleBlocks) -> Self {
        // Where little is left out, wide tiles are faster.
        if w != 0 || 2 * blocks.count() > blocks.total() {
            return Self::new(samples, dims, w);
        }
        let samples = transposed_where(samples, dims, [16, 16], &|spans| blocks.touch(spans));
        Self { layout: Layout::new(dims, w), samples: Cow::Owned(samples) }
    }

    /// `len` voxels of a row, from (u, v, k) on.
    #[inline]
    pub fn row(&self, voxel: [usize; 3], len: usize) -> &[T] {
        let at = self.layout.offset(voxel);
        &self.samples[at..at + len]
    }
}

/// A copy with y fastest, then z, then x, and [`PAD`] elements behind it.
pub(crate) fn transposed<T: Copy + Default + Send + Sync>(samples: &[T], dims: [usize; 3]) -> Vec<T> {
    // As wide along x as a cache line, which is then read once.
    let width = (64 / size_of::<T>().max(1)).max(4);
    transposed_where(samples, dims, [width, 64], &|_| true)
}

/// Like [`transposed`], but only the tiles for which `wanted` holds of their first sample and the one behind their last: along x and y they
/// are as large as `tile`, along z like a block.
fn transposed_where<T: Copy + Default + Send + Sync>(
    samples: &[T],
    [nx, ny, nz]: [usize; 3],
    [width, height]: [usize; 2],
    wanted: &(dyn Fn([[usize; 2]; 3]) -> bool + Sync),
) -> Vec<T> {
    let mut out = vec![T::default(); nx * ny * nz + PAD];
    // A slab of x is a task.
    each_part(out[..nx * ny * nz].chunks_mut(width * ny * nz), |task, out| {
        let xs = [task * width, (task * width + width).min(nx)];
        // Rows of the result lie far apart, often by a power of two: written to one by one, they would push each other from the cache.
        let mut tile = vec![T::default(); width * height];
        let spans = |n: usize, step: usize| (0..n).step_by(step).map(move |first| [first, (first + step).min(n)]);
        for zs in spans(nz, EDGE) {
            for ys in spans(ny, height).filter(|&ys| wanted([xs, ys, zs])) {
                for z in zs[0]..zs[1] {
                    for y in ys[0]..ys[1] {
                        let row = &samples[(z * ny + y) * nx..][xs[0]..xs[1]];
                        for (to, &s) in tile[y - ys[0]..].iter_mut().step_by(height).zip(row) {
                            *to = s;
                        }
                    }
                    for (x, from) in tile.chunks_exact(height).take(xs[1] - xs[0]).enumerate() {
                        let to = &mut out[(x * nz + z) * ny..][ys[0]..ys[1]];
                        to.copy_from_slice(&from[..to.len()]);
                    }
                }
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_voxel_is_where_the_layout_says() {
        for dims in [[2, 2, 2], [5, 3, 2], [65, 3, 4], [3, 130, 2], [17, 66, 5]] {
            let samples: Vec<u16> = (0..dims.iter().product::<usize>()).map(|i| i as u16).collect();
            for w in 0..3 {
                let dense = Dense::new(&samples, dims, w);
                let [nu, nv, nw] = dense.layout.size;
                for k in 0..nw {
                    for v in 0..nv {
                        for (u, &s) in dense.row([0, v, k], nu).iter().enumerate() {
                            let [x, y, z] = dense.layout.position([u, v, k]);
                            assert_eq!(s, samples[(z * dims[1] + y) * dims[0] + x], "{dims:?} {w}");
                        }
                    }
                }
                assert_eq!(dense.samples.len(), samples.len() + if w == 0 { PAD } else { 0 });
            }
        }
    }
}
