//! Grids in HDF5 and NetCDF-4, from files that h5py and netCDF4 wrote: (7 i) mod 251 over 3×4×5 numbers.
#![cfg(feature = "hdf5")]

use std::path::{Path, PathBuf};

use glam::DVec3;
use vr_core::{Calibration, Voxel, with_grid};
use vr_io::{Loaded, ReadOptions, read};

fn small(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/all/small_grids").join(name)
}

fn load(name: &str, options: &ReadOptions) -> Loaded {
    read(small(name), options).unwrap_or_else(|e| panic!("{e}"))
}

fn array(name: &str) -> ReadOptions {
    ReadOptions { array: Some(name.into()), ..Default::default() }
}

fn stored(loaded: &Loaded) -> Vec<f32> {
    with_grid!(loaded.volume.grid().unwrap().values(), g => g.samples().iter().map(|v| v.to_f32()).collect())
}

fn numbers() -> impl Iterator<Item = usize> {
    (0..60).map(|i| i * 7 % 251)
}

#[test]
fn datasets_are_named_by_path() {
    let first = load("grids.h5", &ReadOptions::default());
    assert_eq!(stored(&first), numbers().map(|n| n as f32).collect::<Vec<_>>());
    let grid = first.volume.grid().unwrap();
    assert_eq!((grid.dims(), grid.placement().spacing()), ([5, 4, 3], DVec3::new(0.25, 0.5, 2.0)));
    assert_eq!(
        (first.info.format, first.info.placed_by, first.info.units.as_deref()),
        ("HDF5", "element_size_um", Some("µm"))
    );
    let notes = first.notes.join("; ");
    assert!(notes.contains("of 3 variables that are volumes /t0/channel/vol is taken"), "{notes}");
    assert!(notes.contains("/rgb (2×2×4×3)") && notes.contains("/tagged (2×2×3×4)"), "{notes}");
    for name in ["/t0/channel/vol", "vol", "channel/vol"] {
        assert_eq!(stored(&load("grids.h5", &array(name))), stored(&first));
    }
    let message = read(small("grids.h5"), &array("list2")).unwrap_err().to_string();
    assert!(message.contains("array: found list2; the file has"), "{message}");
}

#[test]
fn colours_and_tags_are_components() {
    let options = ReadOptions { component: Some(2), ..array("rgb") };
    let rgb = load("grids.h5", &options);
    assert_eq!((rgb.volume.grid().unwrap().dims(), rgb.info.components), ([4, 2, 2], 3));
    assert_eq!(stored(&rgb)[1], 7.0 + 2.0);
    let options = ReadOptions { component: Some(1), ..array("tagged") };
    let tagged = load("grids.h5", &options);
    assert_eq!((tagged.volume.grid().unwrap().dims(), tagged.info.components), ([4, 3, 2], 2));
    assert_eq!(stored(&tagged)[..3], [1.0, 8.0, 15.0]);
}

#[test]
fn netcdf_4_has_coordinates_calibration_and_missing_voxels() {
    let loaded = load("cf.nc", &ReadOptions::default());
    assert_eq!(loaded.info.format, "NetCDF-4");
    let grid = loaded.volume.grid().unwrap();
    assert_eq!(grid.calibration(), Calibration { slope: 0.5, intercept: 273.0 });
    assert_eq!(grid.placement().origin(), DVec3::new(-1.0, 3.0, 100.0));
    assert_eq!(grid.placement().axes().to_cols_array(), [0.25, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.0, 2.0]);
    assert_eq!(loaded.info.units.as_deref(), Some("m"));
    for (found, n) in stored(&loaded).into_iter().zip(numbers()) {
        assert!(found == n as f32 || n == 7 && found.is_nan(), "{found} {n}");
    }
}

#[test]
fn any_byte_may_be_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["grids.h5", "cf.nc"] {
        let whole = std::fs::read(small(name)).unwrap();
        let path = folder.path().join(name);
        for at in (0..whole.len()).step_by(41) {
            let mut bytes = whole.clone();
            bytes[at] ^= 0xff;
            std::fs::write(&path, bytes).unwrap();
            let _ = read(&path, &ReadOptions::default());
        }
    }
}
