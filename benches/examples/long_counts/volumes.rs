//! Bounds of the error on real volumes.

use std::path::Path;
use std::time::Instant;

use vr_core::{Camera, Control, ControlPoint, OpacityRule, Scene, TransferFunction, View, Volume};
use vr_io::ReadOptions;
use vr_physics::metrics::subgrid;

use crate::Error;
use crate::bounds::{BOUNDS, Solved, Tally};

/// Files of volumes in the folder of data, with the array or the component that is meant where there are several.
const VOLUMES: [(&str, Option<&str>, Option<usize>); 37] = [
    ("raw/fuel_64x64x64_uint8.raw", None, None),
    ("raw/neghip_64x64x64_uint8.raw", None, None),
    ("raw/nucleon.nrrd", None, None),
    ("raw/engine_256x256x128_uint8.raw.gz", None, None),
    ("raw/male_128x256x256_uint8.raw.bz2", None, None),
    ("raw/Bucky_32x32x32_uint8.raw", None, None),
    ("slc/nut.slc", None, None),
    ("nrrd/stent.nrrd", None, None),
    ("nrrd/tooth.nhdr", None, None),
    ("nrrd/FLAIR.nrrd", None, None),
    ("nrrd/headsq/quarter.nhdr", None, None),
    ("nrrd/ball/BallBinary30x30x30.nrrd", None, None),
    ("nrrd/prostate_phantom.nrrd", None, None),
    ("nifti/bonsai.nii.gz", None, None),
    ("nifti/AVM.nii.gz", None, None),
    ("nifti/shear.nii.gz", None, None),
    ("nifti/anatomical_be.nii", None, None),
    ("nifti/example4d.nii.gz", None, None),
    ("metaimage/HeadMRVolume.mhd", None, None),
    ("metaimage/mha.mha", None, None),
    ("metaimage/frogtissue.mhd", None, None),
    ("metaimage/cthead_256x256x99.mhd", None, None),
    ("vtk/hydrogen.vti", None, None),
    ("vtk/ironProt.vtk", None, None),
    ("vtk/heart.vti", None, None),
    ("vtk/vase_4comp.vti", None, Some(0)),
    ("vtk/cth.vtr", None, None),
    ("dx/mri.general", None, None),
    ("mrc/EMD-3001.map.bz2", None, None),
    ("dicom/pet_head", None, None),
    ("dicom/single/emri_small.dcm", None, None),
    ("zarr/fuel_v3.zarr", None, None),
    ("amr/amrex_plt1_Y", Some("Y(H2O)"), None),
    ("amr/vthb/HierarchicalBoxDataset.v1.1.vthb", None, None),
    ("amr/enzo_DD0010/moving7_0010", Some("Density"), None),
    ("unstructured/post.vtk", None, None),
    ("unstructured/fire_ug.vtu", None, None),
];

/// Directions from which each volume is seen.
const DIRECTIONS: usize = 12;

/// Pixels along each side of a picture.
const SIDE: u32 = 96;

/// Returns a direction by azimuth and elevation in degrees, spread evenly over the sphere by the golden angle, and the angle of the view, in every other one.
fn direction(k: usize) -> (f64, f64, Option<f64>) {
    const GOLDEN_ANGLE: f64 = 137.507_764_050_037_85;
    let height = 1.0 - 2.0 * (k as f64 + 0.5) / DIRECTIONS as f64;
    ((k as f64 * GOLDEN_ANGLE).rem_euclid(360.0), height.asin().to_degrees(), k.is_multiple_of(2).then_some(30.0))
}

/// Returns fog with a coloured core, and a jump to a surface with an opaque core, over the range of the values.
fn transfers(volume: &Volume) -> Result<[TransferFunction; 2], Error> {
    let (low, high) = volume.value_range().ok_or("no values")?;
    let point = |share: f64, color, opacity| ControlPoint::new(low + share * (high - low), color, opacity);
    let fog = vec![point(0.05, [0.2, 0.4, 1.0], 0.0), point(0.4, [1.0, 0.7, 0.3], 0.1), point(1.0, [1.0; 3], 0.6)];
    let surface = vec![
        point(0.2, [0.1, 0.3, 0.8], 0.0),
        point(0.2, [0.9, 0.6, 0.4], 0.3),
        point(0.55, [0.9, 0.6, 0.4], 0.5),
        point(0.56, [1.0, 1.0, 0.9], 1.0),
    ];
    let spacing = volume.mean_spacing();
    Ok([
        TransferFunction::new(fog, OpacityRule::Power, 4.0 * spacing)?,
        TransferFunction::new(surface, OpacityRule::Power, spacing)?,
    ])
}

/// Draws each volume of a folder from all directions under each bound, and prints the table.
pub fn count(folder: &Path, grid: u32) -> Result<(), Error> {
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return Ok(());
    }
    let control = Control::default();
    println!(
        "{DIRECTIONS} directions, half of them in perspective, pictures of {SIDE}x{SIDE} pixels, of which {grid}x{grid} are compared, two transfer functions"
    );
    println!("| volume | bound | {} | seconds |", Tally::HEADING);
    let mut all: [Tally; 3] = Default::default();
    for (name, array, component) in VOLUMES {
        let start = Instant::now();
        let options = ReadOptions { array: array.map(str::to_owned), component, ..ReadOptions::default() };
        let volume = match vr_io::read(folder.join(name), &options) {
            Ok(loaded) => loaded.volume,
            Err(e) => {
                println!("skipped: {e}");
                continue;
            }
        };
        let mut own: [Tally; 3] = Default::default();
        for transfer in transfers(&volume)? {
            let scene = Scene::new(volume.clone(), transfer);
            for k in 0..DIRECTIONS {
                let (azimuth, elevation, fov) = direction(k);
                let view = View::new(Camera::framing(volume.bounds(), azimuth, elevation, fov), [SIDE; 2]);
                let solved = Solved::new(&scene, &view, subgrid(grid, view.size), &control)?;
                for (tally, bound) in own.iter_mut().zip(BOUNDS) {
                    let judged = solved.judge(bound, &scene, &view, &control)?;
                    if let Some(judged) = judged.filter(|judged| judged.breaks_its_promise()) {
                        println!("{name}, direction {k}, max-error {bound}: {judged:?}");
                    }
                    tally.add(judged);
                }
            }
        }
        for ((own, all), bound) in own.iter().zip(&mut all).zip(BOUNDS) {
            println!("| {name} | {bound} | {} | {:.0} |", own.row(), start.elapsed().as_secs_f64());
            all.join(own);
        }
    }
    for (all, bound) in all.iter().zip(BOUNDS) {
        println!("| all | {bound} | {} | |", all.row());
    }
    Ok(())
}
