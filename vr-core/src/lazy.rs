//! Values that are computed when they are first asked for.

use std::sync::OnceLock;

/// Returns the value of a cell, computing it if it is not there.
///
/// No lock is held meanwhile, as [`OnceLock::get_or_init`] does: what is computed in parallel may have its thread take up other work while
/// it waits, and that work may ask for the same value. Threads that ask at once compute it more than once; all get the same one.
#[inline]
pub(crate) fn computed<T>(cell: &OnceLock<T>, compute: impl FnOnce() -> T) -> &T {
    match cell.get() {
        Some(value) => value,
        None => {
            let value = compute();
            cell.get_or_init(|| value)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_value_stays_even_where_a_computation_asks_for_it() {
        let cell = OnceLock::new();
        assert_eq!(*computed(&cell, || *computed(&cell, || 1) + 1), 1);
        assert_eq!(*computed(&cell, || unreachable!("it is there")), 1);
    }
}
