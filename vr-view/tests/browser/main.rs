//! The page in a real browser. Without one, each test says so and passes.

#[path = "../view/common.rs"]
#[allow(dead_code)]
mod common;

mod beside;
mod chromium;
mod crop_box;
mod opening;
mod scene;
mod slices;
mod under_pointer;

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
