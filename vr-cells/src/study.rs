//! Settings of the marcher that a study compares, and its error on the hard case that is a mesh.

use vr_core::{Documented, DocumentedError, HardCaseErrors, NamedSetting};

use crate::marcher::CellMarcher;

impl Documented for CellMarcher {
    fn settings(&self) -> Vec<NamedSetting> {
        vec![
            NamedSetting::new("exact", &Self { termination: 1.0 }, None, 1e-6),
            NamedSetting::new("default", &Self::default(), None, 1e-6),
        ]
    }

    /// Rounding alone, whatever the cells: a sliver is a cell like any other.
    fn hard_case_errors(&self) -> HardCaseErrors {
        HardCaseErrors { by_case: vec![("slivers", DocumentedError::Max(1e-6))], otherwise: None }
    }
}
