//! Walk from voxel to voxel: a three-dimensional Bresenham line.

use vr_core::IndexRay;

use crate::walk::ListedWalk;

/// Returns the discrete line from one voxel to another, both included: as many voxels as the longest axis asks for, on each other axis the nearest
/// ones to the straight line. Consecutive ones share at least a corner (26-connected).
///
/// Bresenham 1965, *Algorithm for computer control of a digital plotter*; in three dimensions Kaufman and Shimony 1986, *3D scan-conversion
/// algorithms for voxel-based graphics*. In integers throughout.
pub(crate) fn discrete_line(from: [i64; 3], to: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let delta: [i64; 3] = std::array::from_fn(|a| to[a] - from[a]);
    let count = delta.iter().map(|d| d.abs()).max().unwrap_or(0);
    (0..=count).map(move |i| {
        // Rounded to the nearest; a point line has no slope.
        std::array::from_fn(|a| from[a] + (2 * i * delta[a] + count).div_euclid((2 * count).max(1)))
    })
}

/// Returns the walk along a line of voxels: each contributes its own sample, wherever the ray passes it by.
///
/// The line goes from the voxel nearest to where the ray enters to that nearest to where it leaves, and each voxel stands for the same
/// length of the ray, those at the ends for half of it. So a constant volume is drawn exactly, and anything else as a field that is
/// constant around each sample: the error is of the first order in the size of a voxel, and no step makes it smaller.
pub(crate) fn voxel_walk(ray: &IndexRay, dims: [usize; 3], first: u32, backwards: bool) -> ListedWalk {
    let nearest = |s: f64| {
        let p = ray.at(s).to_array();
        std::array::from_fn(|a| (p[a] + 0.5).floor().clamp(0.0, (dims[a] - 1) as f64) as i64)
    };
    let places: Vec<[f64; 3]> =
        discrete_line(nearest(ray.start), nearest(ray.end)).map(|v| v.map(|x| x as f64)).collect();
    let between = places.len() - 1;
    let steps = if between == 0 {
        vec![(ray.start, ray.length())]
    } else {
        let length = ray.length() / between as f64;
        // Middles between voxels, and the ends of the chord.
        let border = |k: usize| match k {
            0 => ray.start,
            k if k > between => ray.end,
            k => ray.start + (k as f64 - 0.5) * length,
        };
        (0..=between).map(|k| (border(k), border(k + 1) - border(k))).collect()
    };
    ListedWalk::new(steps, Some(places), first, backwards)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn plane_line_of_the_paper_and_points() {
        let line: Vec<[i64; 3]> = discrete_line([0, 0, 0], [4, 2, 0]).collect();
        assert_eq!(line, [[0, 0, 0], [1, 1, 0], [2, 1, 0], [3, 2, 0], [4, 2, 0]]);
        assert_eq!(discrete_line([3; 3], [3; 3]).collect::<Vec<_>>(), [[3; 3]]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn connected_and_near_the_line(from in prop::array::uniform3(-40i64..40), to in prop::array::uniform3(-40i64..40)) {
            let line: Vec<[i64; 3]> = discrete_line(from, to).collect();
            prop_assert_eq!((line[0], line[line.len() - 1]), (from, to));
            for pair in line.windows(2) {
                let step = (0..3).map(|a| (pair[1][a] - pair[0][a]).abs()).max();
                prop_assert_eq!(step, Some(1), "26-connected, and never twice the same");
            }
            let n = (line.len() - 1).max(1) as f64;
            for (i, voxel) in line.iter().enumerate() {
                for a in 0..3 {
                    let exact = from[a] as f64 + i as f64 / n * (to[a] - from[a]) as f64;
                    prop_assert!((voxel[a] as f64 - exact).abs() <= 0.5 + 1e-9);
                }
            }
        }
    }
}
