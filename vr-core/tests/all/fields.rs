//! Properties of reconstructed fields, for every filter, voxel type and precision.

use proptest::prelude::*;
use vr_core::filter::Reconstruction;
use vr_core::{AnyGrid, Calibration, Filter, Placement, Sampler, SamplerVisitor, UniformGrid, Volume, Voxel};

/// Value and gradient at some index-space points.
struct At<'a>(&'a [[f64; 3]]);

impl SamplerVisitor for At<'_> {
    type Output = Vec<(f64, [f64; 3], f32)>;
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Self::Output {
        let at = |p: &[f64; 3]| {
            let (value, gradient) = sampler.value_and_gradient(*p);
            assert!(value.is_nan() || value == sampler.value(*p), "one field, with or without gradient");
            (value, gradient, sampler.value(p.map(|x| x as f32)))
        };
        self.0.iter().map(at).collect()
    }
}

fn volume(dims: [usize; 3], samples: Vec<f32>) -> Volume {
    let placement = Placement::from_spacing([1.0, 2.0, 0.5]).unwrap();
    UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into()
}

fn sample(volume: &Volume, filter: Filter, points: &[[f64; 3]]) -> Vec<(f64, [f64; 3], f32)> {
    volume.with_filter(filter).grid().unwrap().with_sampler(At(points))
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
    fn gradients_are_the_fields_own((dims, samples) in grid(), unit in prop::array::uniform3(0.0f64..1.0)) {
        let v = volume(dims, samples);
        let p = point(dims, unit);
        const H: f64 = 1e-5;
        for filter in Filter::ALL.into_iter().filter(|f| f.is_continuous()) {
            let mut around = vec![p];
            for a in 0..3 {
                for sign in [-H, H] {
                    let mut q = p;
                    q[a] += sign;
                    around.push(q);
                }
            }
            let f = sample(&v, filter, &around);
            for a in 0..3 {
                let difference = (f[2 * a + 2].0 - f[2 * a + 1].0) / (2.0 * H);
                // Third derivatives of a few hundred per cube, times h²; and rounding of 100/h.
                prop_assert!((f[0].1[a] - difference).abs() < 1e-5, "{filter} {a}: {} {difference}", f[0].1[a]);
            }
        }
    }

    #[test]
    fn constants_stay_constant(c in -1e4f32..1e4, unit in prop::array::uniform3(0.0f64..1.0)) {
        let v = volume([3, 4, 5], vec![c; 60]);
        for filter in Filter::ALL {
            let f = sample(&v, filter, &[point([3, 4, 5], unit)]);
            prop_assert!((f[0].0 - f64::from(c)).abs() <= 4e-7 * f64::from(c.abs()), "{filter}: {}", f[0].0);
        }
    }

    #[test]
    fn f32_follows_f64((dims, samples) in grid(), unit in prop::array::uniform3(0.0f64..1.0)) {
        let v = volume(dims, samples);
        let p = point(dims, unit).map(|x| f64::from(x as f32));
        for filter in Filter::ALL {
            let (value, _, single) = sample(&v, filter, &[p])[0];
            // 64 products of up to 100, gain 2: far below 64 roundings of 200 each.
            prop_assert!((value - f64::from(single)).abs() < 64.0 * 200.0 * 6e-8, "{filter}: {value} {single}");
        }
    }
}

#[test]
fn filters_reproduce_what_they_should() {
    let dims = [6, 6, 6];
    let at = |f: fn(f64, f64, f64) -> f64| -> Vec<f32> {
        (0..216).map(|i| f((i % 6) as f64, (i / 6 % 6) as f64, (i / 36) as f64) as f32).collect()
    };
    // Away from the faces, where the missing samples are made up.
    let p = [2.3, 2.8, 3.4];
    let product = volume(dims, at(|x, y, z| x * y * z));
    for filter in [Filter::Trilinear, Filter::CatmullRom] {
        let f = sample(&product, filter, &[p])[0];
        assert!((f.0 - p[0] * p[1] * p[2]).abs() < 1e-12, "{filter}");
        assert!((f.1[0] - p[1] * p[2]).abs() < 1e-12, "{filter}");
    }
    let square = volume(dims, at(|x, y, _| x * x + y * x));
    let f = sample(&square, Filter::CatmullRom, &[p])[0];
    assert!((f.0 - (p[0] * p[0] + p[1] * p[0])).abs() < 1e-12);
    let f = sample(&square, Filter::Nearest, &[[2.5, 1.49, 0.0]])[0];
    assert_eq!(f.0, 9.0 + 3.0, "at the middle the higher index holds");
}

#[test]
fn a_cell_with_a_missing_corner_is_vacuum_and_closed() {
    let mut samples = vec![1.0; 4 * 2 * 2];
    samples[0] = f32::INFINITY;
    let v = volume([4, 2, 2], samples);
    assert_eq!(v.grid().unwrap().value_stats().infinite, 1);
    for filter in Filter::ALL {
        let f = sample(&v, filter, &[[0.5, 0.5, 0.5], [1.0, 0.5, 0.5], [1.0 + 1e-9, 0.5, 0.5], [3.0, 1.0, 1.0]]);
        assert!(f[0].0.is_nan() && f[1].0.is_nan(), "{filter}");
        assert!((f[2].0 - 1.0).abs() < 1e-6 && (f[3].0 - 1.0).abs() < 1e-6, "{filter}: {f:?}");
    }
}

#[test]
fn integer_and_float_samples_give_the_same_field() {
    let bytes: Vec<u8> = (0..60).map(|i| (i * 37 % 200) as u8).collect();
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let floats: Vec<f32> = bytes.iter().map(|&b| b.into()).collect();
    let v8: Volume =
        AnyGrid::from(UniformGrid::new([3, 4, 5], bytes, placement, Calibration::default()).unwrap()).into();
    let v32: Volume = UniformGrid::new([3, 4, 5], floats, placement, Calibration::default()).unwrap().into();
    for filter in Filter::ALL {
        let p = [[1.25, 2.5, 3.75]];
        assert_eq!(sample(&v8, filter, &p), sample(&v32, filter, &p), "{filter}");
    }
}
