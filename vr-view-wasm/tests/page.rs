//! The page without a server in a real browser, as a file and from a static host. Without a browser, or without the module, each test says so and passes.

#[path = "../../vr-view/tests/browser/chromium.rs"]
#[allow(dead_code)]
mod chromium;

use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use chromium::Browser;
use vr_core::Control;
use vr_view_wasm::package::package;
use vr_view_wasm::renderers;

const SIZE: [u32; 2] = [700, 420];

/// The page around the module; `None`, with a word, where the module was not built.
fn page() -> Option<String> {
    // Tests lie in target/PROFILE/deps.
    let tests = std::env::current_exe().unwrap();
    let target = tests.ancestors().nth(3).unwrap();
    let module = target.join("wasm32-unknown-unknown/release/vr_view_wasm.wasm");
    let Ok(bytes) = std::fs::read(&module) else {
        println!("skipped: {} is not built (vr-view-wasm/README.md says how)", module.display());
        return None;
    };
    Some(package(&bytes).unwrap())
}

/// One browser at a time draws: each has one thread, and all of them would wait for each other.
static TURN: std::sync::Mutex<()> = std::sync::Mutex::new(());

fn turn() -> std::sync::MutexGuard<'static, ()> {
    TURN.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Has the picture at rest be sharp, and not proven, which takes long.
fn unproven(browser: &mut Browser) {
    browser.wait("Boolean(window.vr?.status.head)");
    browser.value("window.vr.send({kind: 'quality', quality: 'normal'})");
    browser.wait("window.vr.rests");
    rest(browser);
}

/// A browser with the page, opened as a file, and the folder of that.
fn opened(size: [u32; 2]) -> Option<(Browser, tempfile::TempDir)> {
    let page = page()?;
    let mut browser = Browser::start()?;
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("vr.html"), page).unwrap();
    browser.open(&address(folder.path()), size, "dark");
    Some((browser, folder))
}

fn address(folder: &Path) -> String {
    format!("file://{}", folder.join("vr.html").display())
}

/// Waits until the newest picture is at rest, and of the page's size.
fn rest(browser: &mut Browser) {
    browser.wait("window.vr?.rests && window.vr.status.head.size.every((n, k) => n === window.vr.picture.size[k])");
}

/// Waits until an edit that was just made is shown and at rest.
fn settled(browser: &mut Browser, before: f64) {
    browser.wait(&format!("window.vr.status.head.picture > {before}"));
    rest(browser);
}

fn number(browser: &mut Browser, expression: &str) -> f64 {
    browser.value(expression).as_f64().unwrap_or_else(|| panic!("{expression} is no number"))
}

fn newest(browser: &mut Browser) -> f64 {
    number(browser, "window.vr.status.head.picture")
}

/// Asks the program in the page for a text.
fn text(browser: &mut Browser, address: &str) -> String {
    let asked = browser.value(&format!("window.vr.ask({address:?}).then((answer) => answer.text())"));
    asked.as_str().unwrap().to_owned()
}

/// Checks that the pixels on the screen are those that this machine draws of the scene that the page saves, bit for bit, sharp or proven.
fn assert_truth(browser: &mut Browser, folder: &Path) {
    let text = text(browser, "save/scene.toml");
    let file = vr_io::parse_scene(&text, Path::new("saved")).unwrap();
    let loaded = vr_io::resolve_scene(&file, &folder.join("scene.toml")).unwrap();
    let list = renderers().all;
    let renderer = list.iter().find(|r| Some(r.name()) == loaded.renderer.as_deref()).unwrap();
    let renderer = renderer.with_options(&loaded.options).unwrap();
    let control = Control::default();
    let prepared = match loaded.max_error {
        Some(error) => renderer.with_max_error(error).unwrap().unwrap().prepare(&loaded.scene, &control),
        None => renderer.prepare(&loaded.scene, &control),
    };
    let frame = prepared.unwrap().render(&loaded.view, &control).unwrap().frame;
    let shown = browser.value(
        "(() => { const c = document.getElementById('picture'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
         let s = ''; for (let i = 0; i < d.length; i += 32768) s += String.fromCharCode(...d.subarray(i, i + 32768)); \
         return [c.width, c.height, btoa(s)]; })()",
    );
    assert_eq!([0, 1].map(|i| shown[i].as_u64().unwrap() as u32), frame.size());
    let shown = STANDARD.decode(shown[2].as_str().unwrap()).unwrap();
    let drawn = vr_io::screen_rgba(&frame, loaded.scene.background);
    let differing = shown.iter().zip(&drawn).filter(|(a, b)| a != b).count();
    assert_eq!(differing, 0, "of {} bytes, max-error {:?}", drawn.len(), loaded.max_error);
    assert!(shown.chunks(4).any(|p| p != &shown[..4]), "something is seen");
}

/// Keeps a picture of the page where a folder is named for that.
fn screenshot(browser: &mut Browser, name: &str) {
    let Some(folder) = std::env::var_os("VR_SCREENSHOTS") else { return };
    std::fs::write(PathBuf::from(folder).join(format!("{name}.png")), browser.screenshot()).unwrap();
}

fn no_complaints(browser: &Browser) {
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn opened_as_a_file_it_draws_what_the_program_draws() {
    let _turn = turn();
    let Some((mut browser, folder)) = opened(SIZE) else { return };
    rest(&mut browser);
    let status = browser.value("document.getElementById('status').innerText").as_str().unwrap().to_owned();
    assert!(status.contains("raycast") && status.contains("every pixel within 0.004: proven"), "{status}");
    assert_truth(&mut browser, folder.path());
    screenshot(&mut browser, "local-dark-700");
    // Turn, shade, crop, another renderer.
    let edits = [
        json!({"kind": "quality", "quality": "normal"}),
        json!({"kind": "orbit", "right": 40, "up": 15}),
        json!({"kind": "projection", "perspective": true}),
        json!({"kind": "renderer", "name": "shearwarp"}),
    ];
    for edit in edits {
        let before = newest(&mut browser);
        browser.value(&format!("window.vr.send({edit})"));
        settled(&mut browser, before);
        assert_truth(&mut browser, folder.path());
    }
    // Slices, a place, a pixel's ray, the error map, and a second picture.
    browser.value("document.getElementById('slices-toggle').click()");
    browser.wait("window.vr.slices.views.every((v) => v.slice && !v.waits && v.slice.values.some((n) => n > 0))");
    browser.wait("document.getElementById('slices-text').textContent.startsWith('value')");
    browser.value("document.getElementById('slices-toggle').click()");
    rest(&mut browser);
    let error = text(&mut browser, "truth/error-map");
    let error: Value = serde_json::from_str(&error).unwrap();
    assert!(error["max"].as_f64().unwrap() < 0.1 && error["pixels"].as_array().unwrap().len() > 1000, "{error}");
    browser.value("window.vr.ray.open([0, 0])");
    browser.wait("window.vr.ray.found !== null");
    browser.value("window.vr.ray.close()");
    // What is refused is said, and changes nothing.
    let status = |browser: &mut Browser, address: &str| {
        number(browser, &format!("window.vr.ask({address:?}).then((answer) => answer.status)"))
    };
    assert_eq!(status(&mut browser, "truth/ray?x=1"), 400.0);
    assert_eq!(status(&mut browser, "save/other"), 404.0);
    assert_eq!(status(&mut browser, "save/picture.exr"), 422.0);
    browser.value("window.vr.send({kind: 'renderer', name: 'none'})");
    browser.wait("document.getElementById('toast').textContent.includes('none')");
    no_complaints(&browser);
}

#[test]
fn it_is_served_by_any_host_and_asks_it_for_nothing_else() {
    let _turn = turn();
    let Some(page) = page() else { return };
    let Some(mut browser) = Browser::start() else { return };
    // A host that has one file, and counts what it is asked for.
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let host = listener.local_addr().unwrap();
    let (asked, requests) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let mut head = [0; 4096];
            let length = stream.read(&mut head).unwrap_or(0);
            if length == 0 {
                continue;
            }
            let line = String::from_utf8_lossy(&head[..length]).lines().next().unwrap_or_default().to_owned();
            let _ = asked.send(line);
            let answer = format!(
                "HTTP/1.1 200 OK\r\nContent-Type: text/html\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
                page.len()
            );
            let _ = stream.write_all(answer.as_bytes()).and_then(|()| stream.write_all(page.as_bytes()));
        }
    });
    browser.open(&format!("http://{host}/vr.html"), SIZE, "light");
    unproven(&mut browser);
    assert_truth(&mut browser, Path::new(""));
    // The policy forbids to ask any other place, and this one.
    for place in ["'vr.html'", "'http://127.0.0.1:9/'"] {
        assert_eq!(browser.value(&format!("fetch({place}).then(() => true, () => false)")), false);
    }
    let lines: Vec<String> = requests.try_iter().collect();
    assert_eq!(lines, ["GET /vr.html HTTP/1.1"]);
}

#[test]
fn a_dropped_file_is_read_in_the_page_and_undone() {
    let _turn = turn();
    let Some((mut browser, folder)) = opened(SIZE) else { return };
    unproven(&mut browser);
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 10 8\nencoding: raw\nspacings: 1 1 2\n\n";
    let voxels: Vec<u8> = (0..12 * 10 * 8).map(|i| (i * 7 % 12 + 20 * (i / 120)) as u8).collect();
    let bytes = [header.as_bytes(), &voxels].concat();
    std::fs::write(folder.path().join("small.nrrd"), &bytes).unwrap();
    let before = newest(&mut browser);
    let drop = |browser: &mut Browser, name: &str, bytes: &[u8]| {
        browser.value(&format!(
            "(() => {{ const t = new DataTransfer(); \
             t.items.add(new File([Uint8Array.from(atob('{}'), (c) => c.charCodeAt(0))], '{name}')); \
             for (const kind of ['dragenter', 'dragover', 'drop']) window.dispatchEvent(new DragEvent(kind, {{ dataTransfer: t, cancelable: true }})); }})()",
            STANDARD.encode(bytes)
        ));
    };
    drop(&mut browser, "small.nrrd", &bytes);
    browser.wait("document.getElementById('title').textContent.startsWith('small.nrrd')");
    settled(&mut browser, before);
    // The saved scene names the file as it was called: beside it, it is drawn again.
    assert_truth(&mut browser, folder.path());
    assert_eq!(browser.value("document.getElementById('title').textContent"), "small.nrrd, 12 × 10 × 8");
    screenshot(&mut browser, "local-dropped");
    // What is no volume is refused in words that name no place of the memory.
    drop(&mut browser, "letter.txt", b"dear reader");
    browser.wait("document.getElementById('toast').textContent.includes('letter.txt')");
    let said = browser.value("document.getElementById('toast').textContent");
    assert!(!said.as_str().unwrap().contains("memory:"), "{said}");
    let before = newest(&mut browser);
    browser.value("document.getElementById('undo').click()");
    browser.wait("document.getElementById('title').textContent.startsWith('hydrogen')");
    settled(&mut browser, before);
    assert_truth(&mut browser, folder.path());
    no_complaints(&browser);
}

#[test]
fn an_edit_cancels_what_it_makes_stale() {
    let _turn = turn();
    // The proof of a large picture takes seconds on any machine.
    let Some((mut browser, _folder)) = opened(SIZE.map(|n| 2 * n)) else { return };
    // The proof is on its way as soon as the error is measured; turn in the middle of it.
    browser.wait("window.vr?.status.head?.stage === 'measured'");
    std::thread::sleep(Duration::from_millis(200));
    let last = newest(&mut browser);
    let start = Instant::now();
    browser.value("window.vr.send({kind: 'orbit', right: 10, up: 0})");
    browser.wait(&format!("window.vr.status.head.picture > {last}"));
    let waited = start.elapsed();
    assert!(browser.value("window.vr.status.head.stage") != "proven", "the proof of the view before is not shown");
    rest(&mut browser);
    let time_of_proof = number(&mut browser, "window.vr.status.head.milliseconds");
    println!("a proof takes {time_of_proof:.0} ms; an edit in the middle of one is shown after {waited:?}");
    assert!(time_of_proof > 1000.0, "long enough to be interrupted: {time_of_proof} ms");
    assert!(waited.as_secs_f64() < (1e-4 * time_of_proof).max(0.5), "{waited:?} of {time_of_proof} ms");
    no_complaints(&browser);
}

#[test]
fn it_says_what_it_cannot_do_on_screens_of_all_widths() {
    let _turn = turn();
    let Some((mut browser, folder)) = opened(SIZE) else { return };
    unproven(&mut browser);
    let shown = "document.getElementById('section-local').checkVisibility()";
    assert_eq!(browser.value(shown), true);
    assert_eq!(browser.value("document.getElementById('save-exr').checkVisibility()"), false);
    for [width, height] in [[360, 740], [1280, 800]] {
        for scheme in ["dark", "light"] {
            browser.open(&address(folder.path()), [width, height], scheme);
            browser.wait("window.vr?.status.head?.stage === 'measured'");
            let wide = "[...document.querySelectorAll('header, footer, #stage, #panel')].filter((e) => !e.inert).map((e) => e.getBoundingClientRect())\
                        .every((b) => b.left >= 0 && b.right <= innerWidth + 0.5 && b.top >= 0 && b.bottom <= innerHeight + 0.5)";
            assert_eq!(browser.value(wide), true, "{width} {scheme}");
            browser.value("document.getElementById('section-local').scrollIntoView()");
            screenshot(&mut browser, &format!("local-{scheme}-{width}"));
        }
    }
    no_complaints(&browser);
}
