//! Tables of the transfer function, and what can be visible by them.

use std::sync::Arc;
use vr_core::{GridVolume, Scene};
use vr_kernels::ranges::Visibility;
use vr_kernels::tables::{BakedTransfer, PreIntegrated, table_range};
use vr_kernels::vector::{OpticsTable, SegmentTable};

use crate::texture_slicer::{Format, TextureSlicer};

/// Tables that follow from the transfer function alone.
pub(crate) struct Tables {
    range: (f32, f32),
    pub(crate) segments: Option<SegmentTable>,
    lengths: Option<LengthTables>,
}

/// Tables that follow from the transfer function and the length of a slab.
pub(crate) struct LengthTables {
    pub(crate) length: f64,
    pub(crate) baked: Arc<BakedTransfer<f32>>,
    pub(crate) optics: OpticsTable,
    /// Visibility of fragments of values, as they are classified.
    pub(crate) visibility: Visibility<f32>,
}

impl Tables {
    pub(crate) fn new(renderer: &TextureSlicer, scene: &Scene, volume: &GridVolume) -> Self {
        let segments =
            (renderer.format == Format::PreIntegrated).then(|| SegmentTable::new(&Arc::new(segments(scene, volume))));
        let (low, high) = volume.value_stats().range.unwrap_or((0.0, 0.0));
        let field = (f64::from(low), f64::from(high));
        let range = table_range(field, volume.voxel_type().is_integer(), volume.calibration(), &scene.transfer);
        Self { range, segments, lengths: None }
    }

    /// Makes the tables for slabs of a length, unless they are for it already; returns true if they had to be made.
    pub(crate) fn tabulate(&mut self, scene: &Scene, volume: &GridVolume, length: f64) -> bool {
        if self.lengths.as_ref().is_some_and(|l| l.length == length) {
            return false;
        }
        let integer = volume.voxel_type().is_integer();
        let baked = Arc::new(BakedTransfer::new(&scene.transfer, volume.calibration(), self.range, integer, length));
        let optics = OpticsTable::new(&baked, &scene.transfer, volume.calibration(), length);
        let table = Some(&baked).filter(|table| self.segments.is_none() && table.resolves());
        let segments = self.segments.as_ref().map(SegmentTable::pre_integrated);
        let visibility = Visibility::of_light(&scene.transfer, volume.calibration(), table, segments);
        self.lengths = Some(LengthTables { length, baked, optics, visibility });
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

/// The table of segments, in any precision.
pub(crate) fn segments<R: vr_core::Real>(scene: &Scene, volume: &GridVolume) -> PreIntegrated<R> {
    let range = volume.value_stats().range.unwrap_or((0.0, 0.0));
    let table = |intervals| PreIntegrated::new(&scene.transfer, volume.calibration(), range, intervals);
    let aligned = INTERVALS.into_iter().map(table).find(PreIntegrated::is_aligned);
    aligned.unwrap_or_else(|| table(INTERVALS[2]))
}
