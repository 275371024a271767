//! Memory is asked for before structures are derived from a volume, and what does not fit is refused with what it would need.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use vr_core::amr::{AmrBlock, AmrCentring};
use vr_core::cancel::Stopped;
use vr_core::labels::{LabelError, LabelMap};
use vr_core::rectilinear::{Centering, RectilinearError};
use vr_core::{
    AmrGrid, AnyGrid, Calibration, Control, Filter, Placement, PointKernel, PointSet, RectilinearGrid, UniformGrid,
    Volume, memory,
};

/// Bytes that the meter says are left.
static LEFT: AtomicU64 = AtomicU64::new(u64::MAX);

fn grid(dims: [usize; 3], missing: bool) -> AnyGrid {
    let mut values = vec![1.0f32; dims.iter().product()];
    if missing {
        values[0] = f32::NAN;
    }
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    UniformGrid::new(dims, values, placement, Calibration::default()).unwrap().into()
}

/// Prepares a volume with so many bytes left, and gives the refusal.
fn refusal(volume: &Volume, left: u64) -> Option<String> {
    LEFT.store(left, Ordering::Relaxed);
    let outcome = Control::default().cancellable(|| volume.prepare_derived());
    LEFT.store(u64::MAX, Ordering::Relaxed);
    outcome.err().map(|stopped| match stopped {
        Stopped::Memory(refused) => refused.to_string(),
        Stopped::Cancelled(_) => panic!("it was not cancelled"),
    })
}

// One test, since the meter is the process's.
#[test]
fn what_does_not_fit_is_refused_before_it_is_made() {
    assert!(memory::set_meter(|| LEFT.load(Ordering::Relaxed)));
    let dims = [128, 128, 64];
    let count = 1 << 20;
    let with = |filter, missing| Volume::from(grid(dims, missing)).with_filter(filter);
    // Twice four bytes a voxel; then, of a grid with a missing voxel, another twelve bytes and a bit.
    let spline = with(Filter::BSpline, false);
    let told = "the coefficients of the B-spline would need 8.4 MB, and 8.4 MB of memory are left";
    assert_eq!(refusal(&spline, 8 * count - 1).as_deref(), Some(told));
    let missing = with(Filter::Trilinear, true);
    let refused = refusal(&missing, 12 * count).unwrap();
    assert!(refused.starts_with("the voxels with missing ones filled in would need 13 MB"), "{refused}");
    let positions: Vec<DVec3> = (0..100_000).map(|i| DVec3::new(f64::from(i), 0.0, 0.0)).collect();
    let ones = vec![1.0f32; positions.len()];
    let points = PointSet::new(positions, ones.clone(), ones.clone(), ones, PointKernel::Gaussian).unwrap();
    let points = Volume::from(points);
    let refused = refusal(&points, 2 * count).unwrap();
    assert!(refused.starts_with("the tree of boxes would need "), "{refused}");
    // Eight bricks of 12 bytes for each block of 64 cells, in two lists for a moment.
    let first = |i: i64| [64 * (i % 32), i / 32 % 32, i / 1024];
    let block = |i: i64| AmrBlock { level: 0, first: first(i), dims: [64, 1, 1], values: vec![0.5; 64] };
    let blocks = (0..1 << 15).map(block).collect();
    let mesh = AmrGrid::new(DVec3::ZERO, DVec3::ONE, Vec::new(), blocks, AmrCentring::Cells).unwrap();
    let refused = refusal(&Volume::from(mesh), 3 * count).unwrap();
    assert!(refused.starts_with("the bricks of the adaptive mesh would need 6.3 MB"), "{refused}");
    // A brick of 12 bytes for each row of eight cells.
    let axes = [vec![0.0, 1.0], vec![0.0, 1.0], (0..=800_000).map(|i| f64::from(i).powf(1.1)).collect()];
    let made = || RectilinearGrid::new(axes.clone(), vec![0.5; 4 * 800_001], Centering::Points);
    // Four bytes a place, asked for when the grid is made.
    LEFT.store(3 * count, Ordering::Relaxed);
    let refused = made().unwrap_err();
    LEFT.store(u64::MAX, Ordering::Relaxed);
    assert!(matches!(refused, RectilinearError::Memory(_)), "{refused}");
    assert!(
        refused.to_string().starts_with("the buckets of an axis of the rectilinear grid would need 3.2 MB"),
        "{refused}"
    );
    let uneven = made().unwrap();
    // Made when a ray first asks for them.
    LEFT.store(count, Ordering::Relaxed);
    let outcome = Control::default().cancellable(|| uneven.bricks().len());
    LEFT.store(u64::MAX, Ordering::Relaxed);
    let refused = outcome.unwrap_err().to_string();
    assert!(refused.starts_with("the bricks of the rectilinear grid would need 1.2 MB"), "{refused}");
    // Cuts of the axis: 60 bytes a cell at most, twice while lists grow.
    LEFT.store(10 * count, Ordering::Relaxed);
    let outcome = Control::default().cancellable(|| uneven.bricks().len());
    LEFT.store(u64::MAX, Ordering::Relaxed);
    let refused = outcome.unwrap_err().to_string();
    assert!(refused.starts_with("the cuts of an axis of the rectilinear grid would need "), "{refused}");
    assert_eq!(uneven.bricks().len(), 100_000);
    // A refusal leaves nothing behind: with the memory there, all are made.
    for volume in [&spline, &missing, &points] {
        assert_eq!(refusal(volume, 100 * count), None);
    }
    // The ranks of labels are two bytes a voxel, and they are all that is made of these.
    LEFT.store(2 * count - 1, Ordering::Relaxed);
    let refused = LabelMap::new(&grid(dims, false)).unwrap_err();
    LEFT.store(u64::MAX, Ordering::Relaxed);
    assert!(matches!(refused, LabelError::Memory(_)), "{refused}");
    assert_eq!(LabelMap::new(&grid(dims, false)).unwrap().count(1), 1 << 20);
}
