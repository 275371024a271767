//! Drawing of a session that has no thread, step by step.

use std::sync::Arc;
use std::time::Duration;

use super::engine::{Due, Engine};

/// Draws the pictures of a session that has no thread.
pub struct Painter(pub(super) Engine);

/// Outcome of a step of a [`Painter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A stage was drawn, or given up for an edit: there may be another one.
    Worked,
    /// The next stage is drawn when no edit has come for so much longer.
    Wait(Duration),
    /// Nothing is left to do before the next edit.
    Idle,
}

impl Painter {
    /// Draws one stage, if one is due.
    pub fn step(&mut self) -> Step {
        let shared = Arc::clone(&self.0.shared);
        let due = self.0.due(&mut shared.desk());
        match due {
            Due::Work(job) => {
                self.0.do_job(&job);
                Step::Worked
            }
            Due::Wait(time) => Step::Wait(time),
            Due::Idle | Due::End => Step::Idle,
        }
    }
}
