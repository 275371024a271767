//! Ctrl-C, and threads that cannot be started.
#![cfg(unix)]

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::harness::Vr;

/// Runs a command, sends it SIGINT after a while, and returns its exit code, what it wrote to stderr, and the time that it took to end.
fn interrupted(vr: &Vr, arguments: &str, after: Duration) -> (Option<i32>, String, Duration) {
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let mut process = vr.command(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    sleep(after);
    assert!(process.try_wait().unwrap().is_none(), "{arguments:?} has ended by itself");
    let sent = Command::new("kill").args(["-INT", &process.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let since = Instant::now();
    let output = process.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap(), since.elapsed())
}

#[test]
fn every_command_ends_soon_and_leaves_nothing() {
    let vr = Vr::new();
    // Half a gibibyte of zeros in half a mebibyte: nothing looks at a flag while it is unpacked.
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    let zeros = vec![0; 1 << 20];
    for _ in 0..1 << 9 {
        std::io::Write::write_all(&mut packed, &zeros).unwrap();
    }
    vr.write("zeros_1024x1024x512_uint8.raw.gz", packed.finish().unwrap());
    let before = vr.files();
    for (arguments, after) in [
        // Rays of 5·10⁷ steps: more are refused.
        ("render --renderer raycast --set step=2e-6 --set leaping=none --set vector=off --size 8 --error none", 1000),
        ("render zeros_1024x1024x512_uint8.raw.gz --size 16", 150),
        ("report --suite hard --no-cache --untimed -o r", 700),
        ("verify --no-cache", 1000),
    ] {
        let (code, stderr, time) = interrupted(&vr, arguments, Duration::from_millis(after));
        assert_eq!(code, Some(130), "{arguments}: {stderr}");
        // A reader says which file it was at.
        let says = |line: &str| line.starts_with("error: ") && line.contains("cancelled");
        assert!(stderr.lines().any(says), "{arguments}: {stderr}");
        // Half a second is promised to a person; a machine that runs other tests beside this one has less.
        assert!(time < Duration::from_secs(3), "{arguments}: {time:?}");
        std::fs::remove_dir_all(vr.folder().join("r")).ok();
        assert_eq!(vr.files(), before, "{arguments}");
    }
}

#[test]
fn threads_that_cannot_be_started_are_an_error() {
    let vr = Vr::new();
    // Large stacks: there is no room for the third, and enough for all else.
    let limited = |flags: &str, stack: &str| {
        let script =
            format!("ulimit -v 900000; exec {} render --size 4 --error none {flags}", env!("CARGO_BIN_EXE_vr"));
        let mut shell = Command::new("sh");
        shell.args(["-c", &script]).env("RUST_MIN_STACK", stack).current_dir(vr.folder()).output().unwrap()
    };
    let refused = limited("--threads 8", "268435456");
    let stderr = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(1), "{stderr}");
    assert!(stderr.starts_with("error: --threads: 8 threads cannot be started"), "{stderr}");
    assert_eq!(limited("--threads 2", "2097152").status.code(), Some(0));
}
