//! Real and broken files from `shared/data` (or `VR_TEST_DATA`). Where they are absent, every test says so and passes.

use std::path::{Path, PathBuf};

use crate::shared::data;
use vr_core::{AnyGrid, GridError, GridVolume, VoxelType, with_grid};
use vr_io::{
    FileError, FileErrorKind, FileInfo, Loaded, LoadedPoints, PointOptions, RawDescription, ReadOptions, ScalarType,
    Space, Transform, orientation, read, read_points,
};

fn load(name: &str) -> Option<Loaded> {
    load_with(name, &ReadOptions::default())
}

fn load_with(name: &str, options: &ReadOptions) -> Option<Loaded> {
    let path = data(name)?;
    Some(read(&path, options).unwrap_or_else(|e| panic!("{e}")))
}

fn uniform(loaded: &Loaded) -> &GridVolume {
    loaded.volume.grid().unwrap()
}

fn stored(loaded: &Loaded) -> Vec<f32> {
    use vr_core::Voxel;
    with_grid!(uniform(loaded).values(), g => g.samples().iter().map(|s| s.to_f32()).collect())
}

/// Checks that a good file has these properties.
fn expect(name: &str, dims: [usize; 3], voxel: VoxelType, spacing: [f64; 3], check: impl FnOnce(&Loaded, &FileInfo)) {
    let Some(loaded) = load(name) else { return };
    let u = uniform(&loaded);
    assert_eq!(u.dims(), dims, "{name}");
    assert_eq!(u.voxel_type(), voxel, "{name}");
    let found = u.placement().spacing().to_array();
    assert!(found.iter().zip(spacing).all(|(a, b)| (a - b).abs() < 1e-3), "{name}: spacing {found:?}");
    check(&loaded, &loaded.info);
}

#[test]
fn good_files() {
    use VoxelType::{F32, I16, U8, U16};
    expect("raw/fuel_64x64x64_uint8.raw", [64; 3], U8, [1.0; 3], |l, i| {
        assert!(i.mapped);
        assert_eq!(l.volume.value_range(), Some((0.0, 255.0)));
    });
    expect("raw/engine_256x256x128_uint8.raw.gz", [256, 256, 128], U8, [1.0; 3], |_, i| assert_eq!(i.encoding, "gzip"));
    expect("raw/male_128x256x256_uint8.raw.bz2", [128, 256, 256], U8, [1.0; 3], |l, _| {
        assert_eq!(l.volume.value_range().unwrap().0, 1.0);
    });
    expect("nrrd/stent.nrrd", [128, 128, 256], F32, [1.0; 3], |l, i| {
        assert_eq!(i.space, Space::Own);
        assert_eq!(l.volume.value_range(), Some((0.0, 1.0)));
    });
    expect("nrrd/tooth.nhdr", [103, 94, 161], U16, [1.0; 3], |l, _| {
        assert_eq!(l.volume.value_range(), Some((0.0, 1300.0)));
    });
    expect("nrrd/headsq/quarter.nhdr", [64, 64, 93], I16, [3.2, 3.2, 1.5], |_, i| {
        assert_eq!(i.data_files.len(), 93);
    });
    expect("nrrd/prostate_phantom.nrrd", [82, 67, 13], U16, [0.5, 0.5, 3.0], |l, _| {
        // In LPS x and y are flipped, so in RAS they are not.
        assert_eq!(orientation(uniform(l).placement()), "RAS");
        assert_eq!(l.volume.value_range(), Some((0.0, 2017.0)));
    });
    expect("nifti/bonsai.nii.gz", [256; 3], U8, [1.0; 3], |_, i| assert_eq!(i.format, "NIfTI-1"));
    expect("nifti/AVM.nii.gz", [337, 319, 154], U8, [0.5469, 0.5469, 1.0], |l, _| {
        assert!((uniform(l).calibration().slope - 2.2086).abs() < 1e-3);
        assert!((l.volume.value_range().unwrap().1 - 563.2).abs() < 0.5);
    });
    expect("nifti/shear.nii.gz", [306, 422, 54], U8, [0.4824, 0.4824, 2.3708], |l, _| {
        let (low, high) = l.volume.value_range().unwrap();
        assert!((low + 1024.0).abs() < 1e-3 && (high - 789.0).abs() < 1.0, "{low} {high}");
        let axes = uniform(l).placement().axes();
        assert!(axes.y_axis.normalize().dot(axes.z_axis.normalize()).abs() > 0.1, "the shear is kept");
    });
    expect("nifti/anatomical_be.nii", [33, 41, 25], I16, [2.0; 3], |l, i| {
        assert!(!i.mapped);
        assert!(uniform(l).placement().axes().determinant() < 0.0);
        assert_eq!(uniform(l).value_stats().range, Some((-610.0, 30393.0)));
    });
    expect("metaimage/HeadMRVolume.mhd", [48, 62, 42], U8, [4.0; 3], |_, i| assert!(i.mapped));
    expect("metaimage/mha.mha", [64, 64, 37], I16, [3.4375, 3.4375, 3.8], |l, i| {
        assert_eq!((i.space, i.encoding), (Space::Lps, "zlib"));
        assert_eq!(l.volume.value_range(), Some((0.0, 6690.0)));
        // Its own AnatomicalOrientation says RPI: from right, posterior, inferior; towards left, anterior, superior.
        assert_eq!(orientation(uniform(l).placement()), "LAS");
    });
    expect("metaimage/frogtissue.mhd", [500, 470, 136], U8, [1.0, 1.0, 1.5], |l, _| {
        assert_eq!(l.volume.value_range(), Some((0.0, 29.0)));
    });
    expect("metaimage/cthead_256x256x99.mhd", [256, 256, 99], U16, [1.0, 1.0, 2.0], |l, _| {
        assert_eq!(l.volume.value_range(), Some((0.0, 3272.0)));
    });
}

#[test]
fn one_scan_in_two_formats_lies_at_the_same_place() {
    let (Some(a), Some(b)) = (load("nrrd/FLAIR.nrrd"), load("nifti/FLAIR.nii.gz")) else { return };
    assert_eq!(stored(&a), stored(&b));
    for (p, q) in uniform(&a).corners().iter().zip(uniform(&b).corners()) {
        assert!((p - q).length() < 1e-3, "{p} {q}");
    }
}

#[test]
fn one_payload_behind_two_headers() {
    let raw = ReadOptions { raw: Some(RawDescription::new([41; 3], ScalarType::U8)), ..Default::default() };
    let (Some(a), Some(b)) = (load("raw/nucleon.nrrd"), load_with("raw/nucleon.raw", &raw)) else { return };
    assert_eq!(stored(&a), stored(&b));
    assert_eq!(uniform(&a).placement(), uniform(&b).placement());
}

#[test]
fn three_headers_of_nucleon() {
    let (Some(a), Some(b)) = (load("raw/nucleon.nrrd"), load("raw/nucleon.vvd")) else { return };
    assert_eq!(stored(&a), stored(&b));
    // The voxels are one; what the headers say of their place is not.
    assert_eq!(uniform(&b).placement().origin(), glam::DVec3::splat(-0.99999994));
    assert_eq!(uniform(&b).placement().spacing(), glam::DVec3::splat(0.04878049));
    assert_eq!((uniform(&b).calibration().slope, b.info.frames), (1.0, 1));
}

#[test]
fn pvm_unpacks_to_the_raw_file() {
    let (Some(a), Some(b)) = (load("raw/Bucky_32x32x32_uint8.raw"), load("pvm/Bucky.pvm")) else { return };
    assert_eq!(stored(&a), stored(&b));
    assert_eq!((b.info.format, b.info.encoding), ("PVM", "DDS"));
}

/// A voxel as it is stored.
fn voxel(loaded: &Loaded, [x, y, z]: [usize; 3]) -> f32 {
    let [nx, ny, _] = uniform(loaded).dims();
    stored(loaded)[x + nx * (y + ny * z)]
}

/// Voxels and positions as mrcfile 1.5 and the formula of a triclinic cell in NumPy give them.
#[test]
fn a_map_of_a_monoclinic_cell() {
    let Some(loaded) = load("mrc/EMD-3001.map.bz2") else { return };
    let grid = uniform(&loaded);
    assert_eq!((grid.dims(), loaded.info.encoding), ([73, 43, 25], "bzip2"));
    assert_eq!(loaded.info.units.as_deref(), Some("Å"));
    assert_eq!(voxel(&loaded, [7, 5, 3]), -0.039_380_778);
    assert_eq!(voxel(&loaded, [72, 42, 24]), 0.067_244_98);
    assert_eq!(voxel(&loaded, [30, 20, 10]), -0.082_779_18);
    // Columns along Z of the cell, rows along X, sections along Y.
    let at = |x, y, z| grid.placement().to_world(glam::DVec3::new(x, y, z));
    let near = |a: glam::DVec3, b: [f64; 3]| assert!((a - glam::DVec3::from_array(b)).length() < 1e-5, "{a}");
    near(at(0.0, 0.0, 0.0), [-9.413_250_16, -4.710_000_04, 0.0]);
    near(at(1.0, 2.0, 3.0), [-8.551_354_19, -3.532_500_03, 0.457_443_01]);
    let axes = grid.placement().axes();
    let angle = axes.x_axis.angle_between(axes.y_axis).to_degrees();
    assert!((angle - 94.326).abs() < 1e-4, "{angle}");
}

#[test]
fn smaller_families() {
    let Some(mri) = load("dx/mri.general") else { return };
    let grid = uniform(&mri);
    assert_eq!((grid.dims(), grid.voxel_type()), ([128, 128, 16], VoxelType::U16));
    assert_eq!(grid.placement().spacing().to_array(), [1.773153, 1.773153, 2.066667]);
    assert_eq!(grid.value_stats().range, Some((668.0, 57684.0)));
    assert_eq!((voxel(&mri, [3, 5, 7]), voxel(&mri, [100, 20, 11])), (1342.0, 4796.0));
    let nut = load("slc/nut.slc").unwrap();
    assert_eq!((uniform(&nut).dims(), nut.info.encoding), ([68, 41, 59], "run-length"));
    assert_eq!((voxel(&nut, [33, 20, 30]), voxel(&nut, [12, 20, 10])), (2.0, 0.0));
    assert_eq!(stored(&nut).iter().map(|&v| f64::from(v)).sum::<f64>(), 5_807_640.0);
}

#[test]
fn every_encoding_of_the_ball() {
    let Some(folder) = data("nrrd/ball") else { return };
    let plain = stored(&load("nrrd/ball/BallBinary30x30x30.nrrd").unwrap());
    assert_eq!(plain.iter().filter(|&&x| x == 257.0).count() + plain.iter().filter(|&&x| x == 0.0).count(), 27000);
    let mut read_ones = 0;
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if !name.starts_with("BallBinary") || name.ends_with(".raw") {
            continue;
        }
        match read(&path, &ReadOptions::default()) {
            // It points into a NIfTI file and forgets to skip its header.
            Err(FileError { kind: FileErrorKind::Length { claimed: 54000, found: 54352, .. }, .. })
                if name == "BallBinary30x30x30_nifti.nhdr" => {}
            Err(e) => panic!("{e}"),
            Ok(loaded) => {
                assert!(stored(&loaded) == plain, "{name}");
                read_ones += 1;
            }
        }
    }
    assert_eq!(read_ones, 9);
}

/// The numbers are those that VTK 9.7 reads.
#[test]
fn images_of_vtk() {
    use VoxelType::{F32, U8};
    let at = |loaded: &Loaded, [x, y, z]: [usize; 3]| {
        let [nx, ny, _] = uniform(loaded).dims();
        stored(loaded)[x + nx * (y + ny * z)]
    };
    for (name, format) in [("vtk/heart.vtk", "VTK (legacy)"), ("vtk/heart.vti", "VTK ImageData")] {
        expect(name, [32, 32, 12], F32, [1.0, 1.0, 4.0], |l, i| {
            assert_eq!((i.format, i.encoding, i.space, i.mapped), (format, "ascii", Space::Own, false));
            assert_eq!([[3, 1, 0], [31, 0, 5], [10, 20, 11]].map(|p| at(l, p)), [16.0, 0.0, 159.0]);
            assert_eq!(stored(l).iter().sum::<f32>(), 832_283.0);
        });
    }
    expect("vtk/hydrogen.vti", [64; 3], F32, [1.0; 3], |l, i| {
        assert_eq!((i.encoding, i.scalar), ("zlib", ScalarType::F32));
        let places = [[32, 32, 32], [32, 32, 22], [30, 35, 40], [32, 40, 31]];
        assert_eq!(places.map(|p| at(l, p)), [0.0, 1.0, 0.622418, 0.270586]);
    });
    expect("vtk/ironProt.vtk", [68; 3], U8, [1.0; 3], |l, i| {
        assert!(i.mapped && l.notes.is_empty(), "{:?}", l.notes);
        assert_eq!((at(l, [34; 3]), stored(l).iter().sum::<f32>()), (131.0, 4_131_089.0));
    });
    let Some(path) = data("vtk/vase_4comp.vti") else { return };
    let first = read(&path, &ReadOptions::default()).unwrap();
    let colors = first.volume.colors().expect("four bytes are a colour and an opacity");
    assert_eq!(colors.value_source(), vr_core::ColorValue::Opacity, "{:?}", first.notes);
    let vase = read(&path, &ReadOptions { component: Some(2), ..Default::default() }).unwrap();
    assert_eq!((uniform(&vase).dims(), vase.info.components), ([115, 101, 75], 4));
    assert_eq!(stored(&vase).iter().sum::<f32>(), 10_723_131.0);
    // Cell data, appended as they are.
    let array = |name: &str| ReadOptions { array: Some(name.to_owned()), ..Default::default() };
    let name = "amr/vthb/HierarchicalBoxDataset.v1.1/HierarchicalBoxDataset.v1.1_0.vti";
    let amr = load_with(name, &array("Fractal Volume Fraction")).unwrap();
    let f32s = [0.17115964387592517f64, 0.30560021651418584, 0.05766468926479942].map(|x| x as f32);
    assert_eq!([[0, 0, 0], [1, 0, 0], [3, 1, 2]].map(|p| at(&amr, p)), f32s);
    let first = uniform(&amr).placement().origin();
    let expected = [-1.75 + 0.83333331347 / 2.0, -1.25 + 0.83333331347 / 2.0, 0.66666668653 / 2.0];
    assert!((first - glam::DVec3::from_array(expected)).length() < 1e-12, "{first}");
    let refused = read(data(name).unwrap(), &array("heat")).unwrap_err().to_string();
    assert!(refused.contains("one of VectorXYZ, TestX, BlockId, Depth, Fractal Volume Fraction"), "{refused}");
}

#[test]
fn one_frame_of_four_dimensions() {
    let Some(path) = data("nifti/example4d.nii.gz") else { return };
    let frame = |n| read(&path, &ReadOptions { frame: Some(n), ..Default::default() }).unwrap();
    let (first, second) = (frame(0), frame(1));
    assert_eq!(uniform(&first).dims(), [128, 96, 24]);
    assert_eq!(stored(&first), stored(&read(&path, &ReadOptions::default()).unwrap()));
    assert_ne!(stored(&first), stored(&second));
}

#[test]
fn colours_and_one_component_of_them() {
    let Some(path) = data("bad/rgb24.nii.gz") else { return };
    let all = read(&path, &ReadOptions::default()).unwrap();
    assert!(all.notes.iter().any(|n| n.contains("drawn in their colours")), "{:?}", all.notes);
    let colors = all.volume.colors().expect("RGB24");
    let green = read(&path, &ReadOptions { component: Some(1), ..Default::default() }).unwrap();
    assert_eq!(uniform(&green).dims(), [256, 286, 15]);
    let AnyGrid::U8(grid) = uniform(&green).values() else { panic!("bytes") };
    assert_eq!(colors.values().placement(), grid.placement());
    for (&encoded, &light) in grid.samples().iter().zip(colors.channels()[1].samples) {
        let linear = vr_core::transfer::srgb_to_linear(f64::from(encoded) / 255.0);
        assert!((linear - f64::from(light) / 65535.0).abs() <= 0.5 / 65535.0);
    }
}

#[test]
fn transforms_can_be_chosen() {
    let by = |transform| load_with("nifti/FLAIR.nii.gz", &ReadOptions { transform, ..Default::default() });
    let Some(spacing) = by(Transform::Spacing) else { return };
    assert_eq!(orientation(uniform(&spacing).placement()), "RAS");
    assert_eq!(spacing.info.placed_by, "spacing");
}

/// Every broken file of these formats, and a word of the message that it must give; `""` for files that are odd but right.
const BROKEN: [(&str, &str); 48] = [
    ("nan_be_f32.nii", ""),
    ("complex64.nii.gz", "datatype: found 32 (complex numbers"),
    ("header_only.hdr.gz", "bad/header_only.img.gz: "),
    ("FullHead.mhd", "data file "),
    ("byteskip_minus_five.nhdr", "byte skip: found -5"),
    ("rgb2d.nrrd", "a picture with colours, not a volume"),
    ("empty.nrrd", "magic: found nothing; must be NRRD0001"),
    ("empty_64x64x64_uint8.raw", "claims 262144 bytes of voxels, found 0"),
    ("short.nrrd", "claims 68921 bytes of voxels, found 67921"),
    ("trunc_gz.nrrd", "claims 68921 bytes of voxels, found 33860"),
    ("huge_dims.nrrd", "dims [4294967295, 4294967295, 4294967295]"),
    ("big_dims.nrrd", "claims 281474976710656 bytes of voxels, found 68921"),
    ("zero_dim.nrrd", "sizes: found 41 0 41; must be 3 positive integers"),
    ("neg_dim.nrrd", "sizes: found 41 -41 41"),
    ("bad_type.nrrd", "type: found quaternion; must be int8"),
    ("nan_spacing.nrrd", "spacings: found NaN"),
    ("zero_spacing.nrrd", "spacing of axis 1: found 0, must be positive and finite"),
    ("constant.nrrd", ""),
    ("one_voxel.nrrd", "dims [1, 1, 1]: every axis must have 2"),
    ("one_slice.nrrd", "dims [41, 41, 1]: every axis must have 2"),
    ("nan_inf.nrrd", ""),
    ("nifti_bad_magic.nii", "magic: found"),
    ("nifti_dim0.nii", "dim[0]: found 0"),
    ("nifti_vox_offset.nii", "claims 67650 bytes of voxels, found 0"),
    ("nifti_slope_zero.nii", ""),
    ("nifti_neg_dim.nii", "dim[1]: found -33"),
    ("nifti_truncated.nii.gz", "bytes of voxels, found"),
    ("mha_wrong_type.mha", "claims 1212416 bytes of voxels, found"),
    ("not_compressed.mha", "zlib data are damaged"),
    ("fuel_plus_one_64x64x64_uint8.raw", "claims 262144 bytes of voxels, found 262145"),
    ("lies_128x128x128_uint8.raw", "claims 2097152 bytes of voxels, found 68921"),
    ("hydrogen_truncated.vti", "must be well-formed and whole"),
    ("tets_no_scalars.vtk", ""),
    ("tets_bad_index.vtk", "found vertex 999999"),
    ("tets_nan_scalar.vtk", ""),
    ("Bucky_truncated.pvm", "claims 32768 bytes of voxels, found 1"),
    ("sph_zero_h.h5", SPH_ZERO_H),
    ("no_meta.dcm", "prefix: found neither DICM nor a data set; must be DICM after 128 bytes"),
    ("JPEG2000.dcm", JPEG_2000[0]),
    ("emri_j2k_too_short.dcm", JPEG_2000[1]),
    ("MR_truncated.dcm", "claims 8192 bytes of voxels, found 8130"),
    ("badVR.dcm", "NumberOfFrames (0028,0008): found 1A; must be an integer"),
    ("SC_rgb_small_odd.dcm", "slices: found 1 image; a volume has 2 slices or more"),
    ("liver_1frame.dcm", "BitsAllocated (0028,0100): found 1; must be 8, 16 or 32: images of single bits"),
    ("rtdose.dcm", ""),
    (
        "dicom_missing_slice",
        "found a gap of 6.75 mm between -439.334 and -432.584 mm; all gaps along the normal must be",
    ),
    ("dicom_mixed", "series: found 2 in the folder; choose a series by its UID"),
    ("amrex_missing_levels", "Level_1/Cell_H: No such file"),
];

/// One picture, and a file that ends before its frames do.
const JPEG_2000: [&str; 2] = if cfg!(feature = "jpeg2000") {
    ["slices: found 1 image; a volume has 2 slices or more", "PixelData"]
} else {
    ["frames in JPEG 2000 is read by builds with the feature `jpeg2000`"; 2]
};

const SPH_ZERO_H: &str =
    if cfg!(feature = "hdf5") { "position: found" } else { "HDF5 is read by builds with the feature `hdf5`" };

/// Count, and smallest and largest radius.
fn points_of(name: &str, options: &PointOptions) -> Option<(LoadedPoints, usize, [f32; 2])> {
    let loaded = read_points(data(name)?, options).unwrap_or_else(|e| panic!("{e}"));
    println!("{name}: {:?}", loaded.notes);
    let radii = loaded.points.radii();
    let ends = radii.iter().fold([f32::INFINITY, 0.0], |[low, high], &r| [low.min(r), high.max(r)]);
    let count = radii.len();
    Some((loaded, count, ends))
}

#[test]
fn points_of_numpy_and_vtk() {
    let default = PointOptions::default();
    let Some((halo, count, radii)) = points_of("particles/halo_low_res.npy", &default) else { return };
    assert_eq!((count, halo.info.scalar), (32_314, ScalarType::F32));
    assert!(radii[0] > 0.0 && radii[1] > 10.0 * radii[0], "clustered: {radii:?}");
    let (post, count, _) = points_of("unstructured/post.vtk", &default).unwrap();
    assert_eq!((count, post.info.columns.as_slice()), (2288, &["Pressure".to_owned()][..]));
    let values = post.points.values();
    let ends = values.iter().fold([f32::INFINITY, 0.0], |[low, high], &v| [low.min(v), high.max(v)]);
    assert!((ends[0] - 0.355).abs() < 1e-3 && (ends[1] - 1.641).abs() < 1e-3, "{ends:?}");
    let options = PointOptions { value: Some("t".to_owned()), ..PointOptions::default() };
    let (fire, count, _) = points_of("unstructured/fire_ug.vtu", &options).unwrap();
    assert_eq!((count, fire.info.encoding), (12_323, "zlib"));
    let values = fire.points.values();
    let ends = values.iter().fold([f32::INFINITY, 0.0], |[low, high], &v| [low.min(v), high.max(v)]);
    assert!((ends[0] - 298.0).abs() < 1.0 && (ends[1] - 692.0).abs() < 1.0, "{ends:?}");
    let options = PointOptions { value: Some("DistanceToCenter".to_owned()), ..PointOptions::default() };
    let (_, count, _) = points_of("unstructured/Tetrahedron.vtu", &options).unwrap();
    assert_eq!(count, 35);
    assert_eq!(points_of("unstructured/tetraMesh.vtk", &default).unwrap().1, 55);
    assert_eq!(points_of("unstructured/uGridEx.vtk", &default).unwrap().1, 27);
}

#[cfg(feature = "hdf5")]
#[test]
fn points_of_phantom() {
    let Some((dump, count, radii)) = points_of("particles/phantom_adiabatic_00000.h5", &PointOptions::default()) else {
        return;
    };
    assert!(count < 20_736, "boundaries are left out");
    assert!(
        dump.notes.iter().any(|n| n.contains(&format!("{} particles are left out", 20_736 - count))),
        "{:?}",
        dump.notes
    );
    // The largest smoothing lengths, 0.0323, are the boundaries'.
    assert!((radii[0] - 2.0 * 0.0139).abs() < 1e-3 && radii[1] < 2.0 * 0.0323, "{radii:?}");
    // The field at a particle is the density that smoothing lengths tell, to within the noise of a sum over some thirty neighbours; in the
    // middle, for boundaries are left out.
    let points = &dump.points;
    let middle = (0..count).min_by(|&a, &b| {
        let far = |k: usize| points.positions()[k].length();
        far(a).total_cmp(&far(b))
    });
    let k = middle.unwrap();
    let sum: f64 = (0..count).map(|j| points.contribution(j, points.positions()[k])).sum();
    let options = PointOptions { value: Some("density".to_owned()), ..PointOptions::default() };
    let (densities, ..) = points_of("particles/phantom_adiabatic_00000.h5", &options).unwrap();
    let told = f64::from(densities.points.values()[k]);
    assert!((sum / told - 1.0).abs() < 0.02, "{sum} {told}");
}

/// Reference: pydicom 3, on the same files.
#[test]
fn scans_in_dicom() {
    let Some(loaded) = load("dicom/pet_head") else { return };
    let (grid, info) = (uniform(&loaded), &loaded.info);
    assert_eq!((grid.dims(), grid.voxel_type()), ([128, 128, 48], VoxelType::I16));
    assert_eq!((info.modality.as_deref(), info.space, info.data_files.len()), (Some("PT"), Space::Lps, 48));
    assert_eq!(info.window, Some([8431.0 - 7587.5, 8431.0 + 7587.5]));
    let spacing = grid.placement().spacing().to_array();
    assert!(spacing.iter().zip([3.5378182, 3.5378182, 3.375]).all(|(a, b)| (a - b).abs() < 1e-9), "{spacing:?}");
    assert_eq!(grid.placement().origin().to_array(), [226.13246, 425.88375, -446.084]);
    // Index axes towards left, posterior and the head.
    assert_eq!(orientation(grid.placement()), "LPS");
    let numbers = stored(&loaded);
    let at = |[x, y, z]: [usize; 3]| numbers[x + 128 * (y + 128 * z)];
    assert_eq!([[64, 64, 24], [40, 70, 10], [90, 50, 40], [60, 30, 5]].map(at), [2209.0, 118.0, 34.0, 24.0]);
    assert_eq!(numbers.iter().map(|&v| f64::from(v)).sum::<f64>(), 324_397_186.0);
    let (low, high) = loaded.volume.value_range().unwrap();
    assert!(low == 0.0 && (high - 24477.2099056).abs() < 1e-2, "{low} {high}");
    let by_file = load("dicom/pet_head/000283.dcm").unwrap();
    assert!(stored(&by_file) == numbers && by_file.notes[0].contains("all 48 of its files"), "{:?}", by_file.notes);

    let frames = load("dicom/single/emri_small.dcm").unwrap();
    let numbers = stored(&frames);
    assert_eq!((uniform(&frames).dims(), frames.info.mapped), ([64, 64, 10], true));
    assert_eq!((numbers[20 + 64 * (10 + 64 * 3)], numbers[33 + 64 * (40 + 64 * 9)]), (180.0, 79.0));
    assert!(frames.notes.iter().any(|n| n.contains("no PixelSpacing: 1, 1 is assumed")), "{:?}", frames.notes);
    let dose = load("bad/rtdose.dcm").unwrap();
    assert_eq!(uniform(&dose).placement().spacing().to_array(), [10.0, 10.0, 5.0]);
    let (low, high) = dose.volume.value_range().unwrap();
    assert!((low - 0.795).abs() < 1e-6 && (high - 1.254).abs() < 1e-6, "{low} {high}");
    for one in ["CT_small.dcm", "DICOM_KNEE.dcm"] {
        // Each is one slice of a series of its own.
        let refused = read(data("dicom/single").unwrap().join(one), &ReadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("slices: found 1 image"), "{refused}");
    }
}

#[test]
fn broken_files_are_met() {
    if data("bad").is_none() {
        return;
    }
    for (name, word) in BROKEN {
        let path = data("bad").unwrap().join(name);
        match read(&path, &ReadOptions::default()) {
            Ok(_) => assert!(word.is_empty(), "{name} was read"),
            Err(e) => {
                let message = e.to_string();
                println!("{message}");
                assert!(!word.is_empty() && message.contains(word), "{message}");
                assert!(message.contains(name) && !message.contains('\n'), "{message}");
            }
        }
    }
    let nan = load("bad/nan_be_f32.nii").unwrap();
    assert_eq!(uniform(&nan).value_stats().nan, 153);
    assert!(nan.notes.iter().any(|n| n.contains("153 of 1071 voxels are NaN")), "{:?}", nan.notes);
    let infinite = load("bad/nan_inf.nrrd").unwrap();
    assert_eq!((uniform(&infinite).value_stats().nan, uniform(&infinite).value_stats().infinite), (1681, 2));
    let slope = load("bad/nifti_slope_zero.nii").unwrap();
    assert_eq!(uniform(&slope).calibration().slope, 1.0);
    assert!(matches!(
        read(data("bad/one_slice.nrrd").unwrap(), &ReadOptions::default()),
        Err(FileError { kind: FileErrorKind::Grid(GridError::Dims { .. }), .. })
    ));
}

/// No file at all may panic, and each must be refused or read within reason.
#[test]
fn nothing_panics() {
    fn walk(folder: &Path, visit: &mut impl FnMut(&Path)) {
        for entry in folder.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, visit);
            } else {
                visit(&path);
            }
        }
    }
    let Some(root) = data("") else { return };
    let mut results = [0; 2];
    walk(&root, &mut |path| {
        let read = read(path, &ReadOptions::default());
        results[usize::from(read.is_err())] += 1;
        if let Err(e) = read {
            assert!(!e.to_string().contains('\n'), "{e}");
        }
    });
    println!("{} read, {} refused", results[0], results[1]);
}

#[test]
fn zarr_arrays_equal_the_raw_files_that_they_were_made_of() {
    let nucleon = ReadOptions { raw: Some(RawDescription::new([41; 3], ScalarType::U8)), ..Default::default() };
    let pairs = [
        ("zarr/nucleon_v2.zarr", "zlib", "raw/nucleon.raw", nucleon),
        ("zarr/fuel_v3.zarr", "gzip", "raw/fuel_64x64x64_uint8.raw", ReadOptions::default()),
    ];
    for (name, encoding, raw, options) in pairs {
        let (Some(zarr), Some(raw)) = (load(name), load_with(raw, &options)) else { return };
        assert_eq!(uniform(&zarr).dims(), uniform(&raw).dims(), "{name}");
        assert_eq!(stored(&zarr), stored(&raw), "{name}");
        assert_eq!((zarr.info.format, zarr.info.encoding), ("Zarr", encoding));
    }
}

/// Files that other programs wrote, with the voxels that they hold as f32 in `NAME.f32` beside each: `VR_STACK_DATA` names the folder.
#[test]
fn stacks_of_other_programs() {
    let Some(folder) = std::env::var_os("VR_STACK_DATA").map(PathBuf::from) else {
        println!("skipped: VR_STACK_DATA names no folder");
        return;
    };
    let mut wrong = Vec::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        let Ok(bytes) = std::fs::read(folder.join(format!("{name}.f32"))) else { continue };
        let expected: Vec<f32> = bytes.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
        match read(&path, &ReadOptions::default()) {
            Ok(loaded) if stored(&loaded) == expected => println!("{name}: {:?} {:?}", loaded.info.units, loaded.notes),
            Ok(_) => wrong.push(format!("{name}: other voxels")),
            Err(e) => wrong.push(e.to_string()),
        }
    }
    let refused = |message: &String| message.contains("BloscLZ is not read");
    wrong.retain(|message| !refused(message));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
