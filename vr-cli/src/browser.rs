//! The system's browser.

use std::process::{Command, Stdio};
use std::thread;

/// Opens an address in the system's browser; false where there is none, as on a server without a screen.
pub fn open(address: &str) -> bool {
    let has_screen = cfg!(any(target_os = "macos", windows))
        || ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some_and(|v| !v.is_empty()));
    let (program, before): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(before).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    match has_screen.then(|| command.spawn()) {
        Some(Ok(mut child)) => {
            // Without a wait, it would stay as a zombie.
            thread::spawn(move || child.wait());
            true
        }
        _ => false,
    }
}
