//! Files that are no files, that have strange names, or that have strange words in them.
#![cfg(unix)]

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Stdio};

use crate::harness::Vr;

/// Places of files on the command line, each with the name of a file that would do.
const INPUTS: [&str; 8] = [
    "info @",
    "render @ --size 4",
    "render --scene @ --size 4",
    "render --mesh @ --size 4",
    "render --transfer @ --size 4",
    "animate @",
    "diff @ @",
    "report --baseline @ -o r",
];

#[test]
fn devices_and_pipes_are_refused_by_their_kind() {
    let vr = Vr::new();
    assert!(Command::new("mkfifo").arg(vr.folder().join("pipe")).status().unwrap().success());
    for (file, kind) in [("./pipe", "a pipe"), ("/dev/zero", "a device"), (".", "a folder")] {
        // A folder may be a volume, and a word without an extension a preset.
        let others = ["info @", "render @ --size 4", "render --transfer @ --size 4"];
        for input in INPUTS.iter().filter(|input| file != "." || !others.contains(input)) {
            let command = input.replace('@', file);
            let run = vr.run(&command);
            assert_ne!(run.code, 0, "{command}");
            assert!(run.stderr.contains(&format!("is {kind}; must be a regular file")), "{command}: {}", run.stderr);
        }
    }
    assert_eq!(vr.files(), ["pipe"]);
}

#[test]
fn names_are_bytes() {
    let vr = Vr::new();
    let name = OsStr::from_bytes(b"caf\xe9.nrrd");
    let picture = OsStr::from_bytes(b"caf\xe9.png");
    let run = |arguments: &[&OsStr]| {
        let output = vr.command(&[]).args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let word = OsStr::new;
    run(&[word("convert"), word("--phantom"), word("blobs"), word("--phantom-size"), word("8"), word("-o"), name]);
    run(&[word("info"), name]);
    run(&[word("render"), name, word("--size"), word("8"), word("-o"), picture]);
    run(&[word("diff"), picture, picture]);
    assert!(vr.folder().join(picture).exists());
}

#[test]
fn nothing_in_a_file_reaches_the_terminal_as_it_is() {
    let vr = Vr::new();
    vr.write("a.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ncontent: \x1b[2J\ndata file: \x1b]0;x\x07.raw\n");
    vr.write("b.nhdr", "NRRD0004\ntype: \x1b[31mred\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: b.raw\n");
    vr.write("c.toml", "[volume]\n\"\\u001b[31m\" = 1\n");
    vr.write("\x1b[31m.nrrd", "NRRD0004\n");
    vr.write("d.csv", "x,y,z,\x1b[31mvalue\n1,2,3,4\n2,3,4,\x1b[31m\n");
    for command in [
        ["info", "a.nhdr"],
        ["info", "b.nhdr"],
        ["render", "--scene=c.toml"],
        ["info", "\x1b[31m.nrrd"],
        ["info", "d.csv"],
        ["info", "\u{202e}gpj.nrrd"],
    ] {
        let output = vr.command(&command).stdin(Stdio::null()).output().unwrap();
        let printed = [output.stdout, output.stderr].concat();
        let printed = String::from_utf8(printed).unwrap();
        assert!(
            !printed.contains(|c: char| c.is_control() && c != '\n' || c == '\u{202e}'),
            "{command:?}: {printed:?}"
        );
        assert!(printed.contains("\\u{1b}") || printed.contains("\\u{202e}"), "{command:?}: {printed:?}");
    }
}

#[test]
fn texts_have_a_limit() {
    let vr = Vr::new();
    let long = format!("# {}\n", "x".repeat(1 << 24));
    vr.write("long.toml", long);
    for command in ["render --scene long.toml", "animate long.toml", "render --transfer long.toml"] {
        let error = vr.run(command).failed(1);
        assert!(error.contains("at most 16777216 are read of such a file"), "{command}: {error}");
    }
}
