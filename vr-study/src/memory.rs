//! Memory that a piece of work takes.

/// Tells how much memory of the heap is in use. The program that runs a study has one where its allocator counts.
pub trait MemoryMeter: Sync {
    /// Bytes in use now.
    fn current(&self) -> usize;

    /// Largest number of bytes in use since the last [`reset`](Self::reset).
    fn peak(&self) -> usize;

    /// Begins anew: the peak is what is in use now.
    fn reset(&self);
}

/// Runs work; returns with its result how many bytes beyond those in use before were needed at once, where there is a meter.
pub fn peak_of<T>(meter: Option<&dyn MemoryMeter>, work: impl FnOnce() -> T) -> (T, Option<u64>) {
    let before = meter.map(|m| {
        m.reset();
        m.current()
    });
    let result = work();
    let peak = meter.zip(before).map(|(m, before)| m.peak().saturating_sub(before) as u64);
    (result, peak)
}
