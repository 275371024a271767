//! Random volumes.

use glam::{DMat3, DVec3};
use proptest::collection::vec;
use proptest::prelude::*;
use vr_core::{AnyGrid, Calibration, Placement, UniformGrid, Volume, VoxelType};

/// Largest number of voxels along an axis of a random grid.
const MAX_VOXELS: usize = 6;

/// Any small volume: all five voxel types, 2 to 6 voxels an axis, sheared, flipped and anisotropic placements, calibrations of
/// either sign, constant data, and (for floats) missing voxels.
pub fn grid() -> impl Strategy<Value = Volume> {
    of_data(prop_oneof![2 => constant(), 2 => ramp(), 4 => noise(), 2 => with_holes()])
}

/// Any small volume of [`grid`] without missing voxels.
pub fn tame_grid() -> impl Strategy<Value = Volume> {
    of_data(prop_oneof![1 => constant(), 2 => ramp(), 4 => noise()])
}

/// Any small volume of some data.
fn of_data(data: impl Strategy<Value = Data>) -> impl Strategy<Value = Volume> {
    (voxel_type(), dims(2), data, placement(any_spacing()), calibration())
        .prop_map(|(kind, dims, data, placement, calibration)| build(kind, dims, &data, placement, calibration))
}

/// Floats in [0, 1] that change little from cell to cell: a ramp with a gentle parabola on it, on 4 to 6 voxels an axis, under
/// any placement that is not very anisotropic.
pub fn smooth_grid() -> impl Strategy<Value = Volume> {
    (dims(4), smooth(), placement(0.7..1.4))
        .prop_map(|(dims, data, placement)| build(VoxelType::F32, dims, &data, placement, Calibration::default()))
}

pub(super) fn voxel_type() -> impl Strategy<Value = VoxelType> {
    prop_oneof![
        Just(VoxelType::F32),
        Just(VoxelType::U8),
        Just(VoxelType::I8),
        Just(VoxelType::U16),
        Just(VoxelType::I16)
    ]
}

pub(super) fn dims(min: usize) -> impl Strategy<Value = [usize; 3]> {
    [min..=MAX_VOXELS, min..=MAX_VOXELS, min..=MAX_VOXELS]
}

/// Values of the voxels as fractions of the range of their type, a function of the index. Independent of the dims, so that
/// these can shrink by themselves and leave the values as they were.
#[derive(Clone, Debug)]
pub(super) enum Data {
    Constant(f64),
    /// Value at the middle, slopes per axis, and the curvature along all of them.
    Smooth {
        slopes: [f64; 3],
        curvature: f64,
    },
    Noise(Vec<f64>),
    /// Noise with NaN and infinities.
    Holes(Vec<f64>, Vec<u8>),
    /// Half a wave or so along each axis, from one phase on: bent everywhere, of moderate slope.
    Wave {
        turns: [f64; 3],
        phase: f64,
    },
    /// Other data, NaN in some regions, as scanners write outside of the part that they see.
    Masked(Box<Data>, Vec<Region>),
    /// Other data, the same value throughout each of some regions.
    Flat(Box<Data>, Vec<(Region, f64)>),
    /// Numbers of parts, as fractions of [`LABELS`]: the last region that holds a voxel names it.
    Labels(Vec<(Region, u8)>),
}

/// The highest label.
pub(super) const LABELS: u8 = 4;

/// A box or an ellipsoid, in fractions of the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Region {
    middle: [f64; 3],
    half: [f64; 3],
    round: bool,
}

impl Region {
    fn holds(&self, p: [usize; 3], dims: [usize; 3]) -> bool {
        let off: [f64; 3] =
            std::array::from_fn(|a| (p[a] as f64 / (dims[a] - 1) as f64 - self.middle[a]).abs() / self.half[a]);
        if self.round { off.iter().map(|x| x * x).sum::<f64>() <= 1.0 } else { off.iter().all(|&x| x <= 1.0) }
    }
}

fn region() -> impl Strategy<Value = Region> {
    let half = || 0.12..0.5;
    ([0.0..1.0, 0.0..1.0, 0.0..1.0], [half(), half(), half()], any::<bool>()).prop_map(|(middle, half, round)| Region {
        middle,
        half,
        round,
    })
}

/// Data that change from voxel to voxel: a ramp, a wave, noise.
pub(super) fn varied() -> impl Strategy<Value = Data> {
    prop_oneof![1 => ramp(), 3 => wave(), 2 => noise()]
}

fn wave() -> impl Strategy<Value = Data> {
    ([-0.5..0.5, -0.5..0.5, 0.1..0.5], 0.0..1.0).prop_map(|(turns, phase)| Data::Wave { turns, phase })
}

/// Voxels that are missing in one or two blocks or spheres.
pub(super) fn masked() -> impl Strategy<Value = Data> {
    let inside = prop_oneof![2 => varied(), 1 => constant()];
    (inside, vec(region(), 1..=2)).prop_map(|(data, regions)| Data::Masked(Box::new(data), regions))
}

/// Constant throughout, or in one to three regions.
pub(super) fn flat() -> impl Strategy<Value = Data> {
    let regions = vec((region(), prop_oneof![Just(0.0), Just(1.0), 0.0..1.0]), 1..=3);
    prop_oneof![
        1 => constant(),
        3 => (varied(), regions).prop_map(|(data, regions)| Data::Flat(Box::new(data), regions)),
    ]
}

pub(super) fn labels() -> impl Strategy<Value = Data> {
    vec((region(), 1..=LABELS), 1..=4).prop_map(Data::Labels)
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

pub(super) fn noise() -> impl Strategy<Value = Data> {
    vec(0.0..=1.0, MAX_VOXELS * MAX_VOXELS * MAX_VOXELS).prop_map(Data::Noise)
}

pub(super) fn with_holes() -> impl Strategy<Value = Data> {
    let n = MAX_VOXELS * MAX_VOXELS * MAX_VOXELS;
    // One in eight is missing: 5 NaN, 6 +∞, 7 −∞.
    let hole = prop_oneof![21 => Just(0u8), 1 => Just(5u8), 1 => Just(6u8), 1 => Just(7u8)];
    (vec(0.0..=1.0, n), vec(hole, n)).prop_map(|(values, holes)| Data::Holes(values, holes))
}

impl Data {
    /// True if some voxels may be NaN or infinite.
    pub fn has_missing(&self) -> bool {
        matches!(self, Self::Holes(..) | Self::Masked(..))
    }

    fn at(&self, p: [usize; 3], dims: [usize; 3]) -> f64 {
        // Larger grids repeat what is random.
        let i = (p[2] % MAX_VOXELS * MAX_VOXELS + p[1] % MAX_VOXELS) * MAX_VOXELS + p[0] % MAX_VOXELS;
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
            Self::Wave { turns, phase } => {
                let turn: f64 = (0..3).map(|a| turns[a] * p[a] as f64 / (dims[a] - 1) as f64).sum();
                0.5 + 0.5 * libm::sin(std::f64::consts::TAU * (turn + phase))
            }
            Self::Masked(data, regions) if !regions.iter().any(|r| r.holds(p, dims)) => data.at(p, dims),
            Self::Masked(..) => f64::NAN,
            Self::Flat(data, regions) => {
                let last = regions.iter().rev().find(|(r, _)| r.holds(p, dims));
                last.map_or_else(|| data.at(p, dims), |&(_, value)| value)
            }
            Self::Labels(regions) => {
                let last = regions.iter().rev().find(|(r, _)| r.holds(p, dims));
                f64::from(last.map_or(0, |&(_, label)| label)) / f64::from(LABELS)
            }
        }
    }
}

/// Spacings along an axis relative to each other: usually near 1, at most 1:50.
pub(super) fn any_spacing() -> impl Strategy<Value = f64> + Clone {
    // Boxed, for unions cannot be cloned otherwise.
    prop_oneof![4 => Just(1.0).boxed(), 3 => (0.5..2.0).boxed(), 1 => Just(25.0).boxed()]
}

/// The affine placement: any scale, a rotation, perhaps a shear, flips.
pub(super) fn placement(spacing: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = Placement> {
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
    build_in((0.0, 1.0), kind, dims, data, placement, calibration)
}

/// Builds a grid like [`build`], with floats between two given numbers in place of 0 and 1.
pub(super) fn build_in(
    (min, max): (f64, f64),
    kind: VoxelType,
    dims: [usize; 3],
    data: &Data,
    placement: Placement,
    calibration: Calibration,
) -> Volume {
    // Integers have no missing samples: their cast takes NaN to 0 and infinities to the ends of the range.
    let scaled = |low: f64, high: f64| samples(dims, |p| (low + data.at(p, dims) * (high - low)).round());
    let float = || samples(dims, |p| min + data.at(p, dims) * (max - min));
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
