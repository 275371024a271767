//! Random volumes.

use glam::{DMat3, DVec3};
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{AnyGrid, Calibration, Placement, UniformGrid, Volume, VoxelType};

/// Most samples along an axis of a random grid.
const MOST: usize = 6;

/// Any small volume: all five sample types, 2 to 6 samples an axis, sheared, flipped and anisotropic placements, calibrations of
/// either sign, constant data, and (for floats) missing samples.
pub fn grid() -> impl Strategy<Value = Volume> {
    let data = prop_oneof![2 => constant(), 2 => ramp(), 4 => noise(), 2 => with_holes()];
    (voxel_type(), dims(2), data, placement(any_spacing()), calibration())
        .prop_map(|(kind, dims, data, placement, calibration)| build(kind, dims, &data, placement, calibration))
}

/// As [`grid`], with no missing samples.
pub fn tame_grid() -> impl Strategy<Value = Volume> {
    let data = prop_oneof![1 => constant(), 2 => ramp(), 4 => noise()];
    (voxel_type(), dims(2), data, placement(any_spacing()), calibration())
        .prop_map(|(kind, dims, data, placement, calibration)| build(kind, dims, &data, placement, calibration))
}

/// Floats in [0, 1] that change little from cell to cell: a ramp with a gentle parabola on it, on 4 to 6 samples an axis, under
/// any placement that is not very anisotropic.
pub fn smooth_grid() -> impl Strategy<Value = Volume> {
    (dims(4), smooth(), placement(0.7..1.4))
        .prop_map(|(dims, data, placement)| build(VoxelType::F32, dims, &data, placement, Calibration::default()))
}

fn voxel_type() -> impl Strategy<Value = VoxelType> {
    prop_oneof![
        Just(VoxelType::F32),
        Just(VoxelType::U8),
        Just(VoxelType::I8),
        Just(VoxelType::U16),
        Just(VoxelType::I16)
    ]
}

fn dims(least: usize) -> impl Strategy<Value = [usize; 3]> {
    [least..=MOST, least..=MOST, least..=MOST]
}

/// Where in the range of the sample type the samples lie, 0 to 1, as a function of the index. Independent of the dims, so that
/// these can shrink by themselves and leave the samples where they were.
#[derive(Clone, Debug)]
enum Data {
    Constant(f64),
    /// Value at the middle, slopes per axis, and the curvature along all of them.
    Smooth {
        slopes: [f64; 3],
        curvature: f64,
    },
    Noise(Vec<f64>),
    /// Noise with NaN and infinities.
    Holes(Vec<f64>, Vec<u8>),
}

fn constant() -> impl Strategy<Value = Data> {
    prop_oneof![Just(0.0), Just(1.0), 0.0..1.0].prop_map(Data::Constant)
}

fn ramp() -> impl Strategy<Value = Data> {
    [-0.33..0.33, -0.33..0.33, -0.33..0.33].prop_map(|slopes| Data::Smooth { slopes, curvature: 0.0 })
}

/// The slope along x is never small: a constant field would have no error to fall.
fn smooth() -> impl Strategy<Value = Data> {
    ([0.12..0.28, -0.28..0.28, -0.28..0.28], -0.15..0.15)
        .prop_map(|(slopes, curvature)| Data::Smooth { slopes, curvature })
}

fn noise() -> impl Strategy<Value = Data> {
    vec(0.0..=1.0, MOST * MOST * MOST).prop_map(Data::Noise)
}

fn with_holes() -> impl Strategy<Value = Data> {
    let n = MOST * MOST * MOST;
    // One in eight is missing: 5 NaN, 6 +∞, 7 −∞.
    let hole = prop_oneof![21 => Just(0u8), 1 => Just(5u8), 1 => Just(6u8), 1 => Just(7u8)];
    (vec(0.0..=1.0, n), vec(hole, n)).prop_map(|(values, holes)| Data::Holes(values, holes))
}

impl Data {
    fn at(&self, p: [usize; 3], dims: [usize; 3]) -> f64 {
        let i = (p[2] * MOST + p[1]) * MOST + p[0];
        match self {
            Self::Constant(v) => *v,
            Self::Smooth { slopes, curvature } => {
                let u: [f64; 3] = std::array::from_fn(|a| 2.0 * p[a] as f64 / (dims[a] - 1) as f64 - 1.0);
                let linear: f64 = (0..3).map(|a| 0.5 * slopes[a] * u[a]).sum();
                let bent: f64 = u.iter().map(|x| 1.0 - x * x).sum::<f64>() / 3.0;
                (0.5 + linear + 0.5 * curvature * bent).clamp(0.0, 1.0)
            }
            Self::Noise(values) => values[i],
            Self::Holes(values, holes) => match holes[i] {
                5 => f64::NAN,
                6 => f64::INFINITY,
                7 => f64::NEG_INFINITY,
                _ => values[i],
            },
        }
    }
}

/// Spacings along an axis relative to each other: usually near 1, at most 1:50.
fn any_spacing() -> impl Strategy<Value = f64> + Clone {
    // Boxed, for unions cannot be cloned otherwise.
    prop_oneof![4 => Just(1.0).boxed(), 3 => (0.5..2.0).boxed(), 1 => Just(25.0).boxed()]
}

/// The affine placement: any scale, a rotation, perhaps a shear, flips.
fn placement(spacing: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Placement> {
    let scale = prop_oneof![4 => Just(1.0), 1 => Just(0.01), 1 => Just(100.0)];
    let spacing = (scale, [spacing.clone(), spacing.clone(), spacing])
        .prop_map(|(scale, spacing): (f64, [f64; 3])| spacing.map(|s| s * scale));
    let axis_flip = || prop_oneof![3 => Just(1.0), 1 => Just(-1.0)];
    let turn = prop_oneof![2 => Just(0.0), 1 => -3.0..3.0];
    let shear = || prop_oneof![2 => Just(0.0), 1 => -0.6..0.6];
    let origin = prop_oneof![2 => Just([0.0; 3]), 1 => [-100.0..100.0, -100.0..100.0, -100.0..100.0]];
    (spacing, [axis_flip(), axis_flip(), axis_flip()], turn, [shear(), shear(), shear()], origin).prop_map(
        |(spacing, flip, turn, shear, origin): ([f64; 3], [f64; 3], f64, [f64; 3], [f64; 3])| {
            let axis = DVec3::new(0.6, 0.0, 0.8);
            let rotation = if turn == 0.0 { DMat3::IDENTITY } else { DMat3::from_axis_angle(axis, turn) };
            let sheared =
                DMat3::from_cols(DVec3::X, DVec3::new(shear[0], 1.0, 0.0), DVec3::new(shear[1], shear[2], 1.0));
            let scale = DVec3::from(spacing) * DVec3::from(flip);
            Placement::new(origin.into(), rotation * sheared * DMat3::from_diagonal(scale))
                .expect("shears below 1 are not singular")
        },
    )
}

fn calibration() -> impl Strategy<Value = Calibration> {
    let calibration = |slope, intercept| Calibration { slope, intercept };
    prop_oneof![
        2 => Just(Calibration::default()),
        1 => Just(calibration(0.5, -1024.0)),
        1 => Just(calibration(-2.0, 10.0)),
        1 => (0.001..1000.0, -1000.0..1000.0).prop_map(move |(s, i)| calibration(s, i)),
    ]
}

fn build(kind: VoxelType, dims: [usize; 3], data: &Data, placement: Placement, calibration: Calibration) -> Volume {
    // Integers have no missing samples: their cast takes NaN to 0 and infinities to the ends of the range.
    let scaled = |low: f64, high: f64| samples(dims, |p| (low + data.at(p, dims) * (high - low)).round());
    let float = || samples(dims, |p| data.at(p, dims));
    fn cast<T: vr_core::Voxel>(
        dims: [usize; 3],
        numbers: Vec<f64>,
        convert: fn(f64) -> T,
        placement: Placement,
        calibration: Calibration,
    ) -> UniformGrid<T> {
        let samples: Vec<T> = numbers.into_iter().map(convert).collect();
        UniformGrid::new(dims, samples, placement, calibration).expect("strategies make valid grids")
    }
    let grid: AnyGrid = match kind {
        VoxelType::U8 => cast(dims, scaled(0.0, 255.0), |x| x as u8, placement, calibration).into(),
        VoxelType::I8 => cast(dims, scaled(-128.0, 127.0), |x| x as i8, placement, calibration).into(),
        VoxelType::U16 => cast(dims, scaled(0.0, 65535.0), |x| x as u16, placement, calibration).into(),
        VoxelType::I16 => cast(dims, scaled(-32768.0, 32767.0), |x| x as i16, placement, calibration).into(),
        VoxelType::F32 => cast(dims, float(), |x| x as f32, placement, calibration).into(),
    };
    grid.into()
}

fn samples(dims: [usize; 3], f: impl Fn([usize; 3]) -> f64) -> Vec<f64> {
    let mut samples = Vec::with_capacity(dims.iter().product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            samples.extend((0..dims[0]).map(|x| f([x, y, z])));
        }
    }
    samples
}
