//! Options of the marcher.

use vr_core::{Configurable, DeclaredOption, NumberRange, OptionTable};

use crate::marcher::CellMarcher;

impl Configurable for CellMarcher {
    fn options() -> OptionTable<Self> {
        OptionTable::new(
            Self::NAME,
            [DeclaredOption::number(
                "termination",
                "opacity from which on a ray ends; 1: never",
                NumberRange::above(0.0).up_to(1.0),
                |r: &Self| r.termination,
                |r, x| r.termination = x,
            )],
        )
    }
}
