//! Every format of scattered points, and what is said of those that are broken.

use glam::DVec3;
use vr_io::{FileError, FileErrorKind, LoadedPoints, PointOptions, ReadOptions, read_points};

use crate::small_points;
use crate::small_points::{POINTS, Packed, Stored, all_vtp, csv, npy, vtk_binary, vtk_text, vtp};

fn read(name: &str, bytes: impl AsRef<[u8]>) -> Result<LoadedPoints, FileError> {
    read_with(name, bytes, &PointOptions::default())
}

fn read_with(name: &str, bytes: impl AsRef<[u8]>, options: &PointOptions) -> Result<LoadedPoints, FileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_points(&path, options)
}

/// The three points with radii of two smoothing lengths, and temperatures.
#[track_caller]
fn is_the_three_points(loaded: &LoadedPoints, what: &str) {
    let points = &loaded.points;
    let positions: Vec<DVec3> = POINTS.iter().map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into())).collect();
    assert_eq!(points.positions(), positions, "{what}");
    assert_eq!(points.radii(), POINTS.map(|p| 2.0 * p[3]), "{what}");
    assert_eq!(points.values(), POINTS.map(|p| p[4]), "{what}");
    let volumes = POINTS.map(|p| (f64::from(2.0 * p[3]) / 2.4).powi(3) as f32);
    assert_eq!(points.weights(), volumes, "{what}");
    assert!(loaded.notes.iter().any(|n| n.contains("2 smoothing lengths, 'h'")), "{what}: {:?}", loaded.notes);
}

#[test]
fn all_formats_hold_the_same_points() {
    let files: [(&str, Vec<u8>, &str); 4] = [
        ("a.csv", csv().into_bytes(), "CSV"),
        ("b.TXT", csv().replace(',', "  ").into_bytes(), "text (blanks)"),
        ("c.vtk", vtk_text().into_bytes(), "VTK (legacy)"),
        ("d", vtk_binary(), "VTK (legacy)"),
    ];
    for (name, bytes, format) in files {
        let loaded = read(name, bytes).unwrap();
        is_the_three_points(&loaded, name);
        assert_eq!(loaded.info.format, format, "{name}");
        assert!(loaded.info.columns.iter().any(|c| c == "Temperature"), "{name}: {:?}", loaded.info.columns);
    }
    for (what, bytes) in all_vtp() {
        let loaded = read("x.vtp", bytes).unwrap_or_else(|e| panic!("{what}: {e}"));
        is_the_three_points(&loaded, &what);
        assert_eq!(
            (loaded.info.format, &loaded.info.columns[..]),
            ("VTK PolyData", &["h", "Temperature"].map(String::from)[..])
        );
        assert!(loaded.notes.iter().any(|n| n.contains("3 cells are left out")), "{what}: {:?}", loaded.notes);
    }
    let loaded = read("e.npy", npy()).unwrap();
    assert_eq!(loaded.points.positions()[2], DVec3::new(3.0, 1.5, 1e3));
    assert!(loaded.notes.iter().any(|n| n.contains("2 others")), "{:?}", loaded.notes);
}

#[test]
fn names_of_vtk_arrays_are_those_that_people_gave() {
    let options = PointOptions { value: Some("kind of".to_owned()), ..PointOptions::default() };
    let loaded = read_with("x.vtk", vtk_text(), &options).unwrap();
    assert_eq!(loaded.points.values(), [1.0, 2.0, 3.0]);
    assert_eq!(loaded.info.columns, ["h", "Temperature", "kind of"]);
    assert!(loaded.notes.iter().any(|n| n == "1 arrays of cell data are left out"), "{:?}", loaded.notes);
}

#[test]
fn the_one_way_in_reads_points() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.csv");
    std::fs::write(&path, csv()).unwrap();
    let loaded = vr_io::read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.volume.points().unwrap().count(), 3);
    assert_eq!(loaded.info.placed_by, "positions");
    let error = vr_io::read(&path, &ReadOptions { frame: Some(0), ..ReadOptions::default() }).unwrap_err().to_string();
    assert!(error.contains("frame: found 0; scattered points have none"), "{error}");
    // What is no file of points is not read as one.
    assert!(matches!(read("x.nrrd", "NRRD0004\n").unwrap_err().kind, FileErrorKind::Unrecognised { .. }));
    assert!(matches!(read_points("nowhere.csv", &PointOptions::default()).unwrap_err().kind, FileErrorKind::Io(_)));
}

/// Checks that the error is one line with all of these words.
#[track_caller]
fn refused(name: &str, bytes: impl AsRef<[u8]>, words: &[&str]) {
    refused_with(name, bytes, &PointOptions::default(), words);
}

#[track_caller]
fn refused_with(name: &str, bytes: impl AsRef<[u8]>, options: &PointOptions, words: &[&str]) {
    let error = read_with(name, bytes, options).unwrap_err().to_string();
    assert!(!error.contains('\n'), "{error}");
    for word in words.iter().chain([&name]) {
        assert!(error.contains(word), "no {word:?} in {error}");
    }
}

#[test]
fn points_that_make_no_sense_are_refused_with_line_and_column() {
    refused("x.csv", csv().replace("0.25", "0"), &["line 3", "smoothing length 'h'", "found 0.0", "positive"]);
    refused("x.csv", csv().replace("0.25", "-1"), &["line 3", "found -1.0"]);
    refused("x.csv", csv().replace("20\n", "nan\n"), &["line 3", "value 'Temperature'", "NaN"]);
    refused("x.csv", csv().replace("-2,", "inf,"), &["line 3", "position", "inf"]);
    refused("x.csv", csv().replace("-2,", "1e30,"), &["line 3", "position", "1e30"]);
    refused("x.vtk", vtk_text().replace("0.25", "0"), &["point 1", "'h'"]);
    let columns = "x,y,z\n1,2,3\n";
    refused("x.csv", columns, &["radius", "one point alone", "give one"]);
    refused("x.csv", "x,y,z\n1,2,3\n1,2,3\n", &["radius", "point 0 with 1 others"]);
    for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = PointOptions { radius: Some(radius), ..PointOptions::default() };
        refused_with("x.csv", columns, &options, &["volume.radius", "positive"]);
    }
    let options = PointOptions { radius: Some(1e29), radius_scale: Some(1e20), ..PointOptions::default() };
    refused_with("x.csv", columns, &options, &["line 2, radius", "1e49"]);
    let options = PointOptions { value: Some("Pressure".to_owned()), ..PointOptions::default() };
    refused_with("x.csv", csv(), &options, &["value", "Pressure", "x, y, z, h, Temperature"]);
    let mut options = PointOptions::default();
    options.columns.position = Some(["x", "y", "z"].map(String::from));
    refused_with("x.npy", npy(), &options, &["columns.position", "only text"]);
}

#[test]
fn broken_vtk_files_are_refused_with_reasons() {
    let text = vtk_text();
    refused("x.vtk", text.replace("POINTS 3", "POINTS 300000000000000"), &["array POINTS", "900000000000000 numbers"]);
    refused("x.vtk", text.replace("POINTS 3", "POINTS 18446744073709551615"), &["line 8", "fewer"]);
    refused("x.vtk", text.replace("POINTS 3 float", "POINTS 3 string"), &["line 8", "string", "type of numbers"]);
    refused("x.vtk", text.replace("-2", "minus"), &["line 9", "array POINTS", "minus"]);
    refused("x.vtk", text.replace("VECTORS", "VICTORS"), &["VICTORS v float", "a section begins"]);
    refused("x.vtk", text.replace("Temperature 1 3 float", "Temperature 1 three float"), &["array of a field"]);
    refused(
        "x.vtk",
        text.split_at(text.find("FIELD FieldData 2").unwrap() + 45).0,
        &["array Temperature", "3 numbers"],
    );
    let binary = vtk_binary();
    refused("x.vtk", &binary[..binary.len() - 5], &["array Temperature", "8 bytes left", "3 numbers of f32"]);

    let ascii = String::from_utf8(vtp(Stored::Ascii, Packed::No, false)).unwrap();
    refused(
        "x.vtp",
        ascii.replacen("NumberOfPoints=\"2\"", "NumberOfPoints=\"4000000000\"", 1),
        &["array Points", "6 numbers", "12000000000"],
    );
    refused("x.vtp", ascii.replacen("NumberOfPoints=\"2\"", "NumberOfPoints=\"-1\"", 1), &["NumberOfPoints", "-1"]);
    refused("x.vtp", ascii.replacen("</Piece>", "", 1), &["XML"]);
    refused("x.vtp", ascii.replace("type=\"Float32\"", "type=\"String\""), &["array Points, type", "String"]);
    refused("x.vtp", ascii.replacen("Temperature", "Pressure", 1), &["Piece, array Pressure", "every piece"]);
    for stored in [Stored::Inline, Stored::AppendedBase64, Stored::AppendedRaw] {
        for how in [Packed::No, Packed::Zlib, Packed::Lz4] {
            let file = vtp(stored, how, true);
            let text = String::from_utf8_lossy(&file).into_owned();
            if stored != Stored::AppendedRaw {
                // More than there is: nothing may be allocated for it.
                let claims = text.replace("NumberOfPoints=\"2\"", "NumberOfPoints=\"4000000000\"");
                refused("x.vtp", claims, &["array Points", "need 48000000000"]);
            }
            if stored == Stored::AppendedRaw {
                let begin = file.windows(2).position(|w| w == b" _").unwrap();
                refused("x.vtp", &file[..begin + 30], &["array"]);
            }
        }
    }
    let zlib = String::from_utf8(vtp(Stored::Inline, Packed::Zlib, false)).unwrap();
    refused(
        "x.vtp",
        zlib.replace("vtkZLibDataCompressor", "vtkOtherDataCompressor"),
        &["compressor", "Other", "vtkLZ4"],
    );
    refused("x.vtp", zlib.replace("vtkZLibDataCompressor", "vtkLZ4DataCompressor"), &["array Points"]);
    refused("x.vtp", zlib.replace("LittleEndian", "BigEndian"), &["array Points", "blocks of"]);
    let raw = vtp(Stored::AppendedRaw, Packed::No, false);
    let place = raw.windows(10).position(|w| w == b"offset=\"0\"").unwrap();
    let beyond = [&raw[..place], b"offset=\"999999999999\"", &raw[place + 10..]].concat();
    refused("x.vtp", beyond, &["offset", "999999999999", "bytes of AppendedData"]);
}

#[cfg(not(feature = "hdf5"))]
#[test]
fn hdf5_is_refused_with_the_way_to_read_it() {
    refused("x.h5", b"\x89HDF\r\n\x1a\n....", &["HDF5", "feature `hdf5`"]);
}

#[cfg(feature = "hdf5")]
mod hdf5 {
    use super::*;

    #[test]
    fn gadget_snapshots() {
        let loaded = read("x.hdf5", small_points::GADGET).unwrap();
        let points = &loaded.points;
        assert_eq!(points.positions()[2], DVec3::new(3.0, 1.5, 1e3));
        assert_eq!((points.radii(), points.values()), (&[1.0, 0.5, 2.0][..], &[10.0, 20.0, 30.0][..]));
        // Mass by density.
        assert_eq!(points.weights(), [4.0; 3]);
        assert_eq!((loaded.info.format, loaded.info.scalar), ("HDF5 (Gadget)", vr_io::ScalarType::F64));
        assert!(loaded.notes.iter().any(|n| n.contains("PartType1 is left out")), "{:?}", loaded.notes);
        let options = PointOptions { value: Some("density".to_owned()), ..PointOptions::default() };
        assert_eq!(read_with("x.hdf5", small_points::GADGET, &options).unwrap().points.values(), [2.0; 3]);
        let options = PointOptions { value: Some("Velocities".to_owned()), ..PointOptions::default() };
        refused_with(
            "x.h5",
            small_points::GADGET,
            &options,
            &["value", "Velocities", "SmoothingLength, InternalEnergy, Density, Masses"],
        );
    }

    #[test]
    fn broken_files_are_refused_with_reasons() {
        refused("x.h5", b"\x89HDF\r\n\x1a\n....", &["HDF5"]);
        refused("x.h5", &small_points::GADGET[..1000], &[]);
    }
}
