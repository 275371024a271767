//! Meter of the heap in use.

use peak_alloc::PeakAlloc;
use vr_study::memory::MemoryMeter;

/// Allocator of the system, with counts.
#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Meter that asks the allocator.
pub struct Heap;

impl MemoryMeter for Heap {
    fn current(&self) -> usize {
        HEAP.current_usage()
    }

    fn peak(&self) -> usize {
        HEAP.peak_usage()
    }

    fn reset(&self) {
        HEAP.reset_peak_usage();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_in_use_for_a_while_is_seen() {
        // Other tests take and free memory of their own meanwhile, by far not as much as this,
        // which is reserved and never touched.
        let size = 256 << 20;
        Heap.reset();
        let before = Heap.current();
        drop(std::hint::black_box(Vec::<u8>::with_capacity(size)));
        assert!(Heap.peak() >= before + size / 2);
        assert!(Heap.current() < before + size / 2);
    }
}
