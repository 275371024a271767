//! Settings of the projector that a study compares, and its error on the hard case that is a mesh.

use vr_core::{Documented, DocumentedError, HardCaseErrors, NamedSetting};

use super::projector::{Attenuation, CellProjector};

impl Documented for CellProjector {
    fn settings(&self) -> Vec<NamedSetting> {
        let classic = Self { attenuation: Attenuation::Linear, ..Self::default() };
        vec![
            NamedSetting::new("whole", &Self { termination: 1.0, ..Self::default() }, None, 1e-4),
            NamedSetting::new("default", &Self::default(), None, 1e-4),
            NamedSetting::new("classic", &classic, None, 0.1),
        ]
    }

    /// Measured errors, and half as much again or more.
    fn hard_case_errors(&self) -> HardCaseErrors {
        let error = match self.attenuation {
            Attenuation::Exact => 1e-4,
            Attenuation::Linear => 0.23,
        };
        HardCaseErrors { by_case: vec![("slivers", DocumentedError::Max(error))], otherwise: None }
    }
}
