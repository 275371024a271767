//! A box of a volume's texels.

use vr_core::filter::Lattice;

use crate::layout::Layout;

/// The texels from an index on, so many along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    pub(crate) first: [usize; 3],
    pub(crate) dims: [usize; 3],
}

impl Region {
    /// All texels of a volume.
    pub(crate) fn whole(dims: [usize; 3]) -> Self {
        Self { first: [0; 3], dims }
    }

    /// The corners of cells, given from the first to behind the last along each axis, and `apron` texels more on all sides where the volume has them.
    pub(crate) fn around(cells: &[[usize; 2]; 3], apron: usize, dims: [usize; 3]) -> Self {
        let first = cells.map(|[first, _]| first.saturating_sub(apron));
        Self { first, dims: std::array::from_fn(|a| (cells[a][1] + 1 + apron).min(dims[a]) - first[a]) }
    }

    /// The same with texels from another one on along the last axis.
    pub(crate) fn starting_at_layer(&self, first: usize) -> Self {
        let mut region = *self;
        (region.first[2], region.dims[2]) = (first, self.first[2] + self.dims[2] - first);
        region
    }

    /// The same box along the volume's own axes.
    pub(crate) fn turned_back(&self, layout: &Layout) -> Self {
        Self { first: layout.turned_back(self.first), dims: layout.turned_back(self.dims) }
    }

    /// Number of texels.
    pub(crate) fn count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Number of rows along x.
    pub(crate) fn rows(&self) -> usize {
        self.dims[1] * self.dims[2]
    }

    /// Index of the first texel of a row.
    pub(crate) fn row(&self, row: usize) -> [usize; 3] {
        let [x, y, z] = self.first;
        [x, y + row % self.dims[1], z + row / self.dims[1]]
    }

    /// The texels that a lattice has there.
    pub(crate) fn copied<T: Copy>(&self, lattice: &Lattice<'_, T>) -> Vec<T> {
        let mut texels = Vec::with_capacity(self.count());
        for row in 0..self.rows() {
            let [x, y, z] = self.row(row);
            let from = (z * lattice.dims[1] + y) * lattice.dims[0] + x;
            texels.extend_from_slice(&lattice.samples[from..from + self.dims[0]]);
        }
        texels
    }

    /// The texels that a lattice has there, if coordinate c of the region is the index along axis `axes[c]` of the lattice.
    pub(crate) fn copied_along<T: Copy>(&self, axes: [usize; 3], lattice: &Lattice<'_, T>) -> Vec<T> {
        if axes == [0, 1, 2] {
            return self.copied(lattice);
        }
        let strides = [1, lattice.dims[0], lattice.dims[0] * lattice.dims[1]];
        let [sx, sy, sz] = axes.map(|a| strides[a]);
        let mut texels = Vec::with_capacity(self.count());
        for row in 0..self.rows() {
            let [x, y, z] = self.row(row);
            let from = x * sx + y * sy + z * sz;
            texels.extend((0..self.dims[0]).map(|i| lattice.samples[from + i * sx]));
        }
        texels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_apron_ends_at_the_volume() {
        let samples: Vec<usize> = (0..9 * 7 * 6).collect();
        let lattice = Lattice { samples: &samples, dims: [9, 7, 6] };
        let region = Region::around(&[[0, 4], [4, 6], [2, 4]], 1, lattice.dims);
        assert_eq!(region, Region { first: [0, 3, 1], dims: [6, 4, 5] });
        let copied = region.copied(&lattice);
        assert_eq!(copied.len(), region.count());
        for (i, texel) in copied.into_iter().enumerate() {
            let [x, y, z] = [i % 6, 3 + i / 6 % 4, 1 + i / 24];
            assert_eq!(texel, (z * 7 + y) * 9 + x);
        }
        assert_eq!(Region::whole(lattice.dims).copied(&lattice), samples);
    }
}
