//! The crop box in the picture.

use super::*;

const BOX: &str = "window.vr.cropBox";

/// Middle of a handle in the page.
fn handle(browser: &mut Browser, label: &str) -> [f64; 2] {
    let at = browser.value(&format!(
        "(() => {{ const b = document.querySelector('#crop-box [aria-label={label:?}] .knob').getBoundingClientRect(); \
         return [b.left + b.width / 2, b.top + b.height / 2]; }})()"
    ));
    [0, 1].map(|k| at[k].as_f64().unwrap())
}

/// The box of the scene that the page saves; `None` for the whole volume.
fn saved_box(browser: &mut Browser) -> Option<[[f64; 3]; 2]> {
    let text = browser.value("fetch('save/scene.toml').then((answer) => answer.text())");
    let file = vr_io::parse_scene(text.as_str().unwrap(), std::path::Path::new("saved")).unwrap();
    let loaded = vr_io::resolve_scene(&file, std::path::Path::new("")).unwrap();
    loaded.view.clip.crop.map(|(low, high)| [low.to_array(), high.to_array()])
}

#[test]
fn faces_follow_the_pointer_and_keys_and_are_undone() {
    let Some((running, mut browser)) = opened("blobs") else { return };
    // An oblique view, so that every face has a way across the picture, from so far that all of them are seen below the tools.
    let before = picture(&mut browser);
    browser.value(
        "window.vr.send({kind: 'orbit', right: 25, up: 20}); window.vr.send({kind: 'zoom', factor: 0.25, at: [0, 0]})",
    );
    settled(&mut browser, before);
    assert_eq!(browser.value("document.querySelector('#crop-box').checkVisibility()"), false);
    browser.value("document.getElementById('picture').focus()");
    browser.key("b", 0);
    assert_eq!(number(&mut browser, "document.querySelectorAll('#crop-box .handle').length"), 6.0);
    assert_eq!(browser.value("document.querySelector('#crop-box').checkVisibility()"), true);
    browser.value(&format!(
        "(() => {{ const send = {BOX}.send; \
         {BOX}.send = (edit) => {{ const number = send(edit); if (edit.kind === 'crop') window.lastCrop = number; }}; }})()"
    ));
    let bounds = browser.value(&format!("{BOX}.opened.bounds"));
    let bound = |end: usize, axis: usize| bounds[end][axis].as_f64().unwrap();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        for end in [0, 1] {
            let label = format!("{} end of {name}", ["Lower", "Upper"][end]);
            // Drag it toward the other face by a third of the way: it stays under the pointer.
            let other = format!("{} end of {name}", ["Upper", "Lower"][end]);
            let (from, to) = (handle(&mut browser, &label), handle(&mut browser, &other));
            let to = [0, 1].map(|k| from[k] + (to[k] - from[k]) / 3.0);
            // A drag is many edits, and a slow machine may come to rest between two of them: the last one is waited for.
            browser.drag(from, to, 8, "left");
            browser.wait("window.vr.status.head.answers >= window.lastCrop");
            rest(&mut browser);
            let now = handle(&mut browser, &label);
            assert!((0..2).all(|k| (now[k] - to[k]).abs() < 2.0), "{label}: {now:?}, the pointer is at {to:?}");
            let saved = saved_box(&mut browser).expect("it is cropped");
            let share = (saved[end][axis] - bound(end, axis)).abs() / (bound(1, axis) - bound(0, axis));
            assert!((share - 1.0 / 3.0).abs() < 0.02, "{label}: {share}");
            let others = (0..3).filter(|&k| k != axis).all(|k| [0, 1].iter().all(|&e| saved[e][k] == bound(e, k)));
            assert!(others && saved[1 - end][axis] == bound(1 - end, axis), "{label}: {saved:?}");
            assert_truth(&mut browser);
            // The drag is undone as one.
            let before = picture(&mut browser);
            browser.value("document.getElementById('undo').click()");
            settled(&mut browser, before);
            assert_eq!(saved_box(&mut browser), None);
        }
    }
    // By keys: three hundredths in, and all of the way back.
    browser.value("document.querySelector('#crop-box [aria-label=\"Upper end of y\"]').focus()");
    for (key, share) in [("ArrowDown", 0.01), ("ArrowLeft", 0.02), ("PageDown", 0.12), ("ArrowUp", 0.11)] {
        let before = picture(&mut browser);
        browser.key(key, 0);
        settled(&mut browser, before);
        let saved = saved_box(&mut browser).unwrap();
        let wanted = bound(1, 1) - share * (bound(1, 1) - bound(0, 1));
        assert!((saved[1][1] - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{key}: {saved:?}");
        assert_eq!(browser.value("document.activeElement.getAttribute('aria-label')"), "Upper end of y");
        let told = number(&mut browser, "Number(document.activeElement.getAttribute('aria-valuenow'))");
        assert_eq!(told, saved[1][1]);
    }
    assert_truth(&mut browser);
    screenshots(&running, &mut browser, "crop-box", |browser| {
        browser.value("document.getElementById('crop-handles').click()");
    });
    browser.value("window.vr.cropBox.isOpen || document.getElementById('crop-handles').click()");
    browser.value("document.querySelector('#crop-box [aria-label=\"Upper end of y\"]').focus()");
    let before = picture(&mut browser);
    browser.key("End", 0);
    settled(&mut browser, before);
    assert_eq!(saved_box(&mut browser), None);
    // A face does not pass the other one.
    let before = picture(&mut browser);
    browser.key("Home", 0);
    settled(&mut browser, before);
    let saved = saved_box(&mut browser).unwrap();
    assert!(saved[0][1] < saved[1][1] && saved[1][1] - saved[0][1] < 0.01 * (bound(1, 1) - bound(0, 1)), "{saved:?}");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}
