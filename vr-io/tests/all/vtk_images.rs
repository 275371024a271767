//! Images of VTK, XML and legacy, in every encoding, and what is refused of them.

use crate::tiny;

use std::path::PathBuf;

use crate::small_images::{Array, IMAGE, all_vti, halves, point_arrays, vti, vti_of, vtk};
use crate::small_points::{Packed, Stored};
use crate::tiny::{COUNT, DIMS, expected, sample, stored};
use glam::DVec3;
use vr_core::VoxelType;
use vr_io::{Endian, Loaded, ReadOptions, ScalarType, Space, read};

/// A file in a folder that lives as long.
struct Put {
    path: PathBuf,
    _folder: tempfile::TempDir,
}

fn put(name: &str, bytes: &[u8]) -> Put {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Put { path, _folder: folder }
}

fn load(bytes: &[u8]) -> Loaded {
    load_with(bytes, &ReadOptions::default())
}

fn load_with(bytes: &[u8], options: &ReadOptions) -> Loaded {
    read(&put("x", bytes).path, options).unwrap_or_else(|e| panic!("{e}"))
}

fn array(name: &str) -> ReadOptions {
    ReadOptions { array: Some(name.to_owned()), ..ReadOptions::default() }
}

/// Checks that the error is one line with all of these words.
#[track_caller]
fn refused(bytes: &[u8], words: &[&str]) {
    refused_with(bytes, &ReadOptions::default(), words);
}

#[track_caller]
fn refused_with(bytes: &[u8], options: &ReadOptions, words: &[&str]) {
    let error = read(put("x", bytes).path, options).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    for word in words {
        assert!(error.contains(word), "no {word:?} in {error}");
    }
}

fn origin(loaded: &Loaded) -> DVec3 {
    loaded.volume.grid().unwrap().placement().origin()
}

fn is_the_image(loaded: &Loaded, what: &str) {
    let grid = loaded.volume.grid().unwrap();
    assert_eq!((grid.dims(), stored(loaded)), (DIMS, expected()), "{what}");
    assert_eq!(grid.voxel_type(), VoxelType::I16, "{what}");
    let placement = grid.placement();
    assert_eq!((placement.origin(), placement.spacing()), (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.5, 1.0, 2.0)));
    assert_eq!((loaded.info.space, loaded.info.placed_by), (Space::Own, "Spacing"), "{what}");
    assert!(loaded.notes.iter().any(|n| n.contains("'density stored' of the points is taken")), "{:?}", loaded.notes);
}

#[test]
fn every_encoding_holds_the_same_image() {
    for (what, file) in all_vti() {
        let loaded = load(&file);
        is_the_image(&loaded, &what);
        assert_eq!((loaded.info.format, loaded.info.scalar), ("VTK ImageData", ScalarType::I16));
        assert_eq!(loaded.notes.len(), 1, "{what}: {:?}", loaded.notes);
        let second = load_with(&file, &ReadOptions { component: Some(1), ..array("Velocity") });
        assert_eq!(stored(&second), expected().iter().map(|x| x * 10.0).collect::<Vec<_>>(), "{what}");
        assert_eq!(second.info.components, 3);
    }
    for binary in [false, true] {
        let loaded = load(&vtk(binary));
        is_the_image(&loaded, "legacy");
        assert_eq!((loaded.info.format, loaded.info.endian), ("VTK (legacy)", Endian::Big));
        let by_name = |name| stored(&load_with(&vtk(binary), &array(name)));
        assert_eq!(by_name("index"), (0..24).map(|i| i as f32).collect::<Vec<_>>());
        assert_eq!(by_name("even")[..3], [1.0, 0.0, 1.0]);
    }
}

#[test]
fn uncompressed_numbers_stay_in_the_file() {
    // The mapping begins at a multiple of the type's size only by chance: blanks bring it there.
    let mapped = (0..4).map(|blanks| {
        let image = format!("{IMAGE}{}", " ".repeat(blanks));
        let piece = ("0 3 0 2 0 1", point_arrays(false), Vec::new());
        let file = vti_of(&image, &[piece], Stored::AppendedRaw, Packed::No, false, false);
        let loaded = load(&file);
        assert_eq!((loaded.info.encoding, stored(&loaded)), ("raw", expected()));
        loaded.info.mapped
    });
    assert_eq!(mapped.filter(|&mapped| mapped).count(), if cfg!(target_endian = "little") { 2 } else { 0 });
    let bytes = load_with(&vtk(true), &array("index"));
    assert!(bytes.info.mapped);
    assert!(bytes.notes.is_empty(), "{:?}", bytes.notes);
}

#[test]
fn appended_bytes_are_no_text() {
    let bytes = vec![0xff; 24];
    let begin = "type=\"UInt8\" Name=\"density stored\"";
    let piece = ("0 3 0 2 0 1", vec![Array { begin, bytes, words: String::new() }], Vec::new());
    let loaded = load(&vti_of(IMAGE, &[piece], Stored::AppendedRaw, Packed::No, false, false));
    assert!(loaded.info.mapped);
    assert_eq!(stored(&loaded), [255.0; 24]);
}

#[test]
fn numbers_of_cells_lie_at_their_centres() {
    let numbers: Vec<u8> = (0..18).map(|i| i * 3).collect();
    let cells = || {
        let words = numbers.iter().map(|n| format!("{n} ")).collect();
        vec![Array { begin: "type=\"UInt8\" Name=\"level\"", bytes: numbers.clone(), words }]
    };
    let image = "WholeExtent=\"2 5 -1 2 0 2\" Origin=\"10 20 30\" Spacing=\"1 2 4\"";
    for stored_as in [Stored::Ascii, Stored::AppendedRaw] {
        let piece = ("2 5 -1 2 0 2", Vec::new(), cells());
        let loaded = load(&vti_of(image, &[piece], stored_as, Packed::No, false, false));
        assert_eq!(loaded.volume.grid().unwrap().dims(), [3, 3, 2]);
        assert_eq!(stored(&loaded), numbers.iter().map(|&n| f32::from(n)).collect::<Vec<_>>());
        assert_eq!(origin(&loaded), DVec3::new(12.5, 19.0, 32.0));
        assert!(loaded.notes.iter().any(|n| n.contains("begin at 2, -1, 0")), "{:?}", loaded.notes);
        assert!(loaded.notes.iter().any(|n| n.contains("centre of its cell")), "{:?}", loaded.notes);
    }
    let legacy = "# vtk DataFile Version 1.0\ncells\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 3 3 3\n\
                  ASPECT_RATIO 1 2 4\nCELL_DATA 8\nSCALARS level int\n1 2 3 4 5 6 7 8\n";
    let loaded = load(legacy.as_bytes());
    assert_eq!((stored(&loaded)[7], origin(&loaded)), (8.0, DVec3::new(0.5, 1.0, 2.0)));
}

#[test]
fn pieces_are_put_together() {
    let loaded = load(&halves());
    assert_eq!((loaded.volume.grid().unwrap().dims(), stored(&loaded)), (DIMS, expected()));
    assert_eq!((origin(&loaded), loaded.info.placed_by), (DVec3::new(10.0, 0.0, 0.0), "assumed"));
    for words in ["from 2 pieces", "no spacing", "begin at 10, 0, 0"] {
        assert!(loaded.notes.iter().any(|n| n.contains(words)), "{:?}", loaded.notes);
    }
    let part = |extent| (extent, point_arrays(false), Vec::new());
    let of = |pieces: &[_], stored| vti_of(IMAGE, pieces, stored, Packed::No, false, false);
    // A gap, and a piece that is smaller than it claims.
    refused(&of(&[part("0 3 0 2 0 1"), part("0 3 0 2 5 6")], Stored::Ascii), &["Piece, Extent", "gap"]);
    refused(&of(&[part("0 3 0 2 0 1"), part("0 3 0 2 1 9")], Stored::Inline), &["array density stored", "need 216"]);
    let mut other = part("0 3 0 2 1 2");
    other.1.pop();
    refused(&of(&[part("0 3 0 2 0 1"), other], Stored::Ascii), &["array density stored", "every piece"]);
    // A piece that is not the whole.
    let whole = String::from_utf8(vti(Stored::Ascii, Packed::No, false, false)).unwrap();
    let loaded = load(whole.replace("WholeExtent=\"0 3 0 2 0 1\"", "WholeExtent=\"0 9 0 9 0 9\"").as_bytes());
    assert!(loaded.notes.iter().any(|n| n.contains("the box around them is taken")), "{:?}", loaded.notes);
}

#[test]
fn a_direction_turns_the_axes() {
    let text = String::from_utf8(vti(Stored::Ascii, Packed::No, false, false)).unwrap();
    let turned = text.replace("Direction=\"1 0 0 0 1 0 0 0 1\"", "Direction='0 1 0 -1 0 0 0 0 1'");
    let loaded = load(turned.as_bytes());
    let axes = loaded.volume.grid().unwrap().placement().axes();
    // The second column of the rows 0 1 0, -1 0 0, 0 0 1, times the spacing.
    assert_eq!((axes.x_axis, axes.y_axis), (DVec3::new(0.0, -0.5, 0.0), DVec3::new(1.0, 0.0, 0.0)));
    assert_eq!(loaded.info.placed_by, "Direction");
}

#[test]
fn arrays_are_chosen_by_name() {
    let file = vti(Stored::Inline, Packed::Lz4, false, false);
    refused_with(&file, &array("heat"), &["array: found heat; must be one of velocity, density stored"]);
    refused_with(&vtk(true), &array("heat"), &["must be one of velocity, density stored, index, even, level"]);
    // Where there is one array, it has no name to choose.
    let nrrd = tiny::nrrd("type: uchar\nencoding: raw", &[7; COUNT]);
    refused_with(&nrrd, &array("heat"), &["array: found heat", "one array, without a name"]);
    // Of points, it is that of the values.
    let points = put("x.csv", b"x,y,z,heat\n0,0,0,5\n1,0,0,6\n0,1,0,7\n");
    let loaded = read(&points.path, &array("heat")).unwrap();
    assert_eq!(loaded.volume.points().unwrap().values(), [5.0, 6.0, 7.0]);
}

#[test]
fn broken_images_are_refused_with_reasons() {
    let text = String::from_utf8(vti(Stored::Ascii, Packed::No, false, false)).unwrap();
    let replaced = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to).into_bytes()
    };
    refused(&replaced("Piece Extent=\"0 3 0 2 0 1\"", "Piece"), &["Piece, Extent", "nothing"]);
    refused(&replaced("Extent=\"0 3 0 2 0 1\"", "Extent=\"0 3 0 2 0\""), &["Extent: found 0 3 0 2 0; must be six"]);
    refused(&replaced("Extent=\"0 3 0 2 0 1\"", "Extent=\"0 3 0 2 0 0\""), &["dims [4, 3, 1]: every axis"]);
    refused(&replaced("Extent=\"0 3 0 2 0 1\"", "Extent=\"0 3 0 2 0 -1\""), &["Piece: found none with points"]);
    let huge = "Extent=\"0 2000000000 0 2000000000 0 2000000000\"";
    refused(&replaced("Extent=\"0 3 0 2 0 1\"", huge), &["dims [2000000001, 2000000001, 2000000001]"]);
    let large = "Extent=\"0 20000 0 20000 0 20000\"";
    refused(&replaced("Extent=\"0 3 0 2 0 1\"", large), &["array density stored", "24 numbers", "8001200060001"]);
    refused(&replaced("Spacing=\"0.5 1 2\"", "Spacing=\"0.5 0 2\""), &["spacing of axis 1: found 0"]);
    refused(&replaced("Spacing=\"0.5 1 2\"", "Spacing=\"0.5 nan 2\""), &["spacing of axis 1: found NaN"]);
    refused(&replaced("Spacing=\"0.5 1 2\"", "Spacing=\"0.5 2\""), &["Spacing: found 0.5 2; must be three numbers"]);
    refused(&replaced("1 0 0 0 1 0 0 0 1", "1 1 0 0 0 0 0 0 1"), &["linearly independent"]);
    refused(&replaced("type=\"ImageData\"", "type=\"HyperTreeGrid\""), &["unsupported format VTK HyperTreeGrid (.htg"]);
    refused(&replaced("type=\"ImageData\"", "type=\"PImageData\""), &["PImageData: found nothing; PImageData has"]);
    refused(&text.as_bytes()[..text.len() / 2], &["XML", "must be well-formed and whole"]);
    refused(&tiny::gzip(text.as_bytes()), &["VTK in a compressed file"]);
    // A number of the scalars alone.
    let last = sample(23).to_string();
    refused(&replaced(&format!(" {last} "), " one "), &["array density stored", "one", "a number of type i16"]);
    let raw = vti(Stored::AppendedRaw, Packed::No, false, false);
    let end = raw.windows(14).position(|w| w == b"\n</AppendedDat").unwrap();
    refused(&raw[..end - 1], &["claims 48 bytes of voxels, found 47", "is the file whole?"]);
    refused(&raw[..end - 50], &["array density stored", "the end of the data"]);
    refused(&raw[..end - 60], &["array density stored, offset", "within the"]);

    let text = String::from_utf8(vtk(false)).unwrap();
    let legacy = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1).into_bytes()
    };
    refused(&legacy("DIMENSIONS 4 3 2", "DIMENSIONS 4 3 0"), &["DIMENSIONS", "must be positive"]);
    refused(&legacy("DIMENSIONS 4 3 2", "DIMENSIONS 4 3 -2"), &["line 8", "DIMENSIONS 4 3 -2", "whole number"]);
    refused(&legacy("DIMENSIONS 4 3 2", "DIMENSIONS 4 3"), &["line 8", "must have more words"]);
    refused(&legacy("DIMENSIONS 4 3 2\n", ""), &["DIMENSIONS: found nothing"]);
    refused(&legacy("DIMENSIONS 4 3 2", "DIMENSIONS 4 3 3"), &["POINT_DATA: found 24; DIMENSIONS make 4 x 3 x 3"]);
    refused(&legacy("SPACING 0.5 1 2", "SPACING 0.5 1"), &["SPACING 0.5 1; must hold three numbers"]);
    refused(&legacy("density%20stored short", "density%20stored string"), &["string", "must be a type of numbers"]);
    refused(&legacy("STRUCTURED_POINTS", "RECTILINEAR_GRID"), &["X_COORDINATES: found nothing"]);
    refused(&legacy("DATASET", "DATUMSET"), &["line 4", "a section begins here"]);
    refused(&text.as_bytes()[..text.len() / 2], &["array "]);
    refused(&legacy(&format!(" {last} "), " one "), &["array density stored", "one", "type i16"]);
    let binary = vtk(true);
    refused(&binary[..binary.len() - 2], &["array even", "2 bytes left"]);
    let at = binary.windows(13).position(|w| w == b"POINT_DATA 24").unwrap();
    let claims = [&binary[..at], b"POINT_DATA 240000000000000", &binary[at + 13..]].concat();
    refused(&claims, &["array velocity", "720000000000000 numbers of f32"]);
}

#[test]
fn scalars_may_have_no_table_and_an_extent_may_stand_for_dimensions() {
    let head = "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nEXTENT 3 4 0 1 0 1\nSPACING 1 1 1\n\
                POINT_DATA 8\nSCALARS s short 2\n";
    let mut file = head.as_bytes().to_vec();
    // What a line would end at.
    file.extend((0..16i16).flat_map(|i| (i + 0x0a00).to_be_bytes()));
    let loaded = load_with(&file, &ReadOptions { component: Some(1), ..ReadOptions::default() });
    assert_eq!(stored(&loaded), (0..8).map(|i| f32::from(2 * i + 1 + 0x0a00i16)).collect::<Vec<_>>());
    assert_eq!(origin(&loaded), DVec3::new(3.0, 0.0, 0.0));
}

#[test]
fn colours_in_words_are_shares_of_255() {
    let text = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\nSPACING 1 1 1\n\
                POINT_DATA 8\nSCALARS before int\nLOOKUP_TABLE default\n1 1 1 1 1 1 1 1\nCOLOR_SCALARS c 1\n\
                0 0.2 0.372549 1 2 -1 0.054902 0\n";
    let loaded = load_with(text.as_bytes(), &array("c"));
    assert_eq!(stored(&loaded), [0.0, 51.0, 95.0, 255.0, 255.0, 0.0, 14.0, 0.0]);
    assert_eq!((loaded.info.scalar, loaded.info.encoding), (ScalarType::U8, "ascii"));
}
