//! Volumes in every format, type, encoding and arrangement of files that is read; and NRRD files that come back.

use std::path::{Path, PathBuf};

use crate::tiny::{
    COUNT, DIMS, bzip2, expected, gzip, i16_bytes, join, metaimage, nifti_1, nifti_2, nrrd, sample, stored, zlib,
};
use glam::{DMat3, DVec3};
use vr_core::{AnyGrid, Calibration, Placement, UniformGrid, Volume, VoxelType};
use vr_io::{
    Endian, Loaded, NrrdEncoding, NrrdOptions, NrrdValues, RawDescription, ReadOptions, ScalarType, Space, Transform,
    read, write_nrrd,
};

/// A folder with files in it.
struct Files(tempfile::TempDir);

impl Files {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

fn load(path: &Path) -> Loaded {
    load_with(path, &ReadOptions::default())
}

fn load_with(path: &Path, options: &ReadOptions) -> Loaded {
    read(path, options).unwrap_or_else(|e| panic!("{e}"))
}

fn check(path: &Path) -> Loaded {
    let loaded = load(path);
    assert_eq!(loaded.volume.grid().unwrap().dims(), DIMS);
    assert_eq!(stored(&loaded), expected(), "{}", path.display());
    loaded
}

const SHORT: &str = "type: short\nspacings: 1 2 3\nendian: ";

#[test]
fn nrrd_encodings_and_byte_orders() {
    let files = Files::new();
    for (big, endian) in [(false, "little"), (true, "big")] {
        let bytes = i16_bytes(big);
        let hex: String =
            bytes.iter().enumerate().map(|(i, b)| format!("{b:02x}{}", if i % 7 == 0 { "\n" } else { "" })).collect();
        let text: String = (0..COUNT).map(|i| format!("{} ", sample(i))).collect();
        let encodings: [(&str, &[u8]); 6] = [
            ("raw", &bytes),
            ("gzip", &gzip(&bytes)),
            ("bz2", &bzip2(&bytes)),
            ("hex", hex.as_bytes()),
            ("ascii", text.as_bytes()),
            ("txt", text.as_bytes()),
        ];
        for (encoding, data) in encodings {
            let fields = format!("{SHORT}{endian}\nencoding: {encoding}");
            check(&files.put(&format!("{endian}_{encoding}.nrrd"), &nrrd(&fields, data)));
            files.put("data.bin", data);
            let loaded = check(&files.put("d.nhdr", &nrrd(&format!("{fields}\ndata file: data.bin"), b"")));
            assert_eq!(loaded.info.data_files, [files.0.path().join("data.bin")]);
        }
    }
}

#[test]
fn every_type_in_both_byte_orders() {
    let files = Files::new();
    macro_rules! check_type {
        ($($t:ty => $name:literal, $memory:ident);*) => {$(
            for big in [false, true] {
                let bytes: Vec<u8> = (0..COUNT)
                    .flat_map(|i| { let x = sample(i) as $t; if big { x.to_be_bytes() } else { x.to_le_bytes() } })
                    .collect();
                let endian = if big { "big" } else { "little" };
                let fields = format!("type: {}\nspacings: 1 1 1\nendian: {endian}\nencoding: raw", $name);
                let loaded = check(&files.put("x.nrrd", &nrrd(&fields, &bytes)));
                assert_eq!(loaded.volume.grid().unwrap().voxel_type(), VoxelType::$memory);
            }
        )*};
    }
    check_type!(
        u8 => "uchar", U8; i8 => "signed char", I8; u16 => "ushort", U16; i16 => "int16", I16;
        u32 => "unsigned int", U8; i32 => "int", U8; u64 => "uint64", U8; i64 => "longlong", U8;
        f32 => "float", F32; f64 => "double", F32
    );
}

#[test]
fn nrrd_in_several_files_and_with_skips() {
    let files = Files::new();
    let bytes = i16_bytes(false);
    let (first, second) = bytes.split_at(bytes.len() / 2);
    files.put("part/s 01.raw", &join(b"a line\nanother\nxx".to_vec(), first));
    files.put("part/s 03.raw", &join(b"a line\nanother\nxx".to_vec(), second));
    let skips = format!("{SHORT}little\nencoding: raw\nline skip: 2\nbyte skip: 2\n");
    check(&files.put("pattern.nhdr", &nrrd(&format!("{skips}data file: part/s %02d.raw 1 3 2 2"), b"")));
    check(&files.put("list.nhdr", &nrrd(&format!("{skips}data file: LIST 2\npart/s 01.raw\npart/s 03.raw"), b"")));

    files.put("tail.gz", &gzip(&join(b"something else".to_vec(), &bytes)));
    let tail = format!("{SHORT}little\nencoding: gzip\nbyte skip: -1\ndata file: tail.gz");
    check(&files.put("tail.nhdr", &nrrd(&tail, b"")));

    // As many files as do not divide the volume.
    let odd =
        files.put("odd.nhdr", &nrrd(&format!("{SHORT}little\nencoding: raw\ndata file: LIST\na\nb\nc\nd\ne"), b""));
    assert!(read(&odd, &ReadOptions::default()).unwrap_err().to_string().contains("data file: found 5 files"));
    let none = files.put("none.nhdr", &nrrd(&format!("{SHORT}little\nencoding: raw\ndata file: LIST"), b""));
    assert!(read(&none, &ReadOptions::default()).is_err());
}

#[test]
fn components_and_frames_are_picked() {
    let files = Files::new();
    // Two frames of three components; component 1 of frame 1 holds the voxels.
    let at = |frame: usize, i: usize, c: usize| if (frame, c) == (1, 1) { sample(i) as u8 } else { 255 };
    let data: Vec<u8> = (0..2).flat_map(|f| (0..COUNT).flat_map(move |i| (0..3).map(move |c| at(f, i, c)))).collect();
    let header = "NRRD0004\ntype: uchar\ndimension: 5\nsizes: 3 4 3 2 2\nkinds: 3-vector domain domain domain time\nencoding: raw\n\n";
    let path = files.put("five.nrrd", &join(header.as_bytes().to_vec(), &data));
    let first = load_with(&path, &ReadOptions { frame: Some(1), ..Default::default() });
    assert!(
        stored(&first).iter().all(|&v| v == 255.0) && first.notes.contains(&"component 0 is taken, of 0 to 2".into())
    );
    let picked = load_with(&path, &ReadOptions { frame: Some(1), component: Some(1), ..Default::default() });
    assert_eq!(stored(&picked), expected());
    assert_eq!((picked.info.frames, picked.info.components), (2, 3));
}

#[test]
fn metaimage_in_all_its_shapes() {
    let files = Files::new();
    let (little, big) = (i16_bytes(false), i16_bytes(true));
    let short = "ElementType = MET_SHORT\nElementSpacing = 1 2 3";
    check(&files.put("a.mha", &metaimage(short, "LOCAL", &little)));
    check(&files.put("b.mha", &metaimage(&format!("{short}\nBinaryDataByteOrderMSB = True"), "LOCAL", &big)));
    check(&files.put("c.mha", &metaimage(&format!("{short}\nCompressedData = True"), "LOCAL", &zlib(&little))));
    let text: String = (0..COUNT).map(|i| format!("{}\n", sample(i))).collect();
    check(&files.put("d.mha", &metaimage(&format!("{short}\nBinaryData = False"), "LOCAL", text.as_bytes())));
    files.put("e.raw", &join(vec![7; 100], &little));
    check(&files.put("e.mhd", &metaimage(&format!("{short}\nHeaderSize = -1"), "e.raw", b"")));
    check(&files.put("f.mhd", &metaimage(&format!("{short}\nHeaderSize = 100"), "e.raw", b"")));
    let (first, second) = little.split_at(little.len() / 2);
    files.put("g1.raw", first);
    files.put("g2.raw", second);
    check(&files.put("g.mhd", &metaimage(short, "LIST", b"g1.raw\ng2.raw\n")));
    check(&files.put("h.mhd", &metaimage(short, "g%d.raw 1 2 1", b"")));
    // A long of 32 bits.
    let long: Vec<u8> = (0..COUNT).flat_map(|i| (sample(i) as i32).to_le_bytes()).collect();
    check(&files.put("i.mha", &metaimage("ElementType = MET_LONG", "LOCAL", &long)));
    let channels: Vec<u8> = (0..COUNT).flat_map(|i| [9, sample(i) as u8]).collect();
    let two =
        files.put("j.mha", &metaimage("ElementType = MET_UCHAR\nElementNumberOfChannels = 2", "LOCAL", &channels));
    assert!(stored(&load(&two)).iter().all(|&v| v == 9.0));
    assert_eq!(stored(&load_with(&two, &ReadOptions { component: Some(1), ..Default::default() })), expected());

    let itk = format!("{short}\nTransformMatrix = 0 1 0 1 0 0 0 0 1\nOffset = 10 20 30");
    let loaded = load(&files.put("k.mha", &metaimage(&itk, "LOCAL", &little)));
    let placement = *loaded.volume.grid().unwrap().placement();
    // Index x runs along posterior, that is −y in RAS.
    assert_eq!(placement.axes().x_axis, DVec3::new(0.0, -1.0, 0.0));
    assert_eq!(placement.axes().y_axis, DVec3::new(-2.0, 0.0, 0.0));
    assert_eq!(placement.origin(), DVec3::new(-10.0, -20.0, 30.0));
}

#[test]
fn nifti_of_both_versions_and_byte_orders() {
    let files = Files::new();
    for big in [false, true] {
        let bytes = i16_bytes(big);
        let one = join(nifti_1(big, b"n+1\0"), &bytes);
        let all = [
            files.put("one.nii", &one),
            files.put("one.nii.gz", &gzip(&one)),
            files.put("two.nii", &join(nifti_2(big), &bytes)),
        ];
        files.put("pair.img", &bytes);
        let pair = files.put("pair.hdr", &nifti_1(big, b"ni1\0"));
        files.put("packed.img.gz", &gzip(&bytes));
        let packed = files.put("packed.hdr", &nifti_1(big, b"ni1\0"));
        for path in all.iter().chain([&pair, &packed, &files.0.path().join("pair.img")]) {
            let loaded = check(path);
            let placement = *loaded.volume.grid().unwrap().placement();
            assert_eq!(placement.origin(), DVec3::new(10.0, 20.0, 30.0));
            assert_eq!(placement.axes(), DMat3::from_diagonal(DVec3::new(1.0, 2.0, 3.0)));
            assert_eq!(loaded.info.units.as_deref(), Some("mm"));
        }
        let by_spacing = ReadOptions { transform: Transform::Spacing, ..Default::default() };
        assert_eq!(load_with(&all[0], &by_spacing).volume.grid().unwrap().placement().origin(), DVec3::ZERO);
    }
}

#[test]
fn nifti_scaling() {
    let files = Files::new();
    for (slope, inter, expected) in [
        (2.0f32, -1.0f32, Calibration { slope: 2.0, intercept: -1.0 }),
        (0.0, 5.0, Calibration::default()),
        (f32::NAN, 5.0, Calibration::default()),
    ] {
        let mut head = nifti_1(false, b"n+1\0");
        head[112..116].copy_from_slice(&slope.to_le_bytes());
        head[116..120].copy_from_slice(&inter.to_le_bytes());
        let loaded = load(&files.put("x.nii", &join(head, &i16_bytes(false))));
        assert_eq!(loaded.volume.grid().unwrap().calibration(), expected);
    }
}

#[test]
fn raw_by_name_and_by_description() {
    let files = Files::new();
    let bytes = i16_bytes(false);
    check(&files.put("x_4x3x2_int16.raw", &bytes));
    check(&files.put("x_4x3x2_int16.raw.gz", &gzip(&bytes)));
    check(&files.put("x_4x3x2_int16.raw.bz2", &bzip2(&bytes)));
    let path = files.put("nameless.bin", &join(vec![1; 3], &i16_bytes(true)));
    let described = RawDescription {
        endian: Endian::Big,
        spacing: Some([1.0, 2.0, 3.0]),
        skip: 3,
        ..RawDescription::new(DIMS, ScalarType::I16)
    };
    let options = ReadOptions { raw: Some(described.clone()), ..Default::default() };
    let loaded = load_with(&path, &options);
    assert_eq!(stored(&loaded), expected());
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
    let bad = RawDescription { spacing: Some([1.0, f64::NAN, 1.0]), ..described };
    let refused = read(&path, &ReadOptions { raw: Some(bad), ..Default::default() }).unwrap_err().to_string();
    assert!(refused.contains("spacing of axis 1: found NaN"), "{refused}");
}

#[test]
fn mapped_and_copied_are_the_same() {
    let files = Files::new();
    let aligned = files.put("x_4x3x2_int16.raw", &i16_bytes(Endian::NATIVE == Endian::Big));
    let loaded = load(&aligned);
    assert!(loaded.info.mapped);
    let copied = load_with(&aligned, &ReadOptions { map: false, ..Default::default() });
    assert!(!copied.info.mapped);
    assert_eq!(stored(&loaded), stored(&copied));
    // One byte off: the copying reader takes over.
    let raw = RawDescription { skip: 1, endian: Endian::NATIVE, ..RawDescription::new(DIMS, ScalarType::I16) };
    let odd = files.put("odd.bin", &join(vec![0], &i16_bytes(Endian::NATIVE == Endian::Big)));
    let odd = load_with(&odd, &ReadOptions { raw: Some(raw), ..Default::default() });
    assert!(!odd.info.mapped);
    assert_eq!(stored(&odd), expected());
}

#[test]
fn claims_of_terabytes_are_refused_at_once() {
    let files = Files::new();
    let header = |encoding: &str| {
        format!(
            "NRRD0004\ntype: double\nendian: little\ndimension: 3\nsizes: 100000 100000 1000\nencoding: {encoding}\n\n"
        )
    };
    for (encoding, data) in [
        ("raw", i16_bytes(false)),
        ("gzip", gzip(&[0; 10000])),
        ("bzip2", bzip2(&[0; 10000])),
        ("ascii", b"1 2".to_vec()),
    ] {
        let path = files.put("huge.nrrd", &join(header(encoding).into_bytes(), &data));
        let message = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(message.contains("claims 80000000000000 bytes"), "{message}");
    }
}

fn odd_placement() -> Placement {
    let axes =
        DMat3::from_cols(DVec3::new(0.1, 0.2, 0.0), DVec3::new(-0.3, 1.0 / 3.0, 0.1), DVec3::new(0.0, 1e-3, 7.0));
    Placement::new(DVec3::new(1e6 + 0.1, -3.0, 1.0 / 7.0), axes).unwrap()
}

#[test]
fn what_is_written_as_nrrd_is_read_back_identical() {
    let files = Files::new();
    let calibration = Calibration { slope: 2.2086, intercept: -1024.1 };
    macro_rules! volumes {
        ($($t:ty),*) => { [$({
            let samples: Vec<$t> = (0..COUNT).map(|i| sample(i) as $t).collect();
            Volume::from(UniformGrid::new(DIMS, samples, odd_placement(), calibration).unwrap())
        }),*] };
    }
    for volume in volumes!(u8, i8, u16, i16, f32) {
        let before = volume.grid().unwrap();
        for encoding in [NrrdEncoding::Raw, NrrdEncoding::Gzip] {
            for space in [Space::Own, Space::Ras, Space::Las, Space::Lps] {
                let path = files.0.path().join("out.nrrd");
                write_nrrd(&path, &volume, &NrrdOptions { encoding, space, values: NrrdValues::Stored }).unwrap();
                let back = load(&path);
                let after = back.volume.grid().unwrap();
                assert_eq!(after.voxel_type(), before.voxel_type());
                assert_eq!(after.placement(), before.placement());
                assert_eq!(after.calibration(), before.calibration());
                assert_eq!(after.value_stats(), before.value_stats());
                assert_eq!(stored(&back), expected());
                assert_eq!(back.info.space, space);
            }
        }
        // Calibrated: floats that any reader understands.
        let path = files.0.path().join("calibrated.nrrd");
        write_nrrd(&path, &volume, &NrrdOptions::default()).unwrap();
        let back = load(&path);
        assert!(matches!(back.volume.grid().unwrap().values(), AnyGrid::F32(_)));
        assert_eq!(back.volume.grid().unwrap().calibration(), Calibration::default());
        for (found, stored) in stored(&back).iter().zip(expected()) {
            assert_eq!(*found, calibration.value(stored.into()) as f32);
        }
    }
}

#[test]
fn a_mapped_volume_outlives_its_file_being_replaced() {
    let files = Files::new();
    let path = files.put("x.nrrd", &nrrd("type: uchar\nspacings: 1 1 1\nencoding: raw", &(0..24).collect::<Vec<u8>>()));
    let loaded = load(&path);
    assert!(loaded.info.mapped);
    write_nrrd(&path, &loaded.volume, &NrrdOptions::default()).unwrap();
    assert_eq!(stored(&loaded), stored(&load(&path)));
}
