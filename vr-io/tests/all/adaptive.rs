//! Adaptive meshes of every format: small ones made here, refused where they make no sense, and real ones from `shared/data` (or
//! `VR_TEST_DATA`), which are compared with what VTK and yt find in them.

use crate::small_amr;

use std::path::{Path, PathBuf};

use crate::shared::data;
use crate::small_amr::{Folder, amrex, vthb};
use glam::DVec3;
use vr_core::amr::AmrBlock;
use vr_core::{AmrGrid, Field, Volume};
use vr_io::{Endian, Loaded, ReadOptions, ScalarType, read};

fn mesh(loaded: &Loaded) -> &AmrGrid {
    match &loaded.volume {
        Volume::Amr(grid) => grid,
        other => panic!("found {}: {:?}", other.kind(), loaded.notes),
    }
}

fn array(name: &str) -> ReadOptions {
    ReadOptions { array: Some(name.to_owned()), ..ReadOptions::default() }
}

fn error(path: impl AsRef<Path>, options: &ReadOptions) -> String {
    let message = read(path, options).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

/// Sum of value times volume over the cells that no finer ones cover, and their number and range.
fn leaves(grid: &AmrGrid) -> (usize, f64, f64, f64) {
    let (mut count, mut sum, mut low, mut high) = (0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for level in 0..grid.levels() {
        let volume = grid.spacing_of(level).element_product();
        for (number, block) in grid.blocks_of(level).iter().enumerate() {
            let [nx, ny, _] = block.dims;
            for (i, &value) in block.values.iter().enumerate() {
                let at = [i % nx, i / nx % ny, i / (nx * ny)];
                let cell = [0, 1, 2].map(|a| block.first[a] + at[a] as i64);
                let holds = |b: &AmrBlock, cell: [i64; 3]| {
                    (0..3).all(|a| b.first[a] <= cell[a] && cell[a] < b.first[a] + b.dims[a] as i64)
                };
                let is_covered = level + 1 < grid.levels() && {
                    let ratio = grid.ratio_of(level + 1).map(i64::from);
                    let fine = [0, 1, 2].map(|a| cell[a] * ratio[a]);
                    grid.blocks_of(level + 1).iter().any(|b| holds(b, fine))
                };
                // A cell of two blocks counts once.
                let is_repeated = grid.blocks_of(level)[..number].iter().any(|b| holds(b, cell));
                if !is_covered && !is_repeated {
                    count += 1;
                    sum += f64::from(value) * volume;
                    (low, high) = (low.min(value.into()), high.max(value.into()));
                }
            }
        }
    }
    (count, sum, low, high)
}

/// A linear field on 4×4×2 cells, of which the lower half in x is refined: exact everywhere between the outermost cells' middles.
#[track_caller]
fn is_the_small_mesh(loaded: &Loaded) {
    let grid = mesh(loaded);
    assert_eq!((grid.levels(), grid.leaf_cells(0), grid.leaf_cells(1)), (2, 16, 128), "{:?}", loaded.notes);
    for at in [DVec3::new(1.3, 2.4, 3.4), DVec3::new(2.9, 2.6, 3.6), DVec3::new(4.1, 3.1, 3.7)] {
        let expected = small_amr::value(at);
        let found = grid.value(at).unwrap();
        assert!((found - expected).abs() < 1e-5, "{at}: {found}, not {expected}");
    }
}

#[test]
fn plotfiles_of_amrex() {
    for (double, big, ghosts) in [(false, true, 0), (true, false, 0), (true, true, 1), (false, false, 2)] {
        let folder = amrex(double, big, ghosts);
        let by_folder = read(folder.path(), &array("Y(a b)")).unwrap();
        is_the_small_mesh(&by_folder);
        is_the_small_mesh(&read(folder.path().join("Header"), &array("y(A B)")).unwrap());
        let info = &by_folder.info;
        assert_eq!(
            (info.format, &info.columns[..]),
            ("AMReX plotfile", &["density".to_owned(), "Y(a b)".to_owned()][..])
        );
        let kind =
            (if double { ScalarType::F64 } else { ScalarType::F32 }, if big { Endian::Big } else { Endian::Little });
        assert_eq!((info.scalar, info.endian), kind);
        assert_eq!(info.files.len(), 5, "{:?}", info.files);
        // The first component, which is 1 everywhere.
        assert_eq!(mesh(&read(folder.path(), &ReadOptions::default()).unwrap()).value_range(), (1.0, 1.0));
        let wrong = error(folder.path(), &array("pressure"));
        assert!(wrong.contains("array: found pressure; must be one of density, Y(a b)"), "{wrong}");
    }
}

#[test]
fn plotfiles_that_are_not_whole() {
    let refused = |damage: &dyn Fn(&Folder), words: &[&str]| {
        let folder = amrex(true, false, 0);
        damage(&folder);
        let message = error(folder.path(), &ReadOptions::default());
        for word in words {
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    };
    refused(&|f| f.remove("Level_1/Cell_H"), &["Header: data file", "Level_1/Cell_H", "must lie where"]);
    refused(&|f| f.remove("Level_1/Cell_D_00000"), &["Level_1/Cell_D_00000"]);
    refused(&|f| f.cut("Level_1/Cell_D_00000", 1100), &["Cell_D_00000: FAB at byte 0", "cut off"]);
    refused(&|f| f.edit("Header", "\n3\n0.5", "\n2\n0.5"), &["dimension: found 2"]);
    refused(&|f| f.edit("Header", "Level_1/Cell", "../Level_1/Cell"), &["level 1, path", "inside of the folder"]);
    refused(&|f| f.edit("Level_0/Cell_H", "Cell_D_00000", "/etc/passwd"), &["FabOnDisk", "inside of the folder"]);
    refused(&|f| f.edit("Header", "(7,7,3)", "(7,6,3)"), &["domain of level 1"]);
    refused(&|f| f.edit("Level_1/Cell_H", "(3,7,3)", "(3,7,4)"), &["must hold the box"]);
    refused(&|f| f.edit("Header", "\n1\n", "\n4000000000\n"), &["Header: "]);
    let folder = amrex(true, false, 0);
    let options = ReadOptions { frame: Some(1), ..ReadOptions::default() };
    assert!(error(folder.path(), &options).contains("frame: found 1"));
}

#[test]
fn blocks_of_vtk() {
    for version in ["1.1", "1.0"] {
        let folder = vthb(version);
        let path = folder.path().join("a.vthb");
        let loaded = read(&path, &ReadOptions::default()).unwrap();
        is_the_small_mesh(&loaded);
        assert_eq!((loaded.info.format, loaded.info.files.len()), ("VTK AMR", 4), "{:?}", loaded.notes);
        assert!(loaded.notes.iter().any(|n| n.contains("1 blocks are listed without a file")), "{:?}", loaded.notes);
        let along_y = read(&path, &ReadOptions { component: Some(1), ..array("place") }).unwrap();
        assert!((mesh(&along_y).value(DVec3::new(2.9, 2.6, 3.6)).unwrap() - 2.6).abs() < 1e-5);
        let length = read(&path, &array("place")).unwrap();
        assert!(length.notes.iter().any(|n| n.contains("3 components: their length")), "{:?}", length.notes);
        folder.remove("a/1.vti");
        let missing = error(&path, &ReadOptions::default());
        assert!(missing.contains("a.vthb: data file") && missing.contains("1.vti"), "{missing}");
    }
}

#[test]
fn lists_of_vtk_that_make_no_mesh() {
    let refused = |from: &str, to: &str, words: &[&str]| {
        let folder = vthb("1.1");
        folder.edit("a.vthb", from, to);
        let message = error(folder.path().join("a.vthb"), &ReadOptions::default());
        for word in words {
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    };
    refused("a/1.vti", "../a/1.vti", &["DataSet, file", "inside of the folder"]);
    refused("a/1.vti", "/etc/passwd", &["inside of the folder"]);
    refused("amr_box=\"0 3 0 7 0 1\"", "amr_box=\"1 4 0 7 0 1\"", &["amr_box 1 4 0 7 0 1"]);
    refused("amr_box=\"0 3 0 7 0 1\"", "amr_box=\"0 3 0 7 0\"", &["amr_box", "first and last"]);
    refused("spacing=\"0.5", "spacing=\"0.4", &["level 1, spacing", "whole number"]);
    refused("level=\"1\"", "level=\"3000000000\"", &["level 1", "each level must have one"]);
    refused("XYZ", "XY", &["grid_description", "three dimensions"]);
    refused("origin=\"1 2 3\"", "origin=\"1.3 2 3\"", &["Origin and Extent", "corner of a cell"]);
}

#[test]
fn ghost_cells_and_blanked_ones() {
    // The fine image has a layer of copies beyond the box that is refined, whose values differ from their owner's.
    let folder = vthb("ghosts");
    is_the_small_mesh(&read(folder.path().join("a.vthb"), &ReadOptions::default()).unwrap());
    let folder = vthb("blanked");
    let loaded = read(folder.path().join("a.vthb"), &ReadOptions::default()).unwrap();
    assert!(loaded.notes.iter().any(|n| n.contains("1 of 160 values are NaN")), "{:?}", loaded.notes);
}

#[test]
fn images_that_do_not_overlap() {
    let folder = vthb("1.1");
    for _ in 0..3 {
        folder.edit("a.vthb", "vtkOverlapping", "vtkNonOverlapping");
    }
    for (from, to) in [("origin=\"1 2 3\"", ""), (" amr_box=\"0 3 0 7 0 1\"", ""), (" spacing=\"0.5 0.5 0.5\"", "")] {
        folder.edit("a.vthb", from, to);
    }
    is_the_small_mesh(&read(folder.path().join("a.vthb"), &ReadOptions::default()).unwrap());
}

/// Numbers of leaves, sums over them of value times volume, and ranges, as VTK 9.7 (of `.vthb`, where it marks cells under finer ones) and yt 4
/// find them.
#[test]
fn shared_meshes_are_what_other_programs_find() {
    let files = [
        (
            "amr/vthb/HierarchicalBoxDataset.v1.1.vthb",
            "Fractal Volume Fraction",
            (2241, 10.321843175479355, 0.05334170868522242, 5.2631578947368425),
        ),
        ("amr/amrex_plt1_Y", "Y(H2O)", (32768, 1.8453344341322224e-07, 5.6778470341907143e-11, 0.08165388135997632)),
        ("amr/enzo_DD0010", "Density", (27077, 0.2254537075328642, 0.09875256568193436, 256954.46875)),
    ];
    for (name, field, expected) in files {
        let Some(path) = data(name) else { return };
        let loaded = read(path, &array(field)).unwrap_or_else(|e| panic!("{e}"));
        let found = leaves(mesh(&loaded));
        println!("{name} {field} {found:?} {:?} {:?}", mesh(&loaded).bounds(), loaded.notes);
        assert_eq!(found.0, expected.0, "{name}");
        // Values of 32 bits; their sum is in 64.
        for (found, expected) in [(found.1, expected.1), (found.2, expected.2), (found.3, expected.3)] {
            assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{name}: {found}, not {expected}");
        }
    }
    let Some(broken) = data("bad/amrex_missing_levels") else { return };
    let message = error(broken, &ReadOptions::default());
    assert!(message.contains("data file") && message.contains("Level_1/Cell_H"), "{message}");
}

fn small_enzo(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/small_grids/enzo").join(name)
}

/// The small mesh as h5py wrote it; the finer grid has its ghost zones.
#[test]
fn packed_meshes_of_enzo() {
    for part in ["", "run", "run.hierarchy"] {
        let loaded = read(small_enzo(part), &array("x-velocity")).unwrap();
        is_the_small_mesh(&loaded);
        assert_eq!((loaded.info.format, loaded.info.files.len()), ("Enzo", 3), "{:?}", loaded.info.files);
        assert_eq!(loaded.info.columns, ["Density", "x-velocity"], "particles are no field");
    }
    let first = read(small_enzo("run"), &ReadOptions::default()).unwrap();
    assert_eq!(mesh(&first).value_range(), (1.0, 1.0));
    // Other texts for the same numbers.
    let refused = |name: &str, from: &str, to: &str, words: &[&str]| {
        let folder = Folder::default();
        for file in ["run", "run.hierarchy", "run.cpu0000"] {
            folder.write(file, std::fs::read(small_enzo(file)).unwrap());
        }
        folder.edit(name, from, to);
        let message = error(folder.path().join("run"), &ReadOptions::default());
        for word in words {
            assert!(message.contains(word), "no {word:?} in {message}");
        }
    };
    refused(
        "run.hierarchy",
        "GridEndIndex      = 6 6 4",
        "GridEndIndex      = 6 6 5",
        &["run.hierarchy: ", "power of 2"],
    );
    refused("run.hierarchy", "away/run.cpu0000", "away/other.cpu0000", &["run.hierarchy: data file", "other.cpu0000"]);
    refused("run.hierarchy", "Grid = 2", "Grid = 7", &["run.cpu0000: Grid00000007/Density"]);
    refused("run", "TopGridDimensions   = 4 4 2", "TopGridDimensions   = 4 4", &["run: TopGridDimensions"]);
}
