//! Cancellation by Ctrl-C.

use std::sync::atomic::Ordering;

use vr_core::Control;

/// Makes Ctrl-C set the control's cancel flag: the command then ends where it stands, with nothing half written.
pub fn cancels(control: &Control) {
    let flag = control.cancel_flag();
    // Where no handler can be set, Ctrl-C ends the program as it would any other: that is good enough.
    let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
}
