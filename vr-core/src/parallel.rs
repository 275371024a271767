//! Loops over parts of an array on rayon's current threads. Rayon's own code is compiled here, once, and not anew for each closure: a
//! loop elsewhere costs the compiler a fiftieth of what a parallel iterator does.
//!
//! Each loop asks for the current cancel flag with each part ([`crate::cancel`]), and has it be current on the threads that it runs on.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use crate::cancel::CancelToken;
use crate::error::RenderError;

/// Locks a mutex, whether or not a thread has panicked with it.
pub fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls `piece` for `0 .. count`, one a task, until one fails.
///
/// # Errors
/// Returns the error of a piece that failed, or [`RenderError::Cancelled`].
pub fn try_each(count: usize, piece: &(dyn Fn(usize) -> Result<(), RenderError> + Sync)) -> Result<(), RenderError> {
    let token = CancelToken::current();
    (0..count).into_par_iter().with_max_len(1).try_for_each(|i| {
        let _entered = token.enter();
        token.check()?;
        piece(i)
    })
}

/// Calls `piece` for `0 .. count`; neighbours may share a task.
pub fn each(count: usize, piece: &(dyn Fn(usize) + Sync)) {
    let token = CancelToken::current();
    (0..count).into_par_iter().for_each_init(
        || token.enter(),
        |_entered, i| {
            // What is left of a cancelled loop is passed over; it unwinds once, at its end, rather than in each task.
            if !token.is_cancelled() {
                piece(i);
            }
        },
    );
    token.poll();
}

/// Does two things, side by side where a thread is free.
pub fn join<A: Send, B: Send>(a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
    let token = CancelToken::current();
    token.poll();
    rayon::join(
        || {
            let _entered = token.enter();
            a()
        },
        || {
            let _entered = token.enter();
            b()
        },
    )
}

/// Calls `work` with the number of each part, and the part.
pub fn each_part<T: Send>(parts: impl IntoIterator<Item = T>, work: impl Fn(usize, &mut T) + Sync) {
    let parts: Vec<Mutex<T>> = parts.into_iter().map(Mutex::new).collect();
    each(parts.len(), &|i| work(i, &mut locked(&parts[i])));
}

/// Makes a value for each of `0 .. count`; returns them in order.
pub fn collect<T: Send + Default>(count: usize, make: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut made: Vec<T> = std::iter::repeat_with(T::default).take(count).collect();
    // Large enough that a task's cost does not count, small enough to balance.
    let length = count.div_ceil(64 * rayon::current_num_threads()).max(1);
    each_part(made.chunks_mut(length), |part, made| {
        for (i, made) in made.iter_mut().enumerate() {
            *made = make(part * length + i);
        }
    });
    made
}

/// Makes a value for each of `0 .. count`, several at a time; returns them in order.
///
/// # Errors
/// Returns the error of the first of `0 .. count` that failed, whichever fails earlier in time: the same one in each run.
pub fn try_collect<T: Send, E: Send>(count: usize, make: impl Fn(usize) -> Result<T, E> + Sync) -> Result<Vec<T>, E> {
    let first_failure = AtomicUsize::new(usize::MAX);
    let made = collect(count, |i| {
        // Nothing behind a failure is needed.
        (i < first_failure.load(Ordering::Relaxed)).then(|| {
            let made = make(i);
            if made.is_err() {
                first_failure.fetch_min(i, Ordering::Relaxed);
            }
            made
        })
    });
    made.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_is_met_once_and_in_its_place() {
        for count in [0, 1, 7, 1000] {
            assert_eq!(collect(count, |i| i), (0..count).collect::<Vec<_>>());
            let mut values = vec![1; count];
            each_part(values.chunks_mut(3), |part, values| values.iter_mut().for_each(|v| *v += part));
            assert!(values.iter().enumerate().all(|(i, &v)| v == 1 + i / 3));
        }
        for failing in [0, 5, 99, 500] {
            let made = try_collect(100, |i| if i >= failing { Err(i) } else { Ok(i) });
            assert_eq!(made, if failing < 100 { Err(failing) } else { Ok((0..100).collect()) });
        }
        let stopped = try_each(9, &|i| if i == 5 { Err(RenderError::Cancelled) } else { Ok(()) });
        assert!(matches!(stopped, Err(RenderError::Cancelled)));
    }
}
