//! The page in a real browser. Without one, each test says so and passes.

#[path = "../view/common.rs"]
#[allow(dead_code)]
mod common;

mod chromium;

use base64::Engine;
use serde_json::json;

use chromium::Browser;
use common::{Running, document, drawn_anew};

const SIZE: [u32; 2] = [700, 420];

/// A browser with the page of a phantom, proven; `None` where there is no browser.
fn opened(name: &str) -> Option<(Running, Browser)> {
    let mut browser = Browser::start()?;
    let running = Running::new(document(name, 24, [64, 64]), true);
    browser.open(&format!("http://{}/{}/", running.address, running.token), SIZE, "dark");
    rest(&mut browser);
    Some((running, browser))
}

/// Waits until the newest picture is at rest, and of the page's size.
fn rest(browser: &mut Browser) {
    browser.wait("window.vr?.rests && window.vr.status.head.size.every((n, k) => n === window.vr.picture.size[k])");
}

/// Waits until an edit that was just made is shown and at rest.
fn settled(browser: &mut Browser, before: i64) {
    browser.wait(&format!("window.vr.status.head.picture > {before}"));
    rest(browser);
}

fn number(browser: &mut Browser, expression: &str) -> f64 {
    browser.value(expression).as_f64().unwrap_or_else(|| panic!("{expression} is no number"))
}

fn picture(browser: &mut Browser) -> i64 {
    number(browser, "window.vr.status.head.picture") as i64
}

/// Pixels on the screen, and those of the scene that the page saves, drawn anew.
fn shown_and_saved(browser: &mut Browser) -> ([u32; 2], Vec<u8>, [u32; 2], Vec<u8>) {
    let text = browser.value("fetch('save/scene.toml').then((answer) => answer.text())");
    let (size, saved) = drawn_anew(text.as_str().unwrap());
    let shown = browser.value(
        "(() => { const c = document.getElementById('picture'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
         let s = ''; for (let i = 0; i < d.length; i += 32768) s += String.fromCharCode(...d.subarray(i, i + 32768)); \
         return [c.width, c.height, btoa(s)]; })()",
    );
    let shown_size = [0, 1].map(|i| shown[i].as_u64().unwrap() as u32);
    let bytes = base64::engine::general_purpose::STANDARD.decode(shown[2].as_str().unwrap()).unwrap();
    (shown_size, bytes, size, saved)
}

fn assert_truth(browser: &mut Browser) {
    let (shown_size, shown, size, saved) = shown_and_saved(browser);
    assert_eq!(shown_size, size);
    assert!(shown == saved, "pixels on the screen are those of the saved scene");
    assert!(shown.chunks(4).any(|p| p != &shown[..4]), "something is seen");
}

#[test]
fn pixels_on_the_screen_are_those_of_the_saved_scene() {
    let Some((running, mut browser)) = opened("blobs") else { return };
    assert_truth(&mut browser);
    let status = browser.value("document.getElementById('status').innerText").as_str().unwrap().to_owned();
    assert!(status.contains("raycast") && status.contains("every pixel within 0.004: proven"), "{status}");
    // Turn, move, zoom.
    // Nine digits: where a camera only moves, its axes are found anew, to rounding.
    let up = "JSON.stringify(window.vr.status.head.camera, (key, x) => key === 'eye' ? undefined : typeof x === 'number' ? Number(x.toFixed(9)) : x)";
    let mut last = browser.value(up);
    let middle = [170.0, 200.0];
    for act in 0..4 {
        let before = picture(&mut browser);
        match act {
            0 => browser.drag(middle, [250.0, 230.0], 12, "left"),
            1 => browser.drag(middle, [200.0, 180.0], 6, "right"),
            2 => browser.mouse(
                "mouseWheel",
                [190.0, 190.0],
                json!({"deltaX": 0, "deltaY": -240, "button": "none", "buttons": 0}),
            ),
            _ => {
                browser.value("document.getElementById('picture').focus()");
                browser.key("ArrowLeft", 0);
            }
        }
        settled(&mut browser, before);
        let now = browser.value(up);
        // Moving leaves orientation and height as they are.
        assert_eq!(now == last, act == 1, "{act}: {last} {now}");
        last = now;
        assert_truth(&mut browser);
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

#[test]
fn the_curve_is_edited_by_hand_and_undone() {
    let Some((running, mut browser)) = opened("fog") else { return };
    let points = "window.vr.curve.points.length";
    browser.wait(&format!("{points} > 0"));
    let count = number(&mut browser, points);
    let place = |browser: &mut Browser, x: f64, y: f64| {
        let at = browser.value(&format!(
            "(() => {{ const b = document.getElementById('curve').getBoundingClientRect(); return [b.left + {x} * b.width, b.top + {y} * b.height]; }})()"
        ));
        [at[0].as_f64().unwrap(), at[1].as_f64().unwrap()]
    };
    // A double click adds a point where it is.
    let before = picture(&mut browser);
    let at = place(&mut browser, 0.4, 0.3);
    for clicks in [1, 2] {
        browser.mouse("mousePressed", at, json!({"clickCount": clicks}));
        browser.mouse("mouseReleased", at, json!({"clickCount": clicks, "buttons": 0}));
    }
    browser.wait(&format!("{points} === {}", count + 1.0));
    settled(&mut browser, before);
    assert_truth(&mut browser);
    // A drag moves it.
    let chosen = "window.vr.curve.points[window.vr.curve.selected]";
    let [value, opacity] = ["value", "opacity"].map(|key| number(&mut browser, &format!("{chosen}.{key}")));
    let before = picture(&mut browser);
    let to = place(&mut browser, 0.5, 0.6);
    browser.drag(at, to, 10, "left");
    settled(&mut browser, before);
    let [moved, lower] = ["value", "opacity"].map(|key| number(&mut browser, &format!("{chosen}.{key}")));
    assert!(moved > value && lower < opacity, "{value} {opacity} {moved} {lower}");
    assert_truth(&mut browser);
    // The drag is undone as one, by a key.
    let before = picture(&mut browser);
    browser.value("document.getElementById('picture').focus()");
    browser.key("z", 2);
    settled(&mut browser, before);
    browser.wait(&format!("Math.abs({chosen}.value - {value}) < 1e-9"));
    let before = picture(&mut browser);
    browser.value("document.getElementById('undo').click()");
    settled(&mut browser, before);
    browser.wait(&format!("{points} === {count}"));
    // A preset, and a key on the curve.
    let before = picture(&mut browser);
    browser.value("(() => { const p = document.getElementById('preset'); p.value = 'inferno'; p.dispatchEvent(new Event('change')); })()");
    settled(&mut browser, before);
    assert_truth(&mut browser);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

#[test]
fn panels_crop_light_and_choose() {
    let Some((running, mut browser)) = opened("blobs") else { return };
    let set = |browser: &mut Browser, selector: &str, value: &str| {
        browser.value(&format!(
            "(() => {{ const i = document.querySelector({selector:?}); i.value = {value}; \
             i.dispatchEvent(new Event('input')); i.dispatchEvent(new Event('change')); }})()"
        ));
    };
    let click = |browser: &mut Browser, id: &str| {
        browser.value(&format!("document.getElementById({id:?}).click()"));
    };
    type Act = Box<dyn Fn(&mut Browser)>;
    let acts: [(&str, Act); 8] = [
        ("crop", Box::new(move |b| set(b, "[data-axis='0'] input:last-of-type", "0.5"))),
        ("plane", Box::new(move |b| click(b, "plane"))),
        ("depth", Box::new(move |b| set(b, "#plane-depth", "0.2"))),
        ("whole", Box::new(move |b| click(b, "uncrop"))),
        ("shade", Box::new(move |b| click(b, "shaded"))),
        ("density", Box::new(move |b| set(b, "#density", "0.7"))),
        ("perspective", Box::new(move |b| click(b, "perspective"))),
        ("background", Box::new(move |b| set(b, "#background", "'#336699'"))),
    ];
    for (name, act) in acts {
        let before = picture(&mut browser);
        act(&mut browser);
        settled(&mut browser, before);
        let (_, shown, _, saved) = shown_and_saved(&mut browser);
        assert!(shown == saved, "{name}");
    }
    // A page that is loaded anew shows the same scene.
    let text = "fetch('save/scene.toml').then((answer) => answer.text())";
    let before = browser.value(text);
    assert!(before.as_str().unwrap().contains("perspective"), "{before}");
    browser.call("Page.reload", json!({}));
    rest(&mut browser);
    assert_eq!(browser.value(text), before);
    assert_truth(&mut browser);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

#[test]
fn it_fits_narrow_and_wide_screens_in_both_themes() {
    let Some(mut browser) = Browser::start() else { return };
    let running = Running::new(document("hydrogen", 32, [64, 64]), true);
    let address = format!("http://{}/{}/", running.address, running.token);
    for size in [[360, 740], [1280, 800], [3840, 2160]] {
        for scheme in ["dark", "light"] {
            browser.open(&address, size, scheme);
            browser.wait("window.vr?.curve.points.length > 0 && window.vr.picture.head?.full_size[0] === window.vr.picture.size[0]");
            // Nothing is wider than the screen, and everything that can be pressed can be seen or scrolled to.
            let wide = "[...document.querySelectorAll('header, footer, #stage, #panel')].filter((e) => !e.inert).map((e) => e.getBoundingClientRect())\
                        .every((b) => b.left >= 0 && b.right <= innerWidth + 0.5 && b.top >= 0 && b.bottom <= innerHeight + 0.5)";
            assert_eq!(browser.value(wide), true, "{size:?} {scheme}");
            let names = "[...document.querySelectorAll('button, input, select, a')].every((e) => \
                         (e.textContent || e.ariaLabel || e.title || e.labels?.[0]?.textContent || '').trim() !== '')";
            assert_eq!(browser.value(names), true, "everything has a name");
            let shot = browser.screenshot();
            let image = image::load_from_memory(&shot).unwrap();
            assert_eq!([image.width(), image.height()], size);
            if let Some(folder) = std::env::var_os("VR_SCREENSHOTS") {
                let path = std::path::Path::new(&folder).join(format!("{scheme}-{}.png", size[0]));
                std::fs::write(path, shot).unwrap();
            }
        }
    }
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

/// Draws the page anew in both themes, narrow and wide, and keeps it where a folder is named for that.
fn screenshots(running: &Running, browser: &mut Browser, name: &str, act: impl Fn(&mut Browser)) {
    let Some(folder) = std::env::var_os("VR_SCREENSHOTS") else { return };
    for scheme in ["dark", "light"] {
        for [width, height] in [[360, 740], [1280, 800]] {
            browser.open(&format!("http://{}/{}/", running.address, running.token), [width, height], scheme);
            rest(browser);
            act(browser);
            let path = std::path::Path::new(&folder).join(format!("{name}-{scheme}-{width}.png"));
            std::fs::write(path, browser.screenshot()).unwrap();
        }
    }
}

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
    assert!(second.contains("raycast, draft") && second.contains("measured on 576 pixels"), "{second}");
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

/// Small files of a grid, of points, of a mesh of cells and of an adaptive grid; returns their names.
fn small_files(folder: &std::path::Path) -> [&'static str; 4] {
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    std::fs::write(folder.join("grid.nrrd"), common::nrrd(1.0)).unwrap();
    // Points on a lattice, with a radius and a value each.
    let rows: String = (0..64).map(|i| format!("{},{},{},1.2,{}\n", i % 4, i / 4 % 4, i / 16, 1 + i % 5)).collect();
    write("points.csv", format!("x,y,z,h,Temperature\n{rows}"));
    // Two tetrahedra on a common face.
    let mesh = "# vtk DataFile Version 3.0\ncells\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 float\n0 0 0  2 0 0  0 2 0  0 0 2  2 2 2\n\
                CELLS 2 10\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 2\n10 10\nPOINT_DATA 5\nSCALARS f float 1\nLOOKUP_TABLE default\n0 1 2 3 4\n";
    write("cells.vtk", mesh.to_owned());
    // 4×4×2 cells, of which the half on the left is refined by two.
    write(
        "adaptive.vthb",
        "<VTKFile type=\"vtkOverlappingAMR\" version=\"1.1\"><vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">\n\
         <Block level=\"0\" spacing=\"1 1 1\"><DataSet index=\"0\" amr_box=\"0 3 0 3 0 1\" file=\"parts/0.vti\"/></Block>\n\
         <Block level=\"1\" spacing=\"0.5 0.5 0.5\"><DataSet index=\"0\" amr_box=\"0 3 0 7 0 3\" file=\"parts/1.vti\"/></Block>\n\
         </vtkOverlappingAMR></VTKFile>\n"
            .to_owned(),
    );
    std::fs::create_dir(folder.join("parts")).unwrap();
    for (name, spacing, n) in [("parts/0.vti", 1.0, [4, 4, 2]), ("parts/1.vti", 0.5, [4, 8, 4])] {
        let count = n[0] * n[1] * n[2];
        let values: String =
            (0..count).map(|i| format!("{} ", spacing * (i % n[0]) as f64 + (i / n[0] % n[1]) as f64)).collect();
        let extent = format!("0 {} 0 {} 0 {}", n[0], n[1], n[2]);
        write(
            name,
            format!(
                "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"{spacing} {spacing} {spacing}\">\
                 <Piece Extent=\"{extent}\"><PointData/><CellData><DataArray type=\"Float64\" Name=\"f\">{values}</DataArray></CellData></Piece></ImageData></VTKFile>\n"
            ),
        );
    }
    ["grid.nrrd", "points.csv", "cells.vtk", "adaptive.vthb"]
}

#[test]
fn any_kind_of_volume_is_opened_from_the_page_and_undone() {
    let Some(mut browser) = Browser::start() else { return };
    let folder = tempfile::tempdir().unwrap();
    let names = small_files(folder.path());
    let running = Running::opening(document("blobs", 16, [64, 64]), Some(folder.path()), 1 << 20);
    browser.open(&format!("http://{}/{}/", running.address, running.token), SIZE, "dark");
    rest(&mut browser);
    browser.wait("window.vr.open.listing?.files.length === 6");
    let title = |browser: &mut Browser| browser.value("document.getElementById('title').textContent");
    let slices =
        "window.vr.slices.views.every((v) => v.slice && !v.waits && v.slice.values.some((n) => !Number.isNaN(n)))";
    browser.value("document.getElementById('slices-toggle').click()");
    browser.wait(slices);
    for name in names {
        // By its path; the picture at rest is that of the saved scene, which names the file.
        let before = picture(&mut browser);
        browser.value(&format!(
            "(() => {{ document.getElementById('open-path').value = {name:?}; document.getElementById('open-form').requestSubmit(); }})()"
        ));
        browser.wait(&format!("document.getElementById('title').textContent === {name:?}"));
        settled(&mut browser, before);
        browser.value("window.vr.send({ kind: 'automatic-look' })");
        let before = picture(&mut browser);
        settled(&mut browser, before);
        assert_truth(&mut browser);
        // Slices are of the new volume, and so is the curve.
        browser.wait(slices);
        let same = "window.vr.slices.views.map((v) => { const { size: [w, h], values, corner, right, down } = v.slice; \
                    const i = values.findIndex((n) => !Number.isNaN(n)); const [s, t] = [((i % w) + 0.5) / w, (Math.floor(i / w) + 0.5) / h]; \
                    const [x, y, z] = corner.map((c, k) => c + right[k] * s + down[k] * t); \
                    return fetch(`place?${new URLSearchParams({ x, y, z })}`).then((a) => a.json()).then((p) => [values[i], Math.fround(p.value)]); })";
        let pairs = browser.value(&format!("Promise.all({same})"));
        for pair in pairs.as_array().unwrap() {
            let [shown, told] = [0, 1].map(|i| pair[i].as_f64().unwrap());
            assert!((shown - told).abs() <= 1e-5 * told.abs().max(1.0), "{name}: {pairs}");
        }
        let text = browser.value("document.getElementById('open-text').textContent").as_str().unwrap().to_owned();
        assert!(text.starts_with(name), "{text}");
    }
    // Undo comes back to the file before.
    let before = picture(&mut browser);
    browser.value("window.vr.send({ kind: 'undo' }); window.vr.send({ kind: 'undo' })");
    browser.wait("document.getElementById('title').textContent === 'cells.vtk'");
    settled(&mut browser, before);
    assert_truth(&mut browser);
    // A path that leads out is refused in words, and changes nothing.
    browser.value("(() => { document.getElementById('open-path').value = '../x'; document.getElementById('open-form').requestSubmit(); })()");
    browser.wait("document.getElementById('toast').textContent.includes('--folder')");
    assert_eq!(title(&mut browser), "cells.vtk");
    // A file that is chosen is sent in pieces.
    let document = browser.call("DOM.getDocument", json!({}))["root"]["nodeId"].clone();
    let input =
        browser.call("DOM.querySelector", json!({"nodeId": document, "selector": "#open-files"}))["nodeId"].clone();
    let path = folder.path().join("grid.nrrd");
    browser.call("DOM.setFileInputFiles", json!({"nodeId": input, "files": [path]}));
    browser.wait("document.getElementById('title').textContent === 'grid.nrrd'");
    rest(&mut browser);
    // One that is dropped, too; rubbish is said.
    let drop = |browser: &mut Browser, name: &str, text: &str| {
        browser.value(&format!(
            "(() => {{ const t = new DataTransfer(); t.items.add(new File([{text:?}], {name:?})); \
             window.dispatchEvent(new DragEvent('drop', {{ dataTransfer: t, cancelable: true }})); }})()"
        ));
    };
    drop(&mut browser, "dropped.csv", "x,y,z,h,Temperature\n0,0,0,1,1\n1,1,1,1,2\n");
    browser.wait("document.getElementById('title').textContent === 'dropped.csv'");
    rest(&mut browser);
    drop(&mut browser, "rubbish.nrrd", "no volume");
    browser.wait("document.getElementById('toast').textContent.startsWith('rubbish.nrrd: ')");
    assert_eq!(title(&mut browser), "dropped.csv");
    browser.value("document.getElementById('section-open').open = true");
    screenshots(&running, &mut browser, "open", |browser| {
        browser.value("document.getElementById('panel').inert && document.getElementById('panel-toggle').click(); document.getElementById('section-open').open = true; document.getElementById('section-open').scrollIntoView()");
    });
    browser.complaints.retain(|complaint| !complaint.contains("403") && !complaint.contains("422"));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
    running.end();
}

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
