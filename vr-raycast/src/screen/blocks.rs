//! The order of rays that runs fastest.

/// Points along the edge of a block. Rays of a packet stay close to each other.
const BLOCK: u32 = 4;

/// The points of a rectangle, `high` excluded, in blocks of 4×4.
pub(super) fn in_blocks(low: [u32; 2], high: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
    let of = move |a: usize| (low[a]..high[a]).step_by(BLOCK as usize);
    let in_block = move |from: u32, a: usize| from..(from + BLOCK).min(high[a]);
    of(1)
        .flat_map(move |y| of(0).map(move |x| [x, y]))
        .flat_map(move |[x, y]| in_block(y, 1).flat_map(move |y| in_block(x, 0).map(move |x| [x, y])))
}
