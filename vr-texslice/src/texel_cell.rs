//! Cell of texels in which a texture is read, in f64.

use vr_core::{Filter, GridVolume};

/// Returns the cell that a texture of a volume is read in at a place in index space, and the fractions in it: 0 or 1 where the nearest texel is taken. `None` beside a
/// missing texel, where cells meet on either side.
pub(crate) fn texel_cell(volume: &GridVolume, at: [f64; 3]) -> Option<([usize; 3], [f64; 3])> {
    if volume.vacuum_cells().is_some_and(|vacuum| vacuum.contains(at)) {
        return None;
    }
    let dims = volume.dims();
    let cell: [usize; 3] = std::array::from_fn(|a| (at[a] as usize).min(dims[a] - 2));
    let at = if volume.filter() == Filter::Nearest { at.map(|x| (x + 0.5).floor()) } else { at };
    Some((cell, std::array::from_fn(|a| at[a] - cell[a] as f64)))
}
