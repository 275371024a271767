//! Settings of the marcher that a study compares, and its documented errors.

use vr_core::{Documented, DocumentedError, HardCaseErrors, NamedSetting};

use crate::marcher::CellMarcher;

impl Documented for CellMarcher {
    fn settings(&self) -> Vec<NamedSetting> {
        vec![
            NamedSetting::new("exact", &Self { termination: 1.0 }, None, 1e-6),
            NamedSetting::new("default", &Self::default(), None, 1e-6),
        ]
    }

    fn hard_case_errors(&self) -> HardCaseErrors {
        HardCaseErrors { otherwise: Some(DocumentedError::Max(1e-5)), ..HardCaseErrors::default() }
    }
}
