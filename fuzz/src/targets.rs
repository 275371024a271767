//! The kinds of files, each with its reader.

use std::fs;
use std::path::Path;

use crate::readers;
use crate::seeds::{amr, grids, meshes, nothing_beside, pictures, points, texts, vtk};

/// Packs the bytes of a file.
type Pack = fn(&[u8]) -> Vec<u8>;

/// A kind of file with the reader that takes it.
pub struct Target {
    /// Name, by which a fuzzer chooses it.
    pub name: &'static str,
    /// Name of the file of arbitrary bytes: its ending tells some readers what it is.
    pub(crate) file: &'static str,
    /// File or folder that the reader is given.
    pub(crate) entry: &'static str,
    pub(crate) reader: fn(&Path) -> Result<(), String>,
    /// Packs the bytes: what a reader unpacks is to be damaged inside, too.
    pub(crate) pack: Option<Pack>,
    /// Writes the other files that the reader needs.
    pub(crate) beside: fn(&Path),
    seeds: fn() -> Vec<Vec<u8>>,
}

impl Target {
    const fn new(
        name: &'static str,
        file: &'static str,
        reader: fn(&Path) -> Result<(), String>,
        seeds: fn() -> Vec<Vec<u8>>,
    ) -> Self {
        Self { name, file, entry: file, reader, pack: None, beside: nothing_beside, seeds }
    }

    const fn among(self, entry: &'static str, beside: fn(&Path)) -> Self {
        Self { entry, beside, ..self }
    }

    const fn packed(self, pack: Pack) -> Self {
        Self { pack: Some(pack), ..self }
    }

    /// Returns files of the kind, to begin from: small whole ones, and those by which a fuzzer has found faults that are mended.
    ///
    /// # Panics
    /// If a file that is there cannot be read.
    pub fn seeds(&self) -> Vec<Vec<u8>> {
        let found = Path::new(env!("CARGO_MANIFEST_DIR")).join("found").join(self.name);
        let mut found: Vec<_> =
            fs::read_dir(found).into_iter().flatten().map(|file| file.expect("a file").path()).collect();
        // Folders have no order of their own, and a replay is to be the same on every run.
        found.sort();
        let found = found.iter().map(|path| fs::read(path).expect("a file that a fuzzer has found"));
        (self.seeds)().into_iter().chain(found).collect()
    }
}

/// Returns the target of a name.
pub fn target(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

/// All targets.
pub static TARGETS: &[Target] = &[
    Target::new("nrrd", "x.nrrd", readers::volume, grids::nrrd),
    Target::new("metaimage", "x.mha", readers::volume, grids::metaimage),
    Target::new("nifti", "x.nii", readers::volume, grids::nifti),
    Target::new("nifti-gz", "x.nii.gz", readers::volume, grids::nifti).packed(grids::gzip),
    Target::new("gzip", "x.nii.gz", readers::volume, grids::packed),
    Target::new("mrc", "x.mrc", readers::volume, grids::mrc),
    Target::new("pvm", "x.pvm", readers::volume, grids::pvm),
    Target::new("slc", "x.slc", readers::volume, grids::slc),
    Target::new("npy", "x.npy", readers::volume, grids::npy),
    Target::new("dx-general", "x.general", readers::volume, grids::dx_general),
    Target::new("dx", "x.dx", readers::volume, grids::dx),
    Target::new("voreen-vvd", "x.vvd", readers::volume, grids::vvd),
    Target::new("voreen-dat", "x.dat", readers::volume, grids::dat),
    Target::new("netcdf", "x.nc", readers::volume, grids::netcdf),
    Target::new("hdf5-grid", "x.h5", readers::volume, grids::hdf5),
    Target::new("dicom", "x.dcm", readers::volume, grids::dicom),
    Target::new("tiff", "x.tif", readers::volume, pictures::tiff),
    Target::new("slice", "x.png", readers::volume, pictures::slices),
    Target::new("zarr", "x.zarr/zarr.json", readers::volume, grids::zarr).among("x.zarr", nothing_beside),
    Target::new("vti", "x.vti", readers::volume, vtk::vti),
    Target::new("vtk-image", "x.vtk", readers::volume, vtk::image),
    Target::new("vtr", "x.vtr", readers::volume, vtk::vtr),
    Target::new("vtk-rectilinear", "x.vtk", readers::volume, vtk::rectilinear),
    Target::new("pvtr", "x.pvtr", readers::volume, vtk::pvtr).among("x.pvtr", vtk::pieces),
    Target::new("vtu", "x.vtu", readers::volume, vtk::vtu),
    Target::new("vtk-cells", "x.vtk", readers::volume, vtk::cells),
    Target::new("amrex", "Header", readers::volume, amr::amrex_header).among("Header", amr::amrex),
    Target::new("amrex-level", "Level_1/Cell_H", readers::volume, amr::amrex_level).among("Header", amr::amrex),
    Target::new("amrex-data", "Level_1/Cell_D_00000", readers::volume, amr::amrex_data).among("Header", amr::amrex),
    Target::new("vthb", "a.vthb", readers::volume, amr::vthb_tree).among("a.vthb", amr::vthb),
    Target::new("vthb-block", "a/2.vti", readers::volume, amr::vthb_block).among("a.vthb", amr::vthb),
    Target::new("enzo", "run", readers::volume, amr::enzo_parameters).among("run.hierarchy", amr::enzo),
    Target::new("enzo-hierarchy", "run.hierarchy", readers::volume, amr::enzo_hierarchy)
        .among("run.hierarchy", amr::enzo),
    Target::new("enzo-data", "run.cpu0000", readers::volume, amr::enzo_data).among("run.hierarchy", amr::enzo),
    Target::new("points-csv", "x.csv", readers::points, points::csv),
    Target::new("points-text", "x.txt", readers::points, points::words),
    Target::new("points-npy", "x.npy", readers::points, points::npy),
    Target::new("points-vtk", "x.vtk", readers::points, points::vtk),
    Target::new("points-vtp", "x.vtp", readers::points, points::vtp),
    Target::new("points-hdf5", "x.h5", readers::points, points::hdf5),
    Target::new("stl", "x.stl", readers::mesh, meshes::stl),
    Target::new("obj", "x.obj", readers::mesh, meshes::obj),
    Target::new("ply", "x.ply", readers::mesh, meshes::ply),
    Target::new("transfer-json", "x.json", readers::transfer, texts::transfer_json),
    Target::new("transfer-vp", "x.vp", readers::transfer, texts::transfer_vp),
    Target::new("transfer-csv", "x.csv", readers::transfer, texts::transfer_csv),
    Target::new("transfer-lut", "x.lut", readers::transfer, texts::transfer_lut),
    Target::new("transfer-toml", "x.toml", readers::transfer, texts::transfer_toml),
    Target::new("color-maps", "x.json", readers::color_maps, texts::color_maps),
    Target::new("labels", "x.txt", readers::labels, texts::labels),
    Target::new("scene", "x.toml", readers::scene, texts::scene),
    Target::new("keys", "x.toml", readers::keys, texts::keys),
    Target::new("picture-png", "x.png", readers::picture, pictures::png),
    Target::new("picture-exr", "x.exr", readers::picture, pictures::exr),
    Target::new("picture-other", "x.jpg", readers::picture, pictures::others),
    Target::new("record-png", "x.png", readers::record, pictures::recorded_png),
    Target::new("record-exr", "x.exr", readers::record, pictures::recorded_exr),
];
