//! Labels beside a volume: files, scene files, and what they say where something does not fit.

use std::path::Path;

use glam::DVec3;
use vr_core::Volume;
use vr_io::{LabelLook, LabelName, load_scene, parse_scene, read_labels, scene_text};

const NAMES: &str = "\
Segment0_ID:=Segment_1
Segment0_Name:=left lung
Segment0_Color:=1 0 0
Segment0_LabelValue:=1
Segment1_ID:=Segment_2
Segment1_Name:=right lung
Segment1_Color:=0 1 0
Segment1_LabelValue:=2
";

/// An NRRD file of bytes in millimetres, LPS.
fn nrrd(dims: [usize; 3], origin: [f64; 3], keys: &str, voxels: &[u8]) -> Vec<u8> {
    let [[nx, ny, nz], [x, y, z]] = [dims.map(|n| n.to_string()), origin.map(|x| x.to_string())];
    let mut file = format!(
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: {nx} {ny} {nz}\nspace directions: (1,0,0) (0,1,0) (0,0,2)\n\
         kinds: domain domain domain\nencoding: raw\nspace origin: ({x},{y},{z})\n{keys}\n"
    )
    .into_bytes();
    file.extend(voxels);
    file
}

/// A folder with a volume of 4³ voxels, and labels on every other slice of x.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, content: &[u8]| std::fs::write(folder.path().join(name), content).unwrap();
    let values: Vec<u8> = (0..64).map(|i| 3 * i).collect();
    write("volume.nrrd", &nrrd([4; 3], [0.0; 3], "", &values));
    let labels: Vec<u8> = (0..64).map(|i| [0, 1, 0, 2][i % 4]).collect();
    write("lungs.seg.nrrd", &nrrd([4; 3], [0.0; 3], NAMES, &labels));
    write("far.nrrd", &nrrd([4; 3], [100.0, 0.0, 0.0], "", &labels));
    write("near.nrrd", &nrrd([4; 3], [3.2, 0.0, 0.0], "", &labels));
    write("names.label", b"1 0 0 255 0.5 1 1 \"vein\"\n2 255 255 255 1 0 0 \"bone\"\n");
    folder
}

fn scene(folder: &Path, labels: &str) -> Result<vr_io::LoadedScene, String> {
    let text = format!("[volume]\npath = \"volume.nrrd\"\n[image]\nsize = [8, 8]\n{labels}");
    std::fs::write(folder.join("scene.toml"), text).unwrap();
    load_scene(folder.join("scene.toml")).map_err(|e| e.to_string().replace(&format!("{}/", folder.display()), ""))
}

#[test]
fn a_segmentation_has_names_and_colours() {
    let folder = folder();
    let loaded = read_labels(folder.path().join("lungs.seg.nrrd"), None).unwrap();
    assert_eq!(loaded.map.labels(), [0, 1, 2]);
    assert_eq!((loaded.map.count(1), loaded.map.voxel_volume()), (16, 2.0));
    let names: Vec<_> = loaded.entries.iter().map(|e| (e.label, e.name.as_deref().unwrap())).collect();
    assert_eq!(names, [(1, "left lung"), (2, "right lung")]);
    // LPS became RAS.
    assert_eq!(loaded.map.label_at(DVec3::new(-1.0, -2.0, 2.0)), 1);
    // A list comes before the file.
    let listed = read_labels(folder.path().join("lungs.seg.nrrd"), Some(&folder.path().join("names.label"))).unwrap();
    assert_eq!(listed.entries[0].name.as_deref(), Some("vein"));
    assert_eq!((listed.entries[0].opacity, listed.entries[1].visible), (Some(0.5), Some(false)));
    assert_eq!(listed.files.len(), 2);
}

#[test]
fn later_layers_cover_earlier_ones() {
    let folder = tempfile::tempdir().unwrap();
    let keys = "Segment0_ID:=a\nSegment0_Name:=all\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment1_ID:=b\nSegment1_Name:=half\n\
                Segment1_LabelValue:=1\nSegment1_Layer:=1\n";
    let voxels: Vec<u8> = (0..8).flat_map(|i| [u8::from(i != 7), u8::from(i % 2 == 1)]).collect();
    let mut file = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nspace: left-posterior-superior\nsizes: 2 2 2 2\nspace directions: none (1,0,0) (0,1,0) (0,0,1)\n\
         kinds: list domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n{keys}\n"
    )
    .into_bytes();
    file.extend(voxels);
    let path = folder.path().join("layers.seg.nrrd");
    std::fs::write(&path, file).unwrap();
    let loaded = read_labels(&path, None).unwrap();
    assert_eq!(loaded.map.labels(), [0, 1, 2]);
    assert_eq!([0, 1, 2].map(|label| loaded.map.count(label)), [0, 4, 4]);
    assert_eq!(loaded.entries[1].name.as_deref(), Some("half"));
    assert_eq!((loaded.entries[1].label, loaded.notes.len() >= 2), (2, true));
}

#[test]
fn a_scene_has_labels_in_the_styles_that_it_names() {
    let folder = folder();
    let labels = "[labels]\nfile = \"lungs.seg.nrrd\"\n[[labels.label]]\nlabel = \"Left Lung\"\nopacity = 0.5\n[[labels.label]]\nlabel = 2\nvisible = false\n";
    let loaded = scene(folder.path(), labels).unwrap();
    let Volume::Field(field) = &loaded.scene.volume else { panic!("a labelled grid is a field") };
    assert_eq!(field.kind(), "labelled grid");
    assert!(loaded.scene.shading.is_some(), "solids are lit");
    let at = |x: f64| field.value(DVec3::new(-x, -1.0, 2.0)).map(|v| loaded.scene.transfer.at(v));
    let left = at(1.0).unwrap();
    assert_eq!((left.color, left.opacity), ([1.0, 0.0, 0.0], 0.5));
    assert_eq!(at(3.0), None, "hidden");
    assert!(
        loaded
            .notes
            .iter()
            .any(|n| n.starts_with("labels: 1 left lung, 2 right lung (hidden); the rest is the volume"))
    );
    assert!(loaded.files.iter().any(|f| f.ends_with("lungs.seg.nrrd")));
    // A mask shows the volume's own values, and nothing else.
    let mask =
        scene(folder.path(), "[labels]\nfile = \"lungs.seg.nrrd\"\nmask = true\n[render]\ncompositing = \"maximum\"\n")
            .unwrap();
    let Volume::Field(field) = &mask.scene.volume else { panic!("a labelled grid is a field") };
    assert_eq!(field.value(DVec3::new(-1.0, -1.0, 2.0)), Some(63.0));
    assert_eq!(field.value(DVec3::new(-2.0, -1.0, 2.0)), None);
}

#[test]
fn what_does_not_fit_is_told() {
    let folder = folder();
    let refused = |labels: &str| scene(folder.path(), labels).unwrap_err();
    let lungs = "[labels]\nfile = \"lungs.seg.nrrd\"\n";
    assert!(
        refused("[labels]\nfile = \"far.nrrd\"\n").starts_with("far.nrrd: the labels lie from [-103.5, -3.5, -1.0]")
    );
    assert!(
        refused(&format!("{lungs}[[labels.label]]\nlabel = 7\n"))
            .contains("labels.label[0].label: found 7, among the labels 0, 1, 2; must")
    );
    assert!(
        refused(&format!("{lungs}[[labels.label]]\nlabel = \"liver\"\n"))
            .contains("'liver', and the files have left lung, right lung")
    );
    assert!(
        refused(&format!("{lungs}[[labels.label]]\nlabel = 1\nopacity = 2\n"))
            .contains("opacity: found 2; from 0 to 1")
    );
    assert!(
        refused(&format!("{lungs}[[labels.label]]\nlabel = 1\ncolour = [1, 0, 0]\n"))
            .contains("unknown key 'colour'; did you mean 'color'?")
    );
    assert!(
        refused(&format!("{lungs}[render]\ncompositing = \"maximum\"\n"))
            .contains("render.compositing: found \"maximum\"")
    );
    let near = scene(folder.path(), "[labels]\nfile = \"near.nrrd\"\n").unwrap();
    assert!(near.notes.iter().any(|n| n.contains("no labelled voxel lies in the volume")), "{:?}", near.notes);
    assert!(refused("[labels]\nfile = \"none.nrrd\"\n").starts_with("none.nrrd: "));
}

#[test]
fn a_section_comes_back_as_it_was() {
    let text = "[labels]\nfile = \"a.seg.nrrd\"\nnames = \"a.ctbl\"\nas = \"tinted\"\n[[labels.label]]\nlabel = 3\ncolor = [1.0, 0.0, 0.0]\nas = \"solid\"\n\
                [[labels.label]]\nlabel = \"liver\"\nvisible = false\n";
    let file = parse_scene(text, Path::new("x.toml")).unwrap();
    let section = file.labels.as_ref().unwrap();
    assert_eq!((section.look, section.mask), (Some(LabelLook::Tinted), false));
    assert_eq!(section.label[0].label, LabelName::Number(3));
    assert_eq!(section.label[1].label, LabelName::Name("liver".into()));
    let again = parse_scene(&scene_text(&file).unwrap(), Path::new("x.toml")).unwrap();
    assert_eq!(again, file);
}
