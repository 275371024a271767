//! Meter of the memory that a piece of work takes.

/// Meter of the heap in use. The program that runs a study has one where its allocator counts.
pub trait MemoryMeter: Sync {
    /// Returns the number of bytes in use now.
    fn current(&self) -> usize;

    /// Returns the largest number of bytes in use since the last [`reset`](Self::reset).
    fn peak(&self) -> usize;

    /// Sets the peak to the bytes in use now.
    fn reset(&self);
}

/// Runs work; returns its result and, where there is a meter, the largest number of bytes in use beyond those before.
pub fn peak_of<T>(meter: Option<&dyn MemoryMeter>, work: impl FnOnce() -> T) -> (T, Option<u64>) {
    let before = meter.map(|m| {
        m.reset();
        m.current()
    });
    let result = work();
    let peak = meter.zip(before).map(|(m, before)| m.peak().saturating_sub(before) as u64);
    (result, peak)
}
