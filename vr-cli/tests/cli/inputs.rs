//! No command writes over a file that it reads, by whatever name.

use std::fs;

use crate::harness::Vr;

/// Files of a folder and their bytes.
fn contents(vr: &Vr) -> Vec<(String, Vec<u8>)> {
    let read = |name: &String| fs::read(vr.folder().join(name)).unwrap_or_default();
    vr.files().into_iter().map(|name| (name.clone(), read(&name))).collect()
}

/// Runs a command that has to be refused as wrong usage, and leave every byte of the folder as it was.
#[track_caller]
fn spared(vr: &Vr, arguments: &str, place: &str) {
    let before = contents(vr);
    let error = vr.run(arguments).failed(2);
    assert!(error.contains(place) && error.contains("would destroy it"), "{arguments}: {error}");
    assert!(contents(vr) == before, "{arguments}: a file has changed");
}

const HEADER: &str = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspacings: 1 1 1\n";

/// A folder with volumes of several kinds: of one file, under the name of a picture, and of a header with one and two data files.
fn scans() -> Vr {
    let vr = Vr::new();
    vr.write("x.png", format!("{HEADER}\nabcdefgh"));
    vr.write("detached.nhdr", format!("{HEADER}data file: voxels.png\n"));
    vr.write("voxels.png", "abcdefgh");
    vr.write("stack.nhdr", format!("{HEADER}data file: slice%d.png 0 1 1\n"));
    vr.write("slice0.png", "abcd");
    vr.write("slice1.png", "efgh");
    vr.write(
        "meta.mhd",
        "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = voxels.png\n",
    );
    vr
}

const SMALL: &str = "--size 4 --error none";

#[test]
fn volumes_are_spared() {
    let vr = scans();
    vr.run(&format!("render x.png {SMALL} -o fine.png")).succeeded();
    for (volume, place) in [
        ("x.png", "x.png"),
        ("x.png", "./x.png"),
        ("detached.nhdr", "voxels.png"),
        ("stack.nhdr", "slice0.png"),
        ("stack.nhdr", "slice1.png"),
        ("meta.mhd", "voxels.png"),
    ] {
        spared(&vr, &format!("render {volume} {SMALL} -o {place}"), place);
        spared(&vr, &format!("render {volume} {SMALL} -o new.exr -o {place}"), place);
        spared(&vr, &format!("render {volume} --size 4 -o new.png --error-map {place}"), place);
        spared(&vr, &format!("compare {volume} --size 4 -o {place}"), place);
    }
    // The picture's own name where none is given.
    vr.write("vr.png", fs::read(vr.folder().join("x.png")).unwrap());
    spared(&vr, &format!("render vr.png {SMALL}"), "vr.png");
}

#[cfg(unix)]
#[test]
fn links_are_seen_through() {
    use std::os::unix::fs::symlink;
    let vr = scans();
    let at = |name: &str| vr.folder().join(name);
    fs::hard_link(at("x.png"), at("hard.png")).unwrap();
    symlink("x.png", at("soft.png")).unwrap();
    symlink("soft.png", at("further.png")).unwrap();
    symlink(".", at("here")).unwrap();
    fs::hard_link(at("slice1.png"), at("hard1.png")).unwrap();
    for place in ["hard.png", "soft.png", "further.png", "here/x.png"] {
        spared(&vr, &format!("render x.png {SMALL} -o {place}"), place);
        // The other way round: read through the link, written to the file.
        spared(&vr, &format!("render {place} {SMALL} -o x.png"), "x.png");
    }
    spared(&vr, &format!("render stack.nhdr {SMALL} -o hard1.png"), "hard1.png");
    // A link to a file of no concern is written through, as ever.
    vr.write("other.png", "old");
    symlink("other.png", at("link.png")).unwrap();
    vr.run(&format!("render x.png {SMALL} -o link.png --force")).succeeded();
    assert!(at("link.png").is_symlink() && fs::read(at("other.png")).unwrap() != b"old");
}

#[test]
fn everything_that_a_scene_names_is_spared() {
    let vr = scans();
    vr.write(
        "mesh.exr",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    vr.write("map.png", r#"[{"Name": "m", "ColorSpace": "RGB", "RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "Points": [0, 0, 0.5, 0, 1, 1, 0.5, 0]}]"#);
    vr.write(
        "scene.png",
        "[volume]\npath = \"stack.nhdr\"\n[transfer]\nfile = \"map.png\"\n[mesh]\npath = \"mesh.exr\"\n[image]\nsize = [4, 4]\n",
    );
    vr.run("render --scene scene.png --error none -o fine.png").succeeded();
    for place in ["scene.png", "slice1.png", "map.png", "mesh.exr"] {
        spared(&vr, &format!("render --scene scene.png --error none -o {place}"), place);
        spared(&vr, &format!("render --scene scene.png -o new.png --error-map {place}"), place);
    }
    spared(&vr, &format!("render x.png {SMALL} --transfer map.png -o map.png"), "map.png");
    spared(&vr, &format!("render x.png {SMALL} --mesh mesh.exr -o mesh.exr"), "mesh.exr");
}

#[test]
fn other_commands_spare_their_inputs() {
    let vr = scans();
    vr.write("points.csv", "x,y,z\n0,0,0\n1,0,0\n0,1,1\n0,0,1\n");
    spared(&vr, "ray 1 1 points.csv --renderer physics --size 4 --csv points.csv", "points.csv");
    // A report's folder is full of names.
    fs::create_dir(vr.folder().join("r")).unwrap();
    let report = "report --untimed --no-cache --renderer raycast --size 4 -o r";
    for name in ["points.csv", "errors.json", "index.html", "journal-quick.jsonl"] {
        vr.write(&format!("r/{name}"), format!("{HEADER}\nabcdefgh"));
        let before = fs::read(vr.folder().join("r").join(name)).unwrap();
        let error = vr.run(&format!("{report} r/{name}")).failed(2);
        assert!(error.contains(name) && error.contains("would destroy it"), "{error}");
        assert!(fs::read(vr.folder().join("r").join(name)).unwrap() == before, "{name}");
        fs::remove_file(vr.folder().join("r").join(name)).unwrap();
    }
    vr.write("r/errors.json", "{}");
    let error = vr.run(&format!("{report} --phantom fog --phantom-size 4 --baseline r/errors.json")).failed(2);
    assert!(error.contains("errors.json") && error.contains("would destroy it"), "{error}");
    assert_eq!(fs::read(vr.folder().join("r/errors.json")).unwrap(), b"{}");

    vr.run("render --phantom fog --phantom-size 4 --size 4 --error none -o a.png -o b.png").succeeded();
    spared(&vr, "diff a.png b.png -o a.png", "a.png");
    spared(&vr, "diff a.png b.png -o d.png -o ./b.png", "b.png");
}

#[test]
fn a_map_does_not_take_the_place_of_its_picture() {
    let vr = Vr::new();
    let render = "render --phantom fog --phantom-size 4 --size 4";
    let error = vr.run(&format!("{render} -o p.png --error-map ./p.png")).failed(2);
    assert!(error.contains("--error-map") && error.contains("p.png"), "{error}");
    assert!(vr.files().is_empty());
}
