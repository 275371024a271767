//! Tables of the transfer function, and what can be visible by them.

use vr_core::{GridVolume, Scene, TransferFunction};
use vr_kernels::tables::{BakedTransfer, PreIntegrated, resolves_ramps, table_range};
use vr_kernels::vector::OpticsTable;

use crate::tex_slice::{Format, TexSlice};

/// What follows from the transfer function alone.
pub(crate) struct Tables {
    range: (f32, f32),
    pub(crate) segments: Option<PreIntegrated<f32>>,
    lengths: Option<LengthTables>,
}

/// What follows from the transfer function and the length of a slab.
pub(crate) struct LengthTables {
    pub(crate) length: f64,
    pub(crate) baked: BakedTransfer<f32>,
    pub(crate) optics: OpticsTable,
}

impl Tables {
    pub(crate) fn new(renderer: &TexSlice, scene: &Scene, volume: &GridVolume) -> Self {
        let segments = (renderer.format == Format::PreIntegrated).then(|| segments(scene, volume));
        let (low, high) = volume.census().range.unwrap_or((0.0, 0.0));
        let field = (f64::from(low), f64::from(high));
        let range = table_range(field, volume.voxel_type().is_integer(), volume.calibration(), &scene.transfer);
        Self { range, segments, lengths: None }
    }

    /// Makes the tables for slabs of a length, unless they are for it already; whether they had to be made.
    pub(crate) fn tabulate(&mut self, scene: &Scene, volume: &GridVolume, length: f64) -> bool {
        if self.lengths.as_ref().is_some_and(|l| l.length == length) {
            return false;
        }
        let integer = volume.voxel_type().is_integer();
        let baked = BakedTransfer::new(&scene.transfer, volume.calibration(), self.range, integer, length);
        let optics = OpticsTable::new(&baked, &scene.transfer, volume.calibration(), length);
        self.lengths = Some(LengthTables { length, baked, optics });
        true
    }

    /// Whether anything is visible between two stored numbers, as fragments of values are classified.
    ///
    /// # Panics
    /// If no length has been tabulated.
    pub(crate) fn shows(&self, scene: &Scene, volume: &GridVolume, low: f32, high: f32) -> bool {
        let tables = self.of_length();
        match &self.segments {
            Some(segments) => !segments.is_clear(low, high),
            None if tables.resolves(&scene.transfer, volume) => tables.baked.shows(low, high),
            None => is_visible(&scene.transfer, volume, low, high),
        }
    }

    /// Those of the last length asked for.
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
    let range = volume.census().range.unwrap_or((0.0, 0.0));
    let table = |intervals| PreIntegrated::new(&scene.transfer, volume.calibration(), range, intervals);
    let aligned = INTERVALS.into_iter().map(table).find(PreIntegrated::is_aligned);
    aligned.unwrap_or_else(|| table(INTERVALS[2]))
}

impl LengthTables {
    /// Whether the table tells apart all that the transfer function does.
    pub(crate) fn resolves(&self, transfer: &TransferFunction, volume: &GridVolume) -> bool {
        resolves_ramps(self.baked.spacing(), volume.calibration(), transfer)
    }
}

/// Whether the transfer function shows anything at or between two stored numbers.
pub(crate) fn is_visible(transfer: &TransferFunction, volume: &GridVolume, low: f32, high: f32) -> bool {
    let [a, b] = [low, high].map(|v| volume.calibration().value(f64::from(v)));
    let (low, high) = (a.min(b), a.max(b));
    let shows = |value: f64| {
        let at = transfer.at(value);
        at.opacity > 0.0 || at.emission != [0.0; 3]
    };
    shows(low) || shows(high) || transfer.segments().iter().any(|s| s.from < high && s.to > low && !s.is_clear())
}
