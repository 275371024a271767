//! Volumes of colours, from the file to the picture.

use crate::harness::Vr;

/// A ball, red on one side and blue on the other, in a black box.
fn ball() -> Vec<u8> {
    const SIDE: usize = 24;
    let mut file = format!(
        "NRRD0005\ntype: uint8\ndimension: 4\nsizes: 3 {SIDE} {SIDE} {SIDE}\nkinds: RGB-color domain domain domain\n\
         spacings: nan 1 1 1\nencoding: raw\n\n"
    )
    .into_bytes();
    for i in 0..SIDE * SIDE * SIDE {
        let at = |k: usize| k as f64 - 11.5;
        let (x, y, z) = (at(i % SIDE), at(i / SIDE % SIDE), at(i / SIDE / SIDE));
        let inside = (x * x + y * y + z * z).sqrt() < 8.0;
        file.extend(match inside {
            false => [0, 0, 0],
            true if x < 0.0 => [230, 20, 20],
            true => [20, 20, 230],
        });
    }
    file
}

#[test]
fn colours_are_drawn_as_they_are() {
    let vr = Vr::new();
    vr.write("ball.nrrd", ball());
    let run = vr.run("render ball.nrrd --size 96x96 --error none --azimuth 0 --elevation 0 -o x.png").succeeded();
    assert!(run.stderr.contains("voxels are RGB and are drawn in their colours"), "{}", run.stderr);
    assert!(run.stderr.contains("look: colours as they are"), "{}", run.stderr);
    let picture = vr.picture("x.png").to_rgb8();
    let (mut red, mut blue, mut other) = (0, 0, 0);
    for p in picture.pixels().map(|p| p.0.map(u16::from)).filter(|p| p.iter().any(|&c| c > 60)) {
        match p {
            [r, _, b] if r > 2 * b.max(1) => red += 1,
            [r, _, b] if b > 2 * r.max(1) => blue += 1,
            _ => other += 1,
        }
    }
    let all = red + blue + other;
    assert!(all > 2000 && red * 3 > all && blue * 3 > all && other * 5 < all, "{red} red, {blue} blue, {other} other");
}

#[test]
fn they_are_described_and_one_component_is_a_volume() {
    let vr = Vr::new();
    vr.write("ball.nrrd", ball());
    let info = vr.run("info ball.nrrd").succeeded().stdout;
    assert!(info.contains("3 components; the value is the largest component"), "{info}");
    let message = vr.run("convert ball.nrrd x.mha").failed(1);
    assert!(message.contains("--component 0"), "{message}");
    vr.run("convert ball.nrrd x.mha --component 2").succeeded();
    assert!(vr.run("info x.mha").succeeded().stdout.contains("0 to 230"));
    for renderer in ["shearwarp", "texslice", "splat"] {
        vr.run(&format!("render ball.nrrd --renderer {renderer} --size 16x16 --error none -o {renderer}.png"))
            .succeeded();
    }
    let message = vr.run("render ball.nrrd --renderer march -o x.png").stderr;
    assert!(message.contains("coloured grid"), "{message}");
    let promised = vr.run("render ball.nrrd --max-error 1e-3 --size 16x16 -o x.png").succeeded().stdout;
    assert!(promised.contains("error bound proven: every pixel within 1.00e-3"), "{promised}");
}
