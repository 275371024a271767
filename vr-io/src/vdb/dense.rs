//! A box of voxels around all that is active, filled.

use crate::error::{FileErrorKind, shown};

use super::tree::{LEAF, Tree};

/// Most voxels of a box: 2 GiB of floats. A tree of a few nodes may span more than any memory.
const MAX_VOXELS: i64 = 1 << 29;

/// Voxels from `low` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Box3 {
    pub low: [i32; 3],
    pub end: [i32; 3],
}

impl Box3 {
    /// The box around all active voxels of a tree, and one voxel of background on each side.
    pub fn around(tree: &Tree, name: &str) -> Result<Self, FileErrorKind> {
        let mut found = Self { low: [i32::MAX; 3], end: [i32::MIN; 3] };
        for tile in tree.tiles.iter().filter(|tile| tile.is_active) {
            found.add(tile.origin, tile.origin.map(|o| o + tile.edge));
        }
        for leaf in &tree.leaves {
            for i in leaf.active.on() {
                let at = [i >> 6, i >> 3 & 7, i & 7];
                let at = [0, 1, 2].map(|a| leaf.origin[a] + at[a] as i32);
                found.add(at, at.map(|n| n + 1));
            }
        }
        if found.low[0] > found.end[0] {
            let allowed = "must have active voxels: nothing can be seen of it";
            return Err(FileErrorKind::field("grid", shown(name), allowed));
        }
        let found = Self { low: found.low.map(|n| n - 1), end: found.end.map(|n| n + 1) };
        let sizes = [0, 1, 2].map(|a| i64::from(found.end[a]) - i64::from(found.low[a]));
        let count = sizes.iter().try_fold(1i64, |n, &size| n.checked_mul(size));
        if count.is_none_or(|count| count > MAX_VOXELS) {
            let [x, y, z] = sizes;
            let allowed = format!("must be at most {MAX_VOXELS} voxels when it is dense: crop or resample the grid");
            return Err(FileErrorKind::field("box of active voxels", format!("{x}×{y}×{z}"), allowed));
        }
        Ok(found)
    }

    fn add(&mut self, low: [i32; 3], end: [i32; 3]) {
        for a in 0..3 {
            self.low[a] = self.low[a].min(low[a]);
            self.end[a] = self.end[a].max(end[a]);
        }
    }

    pub fn dims(&self) -> [usize; 3] {
        [0, 1, 2].map(|a| (self.end[a] - self.low[a]) as usize)
    }

    /// The values in the box, x fastest.
    pub fn fill(&self, tree: &Tree) -> Result<Vec<f32>, FileErrorKind> {
        let [nx, ny, nz] = self.dims();
        let mut out = Vec::new();
        let count = nx * ny * nz;
        let too_many = |_| FileErrorKind::field("box of active voxels", count, "must fit memory");
        out.try_reserve_exact(count).map_err(too_many)?;
        out.resize(count, tree.background);
        for tile in &tree.tiles {
            let [xs, ys, zs] = self.part(tile.origin, tile.edge);
            for z in zs {
                for y in ys.clone() {
                    let row = (z * ny + y) * nx;
                    out[row + xs.start..row + xs.end].fill(tile.value);
                }
            }
        }
        for leaf in &tree.leaves {
            let [xs, ys, zs] = self.part(leaf.origin, LEAF);
            // Back to places in the leaf.
            let inside = |n: usize, a: usize| (n as i32 + self.low[a] - leaf.origin[a]) as usize;
            for z in zs {
                for y in ys.clone() {
                    for x in xs.clone() {
                        let at = inside(x, 0) << 6 | inside(y, 1) << 3 | inside(z, 2);
                        out[(z * ny + y) * nx + x] = leaf.values[at];
                    }
                }
            }
        }
        Ok(out)
    }

    /// Places in the box of a cube's voxels, as far as they are in it.
    fn part(&self, origin: [i32; 3], edge: i32) -> [std::ops::Range<usize>; 3] {
        [0, 1, 2].map(|a| {
            let clamped = |n: i32| (n.clamp(self.low[a], self.end[a]) - self.low[a]) as usize;
            clamped(origin[a])..clamped(origin[a] + edge)
        })
    }
}
