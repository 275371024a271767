//! Small files, written here.

use std::io::Write;

use flate2::{Compression, write::ZlibEncoder};
use glam::DVec3;
use vr_core::{Voxel, with_grid};

use crate::{Loaded, ReadOptions, read};

/// Flags of the packing.
const ZIP: u32 = 1;
const ACTIVE_ALONE: u32 = 2;

fn text(out: &mut Vec<u8>, text: &str) {
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(text.as_bytes());
}

fn bits(count: usize, on: &[usize]) -> Vec<u8> {
    let mut bytes = vec![0; count / 8];
    on.iter().for_each(|&i| bytes[i / 8] |= 1 << (i % 8));
    bytes
}

/// Values of a node whose inactive ones are the background's.
fn values(out: &mut Vec<u8>, flags: u32, all: &[f32], active: &[usize]) {
    let is_short = flags & ACTIVE_ALONE != 0;
    out.push(if is_short { 0 } else { 6 });
    let stored: Vec<f32> = if is_short { active.iter().map(|&i| all[i]).collect() } else { all.to_vec() };
    let bytes: Vec<u8> = stored.iter().flat_map(|v| v.to_le_bytes()).collect();
    if flags & ZIP == 0 {
        out.extend(bytes);
        return;
    }
    let mut zlib = ZlibEncoder::new(Vec::new(), Compression::default());
    zlib.write_all(&bytes).unwrap();
    let packed = zlib.finish().unwrap();
    if packed.len() < bytes.len() {
        out.extend((packed.len() as i64).to_le_bytes());
        out.extend(packed);
    } else {
        out.extend((-(bytes.len() as i64)).to_le_bytes());
        out.extend(bytes);
    }
}

/// Active voxels of the leaf, and the value of each.
const ACTIVE: [usize; 3] = [0, 0o127, 0o700];

fn leaf_value(i: usize) -> f32 {
    i as f32 / 4.0 + 1.0
}

/// A file of two grids: points, which are not read, and floats with a leaf at (−4088, 0, 8) and a tile of 8³ beside it.
fn file(flags: u32, kind: &str) -> Vec<u8> {
    let mut topology = Vec::new();
    topology.extend(flags.to_le_bytes());
    // Metadata: one entry.
    topology.extend(1u32.to_le_bytes());
    text(&mut topology, "class");
    text(&mut topology, "string");
    text(&mut topology, "fog volume");
    text(&mut topology, "ScaleTranslateMap");
    for x in [[10.0, 20.0, 30.0], [0.5, 0.5, 2.0], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]].concat() {
        topology.extend(f64::to_le_bytes(x));
    }
    // One buffer, the background; no tile and one child of the root.
    topology.extend(1u32.to_le_bytes());
    topology.extend((-1f32).to_le_bytes());
    topology.extend([0u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
    topology.extend([-4096i32, 0, 0].map(i32::to_le_bytes).concat());
    // The first of 32³ nodes is there, and of its 16³ the leaf; the tile lies at z = 16.
    topology.extend([bits(1 << 15, &[0]), bits(1 << 15, &[])].concat());
    values(&mut topology, flags, &vec![-1.0; 1 << 15], &[]);
    let (leaf, tile) = (1 << 8 | 1, 1 << 8 | 2);
    topology.extend([bits(1 << 12, &[leaf]), bits(1 << 12, &[tile])].concat());
    let mut inner = vec![-1.0; 1 << 12];
    inner[tile] = 7.5;
    values(&mut topology, flags, &inner, &[tile]);
    topology.extend(bits(512, &ACTIVE));
    let mut buffers = bits(512, &ACTIVE);
    let mut all = vec![-1.0; 512];
    ACTIVE.iter().for_each(|&i| all[i] = leaf_value(i));
    values(&mut buffers, flags, &all, &ACTIVE);

    let mut out = [0x5644_4220u64.to_le_bytes().as_slice(), &224u32.to_le_bytes()].concat();
    out.extend([8u32.to_le_bytes(), 1u32.to_le_bytes()].concat());
    out.push(1);
    out.extend([b'0'; 36]);
    out.extend(0u32.to_le_bytes());
    out.extend(2u32.to_le_bytes());
    text(&mut out, "points");
    text(&mut out, "Tree_ptdataidx32_5_4_3");
    text(&mut out, "");
    let start = out.len() + 24;
    out.extend([start, start + 4, start + 4].map(|n| (n as i64).to_le_bytes()).concat());
    out.extend(0u32.to_le_bytes());
    text(&mut out, "density");
    text(&mut out, kind);
    text(&mut out, "");
    let start = out.len() + 24;
    let places = [start, start + topology.len(), start + topology.len() + buffers.len()];
    out.extend(places.map(|n| (n as i64).to_le_bytes()).concat());
    out.extend(topology);
    out.extend(buffers);
    out
}

fn load(bytes: &[u8]) -> Result<Loaded, crate::FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.vdb");
    std::fs::write(&path, bytes).unwrap();
    read(&path, &ReadOptions::default())
}

#[test]
fn leaves_and_tiles_lie_in_a_dense_box() {
    for flags in [0, ZIP, ACTIVE_ALONE, ZIP | ACTIVE_ALONE] {
        let loaded = load(&file(flags, "Tree_float_5_4_3")).unwrap_or_else(|e| panic!("{e}"));
        let grid = loaded.volume.grid().unwrap();
        // Around the leaf's voxels (0, 0, 0), (1, 2, 7) and (7, 0, 0) and the tile 8 beyond in z, with a border of one.
        assert_eq!(grid.dims(), [10, 10, 18], "{flags}");
        let samples: Vec<f32> = with_grid!(grid.values(), g => g.samples().iter().map(|v| v.to_f32()).collect());
        let calibration = grid.calibration();
        let at = |[x, y, z]: [usize; 3]| calibration.value(samples[(z * 10 + y) * 10 + x].into());
        for (place, i) in [([1, 1, 1], ACTIVE[0]), ([2, 3, 8], ACTIVE[1]), ([8, 1, 1], ACTIVE[2])] {
            assert_eq!(at(place), f64::from(leaf_value(i)), "{flags}");
        }
        assert_eq!((at([0, 0, 0]), at([2, 1, 1])), (-1.0, -1.0));
        assert_eq!((at([1, 1, 9]), at([8, 8, 16]), at([8, 8, 17])), (7.5, 7.5, -1.0));
        let first = grid.placement().to_world(DVec3::ONE);
        assert_eq!(first, DVec3::new(10.0 - 0.5 * 4088.0, 20.0, 30.0 + 2.0 * 8.0));
        assert!(loaded.notes[0].contains("of 2 grids density is taken"), "{:?}", loaded.notes);
    }
}

#[test]
fn what_is_not_read_or_damaged_is_refused() {
    let message = load(&file(0, "Tree_vec3s_5_4_3")).unwrap_err().to_string();
    assert!(
        message.contains("grids: found points (Tree_ptdataidx32_5_4_3), density (Tree_vec3s_5_4_3); one must"),
        "{message}"
    );
    let whole = file(ZIP | ACTIVE_ALONE, "Tree_float_5_4_3");
    for length in (8..whole.len()).step_by(97) {
        assert!(load(&whole[..length]).is_err(), "{length}");
    }
    // Any byte of the beginning may be wrong.
    for at in 0..600 {
        let mut bytes = whole.clone();
        bytes[at] ^= 0xff;
        let _ = load(&bytes);
    }
}
