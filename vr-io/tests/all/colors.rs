//! Volumes of colours, in every format that can hold them: small files made here.

use crate::tiny;

use std::path::PathBuf;

use image::{ImageBuffer, Rgb, Rgba};
use vr_core::transfer::srgb_to_linear;
use vr_core::{ColorGrid, ColorValue};
use vr_io::{Loaded, ReadOptions, read};

use crate::tiny::{COUNT, DIMS, gzip};

/// Component `c` of voxel `i`.
fn component(i: usize, c: usize) -> u8 {
    ((i * 37 + c * 91 + 11) % 256) as u8
}

fn bytes(count: usize) -> Vec<u8> {
    (0..COUNT).flat_map(|i| (0..count).map(move |c| component(i, c))).collect()
}

struct Files(tempfile::TempDir);

impl Files {
    fn put(&self, name: &str, header: impl AsRef<[u8]>, data: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, [header.as_ref(), data].concat()).unwrap();
        path
    }
}

fn colors<'a>(loaded: &'a Loaded, what: &str) -> &'a ColorGrid {
    assert!(loaded.notes.iter().any(|n| n.contains("drawn in their colours")), "{what}: {:?}", loaded.notes);
    loaded.volume.colors().unwrap_or_else(|| panic!("{what}: no colours"))
}

/// Every voxel has the colour that was written.
fn check(loaded: &Loaded, count: usize, what: &str) {
    let grid = colors(loaded, what);
    assert_eq!(grid.values().dims(), DIMS, "{what}");
    // Where something is seen.
    for i in (0..COUNT).filter(|&i| count == 3 || component(i, 3) > 0) {
        for (c, channel) in grid.channels().into_iter().enumerate() {
            let light = srgb_to_linear(f64::from(component(i, c)) / 255.0) * f64::from(ColorGrid::WHITE);
            assert!((light - f64::from(channel.samples[i])).abs() <= 0.5, "{what}: voxel {i}, component {c}");
        }
    }
    let value = if count == 4 { ColorValue::Opacity } else { ColorValue::Largest };
    assert_eq!(grid.value_source(), value, "{what}");
}

fn nifti(datatype: i16, bits: i16) -> Vec<u8> {
    let mut h = vec![0u8; 352];
    h[..4].copy_from_slice(&348i32.to_le_bytes());
    let short = |h: &mut Vec<u8>, at: usize, x: i16| h[at..at + 2].copy_from_slice(&x.to_le_bytes());
    for (k, n) in [3, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        short(&mut h, 40 + 2 * k, n);
    }
    short(&mut h, 70, datatype);
    short(&mut h, 72, bits);
    for k in 0..4 {
        h[76 + 4 * k..80 + 4 * k].copy_from_slice(&1f32.to_le_bytes());
    }
    h[108..112].copy_from_slice(&352f32.to_le_bytes());
    h[344..348].copy_from_slice(b"n+1\0");
    h
}

#[test]
fn every_format_that_says_colour() {
    let files = Files(tempfile::tempdir().unwrap());
    let read = |path: PathBuf| read(&path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    for count in [3, 4] {
        let data = bytes(count);
        let kind = if count == 3 { "RGB-color" } else { "RGBA-color" };
        for (kind, coding) in [(kind, "raw"), (kind, "gzip"), ("vector", "raw")] {
            let header = format!(
                "NRRD0005\ntype: uint8\ndimension: 4\nsizes: {count} 4 3 2\nkinds: {kind} domain domain domain\nencoding: {coding}\n\n"
            );
            let coded = if coding == "gzip" { gzip(&data) } else { data.clone() };
            check(&read(files.put("a.nrrd", header, &coded)), count, "NRRD");
        }
        let header = format!(
            "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 4 3 2 {count}\nkinds: domain domain domain {kind}\nencoding: raw\n\n"
        );
        let planes: Vec<u8> = (0..count).flat_map(|c| (0..COUNT).map(move |i| component(i, c))).collect();
        check(&read(files.put("planes.nrrd", header, &planes)), count, "NRRD in planes");
        let (datatype, bits) = if count == 3 { (128, 24) } else { (2304, 32) };
        check(&read(files.put("a.nii", nifti(datatype, bits), &data)), count, "NIfTI");
        let header = format!(
            "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementNumberOfChannels = {count}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
        );
        check(&read(files.put("a.mha", header, &data)), count, "MetaImage");
        let text: Vec<String> = data.iter().map(u8::to_string).collect();
        let header = format!(
            "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 3 0 2 0 1\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\
             <Piece Extent=\"0 3 0 2 0 1\"><PointData Scalars=\"c\"><DataArray type=\"UInt8\" Name=\"c\" NumberOfComponents=\"{count}\" \
             format=\"ascii\">{}</DataArray></PointData></Piece></ImageData></VTKFile>",
            text.join(" ")
        );
        check(&read(files.put("a.vti", header, b"")), count, "VTI");
        let shape = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 4, {count}), }}");
        let mut header = b"\x93NUMPY\x01\x00".to_vec();
        header.extend(118u16.to_le_bytes());
        header.extend(format!("{shape:<117}\n").into_bytes());
        check(&read(files.put("a.npy", header, &data)), count, "NumPy");
        for ending in ["png", "tif"] {
            let folder = files.0.path().join(format!("{ending}{count}"));
            std::fs::create_dir(&folder).unwrap();
            for z in 0..2 {
                let (file, slice) = (folder.join(format!("{z}.{ending}")), &data[z * 12 * count..(z + 1) * 12 * count]);
                match count {
                    3 => ImageBuffer::<Rgb<u8>, _>::from_raw(4, 3, slice.to_vec()).unwrap().save(file).unwrap(),
                    _ => ImageBuffer::<Rgba<u8>, _>::from_raw(4, 3, slice.to_vec()).unwrap().save(file).unwrap(),
                }
            }
            check(&read(folder), count, ending);
        }
    }
}

#[test]
fn wider_components_and_one_of_them() {
    let files = Files(tempfile::tempdir().unwrap());
    let header = |kind: &str| {
        format!(
            "NRRD0005\ntype: {kind}\nendian: little\ndimension: 4\nsizes: 3 4 3 2\nkinds: RGB-color domain domain domain\nencoding: raw\n\n"
        )
    };
    let words: Vec<u8> = (0..3 * COUNT).flat_map(|i| (900 * i as u16).to_le_bytes()).collect();
    let path = files.put("words.nrrd", header("uint16"), &words);
    let loaded = read(&path, &ReadOptions::default()).unwrap();
    let light = srgb_to_linear(900.0 * 4.0 / 65535.0);
    assert!((f64::from(colors(&loaded, "u16").channels()[1].samples[1]) / 65535.0 - light).abs() < 1e-5);
    let green = read(&path, &ReadOptions { component: Some(1), ..Default::default() }).unwrap();
    assert_eq!(tiny::stored(&green)[1], 3600.0);
    // Floats are light; beyond 1 they are divided by the largest.
    for (kind, scale) in [("float", 1.0f64), ("double", 0.25)] {
        let number = |i: usize| i as f64 / (3 * COUNT - 1) as f64 / scale;
        let data: Vec<u8> = match kind {
            "float" => (0..3 * COUNT).flat_map(|i| (number(i) as f32).to_le_bytes()).collect(),
            _ => (0..3 * COUNT).flat_map(|i| number(i).to_le_bytes()).collect(),
        };
        let loaded = read(files.put("floats.nrrd", header(kind), &data), &ReadOptions::default()).unwrap();
        let found = f64::from(colors(&loaded, kind).channels()[2].samples[10]) / 65535.0;
        assert!((found - number(32) * scale).abs() < 2e-5, "{kind}: {found}");
        assert_eq!(loaded.notes.iter().any(|n| n.contains("divided")), scale < 1.0, "{:?}", loaded.notes);
    }
    // Of other types and counts the first component is taken.
    let signed = read(files.put("i16.nrrd", header("int16"), &words), &ReadOptions::default()).unwrap();
    assert!(signed.volume.grid().is_some() && signed.notes.iter().any(|n| n.contains("component 0 is taken")));
}

#[test]
fn what_is_cut_off_is_refused() {
    let files = Files(tempfile::tempdir().unwrap());
    let data = bytes(3);
    let header =
        "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 3 4 3 2\nkinds: RGB-color domain domain domain\nencoding: raw\n\n";
    let error = read(files.put("a.nrrd", header, &data[1..]), &ReadOptions::default()).unwrap_err().to_string();
    assert!(error.contains("a.nrrd"), "{error}");
    let beyond = read(files.put("b.nrrd", header, &data), &ReadOptions { component: Some(3), ..Default::default() });
    assert!(beyond.unwrap_err().to_string().contains("3 component(s), 0 to 2"));
}
