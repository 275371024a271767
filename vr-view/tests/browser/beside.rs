//! Truth beside the picture: error map, ray of a pixel, and a second setting behind a divider.

use super::*;

#[test]
fn an_error_map_lies_over_the_picture_at_rest() {
    let Some((running, mut browser)) = opened("hydrogen") else { return };
    let there = "window.vr.errorMap.found !== null && !document.getElementById('errors').hidden";
    let legend = "document.getElementById('error-legend').innerText";
    assert_eq!(browser.value(there), false);
    // A key asks for it.
    browser.value("document.getElementById('picture').focus()");
    browser.key("e", 0);
    browser.wait(there);
    let text = browser.value(legend).as_str().unwrap().to_owned();
    let max = number(&mut browser, "window.vr.errorMap.found.max");
    assert!(text.contains("/255") && text.contains("4096 of") && max > 0.0 && max <= 4e-3, "{text} {max}");
    // Marks lie at their pixels, in their colours; a few are covered by their neighbours.
    let colored = "(() => { const { pixels, colors, size } = window.vr.errorMap.found; const c = document.getElementById('errors'); \
                   const d = c.getContext('2d').getImageData(0, 0, ...size).data; let same = 0; \
                   pixels.forEach(([x, y], i) => { const k = 4 * (y * size[0] + x); \
                   if (colors[i].every((n, j) => d[k + j] === n) && d[k + 3] === 255) same += 1; }); return same / pixels.length; })()";
    let share = number(&mut browser, colored);
    assert!(share > 0.8, "{share} of the marks are seen at their pixels");
    assert_eq!(browser.value("document.getElementById('error-map').ariaPressed"), "true");
    assert_truth(&mut browser);
    // A move takes it away, and rest brings that of the new picture.
    let before = picture(&mut browser);
    browser.value(
        "window.vr.seen = []; new MutationObserver(() => window.vr.seen.push(document.getElementById('errors').hidden))\
                   .observe(document.getElementById('errors'), { attributes: true, attributeFilter: ['hidden'] }); 0",
    );
    browser.key("ArrowLeft", 0);
    settled(&mut browser, before);
    browser.wait(there);
    assert_eq!(browser.value("window.vr.seen.includes(true)"), true, "it was taken away meanwhile");
    assert_truth(&mut browser);
    screenshots(&running, &mut browser, "errors", |browser| {
        browser.value("document.getElementById('error-map').click()");
        browser.wait(there);
    });
    // The button takes it away for good.
    if browser.value("window.vr.errorMap.on") == true {
        browser.value("document.getElementById('error-map').click()");
    }
    assert_eq!(browser.value(there), false);
    assert_eq!(browser.value("document.getElementById('error-legend').hidden"), true);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

#[test]
fn a_pixel_is_asked_for_its_ray() {
    let Some((running, mut browser)) = opened("hydrogen") else { return };
    let told = "window.vr.ray.found !== null && document.querySelectorAll('#ray-plot path').length > 4";
    let text = "document.getElementById('ray').innerText";
    // Alt and a click ask for a pixel, and change nothing.
    let before = picture(&mut browser);
    let at = [150.0, 190.0];
    browser.mouse("mousePressed", at, json!({"clickCount": 1, "modifiers": 1}));
    browser.mouse("mouseReleased", at, json!({"clickCount": 1, "buttons": 0, "modifiers": 1}));
    browser.wait(told);
    assert_eq!(picture(&mut browser), before);
    let pixel = browser.value("window.vr.ray.found.pixel");
    let near = |value: &serde_json::Value, want: f64| (value.as_f64().unwrap() - want).abs() <= 1.0;
    assert!(near(&pixel[0], at[0]) && near(&pixel[1], at[1]), "{pixel}");
    // It is the pixel on the screen, and within the bound of the reference.
    let differs = "(() => { const { pixel, screen, error } = window.vr.ray.found; const d = document.getElementById('picture').getContext('2d').getImageData(...pixel, 1, 1).data; \
                   return [Math.max(...screen[0].map((n, c) => Math.abs(n - d[c]))), Math.max(...error.map(Math.abs))]; })()";
    let found = browser.value(differs);
    assert!(found[0].as_f64().unwrap() <= 1.0 && found[1].as_f64().unwrap() <= 4e-3, "{found}");
    let words = browser.value(text).as_str().unwrap().to_owned();
    for word in ["reference proven within", "on the screen", "difference"] {
        assert!(words.contains(word), "no {word:?} in {words}");
    }
    // A move makes it stale; at rest, the ray through the same place is asked for anew.
    let last = browser.value("window.vr.ray.found.exact");
    let before = picture(&mut browser);
    browser.value("window.vr.stale = false; new MutationObserver(() => { window.vr.stale ||= document.getElementById('ray').classList.contains('stale'); }).observe(document.getElementById('ray'), { attributes: true }); document.getElementById('picture').focus(); 0");
    browser.key("ArrowLeft", 0);
    settled(&mut browser, before);
    browser.wait(told);
    assert_eq!(browser.value("window.vr.stale"), true);
    assert_eq!(browser.value("window.vr.ray.found.pixel"), pixel);
    assert_ne!(browser.value("window.vr.ray.found.exact"), last);
    // Escape closes it, a key opens it for the pixel in the middle, and the tool for any, while its drags turn.
    browser.key("Escape", 0);
    assert_eq!(
        browser.value("document.getElementById('ray').hidden && document.getElementById('ray-mark').hidden"),
        true
    );
    browser.key("i", 0);
    browser.wait(told);
    assert_eq!(browser.value("window.vr.ray.found.pixel.every((n, k) => n === window.vr.picture.size[k] >> 1)"), true);
    browser.value("document.getElementById('ray-close').click(); document.querySelector('[data-tool=ray]').click()");
    let before = picture(&mut browser);
    browser.drag(at, [200.0, 200.0], 6, "left");
    settled(&mut browser, before);
    assert_eq!(browser.value("window.vr.ray.isOpen"), false);
    browser.mouse("mousePressed", at, json!({"clickCount": 1}));
    browser.mouse("mouseReleased", at, json!({"clickCount": 1, "buttons": 0}));
    browser.wait(told);
    // By a setting that lists its steps, the renderer's curves are there, too.
    let before = picture(&mut browser);
    browser.value("window.vr.send({ kind: 'quality', quality: 'draft' })");
    browser.wait(&format!("window.vr.status.head.picture > {before} && window.vr.rests"));
    browser.wait(&format!("{told} && window.vr.ray.found.steps > 5"));
    let words = browser.value(text).as_str().unwrap().to_owned();
    assert!(words.contains("steps of raycast"), "{words}");
    screenshots(&running, &mut browser, "ray", |browser| {
        browser.key("i", 0);
        browser.wait(told);
    });
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

#[test]
fn a_curtain_shows_a_second_setting_at_rest() {
    let Some((running, mut browser)) = opened("blobs") else { return };
    let there = "window.vr.curtain.found !== null && !document.getElementById('second').hidden";
    let split = "window.vr.curtain.split";
    let label = |browser: &mut Browser, id: &str| {
        browser.value(&format!("document.getElementById({id:?}).innerText")).as_str().unwrap().to_owned()
    };
    // A key opens it: a draft by the same renderer beside the proven picture; each says what it is.
    browser.value("document.getElementById('picture').focus()");
    browser.key("c", 0);
    browser.wait(there);
    let [first, second] = ["first-label", "second-label"].map(|id| label(&mut browser, id));
    assert!(first.contains("raycast, proven") && first.contains("every pixel within 0.004: proven"), "{first}");
    assert!(second.contains("raycast, draft") && second.contains("measured on 400 pixels"), "{second}");
    assert!(first.contains(" ms") || first.contains(" s\n"), "{first}");
    assert_truth(&mut browser);
    // The pixels behind it are those of a scene with its setting.
    let shown = "(() => { const c = document.getElementById('second'); return [c.width, c.height, [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data].reduce((s, n, i) => (s * 31 + n * (i % 7 + 1)) % 1000003, 7)]; })()";
    let sum = |bytes: &[u8]| {
        bytes.iter().enumerate().fold(7u64, |s, (i, &n)| (s * 31 + u64::from(n) * (i as u64 % 7 + 1)) % 1_000_003)
    };
    let text = browser.value("fetch('save/scene.toml').then((answer) => answer.text())");
    let mut file = vr_io::parse_scene(text.as_str().unwrap(), std::path::Path::new("saved")).unwrap();
    file.render.max_error = None;
    file.render.options.0.insert("quality".to_owned(), "draft".into());
    let (size, drawn) = drawn_anew(&vr_io::scene_text(&file).unwrap());
    let found = browser.value(shown);
    assert_eq!(found, json!([size[0], size[1], sum(&drawn)]));
    // The divider goes by mouse and by keys.
    let at = |browser: &mut Browser| {
        let place = browser.value("(() => { const b = document.getElementById('divider').getBoundingClientRect(); return [b.left + b.width / 2, b.top + b.height / 2]; })()");
        [place[0].as_f64().unwrap(), place[1].as_f64().unwrap()]
    };
    assert_eq!(number(&mut browser, split), 0.5);
    let from = at(&mut browser);
    let before = picture(&mut browser);
    browser.drag(from, [from[0] - 60.0, from[1]], 6, "left");
    let moved = number(&mut browser, split);
    assert!((at(&mut browser)[0] - from[0] + 60.0).abs() < 1.5 && moved < 0.45, "{moved}");
    browser.key("ArrowRight", 0);
    assert!((number(&mut browser, split) - moved - 0.02).abs() < 1e-9);
    browser.key("End", 0);
    assert_eq!(
        browser.value("[window.vr.curtain.split, document.getElementById('divider').ariaValueNow]"),
        json!([1, "100"])
    );
    browser.key("Home", 0);
    assert_eq!(number(&mut browser, split), 0.0);
    // And by a finger.
    let from = at(&mut browser);
    for (kind, x) in [("touchStart", 3.0), ("touchMove", 60.0), ("touchMove", 120.0), ("touchEnd", 0.0)] {
        let points = if kind == "touchEnd" { json!([]) } else { json!([{"x": from[0] + x, "y": from[1]}]) };
        browser.call("Input.dispatchTouchEvent", json!({"type": kind, "touchPoints": points}));
    }
    assert!((at(&mut browser)[0] - from[0] - 120.0).abs() < 1.5, "{from:?} {:?}", at(&mut browser));
    browser.value("window.vr.curtain.moveTo(0.5)");
    assert_eq!(picture(&mut browser), before, "nothing is drawn anew for that");
    // While something moves, the first is shown alone; at rest, both again.
    browser.value(
        "window.vr.seen = []; new MutationObserver(() => window.vr.seen.push(document.getElementById('second').hidden))\
                   .observe(document.getElementById('second'), { attributes: true, attributeFilter: ['hidden'] }); document.getElementById('picture').focus(); 0",
    );
    browser.key("ArrowLeft", 0);
    settled(&mut browser, before);
    browser.wait(there);
    assert_eq!(browser.value("window.vr.seen.includes(true)"), true, "it was taken away meanwhile");
    assert_ne!(browser.value(shown), found);
    // Another renderer; one that has no such quality is said in words.
    let choose = |browser: &mut Browser, id: &str, value: &str| {
        browser.value(&format!("(() => {{ const s = document.getElementById({id:?}); s.value = {value:?}; s.dispatchEvent(new Event('change')); }})()"));
    };
    choose(&mut browser, "second-renderer", "shearwarp");
    browser.wait(there);
    let second = label(&mut browser, "second-label");
    assert!(second.contains("shearwarp") && second.contains("measured"), "{second}");
    choose(&mut browser, "second-quality", "proven");
    browser.wait("document.getElementById('second-text').textContent.includes('shearwarp cannot prove')");
    assert_eq!(browser.value("document.getElementById('second').hidden"), true);
    // A click on the right side asks the second picture's pixel, one on the left side the first one's.
    choose(&mut browser, "second-quality", "");
    browser.wait(there);
    for (x, name) in [(250.0, "shearwarp"), (60.0, "raycast")] {
        browser.mouse("mousePressed", [x, 250.0], json!({"clickCount": 1, "modifiers": 1}));
        browser.mouse("mouseReleased", [x, 250.0], json!({"clickCount": 1, "buttons": 0, "modifiers": 1}));
        browser.wait(&format!("window.vr.ray.found?.renderer === {name:?}"));
        let title = browser.value("document.getElementById('ray-title').textContent").as_str().unwrap().to_owned();
        assert_eq!(title.contains("second picture"), name == "shearwarp", "{title}");
        // The panel lies over the left side.
        browser.key("Escape", 0);
    }
    screenshots(&running, &mut browser, "curtain", |browser| {
        browser.key("c", 0);
        browser.wait(there);
    });
    // The error map, which is the first picture's, takes it away.
    browser.value("window.vr.curtain.choose('raycast', 'draft'); document.getElementById('error-map').click()");
    assert_eq!(browser.value("window.vr.errorMap.on && window.vr.curtain.setting === null"), true);
    browser.value("document.getElementById('beside').click()");
    assert_eq!(browser.value("!window.vr.errorMap.on && window.vr.curtain.setting !== null"), true);
    // The button closes it for good.
    if browser.value("window.vr.curtain.setting !== null") == true {
        browser.value("document.getElementById('beside').click()");
    }
    assert_eq!(browser.value("window.vr.curtain.found === null && document.getElementById('divider').hidden"), true);
    let refused = |complaint: &String| complaint.contains("422");
    browser.complaints.retain(|complaint| !refused(complaint));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}
