//! Patient spaces: which way the axes of a file's world point, and how to turn them to RAS.

use glam::{DMat3, DVec3};
use vr_core::{GridError, Placement};

/// The world that the positions in a file refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Space {
    /// Right, anterior, superior: what volumes are turned to.
    Ras,
    /// Left, anterior, superior.
    Las,
    /// Left, posterior, superior: DICOM's and ITK's.
    Lps,
    /// The file's own frame, kept as it is.
    Own,
}

impl Space {
    /// `RAS`, `LAS`, `LPS` or `own frame`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ras => "RAS",
            Self::Las => "LAS",
            Self::Lps => "LPS",
            Self::Own => "own frame",
        }
    }

    /// True if the world is a patient's, so that positions were turned to RAS.
    pub fn is_patient(self) -> bool {
        self != Self::Own
    }

    /// Signs that turn positions in this space to RAS, and back.
    pub(crate) fn to_ras(self) -> DVec3 {
        match self {
            Self::Ras | Self::Own => DVec3::ONE,
            Self::Las => DVec3::new(-1.0, 1.0, 1.0),
            Self::Lps => DVec3::new(-1.0, -1.0, 1.0),
        }
    }

    /// A placement in RAS from one in this space.
    pub(crate) fn place(self, origin: DVec3, axes: DMat3) -> Result<Placement, GridError> {
        let turn = self.to_ras();
        Placement::new(turn * origin, DMat3::from_diagonal(turn) * axes)
    }
}

impl std::fmt::Display for Space {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Nearest directions of the index axes of a placement in RAS: `LPI` means towards left, posterior and inferior.
pub fn orientation(placement: &Placement) -> String {
    let axes = placement.axes();
    [axes.x_axis, axes.y_axis, axes.z_axis]
        .map(|a| {
            let towards = a.abs().max_position();
            let (positive, negative) = [('R', 'L'), ('A', 'P'), ('S', 'I')][towards];
            if a[towards] >= 0.0 { positive } else { negative }
        })
        .iter()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lps_becomes_ras() {
        let p = Space::Lps.place(DVec3::new(1.0, 2.0, 3.0), DMat3::IDENTITY).unwrap();
        assert_eq!(p.origin(), DVec3::new(-1.0, -2.0, 3.0));
        assert_eq!(p.to_world(DVec3::ONE), DVec3::new(-2.0, -3.0, 4.0));
        assert_eq!(orientation(&p), "LPS");
    }
}
