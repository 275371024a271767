//! Runs of cells, row by row.

use vr_core::RenderError;

use super::dense::Layout;

/// A run of neighbouring cells of one row of cells that may be visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Run<const N: usize> {
    /// The first cell.
    pub start: u32,
    /// Number of cells.
    pub len: u32,
    /// First voxels of the cells' `N` edges along u: rows v and v + 1 of layer k; for `N = 4`, then those of layer k + 1. Each
    /// edge has `len + 1` voxels, one after another.
    pub at: [u32; N],
}

/// All runs of a volume seen along one axis: with `N = 2` edges of cells in layers, with `N = 4` of cells between layers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Runs<const N: usize> {
    layout: Layout,
    /// Begin of each row's runs, and the end of the last.
    starts: Vec<u32>,
    runs: Vec<Run<N>>,
}

/// The `N` edges of a cell: which of the two rows, which of the two layers.
pub(crate) fn edges<const N: usize>() -> [[usize; 2]; N] {
    std::array::from_fn(|e| [e % 2, e / 2])
}

/// Error for more than u32 counts.
pub(crate) fn too_large(what: &'static str, count: usize) -> RenderError {
    RenderError::TooLarge { what, bytes: count as u64, limit: u32::MAX.into() }
}

/// Running sums of `counts`, a zero first.
pub(crate) fn running_sums(
    what: &'static str,
    counts: impl ExactSizeIterator<Item = u32>,
) -> Result<Vec<u32>, RenderError> {
    let mut starts = Vec::with_capacity(counts.len() + 1);
    let mut sum = 0usize;
    starts.push(0);
    for count in counts {
        sum += count as usize;
        starts.push(sum as u32);
    }
    if sum > u32::MAX as usize { Err(too_large(what, sum)) } else { Ok(starts) }
}

/// The parts of `all` that belong to each group of `rows` rows, where row i begins at `starts[i]`.
pub(crate) fn split_by_rows<'a, T>(mut all: &'a mut [T], starts: &[u32], rows: usize) -> Vec<&'a mut [T]> {
    let mut parts = Vec::with_capacity(starts.len() / rows);
    for first in (0..starts.len() - 1).step_by(rows) {
        let (part, rest) = all.split_at_mut((starts[first + rows] - starts[first]) as usize);
        parts.push(part);
        all = rest;
    }
    parts
}

impl<const N: usize> Runs<N> {
    pub(super) fn new(layout: Layout, starts: Vec<u32>, runs: Vec<Run<N>>) -> Self {
        debug_assert_eq!(starts.len(), layout.cell_rows() * layout.cell_layers::<N>() + 1);
        Self { layout, starts, runs }
    }

    /// The runs of a row of cells, by where they begin.
    #[inline]
    pub fn row(&self, layer: usize, row: usize) -> &[Run<N>] {
        let i = layer * self.rows() + row;
        &self.runs[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    /// True if a layer has no run.
    #[inline]
    pub fn layer_is_empty(&self, layer: usize) -> bool {
        self.starts[layer * self.rows()] == self.starts[(layer + 1) * self.rows()]
    }

    /// True if there is no run at all.
    #[cfg(test)]
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Rows of cells of a layer.
    #[inline]
    pub fn rows(&self) -> usize {
        self.layout.cell_rows()
    }

    /// Layers, or slabs between them.
    #[cfg(test)]
    #[inline]
    pub fn layers(&self) -> usize {
        self.layout.cell_layers::<N>()
    }

    /// The axes and sizes of the volume as it is seen.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Number of cells that they cover.
    #[cfg(test)]
    pub fn cells(&self) -> usize {
        self.runs.iter().map(|run| run.len as usize).sum()
    }

    /// Memory that they take.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.runs[..])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_u32_counts_is_refused() {
        assert_eq!(running_sums("", [3, 0, 5].into_iter()).unwrap(), [0, 3, 3, 8]);
        assert!(running_sums("", [u32::MAX].into_iter()).is_ok());
        let refused = running_sums("", [u32::MAX, 1, 1].into_iter());
        assert!(matches!(refused, Err(RenderError::TooLarge { bytes: 0x1_0000_0001, .. })));
    }
}
