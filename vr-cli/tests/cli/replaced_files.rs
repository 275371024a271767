//! Files that are there already: pictures of vr's are replaced, and nothing else is without `--force`.

use std::process::Output;

use crate::harness::Vr;

const SMALL: &str = "--size 4 --error none";

#[test]
fn pictures_of_its_own_are_replaced() {
    let vr = Vr::new();
    for command in [
        format!("render {SMALL} -o a.png -o a.exr"),
        format!("render {SMALL} --no-record -o b.png -o b.exr"),
        "render --size 4 --error full -o c.png --error-map d.png".to_owned(),
        "tf viridis -o e.png".to_owned(),
        "info --phantom fog -o f.png".to_owned(),
        "diff a.png b.png -o g.png -o g.exr".to_owned(),
        "turntable --size 4 --frames 2 -o h.gif -o h.webp -o h.apng".to_owned(),
        "rerun a.png -o i.png".to_owned(),
    ] {
        vr.run(&command).succeeded();
        vr.run(&command).succeeded();
    }
}

#[test]
fn everything_else_is_spared() {
    let vr = Vr::new();
    image::RgbImage::new(2, 2).save(vr.folder().join("a.png")).unwrap();
    vr.run(&format!("render {SMALL} -o b.png")).succeeded();
    for name in ["a.exr", "a.gif", "a.csv", "a.toml", "a.json", "a.nrrd", "a.mhd", "a.raw"] {
        vr.write(name, "another work");
    }
    for (command, place) in [
        (format!("render {SMALL} -o a.png"), "a.png"),
        (format!("render {SMALL} -o new.png -o a.exr"), "a.exr"),
        ("render --size 4 --error-map a.png".to_owned(), "a.png"),
        ("compare --size 4 -o a.png".to_owned(), "a.png"),
        ("presets --size 4 --phantom fog -o a.png".to_owned(), "a.png"),
        ("turntable --size 4 --frames 2 -o a.gif".to_owned(), "a.gif"),
        ("ray 2 2 --size 4 --csv a.csv".to_owned(), "a.csv"),
        ("scene -o a.toml".to_owned(), "a.toml"),
        ("tf viridis -o a.json".to_owned(), "a.json"),
        ("tf viridis -o a.png".to_owned(), "a.png"),
        ("info --phantom fog -o a.png".to_owned(), "a.png"),
        ("convert --phantom fog --phantom-size 4 -o a.nrrd".to_owned(), "a.nrrd"),
        // The data beside a header.
        ("convert --phantom fog --phantom-size 4 -o a.mhd".to_owned(), "a.mhd"),
        ("rerun b.png -o a.png".to_owned(), "a.png"),
        ("diff b.png b.png -o a.png".to_owned(), "a.png"),
    ] {
        let before: Vec<Vec<u8>> =
            vr.files().iter().map(|name| std::fs::read(vr.folder().join(name)).unwrap()).collect();
        let error = vr.run(&command).failed(1);
        assert!(error.contains(place) && error.contains("--force"), "{command}: {error}");
        let after: Vec<Vec<u8>> =
            vr.files().iter().map(|name| std::fs::read(vr.folder().join(name)).unwrap()).collect();
        assert!(before == after, "{command}: a file has changed");
    }
    vr.run("convert --phantom fog --phantom-size 4 -o a.nrrd --force").succeeded();
    vr.run("scene -o a.toml --force").succeeded();
    vr.run(&format!("render {SMALL} -o a.png --force")).succeeded();
}

#[test]
fn force_destroys_no_input() {
    let vr = Vr::new();
    vr.run("convert --phantom fog --phantom-size 4 -o a.nrrd").succeeded();
    let error = vr.run("convert a.nrrd a.nrrd --force").failed(2);
    assert!(error.contains("would destroy it"), "{error}");
}

/// Two runs that write the same files beside each other: each file is whole, and of one of them.
#[test]
fn two_runs_side_by_side_leave_whole_files() {
    let vr = Vr::new();
    let command = "report --phantom fog --phantom-size 8 --size 16 --renderer shearwarp --untimed --cache kept -o r";
    let arguments: Vec<&str> = command.split_whitespace().collect();
    let runs: Vec<_> = (0..2)
        .map(|_| {
            vr.command(&arguments)
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::piped())
                .spawn()
                .unwrap()
        })
        .collect();
    // A run is refused as long as another one writes there.
    let ended: Vec<Output> = runs.into_iter().map(|run| run.wait_with_output().unwrap()).collect();
    assert!(ended.iter().any(|run| run.status.success()));
    for run in ended.iter().filter(|run| !run.status.success()) {
        let stderr = String::from_utf8_lossy(&run.stderr);
        assert!(stderr.contains("another run writes there"), "{stderr}");
    }
    let read = |name: &str| std::fs::read_to_string(vr.folder().join("r").join(name)).unwrap();
    serde_json::from_str::<serde_json::Value>(&read("errors.json")).unwrap();
    assert!(read("index.html").trim_end().ends_with("</html>"));
    vr.run(command).succeeded();
    let left = std::fs::read_dir(vr.folder().join("r")).unwrap();
    assert!(left.flatten().all(|file| !file.file_name().to_string_lossy().ends_with(".part")));
}
