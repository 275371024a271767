//! One body without symmetry through every format: its voxels lie at the same places of the patient, and the default picture shows it from
//! the same anatomical side.

mod dicom;
mod headers;
mod phantom;

use std::path::PathBuf;

use glam::DVec3;
use image::RgbImage;
use vr_core::{Voxel, with_grid};
use vr_io::{Loaded, ReadOptions, default_angles, framing};

use crate::harness::Vr;
use dicom::Order;
use headers::{Forms, Qform, metaimage, mrc, nifti, nrrd, transform_matrix, vti};
use phantom::{Phantom, Turn};

/// Agreement that a picture must keep with that of the first file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Agreement {
    /// Axes and numbers are the same, and so is each bit.
    Exact,
    /// Directions are rounded to 32 bits, or axes are taken in another order: places of samples are off by some 10⁻⁶ of a voxel, and values
    /// by as much of their range, so that a channel may be rounded to the next of 256 levels.
    Rounded,
}

/// A folder of files that hold one phantom, and the picture that they must give.
struct Gallery {
    vr: Vr,
    phantom: Phantom,
    flags: String,
    expected: Option<RgbImage>,
}

impl Gallery {
    fn new(phantom: Phantom) -> Self {
        Self { vr: Vr::new(), phantom, flags: String::new(), expected: None }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.vr.folder().join(name)
    }

    /// Holds a file that is there against the phantom and the first file's picture.
    #[track_caller]
    fn check(&mut self, name: &str, agreement: Agreement) {
        let loaded = vr_io::read(self.path(name), &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        self.check_places(name, &loaded);
        self.vr
            .run(&format!("render {name} --size 72x64 --quality fine --error none -o x.png {}", self.flags))
            .succeeded();
        let picture = self.vr.picture("x.png").to_rgb8();
        let Some(expected) = &self.expected else {
            self.expected = Some(picture);
            return;
        };
        let largest = expected.iter().zip(picture.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(largest <= u8::from(agreement == Agreement::Rounded), "{name}: {largest} levels apart");
    }

    fn put(&mut self, name: &str, bytes: Vec<u8>, agreement: Agreement) {
        self.vr.write(name, bytes);
        self.check(name, agreement);
    }

    /// Each voxel of the phantom is a voxel of the file, of its value, at its place.
    #[track_caller]
    fn check_places(&self, name: &str, loaded: &Loaded) {
        let grid = loaded.volume.grid().unwrap();
        let Phantom { dims: [nx, ny, nz], origin, axes, values } = &self.phantom;
        let (to_index, start) = (grid.placement().axes().inverse(), grid.placement().origin());
        let [mx, my, _] = grid.dims();
        let calibration = grid.calibration();
        let found: Vec<f64> = with_grid!(grid.values(), g => g.samples().iter().map(|v| v.to_f32().into()).collect());
        for (i, value) in values.iter().enumerate() {
            let at = [i % nx, i / nx % ny, i / nx / ny].map(|n| n as f64);
            let index = to_index * (*origin + *axes * DVec3::from_array(at) - start);
            // Numbers of 24 bits: a 10⁷th of the origin's 140 mm, and the smallest spacing is 0.78 mm.
            assert!(index.distance(index.round()) < 1e-4, "{name}: {index} is no voxel");
            let [x, y, z] = index.round().to_array().map(|n| n as usize);
            assert_eq!(calibration.value(found[(z * my + y) * mx + x]), f64::from(*value), "{name}: {at:?}");
        }
        assert_eq!(found.len(), nx * ny * nz);
    }
}

/// Flags of the default camera of a patient, for files whose worlds are no patients'.
fn patient_camera(loaded: &Loaded) -> String {
    let bounds = loaded.volume.grid().unwrap().bounds();
    let info = Some(&loaded.info);
    let camera = framing(bounds, info, default_angles(info), None);
    let vr_core::Projection::Orthographic { height } = camera.projection else { panic!("orthographic") };
    let triple = |v: DVec3| format!("{},{},{}", v.x, v.y, v.z);
    format!(
        "--eye={} --target={} --up={} --height={height} --transfer grey --no-shading",
        triple(camera.eye),
        triple(camera.target),
        triple(camera.up)
    )
}

/// Orders of axes, with directions in which they make a right-handed system, as DICOM's slices do: axial, coronal, sagittal.
fn acquisitions() -> [(&'static str, Turn); 4] {
    [
        ("axial", Turn::along([0, 1, 2], [true, true, false])),
        ("coronal", Turn::along([0, 2, 1], [true, true, true])),
        ("sagittal", Turn::along([1, 2, 0], [true, true, false])),
        ("feet_first", Turn::along([0, 1, 2], [false, true, true])),
    ]
}

#[test]
fn a_patient_is_seen_from_the_front_in_every_format() {
    let mut gallery = Gallery::new(Phantom::oblique());
    let phantom = gallery.phantom.clone();
    gallery.put("ras.nrrd", nrrd(&phantom, "right-anterior-superior"), Agreement::Exact);

    // The apple in the raised left hand, the brightest thing: in the right half of the picture, and in the upper one.
    let picture = gallery.expected.as_ref().unwrap();
    let brightest = picture.enumerate_pixels().max_by_key(|(.., p)| p.0.map(u32::from).iter().sum::<u32>()).unwrap();
    assert!(brightest.0 > 40 && brightest.1 < 28, "{brightest:?}");

    for space in ["RAS", "LPS", "left-posterior-superior", "LAS", "left-anterior-superior", "RAST"] {
        gallery.put("x.nrrd", nrrd(&phantom, space), Agreement::Exact);
    }
    let both = Forms { sform: true, qform: Qform::Right, qfac: 1.0 };
    let none = Qform::None;
    gallery.put("sform.nii", nifti(&phantom, Forms { qform: none, ..both }), Agreement::Exact);
    gallery.put("both.nii", nifti(&phantom, both), Agreement::Exact);
    gallery.put("elsewhere.nii", nifti(&phantom, Forms { qform: Qform::Elsewhere, ..both }), Agreement::Exact);
    for qfac in [1.0, 0.0] {
        gallery.put("qform.nii", nifti(&phantom, Forms { sform: false, qfac, ..both }), Agreement::Rounded);
    }
    gallery.put("x.mha", metaimage(&phantom, &transform_matrix(&phantom)), Agreement::Rounded);
    // What a matrix says counts, whatever the letters are.
    let fields = format!("AnatomicalOrientation = RAI\n{}", transform_matrix(&phantom));
    gallery.put("y.mha", metaimage(&phantom, &fields), Agreement::Rounded);
}

#[test]
fn order_and_direction_of_the_axes_do_not_turn_the_patient() {
    let mut gallery = Gallery::new(Phantom::oblique());
    let phantom = gallery.phantom.clone();
    gallery.put("ras.nrrd", nrrd(&phantom, "RAS"), Agreement::Exact);
    let turns = [
        Turn::flipped([true, false, false]),
        Turn::flipped([true, true, false]),
        Turn::flipped([true, true, true]),
        Turn::along([2, 1, 0], [false; 3]),
        Turn::along([1, 2, 0], [false, true, false]),
        Turn::along([2, 0, 1], [true, false, false]),
    ];
    for turn in turns {
        let turned = phantom.turned(turn);
        let form = |sform| Forms { sform, qform: Qform::Right, qfac: 1.0 };
        gallery.put("x.nrrd", nrrd(&turned, "LPS"), Agreement::Rounded);
        gallery.put("sform.nii", nifti(&turned, form(true)), Agreement::Rounded);
        gallery.put("qform.nii", nifti(&turned, form(false)), Agreement::Rounded);
        gallery.put("x.mha", metaimage(&turned, &transform_matrix(&turned)), Agreement::Rounded);
    }
}

#[test]
fn slices_of_dicom_show_the_patient_in_every_order_and_acquisition() {
    let mut gallery = Gallery::new(Phantom::oblique());
    let phantom = gallery.phantom.clone();
    gallery.put("ras.nrrd", nrrd(&phantom, "RAS"), Agreement::Exact);
    for (name, turn) in acquisitions() {
        for order in [Order::Forward, Order::Backward, Order::Mixed] {
            let name = format!("{name}_{order:?}");
            dicom::write(&gallery.path(&name), &phantom.turned(turn), order);
            gallery.check(&name, Agreement::Rounded);
        }
    }
}

#[test]
fn worlds_without_patients_hold_the_same_places() {
    let mut gallery = Gallery::new(Phantom::oblique());
    let phantom = gallery.phantom.clone();
    gallery.vr.write("ras.nrrd", nrrd(&phantom, "RAS"));
    gallery.flags = patient_camera(&vr_io::read(gallery.path("ras.nrrd"), &ReadOptions::default()).unwrap());
    gallery.check("ras.nrrd", Agreement::Exact);
    for space in ["scanner-xyz", "scanner-xyz-time", "3D-right-handed"] {
        gallery.put("x.nrrd", nrrd(&phantom, space), Agreement::Exact);
    }
    gallery.put("x.vti", vti(&phantom), Agreement::Rounded);
    gallery.put("y.vti", vti(&phantom.turned(Turn::along([1, 2, 0], [true, false, true]))), Agreement::Rounded);
}

#[test]
fn letters_and_cells_place_an_upright_patient() {
    let mut gallery = Gallery::new(Phantom::upright());
    let phantom = gallery.phantom.clone();
    gallery.vr.write("ras.nrrd", nrrd(&phantom, "RAS"));
    gallery.flags = patient_camera(&vr_io::read(gallery.path("ras.nrrd"), &ReadOptions::default()).unwrap());
    gallery.check("ras.nrrd", Agreement::Exact);
    // Letters tell where each axis comes from: the phantom's from left, posterior and inferior.
    let letters = [
        ("LPI", Turn::NONE),
        ("RAI", Turn::flipped([true, true, false])),
        ("SPL", Turn::along([2, 1, 0], [true, false, false])),
        ("ASR", Turn::along([1, 2, 0], [true; 3])),
    ];
    for (letters, turn) in letters {
        let fields = format!("AnatomicalOrientation = {letters}");
        gallery.put("x.mha", metaimage(&phantom.turned(turn), &fields), Agreement::Rounded);
    }
    // Whole mm as well in 32 bits as in 64.
    for along in [[0, 1, 2], [2, 0, 1], [1, 0, 2]] {
        gallery.put("x.mrc", mrc(&phantom.turned(Turn::along(along, [false; 3])), along), Agreement::Rounded);
    }
}
