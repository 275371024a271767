//! Surfaces among volumes, as a user asks for them.

use crate::harness::Vr;

/// A square across the embedded volume, at a height over its middle, wide enough to hide all that is below.
fn square(height: f64) -> String {
    let corners = [[-9, -9], [9, -9], [9, 9], [-9, 9]].map(|[x, y]| format!("v {x} {y} {height}\n"));
    corners.concat() + "f 1 2 3 4\n"
}

fn json(run: &str) -> serde_json::Value {
    let vr = Vr::new();
    vr.write("square.obj", square(0.1));
    vr.run(run).succeeded().json()
}

#[test]
fn a_mesh_stands_in_the_embedded_scene_and_the_error_stays_small() {
    let vr = Vr::new();
    vr.write("square.obj", square(0.1));
    let run = "render --mesh square.obj --mesh-color 0,0.5,0 --eye 0,0,6 --target 0,0,0 --up 0,1,0 --height 3 --size 64 --json -o x.png";
    let run = vr.run(run).succeeded();
    assert!(run.stderr.contains("1 polygons are cut"), "{}", run.stderr);
    let json = run.json();
    assert!(json["volume"].as_str().unwrap().contains("square.obj of 2 triangles"), "{json}");
    // Against the reference of the same scene with the same layer.
    assert!(json["error"]["max"].as_f64().unwrap() < 1.0 / 255.0, "{json}");
    let corner = vr.picture("x.png").to_rgb8().get_pixel(1, 1).0;
    assert!(corner[1] > 100 && corner[0] > corner[1] / 4, "green under a headlight, with its highlight: {corner:?}");
}

#[test]
fn every_renderer_draws_it_or_says_that_it_cannot() {
    let run = |renderer: &str| {
        let vr = Vr::new();
        vr.write("square.obj", square(0.0));
        vr.run(&format!("render --mesh square.obj --renderer {renderer} --size 24 --json"))
    };
    for renderer in ["raycast", "texslice", "splat", "physics"] {
        let json = run(renderer).succeeded().json();
        assert!(json["error"]["max"].as_f64().unwrap() < 1.0 / 255.0, "{renderer}: {json}");
    }
    // Texels as large as voxels: a picture as soft as that.
    let json = run("shearwarp").succeeded().json();
    assert!(json["error"]["max"].as_f64().unwrap() < 0.3, "shearwarp: {json}");
}

#[test]
fn a_large_volume_is_refused_by_its_header() {
    let vr = Vr::new();
    vr.write("square.obj", square(0.0));
    // Of the voxels that the name claims none is there: to read them fails, but the renderer is asked first.
    vr.write("large_512x512x512_uint8.raw", "");
    let draw = |renderer: &str| {
        vr.run(&format!("render large_512x512x512_uint8.raw --mesh square.obj --renderer {renderer} --size 24"))
            .failed(1)
    };
    let error = draw("shearwarp --filter bspline");
    assert!(error.contains("shearwarp does not support the filter"), "{error}");
    let error = draw("raycast");
    assert!(error.contains("claims 134217728 bytes of voxels, found 0"), "{error}");
}

#[test]
fn a_scene_file_names_a_mesh_beside_it() {
    let vr = Vr::new();
    std::fs::create_dir(vr.folder().join("scenes")).unwrap();
    vr.write("scenes/square.obj", square(0.0));
    vr.write("other.obj", square(-0.3) + "f 1 2 4\n");
    let scene = "[volume]\nphantom = \"blobs\"\nsize = 16\n[mesh]\npath = \"square.obj\"\ncolor = [1.0, 0.0, 0.0]\n\
                 [shading]\nspecular = 0.0\n";
    vr.write("scenes/x.toml", scene);
    let title = |flags: &str| {
        let run = vr.run(&format!("render --scene scenes/x.toml --size 16 --json {flags}")).succeeded();
        run.json()["volume"].as_str().unwrap().to_owned()
    };
    assert!(title("").ends_with("square.obj of 2 triangles"));
    let corner = vr.picture("vr.png").to_rgb8().get_pixel(5, 8).0;
    assert!(corner[0] > 80 && corner[1] == 0 && corner[2] == 0, "red, and nothing shines: {corner:?}");
    // Relative to here, not to the scene; and the colour of the other one is not its own.
    assert!(title("--mesh other.obj").ends_with("other.obj of 3 triangles"));
    let corner = vr.picture("vr.png").to_rgb8().get_pixel(5, 8).0;
    assert!(corner[0] > 80 && corner[0] == corner[1], "grey: {corner:?}");
}

#[test]
fn info_tells_what_a_mesh_is() {
    let vr = Vr::new();
    vr.write("square.obj", square(0.5));
    let text = vr.run("info square.obj").succeeded().stdout;
    for word in ["OBJ", "2 triangles", "4 vertices", "-9 -9 0.5 to 9 9 0.5", "positions alone", "--mesh"] {
        assert!(text.contains(word), "no {word:?} in\n{text}");
    }
    let json = vr.run("info square.obj --json").succeeded().json();
    assert_eq!((&json["triangles"], &json["bounds"][1]), (&2.into(), &serde_json::json!([9.0, 9.0, 0.5])));
    let error = vr.run("info square.obj --frame 1").failed(1);
    assert!(error.contains("mesh"), "{error}");
}

#[test]
fn other_commands_know_it_too() {
    let bench = json("bench --mesh square.obj --size 16 --frames 2 --error --json");
    assert!(bench["error"]["max"].as_f64().unwrap() < 1.0 / 255.0, "{bench}");
    let compare = json("compare --mesh square.obj --size 16 --renderer raycast --renderer shearwarp --json");
    let names: Vec<&str> =
        compare["renderers"].as_array().unwrap().iter().map(|r| r["name"].as_str().unwrap()).collect();
    assert!(["raycast", "shearwarp"].iter().all(|name| names.iter().any(|found| found.starts_with(name))), "{names:?}");
    let vr = Vr::new();
    vr.write("square.obj", square(0.0));
    let verify = vr.run("verify --phantom fog --phantom-size 16 --mesh square.obj --renderer shearwarp --no-cache");
    assert!(verify.code == 0 && verify.stdout.contains("as documented"), "{}{}", verify.stdout, verify.stderr);
}

#[test]
fn a_mesh_out_of_sight_is_told() {
    let vr = Vr::new();
    vr.write("square.obj", square(0.0));
    let run =
        vr.run("render --mesh square.obj --size 8 --error none --eye 0,0,5 --target 0,0,9 --up 0,1,0").succeeded();
    assert!(run.stderr.contains("nowhere in the picture"), "{}", run.stderr);
}

#[test]
fn wrong_meshes_get_one_line() {
    let vr = Vr::new();
    vr.write("square.obj", square(0.0));
    vr.write("broken.obj", "v 0 0 0\nf 1 2\n");
    vr.write("x.toml", "[volume]\nphantom = \"fog\"\n[mesh]\npath = \"none.ply\"\n");
    vr.write("y.toml", "[volume]\nphantom = \"fog\"\n[mesh]\npath = \"square.obj\"\ncolour = [1, 0, 0]\n");
    vr.write("z.toml", "[volume]\nphantom = \"fog\"\n[mesh]\npath = \"square.obj\"\ncolor = [-1, 0, 0]\n");
    for (arguments, code, words) in [
        ("--mesh none.stl", 1, &["none.stl"][..]),
        ("--mesh broken.obj", 1, &["broken.obj", "line 2", "three corners"]),
        ("--mesh x.toml", 1, &["x.toml", "STL", "OBJ", "PLY"]),
        ("--mesh-color 1,0,0", 2, &["mesh.color", "--mesh"]),
        ("--mesh square.obj --mesh-color 1,-1,0", 2, &["mesh.color", "-1", "negative"]),
        ("--mesh square.obj --mesh-color red", 2, &["--mesh-color", "three numbers"]),
        ("square.obj", 1, &["square.obj", "mesh", "--mesh"]),
        ("--scene x.toml", 1, &["none.ply"]),
        ("--scene y.toml", 1, &["y.toml", "line 5", "colour", "did you mean 'color'"]),
        ("--scene z.toml", 1, &["z.toml", "mesh.color", "-1"]),
        ("--scene z.toml --mesh-color 0,0,nan", 2, &["mesh.color", "NaN"]),
    ] {
        let error = vr.run(&format!("render --size 8 --error none {arguments}")).failed(code);
        for word in words {
            assert!(error.contains(word), "{arguments}: no {word:?} in {error}");
        }
    }
    assert!(!vr.exists("vr.png"));
}

#[test]
fn it_stands_in_the_light_of_media_that_scatter() {
    let picture = |model: &str| {
        let vr = Vr::new();
        vr.write("square.obj", square(-0.2));
        let view = "--eye 0,0,6 --target 0,0,0 --up 0,1,0 --height 3 --size 16 --light 0,0,1 --mesh-color 0,0.5,0";
        vr.run(&format!("render --mesh square.obj {view} --model {model} --json -o x.png")).succeeded();
        vr.picture("x.png").to_rgb8().get_pixel(0, 0).0
    };
    // In the corner there is no volume: a lamp of colour 1 in front, 0.7 of the colour by the default shading, encoded as sRGB.
    let [full, single] = ["full --set paths=4", "single"].map(picture);
    assert_eq!((full, single), ([0, 160, 0], [0, 160, 0]));
}
