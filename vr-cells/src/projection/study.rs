//! Settings of the projector that a study compares. The hard cases are grids, which it does not draw.

use vr_core::{Documented, NamedSetting};

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
}
