//! Order of the points of a rectangle in which rays run fastest.

/// Number of points along the edge of a block, which keeps the rays of a packet close to each other.
const BLOCK: u32 = 4;

/// Calls `each` for the points of a rectangle, `high` excluded, in blocks of 4×4. (As an iterator, this took a tenth of a frame.)
pub(super) fn in_blocks(low: [u32; 2], high: [u32; 2], mut each: impl FnMut([u32; 2])) {
    for block_y in (low[1]..high[1]).step_by(BLOCK as usize) {
        for block_x in (low[0]..high[0]).step_by(BLOCK as usize) {
            for y in block_y..(block_y + BLOCK).min(high[1]) {
                for x in block_x..(block_x + BLOCK).min(high[0]) {
                    each([x, y]);
                }
            }
        }
    }
}
