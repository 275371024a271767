//! Control of a running render by its caller: cancellation, progress, number of threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::cancel::{CancelToken, Stopped, catch_stopped};
use crate::error::RenderError;

/// Cancel flag, progress callback and threads. The default never cancels, reports no progress, and uses rayon's global pool.
///
/// # Examples
/// ```
/// use std::sync::atomic::Ordering;
/// use vr_core::{Control, RenderError};
///
/// let control = Control::default().with_threads(2).with_progress(|done| println!("{:.0} %", 100.0 * done));
/// assert_eq!(control.run(|| control.threads()), 2);
/// control.report(0.5);
///
/// // What a signal handler does:
/// control.cancel_flag().store(true, Ordering::Relaxed);
/// assert!(matches!(control.check(), Err(RenderError::Cancelled)));
/// ```
#[derive(Clone, Default)]
pub struct Control {
    cancel: Arc<AtomicBool>,
    progress: Option<Arc<dyn Fn(f64) + Send + Sync>>,
    pool: Option<Arc<rayon::ThreadPool>>,
}

/// Threads that the system does not start.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{threads} threads cannot be started: {reason}; ask for fewer, or raise the limit on processes or memory")]
pub struct ThreadError {
    /// Number of threads that were asked for.
    pub threads: usize,
    /// The system's reason.
    pub reason: String,
}

impl std::fmt::Debug for Control {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("cancelled", &self.is_cancelled()).finish_non_exhaustive()
    }
}

impl Control {
    /// Uses a pool of `threads` threads of its own (at least one).
    ///
    /// # Panics
    /// If the system cannot start threads; [`Self::try_with_threads`] does not.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        self.try_with_threads(threads).expect("threads can be started")
    }

    /// Uses a pool of `threads` threads of its own (at least one).
    ///
    /// # Errors
    /// [`ThreadError`] where the system starts fewer: its limits on processes or memory.
    pub fn try_with_threads(mut self, threads: usize) -> Result<Self, ThreadError> {
        let threads = threads.max(1);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        self.pool = Some(Arc::new(pool.map_err(|e| ThreadError { threads, reason: e.to_string() })?));
        Ok(self)
    }

    /// Calls back with the fraction done, in [0, 1], from any thread.
    #[must_use]
    pub fn with_progress(mut self, progress: impl Fn(f64) + Send + Sync + 'static) -> Self {
        self.progress = Some(Arc::new(progress));
        self
    }

    /// The flag that cancels when set to true; hand it to a signal handler, say.
    pub fn cancel_flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.cancel)
    }

    /// True if the cancel flag is set.
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// Returns an error if the cancel flag is set.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub fn check(&self) -> Result<(), RenderError> {
        if self.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(()) }
    }

    /// Reports the fraction of the work that is done.
    pub fn report(&self, fraction: f64) {
        if let Some(progress) = &self.progress {
            progress(fraction);
        }
    }

    /// Number of threads that work runs on.
    pub fn threads(&self) -> usize {
        self.pool.as_ref().map_or_else(rayon::current_num_threads, |pool| pool.current_num_threads())
    }

    /// Runs work on this control's threads.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        let (mut work, mut made) = (Some(work), None);
        self.install(&mut || made = work.take().map(|work| work()));
        made.expect("the pool ran it")
    }

    /// Runs work as [`Self::run`] does, and ends it soon after the cancel flag is set, wherever it stands: while it reads a file, while it
    /// derives structures from a volume ([`crate::cancel`]). What the work holds is dropped. Structures for which there is too little memory
    /// end it, too. Where a panic aborts, as in a browser, nothing unwinds: work ends early where it asks this control itself.
    ///
    /// # Errors
    /// [`Stopped`]. Work that ends by itself after the flag is set, with an error of its own or without, has its value returned.
    ///
    /// # Examples
    /// ```
    /// use std::sync::atomic::Ordering;
    /// use vr_core::{Control, cancel, parallel};
    ///
    /// let control = Control::default();
    /// assert_eq!(control.cancellable(|| parallel::collect(3, |i| i)), Ok(vec![0, 1, 2]));
    /// control.cancel_flag().store(true, Ordering::Relaxed);
    /// assert_eq!(control.cancellable(|| parallel::collect(3, |i| i)), Err(cancel::Cancelled.into()));
    /// ```
    pub fn cancellable<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, Stopped> {
        if cfg!(panic = "abort") {
            return Ok(self.run(work));
        }
        let token = CancelToken::new(&self.cancel);
        self.run(|| {
            let _entered = token.enter();
            catch_stopped(|| Ok(work()))
        })
    }

    /// Does what [`Self::run`] does; compiled once, not anew for each closure.
    fn install(&self, work: &mut (dyn FnMut() + Send)) {
        match &self.pool {
            Some(pool) => {
                let token = CancelToken::current();
                pool.install(|| {
                    let _entered = token.enter();
                    work();
                });
            }
            None => work(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_runs_on_as_many_threads_as_it_says() {
        let control = Control::default().with_threads(3);
        assert_eq!((control.threads(), control.run(rayon::current_num_threads)), (3, 3));
        assert_eq!(Control::default().threads(), rayon::current_num_threads());
    }
}
