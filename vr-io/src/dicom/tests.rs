//! Tests of whole files and folders, from their bytes to voxels.

use std::path::PathBuf;

use glam::DVec3;
use tempfile::TempDir;
use vr_core::{Voxel, with_grid};

use super::coded_samples::{COLUMNS, ROWS, picture};
use super::sample::{Sample, element, encapsulated, item, meta};
use super::tags::{self, Tag};
use crate::{FileError, Loaded, ReadOptions, Space, orientation, read};

/// A folder of these files; the file of slice i is not the i-th by name.
fn folder(files: &[Vec<u8>]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (i, bytes) in files.iter().enumerate() {
        std::fs::write(folder.path().join(format!("{}.dcm", files.len() - i)), bytes).unwrap();
    }
    folder
}

fn read_all(files: &[Vec<u8>]) -> Result<Loaded, FileError> {
    read_with(files, &ReadOptions::default())
}

fn read_with(files: &[Vec<u8>], options: &ReadOptions) -> Result<Loaded, FileError> {
    let loaded = read(folder(files).path(), options);
    let texts = match &loaded {
        Ok(loaded) => loaded.notes.clone(),
        Err(e) => vec![e.to_string()],
    };
    for text in texts {
        assert!(!text.contains("Secret") && !text.contains('\n'), "{text}");
    }
    loaded
}

fn refusal(files: &[Vec<u8>]) -> String {
    read_all(files).unwrap_err().to_string()
}

fn values(loaded: &Loaded) -> Vec<f32> {
    let grid = loaded.volume.grid().unwrap();
    with_grid!(grid.values(), g => g.samples().iter().map(|s| g.calibration().value(s.to_f32().into()) as f32).collect())
}

fn count_from(first: i16, n: i16) -> Vec<f32> {
    (first..first + n).map(f32::from).collect()
}

/// Three slices, out of order.
fn three() -> [Sample; 3] {
    [Sample::slice(4.0, 112), Sample::slice(0.0, 100), Sample::slice(2.0, 106)]
}

fn bytes(samples: impl IntoIterator<Item = Sample>) -> Vec<Vec<u8>> {
    samples.into_iter().map(|s| s.bytes()).collect()
}

fn pair(change: impl Fn(Sample) -> Sample) -> Vec<Vec<u8>> {
    bytes([change(Sample::slice(0.0, 100)), change(Sample::slice(2.0, 106))])
}

#[test]
fn a_folder_is_a_volume_sorted_by_position() {
    let loaded = read_all(&bytes(three())).unwrap();
    let grid = loaded.volume.grid().unwrap();
    assert_eq!(grid.dims(), [3, 2, 3]);
    assert_eq!(values(&loaded), count_from(100, 18));
    assert_eq!(grid.placement().spacing().to_array(), [0.5, 0.75, 2.0]);
    assert_eq!(grid.placement().to_world(DVec3::new(2.0, 1.0, 2.0)), DVec3::new(-11.0, -20.75, 4.0));
    assert_eq!(orientation(grid.placement()), "LPS");
    let info = &loaded.info;
    assert_eq!(
        (info.format, info.encoding, info.space, info.units.as_deref()),
        ("DICOM", "raw", Space::Lps, Some("mm"))
    );
    assert_eq!((info.modality.as_deref(), info.window, info.data_files.len()), (Some("CT"), None, 3));
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
}

#[test]
fn one_file_of_a_series_brings_its_siblings() {
    let mut files = bytes(three());
    files.push(Sample::slice(6.0, 0).text(tags::SERIES_INSTANCE_UID, "9.9").bytes());
    files.push(b"something else".to_vec());
    let folder = folder(&files);
    let loaded = read(folder.path().join("3.dcm"), &ReadOptions::default()).unwrap();
    assert_eq!(values(&loaded), count_from(100, 18));
    assert_eq!(loaded.notes, ["one file of a series is named: all 3 of its files in the folder are taken"]);
    let alone = read(folder.path().join("2.dcm"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(alone.contains("slices: found 1 image; a volume has 2 slices or more"), "{alone}");
}

#[test]
fn several_series_are_listed_to_choose_from() {
    let other = |z: f64| {
        let slice = Sample::slice(z, 7).text(tags::SERIES_INSTANCE_UID, "9.9").text(tags::SERIES_NUMBER, "12");
        slice.text(tags::MODALITY, "MR").set(tags::SERIES_DESCRIPTION, b"LO", b"T1\nnice".to_vec())
    };
    let mut files = bytes(three());
    files.extend(bytes([other(0.0), other(3.0)]));
    let message = refusal(&files);
    assert!(message.contains("series: found 2 in the folder; choose a series"), "{message}");
    assert!(
        message.contains("7 (CT, 3x2, 3 files, UID 1.2.3); 12 (MR, 3x2, 2 files, T1\\nnice, UID 9.9)"),
        "{message}"
    );
    for choice in ["12", "9.9"] {
        let options = ReadOptions { series: Some(choice.into()), ..ReadOptions::default() };
        assert_eq!(read_with(&files, &options).unwrap().info.modality.as_deref(), Some("MR"));
    }
    let options = ReadOptions { series: Some("8".into()), ..ReadOptions::default() };
    assert!(read_with(&files, &options).unwrap_err().to_string().contains("series: found 8; 0 of the series are that"));
}

#[test]
fn strays_are_left_out_with_a_note() {
    let mut files = bytes(three());
    files.push(Sample::slice(50.0, 0).text(tags::IMAGE_TYPE, "ORIGINAL\\PRIMARY\\LOCALIZER").bytes());
    files.push(Sample::slice(0.0, 0).without(tags::PIXEL_DATA).bytes());
    files.push(b"a text".to_vec());
    let loaded = read_all(&files).unwrap();
    assert_eq!(values(&loaded), count_from(100, 18));
    let notes = loaded.notes.join("; ");
    for word in ["1 of 6 files of the folder are not DICOM", "1 DICOM files without an image", "1 localizer images"] {
        assert!(notes.contains(word), "{notes}");
    }
    let copy = Sample::slice(0.0, 100).text(tags::SOP_INSTANCE_UID, "5");
    let next = Sample::slice(1.0, 106).text(tags::SOP_INSTANCE_UID, "6");
    let loaded = read_all(&[copy.bytes(), copy.bytes(), next.bytes()]).unwrap();
    assert!(loaded.notes[0].contains("1 files with the SOPInstanceUID of another one"), "{:?}", loaded.notes);
}

#[test]
fn mixed_sizes_and_damaged_slices_are_refused() {
    let big = Sample::slice(6.0, 0).short(tags::ROWS, 1);
    let mut files = bytes(three());
    files.push(big.bytes());
    let message = refusal(&files);
    assert!(message.contains("3x2 of 1 i16 (16 bits) in 3 files") && message.contains("3x1 of 1 i16"), "{message}");
    let mut files = bytes(three());
    let length = files[1].len();
    files[1].truncate(length - 2);
    let message = refusal(&files);
    assert!(message.contains("claims 12 bytes of voxels, found 10"), "{message}");
    files[1].truncate(200);
    assert!(read_all(&files).is_err());
}

#[test]
fn calibration_is_one_or_applied_to_each_slice() {
    let scaled = |z, first, slope: &str| {
        Sample::slice(z, first).text(tags::RESCALE_SLOPE, slope).text(tags::RESCALE_INTERCEPT, "-10")
    };
    let loaded = read_all(&bytes([scaled(0.0, 1, "2"), scaled(1.0, 7, "2")])).unwrap();
    assert_eq!(loaded.volume.grid().unwrap().calibration(), vr_core::Calibration { slope: 2.0, intercept: -10.0 });
    assert_eq!(loaded.info.scalar, crate::ScalarType::I16);
    let loaded = read_all(&bytes([scaled(0.0, 1, "2"), scaled(1.0, 7, "0.5")])).unwrap();
    let wanted: Vec<f32> = (1..13).map(|v| if v < 7 { v as f32 * 2.0 - 10.0 } else { v as f32 * 0.5 - 10.0 }).collect();
    assert_eq!(values(&loaded), wanted);
    assert!(loaded.notes[0].contains("slopes from 0.5 to 2"), "{:?}", loaded.notes);
    assert!(refusal(&bytes([scaled(0.0, 1, "0"), scaled(1.0, 7, "0")])).contains("RescaleSlope (0028,1053): found 0"));
}

#[test]
fn unused_bits_are_cleared_or_repeat_the_sign() {
    let stored = |sign: u16| {
        move |s: Sample| {
            let voxels = [0x0fffu16, 0x0800, 0x07ff, 0xf001, 0, 1].map(u16::to_le_bytes).concat();
            let s = s.short(tags::BITS_STORED, 12).short(tags::HIGH_BIT, 11).short(tags::PIXEL_REPRESENTATION, sign);
            s.set(tags::PIXEL_DATA, b"OW", voxels)
        }
    };
    let loaded = read_all(&pair(stored(1))).unwrap();
    assert_eq!(values(&loaded)[..6], [-1.0, -2048.0, 2047.0, 1.0, 0.0, 1.0]);
    // Without a word that something else is there, unsigned numbers stay in the file as they are.
    let loaded = read_all(&pair(stored(0))).unwrap();
    assert_eq!(values(&loaded)[3], f32::from(0xf001u16));
    let overlay = |s: Sample| stored(0)(s).short(Tag(0x6000, 0x0102), 12);
    assert_eq!(values(&read_all(&pair(overlay)).unwrap())[..4], [4095.0, 2048.0, 2047.0, 1.0]);
    let high = |s: Sample| stored(0)(s).short(tags::HIGH_BIT, 15);
    assert_eq!(values(&read_all(&pair(high)).unwrap())[..4], [255.0, 128.0, 127.0, 3840.0]);
    assert!(refusal(&pair(|s| s.short(tags::BITS_STORED, 17))).contains("BitsStored (0028,0101): found 17"));
    assert!(refusal(&pair(|s| s.short(tags::BITS_ALLOCATED, 1))).contains("images of single bits"));
    assert!(refusal(&pair(|s| s.short(tags::BITS_ALLOCATED, 12))).contains("found 12; must be 8, 16 or 32"));
}

#[test]
fn window_padding_and_inversion_are_told() {
    let told = |s: Sample| {
        let s = s.text(tags::WINDOW_CENTER, "40\\300").text(tags::WINDOW_WIDTH, "400\\1500");
        s.text(tags::PHOTOMETRIC_INTERPRETATION, "MONOCHROME1").short(tags::PIXEL_PADDING_VALUE, 0xf830)
    };
    let loaded = read_all(&pair(told)).unwrap();
    assert_eq!(loaded.info.window, Some([-160.0, 240.0]));
    let notes = loaded.notes.join("; ");
    assert!(notes.contains("MONOCHROME1") && notes.contains("PixelPaddingValue (0028,0120) is -2000"), "{notes}");
}

#[test]
fn colours_have_components_together_or_in_planes() {
    let colours = |planar: u16| {
        move |s: Sample| {
            let s = s.short(tags::SAMPLES_PER_PIXEL, 3).text(tags::PHOTOMETRIC_INTERPRETATION, "RGB");
            let s = s.short(tags::BITS_ALLOCATED, 8).short(tags::BITS_STORED, 8).short(tags::HIGH_BIT, 7);
            let s = s.short(tags::PIXEL_REPRESENTATION, 0).short(tags::PLANAR_CONFIGURATION, planar);
            s.set(tags::PIXEL_DATA, b"OB", (0..18).collect())
        }
    };
    let green = ReadOptions { component: Some(1), ..ReadOptions::default() };
    assert_eq!(values(&read_with(&pair(colours(0)), &green).unwrap())[..6], [1.0, 4.0, 7.0, 10.0, 13.0, 16.0]);
    assert_eq!(values(&read_with(&pair(colours(1)), &green).unwrap())[..6], [6.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
    for planar in [0, 1] {
        let loaded = read_all(&pair(colours(planar))).unwrap();
        let colors = loaded.volume.colors().expect("RGB").values();
        let vr_core::AnyGrid::U8(values) = colors.values() else { panic!("bytes") };
        let largest = if planar == 0 { [2, 5, 8, 11, 14, 17] } else { [12, 13, 14, 15, 16, 17] };
        assert_eq!(values.samples()[..6], largest);
    }
}

/// An enhanced file of three sagittal frames, from left to right.
fn enhanced() -> Sample {
    let shared = [
        element(tags::PIXEL_MEASURES_SEQUENCE, b"SQ", &item(&element(tags::PIXEL_SPACING, b"DS", b"3\\2"))),
        element(
            tags::PLANE_ORIENTATION_SEQUENCE,
            b"SQ",
            &item(&element(tags::IMAGE_ORIENTATION_PATIENT, b"DS", b"0\\1\\0\\0\\0\\-1")),
        ),
        element(tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE, b"SQ", &item(&element(tags::RESCALE_SLOPE, b"DS", b"4"))),
    ];
    let voxels: Vec<u8> = (0..18i16).flat_map(i16::to_le_bytes).collect();
    let mut sample = Sample::slice(0.0, 0).text(tags::NUMBER_OF_FRAMES, "3").set(tags::PIXEL_DATA, b"OW", voxels);
    for tag in [tags::IMAGE_POSITION_PATIENT, tags::IMAGE_ORIENTATION_PATIENT, tags::PIXEL_SPACING] {
        sample = sample.without(tag);
    }
    let per_frame = [9, 6, 3].map(|x| {
        let position = element(tags::IMAGE_POSITION_PATIENT, b"DS", format!("{x}\\2\\5").as_bytes());
        item(&element(tags::PLANE_POSITION_SEQUENCE, b"SQ", &item(&position)))
    });
    sample.set(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, b"SQ", item(&shared.concat())).set(
        tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE,
        b"SQ",
        per_frame.concat(),
    )
}

#[test]
fn enhanced_files_keep_places_in_functional_groups() {
    let folder = folder(&[enhanced().bytes()]);
    let loaded = read(folder.path().join("1.dcm"), &ReadOptions::default()).unwrap();
    let grid = loaded.volume.grid().unwrap();
    assert_eq!(grid.dims(), [3, 2, 3]);
    assert_eq!(grid.placement().spacing().to_array(), [2.0, 3.0, 3.0]);
    // Towards posterior, inferior, and right: the normal of these directions; the frames run along it already.
    assert_eq!(orientation(grid.placement()), "PIR");
    assert_eq!(values(&loaded), (0..18).map(|v| v as f32 * 4.0).collect::<Vec<_>>());
    assert!(loaded.info.mapped);

    let fewer = enhanced().text(tags::NUMBER_OF_FRAMES, "2");
    assert!(refusal(&[fewer.bytes()]).contains("must be one for each of 2 frames"));
    let many = enhanced().text(tags::NUMBER_OF_FRAMES, "2000000000");
    assert!(refusal(&[many.bytes()]).contains("claims 24000000000 bytes of voxels, found 36"));
    assert!(
        refusal(&[enhanced().text(tags::NUMBER_OF_FRAMES, "1A").bytes()])
            .contains("NumberOfFrames (0028,0008): found 1A")
    );
}

#[test]
fn classic_frames_lie_behind_each_other() {
    let voxels: Vec<u8> = (0..18i16).flat_map(i16::to_le_bytes).collect();
    let frames = Sample::slice(1.0, 0).text(tags::NUMBER_OF_FRAMES, "3").set(tags::PIXEL_DATA, b"OW", voxels);
    let file = |s: Sample| read_all(&[s.bytes()]);
    let offsets = file(frames.text(tags::GRID_FRAME_OFFSET_VECTOR, "0\\-2.5\\-5")).unwrap();
    // Downwards in the file, upwards in the volume.
    assert_eq!(values(&offsets)[..6], [12.0, 13.0, 14.0, 15.0, 16.0, 17.0]);
    let place = offsets.volume.grid().unwrap().placement();
    assert_eq!((place.spacing().z, place.origin()), (2.5, DVec3::new(-10.0, -20.0, -4.0)));
}

#[test]
fn files_without_places_stand_in_a_frame_of_their_own() {
    let bare = |n: i16| {
        let s = Sample::slice(0.0, n * 6).text(tags::INSTANCE_NUMBER, &(9 - n).to_string());
        s.without(tags::IMAGE_POSITION_PATIENT).text(tags::SLICE_THICKNESS, "2.5")
    };
    let loaded = read_all(&bytes([bare(0), bare(1)])).unwrap();
    assert_eq!(values(&loaded)[0], 6.0);
    assert_eq!((loaded.info.space, loaded.volume.grid().unwrap().placement().spacing().z), (Space::Own, 2.5));
    assert!(loaded.notes[0].contains("in order of InstanceNumber"), "{:?}", loaded.notes);
    assert!(refusal(&bytes([bare(0), bare(0)])).contains("InstanceNumber"));
}

#[test]
fn two_times_are_two_frames() {
    let at = |z, first, time: &str| Sample::slice(z, first).text(tags::TEMPORAL_POSITION_IDENTIFIER, time);
    let files = bytes([at(0.0, 12, "2"), at(1.0, 6, "1"), at(0.0, 0, "1"), at(1.0, 18, "2")]);
    let late = ReadOptions { frame: Some(1), ..ReadOptions::default() };
    assert_eq!(values(&read_with(&files, &late).unwrap()), count_from(12, 12));
}

#[test]
fn other_codings_of_the_same_voxels() {
    let [a, b] = [(0.0, 100), (2.0, 106)];
    let wanted = count_from(100, 12);
    // Deflated: all after the meta information.
    let deflated = |(z, first): (f64, i16)| {
        use std::io::Write;
        let mut e = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::best());
        e.write_all(&Sample::slice(z, first).data_set()).unwrap();
        [meta("1.2.840.10008.1.2.1.99"), e.finish().unwrap()].concat()
    };
    let loaded = read_all(&[deflated(a), deflated(b)]).unwrap();
    assert_eq!((values(&loaded), loaded.info.encoding), (wanted.clone(), "deflate"));

    // RLE: a segment of high bytes, one of low bytes.
    let rle = |(z, first): (f64, i16)| {
        let mut frame = [2u32, 64, 66].map(u32::to_le_bytes).concat();
        frame.resize(64, 0);
        frame.extend([0xfb, 0, 5]);
        frame.extend((first..first + 6).map(|v| v as u8));
        let mut sample = Sample::slice(z, first).without(tags::PIXEL_DATA);
        sample.transfer_syntax = "1.2.840.10008.1.2.5".into();
        [sample.bytes(), encapsulated(&[frame])].concat()
    };
    let loaded = read_all(&[rle(a), rle(b)]).unwrap();
    assert_eq!((values(&loaded), loaded.info.encoding), (wanted.clone(), "RLE"));
    let mut cut = rle(a);
    cut.truncate(cut.len() - 12);
    assert!(read_all(&[cut, rle(b)]).is_err());

    // JPEG of flat grey, which it keeps.
    let jpeg = |(z, grey): (f64, u8)| {
        let mut frame = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut frame, 100)
            .encode(&[grey; 6], 3, 2, image::ExtendedColorType::L8)
            .unwrap();
        let sample = Sample::slice(z, 0).without(tags::PIXEL_DATA).short(tags::PIXEL_REPRESENTATION, 0);
        let mut sample = sample.short(tags::BITS_ALLOCATED, 8).short(tags::BITS_STORED, 8).short(tags::HIGH_BIT, 7);
        sample.transfer_syntax = "1.2.840.10008.1.2.4.50".into();
        [sample.bytes(), encapsulated(&[frame])].concat()
    };
    let loaded = read_all(&[jpeg((2.0, 200)), jpeg((0.0, 80))]).unwrap();
    assert_eq!((values(&loaded), loaded.info.encoding), ([[80.0; 6], [200.0; 6]].concat(), "JPEG"));

    // Without preamble and meta information.
    let bare = |(z, first): (f64, i16)| Sample::slice(z, first).text(tags::IMAGE_TYPE, "ORIGINAL").data_set();
    assert_eq!(values(&read_all(&[bare(a), bare(b)]).unwrap()), wanted);

    let unread = |uid: &str| {
        let mut sample = Sample::slice(0.0, 0).without(tags::PIXEL_DATA);
        sample.transfer_syntax = uid.into();
        refusal(&[[sample.bytes(), encapsulated(&[vec![0; 8]])].concat()])
    };
    if !cfg!(feature = "jpeg2000") {
        let message = unread("1.2.840.10008.1.2.4.90");
        assert!(
            message.contains("frames in JPEG 2000 is read by builds with the feature `jpeg2000` alone"),
            "{message}"
        );
    }
    assert!(unread("1.2.840.10008.1.2.4.201").contains("found High-Throughput JPEG 2000"));
    assert!(unread("1.2.840.10008.1.2.4.50").contains("slices"));
}

/// A file of two frames of a coded sample.
fn coded_frames(uid: &str, code: &[u8], bits: u16, samples: u16, photometric: &str) -> Vec<u8> {
    let allocated = bits.next_multiple_of(8);
    let sample = Sample::slice(0.0, 0).without(tags::PIXEL_DATA).text(tags::NUMBER_OF_FRAMES, "2");
    let sample = sample.short(tags::BITS_ALLOCATED, allocated).short(tags::BITS_STORED, bits);
    let sample = sample.short(tags::HIGH_BIT, bits - 1).short(tags::PIXEL_REPRESENTATION, 0);
    let sample = sample.short(tags::ROWS, ROWS as u16).short(tags::COLUMNS, COLUMNS as u16);
    let sample = sample.short(tags::SAMPLES_PER_PIXEL, samples).text(tags::PHOTOMETRIC_INTERPRETATION, photometric);
    let mut sample = sample.short(tags::PLANAR_CONFIGURATION, 0).text(tags::SLICE_THICKNESS, "2");
    sample.transfer_syntax = uid.into();
    [sample.bytes(), encapsulated(&[code.to_vec(), code.to_vec()])].concat()
}

#[test]
fn frames_in_jpeg_ls() {
    let grey = include_bytes!("coded_samples/grey12_near0.jls");
    let loaded = read_all(&[coded_frames("1.2.840.10008.1.2.4.80", grey, 12, 1, "MONOCHROME2")]).unwrap();
    let wanted: Vec<f32> = picture(12, 1).repeat(2).into_iter().map(|x| x as f32).collect();
    assert_eq!((values(&loaded), loaded.info.encoding), (wanted, "JPEG-LS"));
    let colors = include_bytes!("coded_samples/rgb_lines_near0.jls");
    let loaded = read_all(&[coded_frames("1.2.840.10008.1.2.4.80", colors, 8, 3, "RGB")]).unwrap();
    assert!(loaded.volume.colors().is_some());
    let cut = coded_frames("1.2.840.10008.1.2.4.81", &grey[..grey.len() / 2], 12, 1, "MONOCHROME2");
    assert!(refusal(&[cut]).contains("JPEG-LS data are damaged"));
}

#[cfg(feature = "jpeg2000")]
#[test]
fn frames_in_jpeg_2000() {
    let grey = include_bytes!("coded_samples/grey12.j2k");
    let loaded = read_all(&[coded_frames("1.2.840.10008.1.2.4.90", grey, 12, 1, "MONOCHROME2")]).unwrap();
    let wanted: Vec<f32> = picture(12, 1).repeat(2).into_iter().map(|x| x as f32).collect();
    assert_eq!((values(&loaded), loaded.info.encoding), (wanted, "JPEG 2000"));
    let colors = include_bytes!("coded_samples/rgb_rct.j2k");
    let loaded = read_all(&[coded_frames("1.2.840.10008.1.2.4.91", colors, 8, 3, "YBR_RCT")]).unwrap();
    let vr_core::AnyGrid::U8(values) = loaded.volume.colors().expect("RGB").values().values().clone() else {
        panic!("bytes")
    };
    assert_eq!(values.samples().len(), 2 * ROWS * COLUMNS);
    let cut = coded_frames("1.2.840.10008.1.2.4.91", &grey[..grey.len() / 2], 12, 1, "MONOCHROME2");
    assert!(refusal(&[cut]).contains("JPEG 2000 data are damaged"));
}

#[test]
fn big_endian_and_implicit_data_sets() {
    // The same elements, coded anew: none of these is a sequence.
    let recode = |bytes: &[u8], big: bool| {
        let (mut at, mut out) = (0, Vec::new());
        while at < bytes.len() {
            let tag = [0, 2].map(|i| u16::from_le_bytes([bytes[at + i], bytes[at + i + 1]]));
            let vr = [bytes[at + 4], bytes[at + 5]];
            let long = &vr == b"OW";
            let (start, length) = if long {
                (at + 12, u32::from_le_bytes(*bytes[at + 8..].first_chunk().unwrap()))
            } else {
                (at + 8, u32::from(u16::from_le_bytes([bytes[at + 6], bytes[at + 7]])))
            };
            let mut value = bytes[start..start + length as usize].to_vec();
            at = start + length as usize;
            if big {
                tag.iter().for_each(|t| out.extend(t.to_be_bytes()));
                out.extend(vr);
                if long {
                    out.extend([0, 0]);
                    out.extend(length.to_be_bytes());
                } else {
                    out.extend((length as u16).to_be_bytes());
                }
                if long || &vr == b"US" {
                    value.chunks_exact_mut(2).for_each(<[u8]>::reverse);
                }
            } else {
                tag.iter().for_each(|t| out.extend(t.to_le_bytes()));
                out.extend(length.to_le_bytes());
            }
            out.extend(value);
        }
        out
    };
    for (uid, big) in [("1.2.840.10008.1.2.2", true), ("1.2.840.10008.1.2", false)] {
        let file = |z, first| [meta(uid), recode(&Sample::slice(z, first).data_set(), big)].concat();
        let loaded = read_all(&[file(0.0, 100), file(2.0, 106)]).unwrap();
        assert_eq!(values(&loaded), count_from(100, 12), "{uid}");
        assert_eq!(loaded.volume.grid().unwrap().placement().spacing().to_array(), [0.5, 0.75, 2.0]);
    }
}

/// No damage may bring it down.
#[test]
fn every_byte_changed_and_every_cut() {
    let dir = tempfile::tempdir().unwrap();
    let path: PathBuf = dir.path().join("x.dcm");
    let good = enhanced().bytes();
    for at in 128..good.len() {
        for value in [0, 0xff, good[at] ^ 0x10] {
            let mut bytes = good.clone();
            bytes[at] = value;
            std::fs::write(&path, &bytes).unwrap();
            let _ = read(&path, &ReadOptions { map: false, ..ReadOptions::default() });
        }
        std::fs::write(&path, &good[..at]).unwrap();
        assert!(read(&path, &ReadOptions::default()).is_err(), "{at}");
    }
}
