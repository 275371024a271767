//! Time and memory that the process has used so far; `None` where a system does not count them, or this program cannot ask for them.

use std::time::Duration;

/// Returns the CPU time of all threads, by the system's own clock for it (Linux and macOS).
pub fn cpu_time() -> Option<Duration> {
    #[cfg(any(target_os = "linux", target_os = "macos"))]
    {
        nix::time::ClockId::CLOCK_PROCESS_CPUTIME_ID.now().ok().map(Duration::from)
    }
    #[cfg(not(any(target_os = "linux", target_os = "macos")))]
    None
}

/// Returns the largest resident set in bytes since the start, pages of mapped files among them (Linux).
pub fn peak_bytes() -> Option<u64> {
    // Other systems have no such file.
    kibibytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// Returns the bytes that a line such as `VmHWM:     12345 kB` in one of Linux's descriptions tells.
pub fn kibibytes(text: &str, key: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim_end().parse().ok()?;
    kibibytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    use std::time::Instant;

    use super::*;

    #[test]
    fn the_peak_is_read_and_never_guessed() {
        assert_eq!(kibibytes("Name:\tvr\nVmPeak:\t  900 kB\nVmHWM:\t     12 kB\n", "VmHWM:"), Some(12 * 1024));
        for other in ["", "Name:\tvr\n", "VmHWM:\n", "VmHWM: 12\n", "VmHWM: x kB\n", "VmHWM: 99999999999999999999 kB\n"]
        {
            assert_eq!(kibibytes(other, "VmHWM:"), None, "{other:?}");
        }
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_and_time_that_are_used_are_seen() {
        // Every page is written, so that it is resident.
        let filled = std::hint::black_box(vec![1u8; 64 << 20]);
        assert!(peak_bytes().unwrap() >= filled.len() as u64);
        let before = cpu_time().unwrap();
        // Other tests of this process may be what the clock tells of.
        let (mut spins, deadline) = (0u64, Instant::now() + Duration::from_secs(60));
        while cpu_time().unwrap() - before < Duration::from_millis(2) && Instant::now() < deadline {
            spins = std::hint::black_box(spins + 1);
        }
        assert!(Instant::now() < deadline, "the clock stands still after {spins} turns");
    }
}
