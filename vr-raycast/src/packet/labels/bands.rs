//! Tables of the bands of a grid with labels.

use vr_core::labels::{LabelCode, LabelledGrid};
use vr_core::{Calibration, TransferFunction};
use vr_kernels::tables::{BakedTransfer, table_range};
use vr_kernels::vector::{OpticsTable, TablePlaces};

use crate::table_range::{field_range, resolves};

/// Optical properties of all bands, in one table, and the places of each band in it.
#[derive(Clone, Debug)]
pub(super) struct Bands {
    /// Code of each band; none is vacuum.
    pub(super) codes: Vec<LabelCode>,
    /// Places of each band's numbers in the table; a solid style has one.
    pub(super) places: Vec<TablePlaces>,
    /// Optics of all bands, for lengths in units of a step.
    pub(super) optics: OpticsTable,
}

/// Largest number of bands. In f32, places in so many tables of the usual size are exact to a 32nd of an entry.
const MAX_BANDS: usize = 128;

impl Bands {
    /// Returns the bands of a field under the transfer function of its codes, for steps of a world length; `None` where a table does not resolve the function, and for
    /// too many bands.
    pub(super) fn new(field: &LabelledGrid, transfer: &TransferFunction, step: f64) -> Option<Self> {
        let volume = field.volume();
        let codes: Vec<LabelCode> = field.codes().into_iter().filter(|code| *code != LabelCode::Vacuum).collect();
        if codes.len() > MAX_BANDS {
            return None;
        }
        let (range, integer) = (field_range(volume)?, volume.voxel_type().is_integer());
        let table_of = |code: &LabelCode| match code {
            LabelCode::Offset(_) => {
                let calibration = calibration_of(field, *code);
                let places = table_range(range, integer, calibration, transfer);
                let table = BakedTransfer::<f32>::new(transfer, calibration, places, integer, step);
                resolves(&table, volume).then(|| OpticsTable::new(&table, transfer, calibration, step))
            }
            LabelCode::Constant(value) => Some(OpticsTable::of_value(transfer, *value, step)),
            LabelCode::Vacuum => None,
        };
        let tables: Option<Vec<OpticsTable>> = codes.iter().map(table_of).collect();
        let (optics, places) = OpticsTable::joined(&tables?);
        Some(Self { codes, places, optics })
    }

    /// Band of a code; `None` of vacuum.
    #[inline]
    pub(super) fn of(&self, code: LabelCode) -> Option<u16> {
        Some(self.codes.iter().position(|&own| own == code)? as u16)
    }

    /// True if a band's samples all have one value.
    #[inline(always)]
    pub(super) fn is_solid(&self, band: u16) -> bool {
        matches!(self.codes[usize::from(band)], LabelCode::Constant(_))
    }
}

/// Calibration from the grid's stored numbers to the values of a band.
pub(super) fn calibration_of(field: &LabelledGrid, code: LabelCode) -> Calibration {
    let own = field.volume().calibration();
    let offset = if let LabelCode::Offset(offset) = code { offset } else { 0.0 };
    Calibration { intercept: own.intercept + offset, ..own }
}
