//! Numbers of a variable as they are meant: calibration, and voxels that are missing.

use vr_core::Calibration;

use crate::decode::numbers_as_f64;
use crate::error::FileErrorKind;
use crate::scalar::{Endian, ScalarType};

use super::{Store, Variable, numbers, text};

/// Meaning of stored numbers.
#[derive(Clone, Debug)]
pub(super) struct Packing {
    pub calibration: Calibration,
    stored: ScalarType,
    /// Stored numbers that stand for nothing.
    missing: Vec<f64>,
    /// Smallest and largest stored number that stands for something.
    valid: [f64; 2],
}

impl Packing {
    pub fn read(store: &dyn Store, variable: &Variable) -> Result<Self, FileErrorKind> {
        let name = &variable.name;
        let first = |attribute: &str| numbers(store, name, attribute).first().copied();
        let calibration =
            Calibration { slope: first("scale_factor").unwrap_or(1.0), intercept: first("add_offset").unwrap_or(0.0) };
        if calibration.slope == 0.0 || !calibration.slope.is_finite() || !calibration.intercept.is_finite() {
            let found = format_args!("scale_factor {}, add_offset {}", calibration.slope, calibration.intercept);
            return Err(FileErrorKind::field(name.as_str(), found, "must be finite, and the factor not 0"));
        }
        // Version 3 of NetCDF has no unsigned numbers: an attribute makes them so.
        let is_unsigned = text(store, name, "_Unsigned").is_some_and(|word| word.eq_ignore_ascii_case("true"));
        let stored = match (is_unsigned, variable.scalar) {
            (true, ScalarType::I8) => ScalarType::U8,
            (true, ScalarType::I16) => ScalarType::U16,
            (true, ScalarType::I32) => ScalarType::U32,
            (true, ScalarType::I64) => ScalarType::U64,
            (_, scalar) => scalar,
        };
        let mut missing = [numbers(store, name, "_FillValue"), numbers(store, name, "missing_value")].concat();
        if missing.is_empty() {
            missing.extend(store.default_fill(stored));
        }
        if stored != variable.scalar {
            let range = 2f64.powi(8 * stored.bytes() as i32);
            missing.iter_mut().filter(|m| **m < 0.0).for_each(|m| *m += range);
        }
        let range = numbers(store, name, "valid_range");
        let valid = match range[..] {
            [low, high] => [low, high],
            _ => [first("valid_min").unwrap_or(f64::NEG_INFINITY), first("valid_max").unwrap_or(f64::INFINITY)],
        };
        Ok(Self { calibration, stored, missing, valid })
    }

    /// True if some numbers may stand for nothing.
    pub fn masks(&self) -> bool {
        !self.missing.is_empty() || self.valid != [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// Type of the numbers that [`Self::apply`] gives: floats where voxels may be missing.
    pub fn decoded(&self) -> ScalarType {
        match (self.masks(), self.stored) {
            (false, stored) => stored,
            (true, ScalarType::U32 | ScalarType::I32 | ScalarType::U64 | ScalarType::I64 | ScalarType::F64) => {
                ScalarType::F64
            }
            (true, _) => ScalarType::F32,
        }
    }

    /// Puts NaN for what is missing.
    pub fn apply(&self, bytes: Vec<u8>, endian: Endian) -> Vec<u8> {
        if !self.masks() {
            return bytes;
        }
        let is_there = |x: f64| (self.valid[0]..=self.valid[1]).contains(&x) && !self.missing.contains(&x);
        let masked = |x: f64| if is_there(x) { x } else { f64::NAN };
        // A few at a time: of numbers in 64 bits there is no second copy of all.
        const CHUNK: usize = 1 << 16;
        let mut out = Vec::with_capacity(bytes.len() / self.stored.bytes() * self.decoded().bytes());
        for chunk in bytes.chunks(CHUNK * self.stored.bytes()) {
            let found = numbers_as_f64(chunk, self.stored, endian).into_iter().map(masked);
            match self.decoded() {
                ScalarType::F64 => found.for_each(|x| out.extend(x.to_ne_bytes())),
                _ => found.for_each(|x| out.extend((x as f32).to_ne_bytes())),
            }
        }
        out
    }
}
