//! Memory that a command may take.

use std::fs;
use std::sync::OnceLock;

use vr_core::memory;
use vr_study::memory::MemoryMeter;

use crate::heap::Heap;
use crate::process::kibibytes;

/// Limit that `--memory` sets on the heap, in bytes.
static LIMIT: OnceLock<u64> = OnceLock::new();

/// Has everything large asked for before it is allocated: against a limit on the heap if there is one, and against what the system has left.
pub fn enforce(limit: Option<u64>) {
    if let Some(limit) = limit {
        // Set once a run.
        let _ = LIMIT.set(limit);
    }
    memory::set_meter(left);
}

/// Returns the bytes that may still be allocated.
fn left() -> u64 {
    let own = LIMIT.get().map(|limit| limit.saturating_sub(Heap.current() as u64));
    own.into_iter().chain([of_machine(), of_process(), of_group()].into_iter().flatten()).min().unwrap_or(u64::MAX)
}

/// Memory that the machine has left, of Linux.
fn of_machine() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")
}

/// Addresses that the limit of the process (`ulimit -v`) leaves, of Linux; `None` without a limit.
fn of_process() -> Option<u64> {
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    let limit: u64 = line.split_whitespace().next()?.parse().ok()?;
    let used = kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmSize:")?;
    Some(limit.saturating_sub(used))
}

/// Memory that the control group of the process has left: version 2 or 1, as a container has it at the root; `None` without a limit.
fn of_group() -> Option<u64> {
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let places = [
        ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory.current"],
        ["/sys/fs/cgroup/memory/memory.limit_in_bytes", "/sys/fs/cgroup/memory/memory.usage_in_bytes"],
    ];
    places.iter().find_map(|[limit, used]| Some(number(limit)?.saturating_sub(number(used)?)))
}

/// Reads a size: a number of bytes, with a unit of powers of 1000 (`kB`, `MB`, `GB`, or a letter alone) or of 1024 (`KiB`, `MiB`, `GiB`).
///
/// # Errors
/// A text that is no such size.
pub fn size(text: &str) -> Result<u64, String> {
    let wrong = || "must be a size such as 800M, 4GB or 4GiB".to_owned();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "t" | "tb" => 1e12,
        "kib" => f64::from(1 << 10),
        "mib" => f64::from(1 << 20),
        "gib" => f64::from(1 << 30),
        "tib" => 2f64.powi(40),
        _ => return Err(wrong()),
    };
    let number: f64 = digits.trim().parse().map_err(|_| wrong())?;
    let bytes = number * unit;
    // Beyond that, u64 does not hold it.
    if (1.0..1e19).contains(&bytes) { Ok(bytes as u64) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, bytes) in [("4096", 4096), ("800M", 800_000_000), ("1.5 GB", 1_500_000_000), ("4GiB", 1 << 32)] {
            assert_eq!(size(text), Ok(bytes), "{text}");
        }
        for text in ["", "G", "-1", "4 apples", "1e30", "nan", "inf", "0"] {
            assert!(size(text).is_err(), "{text}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn the_machine_has_something_left() {
        assert!((1 << 20..1 << 50).contains(&of_machine().unwrap()));
        // Others take and give back memory meanwhile: at most a gibibyte of it.
        assert!(left() > 0 && left() <= of_machine().unwrap() + (1 << 30));
    }
}
