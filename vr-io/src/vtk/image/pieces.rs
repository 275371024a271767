//! An image put together from pieces.

use crate::error::FieldError;

use super::lattice::Extent;

/// Puts the bytes of pieces, x running fastest in each, at their places in the whole. Where pieces share points, the last one has the word.
///
/// # Errors
/// Pieces that leave a part of the whole empty, or reach beyond it.
pub(in crate::vtk) fn assemble(
    whole: &Extent,
    of_cells: bool,
    voxel_bytes: usize,
    pieces: &[(Extent, Vec<u8>)],
) -> Result<Vec<u8>, FieldError> {
    let wrong = |found: &str| FieldError::new("Piece, Extent", found, "pieces must fill a box of points");
    // Nothing is allocated beyond what the pieces really hold.
    let there: usize = pieces.iter().map(|(_, bytes)| bytes.len()).sum();
    let dims = whole.dims(of_cells);
    let claimed = dims.iter().try_fold(voxel_bytes, |n, &d| n.checked_mul(d)).filter(|&claimed| claimed <= there);
    let mut out = vec![0; claimed.ok_or_else(|| wrong("pieces that leave a gap"))?];
    let mut filled = vec![false; out.len() / voxel_bytes];
    for (extent, bytes) in pieces {
        let [nx, ny, nz] = extent.dims(of_cells);
        let (first, zero) = (extent.first(), whole.first());
        let at = [0, 1, 2].map(|i| usize::try_from(first[i] - zero[i]).unwrap_or(usize::MAX));
        let within = |i: usize, n: usize| at[i].checked_add(n).is_some_and(|end| end <= dims[i]);
        if !(within(0, nx) && within(1, ny) && within(2, nz)) {
            return Err(wrong("a piece beyond the others"));
        }
        let mut rows = bytes.chunks_exact(nx * voxel_bytes);
        for (z, y) in (0..nz).flat_map(|z| (0..ny).map(move |y| (z, y))) {
            let voxel = at[0] + dims[0] * (at[1] + y + dims[1] * (at[2] + z));
            let row = rows.next().ok_or_else(|| wrong("a piece with too few numbers"))?;
            out[voxel * voxel_bytes..][..row.len()].copy_from_slice(row);
            filled[voxel..voxel + nx].fill(true);
        }
    }
    if filled.contains(&false) { Err(wrong("pieces that leave a gap")) } else { Ok(out) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(numbers: [i64; 6]) -> Extent {
        Extent::new("Extent", numbers).unwrap().unwrap()
    }

    #[test]
    fn shared_points_are_there_once() {
        let whole = extent([1, 3, 0, 1, 0, 0]);
        let left = (extent([1, 2, 0, 1, 0, 0]), vec![1, 10, 2, 20, 4, 40, 5, 50]);
        let right = (extent([2, 3, 0, 1, 0, 0]), vec![2, 20, 3, 30, 5, 50, 6, 60]);
        let both = [left.clone(), right.clone()];
        assert_eq!(assemble(&whole, false, 2, &both).unwrap(), [1, 10, 2, 20, 3, 30, 4, 40, 5, 50, 6, 60]);
        let cells = [(left.0, vec![7]), (right.0, vec![8])];
        assert_eq!(assemble(&whole, true, 1, &cells).unwrap(), [7, 8]);
        assert!(assemble(&whole, false, 2, &[left.clone(), left.clone()]).unwrap_err().found.contains("gap"));
        assert!(assemble(&left.0, false, 2, &both).unwrap_err().found.contains("beyond"));
        assert!(assemble(&extent([0, 1 << 40, 0, 1 << 40, 0, 0]), false, 2, &both).is_err());
    }
}
