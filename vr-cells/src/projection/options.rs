//! Options of the projector.

use vr_core::{Configurable, DeclaredOption, NumberRange, OptionTable};

use super::projector::{Attenuation, CellProjector};

impl Configurable for CellProjector {
    fn options() -> OptionTable<Self> {
        OptionTable::new(
            Self::NAME,
            [
                DeclaredOption::choice(
                    "attenuation",
                    "light inside a cell: the integral along each ray, or linear from the thickest point of its projection to the rim",
                    [("exact", Attenuation::Exact), ("linear", Attenuation::Linear)],
                    |r: &Self| r.attenuation,
                    |r, attenuation| r.attenuation = attenuation,
                ),
                DeclaredOption::number(
                    "termination",
                    "opacity from which on a pixel takes no more; 1: never",
                    NumberRange::above(0.0).up_to(1.0),
                    |r: &Self| r.termination,
                    |r, x| r.termination = x,
                ),
            ],
        )
    }
}
