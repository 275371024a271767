//! Times that a person waits for in the page: `cargo build --release --workspace --bins`, then
//! `cargo run --release --workspace --example page_times -- target/release/vr ARGUMENTS OF VR VIEW` in headless Chromium, which must be installed.
//!
//! It starts `vr view` with those arguments, opens its page with a picture of 512² pixels, turns the volume by the mouse, rests, and edits the transfer function. Each line begins
//! with the last argument's file name, so that `docs/measuring/figures.py view --from FILE` reads what several runs have printed.

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
    const { stage, size, full_size: full } = window.vr.status.head, time = performance.now() - start; at[stage] ??= time; \
    if (stage !== 'draft' && size[0] === full[0]) at.whole ??= time; \
    if (window.vr.rests || performance.now() - start > 60000) done(at); else setTimeout(look, 2); }; look(); })";

/// Function of the page that samples the moving picture's sizes and errors.
const SAMPLING: &str = "window.vrSeen = []; window.vrSampling = setInterval(() => { \
    const { stage, size, error, milliseconds, prepare_milliseconds, renderer } = window.vr.status.head; \
    if (stage === 'draft') window.vrSeen.push([size[0], error.rmse ?? null, milliseconds, prepare_milliseconds, renderer]); }, 20)";

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

/// Milliseconds from an edit to its picture since the last call of [`forget`]: the median, and the number below which 95 % lie.
fn waits(browser: &mut Browser) -> String {
    let waits = sorted(&browser.value("window.vr.status.latencies"));
    format!("{:.0} ms, 95 %: {:.0} ms", quantile(&waits, 0.5), quantile(&waits, 0.95))
}

/// Prints the size, the error and the times of the moving pictures that were sampled: medians.
fn print_sampled(browser: &mut Browser, name: &str) {
    let seen = browser.value("(() => { clearInterval(window.vrSampling); return window.vrSeen; })()");
    let column = |k: usize| sorted(&seen.as_array().into_iter().flatten().map(|row| row[k].clone()).collect());
    let [sides, errors, times, renewals] = [0, 1, 2, 3].map(column);
    let renderer = &seen[seen.as_array().map_or(0, Vec::len) / 2][4];
    println!("{name} {} pixels wide, RMSE {:.1e}", quantile(&sides, 0.5), quantile(&errors, 0.5));
    let renderer = renderer.as_str().unwrap_or("nothing");
    println!(
        "{name} drawn by {renderer} in {:.0} ms, prepared in {:.0} ms",
        quantile(&times, 0.5),
        quantile(&renewals, 0.5)
    );
}

/// Processes that ran or waited for a processor, in the mean of the last minute; `None` where the system does not tell.
fn load() -> Option<String> {
    let loads = std::fs::read_to_string("/proc/loadavg").ok()?;
    loads.split(' ').next().map(str::to_owned)
}

/// Discards the page's times of pictures shown so far.
fn forget(browser: &mut Browser) {
    browser.value("(() => { window.vr.status.latencies.length = 0; window.vr.status.shown.length = 0; })()");
}

fn main() {
    let mut arguments = std::env::args_os().skip(1);
    let last = std::env::args().next_back().unwrap_or_default();
    let name = last.rsplit('/').next().unwrap_or_default();
    if let Some(load) = load() {
        println!("{name}: load {load} before");
    }
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
    let first = start.elapsed().as_secs_f64();
    println!("{name}: first picture after {first:.2} s, listening after {:.2} s", listening.as_secs_f64());

    // Make the picture as large as is asked for.
    let [_, _, width, height] = place(&mut browser);
    let size = [900.0 + SIDE - width, 640.0 + SIDE - height];
    let metrics = json!({"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": false});
    browser.call("Emulation.setDeviceMetricsOverride", metrics);
    browser.wait("window.vr.picture.size.every((n, k) => n === window.vr.status.head.full_size[k])");
    browser.value(STAGES);

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
    let rate = browser.value("window.vr.status.rate()").as_f64().unwrap_or(f64::NAN);
    println!("{name}: {rate:.0} pictures a second in an orbit");
    println!("{name}: move to picture {}", waits(&mut browser));
    print_sampled(&mut browser, &format!("{name}: pictures"));
    for (stage, word) in [("whole", "all pixels"), ("sharp", "sharp"), ("measured", "measured"), ("proven", "proven")] {
        // Stages that were not reached are left out.
        if let Some(time) = stages[stage].as_f64() {
            println!("{name}: {word} after {time:.0} ms");
        }
    }

    // Edit the transfer function.
    browser.wait("window.vr.rests");
    forget(&mut browser);
    browser.value(SAMPLING);
    for k in 0..EDITS {
        let began = Instant::now();
        browser.value(&format!(
            "window.vr.send({{kind: 'transfer', points: window.vr.curve.points.map((p) => ({{...p, opacity: p.opacity * {}}}))}})",
            0.8 + 0.2 * f64::from(k % 7) / 6.0
        ));
        std::thread::sleep((2 * PAUSE).saturating_sub(began.elapsed()));
    }
    // The last picture is waited for.
    browser.value("new Promise((done) => setTimeout(done, 500))");
    println!("{name}: edit to picture {}", waits(&mut browser));
    print_sampled(&mut browser, &format!("{name}: edited pictures"));
}
