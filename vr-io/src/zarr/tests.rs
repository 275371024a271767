//! Arrays and images written by hand.

use std::path::{Path, PathBuf};

use serde_json::json;
use vr_core::{Voxel, with_grid};

use crate::{FileError, Loaded, ReadOptions, read};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn put(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn read(&self) -> Result<Loaded, FileError> {
        read(self.path(), &ReadOptions::default())
    }

    fn error(&self) -> String {
        self.read().unwrap_err().to_string()
    }
}

fn numbers(loaded: &Loaded) -> Vec<f32> {
    with_grid!(loaded.volume.grid().unwrap().values(), g => g.samples().iter().map(|s| s.to_f32()).collect())
}

/// The voxel of an array of 3×4×5 (z, y, x).
fn value(z: usize, y: usize, x: usize) -> u16 {
    (1000 + 100 * z + 10 * y + x) as u16
}

fn expected() -> Vec<f32> {
    let rows = (0..3).flat_map(|z| (0..4).map(move |y| (z, y)));
    rows.flat_map(|(z, y)| (0..5).map(move |x| f32::from(value(z, y, x)))).collect()
}

/// A chunk of 2×3×2 of that array, padded with 7 beyond its end; its axes in `order`, slowest first.
fn chunk(place: [usize; 3], order: [usize; 3], bytes: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
    let size = [2, 3, 2];
    let mut out = Vec::new();
    for a in 0..size[order[0]] {
        for b in 0..size[order[1]] {
            for c in 0..size[order[2]] {
                let mut at = [0; 3];
                (at[order[0]], at[order[1]], at[order[2]]) = (a, b, c);
                let [z, y, x] = [0, 1, 2].map(|i| place[i] * size[i] + at[i]);
                out.extend(bytes(if z < 3 && y < 4 && x < 5 { value(z, y, x) } else { 7 }));
            }
        }
    }
    out
}

fn places() -> impl Iterator<Item = [usize; 3]> {
    (0..12).map(|i| [i / 6, i / 3 % 2, i % 3])
}

fn header_2(dtype: &str, order: &str, compressor: serde_json::Value) -> String {
    json!({"zarr_format": 2, "shape": [3, 4, 5], "chunks": [2, 3, 2], "dtype": dtype, "order": order,
           "compressor": compressor, "fill_value": 9, "filters": null})
    .to_string()
}

fn header_3(codecs: serde_json::Value) -> serde_json::Value {
    json!({"zarr_format": 3, "node_type": "array", "shape": [3, 4, 5], "data_type": "uint16", "fill_value": 9,
           "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 3, 2]}},
           "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
           "codecs": codecs, "attributes": {}})
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut e = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    e.write_all(bytes).unwrap();
    e.finish().unwrap()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut e = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    e.write_all(bytes).unwrap();
    e.finish().unwrap()
}

#[test]
fn version_2_in_both_orders_and_byte_orders() {
    for (dtype, order) in [("<u2", "C"), (">u2", "C"), ("<u2", "F"), (">u2", "F")] {
        let folder = Folder::new();
        folder.put(".zarray", header_2(dtype, order, json!({"id": "zlib", "level": 1})));
        let axes = if order == "C" { [0, 1, 2] } else { [2, 1, 0] };
        let bytes = |v: u16| if dtype == ">u2" { v.to_be_bytes() } else { v.to_le_bytes() };
        for place in places() {
            let [z, y, x] = place;
            folder.put(&format!("{z}.{y}.{x}"), zlib(&chunk(place, axes, bytes)));
        }
        let loaded = folder.read().unwrap();
        assert_eq!(loaded.volume.grid().unwrap().dims(), [5, 4, 3]);
        assert_eq!(numbers(&loaded), expected(), "{dtype} {order}");
        assert_eq!((loaded.info.format, loaded.info.encoding), ("Zarr", "zlib"));
        assert_eq!(loaded.info.files.len(), 13, "the header and the chunks, but no folder");
    }
}

#[test]
fn version_3_with_transposed_chunks_and_checksums() {
    let folder = Folder::new();
    // Axis i of what is stored is axis order[i] of the array.
    let codecs = json!([{"name": "transpose", "configuration": {"order": [1, 2, 0]}},
        {"name": "bytes", "configuration": {"endian": "big"}}, {"name": "gzip"}, {"name": "crc32c"}]);
    folder.put("zarr.json", header_3(codecs).to_string());
    let coded = |place| {
        let mut bytes = gzip(&chunk(place, [1, 2, 0], u16::to_be_bytes));
        bytes.extend(super::crc32c::crc32c(&bytes).to_le_bytes());
        bytes
    };
    for place in places() {
        let [z, y, x] = place;
        folder.put(&format!("c/{z}/{y}/{x}"), coded(place));
    }
    let loaded = folder.read().unwrap();
    assert_eq!(numbers(&loaded), expected());
    assert_eq!(loaded.info.encoding, "gzip");
    let mut damaged = coded([0, 1, 2]);
    damaged[4] ^= 1;
    folder.put("c/0/1/2", damaged);
    assert!(folder.error().contains("CRC-32C"), "{}", folder.error());
}

#[test]
fn shards_hold_several_chunks_and_may_leave_some_out() {
    for location in ["start", "end"] {
        let folder = Folder::new();
        let mut header = header_3(json!([{"name": "sharding_indexed", "configuration": {
            "chunk_shape": [2, 3, 2], "codecs": [{"name": "bytes"}], "index_location": location,
            "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]}}]));
        header["chunk_grid"]["configuration"]["chunk_shape"] = json!([4, 6, 2]);
        folder.put("zarr.json", header.to_string());
        let mut expected = expected();
        for x in 0..3 {
            let (mut data, mut table) = (Vec::new(), Vec::new());
            let start = if location == "start" { 4 * 16 + 4 } else { 0 };
            for place in [[0, 0, x], [0, 1, x], [1, 0, x], [1, 1, x]] {
                if place == [1, 1, 2] {
                    table.extend([0xff; 16]);
                    expected[2 * 20 + 3 * 5 + 4] = 9.0;
                    continue;
                }
                let chunk = chunk(place, [0, 1, 2], u16::to_le_bytes);
                table.extend((start + data.len() as u64).to_le_bytes());
                table.extend((chunk.len() as u64).to_le_bytes());
                data.extend(chunk);
            }
            table.extend(super::crc32c::crc32c(&table).to_le_bytes());
            let shard = if location == "start" { [table, data] } else { [data, table] }.concat();
            folder.put(&format!("c/0/0/{x}"), shard);
        }
        let loaded = folder.read().unwrap();
        assert_eq!(numbers(&loaded), expected, "{location}");
        assert_eq!(loaded.info.data_files.len(), 3);
        assert!(loaded.notes.iter().any(|n| n.starts_with("1 of 12 chunks")), "{:?}", loaded.notes);
        folder.put("c/0/0/1", [0; 20]);
        assert!(folder.error().contains("cut off"), "{}", folder.error());
    }
}

#[test]
fn a_chunk_that_is_not_stored_has_the_fill_value() {
    let folder = Folder::new();
    folder.put(".zarray", header_2("<u2", "C", json!(null)));
    folder.put("1.0.1", chunk([1, 0, 1], [0, 1, 2], u16::to_le_bytes));
    let loaded = folder.read().unwrap();
    let mut expected = vec![9.0; 60];
    for y in 0..3 {
        for x in 2..4 {
            expected[2 * 20 + y * 5 + x] = f32::from(value(2, y, x));
        }
    }
    assert_eq!(numbers(&loaded), expected);
    assert!(loaded.notes.iter().any(|n| n.contains("11 of 12 chunks are not stored")), "{:?}", loaded.notes);
    folder.put("1.0.1", [1, 2, 3]);
    assert!(folder.error().contains("claims 24 bytes of voxels, found 3"), "{}", folder.error());
}

#[test]
fn fill_values_that_no_number_of_json_can_be() {
    let folder = Folder::new();
    let mut header = header_3(json!([{"name": "bytes", "configuration": {"endian": "little"}}]));
    header["data_type"] = json!("float32");
    for (fill, value) in [("Infinity", f32::INFINITY), ("0x40200000", 2.5), ("NaN", f32::NAN)] {
        header["fill_value"] = json!(fill);
        folder.put("zarr.json", header.to_string());
        let found = numbers(&folder.read().unwrap())[59];
        assert!(found == value || (found.is_nan() && !value.is_finite()), "{fill}: {found}");
    }
    header["fill_value"] = json!("much");
    folder.put("zarr.json", header.to_string());
    assert!(folder.error().contains("fill_value: found much"), "{}", folder.error());
}

/// An image of two channels and levels of 2×4×4 and 2×2×2, whose channels are filled with their number; in nanometres along x.
fn image(folder: &Folder, is_v3: bool) {
    let multiscales = json!([{"axes": [{"name": "c", "type": "channel"},
            {"name": "z", "type": "space", "unit": "micrometer"}, {"name": "y", "type": "space", "unit": "micrometer"},
            {"name": "x", "type": "space", "unit": "nanometer"}],
        "coordinateTransformations": [{"type": "scale", "scale": [1, 2, 1, 1]}],
        "datasets": [
            {"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 3, 0.5, 400]}]},
            {"path": "s/1", "coordinateTransformations": [{"type": "scale", "scale": [1, 3, 1, 800]},
                {"type": "translation", "translation": [0, 5, 0.25, 200]}]}]}]);
    if is_v3 {
        let attributes = json!({"ome": {"version": "0.5", "multiscales": multiscales}});
        folder.put("zarr.json", json!({"zarr_format": 3, "node_type": "group", "attributes": attributes}).to_string());
    } else {
        folder.put(".zgroup", r#"{"zarr_format": 2}"#);
        folder.put(".zattrs", json!({"multiscales": multiscales}).to_string());
    }
    for (path, [z, y, x]) in [("0", [2, 4, 4]), ("s/1", [2, 2, 2])] {
        let header = json!({"zarr_format": 2, "shape": [2, z, y, x], "chunks": [1, z, y, x], "dtype": "|u1",
            "order": "C", "compressor": null, "fill_value": 0, "filters": null, "dimension_separator": "/"});
        folder.put(&format!("{path}/.zarray"), header.to_string());
        for c in 0..2u8 {
            folder.put(&format!("{path}/{c}/0/0/0"), vec![c + 1; z * y * x]);
        }
    }
}

#[test]
fn an_image_has_levels_channels_and_a_place() {
    for is_v3 in [false, true] {
        let folder = Folder::new();
        image(&folder, is_v3);
        assert_eq!(folder.read().unwrap().info.components, 2);
        let mut options = ReadOptions { component: Some(1), ..Default::default() };
        // The other channel is not even opened.
        folder.put("0/0/0/0/0", [0; 3]);
        let loaded = read(folder.path(), &options).unwrap();
        assert_eq!(numbers(&loaded), [2.0; 32]);
        let placement = loaded.volume.grid().unwrap().placement();
        assert_eq!(placement.spacing().to_array(), [400.0, 500.0, 6000.0]);
        assert_eq!((loaded.info.units.as_deref(), loaded.info.components), (Some("nm"), 2));
        let note = "level 0 of 2 is read (the first of at most 134217728 voxels); levels are 0: 4×4×2, 1: 2×2×2";
        assert!(loaded.notes.iter().any(|n| n == note), "{:?}", loaded.notes);
        options.level = Some(1);
        let loaded = read(folder.path(), &options).unwrap();
        let placement = loaded.volume.grid().unwrap().placement();
        // The scale of all levels counts for the translation of one.
        assert_eq!(placement.origin().to_array(), [200.0, 250.0, 10000.0]);
        assert_eq!((numbers(&loaded).len(), loaded.info.placed_by), (8, "coordinateTransformations"));
        options.level = Some(2);
        let message = read(folder.path(), &options).unwrap_err().to_string();
        assert!(message.contains("level: found 2; the image has 2 level(s), 0 to 1"), "{message}");
    }
}

#[test]
fn a_group_without_an_image_is_asked_about() {
    let folder = Folder::new();
    folder.put(".zgroup", r#"{"zarr_format": 2}"#);
    assert!(folder.error().contains("no array"), "{}", folder.error());
    folder.put("b/.zarray", header_2("<u2", "C", json!(null)));
    let loaded = folder.read().unwrap();
    assert!(loaded.notes.contains(&"the group holds one array, b".into()), "{:?}", loaded.notes);
    folder.put("a/.zarray", header_2("<u2", "C", json!(null)));
    folder.put("g/.zgroup", "{}");
    let message = folder.error();
    assert!(message.contains("found a group of 2 array(s) and 1 group(s); name one of a, b, g/"), "{message}");
}

#[test]
fn axes_with_names_have_roles() {
    let folder = Folder::new();
    // x slowest.
    let header = json!({"zarr_format": 2, "shape": [2, 3, 4], "chunks": [2, 3, 4], "dtype": "|u1", "order": "C",
        "compressor": null, "fill_value": 0, "filters": null});
    folder.put(".zarray", header.to_string());
    folder.put(".zattrs", r#"{"_ARRAY_DIMENSIONS": ["x", "y", "z"]}"#);
    folder.put("0.0.0", (0..24).collect::<Vec<u8>>());
    let loaded = folder.read().unwrap();
    let grid = loaded.volume.grid().unwrap();
    assert_eq!(grid.dims(), [4, 3, 2]);
    assert_eq!(grid.placement().axes().x_axis.to_array(), [0.0, 0.0, 1.0]);
    assert_eq!(grid.placement().axes().z_axis.to_array(), [1.0, 0.0, 0.0]);
}

#[test]
fn headers_that_lie_or_ask_too_much() {
    let folder = Folder::new();
    let with = |key: &str, value: serde_json::Value| {
        let mut header: serde_json::Value = serde_json::from_str(&header_2("<u2", "C", json!(null))).unwrap();
        header[key] = value;
        folder.put(".zarray", header.to_string());
        folder.error()
    };
    for (key, value, message) in [
        ("shape", json!([0, 4, 5]), "shape: found [0,4,5]; must be a list of positive integers"),
        ("shape", json!([-3, 4, 5]), "shape"),
        ("shape", json!([1u64 << 40, 1u64 << 40, 1u64 << 40]), "1099511627776"),
        ("shape", json!([1 << 20, 1 << 10, 1 << 10]), "must be at most"),
        ("shape", json!([1, 4, 5]), "1"),
        ("chunks", json!([0, 1, 1]), "chunks"),
        ("chunks", json!([2, 2]), "must be the 3 axes"),
        ("chunks", json!([1 << 30, 1 << 30, 1 << 30]), "must be at most 4294967296 bytes each"),
        ("dtype", json!("<c8"), "dtype: found <c8; must be bool"),
        ("dtype", json!([["r", "<u1"]]), "dtype"),
        ("order", json!("Z"), "must be C or F"),
        ("compressor", json!({"id": "lzma"}), "compressor: found lzma; must be gzip"),
        ("filters", json!([{"id": "delta"}]), "filters"),
        ("fill_value", json!(-1), "fill_value: found -1; must be a number of type u16"),
        ("zarr_format", json!(4), "must be 2 or 3"),
    ] {
        let found = with(key, value);
        assert!(found.contains(message), "{found}");
    }
    folder.put(".zarray", "{\"shape\": [");
    assert!(folder.error().contains("JSON"));
    let folder = Folder::new();
    for (codecs, message) in [
        (json!([{"name": "gzip"}]), "must come after bytes"),
        (json!([{"name": "bytes"}, {"name": "zfpy"}]), "codecs: found zfpy"),
        (json!([]), "must have bytes"),
        (json!([{"name": "transpose", "configuration": {"order": [0, 0, 1]}}, {"name": "bytes"}]), "permutation"),
    ] {
        folder.put("zarr.json", header_3(codecs).to_string());
        assert!(folder.error().contains(message), "{}", folder.error());
    }
    let folder = Folder::new();
    folder.put(
        ".zattrs",
        json!({"multiscales": [{"axes": ["z", "y", "x"], "datasets": [{"path": "../x"}]}]}).to_string(),
    );
    assert!(folder.error().contains("must be a path inside of the folder"), "{}", folder.error());
}
