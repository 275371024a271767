//! Look of a label.

use super::error::LabelError;

/// Look of what bears a label.
///
/// # Examples
/// ```
/// use vr_core::labels::LabelStyle;
///
/// let liver = LabelStyle::Solid { color: [0.5, 0.1, 0.05], opacity: 0.9 };
/// assert!(liver.is_solid() && !liver.is_hidden());
/// assert!(LabelStyle::Volume { opacity: 0.0 }.is_hidden(), "nothing of the volume is left");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LabelStyle {
    /// Vacuum.
    Hidden,
    /// The volume, as its transfer function says.
    Volume {
        /// Factor on the opacities, from 0 to 1.
        opacity: f64,
    },
    /// The volume with its own opacities, in one colour.
    Tinted {
        /// Linear RGB.
        color: [f64; 3],
        /// Factor on the opacities, from 0 to 1.
        opacity: f64,
    },
    /// One colour and one opacity throughout, whatever the volume's values are; lit as the surface that it is.
    Solid {
        /// Linear RGB.
        color: [f64; 3],
        /// Opacity of a slab of the transfer function's unit distance.
        opacity: f64,
    },
}

impl LabelStyle {
    /// The volume as it is.
    pub const VOLUME: Self = Self::Volume { opacity: 1.0 };

    /// True if nothing of it can be seen.
    pub fn is_hidden(self) -> bool {
        match self {
            Self::Hidden => true,
            Self::Volume { opacity } | Self::Tinted { opacity, .. } | Self::Solid { opacity, .. } => opacity == 0.0,
        }
    }

    /// True if it has one colour and one opacity throughout.
    pub fn is_solid(self) -> bool {
        matches!(self, Self::Solid { .. })
    }

    /// Checks the numbers of the style of a label.
    pub(super) fn check(self, label: i32) -> Result<(), LabelError> {
        let (color, opacity) = match self {
            Self::Hidden => return Ok(()),
            Self::Volume { opacity } => ([0.0; 3], opacity),
            Self::Tinted { color, opacity } | Self::Solid { color, opacity } => (color, opacity),
        };
        if !(0.0..=1.0).contains(&opacity) {
            let (what, found) = ("opacity", opacity.to_string());
            return Err(LabelError::Style { label, what, found, allowed: "from 0 to 1" });
        }
        if !color.iter().all(|c| (0.0..=1.0).contains(c)) {
            let (what, found) = ("colour", format!("{color:?}"));
            return Err(LabelError::Style { label, what, found, allowed: "three numbers from 0 to 1" });
        }
        Ok(())
    }
}
