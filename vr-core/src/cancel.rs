//! Early ends of work that is handed no control: reading and decoding files, and deriving structures from a volume.
//!
//! [`Control::cancellable`](crate::Control::cancellable) makes a control's cancel flag the current one of the threads that its work runs on.
//! Readers ask for it with each block and end with the error [`Cancelled`]. Work that cannot fail (the coefficients of a prefilter, a tree of
//! boxes) asks for it with each part, and for memory before it allocates any ([`claim`]); it unwinds to `cancellable` with a [`Stopped`], as a
//! panic would but without a message. All of it that is under way is dropped, and what is kept for later ([`Derived`](crate::Derived)) is made
//! anew when it is asked for again. Outside of `cancellable`, no flag is current and nothing unwinds.

use std::cell::RefCell;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::memory::{self, MemoryError};

thread_local! {
    static CURRENT: RefCell<CancelToken> = const { RefCell::new(CancelToken(None)) };
}

/// Error of work that the caller has cancelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

impl From<Cancelled> for io::Error {
    fn from(cancelled: Cancelled) -> Self {
        // Not `Interrupted`, upon which `Read::read_to_end` and its like try again.
        Self::other(cancelled)
    }
}

/// The reason why work that cannot fail has ended early.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Stopped {
    /// The caller set the cancel flag.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// Too little memory for what was to be derived.
    #[error(transparent)]
    Memory(#[from] MemoryError),
}

impl Stopped {
    /// Unwinds to the nearest [`catch_stopped`].
    fn unwind(self) -> ! {
        resume_unwind(Box::new(self))
    }
}

/// Cancel flag of the work that a thread is busy with; none outside of [`Control::cancellable`](crate::Control::cancellable).
#[derive(Clone, Debug, Default)]
pub struct CancelToken(Option<Arc<AtomicBool>>);

impl CancelToken {
    /// Returns the flag that is current on this thread.
    pub fn current() -> Self {
        CURRENT.with_borrow(Clone::clone)
    }

    pub(crate) fn new(flag: &Arc<AtomicBool>) -> Self {
        Self(Some(Arc::clone(flag)))
    }

    /// True if a flag is current: inside of [`Control::cancellable`](crate::Control::cancellable).
    pub(crate) fn is_set(&self) -> bool {
        self.0.is_some()
    }

    /// True if the work is cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }

    /// Returns an error if the work is cancelled.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.is_cancelled() { Err(Cancelled) } else { Ok(()) }
    }

    /// Unwinds to [`Control::cancellable`](crate::Control::cancellable) if the work is cancelled.
    pub fn poll(&self) {
        if self.is_cancelled() {
            Stopped::from(Cancelled).unwind();
        }
    }

    /// Makes this the current flag of the thread, until the guard is dropped.
    pub(crate) fn enter(&self) -> Entered {
        Entered(CURRENT.replace(self.clone()))
    }
}

/// Stay of a thread with a flag; the former one is current again afterwards.
pub(crate) struct Entered(CancelToken);

impl Drop for Entered {
    fn drop(&mut self) {
        CURRENT.set(std::mem::take(&mut self.0));
    }
}

/// Unwinds to [`Control::cancellable`](crate::Control::cancellable) if the current work is cancelled: for long loops that run on one thread.
pub fn poll() {
    CURRENT.with_borrow(CancelToken::poll);
}

/// Poll of a loop whose turns are too short for one each.
///
/// # Examples
/// ```
/// use vr_core::Control;
/// use vr_core::cancel::SparsePoll;
///
/// let control = Control::default();
/// control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
/// let (mut poll, mut turns) = (SparsePoll::default(), 0);
/// let outcome = control.cancellable(|| loop {
///     poll.turn();
///     turns += 1;
/// });
/// assert!(outcome.map(|never: ()| never).is_err() && turns == SparsePoll::TURNS - 1);
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct SparsePoll(u32);

impl SparsePoll {
    /// Turns from one look at the flag to the next: enough that a look does not count, where a turn takes ten nanoseconds.
    pub const TURNS: u32 = 64;

    /// Counts a turn, and does what [`poll`] does in one of [`Self::TURNS`].
    #[inline]
    pub fn turn(&mut self) {
        self.0 += 1;
        if self.0 == Self::TURNS {
            self.0 = 0;
            poll();
        }
    }
}

/// Asks for memory on behalf of work that cannot fail; unwinds to [`Control::cancellable`](crate::Control::cancellable) if there is too
/// little. Outside of it, the work goes on as if no meter were set.
pub fn claim(what: &str, bytes: u64) {
    if CancelToken::current().is_set()
        && let Err(refused) = memory::check(what, bytes)
    {
        Stopped::from(refused).unwind();
    }
}

/// Runs work and gives its value, or an error where it unwinds because it has to end early: for callers who have more to say about that, or
/// something to put in order. A panic goes on.
///
/// # Errors
/// Those of the work, and [`Stopped`].
pub fn catch_stopped<T, E: From<Stopped>>(work: impl FnOnce() -> Result<T, E>) -> Result<T, E> {
    // Nothing that is left half done is used afterwards: the caller gets none of it, and caches are filled by whole values.
    let outcome = catch_unwind(AssertUnwindSafe(work));
    outcome.unwrap_or_else(|payload| match payload.downcast::<Stopped>() {
        Ok(stopped) => Err((*stopped).into()),
        Err(panic) => resume_unwind(panic),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Control, Derived, parallel};

    #[test]
    fn work_that_cannot_fail_ends_early_and_what_is_derived_is_made_anew() {
        let control = Control::default().with_threads(3);
        let flag = control.cancel_flag();
        let derived = Derived::default();
        let make = |cancels_at: usize| {
            derived.get(0u8, || {
                parallel::collect(1000, |i| {
                    flag.fetch_or(i == cancels_at, Ordering::Relaxed);
                    i
                })
            })
        };
        assert_eq!(control.cancellable(|| make(700).len()), Err(Cancelled.into()));
        flag.store(false, Ordering::Relaxed);
        assert_eq!(*control.cancellable(|| make(usize::MAX)).unwrap(), (0..1000).collect::<Vec<_>>());
    }

    #[test]
    fn a_loop_stops_at_its_next_part() {
        let control = Control::default().with_threads(2);
        let flag = control.cancel_flag();
        let met = std::sync::atomic::AtomicUsize::new(0);
        let outcome = control.cancellable(|| {
            parallel::each(1 << 20, &|_| {
                met.fetch_add(1, Ordering::Relaxed);
                flag.store(true, Ordering::Relaxed);
            });
        });
        // Each thread may be in the middle of one.
        assert!(outcome.is_err() && met.into_inner() <= 2);
    }

    #[test]
    fn nothing_unwinds_outside_and_no_flag_stays_behind() {
        let control = Control::default().with_threads(1);
        control.cancel_flag().store(true, Ordering::Relaxed);
        let seen = || CancelToken::current().is_cancelled();
        assert_eq!(control.cancellable(seen), Ok(true));
        // Another control's work inside is its own; afterwards the outer one is current again.
        let inner = Control::default();
        assert_eq!(control.cancellable(|| (inner.cancellable(seen), seen())), Ok((Ok(false), true)));
        assert_eq!(control.cancellable(poll), Err(Cancelled.into()));
        assert!(!control.run(seen) && !seen());
        control.run(|| parallel::each(10, &|_| poll()));
        poll();
    }

    #[test]
    fn threads_of_another_pool_have_the_same_flag() {
        let (outer, inner) = (Control::default().with_threads(1), Control::default().with_threads(2));
        outer.cancel_flag().store(true, Ordering::Relaxed);
        assert_eq!(outer.cancellable(|| inner.run(|| CancelToken::current().is_cancelled())), Ok(true));
        assert_eq!(outer.cancellable(|| inner.run(|| parallel::join(|| (), || ()))), Err(Cancelled.into()));
    }

    #[test]
    fn a_panic_is_no_early_end() {
        let control = Control::default();
        let outcome = catch_unwind(AssertUnwindSafe(|| control.cancellable(|| resume_unwind(Box::new("a panic")))));
        assert_eq!(*outcome.unwrap_err().downcast::<&str>().unwrap(), "a panic");
        control.cancel_flag().store(true, Ordering::Relaxed);
        let caught = || {
            catch_stopped(|| {
                poll();
                Ok::<_, Stopped>(())
            })
        };
        assert_eq!(control.cancellable(caught), Ok(Err(Cancelled.into())));
    }
}
