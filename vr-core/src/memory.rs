//! Memory that the process has left, which is asked for before anything large is allocated.
//!
//! Rust ends a program whose allocation fails. So whatever grows with a number that a file or a user names (voxels, points, pixels, a text)
//! is held against what is left, and is refused with what it would need. A library asks for nothing unless [`set_meter`] says how to:
//! what a process may take is its own affair.

use std::sync::OnceLock;

/// Meter of the memory that is left, in bytes.
static METER: OnceLock<fn() -> u64> = OnceLock::new();

/// Sizes below this are not asked for: 1 MiB.
const SMALL: u64 = 1 << 20;

/// Memory that is not there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{what} would need {}, and {} of memory are left", bytes_text(*.bytes), bytes_text(*.left))]
pub struct MemoryError {
    /// Name of the thing that would have been allocated, as a message begins with it.
    pub what: String,
    /// Its size in bytes.
    pub bytes: u64,
    /// Bytes that were left.
    pub left: u64,
}

/// Sets the function that tells how many bytes the process may still allocate, for all of the process and once. Returns false where one is set
/// already, which then stays.
///
/// # Examples
/// ```
/// use vr_core::memory;
///
/// memory::check("a volume", 1 << 60)?;
/// assert!(memory::set_meter(|| 1 << 30));
/// let refused = memory::check("a volume", 1 << 31).unwrap_err();
/// assert_eq!(refused.to_string(), "a volume would need 2.1 GB, and 1.1 GB of memory are left");
/// # Ok::<(), memory::MemoryError>(())
/// ```
pub fn set_meter(left: fn() -> u64) -> bool {
    METER.set(left).is_ok()
}

/// Checks that there is memory for something of a size. Passes where no meter is set.
///
/// # Errors
/// [`MemoryError`].
pub fn check(what: impl Into<String>, bytes: u64) -> Result<(), MemoryError> {
    let Some(meter) = METER.get().filter(|_| bytes >= SMALL) else { return Ok(()) };
    let left = meter();
    if bytes > left { Err(MemoryError { what: what.into(), bytes, left }) } else { Ok(()) }
}

/// Returns a number of bytes for people, in decimal units and two digits or more.
pub fn bytes_text(bytes: u64) -> String {
    let units = ["kB", "MB", "GB", "TB", "PB", "EB"];
    let mut amount = bytes as f64;
    if amount < 1000.0 {
        return format!("{bytes} bytes");
    }
    let mut unit = 0;
    amount /= 1000.0;
    // One that would be printed as 1000 is one of the next unit.
    while amount >= 999.5 && unit + 1 < units.len() {
        amount /= 1000.0;
        unit += 1;
    }
    if amount < 9.95 { format!("{amount:.1} {}", units[unit]) } else { format!("{amount:.0} {}", units[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_told_in_units_that_people_read() {
        let texts = [0, 999, 1000, 9949, 9950, 999_499, 999_500, 1 << 30, u64::MAX].map(bytes_text);
        assert_eq!(texts, ["0 bytes", "999 bytes", "1.0 kB", "9.9 kB", "10 kB", "999 kB", "1.0 MB", "1.1 GB", "18 EB"]);
    }
}
