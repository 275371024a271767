//! The first picture of a volume about which nothing is said: neither black nor white, neither tiny nor cut.

use vr_core::Volume;
use vr_core::phantom;
use vr_io::NrrdOptions;

use crate::harness::Vr;

/// Extent and brightness of a picture.
struct Seen {
    /// Parts of the picture's width and height that are not black.
    filled: [f64; 2],
    /// Mean luma of what is not black, of 255.
    luma: f64,
    /// Part of that which is within 5 % of white.
    white: f64,
    /// Part of that which is within 5 % of black.
    black: f64,
}

fn look_at(vr: &Vr, arguments: &str) -> Seen {
    vr.run(&format!("render {arguments} --size 160x160 --error none -o x.png")).succeeded();
    let picture = vr.picture("x.png").to_luma8();
    let (width, height) = picture.dimensions();
    let visible: Vec<(u32, u32, u8)> =
        picture.enumerate_pixels().filter(|(.., p)| p.0[0] > 4).map(|(x, y, p)| (x, y, p.0[0])).collect();
    assert!(!visible.is_empty(), "{arguments}: black");
    let share = |keep: &dyn Fn(u8) -> bool| visible.iter().filter(|v| keep(v.2)).count() as f64 / visible.len() as f64;
    let extent = |values: Vec<u32>| f64::from(values.iter().max().unwrap() - values.iter().min().unwrap() + 1);
    Seen {
        filled: [
            extent(visible.iter().map(|v| v.0).collect()) / f64::from(width),
            extent(visible.iter().map(|v| v.1).collect()) / f64::from(height),
        ],
        luma: visible.iter().map(|v| f64::from(v.2)).sum::<f64>() / visible.len() as f64,
        white: share(&|luma| luma >= 242),
        black: share(&|luma| luma <= 13),
    }
}

#[track_caller]
fn is_worth_a_look(seen: &Seen, what: &str) {
    let Seen { filled, luma, white, black } = seen;
    let largest = filled[0].max(filled[1]);
    println!("{what}: fills {:.2} x {:.2}, luma {luma:.0}, white {white:.2}, black {black:.2}", filled[0], filled[1]);
    // What is visible is found from voxels, and a voxel is some hundredths of these.
    assert!((0.8..=1.0).contains(&largest), "{what}: fills {largest}");
    assert!((35.0..=215.0).contains(luma), "{what}: luma {luma}");
    assert!(*white < 0.35 && *black < 0.4, "{what}: white {white}, black {black}");
}

#[test]
fn phantoms_read_from_files_are_worth_a_look() {
    let vr = Vr::new();
    for name in phantom::NAMES {
        let made = phantom::by_name(name).unwrap();
        let volume = Volume::from(phantom::sample::<f32>(made.as_ref(), [40; 3]).unwrap());
        let file = format!("{name}.nrrd");
        vr_io::write_nrrd(vr.folder().join(&file), &volume, &NrrdOptions::default()).unwrap();
        is_worth_a_look(&look_at(&vr, &file), name);
    }
}

#[test]
fn a_small_thing_in_a_large_box_fills_the_picture_from_any_side() {
    let vr = Vr::new();
    let side = 48;
    let at = |i: usize| [i % side, i / side % side, i / side / side];
    let ball = |i: usize| {
        let [x, y, z] = at(i).map(|k| k as f64);
        let far = ((x - 12.0).powi(2) + (y - 30.0).powi(2) + (z - 20.0).powi(2)).sqrt();
        (20.0 + 200.0 / (1.0 + (far - 7.0).exp())) as u8
    };
    vr.write("ball_48x48x48_uint8.raw", (0..side * side * side).map(ball).collect::<Vec<u8>>());
    for view in ["", "--azimuth 0 --elevation 0", "--azimuth 130 --elevation -40", "--fov 40", "--azimuth 200 --fov 25"]
    {
        let seen = look_at(&vr, &format!("ball_48x48x48_uint8.raw {view}"));
        is_worth_a_look(&seen, view);
    }
    let boxed = look_at(&vr, "ball_48x48x48_uint8.raw --fit box");
    assert!(boxed.filled[0] < 0.5, "{:?}", boxed.filled);
    // The value itself, not its opacity.
    let brightest = look_at(&vr, "ball_48x48x48_uint8.raw --compositing maximum");
    assert!(brightest.white > 0.02, "{}", brightest.white);
}

#[test]
fn the_look_gives_way_to_what_is_asked_for() {
    let vr = Vr::new();
    let voxels: Vec<u8> = (0..16 * 16 * 16).map(|i| if (i % 16) > 7 { 200 } else { 10 } + (i % 3) as u8).collect();
    vr.write("a_16x16x16_uint8.raw", voxels);
    let notes =
        |flags: &str| vr.run(&format!("render a_16x16x16_uint8.raw --size 16 --error none {flags}")).succeeded().stderr;
    assert!(notes("").contains("note: look: "));
    for flags in ["--look flat", "--transfer grey", "--range 0,100", "--point 0,1,1,1,0 --point 255,1,1,1,0.5"] {
        assert!(!notes(flags).contains("look: "), "{flags}");
    }
    let pixels = |flags: &str| {
        vr.run(&format!("render a_16x16x16_uint8.raw --size 16 --error none -o y.png {flags}")).succeeded();
        vr.picture("y.png").to_rgb8().into_raw()
    };
    assert_ne!(pixels(""), pixels("--no-shading"));
}
