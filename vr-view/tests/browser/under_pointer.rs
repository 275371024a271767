//! Values under the pointer, and opacity by gradient.

use super::*;

#[test]
fn what_is_under_the_pointer_is_marked_in_the_curve() {
    let Some((running, mut browser)) = opened("hydrogen") else { return };
    let hover =
        |browser: &mut Browser, at: [f64; 2]| browser.mouse("mouseMoved", at, json!({"button": "none", "buttons": 0}));
    let at = [150.0, 190.0];
    let before = picture(&mut browser);
    hover(&mut browser, at);
    browser.wait("window.vr.curve.marked !== null");
    assert_eq!(number(&mut browser, "document.querySelectorAll('#curve .mark').length"), 1.0);
    let value = number(&mut browser, "window.vr.curve.marked");
    let words = browser.value("document.getElementById('status-pick').textContent").as_str().unwrap().to_owned();
    assert!(words.ends_with("under the pointer"), "{words}");
    // It is a value that the ray meets.
    browser.mouse("mousePressed", at, json!({"clickCount": 1, "modifiers": 1}));
    browser.mouse("mouseReleased", at, json!({"clickCount": 1, "buttons": 0, "modifiers": 1}));
    browser.wait("window.vr.ray.found !== null");
    let met = browser.value("(() => { const all = window.vr.ray.found.parts.flatMap((p) => p.values ?? []); return [Math.min(...all), Math.max(...all)]; })()");
    let [low, high] = [0, 1].map(|i| met[i].as_f64().unwrap());
    assert!(low - 1e-3 <= value && value <= high + 1e-3, "{value} {met}");
    browser.key("Escape", 0);
    assert_eq!(picture(&mut browser), before, "nothing is drawn anew for that");
    // Away from the picture, the mark goes.
    hover(&mut browser, [600.0, 300.0]);
    browser.wait("window.vr.curve.marked === null && document.querySelectorAll('#curve .mark').length === 0");
    // A click with Alt brings the crosshair of the slices to what is seen.
    let before = picture(&mut browser);
    browser.value("document.getElementById('slices-toggle').click()");
    settled(&mut browser, before);
    let from = browser.value("window.vr.slices.crosshair");
    let at = browser.value("(() => { const b = document.getElementById('picture').getBoundingClientRect(); return [b.left + 0.45 * b.width, b.top + 0.45 * b.height]; })()");
    let at = [at[0].as_f64().unwrap(), at[1].as_f64().unwrap()];
    browser.mouse("mousePressed", at, json!({"clickCount": 1, "modifiers": 1}));
    browser.mouse("mouseReleased", at, json!({"clickCount": 1, "buttons": 0, "modifiers": 1}));
    browser.wait(&format!("JSON.stringify(window.vr.slices.crosshair) !== JSON.stringify({from})"));
    // It is seen where the click was.
    browser.wait("document.querySelector('#overlay .cross-middle') !== null");
    let mark = ["cx", "cy"].map(|key| {
        number(&mut browser, &format!("Number(document.querySelector('#overlay .cross-middle').getAttribute('{key}'))"))
    });
    assert!((mark[0] - at[0]).hypot(mark[1] - at[1]) < 1.5, "{mark:?} {at:?}");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

#[test]
fn opacity_follows_the_gradient_by_a_slider() {
    let Some((running, mut browser)) = opened("blobs") else { return };
    let before = picture(&mut browser);
    browser.value("document.getElementById('shaded').checked || document.getElementById('shaded').click()");
    settled(&mut browser, before);
    let (_, plain, ..) = shown_and_saved(&mut browser);
    let set = |browser: &mut Browser, share: &str| {
        browser.value(&format!(
            "(() => {{ const i = document.getElementById('edges'); i.value = {share}; i.dispatchEvent(new Event('input')); i.dispatchEvent(new Event('change')); }})()"
        ));
    };
    let before = picture(&mut browser);
    set(&mut browser, "0.4");
    browser.wait(&format!("window.vr.status.head.picture > {before} && window.vr.rests"));
    rest(&mut browser);
    let (_, edges, _, saved) = shown_and_saved(&mut browser);
    assert!(edges == saved && edges != plain, "the picture is that of the saved scene, and another than before");
    let text = browser.value("fetch('save/scene.toml').then((answer) => answer.text())");
    assert!(text.as_str().unwrap().contains("gradient_opacity"), "{text}");
    // Nothing is added: what is flat fades.
    let light = |bytes: &[u8]| bytes.iter().map(|&b| u64::from(b)).sum::<u64>();
    assert!(light(&edges) < light(&plain));
    let before = picture(&mut browser);
    set(&mut browser, "0");
    settled(&mut browser, before);
    assert!(shown_and_saved(&mut browser).1 == plain);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}
