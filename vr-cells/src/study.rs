//! Settings of the marcher that a study compares. The hard cases are grids, which it does not draw.

use vr_core::{Documented, NamedSetting};

use crate::marcher::CellMarcher;

impl Documented for CellMarcher {
    fn settings(&self) -> Vec<NamedSetting> {
        vec![
            NamedSetting::new("exact", &Self { termination: 1.0 }, None, 1e-6),
            NamedSetting::new("default", &Self::default(), None, 1e-6),
        ]
    }
}
