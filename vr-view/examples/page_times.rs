//! Times that a person waits for in the page: `cargo build --release --workspace --bins`, then
//! `cargo run --release --workspace --example page_times -- target/release/vr ARGUMENTS OF VR VIEW` in headless Chromium, which must be installed.
//!
//! It starts `vr view` with those arguments, opens its page with a picture of 512² pixels, turns the volume by the mouse, rests, and edits the transfer function.

#[path = "../tests/browser/chromium.rs"]
#[allow(dead_code)]
mod chromium;

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use chromium::Browser;

/// Width and height of the picture.
const SIDE: f64 = 512.0;
/// Moves of the mouse, and the time between two: those of a screen of sixty pictures a second.
const MOVES: u32 = 240;
const PAUSE: Duration = Duration::from_millis(16);
/// Edits of the transfer function, and the time between two.
const EDITS: u32 = 60;

/// Function of the page that waits until the picture rests, and gives the milliseconds until each stage was shown.
const STAGES: &str = "new Promise((done) => { const start = performance.now(), at = {}; const look = () => { \
    const { stage } = window.vr.status.head; at[stage] ??= performance.now() - start; \
    if (window.vr.rests || performance.now() - start > 60000) done(at); else setTimeout(look, 2); }; look(); })";

/// Function of the page that samples the moving picture's sizes and errors.
const SAMPLING: &str = "window.vrSeen = []; window.vrSampling = setInterval(() => { const { stage, size, error, milliseconds } = window.vr.status.head; \
    if (stage === 'draft') window.vrSeen.push([size[0], error.rmse ?? null, milliseconds]); }, 20)";

/// A process that is killed when this is dropped.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Numbers of a list, in ascending order.
fn sorted(values: &Value) -> Vec<f64> {
    let mut values: Vec<f64> = values.as_array().into_iter().flatten().filter_map(Value::as_f64).collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Quantile of ascending numbers; NaN if there are none.
fn quantile(values: &[f64], share: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    values.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Left, top, width and height of the picture in the page.
fn place(browser: &mut Browser) -> [f64; 4] {
    let found = browser.value(
        "(() => { const b = document.getElementById('picture').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()",
    );
    std::array::from_fn(|i| found[i].as_f64().unwrap_or(f64::NAN))
}

/// Prints pictures a second, and milliseconds from an edit to its picture, since the last call of [`forget`].
fn shown(browser: &mut Browser, what: &str) {
    let rate = browser.value("window.vr.status.rate()");
    let waits = sorted(&browser.value("window.vr.status.latencies"));
    println!(
        "{what}: {:.0} pictures a second; {:.0} ms to the picture, 95 %: {:.0} ms, of {}",
        rate.as_f64().unwrap_or(f64::NAN),
        quantile(&waits, 0.5),
        quantile(&waits, 0.95),
        waits.len()
    );
}

/// Discards the page's times of pictures shown so far.
fn forget(browser: &mut Browser) {
    browser.value("(() => { window.vr.status.latencies.length = 0; window.vr.status.shown.length = 0; })()");
}

fn main() {
    let mut arguments = std::env::args_os().skip(1);
    let program = arguments.next().expect("the program, and the arguments of vr view");
    let mut browser = Browser::start().expect("Chromium is installed");
    let start = Instant::now();
    let child =
        Command::new(program).arg("view").args(arguments).args(["--no-open", "--stay"]).stdout(Stdio::piped()).spawn();
    let mut program = Program(child.expect("the program starts"));
    let lines = BufReader::new(program.0.stdout.take().expect("it is piped")).lines();
    let mut addresses =
        lines.map_while(Result::ok).filter_map(|line| Some(line[line.find("http://")?..].trim().to_owned()));
    let address = addresses.next().expect("it says where it listens");
    let listening = start.elapsed();
    // The rest of what it says is read, so that it never waits.
    std::thread::spawn(move || addresses.for_each(drop));

    browser.open(&address, [900, 640], "dark");
    while browser.value("Boolean(window.vr?.status.head)") != true {
        std::thread::sleep(Duration::from_millis(2));
    }
    println!(
        "first picture: {:.2} s from the start of the program, which listens after {:.2} s",
        start.elapsed().as_secs_f64(),
        listening.as_secs_f64()
    );

    // Make the picture as large as is asked for.
    let [_, _, width, height] = place(&mut browser);
    let size = [900.0 + SIDE - width, 640.0 + SIDE - height];
    let metrics = json!({"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": false});
    browser.call("Emulation.setDeviceMetricsOverride", metrics);
    browser.wait("window.vr.picture.size.every((n, k) => n === window.vr.status.head.full_size[k])");
    let stages = browser.value(STAGES);
    println!("picture of {}; at rest: {stages}", browser.value("window.vr.picture.size"));

    // Turn it by the mouse; the second half is measured.
    let [left, top, width, height] = place(&mut browser);
    let middle = [left + 0.5 * width, top + 0.5 * height];
    let held = json!({"button": "left", "buttons": 1, "clickCount": 1});
    browser.mouse("mousePressed", middle, held.clone());
    for k in 0..MOVES {
        if k == MOVES / 2 {
            forget(&mut browser);
            browser.value(SAMPLING);
        }
        let began = Instant::now();
        let turn = f64::from(k) * 0.05;
        browser.mouse(
            "mouseMoved",
            [middle[0] + 0.3 * width * turn.sin(), middle[1] + 0.1 * height * turn.cos()],
            held.clone(),
        );
        std::thread::sleep(PAUSE.saturating_sub(began.elapsed()));
    }
    let stages = browser.value(STAGES);
    browser.mouse("mouseReleased", middle, json!({"button": "left", "buttons": 0, "clickCount": 1}));
    browser.value("clearInterval(window.vrSampling)");
    shown(&mut browser, "orbit");
    let seen = browser.value("window.vrSeen");
    let column = |k: usize| sorted(&seen.as_array().into_iter().flatten().map(|row| row[k].clone()).collect());
    let [sides, errors, times] = [0, 1, 2].map(column);
    println!(
        "  {} pixels wide, RMSE {:.1e} (estimated), {:.0} ms to draw",
        quantile(&sides, 0.5),
        quantile(&errors, 0.5),
        quantile(&times, 0.5)
    );
    println!("  milliseconds after the last move: {stages}");
    println!("  error at rest: {}", browser.value("window.vr.status.head.error"));

    // Edit the transfer function.
    browser.wait("window.vr.rests");
    forget(&mut browser);
    for k in 0..EDITS {
        let began = Instant::now();
        browser.value(&format!(
            "window.vr.send({{kind: 'transfer', points: window.vr.curve.points.map((p) => ({{...p, opacity: p.opacity * {}}}))}})",
            0.8 + 0.2 * f64::from(k % 7) / 6.0
        ));
        std::thread::sleep((2 * PAUSE).saturating_sub(began.elapsed()));
    }
    let stages = browser.value(STAGES);
    shown(&mut browser, "transfer function");
    println!("  milliseconds after the last edit: {stages}");
}
