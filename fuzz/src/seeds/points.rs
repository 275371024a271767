//! Scattered points.

use crate::small_points;

pub fn csv() -> Vec<Vec<u8>> {
    vec![small_points::csv().into_bytes()]
}

pub fn words() -> Vec<Vec<u8>> {
    vec![small_points::csv().replace(',', " ").into_bytes()]
}

pub fn npy() -> Vec<Vec<u8>> {
    vec![small_points::npy()]
}

pub fn vtk() -> Vec<Vec<u8>> {
    vec![small_points::vtk_text().into_bytes(), small_points::vtk_binary()]
}

pub fn vtp() -> Vec<Vec<u8>> {
    small_points::all_vtp().into_iter().map(|(_, file)| file).collect()
}

pub fn hdf5() -> Vec<Vec<u8>> {
    vec![small_points::GADGET.to_vec()]
}
