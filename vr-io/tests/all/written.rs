//! Volumes in every format that is written, read back: voxels, placement, calibration and space.

use std::path::{Path, PathBuf};

use glam::{DMat3, DQuat, DVec3};
use vr_core::{AnyGrid, Calibration, GridVolume, Placement, UniformGrid, Volume, Voxel, with_grid};
use vr_io::{Loaded, ReadOptions, Space, WriteVolumeOptions, WrittenVolume, read, volume_files, write_volume};

const DIMS: [usize; 3] = [5, 4, 3];
const COUNT: usize = 60;
/// Hounsfield units.
const WHOLE: Calibration = Calibration { slope: 1.0, intercept: -1024.0 };
const BROKEN: Calibration = Calibration { slope: 2.2086, intercept: -10.1 };

fn patient() -> WriteVolumeOptions {
    WriteVolumeOptions { patient: true, ..WriteVolumeOptions::default() }
}

/// Turned about no axis of the world, with another spacing along each axis.
fn turned(mirror: f64) -> Placement {
    let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.9));
    let axes = turn * DMat3::from_diagonal(DVec3::new(0.5, 0.7, 3.1 * mirror));
    Placement::new(DVec3::new(-120.3, 45.6, 1.0 / 7.0), axes).unwrap()
}

fn sheared() -> Placement {
    let axes = DMat3::from_cols(DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.0, 0.5, 0.0), DVec3::new(0.0, 0.3, 2.0));
    Placement::new(DVec3::new(1.0, 2.0, 3.0), axes).unwrap()
}

macro_rules! volume {
    ($t:ty, $placement:expr, $calibration:expr) => {{
        let samples: Vec<$t> = (0..COUNT).map(|i| (i * 7 % 127) as $t).collect();
        Volume::from(UniformGrid::new(DIMS, samples, $placement, $calibration).unwrap())
    }};
}

fn grid(volume: &Volume) -> &GridVolume {
    volume.grid().unwrap()
}

fn values(volume: &Volume) -> Vec<f64> {
    let calibration = grid(volume).calibration();
    with_grid!(grid(volume).values(), g => g.samples().iter().map(|s| calibration.value(s.to_f32().into())).collect())
}

fn written(path: &Path, volume: &Volume, options: &WriteVolumeOptions) -> (WrittenVolume, Loaded) {
    let written = write_volume(path, volume, options).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(written.files, volume_files(path, volume).unwrap());
    let back = read(path, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(back.info.scalar, written.scalar, "{}", path.display());
    (written, back)
}

fn refused(path: &Path, volume: &Volume) -> String {
    write_volume(path, volume, &patient()).unwrap_err().to_string()
}

/// Largest distance of corners, in units of the smallest spacing.
fn displaced(a: &Volume, b: &Volume) -> f64 {
    let distance = grid(a).corners().into_iter().zip(grid(b).corners()).map(|(a, b)| (a - b).length());
    distance.fold(0.0, f64::max) / grid(a).placement().spacing().min_element()
}

fn all_types(placement: Placement, calibration: Calibration) -> [Volume; 5] {
    [
        volume!(u8, placement, calibration),
        volume!(i8, placement, calibration),
        volume!(u16, placement, calibration),
        volume!(i16, placement, calibration),
        volume!(f32, placement, calibration),
    ]
}

/// Headers in text give every f64 back, and products of direction and spacing are one rounding off; NIfTI's are f32, of 24 bits, which
/// are half a 10⁷th of the origin's 120 mm, and the smallest spacing is ½ mm.
const PLACED: [(&str, f64); 5] =
    [("x.nrrd", 1e-12), ("x.mha", 1e-12), ("x.mhd", 1e-12), ("x.nii", 1e-4), ("x.nii.gz", 1e-4)];

#[test]
fn patients_keep_voxels_types_placement_and_space() {
    let folder = tempfile::tempdir().unwrap();
    for (name, tolerance) in PLACED {
        for placement in [turned(1.0), turned(-1.0), sheared()] {
            for volume in all_types(placement, Calibration::default()) {
                let (_, back) = written(&folder.path().join(name), &volume, &patient());
                assert_eq!(values(&back.volume), values(&volume), "{name}");
                assert_eq!(grid(&back.volume).voxel_type(), grid(&volume).voxel_type(), "{name}");
                let off = displaced(&volume, &back.volume);
                assert!(off <= tolerance, "{name}: {off}");
                assert!(back.info.space.is_patient() && back.info.units.as_deref().unwrap_or("mm") == "mm", "{name}");
                let said = back.notes.join("; ");
                assert!(!said.contains("otherwise"), "sform and qform agree: {said}");
            }
        }
    }
}

#[test]
fn frames_of_their_own_keep_their_placement() {
    let folder = tempfile::tempdir().unwrap();
    for (name, tolerance) in PLACED.into_iter().chain([("x.vti", 1e-12)]) {
        let volume = volume!(u16, turned(1.0), Calibration::default());
        let (note, back) = written(&folder.path().join(name), &volume, &WriteVolumeOptions::default());
        let off = displaced(&volume, &back.volume);
        assert!(off <= tolerance, "{name}: {off}");
        let is_own = back.info.space == Space::Own;
        assert_eq!(is_own, name.ends_with("nrrd") || name.ends_with("vti"), "{name}");
        assert!(is_own || note.notes.iter().any(|n| n.contains("own frame")), "{name}");
    }
    // Spacing alone needs no patient.
    let spaced = volume!(u8, Placement::from_spacing([1.0, 2.0, 0.3]).unwrap(), Calibration::default());
    let (_, back) = written(&folder.path().join("x.mha"), &spaced, &WriteVolumeOptions::default());
    assert_eq!(back.info.space, Space::Own);
    assert_eq!(grid(&back.volume).placement(), grid(&spaced).placement());
}

#[test]
fn vtk_images_keep_all_but_the_patient() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.vti");
    for placement in [turned(1.0), turned(-1.0), Placement::from_spacing([1.0, 2.0, 0.3]).unwrap()] {
        for volume in all_types(placement, Calibration::default()) {
            let (note, back) = written(&path, &volume, &patient());
            assert_eq!(values(&back.volume), values(&volume));
            // One rounding of direction times spacing.
            assert!(displaced(&volume, &back.volume) <= 1e-12);
            assert!(back.info.mapped && note.notes[0].contains("no patients"), "{:?}", note.notes);
        }
    }
    let message = refused(&path, &volume!(u8, sheared(), Calibration::default()));
    assert!(message.contains("not perpendicular") && message.contains(".nrrd"), "{message}");
}

#[test]
fn calibrations_are_kept_or_applied() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["x.nrrd", "x.mha", "x.vti", "x.nii"] {
        let path = folder.path().join(name);
        // Whole values: every format holds them, and the type's width stays.
        for volume in all_types(turned(1.0), WHOLE) {
            let (note, back) = written(&path, &volume, &patient());
            assert_eq!(values(&back.volume), values(&volume), "{name}");
            let floats = matches!(grid(&volume).values(), AnyGrid::F32(_));
            assert_eq!(grid(&back.volume).voxel_type().is_integer(), !floats, "{name}");
            let (kept, said) = (grid(&back.volume).calibration() == WHOLE, note.notes.join("; "));
            assert_eq!((kept, said.contains("is applied")), (name == "x.nii", name != "x.nii"), "{name}: {said}");
        }
        // Others: NIfTI's slope and intercept, and the values elsewhere, are f32, which is off by 2⁻²⁴ of the largest.
        for volume in all_types(turned(1.0), BROKEN) {
            let (_, back) = written(&path, &volume, &patient());
            for (found, expected) in values(&back.volume).into_iter().zip(values(&volume)) {
                assert!((found - expected).abs() <= 2.0 * 2f64.powi(-24) * 280.0, "{name}: {found}, not {expected}");
            }
        }
        // Far from 0, 64 bits keep the digits.
        let far = volume!(u8, turned(1.0), Calibration { slope: 0.001, intercept: 1e7 + 0.1 });
        let (note, back) = written(&path, &far, &patient());
        assert_eq!(note.scalar, vr_io::ScalarType::F64, "{name}");
        for (found, expected) in values(&back.volume).into_iter().zip(values(&far)) {
            assert!((found - expected).abs() <= 1e-8, "{name}: {found}, not {expected}");
        }
    }
}

#[test]
fn missing_voxels_stay_missing() {
    let folder = tempfile::tempdir().unwrap();
    let mut samples: Vec<f32> = (0..COUNT).map(|i| i as f32).collect();
    samples[7] = f32::NAN;
    let volume = Volume::from(UniformGrid::new(DIMS, samples, turned(1.0), Calibration::default()).unwrap());
    for name in ["x.nrrd", "x.mha", "x.vti", "x.nii.gz"] {
        let (_, back) = written(&folder.path().join(name), &volume, &patient());
        let found = values(&back.volume);
        assert!(found[7].is_nan() && found[8] == 8.0 && grid(&back.volume).value_stats().nan == 1, "{name}");
    }
}

#[test]
fn raw_files_are_described_by_name_or_by_flags() {
    let folder = tempfile::tempdir().unwrap();
    let unit = Placement::from_spacing([1.0; 3]).unwrap();
    for volume in all_types(unit, Calibration::default()) {
        let path = folder.path().join(format!("x_5x4x3_{}.raw", grid(&volume).voxel_type()));
        let (note, back) = written(&path, &volume, &WriteVolumeOptions::default());
        assert_eq!((values(&back.volume), note.notes), (values(&volume), vec![]));
    }
    let volume = volume!(i16, turned(1.0), Calibration::default());
    let notes = write_volume(folder.path().join("x.raw"), &volume, &patient()).unwrap().notes.join("; ");
    assert!(notes.contains("--dims 5x4x3 --type i16 --spacing 0.5") && notes.contains("orientation"), "{notes}");
    let message = refused(&folder.path().join("x_5x4x3_u8.raw"), &volume);
    assert!(message.contains("..._5x4x3_i16.raw"), "{message}");
}

#[test]
fn slices_are_pngs_of_8_or_16_bits() {
    let folder = tempfile::tempdir().unwrap();
    let unit = Placement::from_spacing([1.0; 3]).unwrap();
    let [bytes, small, words, shorts, floats] = all_types(unit, Calibration::default());
    for (i, (volume, bits)) in [(bytes, 1), (small, 1), (words, 2), (shorts, 2)].into_iter().enumerate() {
        let (note, back) = written(&folder.path().join(format!("{i}_%03d.png")), &volume, &patient());
        assert_eq!((values(&back.volume), note.scalar.bytes()), (values(&volume), bits));
        let made = folder.path().join(format!("made{i}/"));
        let (note, back) = written(&made, &volume, &patient());
        assert_eq!((values(&back.volume), grid(&back.volume).dims()), (values(&volume), DIMS));
        assert_eq!(note.files[2], made.join("slice_2.png"));
        // A folder of files is not written over.
        assert!(refused(&made, &volume).contains("holds files"));
        // Other slices of the same pattern would be read with the new ones.
        std::fs::write(folder.path().join(format!("{i}_007.png")), "").unwrap();
        assert!(refused(&folder.path().join(format!("{i}_%03d.png")), &volume).contains("007.png is there"));
    }
    for bad in [floats, volume!(u16, unit, WHOLE)] {
        let message = refused(&folder.path().join("bad_%03d.png"), &bad);
        assert!(message.contains("--to u16 --rescale"), "{message}");
    }
    let rest: Vec<PathBuf> = folder.path().read_dir().unwrap().map(|e| e.unwrap().path()).collect();
    assert!(rest.iter().all(|path| !path.to_string_lossy().contains(".vr-")), "{rest:?}");
}

#[test]
fn names_and_kinds_that_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let volume = volume!(u8, turned(1.0), Calibration::default());
    for (name, said) in [
        ("x.tif", "no format of volumes that are written"),
        (".nrrd", "no format"),
        ("x", "no format"),
        ("x.png", "x_%03d.png"),
        ("x%d.mhd", "percent sign"),
        ("x%s.png", "pattern"),
        ("no/folder/x.nrrd", "cannot be written"),
        ("no/folder/x%d.png", "cannot be written"),
    ] {
        let message = refused(&folder.path().join(name), &volume);
        assert!(message.contains(said), "{name}: {message}");
    }
    let field = vr_core::field::FunctionField::new((DVec3::ZERO, DVec3::ONE), |p| p.x).unwrap();
    let message = refused(&folder.path().join("x.nrrd"), &field.into());
    assert!(message.contains("must be a uniform grid"), "{message}");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn zarr_keeps_the_places_of_axes_along_the_world() {
    let folder = tempfile::tempdir().unwrap();
    let turned_by = [
        DMat3::from_diagonal(DVec3::new(0.5, 0.7, 3.1)),
        DMat3::from_cols(DVec3::X * -0.5, DVec3::Y * -0.7, DVec3::Z * 3.1),
        DMat3::from_cols(DVec3::Y * 0.5, DVec3::Z * -0.7, DVec3::X * 3.1),
    ];
    for (i, axes) in turned_by.into_iter().enumerate() {
        let placement = Placement::new(DVec3::new(-120.3, 45.6, 7.0), axes).unwrap();
        for volume in all_types(placement, Calibration::default()) {
            let path = folder.path().join(format!("{i}_{}.zarr", grid(&volume).voxel_type()));
            let options = WriteVolumeOptions { units: Some("µm".into()), ..WriteVolumeOptions::default() };
            let (_, back) = written(&path, &volume, &options);
            assert_eq!((back.info.format, back.info.encoding), ("OME-Zarr", "gzip"));
            assert_eq!(back.info.units.as_deref(), Some("µm"));
            // The same corners, in another order where axes ran backwards; each voxel where it was.
            let world = |v: &Volume| {
                let corner = |g: &GridVolume| g.bounds();
                corner(grid(v))
            };
            let (a, b) = (world(&volume), world(&back.volume));
            assert!((a.0 - b.0).length() < 1e-9 && (a.1 - b.1).length() < 1e-9, "{i}: {a:?} {b:?}");
            let to_index = grid(&back.volume).placement().axes().inverse();
            let origin = grid(&back.volume).placement().origin();
            let [nx, ny, _] = grid(&back.volume).dims();
            for (n, value) in values(&volume).into_iter().enumerate() {
                let [mx, my, _] = grid(&volume).dims();
                let at = DVec3::new((n % mx) as f64, (n / mx % my) as f64, (n / mx / my) as f64);
                let index = (to_index * (grid(&volume).placement().to_world(at) - origin)).round();
                let [x, y, z] = index.to_array().map(|c| c as usize);
                assert_eq!(values(&back.volume)[(z * ny + y) * nx + x], value, "{i}: {at}");
            }
            let again = write_volume(&path, &volume, &options).unwrap_err().to_string();
            assert!(again.contains("the folder holds files"), "{again}");
        }
    }
    // Beyond one chunk, and oblique: spacing and the first voxel's place remain.
    let samples: Vec<u16> = (0..70 * 66 * 65).map(|i| (i % 251) as u16).collect();
    let oblique = Volume::from(UniformGrid::new([70, 66, 65], samples, turned(1.0), WHOLE).unwrap());
    let (note, back) = written(&folder.path().join("o.zarr"), &oblique, &patient());
    assert!(note.notes.iter().any(|n| n.contains("holds no rotation")), "{:?}", note.notes);
    assert_eq!(values(&back.volume), values(&oblique));
    let (a, b) = (grid(&oblique).placement(), grid(&back.volume).placement());
    assert!((a.spacing() - b.spacing()).length() < 1e-12 && (a.origin() - b.origin()).length() < 1e-9);
}
