//! Vector instructions that kernels run on.

use fearless_simd::Level;

use crate::caster::Vector;

/// Returns the level that a caster asks for; `None` if it asks for no vectors.
pub(crate) fn of(vector: Vector) -> Option<Level> {
    let best = Level::new();
    match vector {
        Vector::Off => None,
        Vector::Auto => Some(best),
        Vector::Baseline => Some(Level::baseline()),
        #[cfg(target_arch = "x86_64")]
        Vector::Avx2 => Some(best.as_avx2().map_or(best, Level::Avx2)),
        #[cfg(not(target_arch = "x86_64"))]
        Vector::Avx2 => Some(best),
    }
}
