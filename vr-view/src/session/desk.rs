//! Desk of a session, at which its callers and what draws for them meet: the document, what is being worked on, and what has become stale.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard};

use vr_core::Control;
use vr_core::clock::Instant;
use vr_core::parallel::locked;

use super::document::Document;
use super::output::Output;
use super::picture::ClientId;

/// Desk, and the ways to be told of it.
pub(super) struct Shared {
    pub(super) state: Mutex<Desk>,
    pub(super) wake: Condvar,
    pub(super) tell: Box<dyn Fn(Output) + Send + Sync>,
    /// Tells, without a thread of its own, that the caller has an edit to make.
    pub(super) interrupted: Option<Box<dyn Fn() -> bool + Send + Sync>>,
}

/// State that the thread and the callers share.
pub(super) struct Desk {
    pub(super) document: Document,
    /// Counts edits that change the picture.
    pub(super) revision: u64,
    pub(super) last_edit: Instant,
    pub(super) answers: BTreeMap<ClientId, u64>,
    /// Cancel flag of the work that an edit makes stale.
    pub(super) stale: Option<Arc<AtomicBool>>,
    /// Cancel flags of answers in the making, which an edit makes stale, too.
    pub(super) asked: Vec<Arc<AtomicBool>>,
    /// Cancel flags of slices in the making, which moves and looks leave as they are.
    pub(super) sliced: Vec<Arc<AtomicBool>>,
    /// Cancel flag of any work.
    pub(super) working: Option<Arc<AtomicBool>>,
    pub(super) ended: bool,
}

impl Shared {
    pub(super) fn new(
        document: Document,
        tell: impl Fn(Output) + Send + Sync + 'static,
        interrupted: Option<Box<dyn Fn() -> bool + Send + Sync>>,
    ) -> Self {
        let desk = Desk {
            document,
            revision: 1,
            last_edit: Instant::now(),
            answers: BTreeMap::new(),
            stale: None,
            asked: Vec::new(),
            sliced: Vec::new(),
            working: None,
            ended: false,
        };
        Self { state: Mutex::new(desk), wake: Condvar::new(), tell: Box::new(tell), interrupted }
    }

    pub(super) fn desk(&self) -> MutexGuard<'_, Desk> {
        locked(&self.state)
    }

    /// Control of work that is given up as soon as the caller has an edit to make.
    pub(super) fn control(self: &Arc<Self>) -> Control {
        let control = Control::default();
        if self.interrupted.is_none() {
            return control;
        }
        let (shared, flag) = (Arc::clone(self), control.cancel_flag());
        control.with_progress(move |_| {
            if shared.interrupted.as_ref().is_some_and(|interrupted| interrupted()) {
                flag.store(true, Ordering::Relaxed);
            }
        })
    }
}

impl Desk {
    /// Cancels every answer in the making.
    pub(super) fn give_up_answers(&mut self) {
        self.asked.drain(..).for_each(|flag| flag.store(true, Ordering::Relaxed));
    }

    /// Cancels every slice in the making.
    pub(super) fn give_up_slices(&mut self) {
        self.sliced.drain(..).for_each(|flag| flag.store(true, Ordering::Relaxed));
    }
}
