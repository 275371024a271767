//! Threads of a command.

use std::num::NonZero;
use std::thread::available_parallelism;

use vr_core::Control;

use crate::console::Console;
use crate::failure::Failure;

/// Returns a control with threads of its own: as many as were asked for, else one for each processor, or as many of these as can be started,
/// which is said.
///
/// # Errors
/// [`Failure::Failed`] where the threads that were asked for cannot be started, or not a single one.
pub fn control(asked: Option<u16>, console: Console) -> Result<Control, Failure> {
    if let Some(threads) = asked {
        return Control::default()
            .try_with_threads(threads.into())
            .map_err(|e| Failure::failed(format!("--threads: {e}")));
    }
    let processors = available_parallelism().map_or(1, NonZero::get);
    let mut threads = processors;
    loop {
        match Control::default().try_with_threads(threads) {
            Ok(control) => {
                if threads < processors {
                    console.note(&format!("{threads} of {processors} threads are used: the system starts no more"));
                }
                return Ok(control);
            }
            Err(e) if threads == 1 => return Err(Failure::failed(e)),
            Err(_) => threads /= 2,
        }
    }
}
