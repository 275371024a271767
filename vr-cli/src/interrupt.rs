//! Cancellation by Ctrl-C.

use std::process;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use vr_core::Control;

use crate::console::Console;
use crate::failure::Failure;

/// Exit code of a command that Ctrl-C has ended: 128 and the number of the signal, as shells have it.
pub const EXIT_CODE: u8 = 130;

/// Time that a command has to end by itself. Some of its work asks for the flag less often: a block that is decompressed at once, a file of the
/// system's that does not answer.
const PATIENCE: Duration = Duration::from_millis(400);

/// Makes Ctrl-C set the control's cancel flag: the command then ends where it stands, with nothing half written, and says how it is taken up
/// again. One that does not is ended soon, and at once by a second Ctrl-C; nothing is half written then, either.
pub fn cancels(control: &Control) {
    let flag = control.cancel_flag();
    // Where no handler can be set, Ctrl-C ends the program as it would any other: that is good enough.
    let _ = ctrlc::set_handler(move || {
        let is_second = flag.swap(true, Ordering::Relaxed);
        let watch = || {
            thread::sleep(PATIENCE);
            end()
        };
        if is_second || thread::Builder::new().spawn(watch).is_err() {
            end()
        }
    });
}

/// Ends the program in the middle of its work.
fn end() -> ! {
    vr_io::remove_unfinished();
    Console::error(&Failure::Cancelled("cancelled".into()));
    process::exit(EXIT_CODE.into())
}
