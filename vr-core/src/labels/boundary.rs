//! Normals of the boundary of labelled regions.

use glam::DVec3;

use super::label_map::LabelMap;

/// Gradient of a smoothed region in one cell of the labels' lattice.
///
/// A region is 1 at its own voxels and 0 at all others. At each voxel its gradient is taken by the operator of Sobel in three dimensions: central
/// differences across, smoothed by (1, 2, 1)/4 along the other two axes; between voxels it is interpolated trilinearly. It points to the
/// inside, and is 0 where all of the 4³ voxels around belong to the region.
pub(super) struct BoundaryCell {
    /// Gradient per index step at the eight corners, x fastest.
    corners: [DVec3; 8],
    /// Index of the lowest corner.
    low: DVec3,
}

/// Surroundings of a lattice beyond its outermost voxels, on the low and the high side of each axis: true if background can be seen there, false
/// if the labels end where the volume does, so that the region goes on.
pub(super) type OpenSides = [[bool; 2]; 3];

const SMOOTH: [f64; 3] = [0.25, 0.5, 0.25];
const ACROSS: [f64; 3] = [-0.5, 0.0, 0.5];

impl BoundaryCell {
    /// The cell around a position in index space, of the region of all ranks for which `inside` is true.
    pub(super) fn around(map: &LabelMap, position: DVec3, open: &OpenSides, inside: impl Fn(u16) -> bool) -> Self {
        let low = position.floor();
        // Indices of the four voxels on each axis; `None` beyond a side where there is background.
        let taps: [[Option<usize>; 4]; 3] = std::array::from_fn(|a| {
            let n = map.dims()[a] as i64;
            std::array::from_fn(|k| {
                let i = low[a] as i64 - 1 + k as i64;
                let beyond = i < 0 && open[a][0] || i >= n && open[a][1];
                (!beyond).then(|| i.clamp(0, n - 1) as usize)
            })
        });
        let background = inside(map.background());
        let mut region = [false; 64];
        let mut count = 0;
        for (i, of) in region.iter_mut().enumerate() {
            let [x, y, z] = [taps[0][i % 4], taps[1][i / 4 % 4], taps[2][i / 16]];
            *of = match (x, y, z) {
                (Some(x), Some(y), Some(z)) => inside(map.rank([x, y, z])),
                _ => background,
            };
            count += usize::from(*of);
        }
        let mut corners = [DVec3::ZERO; 8];
        if count == 0 || count == 64 {
            return Self { corners, low };
        }
        for (corner, sum) in corners.iter_mut().enumerate() {
            let first = [corner & 1, corner >> 1 & 1, corner >> 2];
            for tap in 0..27 {
                let [i, j, k] = [tap % 3, tap / 3 % 3, tap / 9];
                if region[first[0] + i + 4 * (first[1] + j) + 16 * (first[2] + k)] {
                    let [si, sj, sk] = [SMOOTH[i], SMOOTH[j], SMOOTH[k]];
                    *sum += DVec3::new(ACROSS[i] * sj * sk, si * ACROSS[j] * sk, si * sj * ACROSS[k]);
                }
            }
        }
        Self { corners, low }
    }

    /// Gradient per index step at a position in the cell.
    pub(super) fn gradient(&self, position: DVec3) -> DVec3 {
        let t = position - self.low;
        let lerp = |a: DVec3, b: DVec3, t: f64| a + (b - a) * t;
        let row = |i: usize| lerp(self.corners[i], self.corners[i + 1], t.x);
        let plane = |i: usize| lerp(row(i), row(i + 2), t.y);
        lerp(plane(0), plane(4), t.z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{AnyGrid, Calibration, Placement, UniformGrid};

    fn ball(radius: f64) -> LabelMap {
        let voxel = |i: usize| {
            let p = [i % 24, i / 24 % 24, i / 576].map(|k| k as f64 - 11.5);
            u8::from(DVec3::from(p).length() <= radius)
        };
        let voxels: Vec<u8> = (0..24 * 24 * 24).map(voxel).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        LabelMap::new(&AnyGrid::from(UniformGrid::new([24; 3], voxels, placement, Calibration::default()).unwrap()))
            .unwrap()
    }

    #[test]
    fn normals_of_a_ball_point_to_its_middle() {
        let (map, open) = (ball(9.0), [[true; 2]; 3]);
        let mut worst = 0.0f64;
        for k in 0..500 {
            let (z, turn) = (2.0 * (f64::from(k) + 0.5) / 500.0 - 1.0, 2.399_963 * f64::from(k));
            let (sin, cos) = turn.sin_cos();
            let outward = DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            let at = DVec3::splat(11.5) + outward * 9.0;
            let gradient = BoundaryCell::around(&map, at, &open, |rank| rank == 1).gradient(at);
            worst = worst.max(gradient.normalize().angle_between(-outward));
        }
        // Measured: 0.15; a normal of bare central differences is off by 0.35.
        assert!(worst < 0.2, "{worst}");
    }

    #[test]
    fn the_inside_and_the_end_of_the_volume_have_none() {
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([3; 3], vec![1u8; 27], placement, Calibration::default()).unwrap();
        let map = LabelMap::new(&AnyGrid::from(grid)).unwrap();
        let at = DVec3::new(0.2, 1.0, 1.7);
        let gradient = |open: &OpenSides| BoundaryCell::around(&map, at, open, |rank| rank == 1).gradient(at);
        assert_eq!(gradient(&[[false; 2]; 3]), DVec3::ZERO);
        let open = gradient(&[[true, false], [false; 2], [false; 2]]);
        assert!(open.x > 0.3 && open.y == 0.0 && open.z == 0.0, "{open}");
    }
}
