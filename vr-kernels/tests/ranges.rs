//! Properties of the ranges of blocks.

use proptest::prelude::*;
use vr_core::filter::Reconstruction;
use vr_core::{Calibration, Filter, Placement, Sampler, SamplerVisitor, UniformGrid, Volume, Voxel};
use vr_kernels::ranges::RangeBlocks;

/// The field at some index-space points, in both precisions.
struct At<'a>(&'a [[f64; 3]]);

impl SamplerVisitor for At<'_> {
    type Output = Vec<[f64; 2]>;
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Self::Output {
        let at = |p: &[f64; 3]| [sampler.value(*p), f64::from(sampler.value(p.map(|x| x as f32)))];
        self.0.iter().map(at).collect()
    }
}

fn volume(dims: [usize; 3], samples: Vec<f32>) -> Volume {
    let placement = Placement::from_spacing([1.0, 2.0, 0.5]).unwrap();
    UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into()
}

fn grid() -> impl Strategy<Value = ([usize; 3], Vec<f32>)> {
    prop::array::uniform3(2usize..7)
        .prop_flat_map(|dims| (Just(dims), prop::collection::vec(-100.0f32..100.0, dims.iter().product::<usize>())))
}

/// A point strictly inside a cell, so that a difference of the field stays in one piece.
fn point(dims: [usize; 3], unit: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| {
        let x = unit[a] * (dims[a] - 1) as f64;
        let cell = x.floor().min((dims[a] - 2) as f64);
        cell + (x - cell).clamp(0.01, 0.99)
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::with_cases(200)
    })]

    #[test]
    fn range_blocks_enclose_the_field((dims, mut samples) in grid(), units in prop::collection::vec(prop::array::uniform3(0.0f64..1.0), 20), hole in any::<prop::sample::Index>(), holed in any::<bool>(), edge in 1usize..4) {
        if holed {
            let i = hole.index(samples.len());
            samples[i] = f32::NAN;
        }
        let points: Vec<[f64; 3]> = units.iter().map(|&unit| point(dims, unit)).collect();
        for filter in Filter::ALL {
            let v = volume(dims, samples.clone()).with_filter(filter);
            let u = v.grid().unwrap();
            let blocks = RangeBlocks::of_volume(u, edge);
            for (p, values) in points.iter().zip(u.with_sampler(At(&points))) {
                let range = blocks.at(p.map(|x| x as usize / edge));
                if values[0].is_nan() {
                    prop_assert!(range.vacuum);
                    continue;
                }
                for x in values {
                    prop_assert!(f64::from(range.low) <= x && x <= f64::from(range.high), "{filter}: {x} in {range:?}");
                }
            }
            prop_assert!(std::sync::Arc::ptr_eq(&blocks, &RangeBlocks::of_volume(u, edge)), "made once");
        }
    }
}

/// A block's range under the linear filter is that of its voxels, but for a few roundings; and exactly that where they are all the same.
#[test]
fn range_blocks_are_no_wider_than_they_must_be() {
    let dims = [11, 6, 7];
    let samples: Vec<f32> = (0..462).map(|i| if i % 11 < 5 { -1024.0 } else { (i * 7 % 101) as f32 }).collect();
    let v = volume(dims, samples.clone());
    let blocks = RangeBlocks::of_volume(v.grid().unwrap(), 4);
    assert_eq!(blocks.blocks(), [3, 2, 2]);
    for z in 0..2 {
        for y in 0..2 {
            for x in 0..3 {
                let span = |b: usize, n: usize| 4 * b..=(4 * b + 4).min(n - 1);
                let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
                for k in span(z, 7) {
                    for j in span(y, 6) {
                        for i in span(x, 11) {
                            let sample = samples[(k * 6 + j) * 11 + i];
                            (low, high) = (low.min(sample), high.max(sample));
                        }
                    }
                }
                let range = blocks.at([x, y, z]);
                let slack = if low == high { 0.0 } else { 2e-3 };
                assert!((low - range.low).abs() <= slack && (range.high - high).abs() <= slack, "{range:?}");
            }
        }
    }
    assert_eq!((blocks.at([0; 3]).low, blocks.at([0; 3]).high), (-1024.0, -1024.0));
}
