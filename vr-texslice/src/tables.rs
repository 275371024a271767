//! Tables of the transfer function, and what can be visible by them.

use std::sync::{Arc, Mutex};

use vr_core::parallel::locked;
use vr_core::{GridVolume, Real, Scene, TransferFunction};
use vr_kernels::ranges::Visibility;
use vr_kernels::tables::{BakedTransfer, PreIntegrated, resolves_extinction, table_range};
use vr_kernels::vector::{OpticsTable, SegmentTable};

use crate::texture_slicer::{Format, TextureSlicer};

/// Tables that follow from the transfer function alone.
pub(crate) struct Tables {
    range: (f32, f32),
    pub(crate) segments: Option<Arc<SegmentTable>>,
    /// Segments of each row of a transfer function by gradient.
    pub(crate) row_segments: Vec<PreIntegrated<f32>>,
    lengths: Option<LengthTables>,
}

/// Tables that follow from the transfer function and the length of a slab.
pub(crate) struct LengthTables {
    pub(crate) length: f64,
    pub(crate) baked: Arc<BakedTransfer<f32>>,
    pub(crate) optics: OpticsTable,
    /// Optics of each row of a transfer function by gradient.
    pub(crate) row_optics: Arc<[OpticsTable]>,
    /// True if the tables of optics tell apart all that extinction does.
    pub(crate) resolves_extinction: bool,
    /// Visibility of fragments of values, as they are classified.
    pub(crate) visibility: Visibility<f32>,
}

impl Tables {
    pub(crate) fn new(renderer: &TextureSlicer, scene: &Scene, volume: &GridVolume) -> Self {
        let integrates = renderer.format == Format::PreIntegrated;
        let segments = integrates.then(|| last_segments(scene, volume));
        let row_segments = if integrates { segments_of_rows(scene, volume) } else { Vec::new() };
        let (low, high) = volume.value_stats().range.unwrap_or((0.0, 0.0));
        let field = (f64::from(low), f64::from(high));
        let range = table_range(field, volume.voxel_type().is_integer(), volume.calibration(), &scene.transfer);
        Self { range, segments, row_segments, lengths: None }
    }

    /// Makes the tables for slabs of a length, unless they are for it already; returns true if they had to be made.
    pub(crate) fn tabulate(&mut self, scene: &Scene, volume: &GridVolume, length: f64) -> bool {
        if self.lengths.as_ref().is_some_and(|l| l.length == length) {
            return false;
        }
        let integer = volume.voxel_type().is_integer();
        let baked = Arc::new(BakedTransfer::new(&scene.transfer, volume.calibration(), self.range, integer, length));
        let optics = |transfer| OpticsTable::new(&baked, transfer, volume.calibration(), length);
        let row_optics = scene.transfer.rows().iter().map(|row| optics(&row.transfer)).collect();
        let optics = optics(&scene.transfer);
        let spacing = (volume.calibration().slope / f64::from(baked.per_unit())).abs();
        let rows = scene.transfer.rows().iter().map(|row| &row.transfer);
        let mut functions = rows.chain([&*scene.transfer]);
        let resolves_extinction = baked.resolves() && functions.all(|transfer| resolves_extinction(transfer, spacing));
        let table = Some(&baked).filter(|table| self.segments.is_none() && table.resolves());
        let segments = self.segments.as_deref().map(SegmentTable::pre_integrated);
        let visibility = Visibility::of_light(&scene.transfer, volume.calibration(), table, segments);
        self.lengths = Some(LengthTables { length, baked, optics, row_optics, resolves_extinction, visibility });
        true
    }

    /// Returns the tables of the last length asked for.
    ///
    /// # Panics
    /// If none has been asked for.
    pub(crate) fn of_length(&self) -> &LengthTables {
        self.lengths.as_ref().expect("tabulated before")
    }
}

/// Intervals of a table of segments, the fewest that serve: of 1024 to 65536 the first number at which the knots of the transfer function fall onto the
/// ends of intervals.
const INTERVALS: [usize; 3] = [1024, 8192, 65536];

/// The tables of segments of a transfer function's rows by gradient, in any precision; none where it has no rows.
pub(crate) fn segments_of_rows<R: Real>(scene: &Scene, volume: &GridVolume) -> Vec<PreIntegrated<R>> {
    scene.transfer.rows().iter().map(|row| segments(&row.transfer, volume)).collect()
}

/// The table of segments of a transfer function, in any precision.
pub(crate) fn segments<R: Real>(transfer: &TransferFunction, volume: &GridVolume) -> PreIntegrated<R> {
    let range = volume.value_stats().range.unwrap_or((0.0, 0.0));
    let table = |intervals| PreIntegrated::new(transfer, volume.calibration(), range, intervals);
    let [fewest, more, most] = INTERVALS;
    let aligned = [fewest, more].into_iter().map(table).find(PreIntegrated::is_aligned);
    aligned.unwrap_or_else(|| table(most))
}

/// The table of a volume's last transfer function. The largest take as long to make as a large picture: renderers of other settings share it.
#[derive(Default)]
struct LastSegments(Mutex<Option<(Arc<TransferFunction>, Arc<SegmentTable>)>>);

/// The table of segments for fragments, kept with the volume until there is one for another transfer function.
fn last_segments(scene: &Scene, volume: &GridVolume) -> Arc<SegmentTable> {
    let kept = volume.derived().get("last segments", LastSegments::default);
    let mut kept = locked(&kept.0);
    match &*kept {
        Some((transfer, table)) if *transfer == scene.transfer => Arc::clone(table),
        _ => {
            let table = Arc::new(SegmentTable::new(&Arc::new(segments(&scene.transfer, volume))));
            *kept = Some((Arc::clone(&scene.transfer), Arc::clone(&table)));
            table
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::{Calibration, ControlPoint, OpacityRule, Placement, UniformGrid};

    #[test]
    fn a_volume_keeps_the_table_of_its_last_transfer_function() {
        let samples: Vec<f32> = (0..27).map(|i| i as f32).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let grid = UniformGrid::new([3; 3], samples, placement, Calibration::default()).unwrap();
        let transfer = |knot: f64| {
            let points = [(0.0, 0.0), (knot, 0.3), (26.0, 0.1)];
            let points = points.map(|(value, opacity)| ControlPoint::new(value, [1.0; 3], opacity));
            TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap()
        };
        let first = Scene::new(grid.into(), transfer(13.0));
        // No number of intervals has an end at it.
        let odd = Scene { transfer: transfer(std::f64::consts::E).into(), ..first.clone() };
        let table = |scene: &Scene| last_segments(scene, scene.volume.grid().unwrap());
        let (a, b) = (table(&first), table(&first.clone()));
        assert!(Arc::ptr_eq(&a, &b));
        let c = table(&odd);
        assert!(!Arc::ptr_eq(&a, &c) && Arc::ptr_eq(&c, &table(&odd)));
        let rows = |table: &SegmentTable| table.pre_integrated().rows().len();
        assert!(rows(&a) <= INTERVALS[0] + 2 && rows(&c) > INTERVALS[2] / 2, "{} {}", rows(&a), rows(&c));
        // Made anew, it is the same.
        assert!(!Arc::ptr_eq(&a, &table(&first)));
        assert_eq!(table(&first).pre_integrated().rows(), a.pre_integrated().rows());
    }
}
