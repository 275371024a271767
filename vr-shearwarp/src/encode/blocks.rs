//! Runs of whole blocks, that point into the array of all voxels. No voxel is looked at: so a new transfer function is
//! cheapest (Lacroute & Levoy 1994, fast classification).

use vr_core::RenderError;
use vr_core::parallel::{collect, each_part};
use vr_kernels::bits::{WORD, count_runs, ones};

use super::dense::Layout;
use super::pyramid::{EDGE, VisibleBlocks};
use super::runs::{Run, Runs, edges, running_sums, split_by_rows, too_large};

/// The runs of the cells in blocks that may be visible. Where voxels begin is said of the dense array of `layout`.
///
/// `None` where samples are missing: whole blocks would not leave out the vacuum.
///
/// # Errors
/// [`RenderError::TooLarge`] for more voxels or runs than u32 counts.
pub(crate) fn block_runs<const N: usize>(
    layout: Layout,
    blocks: &VisibleBlocks,
) -> Result<Option<Runs<N>>, RenderError> {
    if blocks.missing() {
        return Ok(None);
    }
    let voxels = layout.size.iter().product::<usize>();
    if voxels > u32::MAX as usize {
        return Err(too_large("voxels of a volume of runs", voxels));
    }
    let (rows, layers) = (layout.cell_rows(), layout.cell_layers::<N>());
    let words = (layout.size[0] - 1).div_ceil(WORD);
    // The cells of the rows of one row of blocks are all alike.
    let rows_of_blocks = rows.div_ceil(EDGE);
    let mut masks = vec![0u64; words * rows_of_blocks * layers];
    each_part(masks.chunks_mut(words * rows_of_blocks), |k, masks| {
        let mut all = vec![0; words];
        for (row, may) in masks.chunks_exact_mut(words).enumerate() {
            blocks.mark::<N>(&layout, k, row, [may, &mut all]);
        }
    });
    let mask = |k: usize, v: usize| {
        let at = (k * rows_of_blocks + v / EDGE) * words;
        &masks[at..at + words]
    };
    let counts: Vec<u32> = collect(rows * layers, |row| count_runs(mask(row / rows, row % rows)) as u32);
    let starts = running_sums("runs of a volume of runs", counts.into_iter())?;
    let mut runs = vec![Run { start: 0, len: 0, at: [0; N] }; starts[rows * layers] as usize];
    each_part(split_by_rows(&mut runs, &starts, rows), |k, runs| {
        let mut runs = runs.iter_mut();
        for v in 0..rows {
            for ((start, len), run) in ones(mask(k, v)).zip(&mut runs) {
                let at = edges::<N>().map(|[dv, dk]| layout.offset([start, v + dv, k + dk]) as u32);
                *run = Run { start: start as u32, len: len as u32, at };
            }
        }
    });
    Ok(Some(Runs::new(layout, starts, runs)))
}
