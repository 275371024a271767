//! Two-dimensional transfer functions: by boxes, by files, drawn, printed, recorded and refused.

use crate::harness::Vr;

const SMALL: &str = "--size 24 --azimuth 20 --elevation 10";

/// A box that holds the boundary of the tangled cubes of a phantom.
const BOX: &str = "--transfer-box 0.2,0.8,0.5,40,1,0.5,0.1,0.8";

#[test]
fn a_box_becomes_rows_that_are_drawn_and_written() {
    let vr = Vr::new();
    vr.run(&format!("render --phantom hydrogen --phantom-size 24 {BOX} {SMALL} -o a.png")).succeeded();
    let picture = vr.picture("a.png").to_rgb8();
    assert!(picture.pixels().any(|p| p.0[0] > 60 && p.0[0] > p.0[2]), "something orange shows");
    // The scene file says the same in rows, and draws the same bits.
    vr.run(&format!("scene --phantom hydrogen --phantom-size 24 {BOX} {SMALL} -o s.toml")).succeeded();
    vr.run("render --scene s.toml -o b.png").succeeded();
    assert_eq!(picture, vr.picture("b.png").to_rgb8());
    // And so does the record in the picture.
    vr.run("rerun a.png -o c.png").succeeded();
    assert_eq!(picture, vr.picture("c.png").to_rgb8());
}

#[test]
fn a_file_of_rows_is_printed_drawn_and_copied() {
    let vr = Vr::new();
    vr.write(
        "rows.toml",
        "[transfer]\n[[transfer.rows]]\ngradient = 0.5\npoints = [{ value = 0.0, color = [0.0, 0.0, 0.0], opacity = 0.0 }]\n\
         [[transfer.rows]]\ngradient = 4.0\npoints = [{ value = 0.0, color = [1.0, 0.5, 0.1], opacity = 0.5 }]\n",
    );
    let printed = vr.run("tf rows.toml --phantom hydrogen --phantom-size 16 -o p.png -o copy.toml");
    assert!(
        printed.stdout.contains("gradient 4 per world unit") && printed.stdout.contains("gradient 0.5 per"),
        "{}",
        printed.stdout
    );
    let size = vr.picture("p.png").to_rgb8().dimensions();
    assert_eq!(size, (800, 520));
    let copy = vr.run("tf copy.toml --json");
    assert!(copy.stdout.contains("\"gradient\""), "{}", copy.stdout);
    let refused = vr.run("tf rows.toml -o x.json");
    assert!(refused.code != 0 && refused.stderr.contains("held by .toml alone"), "{}", refused.stderr);
    let arguments = "render --phantom hydrogen --phantom-size 16 --transfer rows.toml --renderer texslice";
    vr.run(&format!("{arguments} {SMALL} -o r.png")).succeeded();
    let picture = vr.picture("r.png").to_rgb8();
    assert!(picture.pixels().any(|p| p.0[0] > p.0[2]), "the steep row is orange");
}

#[test]
fn boxes_that_are_none_are_refused() {
    let vr = Vr::new();
    let run = vr.run("render --phantom fog --transfer-box 1,2,3 -o a.png");
    assert!(run.code == 2 && run.stderr.contains("eight numbers"), "{}", run.stderr);
    let run = vr.run("render --phantom fog --transfer-box 0,1,0,1,1,1,1,0.5 --preset grey -o a.png");
    assert!(run.code == 2 && run.stderr.contains("cannot be used with"), "{}", run.stderr);
    let run = vr.run("render --phantom fog --transfer-box 0,1,0,1,1,1,1,0.5 --compositing maximum -o a.png");
    assert!(run.code != 0 && run.stderr.contains("over and accumulate"), "{}", run.stderr);
}
