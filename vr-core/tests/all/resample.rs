//! Resampling: every kind of volume against its own field, linear functions, integrals and their order.

use glam::{DMat3, DVec3};
use vr_core::cells::{CellMesh, CellValues};
use vr_core::field::FunctionField;
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::resample::{
    Correction, Integral, ResampleError, ResampleFilter, Resampled, Resampling, Resolution, resample,
};
use vr_core::{Calibration, Control, Filter, GridVolume, Placement, PointKernel, PointSet, UniformGrid, Volume};

/// n³ cubes of six cells each over the unit cube, inner vertices moved, as far as `keep` holds for a cell's middle.
fn mesh(n: usize, jitter: f64, value: impl Fn(DVec3) -> f64, keep: impl Fn(DVec3) -> bool) -> CellMesh {
    let placement = Placement::from_spacing([1.0 / n as f64; 3]).unwrap();
    let grid = UniformGrid::new([n + 1; 3], vec![0u8; (n + 1).pow(3)], placement, Calibration::default()).unwrap();
    let plain = CellMesh::of_grid(&GridVolume::new(grid.into(), Filter::Trilinear)).unwrap();
    let mut state = 7u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 40) as f64 / (1u64 << 24) as f64 - 0.5) * 2.0 * jitter / n as f64
    };
    let moved: Vec<DVec3> = plain
        .vertices()
        .iter()
        .map(|&v| {
            let is_inner = v.min_element() > 0.0 && v.max_element() < 1.0 - 1e-9;
            let by = DVec3::new(random(), random(), random());
            if is_inner { v + by } else { v }
        })
        .collect();
    let middle = |cell: &&[u32; 4]| cell.iter().map(|&v| 0.25 * moved[v as usize]).sum::<DVec3>();
    let cells = plain.cells().iter().filter(|cell| keep(middle(cell))).copied().collect();
    let values = moved.iter().map(|&v| value(v)).collect();
    CellMesh::new(moved, cells, CellValues::Vertices(values)).unwrap()
}

fn waves(p: DVec3) -> f64 {
    1.5 + 0.3 * (7.0 * p.x + 3.0 * p.y).sin() + 0.2 * (9.0 * p.z - 4.0 * p.y).cos()
}

fn run(volume: &Volume, resolution: Resolution, filter: ResampleFilter) -> Resampled {
    resample(volume, &Resampling { resolution, filter, ..Resampling::default() }, &Control::default()).unwrap()
}

/// Calls `each` with every voxel's place and value.
fn each_voxel(grid: &UniformGrid<f32>, mut each: impl FnMut(DVec3, f64)) {
    let [nx, ny, _] = grid.dims();
    for (i, &value) in grid.samples().iter().enumerate() {
        let index = [i % nx, i / nx % ny, i / nx / ny].map(|i| i as f64);
        each(grid.placement().to_world(index.into()), f64::from(value));
    }
}

#[test]
fn voxels_are_the_field_at_their_places() {
    let ball = |p: DVec3| p.distance(DVec3::splat(0.5)) < 0.45;
    let uneven = [vec![0.0, 0.1, 0.5, 1.0], vec![0.0, 0.8, 1.0], vec![0.0, 0.3, 1.0]];
    let values: Vec<f32> = (0..36).map(|i| if i == 20 { f32::NAN } else { (i * 37 % 31) as f32 }).collect();
    let points = vec![DVec3::splat(0.3), DVec3::new(0.8, 0.4, 0.5)];
    let function = FunctionField::new((DVec3::NEG_ONE, DVec3::ONE), |p| p.length()).unwrap();
    let volumes: [Volume; 5] = [
        mesh(5, 0.25, waves, ball).into(),
        mesh(3, 0.2, waves, |_| true).into(),
        RectilinearGrid::new(uneven, values, Centering::Points).unwrap().into(),
        PointSet::new(points, vec![0.3, 0.4], vec![1.0, 2.0], vec![3.0, 4.0], PointKernel::CubicSpline).unwrap().into(),
        function.into(),
    ];
    for volume in volumes {
        let field = volume.field().unwrap();
        let resampled = run(&volume, Resolution::Dims([14, 11, 17]), ResampleFilter::Point);
        let mut vacuum = 0;
        let (low, high) = volume.bounds();
        each_voxel(&resampled.grid, |at, value| {
            let expected = field.value(at.clamp(low, high)).unwrap_or(f64::NAN);
            vacuum += usize::from(value.is_nan());
            assert_eq!(value.is_nan(), expected.is_nan(), "{}: {at}", field.kind());
            assert!(value.is_nan() || (value - expected).abs() < 1e-6 * expected.abs().max(1.0), "{}", field.kind());
        });
        assert_eq!(vacuum, resampled.vacuum);
    }
}

/// Values of cells jump: the raster takes the same cell as the field does, but on the faces themselves.
#[test]
fn values_of_cells_are_those_of_the_cell_around() {
    let plain = mesh(4, 0.2, |_| 0.0, |_| true);
    let values = (0..plain.cells().len()).map(|i| (i * 7919 % 101) as f64).collect();
    let volume: Volume =
        CellMesh::new(plain.vertices().to_vec(), plain.cells().to_vec(), CellValues::Cells(values)).unwrap().into();
    let resampled = run(&volume, Resolution::Dims([12, 13, 11]), ResampleFilter::Point);
    let mut differ = 0;
    let (low, high) = volume.bounds();
    each_voxel(&resampled.grid, |at, value| {
        differ += usize::from(volume.field().unwrap().value(at.clamp(low, high)) != Some(value));
    });
    // On the box's own faces and edges, two cells are as deep but for rounding.
    assert!(differ <= 12, "{differ}");
}

#[test]
fn linear_functions_pass_every_filter() {
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = move |p: DVec3| 0.2 + slope.dot(p);
    let ball = |p: DVec3| p.distance(DVec3::splat(0.5)) < 0.45;
    let volume: Volume = mesh(8, 0.2, value, ball).into();
    for filter in ResampleFilter::ALL {
        let resampled = run(&volume, Resolution::Dims([21; 3]), filter);
        let mut seen = 0;
        each_voxel(&resampled.grid, |at, found| {
            // Boxes that reach beyond the ball have a mean over less.
            if at.distance(DVec3::splat(0.5)) < 0.3 {
                seen += 1;
                assert!((found - value(at)).abs() < 2e-7, "{filter}: {found} at {at}");
            }
        });
        assert!(seen > 800);
    }
}

/// Over a box that the mesh fills, the integral converges with the square of the spacing; with a curved boundary, a voxel's share of it remains, and the box filter
/// leaves far less of that.
#[test]
fn integrals_converge_as_documented() {
    let cube: Volume = mesh(12, 0.2, waves, |_| true).into();
    let exact = Integral::of(&cube).unwrap();
    assert!((exact.volume - 1.0).abs() < 1e-12 && exact.is_exact);
    let errors: Vec<f64> =
        [9, 17, 33].map(|n| run(&cube, Resolution::Dims([n; 3]), ResampleFilter::Point).integral_error()).to_vec();
    assert!(errors[0] < 1e-2 && errors[0] / errors[1] > 2.5 && errors[1] / errors[2] > 2.5, "{errors:?}");

    let ball: Volume = mesh(16, 0.0, |_| 2.0, |p| p.distance(DVec3::splat(0.5)) < 0.45).into();
    let [point, mean] = ResampleFilter::ALL.map(|filter| run(&ball, Resolution::Dims([30; 3]), filter));
    assert!(point.after.volume < point.before.volume);
    assert!(mean.integral_error() < 0.25 * point.integral_error(), "{mean:?} {point:?}");
    assert!(mean.integral_error() < 0.05);
}

#[test]
fn integrals_are_conserved_if_asked_for() {
    let ball = |p: DVec3| p.distance(DVec3::splat(0.5)) < 0.45;
    let options =
        |filter| Resampling { resolution: Resolution::Dims([20; 3]), filter, conserve: true, ..Resampling::default() };
    for filter in ResampleFilter::ALL {
        let made = |volume: Volume| resample(&volume, &options(filter), &Control::default()).unwrap();
        let positive = made(mesh(9, 0.2, waves, ball).into());
        let Some(Correction::Factor(factor)) = positive.correction else { panic!("{:?}", positive.correction) };
        assert!(factor > 0.9 && factor < 2.0, "{factor}");
        assert!(positive.integral_error() < 1e-6, "{}", positive.integral_error());
        // Values of both signs are shifted: a factor would be any number.
        let both = made(mesh(9, 0.2, |p| p.x - 0.45, ball).into());
        assert!(matches!(both.correction, Some(Correction::Shift(s)) if s.abs() < 0.1));
        assert!((both.after.value - both.before.value).abs() < 1e-7);
    }
}

#[test]
fn exact_integrals_of_other_kinds() {
    // ∫ x over a box of 2 × 1 × 3, uneven.
    let axes = [vec![0.0, 0.5, 2.0], vec![0.0, 1.0], vec![0.0, 1.0, 3.0]];
    let values: Vec<f32> = (0..18).map(|i| axes[0][i % 3] as f32).collect();
    let grid: Volume = RectilinearGrid::new(axes.clone(), values.clone(), Centering::Points).unwrap().into();
    let integral = Integral::of(&grid).unwrap();
    assert!((integral.value - 6.0).abs() < 1e-6 && (integral.volume - 6.0).abs() < 1e-12);
    let mut holes = values;
    holes[0] = f32::NAN;
    let integral = Integral::of(&RectilinearGrid::new(axes, holes, Centering::Points).unwrap().into()).unwrap();
    assert!((integral.volume - 5.5).abs() < 1e-12, "the first cell of 0.5 × 1 × 1 is vacuum");
    // Points: weight times value, whatever the radius; the grid finds it, too.
    let points = PointSet::new(vec![DVec3::ZERO], vec![2.0], vec![3.0], vec![5.0], PointKernel::CubicSpline).unwrap();
    let resampled = run(&points.into(), Resolution::Dims([41; 3]), ResampleFilter::Box);
    assert!((resampled.before.value - 15.0).abs() < 1e-12 && resampled.before.is_exact);
    assert!(resampled.integral_error() < 0.01, "{}", resampled.integral_error());
    // A function's is an estimate.
    let function = FunctionField::new((DVec3::ZERO, DVec3::ONE), |p| p.x * p.y).unwrap();
    let resampled = run(&function.into(), Resolution::Dims([9; 3]), ResampleFilter::Point);
    assert!(!resampled.before.is_exact && (resampled.before.value - 0.25).abs() < 1e-9);
    assert!(resampled.integral_error() < 1e-6);
}

/// A turned grid keeps its own box; a factor of two by the box filter is a mean over neighbours.
#[test]
fn uniform_grids_are_resampled_in_their_own_box() {
    let turn = DMat3::from_rotation_z(0.4) * DMat3::from_diagonal(DVec3::new(0.5, 1.0, 2.0));
    let placement = Placement::new(DVec3::new(5.0, -3.0, 1.0), turn).unwrap();
    let voxels: Vec<i16> = (0..9 * 5 * 7).map(|i| (i * 7919 % 997) as i16).collect();
    let calibration = Calibration { slope: 0.5, intercept: -7.0 };
    let grid = UniformGrid::new([9, 5, 7], voxels, placement, calibration).unwrap();
    let volume = Volume::from(grid.clone());
    let same = run(&volume, Resolution::Finest, ResampleFilter::Point);
    assert_eq!(same.grid.dims(), [9, 5, 7]);
    assert!(same.grid.samples().iter().zip(grid.samples()).all(|(&a, &b)| a == (0.5 * f64::from(b) - 7.0) as f32));
    assert!(same.integral_error() < 1e-7);
    let coarse = run(&volume, Resolution::Spacing(2.0), ResampleFilter::Box);
    assert_eq!(coarse.grid.dims(), [3, 3, 7], "2 in the world are 4 steps along x");
    let corner =
        |grid: &UniformGrid<f32>| grid.placement().to_world(DVec3::from_array(grid.dims().map(|n| (n - 1) as f64)));
    assert!(corner(&coarse.grid).distance(corner(&same.grid)) < 1e-12);
}

#[test]
fn resolutions_are_fitted_capped_and_refused() {
    let volume: Volume = mesh(6, 0.1, waves, |_| true).into();
    let finest = run(&volume, Resolution::Finest, ResampleFilter::Point);
    let [n, ..] = finest.grid.dims();
    assert!((7..=11).contains(&n) && finest.wanted.is_none(), "{n}: sixths, moved a little");
    let capped = Resampling { max_finest: 100, ..Resampling::default() };
    let capped = resample(&volume, &capped, &Control::default()).unwrap();
    assert_eq!(capped.grid.dims(), [4; 3]);
    assert_eq!(capped.wanted, Some([n; 3]));
    let fail = |resolution| {
        let options = Resampling { resolution, ..Resampling::default() };
        resample(&volume, &options, &Control::default()).unwrap_err()
    };
    assert!(matches!(fail(Resolution::Spacing(f64::NAN)), ResampleError::Spacing { .. }));
    assert!(matches!(fail(Resolution::Spacing(0.0)), ResampleError::Spacing { .. }));
    assert!(matches!(fail(Resolution::Spacing(1e-300)), ResampleError::TooLarge { .. }));
    assert!(matches!(fail(Resolution::Dims([usize::MAX; 3])), ResampleError::TooLarge { .. }));
    assert!(matches!(fail(Resolution::Dims([1, 2, 2])), ResampleError::Grid(_)));
    assert!(matches!(fail(Resolution::Dims([20_000, 20_000, 2])), ResampleError::TooLarge { .. }));
    // Four corners of the box, in none of which the mesh is.
    let thin = mesh(8, 0.0, waves, |p| p.distance(DVec3::splat(0.5)) < 0.3);
    let options = Resampling { resolution: Resolution::Dims([2; 3]), ..Resampling::default() };
    assert_eq!(
        resample(&thin.into(), &options, &Control::default()).unwrap_err(),
        ResampleError::Empty { dims: [2; 3] }
    );
    let control = Control::default();
    control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    assert_eq!(resample(&volume, &Resampling::default(), &control).unwrap_err(), ResampleError::Cancelled);
}
