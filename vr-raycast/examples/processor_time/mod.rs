//! Time that the processor spent on a program: what else runs on a machine does not count.

use std::time::Instant;

/// Seconds that all threads of this program have been on a processor; by the clock where the system does not tell (only Linux does).
pub fn processor_seconds() -> f64 {
    static BEGIN: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    let begin = BEGIN.get_or_init(Instant::now);
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return begin.elapsed().as_secs_f64() };
    let nanoseconds = |thread: std::fs::DirEntry| -> Option<f64> {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse().ok()
    };
    1e-9 * threads.flatten().filter_map(nanoseconds).sum::<f64>()
}
