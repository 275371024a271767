//! Levels of a pyramid: how many there are, and where the voxels of each lie.

use std::path::Path;

use crate::edit::{Reduction, halved_dims, halving};
use crate::error::WriteError;

use super::refused;

/// Voxels along the longest axis up to which a volume is halved, where the number of levels is not asked for: a level that is there at once.
const SMALL: usize = 64;

/// Options of a pyramid, for a format that holds several resolutions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    /// Number of levels, the volume itself among them; if absent, as many as lead to 64 voxels along the longest axis.
    pub count: Option<usize>,
    /// Way in which the voxels of a block become one.
    pub reduction: Reduction,
}

/// A level: its size, and how many voxels of the volume one of its voxels spans along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Level {
    pub dims: [usize; 3],
    pub spans: [usize; 3],
}

impl Levels {
    /// Returns the levels of a volume, the finest first.
    ///
    /// # Errors
    /// A number that leaves nothing to halve.
    pub(super) fn of(&self, dims: [usize; 3], path: &Path) -> Result<Vec<Level>, WriteError> {
        let mut levels = vec![Level { dims, spans: [1; 3] }];
        let mut last = levels[0];
        while last.dims.iter().any(|&n| n > 2) {
            let factors = halving(last.dims);
            last = Level { dims: halved_dims(last.dims), spans: [0, 1, 2].map(|a| last.spans[a] * factors[a]) };
            levels.push(last);
        }
        let usual = 1 + levels.iter().take_while(|level| level.dims.iter().any(|&n| n > SMALL)).count();
        let count = self.count.unwrap_or(usual);
        if count == 0 || count > levels.len() {
            let [x, y, z] = dims;
            let allowed = levels.len();
            return Err(refused(path, format!("levels: found {count}; must be 1 to {allowed} for {x}×{y}×{z} voxels")));
        }
        levels.truncate(count);
        Ok(levels)
    }
}

impl Level {
    /// Returns the distance of voxels along an axis, and the place of the first one, from those of the volume. A voxel lies in the middle of those that
    /// it spans.
    pub fn placed(&self, axis: usize, spacing: f64, origin: f64) -> (f64, f64) {
        let span = self.spans[axis] as f64;
        (spacing * span, origin + 0.5 * (span - 1.0) * spacing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_end_where_the_volume_is_small() {
        let of = |dims: [usize; 3], count: Option<usize>| {
            let levels = Levels { count, ..Levels::default() }.of(dims, Path::new("x.zarr"));
            levels.map(|levels| levels.into_iter().map(|level| level.dims).collect::<Vec<_>>())
        };
        assert_eq!(of([64, 64, 64], None).unwrap(), [[64, 64, 64]]);
        assert_eq!(of([65, 20, 2], None).unwrap(), [[65, 20, 2], [33, 10, 2]]);
        assert_eq!(of([512, 512, 100], None).unwrap().last(), Some(&[64, 64, 13]));
        assert_eq!(of([9, 4, 2], Some(3)).unwrap(), [[9, 4, 2], [5, 2, 2], [3, 2, 2]]);
        for wrong in [0, 5, usize::MAX] {
            let message = of([9, 4, 2], Some(wrong)).unwrap_err().to_string();
            assert!(message.contains(&format!("found {wrong}; must be 1 to 4")), "{message}");
        }
    }

    #[test]
    fn voxels_lie_in_the_middle_of_what_they_span() {
        let level = Level { dims: [2, 2, 2], spans: [4, 1, 2] };
        assert_eq!(level.placed(0, 0.5, 10.0), (2.0, 10.75));
        assert_eq!(level.placed(1, 0.5, 10.0), (0.5, 10.0));
        assert_eq!(level.placed(2, 3.0, -1.0), (6.0, 0.5));
    }
}
