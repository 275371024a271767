//! Adaptive meshes, which are folders.

use std::path::Path;

use crate::small_amr::{self, Folder};

use super::kept;

/// Copies a folder of the tests.
fn copy(folder: &Folder, into: &Path) {
    fn files(from: &Path, into: &Path) {
        std::fs::create_dir_all(into).expect("a folder for seeds");
        for entry in std::fs::read_dir(from).expect("a folder of seeds") {
            let entry = entry.expect("a seed").path();
            let place = into.join(entry.file_name().unwrap_or_default());
            if entry.is_dir() {
                files(&entry, &place);
            } else {
                std::fs::copy(&entry, &place).expect("a seed");
            }
        }
    }
    files(folder.path(), into);
}

fn file(folder: &Folder, name: &str) -> Vec<Vec<u8>> {
    vec![std::fs::read(folder.path().join(name)).expect("a seed")]
}

fn plotfile() -> Folder {
    small_amr::amrex(false, true, 1)
}

pub fn amrex(into: &Path) {
    copy(&plotfile(), into);
}

pub fn amrex_header() -> Vec<Vec<u8>> {
    file(&plotfile(), "Header")
}

pub fn amrex_level() -> Vec<Vec<u8>> {
    file(&plotfile(), "Level_1/Cell_H")
}

pub fn amrex_data() -> Vec<Vec<u8>> {
    file(&plotfile(), "Level_1/Cell_D_00000")
}

pub fn vthb(into: &Path) {
    copy(&small_amr::vthb("ghosts"), into);
}

pub fn vthb_tree() -> Vec<Vec<u8>> {
    ["1.0", "1.1", "blanked", "ghosts"].iter().flat_map(|version| file(&small_amr::vthb(version), "a.vthb")).collect()
}

pub fn vthb_block() -> Vec<Vec<u8>> {
    file(&small_amr::vthb("ghosts"), "a/2.vti")
}

const ENZO: [&str; 3] = ["run", "run.hierarchy", "run.cpu0000"];

fn of_enzo(number: usize) -> Vec<u8> {
    kept(&format!("small_grids/enzo/{}", ENZO[number]))
}

pub fn enzo(into: &Path) {
    for (number, name) in ENZO.iter().enumerate() {
        std::fs::write(into.join(name), of_enzo(number)).expect("a seed");
    }
}

pub fn enzo_parameters() -> Vec<Vec<u8>> {
    vec![of_enzo(0)]
}

pub fn enzo_hierarchy() -> Vec<Vec<u8>> {
    vec![of_enzo(1)]
}

pub fn enzo_data() -> Vec<Vec<u8>> {
    vec![of_enzo(2)]
}
