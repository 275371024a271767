//! Gradient and colours along a cell: what light and opacity depend on besides the value.

use super::normals::Normals;
use super::reflection::{ColorChange, RayReflection};
use super::tint::Tint;

/// Gradient and colours along a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Looks {
    pub(super) normals: Normals,
    pub(super) tint: Tint,
}

impl Looks {
    /// Unknown gradients, and unknown colours where places have any of their own.
    pub(super) fn unknown(colored: bool) -> Self {
        Self { normals: Normals::Unknown, tint: if colored { Tint::Unknown } else { Tint::White } }
    }

    /// True if there is no gradient, and no colour: nothing depends on the place.
    pub(super) fn is_plain(&self) -> bool {
        matches!((&self.normals, &self.tint), (Normals::Absent, Tint::White))
    }

    /// Returns the change of the transfer function's colours on the part [from, to] of a cell, 0 to 1; `None` if there is none.
    pub(super) fn change(&self, reflection: Option<&RayReflection<'_>>, part: [f64; 2]) -> Option<ColorChange> {
        let reflected = reflection.map(|reflection| reflection.on(&self.normals, part));
        let Some(tint) = self.tint.on(part) else { return reflected };
        Some(reflected.unwrap_or(ColorChange::UNCHANGED).of_tinted(&tint))
    }
}
