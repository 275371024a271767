//! Stacks written by the encoder of the crate, and one by hand.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use tiff::encoder::{Compression, DeflateLevel, Rational, TiffEncoder, colortype};
use tiff::tags::{ResolutionUnit, Tag};
use vr_core::{Voxel, with_grid};

use crate::{Loaded, ReadOptions, read};

fn numbers(loaded: &Loaded) -> Vec<f32> {
    with_grid!(loaded.volume.grid().unwrap().values(), g => g.samples().iter().map(|s| g.calibration().value(f64::from(s.to_f32())) as f32).collect())
}

/// Pixels of page `z`: 3×2.
fn page(z: u16) -> Vec<u16> {
    (0..6).map(|i| 1000 * z + i).collect()
}

fn expected(pages: &[u16]) -> Vec<f32> {
    pages.iter().flat_map(|&z| page(z)).map(f32::from).collect()
}

struct Options<'a> {
    compression: Compression,
    description: &'a str,
    resolution: Option<(ResolutionUnit, u32)>,
}

const PLAIN: Options<'_> = Options { compression: Compression::Uncompressed, description: "", resolution: None };

/// Writes a stack of `pages` pages.
fn write(folder: &Path, pages: u16, options: &Options<'_>) -> PathBuf {
    let path = folder.join("stack.tif");
    let mut encoder =
        TiffEncoder::new(BufWriter::new(File::create(&path).unwrap())).unwrap().with_compression(options.compression);
    for z in 0..pages {
        let mut image = encoder.new_image::<colortype::Gray16>(3, 2).unwrap();
        if let Some((unit, n)) = options.resolution {
            image.resolution(unit, Rational { n, d: 1 });
        }
        if !options.description.is_empty() {
            image.encoder().write_tag(Tag::ImageDescription, options.description).unwrap();
        }
        image.write_data(&page(z)).unwrap();
    }
    drop(encoder);
    path
}

fn load(path: &Path) -> Loaded {
    read(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn spacing(loaded: &Loaded) -> [f64; 3] {
    loaded.volume.grid().unwrap().placement().spacing().to_array()
}

#[test]
fn pages_are_slices_in_every_compression() {
    let folder = tempfile::tempdir().unwrap();
    let all = [
        (Compression::Uncompressed, "raw"),
        (Compression::Lzw, "lzw"),
        (Compression::Deflate(DeflateLevel::Fast), "deflate"),
        (Compression::Packbits, "packbits"),
    ];
    for (compression, name) in all {
        // More pages than are decoded at once by each thread.
        let path = write(folder.path(), 23, &Options { compression, ..PLAIN });
        let loaded = load(&path);
        assert_eq!(loaded.volume.grid().unwrap().dims(), [3, 2, 23]);
        assert_eq!(numbers(&loaded), expected(&(0..23).collect::<Vec<_>>()), "{name}");
        assert_eq!((loaded.info.format, loaded.info.encoding), ("TIFF", name));
        assert_eq!(loaded.notes, ["TIFF states no spacing: 1, 1, 1 is assumed"]);
    }
}

#[test]
fn types_and_bigtiff() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    macro_rules! check {
        ($new:ident, $color:ident, $t:ty, $low:expr) => {{
            let mut encoder = TiffEncoder::$new(File::create(&path).unwrap()).unwrap();
            for z in 0..2 {
                let pixels: Vec<$t> = (0..4).map(|i| $low + (10 * z + i) as $t).collect();
                encoder.write_image::<colortype::$color>(2, 2, &pixels).unwrap();
            }
            drop(encoder);
            let wanted = [0, 1, 2, 3, 10, 11, 12, 13].map(|i| ($low + i as $t) as f32);
            assert_eq!(numbers(&load(&path)), wanted, stringify!($color));
        }};
    }
    check!(new, Gray8, u8, 1u8);
    check!(new_big, GrayI8, i8, -5i8);
    check!(new_big, Gray16, u16, 500u16);
    check!(new, GrayI16, i16, -500i16);
    check!(new, Gray32, u32, 70_000u32);
    check!(new, GrayI32, i32, -70_000i32);
    check!(new_big, Gray32Float, f32, 0.5f32);
    check!(new, Gray64Float, f64, -0.25f64);
}

#[test]
fn imagej_says_what_the_pages_are() {
    let folder = tempfile::tempdir().unwrap();
    let description =
        "ImageJ=1.53t\nimages=12\nchannels=2\nslices=3\nframes=2\nhyperstack=true\nunit=\\u00B5m\nspacing=2.5\n";
    for compression in [Compression::Uncompressed, Compression::Lzw] {
        let resolution = Some((ResolutionUnit::None, 4));
        let path = write(folder.path(), 12, &Options { compression, description, resolution });
        let first = read(&path, &ReadOptions::default()).unwrap();
        assert!(first.notes.contains(&"frame 0 is taken, of 0 to 1".to_owned()), "{:?}", first.notes);
        let loaded = read(&path, &ReadOptions { frame: Some(1), component: Some(1), ..Default::default() }).unwrap();
        assert_eq!(numbers(&loaded), expected(&[7, 9, 11]));
        assert_eq!((spacing(&loaded), loaded.info.units.as_deref()), ([0.25, 0.25, 2.5], Some("µm")));
        assert_eq!((loaded.info.frames, loaded.info.components), (2, 2));
    }
    let description = "ImageJ=1.53t\nimages=4\nframes=4\n";
    let loaded = load(&write(folder.path(), 4, &Options { description, ..PLAIN }));
    assert_eq!(loaded.volume.grid().unwrap().dims(), [3, 2, 4]);
    assert!(loaded.notes.iter().any(|n| n.contains("4 times of one slice")), "{:?}", loaded.notes);
    let description = "ImageJ=1.53t\nimages=9\nslices=9\n";
    let loaded = load(&write(folder.path(), 4, &Options { description, compression: Compression::Lzw, ..PLAIN }));
    assert!(loaded.notes.iter().any(|n| n.contains("names 9 pages and the file has 4")), "{:?}", loaded.notes);
}

#[test]
fn all_pages_behind_one_directory() {
    // A page of ImageJ, its text, and the pixels of two more behind it.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("big.tif");
    let text = b"ImageJ=1.53t\nimages=3\nslices=3\n\0";
    let entries: [(u16, u16, u32, u32); 9] = [
        (256, 4, 1, 3),
        (257, 4, 1, 2),
        (258, 3, 1, 16),
        (259, 3, 1, 1),
        (262, 3, 1, 1),
        (270, 2, text.len() as u32, 8 + 2 + 9 * 12 + 4),
        (273, 4, 1, (8 + 2 + 9 * 12 + 4 + text.len()) as u32),
        (278, 4, 1, 2),
        (279, 4, 1, 12),
    ];
    let mut file = b"MM\0*\0\0\0\x08\0\x09".to_vec();
    for (tag, kind, count, value) in entries {
        file.extend(tag.to_be_bytes());
        file.extend(kind.to_be_bytes());
        file.extend(count.to_be_bytes());
        file.extend(if kind == 3 { value << 16 } else { value }.to_be_bytes());
    }
    file.extend([0; 4]);
    file.extend(text);
    (0..3).for_each(|z| page(z).iter().for_each(|v| file.extend(v.to_be_bytes())));
    file.extend(b"what follows");
    std::fs::write(&path, &file).unwrap();
    let loaded = load(&path);
    assert_eq!(numbers(&loaded), expected(&[0, 1, 2]));
    assert!(!loaded.notes.iter().any(|n| n.contains("unread")), "{:?}", loaded.notes);
    std::fs::write(&path, &file[..file.len() - 13]).unwrap();
    let message = read(&path, &ReadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("claims 36 bytes of voxels, found 35"), "{message}");
}

#[test]
fn ome_xml_says_what_the_pages_are() {
    let folder = tempfile::tempdir().unwrap();
    let ome = |pixels: &str| {
        let start = "<?xml version=\"1.0\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\"><Image ID=\"Image:0\">";
        format!("{start}<Pixels {pixels}><TiffData/></Pixels></Image></OME>")
    };
    let description = &ome("DimensionOrder=\"XYZCT\" SizeX=\"3\" SizeY=\"2\" SizeZ=\"2\" SizeC=\"3\" SizeT=\"1\" \
        PhysicalSizeX=\"200\" PhysicalSizeXUnit=\"nm\" PhysicalSizeY=\"0.3\" PhysicalSizeZ=\"1.5\"");
    let path = write(folder.path(), 6, &Options { description, compression: Compression::Lzw, ..PLAIN });
    let loaded = read(&path, &ReadOptions { component: Some(2), ..Default::default() }).unwrap();
    assert_eq!(numbers(&loaded), expected(&[4, 5]));
    assert_eq!((loaded.info.format, loaded.info.units.as_deref()), ("OME-TIFF", Some("nm")));
    let found = spacing(&loaded);
    assert!(found.iter().zip([200.0, 300.0, 1500.0]).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    for (pixels, message) in [
        ("DimensionOrder=\"XYZZT\"", "DimensionOrder: found XYZZT"),
        ("SizeZ=\"-1\"", "SizeZ: found -1"),
        ("PhysicalSizeX=\"0\" PhysicalSizeY=\"1\"", "PhysicalSizeX: found 0"),
    ] {
        let description = &ome(pixels);
        let path = write(folder.path(), 6, &Options { description, ..PLAIN });
        let found = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(found.contains(message), "{found}");
    }
}

#[test]
fn resolution_in_centimetres_counts_and_that_of_a_screen_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let with = |unit, n| load(&write(folder.path(), 2, &Options { resolution: Some((unit, n)), ..PLAIN }));
    let loaded = with(ResolutionUnit::Centimeter, 20);
    assert_eq!((spacing(&loaded), loaded.info.units.as_deref()), ([0.5; 3], Some("mm")));
    assert!(loaded.notes[0].contains("that of columns, 0.5, is assumed"), "{:?}", loaded.notes);
    let loaded = with(ResolutionUnit::Inch, 72);
    assert_eq!((spacing(&loaded), loaded.info.units.as_deref()), ([1.0; 3], None));
    assert!(loaded.notes[0].contains("screen's"), "{:?}", loaded.notes);
}

#[test]
fn colours_are_components_and_thumbnails_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let mut encoder = TiffEncoder::new(File::create(&path).unwrap()).unwrap();
    for z in 0..2u8 {
        let pixels: Vec<u8> = (0..4).flat_map(|i| [z * 4 + i, 100 + z * 4 + i, 200]).collect();
        encoder.write_image::<colortype::RGB8>(2, 2, &pixels).unwrap();
        encoder.write_image::<colortype::RGB8>(1, 1, &[1, 2, 3]).unwrap();
    }
    drop(encoder);
    assert!(read(&path, &ReadOptions::default()).unwrap().volume.colors().is_some());
    let red = read(&path, &ReadOptions { component: Some(0), ..Default::default() }).unwrap();
    assert_eq!(numbers(&red), [0., 1., 2., 3., 4., 5., 6., 7.]);
    let loaded = read(&path, &ReadOptions { component: Some(1), ..Default::default() }).unwrap();
    assert_eq!(numbers(&loaded), [100., 101., 102., 103., 104., 105., 106., 107.]);
    assert!(loaded.notes[0].contains("than the first page: 2 (page 2, 1×1 u8 with 3 channels)"), "{:?}", loaded.notes);
}

#[test]
fn files_that_are_cut_off_or_lie() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), 3, &Options { compression: Compression::Deflate(DeflateLevel::Fast), ..PLAIN });
    let whole = std::fs::read(&path).unwrap();
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        // No word but an error, and no panic; an early end of the chain may leave whole pages.
        let _ = read(&path, &ReadOptions::default());
    }
    for at in 0..whole.len() {
        for value in [0, 0x7f, 0xff] {
            let mut damaged = whole.clone();
            damaged[at] = value;
            std::fs::write(&path, &damaged).unwrap();
            let _ = read(&path, &ReadOptions::default());
        }
    }
    let one = write(folder.path(), 1, &PLAIN);
    assert!(read(&one, &ReadOptions::default()).is_err(), "one page is no volume");
}
