//! Memory that reading takes beside what is read.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use peak_alloc::PeakAlloc;
use vr_io::{ReadOptions, read};

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Memory that a reader may take beside the bytes that it inflates.
const BESIDE: usize = 64 << 20;

#[test]
fn inflating_takes_little_beside_the_voxels() {
    let folder = tempfile::tempdir().unwrap();
    // Noise in its low bits, and zeros after it: members that pack well and badly.
    let bytes: usize = 1 << 27;
    let path = folder.path().join("x_512x512x512_uint8.raw.gz");
    let mut packed = GzEncoder::new(std::fs::File::create(&path).unwrap(), Compression::fast());
    let noise: Vec<u8> = (0..1u32 << 20).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    for i in 0..bytes / noise.len() {
        packed.write_all(&if i % 2 == 0 { noise.clone() } else { vec![0; noise.len()] }).unwrap();
    }
    packed.finish().unwrap();
    drop(noise);
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    let loaded = read(&path, &ReadOptions::default()).unwrap();
    let peak = HEAP.peak_usage() - before;
    assert_eq!(loaded.volume.grid().unwrap().dims(), [512; 3]);
    println!("{bytes} bytes inflated: a peak of {peak}");
    assert!((bytes..bytes + BESIDE).contains(&peak), "{peak} bytes for {bytes}");
}
