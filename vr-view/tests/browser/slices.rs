//! Slices beside the picture.

use super::*;

#[test]
fn slices_go_with_a_crosshair() {
    let Some((running, mut browser)) = opened("blobs") else { return };
    let there = "window.vr.slices.views.every((v) => v.slice && v.slice.at === window.vr.slices.crosshair[v.axis]) && window.vr.slices.place !== null";
    let crosshair = |browser: &mut Browser| {
        let at = browser.value("window.vr.slices.crosshair");
        [0, 1, 2].map(|k| at[k].as_f64().unwrap())
    };
    // A key opens them; the picture becomes narrower, and is still that of the saved scene.
    browser.call(
        "Emulation.setDeviceMetricsOverride",
        json!({"width": 1100, "height": 640, "deviceScaleFactor": 1, "mobile": false}),
    );
    rest(&mut browser);
    let before = picture(&mut browser);
    browser.value("document.getElementById('picture').focus()");
    browser.key("s", 0);
    browser.wait(there);
    settled(&mut browser, before);
    assert_truth(&mut browser);
    let overlap = "(() => { const [a, b] = ['picture', 'slices'].map((id) => document.getElementById(id).getBoundingClientRect()); return a.right > b.left; })()";
    assert_eq!(browser.value(overlap), false);
    assert_eq!(crosshair(&mut browser), [0.0; 3]);
    // A click in the slice across z moves the crosshair within it, and asks for the two others alone.
    let before = picture(&mut browser);
    let kept = "window.vr.slices.views.map((v) => v.slice)";
    browser.value(&format!("window.vr.kept = {kept}; 0"));
    let at = browser.value("(() => { const b = document.getElementById('slice-2-canvas').getBoundingClientRect(); return [b.left + 0.75 * b.width, b.top + 0.25 * b.height]; })()");
    let at = [at[0].as_f64().unwrap(), at[1].as_f64().unwrap()];
    browser.mouse("mousePressed", at, json!({"clickCount": 1}));
    browser.mouse("mouseReleased", at, json!({"clickCount": 1, "buttons": 0}));
    browser.wait(there);
    let bounds = browser.value("window.vr.slices.opened.bounds");
    let end = |e: usize, k: usize| bounds[e][k].as_f64().unwrap();
    let moved = crosshair(&mut browser);
    for (k, share) in [(0, 0.75), (1, 0.75), (2, 0.5)] {
        let want = end(0, k) + share * (end(1, k) - end(0, k));
        assert!((moved[k] - want).abs() < 0.02 * (end(1, k) - end(0, k)), "{k}: {moved:?} {want}");
    }
    assert_eq!(browser.value(&format!("{kept}.map((s, i) => s === window.vr.kept[i])")), json!([true, false, false]));
    // The program tells the value there, and the picture shows the place: three lines, and a mark where they meet.
    let told = "window.vr.slices.place.at.every((c, k) => c === window.vr.slices.crosshair[k])";
    browser.wait(told);
    let words = browser.value("document.getElementById('slices-text').textContent").as_str().unwrap().to_owned();
    assert!(words.starts_with("value ") && words.contains(" at "), "{words}");
    assert_eq!(number(&mut browser, "document.querySelectorAll('#overlay .crosshair line').length"), 3.0);
    assert_eq!(picture(&mut browser), before, "no picture is drawn anew for that");
    // The mark lies where the program's own camera sees the place.
    let text = browser.value("fetch('save/scene.toml').then((answer) => answer.text())");
    let camera = vr_io::parse_scene(text.as_str().unwrap(), std::path::Path::new("saved")).unwrap().camera.unwrap();
    let camera = camera.camera(|_| unreachable!("all of it is stated")).unwrap();
    let local = camera.frame().unwrap().transpose() * (glam::DVec3::from_array(moved) - camera.eye);
    let size = browser
        .value("[document.getElementById('picture').clientWidth, document.getElementById('picture').clientHeight]");
    let [width, height] = [0, 1].map(|i| size[i].as_f64().unwrap());
    let want = [
        width / 2.0 + local.x / camera.projection.height() * height,
        height / 2.0 - local.y / camera.projection.height() * height,
    ];
    let mark = ["cx", "cy"].map(|key| {
        number(&mut browser, &format!("Number(document.querySelector('#overlay .cross-middle').getAttribute('{key}'))"))
    });
    assert!((mark[0] - want[0]).hypot(mark[1] - want[1]) < 0.01, "{mark:?} {want:?}");
    // The wheel steps through, keys go within and through.
    let step = number(&mut browser, "window.vr.slices.opened.steps[2]");
    browser.mouse("mouseWheel", at, json!({"deltaX": 0, "deltaY": -40, "button": "none", "buttons": 0}));
    browser.wait(there);
    assert!((crosshair(&mut browser)[2] - moved[2] - step).abs() < 1e-9);
    browser.value("document.getElementById('slice-2-canvas').focus()");
    browser.key("PageDown", 0);
    browser.key("ArrowLeft", 0);
    browser.key("ArrowUp", 0);
    browser.wait(there);
    let now = crosshair(&mut browser);
    let steps = [moved[0] - step, moved[1] + step, moved[2]];
    assert!((0..3).all(|k| (now[k] - steps[k]).abs() < 1e-9), "{now:?} {steps:?}");
    // Pixels are the program's values by window and level; a drag with the right button changes both.
    let gray = "(() => { const v = window.vr.slices.views[0]; const [w, h] = v.slice.size; const [low, high] = window.vr.slices.window; \
                const d = v.canvas.getContext('2d').getImageData(0, 0, w, h).data; let worst = 0; \
                v.slice.values.forEach((value, i) => { const want = Math.min(Math.max((255 * (value - low)) / (high - low), 0), 255); worst = Math.max(worst, Math.abs(d[4 * i] - want)); }); return worst; })()";
    assert!(number(&mut browser, gray) <= 1.0);
    let window = browser.value("window.vr.slices.window");
    browser.drag(at, [at[0] + 30.0, at[1] + 20.0], 5, "right");
    let other = browser.value("window.vr.slices.window");
    let [width_before, width_after] = [&window, &other].map(|w| w[1].as_f64().unwrap() - w[0].as_f64().unwrap());
    assert!(width_after > 1.2 * width_before, "{window} {other}");
    assert!(number(&mut browser, gray) <= 1.0);
    assert_eq!(crosshair(&mut browser), now, "that moves no crosshair");
    browser.value("document.getElementById('slices-window').click()");
    assert_eq!(browser.value("window.vr.slices.window"), window);
    // The value under the pointer is said.
    browser.mouse("mouseMoved", at, json!({"button": "none", "buttons": 0}));
    browser.wait("document.getElementById('slice-2-caption').textContent !== ''");
    // The mark goes where it is not wanted; the same key closes them all.
    browser.value("document.getElementById('slices-mark').click()");
    assert_eq!(number(&mut browser, "document.querySelectorAll('#overlay .crosshair').length"), 0.0);
    screenshots(&running, &mut browser, "slices", |browser| {
        browser.key("s", 0);
        browser.wait(there);
    });
    if browser.value("window.vr.slices.isOpen") == true {
        browser.value("document.getElementById('slices-toggle').click()");
    }
    assert_eq!(browser.value("document.getElementById('slices').hidden"), true);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}
