//! Small files of every format, made here so that the tests mean something without any other data.
#![allow(dead_code, reason = "each test file uses its part")]

use std::io::Write;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use vr_core::{Voxel, with_grid};
use vr_io::Loaded;

/// Voxels along x, y and z.
pub const DIMS: [usize; 3] = [4, 3, 2];
/// Voxels in all.
pub const COUNT: usize = 24;

/// A voxel that tells its place and fits every type.
pub fn sample(i: usize) -> i64 {
    (i * 5 % 127) as i64
}

/// The voxels as 16-bit integers.
pub fn i16_bytes(big: bool) -> Vec<u8> {
    let bytes = |i| if big { (sample(i) as i16).to_be_bytes() } else { (sample(i) as i16).to_le_bytes() };
    (0..COUNT).flat_map(bytes).collect()
}

/// Voxels that any of these files must give.
pub fn expected() -> Vec<f32> {
    (0..COUNT).map(|i| sample(i) as f32).collect()
}

/// The stored voxels of a volume that was read.
pub fn stored(loaded: &Loaded) -> Vec<f32> {
    with_grid!(loaded.volume.grid().unwrap().values(), g => g.samples().iter().map(|s| s.to_f32()).collect())
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut e = GzEncoder::new(Vec::new(), Compression::default());
    e.write_all(bytes).unwrap();
    e.finish().unwrap()
}

pub fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut e = ZlibEncoder::new(Vec::new(), Compression::default());
    e.write_all(bytes).unwrap();
    e.finish().unwrap()
}

pub fn bzip2(bytes: &[u8]) -> Vec<u8> {
    let mut e = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
    e.write_all(bytes).unwrap();
    e.finish().unwrap()
}

/// An NRRD file: some fields, and the data behind them.
pub fn nrrd(fields: &str, data: &[u8]) -> Vec<u8> {
    let mut file = format!("NRRD0005\n# a comment\ndimension: 3\nsizes: 4 3 2\n{fields}\n\n").into_bytes();
    file.extend(data);
    file
}

/// A MetaImage file: some fields, and the data behind them.
pub fn metaimage(fields: &str, data_file: &str, data: &[u8]) -> Vec<u8> {
    let mut file = format!("ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\n{fields}\nElementDataFile = {data_file}\n")
        .into_bytes();
    file.extend(data);
    file
}

/// Writes numbers into a header at their offsets, in one byte order.
struct Put {
    bytes: Vec<u8>,
    big: bool,
}

macro_rules! put {
    ($($name:ident: $t:ty),*) => {$(
        fn $name(&mut self, offset: usize, x: $t) {
            let b = if self.big { x.to_be_bytes() } else { x.to_le_bytes() };
            self.bytes[offset..offset + b.len()].copy_from_slice(&b);
        }
    )*};
}

impl Put {
    put!(i16: i16, i32: i32, i64: i64, f32: f32, f64: f64);
}

/// A NIfTI-1 header and its four flag bytes; 16-bit voxels, an sform with spacing 1, 2, 3 at (10, 20, 30).
pub fn nifti_1(big: bool, magic: &[u8; 4]) -> Vec<u8> {
    let mut p = Put { bytes: vec![0; 352], big };
    p.i32(0, 348);
    for (i, n) in [3, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        p.i16(40 + 2 * i, n);
    }
    p.i16(70, 4);
    p.i16(72, 16);
    for (i, s) in [1.0, 1.0, 2.0, 3.0, 1.0, 1.0, 1.0, 1.0].into_iter().enumerate() {
        p.f32(76 + 4 * i, s);
    }
    p.f32(108, if magic == b"n+1\0" { 352.0 } else { 0.0 });
    p.bytes[123] = 2;
    p.i16(254, 1);
    for (row, (step, origin)) in [(1.0, 10.0), (2.0, 20.0), (3.0, 30.0)].into_iter().enumerate() {
        p.f32(280 + 16 * row + 4 * row, step);
        p.f32(280 + 16 * row + 12, origin);
    }
    p.bytes[344..348].copy_from_slice(magic);
    p.bytes
}

/// The same as a NIfTI-2 header.
pub fn nifti_2(big: bool) -> Vec<u8> {
    let mut p = Put { bytes: vec![0; 544], big };
    p.i32(0, 540);
    p.bytes[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
    p.i16(12, 4);
    p.i16(14, 16);
    for (i, n) in [3, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        p.i64(16 + 8 * i, n);
    }
    for (i, s) in [1.0, 1.0, 2.0, 3.0, 1.0, 1.0, 1.0, 1.0].into_iter().enumerate() {
        p.f64(104 + 8 * i, s);
    }
    p.i64(168, 544);
    p.i32(500, 2);
    p.i32(348, 1);
    for (row, (step, origin)) in [(1.0, 10.0), (2.0, 20.0), (3.0, 30.0)].into_iter().enumerate() {
        p.f64(400 + 32 * row + 8 * row, step);
        p.f64(400 + 32 * row + 24, origin);
    }
    p.bytes
}

/// Puts one after the other.
pub fn join(mut a: Vec<u8>, b: &[u8]) -> Vec<u8> {
    a.extend(b);
    a
}
