//! Files with bytes changed, put in, taken out and cut off, thousands of them: each is read or refused in one line, never a
//! panic. The random numbers are the same on every run.

mod small_amr;
mod small_images;
mod small_meshes;
mod small_points;
mod tiny;

use std::cell::Cell;
use std::path::Path;

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use small_meshes::{obj, ply_binary, ply_text, stl_binary, stl_text};
use tiny::{gzip, i16_bytes, join, metaimage, nifti_1, nifti_2, nrrd, zlib};
use vr_io::{PointOptions, ReadOptions, parse_color_maps, parse_scene, read, read_mesh, read_points, resolve_scene};

#[derive(Clone, Debug)]
enum Damage {
    Set(prop::sample::Index, u8),
    Insert(prop::sample::Index, &'static str),
    Remove(prop::sample::Index, usize),
    Cut(prop::sample::Index),
}

/// Words that upset parsers.
const WORDS: [&str; 14] = [
    "-1",
    "0",
    "nan",
    "inf",
    "1e999",
    "18446744073709551616",
    "9223372036854775807",
    "4294967296",
    "\n",
    "\0",
    "%d",
    "none",
    "(",
    "\u{fffd}",
];

fn damage() -> impl Strategy<Value = Vec<Damage>> {
    let at = any::<prop::sample::Index>;
    let one = prop_oneof![
        4 => (at(), any::<u8>()).prop_map(|(i, b)| Damage::Set(i, b)),
        4 => (at(), prop::sample::select(&WORDS[..])).prop_map(|(i, w)| Damage::Insert(i, w)),
        2 => (at(), 1usize..20).prop_map(|(i, n)| Damage::Remove(i, n)),
        1 => at().prop_map(Damage::Cut),
    ];
    vec(one, 1..5)
}

fn apply(bytes: &[u8], damage: &[Damage]) -> Vec<u8> {
    let mut b = bytes.to_vec();
    for d in damage {
        let i = |index: &prop::sample::Index| index.index(b.len().max(1)).min(b.len());
        match d {
            Damage::Set(index, value) => {
                let i = i(index);
                if let Some(byte) = b.get_mut(i) {
                    *byte = *value;
                }
            }
            Damage::Insert(index, word) => {
                let i = i(index);
                b.splice(i..i, word.bytes());
            }
            Damage::Remove(index, n) => {
                let i = i(index);
                b.drain(i..(i + n).min(b.len()));
            }
            Damage::Cut(index) => {
                let i = i(index);
                b.truncate(i);
            }
        }
    }
    b
}

/// Runs a check on damaged versions of some bytes.
fn survive(bytes: &[u8], check: impl Fn(&[u8]) -> Result<(), String>) {
    let config = Config { cases: 600, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let outcome = runner.run(&damage(), |d| {
        let damaged = apply(bytes, &d);
        check(&damaged).map_err(|e| TestCaseError::fail(format!("{e} from {:?}", String::from_utf8_lossy(&damaged))))
    });
    outcome.unwrap_or_else(|e| panic!("{e}"));
}

fn one_line(message: String) -> Result<(), String> {
    if message.contains('\n') { Err(format!("two lines: {message}")) } else { Ok(()) }
}

/// Damages the first `header` bytes of a file, or all of them.
fn survive_reading(name: &str, file: &[u8], header: usize, pack: fn(&[u8]) -> Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    // A new file for each case: some file systems write an overwritten one to the disk at once.
    let case = Cell::new(0);
    let (head, rest) = file.split_at(header.min(file.len()));
    survive(head, |damaged| {
        case.set(case.get() + 1);
        let path = folder.path().join(format!("{}{name}", case.get()));
        std::fs::write(&path, pack(&join(damaged.to_vec(), rest))).map_err(|e| e.to_string())?;
        let outcome = read(&path, &ReadOptions::default());
        std::fs::remove_file(&path).map_err(|e| e.to_string())?;
        match outcome {
            Ok(loaded) => {
                // What was read is a grid in earnest.
                let placement = *loaded.volume.grid().ok_or("no grid")?.placement();
                if placement.axes().is_finite() && placement.origin().is_finite() {
                    Ok(())
                } else {
                    Err("a geometry that is not finite".into())
                }
            }
            Err(e) => one_line(e.to_string()),
        }
    });
}

fn as_it_is(bytes: &[u8]) -> Vec<u8> {
    bytes.to_vec()
}

/// Files of 4×3×2 numbers in the smaller families, with the length of what tells how to read them.
fn smaller_families() -> Vec<(&'static str, Vec<u8>, usize)> {
    let mut map = vec![0u8; 1024];
    for (i, n) in [4i32, 3, 2, 1, 0, 0, 0, 4, 3, 2].into_iter().enumerate() {
        map[4 * i..4 * i + 4].copy_from_slice(&n.to_le_bytes());
    }
    for i in 0..3 {
        map[40 + 4 * i..][..4].copy_from_slice(&9f32.to_le_bytes());
        map[52 + 4 * i..][..4].copy_from_slice(&80f32.to_le_bytes());
        map[64 + 4 * i] = i as u8 + 1;
    }
    map[208..216].copy_from_slice(b"MAP \x44\x44\0\0");
    let npy = "{'descr': '<i2', 'fortran_order': True, 'shape': (2, 3, 4), }\n";
    let npy = [b"\x93NUMPY\x01\0", (npy.len() as u16).to_le_bytes().as_slice(), npy.as_bytes()].concat();
    let grid = "object 1 class gridpositions counts 4 3 2\norigin 0 0 0\ndelta 1 0 0\ndelta 0 1 0\ndelta 0 0 1\n\
                object 3 class array type float rank 0 items 24 data follows\n";
    let numbers: String = (0..24).map(|i| format!("{i}.5 ")).collect();
    let vvd = "<VoreenData version=\"1\"><Volumes><Volume><RawData filename=\"a.raw\" format=\"int16\" x=\"4\" y=\"3\" z=\"2\" />\
               <MetaData><MetaItem name=\"Spacing\"><value x=\"1\" y=\"2\" z=\"3\" /></MetaItem></MetaData></Volume></Volumes></VoreenData>";
    let dat = "ObjectFileName: a.raw\nResolution: 4 3 2\nSliceThickness: 1 2 3\nFormat: SHORT\n";
    // 24 steps of 0 after the header's own bytes would do; this one ends in its middle.
    let dds = b"DDS v3d\n\x00\x00\x00\x2a\x75\x28\x13\x77\x91\x3b\x5c\x00".to_vec();
    let slices = [b"7 X\x0c\x09\x00....".as_slice(), b"15 X\x8cabcdefghijkl\x00."].concat();
    let all = [
        ("a.mrc", join(map, &i16_bytes(false)), 1024),
        ("a.pvm", join(b"PVM2\n4 3 2\n1 2 3\n2\n".to_vec(), &i16_bytes(true)), 20),
        ("b.pvm", dds, 20),
        ("a.slc", join(b"11111\n4 3 2 8\n1 1 1\n0 0 0 1\n1 1 Xpic".to_vec(), &slices), 70),
        ("a.npy", join(npy.clone(), &i16_bytes(false)), npy.len()),
        ("a.general", join(b"grid = 4x3x2\nformat = lsb binary\ntype = short\nend\n".to_vec(), &i16_bytes(false)), 51),
        ("a.dx", join(grid.into(), numbers.as_bytes()), 500),
        ("a.vvd", vvd.into(), 500),
        ("a.dat", dat.into(), 500),
    ];
    all.into()
}

#[test]
fn headers_of_the_smaller_families() {
    for (name, file, header) in smaller_families() {
        survive_reading(name, &file, header, as_it_is);
    }
}

#[test]
fn nrrd_headers() {
    let fields = "type: short\nendian: little\nencoding: raw\nspace: left-posterior-superior\n\
                  space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nkinds: domain domain domain";
    let file = nrrd(fields, &i16_bytes(false));
    survive_reading("x.nrrd", &file, file.len() - 48, as_it_is);
    let fields =
        "type: short\nendian: big\nencoding: gzip\nspacings: 1 2 3\naxis mins: 0 0 0\nunits: \"mm\" \"mm\" \"um\"";
    let file = nrrd(fields, &gzip(&i16_bytes(true)));
    survive_reading("y.nrrd", &file, usize::MAX, as_it_is);
    let text: String = (0..24).map(|i| format!("{i} ")).collect();
    let file = nrrd("type: double\nencoding: ascii\nline skip: 0\nbyte skip: 0", text.as_bytes());
    survive_reading("z.nrrd", &file, usize::MAX, as_it_is);
    let file = nrrd("type: uchar\nencoding: raw\ndata file: x%02d.raw 1 4 1", b"");
    survive_reading("w.nrrd", &file, usize::MAX, as_it_is);
}

#[test]
fn metaimage_headers() {
    let fields = "ElementType = MET_SHORT\nElementSpacing = 1 2 3\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\n\
                  BinaryDataByteOrderMSB = False\nHeaderSize = 0\nElementNumberOfChannels = 1";
    let file = metaimage(fields, "LOCAL", &i16_bytes(false));
    survive_reading("x.mha", &file, file.len() - 48, as_it_is);
    let file = metaimage("ElementType = MET_SHORT\nCompressedData = True", "LOCAL", &zlib(&i16_bytes(false)));
    survive_reading("y.mha", &file, usize::MAX, as_it_is);
}

#[test]
fn nifti_headers() {
    let one = join(nifti_1(false, b"n+1\0"), &i16_bytes(false));
    survive_reading("x.nii", &one, 352, as_it_is);
    survive_reading("x.nii.gz", &one, 352, gzip);
    survive_reading("y.nii", &join(nifti_2(true), &i16_bytes(true)), 544, as_it_is);
    survive_reading("z.nii.gz", &gzip(&one), usize::MAX, as_it_is);
}

#[test]
fn vtk_images() {
    for (name, file) in small_images::few() {
        survive_reading(name, &file, usize::MAX, as_it_is);
    }
}

#[test]
fn scene_files() {
    let text = "[volume]\ndata = [0, 1, 2, 3, 4, 5, 6, 7]\ndims = [2, 2, 2]\ntype = \"u8\"\nspacing = [1.0, 1.0, 1.0]\n\
                [transfer]\npoints = [{value = 0.0, color = [0, 0, 0], opacity = 0.0}, {value = 7.0, color = [1, 1, 1], opacity = 0.5}]\n\
                [image]\nsize = [8, 8]\n[render]\ncompositing = \"over\"\nstep = 0.5\n";
    survive(text.as_bytes(), |damaged| {
        let path = Path::new("x.toml");
        match parse_scene(&String::from_utf8_lossy(damaged), path).and_then(|s| resolve_scene(&s, path)) {
            Ok(_) => Ok(()),
            Err(e) => one_line(e.to_string()),
        }
    });
}

#[test]
fn colour_maps() {
    let text = r#"[{"ColorSpace": "Diverging", "RGBPoints": [0, 0.2, 0.3, 0.7, 1, 0.7, 0.0, 0.1],
                    "Points": [0, 0, 0.5, 0, 0.5, 0.3, 0.2, 0.4, 1, 1, 0.5, 1]}]"#;
    survive(text.as_bytes(), |damaged| {
        match parse_color_maps(&String::from_utf8_lossy(damaged), Path::new("x.json")) {
            Ok(maps) => maps.iter().try_for_each(|m| {
                let points = m.over((-1.0, 1.0));
                vr_core::TransferFunction::new(points, vr_core::OpacityRule::Power, 1.0)
                    .map(|_| ())
                    .map_err(|e| e.to_string())
            }),
            Err(e) => one_line(e.to_string()),
        }
    });
}

#[test]
fn meshes() {
    let folder = tempfile::tempdir().unwrap();
    let case = Cell::new(0);
    let files = [
        ("a.stl", stl_text().into_bytes()),
        ("b.stl", stl_binary(b"solid")),
        ("c.obj", obj().into_bytes()),
        ("d.obj", b"v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nf 1/1/1 2//1 -1//-1\n".to_vec()),
        ("e.ply", ply_text().into_bytes()),
        ("f.ply", ply_binary(false)),
        ("g.ply", ply_binary(true)),
    ];
    for (name, file) in files {
        survive(&file, |damaged| {
            case.set(case.get() + 1);
            let path = folder.path().join(format!("{}{name}", case.get()));
            std::fs::write(&path, damaged).map_err(|e| e.to_string())?;
            let outcome = read_mesh(&path);
            std::fs::remove_file(&path).map_err(|e| e.to_string())?;
            match outcome {
                // What was read is a surface in earnest.
                Ok(loaded) => {
                    let (low, high) = loaded.mesh.bounds();
                    if low.is_finite() && high.is_finite() { Ok(()) } else { Err("bounds that are not finite".into()) }
                }
                Err(e) => one_line(e.to_string()),
            }
        });
    }
}

#[test]
fn points() {
    let folder = tempfile::tempdir().unwrap();
    let case = Cell::new(0);
    let mut files = vec![
        ("a.csv", small_points::csv().into_bytes()),
        ("b.txt", small_points::csv().replace(',', " ").into_bytes()),
        ("c.npy", small_points::npy()),
        ("d.vtk", small_points::vtk_text().into_bytes()),
        ("e.vtk", small_points::vtk_binary()),
    ];
    files.extend(small_points::all_vtp().into_iter().map(|(_, file)| ("f.vtp", file)));
    // Without the feature, it is refused after eight bytes.
    files.push(("g.h5", small_points::GADGET.to_vec()));
    for (name, file) in files {
        survive(&file, |damaged| {
            case.set(case.get() + 1);
            let path = folder.path().join(format!("{}{name}", case.get()));
            std::fs::write(&path, damaged).map_err(|e| e.to_string())?;
            let outcome = read_points(&path, &PointOptions::default());
            std::fs::remove_file(&path).map_err(|e| e.to_string())?;
            match outcome {
                // What was read is points in earnest.
                Ok(loaded) => {
                    let (low, high) = loaded.points.bounds();
                    if loaded.notes.iter().any(|note| note.contains('\n')) {
                        return Err(format!("a note of two lines: {:?}", loaded.notes));
                    }
                    if low.is_finite() && high.is_finite() { Ok(()) } else { Err("bounds that are not finite".into()) }
                }
                Err(e) => one_line(e.to_string()),
            }
        });
    }
}

/// Damages one file of a folder at a time; the volume is read by way of another.
fn survive_in_folder(folder: &Path, entry: &str, damaged: &str) {
    let whole = std::fs::read(folder.join(damaged)).unwrap();
    let case = Cell::new(0);
    survive(&whole, |bytes| {
        // A name of its own for each case, as above.
        case.set(case.get() + 1);
        let path = folder.join(damaged);
        std::fs::remove_file(&path).map_err(|e| e.to_string())?;
        std::fs::write(&path, bytes).map_err(|e| e.to_string())?;
        match read(folder.join(entry), &ReadOptions::default()) {
            Ok(loaded) => {
                let (low, high) = loaded.volume.bounds();
                if low.is_finite() && high.is_finite() { Ok(()) } else { Err("a box that is not finite".into()) }
            }
            Err(e) => one_line(e.to_string()),
        }
    });
    std::fs::write(folder.join(damaged), whole).unwrap();
}

#[test]
fn plotfiles_of_amrex() {
    let folder = small_amr::amrex(false, true, 1);
    for damaged in ["Header", "Level_0/Cell_H", "Level_1/Cell_H", "Level_1/Cell_D_00000"] {
        survive_in_folder(folder.path(), "Header", damaged);
    }
}

#[test]
fn blocks_of_vtk() {
    for (version, damaged) in [("1.0", "a.vthb"), ("1.1", "a.vthb"), ("blanked", "a/1.vti"), ("ghosts", "a/2.vti")] {
        let folder = small_amr::vthb(version);
        survive_in_folder(folder.path(), "a.vthb", damaged);
    }
}

#[test]
fn texts_of_enzo() {
    let folder = small_amr::Folder::default();
    let small = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/small_grids/enzo");
    for name in ["run", "run.hierarchy", "run.cpu0000"] {
        folder.write(name, std::fs::read(small.join(name)).unwrap());
    }
    for damaged in ["run", "run.hierarchy", "run.cpu0000"] {
        survive_in_folder(folder.path(), "run.hierarchy", damaged);
    }
}

#[test]
fn rectilinear_grids() {
    let folder = small_amr::Folder::default();
    let axes = "X_COORDINATES 3 float\n0 1 4\nY_COORDINATES 2 double\n0 2\nZ_COORDINATES 2 int\n5 3\n";
    let data = "POINT_DATA 12\nSCALARS f float\nLOOKUP_TABLE default\n0 1 2 3 4 5 6 7 8 9 10 11\nCELL_DATA 2\nVECTORS v float\n0 1 2 3 4 5\n";
    folder.write(
        "a.vtk",
        format!("# vtk DataFile Version 3.0\nx\nASCII\nDATASET RECTILINEAR_GRID\nDIMENSIONS 3 2 2\n{axes}{data}"),
    );
    survive_in_folder(folder.path(), "a.vtk", "a.vtk");
    let array = |numbers: &str| format!("<DataArray type=\"Float32\" Name=\"f\">{numbers}</DataArray>");
    let piece = format!(
        "<Piece Extent=\"0 2 0 1 0 1\"><PointData>{}<DataArray type=\"UInt8\" Name=\"vtkGhostType\">0 0 0 2 0 0 0 0 0 0 0 0</DataArray></PointData>\
         <CellData/><Coordinates>{}{}{}</Coordinates></Piece>",
        array("0 1 2 3 4 5 6 7 8 9 10 11"),
        array("0 1 4"),
        array("0 1"),
        array("0 1")
    );
    folder.write(
        "a.vtr",
        format!(
            "<VTKFile type=\"RectilinearGrid\" version=\"0.1\"><RectilinearGrid WholeExtent=\"0 2 0 1 0 1\">{piece}</RectilinearGrid></VTKFile>"
        ),
    );
    survive_in_folder(folder.path(), "a.vtr", "a.vtr");
    let list = "<VTKFile type=\"PRectilinearGrid\" version=\"0.1\"><PRectilinearGrid WholeExtent=\"0 2 0 1 0 1\"><Piece Extent=\"0 2 0 1 0 1\" Source=\"a.vtr\"/>\
                </PRectilinearGrid></VTKFile>";
    folder.write("a.pvtr", list);
    survive_in_folder(folder.path(), "a.pvtr", "a.pvtr");
}
