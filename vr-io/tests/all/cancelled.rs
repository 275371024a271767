//! Reading ends soon after it is cancelled, in the middle of a file.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::Duration;

use flate2::Compression;
use vr_core::Control;
use vr_io::{FileErrorKind, ReadOptions, read, read_points};

/// Bytes of a part of a file of zeros, of which a packed one has as many as make up [`LENGTH`].
const PART: usize = 1 << 26;
/// Bytes that each file stands for: seconds of reading, of which some hundredths are let pass.
const LENGTH: usize = 1 << 31;
const DELAY: Duration = Duration::from_millis(30);

/// Reads in a control's hands, and cancels it after a while.
fn cancelled<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let control = Control::default();
    let flag = control.cancel_flag();
    thread::scope(|scope| {
        scope.spawn(move || {
            thread::sleep(DELAY);
            flag.store(true, Ordering::Relaxed);
        });
        control.cancellable(work).expect("a reader returns its error")
    })
}

fn repeated(folder: &Path, name: &str, part: &[u8]) -> PathBuf {
    let path = folder.join(name);
    let mut file = File::create(&path).unwrap();
    for _ in 0..LENGTH / PART {
        file.write_all(part).unwrap();
    }
    path
}

#[test]
fn large_volumes_end_in_the_middle() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let zeros = vec![0; PART];
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), Compression::fast());
    gzip.write_all(&zeros).unwrap();
    let mut bzip2 = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
    bzip2.write_all(&zeros).unwrap();
    // Sparse, where the system knows such files; not mapped, so that it is read.
    File::create(at("x_2048x1024x1024_uint8.raw")).unwrap().set_len(LENGTH as u64).unwrap();
    let mut text = File::create(at("x.nrrd")).unwrap();
    text.write_all(b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 512 512 512\nencoding: ascii\n\n").unwrap();
    text.write_all("0 ".repeat(1 << 27).as_bytes()).unwrap();
    let files = [
        at("x_2048x1024x1024_uint8.raw"),
        repeated(folder.path(), "gzip_2048x1024x1024_uint8.raw.gz", &gzip.finish().unwrap()),
        repeated(folder.path(), "bzip2_2048x1024x1024_uint8.raw.bz2", &bzip2.finish().unwrap()),
        at("x.nrrd"),
    ];
    let options = ReadOptions { map: false, ..Default::default() };
    for path in files {
        let error = cancelled(|| read(&path, &options)).map(|_| "the whole file was read").unwrap_err();
        assert!(matches!(error.kind, FileErrorKind::Cancelled), "{error}");
        assert!(error.to_string().ends_with(": cancelled while it was read"), "{error}");
    }
}

#[test]
fn nothing_of_a_cancelled_reader_stays_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x_2x2x2_uint8.raw");
    std::fs::write(&path, [7; 8]).unwrap();
    let points = folder.path().join("points.csv");
    std::fs::write(&points, "x,y,z\n0,0,0\n1,1,1\n").unwrap();
    let control = Control::default();
    control.cancel_flag().store(true, Ordering::Relaxed);
    let outcome =
        control.cancellable(|| (read(&path, &ReadOptions::default()), read_points(&points, &Default::default())));
    let (volume, points_read) = outcome.unwrap();
    assert!(matches!(volume.unwrap_err().kind, FileErrorKind::Cancelled));
    assert!(matches!(points_read.unwrap_err().kind, FileErrorKind::Cancelled));
    // Outside, the same files are read.
    assert!(read(&path, &ReadOptions::default()).is_ok() && read_points(&points, &Default::default()).is_ok());
}
