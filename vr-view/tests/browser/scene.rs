//! The picture, its curve and the panels by hand, on screens of all widths.

use super::*;

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
