//! Scene files: what they say, what they are told when they are wrong, and that they come back as they were.

use std::path::Path;

use glam::DVec3;
use vr_core::transfer::srgb_to_linear;
use vr_core::{Calibration, Placement, PointKernel, PointSet, Projection, Scene, UniformGrid, View};
use vr_io::{SceneFile, load_scene, parse_scene, resolve_scene, scene_text, write_scene};

/// The example of the design, with a raw volume beside it.
const EXAMPLE: &str = r#"
[volume]
path = "foot.raw"
dims = [4, 3, 2]
type = "u16"
endian = "big"
spacing = [1.0, 1.0, 2.0]
slope = 0.5
intercept = -1.0
filter = "trilinear"
[transfer]
unit_distance = 1.0
opacity_rule = "power"
colors = "srgb"
points = [ {value = 0.0, color = [0.0, 0.0, 0.0], opacity = 0.0}, {value = 255.0, color = [1.0, 0.5, 0.8], opacity = 0.4} ]
[shading]
ambient = 0.2
diffuse = 0.7
specular = 0.3
power = 20.0
lights = [ {headlight = true} ]
[camera]
projection = "orthographic"
eye = [300.0, 200.0, 400.0]
target = [127.5, 127.5, 127.5]
up = [0.0, 1.0, 0.0]
height = 300.0
[clip]
box = [[0.0, 0.0, 0.0], [255.0, 255.0, 128.0]]
planes = [ {normal = [0.0, 0.0, 1.0], offset = 64.0} ]
[image]
size = [512, 512]
samples = 1
background = [0.0, 0.0, 0.0]
[render]
renderer = "raycast"
compositing = "over"
max_error = 0.004
step = 0.25
"#;

#[test]
fn the_example_of_the_design() {
    let folder = tempfile::tempdir().unwrap();
    let samples: Vec<u8> = (0..24u16).flat_map(|i| (10 * i).to_be_bytes()).collect();
    std::fs::write(folder.path().join("foot.raw"), samples).unwrap();
    std::fs::write(folder.path().join("scene.toml"), EXAMPLE).unwrap();
    let loaded = load_scene(folder.path().join("scene.toml")).unwrap();
    let uniform = loaded.scene.volume.grid().unwrap();
    assert_eq!(uniform.dims(), [4, 3, 2]);
    assert_eq!(uniform.placement().spacing(), DVec3::new(1.0, 1.0, 2.0));
    assert_eq!(loaded.scene.volume.value_range(), Some((-1.0, 114.0)));
    assert_eq!(loaded.scene.transfer.points()[1].color[1], srgb_to_linear(0.5));
    assert_eq!(loaded.view.clip.planes.len(), 1);
    assert_eq!((loaded.renderer.as_deref(), loaded.max_error), (Some("raycast"), Some(0.004)));
    assert_eq!(loaded.options.0.len(), 1);
}

#[test]
fn wrong_files_are_told_where_and_what() {
    for (text, word) in [
        ("[volume]\nphantom = \"fog\"\n\n[imge]\n", "s.toml: line 4: unknown key 'imge'; did you mean 'image'?"),
        ("[volume]\nfliter = \"trilinear\"\n", "s.toml: line 2: unknown key 'fliter'; did you mean 'filter'?"),
        (
            "[transfer]\npoints = [\n {value = 0, colour = [0,0,0], opacity = 0}]",
            "line 3: unknown key 'colour'; did you mean 'color'?",
        ),
        (
            "[camera]\neye = [0,0,0]\ntarget = [1,0,0]\nup = [0,1,0]\nqqqqqqq = 1\n",
            "line 5: unknown key 'qqqqqqq'; must be one of projection, eye",
        ),
        (
            "[volume]\nfilter = \"cubic\"\n",
            "s.toml: line 2: volume.filter: found \"cubic\"; must be one of nearest, trilinear",
        ),
        ("[image]\nsize = [512]\n", "s.toml: line 2: "),
        ("volume = \n", "s.toml: line 1: "),
    ] {
        let message = parse_scene(text, Path::new("s.toml")).unwrap_err().to_string();
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
    }
    for (text, word) in [
        ("", "s.toml: volume: found nothing; must have a path, a phantom, data or points"),
        ("[volume]\nphantom = \"fog\"\npath = \"x\"", "volume: found several"),
        ("[volume]\nphantom = \"frog\"", "volume.phantom: found 'frog' (did you mean 'fog'?); must be marschner-lobb"),
        ("[volume]\nphantom = \"fog\"\nsize = 1", "volume.size: found 1; must be 2 to 2048"),
        ("[volume]\npath = \"x.raw\"\ntype = \"u8\"", "volume.dims: found nothing"),
        ("[volume]\npath = \"x.raw\"\ndims = [2,2,2]", "volume.type: found nothing"),
        ("[volume]\npath = \"x.raw\"\ndims = [2,2,2]\ntype = \"u9\"", "volume.type: found \"u9\"; must be u8"),
        ("[volume]\npath = \"nowhere.nrrd\"", "nowhere.nrrd: "),
        (
            "[volume]\nphantom = \"fog\"\nsize = 4\n[transfer]\npreset = \"gray\"",
            "transfer.preset: found 'gray' (did you mean 'grey'?)",
        ),
        ("[volume]\nphantom = \"fog\"\nsize = 4\n[transfer]\npoints = []", "transfer.points: found"),
        (
            "[volume]\nphantom = \"fog\"\nsize = 4\n[transfer]\npoints = [{value = 1, color = [0,0,0], opacity = 0}, {value = 0, color = [0,0,0], opacity = 0}]",
            "points must be sorted",
        ),
        (
            "[volume]\nphantom = \"fog\"\nsize = 4\n[transfer]\npoints = [{value = 1, color = [0,0,0], opacity = 1.5}]",
            "transfer.points[0].opacity: found 1.5",
        ),
        (
            "[volume]\nphantom = \"fog\"\nsize = 4\n[transfer]\npreset = \"grey\"\nrange = [1, 0]",
            "transfer.range: found [1.0, 0.0]",
        ),
        ("[volume]\nphantom = \"fog\"\nsize = 4\n[image]\nsize = [0, 5]", "image.size"),
        (
            "[volume]\nphantom = \"fog\"\nsize = 4\n[camera]\neye = [0,0,0]\ntarget = [0,0,0]\nup = [0,1,0]\nheight = 1",
            "camera",
        ),
    ] {
        let path = Path::new("s.toml");
        let message = parse_scene(text, path).and_then(|file| resolve_scene(&file, path)).unwrap_err().to_string();
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
    }
}

/// A section and its text say the same.
#[test]
fn sections_come_back_as_they_were() {
    for volume in [
        "path = \"x.raw\"\ndims = [2, 3, 4]\ntype = \"uint16\"\nendian = \"big\"\nskip = 9\nspacing = [1, 2, 3]\norigin = [0, 1, 2]\n\
         direction = [[0, 1, 0], [1, 0, 0], [0, 0, 1]]\nslope = 2\nintercept = -1\nfilter = \"gaussian\"",
        "path = \"x.nii\"\nframe = 1\ncomponent = 2\ntransform = \"qform\"",
        "path = \"scan\"\nseries = \"1.2.3\"\nlevel = 2",
        "path = \"x.csv\"\nkernel = \"cone\"\nradius = 1\nradius_scale = 2\nvalue = \"T\"\nmixing = \"mean\"\ncolor_value = \"u\"\ncolor_map = \"cool-warm\"\ncolor_range = [0, 2]\ncolumns = {position = [\"a\", \"b\", \"c\"], mass = \"m\"}",
        "phantom = \"fog\"\nsize = 9",
        "phantom = \"plummer\"\ncount = 7",
        "data = [0, nan, 2, 3, 4, 5, 6, 7]\ndims = [2, 2, 2]\ntype = \"f32\"\nslope = 2",
        "points = [[0, 0, 0, 1, 2, 3]]\nkernel = \"gaussian\"\nmixing = \"mean\"\npoint_colors = [[0, 0.5, 1]]",
        "filter = \"nearest\"",
    ] {
        let rest = "[shading]\nlights = [{direction = [0, 0, 1]}]\ngradient_opacity = [[0, 1], [2, 0.5]]\n[clip]\nbox = [[0, 0, 0], [1, 1, 1]]\n\
                    planes = [{normal = [0, 0, 1], offset = 4}]\n[render]\ncompositing = \"first\"\nthreshold = 3\nstep = 0.5\n";
        let file = parse_scene(&format!("[volume]\n{volume}\n{rest}"), Path::new("")).unwrap();
        let text = scene_text(&file).unwrap();
        assert_eq!(scene_text(&parse_scene(&text, Path::new("")).unwrap()).unwrap(), text);
        let keys = |text: &str| text.parse::<toml::Table>().unwrap()["volume"].as_table().unwrap().clone();
        let keys = (keys(&format!("[volume]\n{volume}")), keys(&text));
        assert_eq!(keys.0.len(), keys.1.len(), "{text}");
        assert!(keys.0.keys().all(|key| keys.1.contains_key(key)), "{text}");
    }
}

#[test]
fn files_of_several_volumes_give_the_one_that_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let array = |name: &str, voxels: &str| {
        format!("<DataArray type=\"Float32\" Name=\"{name}\" format=\"ascii\">{voxels}</DataArray>")
    };
    let extent = "Extent=\"0 1 0 1 0 1\"";
    let image = format!(
        "<VTKFile type=\"ImageData\"><ImageData Whole{extent} Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece {extent}><PointData>{}{}\
         </PointData></Piece></ImageData></VTKFile>",
        array("heat", "0 1 2 3 4 5 6 7"),
        array("flow", "1 1 1 1 1 1 1 9"),
    );
    std::fs::write(folder.path().join("x.vti"), image).unwrap();
    let path = folder.path().join("s.toml");
    let resolved = |keys: &str| {
        let file = parse_scene(&format!("[volume]\npath = \"x.vti\"\n{keys}"), &path).unwrap();
        resolve_scene(&file, &path).map(|loaded| loaded.scene.volume.value_range()).map_err(|e| e.to_string())
    };
    assert_eq!(resolved("value = \"flow\""), Ok(Some((1.0, 9.0))));
    for (keys, word) in [
        ("value = \"mass\"", "must be one of heat, flow"),
        ("series = 7", "series: found 7; only DICOM files belong to series"),
        ("level = 1", "level: found 1; only OME-Zarr images have levels"),
        ("radius = 1", "volume.radius: found 1.0; only scattered points have one"),
    ] {
        let message = resolved(keys).unwrap_err();
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn phantoms_bring_their_transfer_function() {
    let file = parse_scene("[volume]\nphantom = \"blobs\"\nsize = 8\n", Path::new("")).unwrap();
    let loaded = resolve_scene(&file, Path::new("")).unwrap();
    assert_eq!(loaded.scene.volume.grid().unwrap().dims(), [8; 3]);
    assert_eq!(loaded.scene.transfer.unit_distance(), vr_core::phantom::TRANSFER_UNIT_DISTANCE);
}

#[test]
fn what_a_property_test_prints_is_read_back_identical() {
    let samples = vec![0.1f32, f32::NAN, -3.5, 1e-30, 7.0, 1e20, 0.0, 2.0];
    let placement = Placement::oriented(DVec3::new(0.1, 2.0, -3.0), [0.3, 1.0, 2.0], glam::DMat3::IDENTITY).unwrap();
    let grid = UniformGrid::new([2, 2, 2], samples, placement, Calibration { slope: 0.1, intercept: 3.0 }).unwrap();
    let file = parse_scene(EXAMPLE, Path::new("")).unwrap();
    let (scene, view): (Scene, View) =
        file.assemble(grid.into(), vec![vr_core::ControlPoint::new(0.1, [0.2, 0.3, 1.0 / 3.0], 0.7)]).unwrap();
    let described = SceneFile::describe(&scene, &view).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("failing.toml");
    write_scene(&path, &described).unwrap();
    assert_eq!(scene_text(&described).unwrap(), std::fs::read_to_string(&path).unwrap());
    let back = load_scene(&path).unwrap();
    let (a, b) = (scene.volume.grid().unwrap(), back.scene.volume.grid().unwrap());
    assert_eq!(a.placement(), b.placement());
    assert_eq!(a.calibration(), b.calibration());
    let (vr_core::AnyGrid::F32(a), vr_core::AnyGrid::F32(b)) = (a.values(), b.values()) else {
        panic!("f32 stays f32")
    };
    assert!(a.samples().iter().zip(b.samples()).all(|(x, y)| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan())));
    assert_eq!(scene.transfer, back.scene.transfer);
    assert_eq!(view.camera, back.view.camera);
    assert_eq!(view.clip, back.view.clip);
}

/// A mesh beside the scene file: read, part of what there is to see, and written as it was.
#[test]
fn a_mesh_belongs_to_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.obj"), "v 0 0 0\nv 50 0 0\nv 0 -40 0\nf 1 2 3\n").unwrap();
    let text = "[volume]\nphantom = \"fog\"\nsize = 4\n[mesh]\npath = \"x.obj\"\ncolor = [0.5, 0.25, 1.0]\n";
    let path = folder.path().join("x.toml");
    let file = parse_scene(text, &path).unwrap();
    let written = scene_text(&file).unwrap();
    assert_eq!(parse_scene(&written, &path).unwrap(), file, "{written}");
    let loaded = resolve_scene(&file, &path).unwrap();
    let (low, high) = loaded.bounds();
    assert_eq!((low.y, high.x, high.y), (-40.0, 50.0, loaded.scene.volume.bounds().1.y));
    // The default camera sees all of it, and it fills the picture.
    let camera = loaded.view.camera;
    let frame = camera.frame().unwrap();
    let Projection::Orthographic { height } = camera.projection else { panic!("orthographic") };
    let seen =
        loaded.visible().iter().copied().map(|p| (frame.transpose() * (p - camera.target)).abs() / (0.5 * height));
    let most = seen.fold(DVec3::ZERO, DVec3::max);
    assert!((most.x.max(most.y) - 0.9).abs() < 1e-9, "{most}");
    let mesh = loaded.mesh.unwrap();
    assert_eq!((mesh.mesh.triangles().len(), mesh.color), (1, Some([0.5, 0.25, 1.0])));
    assert!(parse_scene("[mesh]\ncolor = [1.0, 0.0, 0.0]\n", &path).unwrap_err().to_string().contains("path"));
}

#[test]
fn points_stand_in_scene_files_and_come_back_identical() {
    let positions = vec![DVec3::new(0.1, 1.0 / 3.0, -1e6), DVec3::ONE];
    let points =
        PointSet::new(positions, vec![0.1, 3.5], vec![1.0 / 3.0, -2.0], vec![1e-20, 7.5], PointKernel::Gaussian)
            .unwrap();
    let file =
        parse_scene("[camera]\neye = [0,0,9]\ntarget = [0,0,0]\nup = [0,1,0]\nheight = 3\n", Path::new("")).unwrap();
    let control_points = vec![vr_core::ControlPoint::new(0.0, [1.0; 3], 0.5)];
    let (scene, view) = file.assemble(points.into(), control_points).unwrap();
    let text = scene_text(&SceneFile::describe(&scene, &view).unwrap()).unwrap();
    let back = resolve_scene(&parse_scene(&text, Path::new("x.toml")).unwrap(), Path::new("x.toml")).unwrap();
    let (a, b) = (scene.volume.points().unwrap(), back.scene.volume.points().unwrap());
    assert_eq!((a.positions(), a.radii(), a.kernel()), (b.positions(), b.radii(), b.kernel()), "{text}");
    assert_eq!((a.weights(), a.values()), (b.weights(), b.values()), "{text}");
    assert_eq!(back.renderer, None);
}

#[test]
fn files_and_phantoms_of_points() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.csv"), "a,b,c,size,m,T\n0,0,0,2,1,5\n9,0,0,4,1,6\n").unwrap();
    let text = "[volume]\npath = \"x.csv\"\nkernel = \"cone\"\nradius_scale = 0.5\nvalue = \"T\"\n\
                columns = {position = [\"a\", \"b\", \"c\"], radius = \"size\", weight = \"m\"}\n";
    let path = folder.path().join("x.toml");
    let file = parse_scene(text, &path).unwrap();
    let written = scene_text(&file).unwrap();
    assert_eq!(parse_scene(&written, &path).unwrap(), file, "{written}");
    let loaded = resolve_scene(&file, &path).unwrap();
    let points = loaded.scene.volume.points().unwrap();
    assert_eq!((points.radii(), points.weights(), points.values()), (&[1.0, 2.0][..], &[1.0; 2][..], &[5.0, 6.0][..]));
    assert_eq!(points.kernel(), PointKernel::Cone);
    assert!(loaded.notes.iter().any(|n| n.starts_with("look: field")), "{:?}", loaded.notes);
    // The default camera sees the supports, too.
    assert_eq!(loaded.bounds(), (DVec3::new(-1.0, -2.0, -2.0), DVec3::new(11.0, 2.0, 2.0)));

    let phantom = |text: &str| {
        let path = Path::new("x.toml");
        resolve_scene(&parse_scene(text, path).unwrap(), path)
    };
    for name in vr_core::phantom::POINT_NAMES {
        let loaded = phantom(&format!("[volume]\nphantom = \"{name}\"\ncount = 50\n")).unwrap();
        assert_eq!(loaded.scene.volume.points().unwrap().count(), 50);
        let (_, unit_distance) = vr_core::phantom::point_transfer_function(name).unwrap();
        assert_eq!(loaded.scene.transfer.unit_distance(), unit_distance);
    }
}

#[test]
fn keys_that_do_not_suit_the_volume_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.csv"), "x,y,z,r\n0,0,0,1\n").unwrap();
    std::fs::write(folder.path().join("g_2x2x2_uint8.raw"), [0; 8]).unwrap();
    let path = folder.path().join("x.toml");
    for (volume, words) in [
        ("path = \"x.csv\"\ncount = 4", &["volume.count", "only phantoms"][..]),
        ("path = \"x.csv\"\nfilter = \"bspline\"", &["volume.filter", "points have a kernel"]),
        ("path = \"x.csv\"\nradius = 0.0", &["volume.radius", "positive"]),
        ("path = \"x.csv\"\nvalue = \"T\"", &["x.csv", "value: found T", "x, y, z, r"]),
        ("path = \"x.csv\"\ncolumns = {density = \"rho\"}", &["density: found rho"]),
        ("path = \"x.csv\"\ncolumns = {densities = \"rho\"}", &["densities", "did you mean 'density'"]),
        ("path = \"x.csv\"\nkernel = \"cube\"", &["cube", "cubic-spline"]),
        ("path = \"x.csv\"\npoints = [[0,0,0,1,1,1]]", &["several of path, phantom, data and points"]),
        ("path = \"g_2x2x2_uint8.raw\"\nkernel = \"cone\"", &["volume.kernel", "grid"]),
        ("phantom = \"fog\"\nsize = 4\ncount = 4", &["volume.count", "grid"]),
        ("phantom = \"plummer\"\nsize = 4", &["volume.size", "made of points"]),
        ("phantom = \"plummer\"\ncount = 0", &["volume.count", "1 to 100000000"]),
        ("phantom = \"plummer\"\nkernel = \"cone\"", &["volume.kernel", "its own"]),
        ("phantom = \"plumer\"", &["did you mean 'plummer'"]),
        ("points = [[0,0,0,1,1,1]]\nradius = 2.0", &["volume.radius", "only points from files"]),
        ("points = [[0,0,0,0,1,1]]", &["volume.points", "radius 0"]),
        (
            "phantom = \"fog\"\nspacing = [1, 1, 2]",
            &["x.toml: line 1: volume.spacing: found [1.0, 1.0, 2.0]", "a size"],
        ),
        ("phantom = \"plumer\"\ncount = 4", &["did you mean 'plummer'"]),
        ("data = [0]\ndims = [1,1,1]\nframe = 1", &["volume.frame: found 1", "dims, type, spacing"]),
        ("dims = [2,2,2]", &["volume: found dims alone", "a path, a phantom, data or points"]),
        ("path = \"x.raw\"\nendian = \"middle\"", &["line 3", "volume.endian: found \"middle\"", "little", "big"]),
        ("points = []", &["volume.points", "no point"]),
        ("data = [0,0,0,0,0,0,0,0]\ndims = [2,2,2]\nvalue = \"T\"", &["volume.value", "grid"]),
    ] {
        let text = format!("[volume]\n{volume}\n");
        let error = parse_scene(&text, &path).and_then(|file| resolve_scene(&file, &path)).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word) && !error.contains('\n'), "{volume}: no {word:?} in {error}");
        }
    }
}
