//! Chessboard distances: as a king moves.

use vr_core::cancel::SparsePoll;

/// Computes distances in place, x fastest: 0 stays 0, and all other blocks get the chessboard distance max(|Δx|, |Δy|, |Δz|) to the nearest block that is 0; 255
/// where that is farther than 254, or where none is.
///
/// Two sweeps over rows, each from the rows before it (Borgefors 1986, "Distance transformations in digital images"): exact for this distance.
/// Along a row, distances spread by leaps of 1, 2, 4, … blocks, since a step from block to block waits for the last one.
pub(crate) fn chessboard_distances([nx, ny, nz]: [usize; 3], distance: &mut [u8]) {
    let (mut near, mut old) = (vec![u8::MAX; nx + 2], vec![u8::MAX; nx]);
    for backwards in [false, true] {
        let mut poll = SparsePoll::default();
        for row in 0..ny * nz {
            poll.turn();
            let row = if backwards { ny * nz - 1 - row } else { row };
            let (y, z) = (row % ny, row / ny);
            near.fill(u8::MAX);
            // The rows that the sweep has been at: three of the slice before, one of this one.
            let done = |y: usize, z: usize| (z * ny + y) * nx;
            let slice = if backwards { (z + 1 < nz).then_some(z + 1) } else { z.checked_sub(1) };
            let beside = if backwards { (y + 1 < ny).then_some(y + 1) } else { y.checked_sub(1) };
            let of_slice = (y.saturating_sub(1)..=(y + 1).min(ny - 1)).filter_map(|y| slice.map(|z| done(y, z)));
            for first in of_slice.chain(beside.map(|y| done(y, z))) {
                least(&mut near[1..=nx], &distance[first..first + nx], 0);
            }
            let here = &mut distance[done(y, z)..][..nx];
            for beside in 0..3 {
                least(here, &near[beside..][..nx], 1);
            }
            for leap in (0..8).map(|power| 1 << power).take_while(|&leap| leap < nx) {
                old.copy_from_slice(here);
                let (to, from) = if backwards { (0..nx - leap, leap..nx) } else { (leap..nx, 0..nx - leap) };
                least(&mut here[to], &old[from], leap as u8);
            }
        }
    }
}

/// Replaces each byte by the other one plus an amount, where that is less.
fn least(to: &mut [u8], from: &[u8], more: u8) {
    for (to, &from) in to.iter_mut().zip(from) {
        *to = from.saturating_add(more).min(*to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_to_the_nearest_block() {
        for (blocks, seeds) in [
            ([20, 18, 23], vec![[3, 2, 1], [15, 14, 20], [0, 17, 9]]),
            ([1, 1, 7], vec![[0, 0, 5]]),
            ([300, 2, 1], vec![[290, 1, 0]]),
            ([5, 4, 3], vec![]),
        ] {
            let [nx, ny, nz] = blocks;
            let at = |i: usize| [i % nx, i / nx % ny, i / (nx * ny)];
            let mut distance: Vec<u8> =
                (0..nx * ny * nz).map(|i| if seeds.contains(&at(i)) { 0 } else { u8::MAX }).collect();
            chessboard_distances(blocks, &mut distance);
            for (i, &found) in distance.iter().enumerate() {
                let to = |seed: &[usize; 3]| (0..3).map(|a| seed[a].abs_diff(at(i)[a])).max().unwrap();
                let want = seeds.iter().map(to).min().unwrap_or(usize::MAX).min(255);
                assert_eq!(usize::from(found), want, "{:?} of {blocks:?}", at(i));
            }
        }
    }
}
