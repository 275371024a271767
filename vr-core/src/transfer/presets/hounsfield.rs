//! Hounsfield units, and how values that are not in them are related to them.

/// The scale of a 12-bit CT scanner, in Hounsfield units.
const SCANNER: (f64, f64) = (-1024.0, 3071.0);

/// Offset that scanners add so that no stored number is negative.
const STORED_ABOVE: f64 = 1024.0;

/// True if values in a range look like Hounsfield units (air −1000, water 0): they begin below −500, which MR and 8-bit data
/// do not, and fit into the 16 bits that scanners store.
pub fn is_hounsfield((low, high): (f64, f64)) -> bool {
    (-32768.0..-500.0).contains(&low) && (0.0..32768.0).contains(&high)
}

/// Relation of a volume's values to Hounsfield units.
///
/// # Examples
/// ```
/// use vr_core::transfer::HounsfieldScale;
///
/// let stored = HounsfieldScale::of_range((0.0, 3272.0));
/// assert_eq!(stored, HounsfieldScale::Stored);
/// assert_eq!(stored.value(300.0), 1324.0, "bone, as a scanner stores it");
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HounsfieldScale {
    /// The values are Hounsfield units.
    Calibrated,
    /// The values are the numbers that a scanner stores, 1024 above Hounsfield units.
    Stored,
    /// No unit: the range is taken for the scale of a 12-bit scanner, −1024 to 3071.
    Stretched {
        /// The value at −1024.
        low: f64,
        /// The value at 3071.
        high: f64,
    },
}

impl HounsfieldScale {
    /// The relation that a range of values suggests.
    pub fn of_range(range: (f64, f64)) -> Self {
        /// From so large a value on, something that is stored is denser than contrast agent; 16-bit data go further than scanners do.
        const DENSE: f64 = 1500.0;
        let (low, high) = range;
        if is_hounsfield(range) {
            Self::Calibrated
        } else if (0.0..500.0).contains(&low) && (DENSE..=SCANNER.1 + STORED_ABOVE).contains(&high) {
            Self::Stored
        } else {
            Self::Stretched { low, high }
        }
    }

    /// The value at which a volume has so many Hounsfield units.
    pub fn value(self, hounsfield: f64) -> f64 {
        match self {
            Self::Calibrated => hounsfield,
            Self::Stored => hounsfield + STORED_ABOVE,
            Self::Stretched { low, high } => low + (high - low) * ((hounsfield - SCANNER.0) / (SCANNER.1 - SCANNER.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hounsfield_is_told_from_other_data() {
        assert!(is_hounsfield((-1024.0, 1800.0)) && is_hounsfield((-3024.0, 3071.0)));
        assert!(!is_hounsfield((0.0, 4095.0)) && !is_hounsfield((-1.0, 1.0)) && !is_hounsfield((-1e6, 1e6)));
    }

    #[test]
    fn scales_are_told_by_their_range() {
        assert_eq!(HounsfieldScale::of_range((-1024.0, 1800.0)), HounsfieldScale::Calibrated);
        assert_eq!(HounsfieldScale::of_range((0.0, 4095.0)), HounsfieldScale::Stored);
        for range in [(0.0, 255.0), (0.0, 1.0), (0.0, 65535.0), (7.0, 7.0), (-3.0, 3.0)] {
            let scale = HounsfieldScale::of_range(range);
            assert_eq!(scale, HounsfieldScale::Stretched { low: range.0, high: range.1 });
            assert_eq!((scale.value(-1024.0), scale.value(3071.0)), range);
        }
    }
}
