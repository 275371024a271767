//! Labels beside a volume, from the command line.

use crate::harness::Vr;

/// A volume of 12³ voxels that is clear, and a segmentation with a block of each of two labels in it.
fn folder() -> Vr {
    let vr = Vr::new();
    let nrrd = |keys: &str, voxel: &dyn Fn([usize; 3]) -> u8| {
        let mut file = format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 12 12\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n\
             space units: \"mm\" \"mm\" \"mm\"\nkinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n{keys}\n"
        )
        .into_bytes();
        file.extend((0..1728).map(|i| voxel([i % 12, i / 12 % 12, i / 144])));
        file
    };
    let keys = "Segment0_ID:=a\nSegment0_Name:=cyst\nSegment0_Color:=1 0 0\nSegment0_LabelValue:=3\nSegment1_ID:=b\nSegment1_Name:=stone\n\
                Segment1_Color:=0 0 1\nSegment1_LabelValue:=5\n";
    let inside = |p: [usize; 3]| p[1..].iter().all(|i| (2..10).contains(i));
    let label = move |p: [usize; 3]| match p[0] {
        1..5 if inside(p) => 3,
        7..11 if inside(p) => 5,
        _ => 0,
    };
    vr.write("volume.nrrd", nrrd("", &|p| if p == [0; 3] { 100 } else { 0 }));
    vr.write("kidney.seg.nrrd", nrrd(keys, &label));
    vr.write("names.ctbl", "0 background 0 0 0 0\n3 renal_cyst 0 255 0 255\n5 stone 0 0 255 255\n");
    vr
}

const CLEAR: &str = "--point 0,1,1,1,0 --point 100,1,1,1,0 --size 64x64 --azimuth 0 --elevation 0 --fit box";

/// Mean colour of the left half, and of the right half of a picture.
fn halves(vr: &Vr, arguments: &str) -> [[f64; 3]; 2] {
    vr.run(&format!("render volume.nrrd {CLEAR} {arguments} -o x.png")).succeeded();
    let picture = vr.picture("x.png").to_rgb8();
    [0..32, 32..64].map(|columns| {
        let mut sum = [0.0; 3];
        for (_, _, pixel) in picture.enumerate_pixels().filter(|(x, ..)| columns.contains(x)) {
            (0..3).for_each(|c| sum[c] += f64::from(pixel.0[c]) / 2048.0);
        }
        sum
    })
}

/// True if a colour is that of one channel alone, but for white highlights.
fn is_mostly(channel: usize, [r, g, b]: [f64; 3], min: f64) -> bool {
    let color = [r, g, b];
    color[channel] > min && (0..3).filter(|&c| c != channel).all(|c| color[c] < 0.4 * color[channel])
}

#[test]
fn labels_are_solids_in_their_own_colours() {
    let vr = folder();
    // The face is seen: what lies to the left in LPS, at large x, is on the right of the picture.
    let [left, right] = halves(&vr, "--labels kidney.seg.nrrd");
    assert!(is_mostly(0, left, 40.0), "red: {left:?}");
    assert!(is_mostly(2, right, 40.0), "blue: {right:?}");
    let [left, right] =
        halves(&vr, "--labels kidney.seg.nrrd --label stone:visible=no --label 3:colour=0,1,0:opacity=0.02");
    assert!(is_mostly(1, left, 3.0) && right == [0.0; 3], "{left:?} {right:?}");
    let [left, _] = halves(&vr, "--labels kidney.seg.nrrd --label-names names.ctbl");
    assert!(is_mostly(1, left, 40.0), "green, as the list says: {left:?}");
    // The mask of a clear volume is clear.
    assert_eq!(halves(&vr, "--mask kidney.seg.nrrd"), [[0.0; 3]; 2]);
}

#[test]
fn the_picture_is_the_correct_one() {
    let vr = folder();
    let run = vr.run(&format!("--json render volume.nrrd {CLEAR} --azimuth 25 --labels kidney.seg.nrrd --label 5:opacity=0.3 --error full -o x.png"));
    let rmse = run.succeeded().json()["error"]["rmse"].as_f64().unwrap();
    assert!(rmse < 1e-3, "{rmse}");
}

#[test]
fn info_lists_labels() {
    let vr = folder();
    let run = vr.run("info kidney.seg.nrrd").succeeded();
    assert!(run.stdout.contains("cyst") && run.stdout.contains("256"), "{}", run.stdout);
    let json = vr.run("--json info kidney.seg.nrrd --label-names names.ctbl").succeeded().json();
    let rows = json["labels"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3);
    assert_eq!(
        (rows[1]["name"].as_str(), rows[1]["voxels"].as_u64(), rows[1]["volume"].as_f64()),
        (Some("renal_cyst"), Some(256), Some(256.0))
    );
}

#[test]
fn what_makes_no_sense_is_refused() {
    let vr = folder();
    let refused =
        |arguments: &str, code| vr.run(&format!("render volume.nrrd {arguments} --size 8x8 -o x.png")).failed(code);
    assert!(refused("--label 3:opacity=0.5", 2).contains("--labels FILE or --mask FILE"));
    assert!(refused("--labels kidney.seg.nrrd --label 4:opacity=0.5", 2).contains("among the labels 0, 3, 5"));
    assert!(refused("--labels kidney.seg.nrrd --label liver:opacity=0.5", 2).contains("cyst, stone"));
    assert!(refused("--labels kidney.seg.nrrd --label 3:opacity=2", 2).contains("from 0 to 1"));
    assert!(refused("--labels kidney.seg.nrrd --label 3:size=2", 2).contains("must be color, opacity, visible or as"));
    assert!(refused("--labels kidney.seg.nrrd --compositing maximum", 2).contains("no values to compare"));
    assert!(refused("--labels kidney.seg.nrrd --renderer splat", 1).contains("labelled grid"));
    assert!(refused("--labels volume.nrrd --mask kidney.seg.nrrd", 2).contains("cannot be used with"));
    assert!(
        vr.run("render volume.nrrd --labels kidney.seg.nrrd -o kidney.seg.nrrd").failed(2).contains("kidney.seg.nrrd")
    );
}
