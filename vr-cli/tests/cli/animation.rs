//! `vr turntable` and `vr animate`.

use std::fs;

use image::AnimationDecoder;

use crate::harness::Vr;

/// A small scene that is drawn quickly.
const SMALL: &str = "--phantom blobs --phantom-size 12 --size 24x20";

fn frames_of_png(vr: &Vr, name: &str) -> Vec<image::Frame> {
    let bytes = fs::read(vr.folder().join(name)).unwrap();
    let decoder = image::codecs::png::PngDecoder::new(std::io::Cursor::new(bytes)).unwrap();
    decoder.apng().unwrap().into_frames().collect_frames().unwrap()
}

/// Counts of blocks of a GIF: width, height, frames, hundredths of a second, and true if it begins again.
fn gif(vr: &Vr, name: &str) -> (u16, u16, usize, u32, bool) {
    let bytes = fs::read(vr.folder().join(name)).unwrap();
    let number = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    assert_eq!(&bytes[..6], b"GIF89a");
    let (width, height) = (number(6), number(8));
    let mut at = 13 + if bytes[10] & 0x80 != 0 { 3 << ((bytes[10] & 7) + 1) } else { 0 };
    let (mut frames, mut time, mut repeats) = (0, 0, false);
    let skip_blocks = |mut at: usize| {
        while bytes[at] != 0 {
            at += 1 + usize::from(bytes[at]);
        }
        at + 1
    };
    loop {
        match bytes[at] {
            0x21 => {
                match bytes[at + 1] {
                    0xf9 => time += u32::from(number(at + 4)),
                    0xff => repeats |= &bytes[at + 3..at + 14] == b"NETSCAPE2.0",
                    _ => {}
                }
                at = skip_blocks(at + 2);
            }
            0x2c => {
                frames += 1;
                assert_eq!(bytes[at + 9] & 0x80, 0, "the palette is the animation's");
                at = skip_blocks(at + 11);
            }
            0x3b => return (width, height, frames, time, repeats),
            other => panic!("block {other:#x}"),
        }
    }
}

#[test]
fn a_turn_becomes_a_gif_and_leaves_nothing_else() {
    let vr = Vr::new();
    let run = vr.run(&format!("turntable {SMALL} --frames 8 -o turn.gif")).succeeded();
    assert!(run.stdout.contains("frames   8") && run.stdout.contains("wrote    turn.gif"), "{}", run.stdout);
    assert!(!run.stdout.contains("ffmpeg"), "frames are not kept: {}", run.stdout);
    assert_eq!(vr.files(), ["turn.gif"]);
    assert_eq!(gif(&vr, "turn.gif"), (24, 20, 8, 33, true));
    vr.run(&format!("turntable {SMALL} --frames 3 --fps 10 --once -o once.gif")).succeeded();
    assert_eq!(gif(&vr, "once.gif"), (24, 20, 3, 30, false));
}

#[test]
fn an_interrupted_animation_goes_on_with_the_same_bytes() {
    let vr = Vr::new();
    let command = format!("turntable {SMALL} --frames 6 -o frames/ -o turn.webp --json");
    let first = vr.run(&command).succeeded().json();
    assert_eq!((first["drawn"].as_u64(), first["kept"].as_u64()), (Some(6), Some(0)));
    assert!(first["ffmpeg"].as_str().unwrap().contains("-i 'frames/frame-%04d.png'"), "{first}");
    let file = |i: usize| vr.folder().join(format!("frames/frame-{i:04}.png"));
    let bytes: Vec<Vec<u8>> = (0..6).map(|i| fs::read(file(i)).unwrap()).collect();
    let webp = fs::read(vr.folder().join("turn.webp")).unwrap();

    // Two frames are gone, one is cut short, as if by a machine that went down.
    for i in [1, 4] {
        fs::remove_file(file(i)).unwrap();
    }
    fs::write(file(2), &bytes[2][..bytes[2].len() / 2]).unwrap();
    fs::remove_file(vr.folder().join("turn.webp")).unwrap();
    let again = vr.run(&command).succeeded().json();
    assert_eq!((again["drawn"].as_u64(), again["kept"].as_u64()), (Some(3), Some(3)));
    assert!((0..6).all(|i| fs::read(file(i)).unwrap() == bytes[i]));
    assert_eq!(fs::read(vr.folder().join("turn.webp")).unwrap(), webp);

    // Another picture is drawn anew, and so is the same by force.
    let force = vr.run(&format!("{command} --force")).succeeded().json();
    assert_eq!(force["drawn"].as_u64(), Some(6));
    assert!((0..6).all(|i| fs::read(file(i)).unwrap() == bytes[i]));
    let other = vr.run(&format!("{command} --background 0.1,0,0")).succeeded().json();
    assert_eq!(other["drawn"].as_u64(), Some(6));
    // Fewer frames leave none of the others behind.
    vr.run(&command.replace("--frames 6", "--frames 4")).succeeded();
    assert!(file(3).exists() && !file(4).exists() && !file(5).exists());
}

#[test]
fn a_whole_turn_closes_and_does_not_pump() {
    let vr = Vr::new();
    // Frame 4 of 8 of two turns is frame 0 again.
    vr.run(&format!("turntable {SMALL} --turn 720 --frames 8 -o two-%d.png")).succeeded();
    let frame = |name: &str| vr.picture(name).to_rgb8().into_raw();
    let difference = |a: &[u8], b: &[u8]| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(difference(&frame("two-0.png"), &frame("two-4.png")) <= 1, "a step of 8 bits is rounding's");
    // A part of a turn ends at its end: a quarter, in three frames, as a quarter of eight in one turn.
    vr.run(&format!("turntable {SMALL} --turn 90 --frames 3 --fit box -o part-%d.png")).succeeded();
    vr.run(&format!("turntable {SMALL} --frames 8 --fit box -o whole-%d.png")).succeeded();
    for (part, whole) in [(0, 0), (1, 1), (2, 2)] {
        let (part, whole) = (frame(&format!("part-{part}.png")), frame(&format!("whole-{whole}.png")));
        assert!(difference(&part, &whole) <= 1);
    }
    // The first frame of a placed camera is its still picture.
    let placed = "--eye 9,3,2 --target 0,0,0 --height 3 --up 0,1,0";
    vr.run(&format!("turntable {SMALL} {placed} --frames 2 -o eye-%d.png")).succeeded();
    vr.run(&format!("render {SMALL} {placed} --error none -o still.png")).succeeded();
    assert_eq!(frame("eye-0.png"), frame("still.png"));
    vr.run(&format!("turntable {SMALL} --axis 1,0,0 --frames 2 -o turn.png")).succeeded();
    let turned = frames_of_png(&vr, "turn.png");
    assert!(turned.len() == 2 && turned[0].buffer() != turned[1].buffer());
}

#[test]
fn key_frames_hit_their_keys() {
    let vr = Vr::new();
    vr.write(
        "keys.toml",
        "[[keys]]\ntime = 0\neye = [0, 0, 6]\ntarget = [0, 0, 0]\nheight = 3\n\
         [[keys]]\ntime = 0.5\neye = [6, 1, 0]\ntarget = [0, 0, 0]\n\
         [[keys]]\ntime = 1\neye = [0, 6, 1]\ntarget = [0, 0.5, 0]\nup = [0, 0, 1]\nheight = 2\n",
    );
    let run = vr.run(&format!("animate keys.toml {SMALL} --fps 4 -o f-%d.png --error=4 --json")).succeeded().json();
    assert_eq!((run["frames"].as_u64(), run["errors"].as_array().unwrap().len()), (Some(5), 2), "0, 1/4, ... 1");
    assert!(run["errors"][1]["rmse"].as_f64().unwrap() < 1e-2);
    let frame = |name: &str| vr.picture(name).to_rgb8().into_raw();
    for (i, camera) in [
        (0, "--eye 0,0,6 --target 0,0,0 --up 0,1,0 --height 3"),
        (2, "--eye 6,1,0 --target 0,0,0 --up 0,1,0 --height 3"),
        (4, "--eye 0,6,1 --target 0,0.5,0 --up 0,0,1 --height 2"),
    ] {
        vr.run(&format!("render {SMALL} {camera} --error none -o still.png")).succeeded();
        assert_eq!(frame(&format!("f-{i}.png")), frame("still.png"), "{i}");
    }
    // Angles, a clip that moves in, and control points that change.
    vr.write(
        "more.toml",
        "interpolation = 'linear'\n\
         [[keys]]\nazimuth = 0\nclip = { planes = [{ normal = [1, 0, 0], offset = -9 }] }\n\
         points = [{ value = 0, color = [1, 1, 1], opacity = 0 }, { value = 1, color = [1, 0, 0], opacity = 0.9 }]\n\
         [[keys]]\ntime = 1\nazimuth = 180\nzoom = 2\nclip = { planes = [{ normal = [1, 0, 0], offset = 9 }] }\n\
         points = [{ value = 0, color = [1, 1, 1], opacity = 0 }, { value = 1, color = [0, 0, 1], opacity = 0.9 }]\n",
    );
    vr.run(&format!("animate more.toml {SMALL} --frames 3 -o m-%d.png")).succeeded();
    let sums = |i: usize| {
        let picture = vr.picture(&format!("m-{i}.png")).to_rgb8();
        picture.pixels().fold([0u32; 3], |sum, p| std::array::from_fn(|c| sum[c] + u32::from(p[c])))
    };
    assert!(sums(0)[0] > 0 && sums(0)[2] < sums(0)[0] && sums(1)[2] > 0, "{:?} {:?}", sums(0), sums(1));
    assert_eq!(sums(2), [0; 3], "clipped away");
}

#[test]
fn time_series_are_drawn_with_one_transfer_function() {
    let vr = Vr::new();
    for (number, phantom) in [(1, "blobs"), (2, "shells"), (10, "blobs")] {
        vr.run(&format!("convert --phantom {phantom} --phantom-size 12 -o v{number}.nrrd")).succeeded();
    }
    let flags = "--size 24x20 --time-series --turn 0 --azimuth 30";
    let run = vr.run(&format!("turntable v%d.nrrd -o s-%d.png {flags}"));
    let run = run.succeeded();
    assert!(run.stderr.contains("time series of 3 volumes: transfer function from number 0"), "{}", run.stderr);
    let frame = |i: usize| vr.picture(&format!("s-{i}.png")).to_rgb8().into_raw();
    assert!(frame(0) == frame(2) && frame(0) != frame(1));
    // Four frames of a 4-D file, two pictures each.
    let header =
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 4 4 4 3\nkinds: domain domain domain time\nencoding: raw\n\n";
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend((0..192u8).map(|i| i.wrapping_mul(37) / (1 + i / 64)));
    vr.write("t.nrrd", bytes);
    let run =
        vr.run("turntable t.nrrd --time-series --hold 2 --look-from all --size 16 -o t.webp --json").succeeded().json();
    assert_eq!(run["frames"].as_u64(), Some(6));
    for (command, words) in [
        ("turntable v1.nrrd --time-series", "holds one volume"),
        ("turntable --phantom fog --time-series", "no file"),
        ("turntable t.nrrd --frame 1 --time-series", "--frame"),
        ("turntable t.nrrd --hold 2", "--time-series"),
    ] {
        assert!(vr.run(command).failed(2).contains(words), "{command}");
    }
}

#[test]
fn what_cannot_be_written_is_refused_before_anything_is_drawn() {
    let vr = Vr::new();
    for (flags, words) in [
        ("-o turn.mp4", "ffmpeg"),
        ("-o turn.gif --alpha", "a pixel of a GIF is there or not"),
        ("-o turn.webp --bits 16", "8 bits"),
        ("-o turn.gif --fps 60", "at most 50"),
        ("-o turn.webp --fps 0", "0.02 to 240"),
        ("-o a-%d.png -o b/", "one place alone"),
        ("-o a-%s.png", "%d"),
        ("-o a.gif -o ./a.gif", "another file"),
        ("--axis 0,0,0", "direction"),
        ("--frames 0", "1..=100000"),
    ] {
        let error = vr.run(&format!("turntable {SMALL} {flags}")).failed(2);
        assert!(error.contains(words), "{flags}: {error}");
    }
    assert!(vr.run(&format!("turntable {SMALL} -o no/such/turn.gif")).failed(1).contains("folder"));
    vr.write("f-1.png", "mine");
    assert!(
        vr.run(&format!("turntable {SMALL} --frames 2 -o f-%d.png")).failed(1).contains("no frame of an earlier run")
    );
    vr.write("keys.toml", "[[keys]]\ntime = 0\nzomm = 2\n");
    assert!(vr.run(&format!("animate keys.toml {SMALL}")).failed(1).contains("did you mean 'zoom'"));
    assert_eq!(fs::read(vr.folder().join("f-1.png")).unwrap(), b"mine");
}

#[test]
fn a_transparent_background_is_that_of_every_frame() {
    let vr = Vr::new();
    let flags = "--phantom fog --phantom-size 8 --size 16x16 --frames 2 --background transparent";
    vr.run(&format!("turntable {flags} -o f-%d.png")).succeeded();
    assert_eq!(vr.picture("f-0.png").to_rgba8().get_pixel(0, 0).0[3], 0);
    assert!(vr.run(&format!("turntable {flags} -o f.gif")).failed(2).contains("GIF"));
}

#[test]
fn labels_stay_with_the_volume_and_the_colours_that_they_are_made_for() {
    let vr = Vr::new();
    vr.write("v.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n");
    vr.write("l.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n0 0 0 0 1 1 1 1\n");
    let flags = "v.nrrd --labels l.nrrd --size 8x8 --frames 2 -o f-%d.png";
    let error = vr.run(&format!("turntable {flags} --time-series")).failed(2);
    assert!(error.contains("labels are of one volume"), "{error}");
    let points = "points = [{ value = 0, color = [1, 1, 1], opacity = 0.1 }]";
    vr.write(
        "keys.toml",
        format!("[[keys]]\ntime = 0\nazimuth = 0\n{points}\n[[keys]]\ntime = 1\nazimuth = 9\n{points}\n"),
    );
    let error = vr.run(&format!("animate keys.toml {flags}")).failed(1);
    assert!(error.contains("cannot go with labels"), "{error}");
    vr.run(&format!("turntable {flags}")).succeeded();
}
