//! Depths between four neighbours, which are not averaged across edges.

/// Widths between neighbours by which the depths of one sheet may differ: a surface that is steeper takes its nearest neighbour's depth.
const STEEPEST: f64 = 4.0;

/// Largest difference of depths of one sheet, given the voxels from neighbour to neighbour.
pub(crate) fn tolerance(spacing: f64) -> f32 {
    (STEEPEST * spacing) as f32
}

/// Weights of four neighbours, left to right and row by row, under linear interpolation.
#[inline(always)]
pub(crate) fn linear_weights([x, y]: [f32; 2]) -> [f32; 4] {
    let (left, above) = (1.0 - x, 1.0 - y);
    [left * above, x * above, left * y, x * y]
}

/// Mean of the depths that lie on the sheet of the neighbour with the largest weight: those within the tolerance. `None` where no neighbour with
/// a weight has a finite depth.
#[inline(always)]
pub(crate) fn mean_of_sheet(depths: [f32; 4], weights: [f32; 4], tolerance: f32) -> Option<f32> {
    let (mut nearest, mut largest) = (f32::INFINITY, 0.0);
    for i in 0..4 {
        if depths[i].is_finite() && weights[i] > largest {
            (nearest, largest) = (depths[i], weights[i]);
        }
    }
    if largest == 0.0 {
        return None;
    }
    // Differences from the nearest one, so that neighbours at one depth give that depth.
    let (mut sum, mut all) = (0.0, 0.0);
    for i in 0..4 {
        let off = depths[i] - nearest;
        if off.abs() <= tolerance {
            (sum, all) = (sum + weights[i] * off, all + weights[i]);
        }
    }
    Some(nearest + sum / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_is_reproduced_and_an_edge_is_kept() {
        for at in [[0.0, 0.0], [0.25, 0.5], [0.9, 0.1], [1.0, 1.0]] {
            let weights = linear_weights(at);
            let plane = |x: f32, y: f32| 7.0 + 2.0 * x - 0.5 * y;
            let slope = [plane(0.0, 0.0), plane(1.0, 0.0), plane(0.0, 1.0), plane(1.0, 1.0)];
            let mean = mean_of_sheet(slope, weights, 4.0).unwrap();
            assert!((mean - plane(at[0], at[1])).abs() < 1e-6, "{at:?}: {mean}");
            // On the left a near sheet, on the right a far one.
            let edge = mean_of_sheet([3.0, 90.0, 3.0, 90.0], weights, 4.0).unwrap();
            assert_eq!(edge, if at[0] <= 0.5 { 3.0 } else { 90.0 });
        }
        let weights = linear_weights([0.75, 0.0]);
        assert_eq!(mean_of_sheet([3.0, f32::INFINITY, 3.0, f32::INFINITY], weights, 4.0), Some(3.0));
        assert_eq!(mean_of_sheet([f32::INFINITY, f32::INFINITY, 3.0, 3.0], weights, 4.0), None);
    }
}
