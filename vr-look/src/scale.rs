//! Scales of values: from a value to 0..1, and back.

/// Number of steps into which a scale is divided.
pub(crate) const BINS: usize = 256;

/// A monotone map from values to 0..1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// Even steps from `low` to `high`.
    Linear { low: f64, high: f64 },
    /// Even steps of the logarithm from `low` to `high`, both positive.
    Logarithmic { low: f64, high: f64 },
}

impl Scale {
    /// Place of a value; below 0 or above 1 where it lies outside.
    pub fn place(self, value: f64) -> f64 {
        match self {
            Self::Linear { low, high } => (value - low) / (high - low),
            Self::Logarithmic { low, high } => libm::log(value.max(f64::MIN_POSITIVE) / low) / libm::log(high / low),
        }
    }

    /// The value at a place.
    pub fn value(self, place: f64) -> f64 {
        match self {
            Self::Linear { low, high } => low + place * (high - low),
            Self::Logarithmic { low, high } => low * libm::exp(place * libm::log(high / low)),
        }
    }

    /// The bin of a value; the first and the last hold all beyond.
    pub fn bin(self, value: f64) -> usize {
        // `as` saturates.
        ((self.place(value) * BINS as f64) as usize).min(BINS - 1)
    }

    /// The place in the middle of a bin.
    pub fn middle(bin: usize) -> f64 {
        (bin as f64 + 0.5) / BINS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_values_are_inverse() {
        for scale in [Scale::Linear { low: -3.0, high: 9.0 }, Scale::Logarithmic { low: 1e-6, high: 10.0 }] {
            for place in [0.0, 0.3, 1.0] {
                assert!((scale.place(scale.value(place)) - place).abs() < 1e-12);
            }
            assert_eq!((scale.bin(-1e9), scale.bin(1e9)), (0, BINS - 1));
        }
    }
}
