//! Machine and program that figures were measured with.

use serde::{Deserialize, Serialize};

/// Machine and program that figures were measured with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor, as the system names it; `None` where it does not.
    pub processor: Option<String>,
    /// Processors that the program may use.
    pub processors: usize,
    /// Threads that were used.
    pub threads: usize,
    /// Bytes of main memory; `None` where the system does not tell.
    pub memory: Option<u64>,
    /// Operating system and architecture: `linux x86_64`.
    pub system: String,
    /// The version of these crates.
    pub version: String,
    /// True if the program was built with optimization.
    pub optimized: bool,
}

impl Machine {
    /// Returns this machine and program.
    pub fn here(threads: usize) -> Self {
        let cpu = std::fs::read_to_string("/proc/cpuinfo").ok();
        let memory = std::fs::read_to_string("/proc/meminfo").ok();
        Self {
            processor: cpu.as_deref().and_then(|text| entry(text, "model name")).map(str::to_owned),
            processors: std::thread::available_parallelism().map_or(1, usize::from),
            threads,
            memory: memory.as_deref().and_then(|text| entry(text, "MemTotal")).and_then(kibibytes),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            optimized: !cfg!(debug_assertions),
        }
    }
}

/// Returns the value of the first line `key : value`.
fn entry<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    let value = |line: &'a str| line.split_once(':').filter(|(k, _)| k.trim() == key).map(|(_, v)| v.trim());
    text.lines().find_map(value)
}

fn kibibytes(text: &str) -> Option<u64> {
    text.strip_suffix("kB")?.trim_end().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_read_and_never_guessed() {
        let text = "processor\t: 0\nmodel name\t: A B\nMemTotal:       12 kB\n";
        assert_eq!(entry(text, "model name"), Some("A B"));
        assert_eq!(entry(text, "MemTotal").and_then(kibibytes), Some(12 * 1024));
        assert_eq!(entry(text, "bogomips"), None);
        assert_eq!(kibibytes("99999999999999999999 kB"), None);
        assert_eq!(Machine::here(3).threads, 3);
    }
}
