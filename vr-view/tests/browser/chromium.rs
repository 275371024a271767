//! A browser without a screen, steered through the DevTools protocol.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::Message;
use tungstenite::protocol::WebSocket;

/// Time after which a test gives up.
const PATIENCE: Duration = Duration::from_secs(90);

/// Program and profile of a browser, and the socket that steers it.
pub struct Browser {
    child: Child,
    socket: WebSocket<TcpStream>,
    number: u64,
    session: String,
    /// What the page has complained of: exceptions, and entries of its log.
    pub complaints: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Browser {
    /// Starts a browser; `None`, with a word, where there is none.
    pub fn start() -> Option<Self> {
        let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
        let paths = std::env::var_os("PATH").unwrap_or_default();
        let found =
            std::env::split_paths(&paths).flat_map(|folder| names.map(|name| folder.join(name))).find(|p| p.is_file());
        let Some(program): Option<PathBuf> = found else {
            println!("skipped: no Chromium is installed (vr-view/README.md says how to install one)");
            return None;
        };
        let profile = tempfile::tempdir().unwrap();
        let mut child = Command::new(program)
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--remote-debugging-port=0"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg("about:blank")
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let address =
            lines.find_map(|line| line.unwrap().split_once("DevTools listening on ").map(|(_, a)| a.to_owned()));
        // The rest of what it says is read, so that it never waits.
        std::thread::spawn(move || lines.for_each(drop));
        let address = address.expect("it says where it listens");
        let host = address.strip_prefix("ws://").unwrap().split('/').next().unwrap().to_owned();
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let socket = tungstenite::client(address, stream).unwrap().0;
        let mut browser =
            Self { child, socket, number: 0, session: String::new(), complaints: Vec::new(), _profile: profile };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}))["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({"targetId": target, "flatten": true}));
        browser.session = attached["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Log"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// Calls a method, and waits for its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let mut message = json!({"id": self.number, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = self.session.clone().into();
        }
        self.socket.send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().expect("the browser answers") else { continue };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            match answer["method"].as_str() {
                Some("Runtime.exceptionThrown") => {
                    self.complaints.push(answer["params"]["exceptionDetails"].to_string())
                }
                // Reading the canvas back is a habit of tests, not of the page.
                Some("Log.entryAdded") if answer["params"]["entry"]["source"] == "rendering" => {}
                Some("Log.entryAdded") => self.complaints.push(answer["params"]["entry"].to_string()),
                _ => {}
            }
            if answer["id"] == self.number {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
        }
    }

    /// Shows a page of a size in CSS pixels, in a theme.
    pub fn open(&mut self, address: &str, [width, height]: [u32; 2], scheme: &str) {
        let metrics = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", metrics);
        self.call(
            "Emulation.setEmulatedMedia",
            json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]}),
        );
        self.call("Page.navigate", json!({"url": address}));
    }

    /// Value of an expression in the page; a promise is waited for.
    pub fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let mut result = self.call("Runtime.evaluate", parameters);
        assert!(result["exceptionDetails"].is_null(), "{expression}: {}", result["exceptionDetails"]);
        result["result"]["value"].take()
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str) {
        let end = Instant::now() + PATIENCE;
        while self.value(expression) != true {
            let status = self.value("document.getElementById('status')?.innerText ?? ''");
            assert!(Instant::now() < end, "{expression} is never true; the page says {status}; {:?}", self.complaints);
            std::thread::sleep(Duration::from_millis(25));
        }
    }

    /// Tells of a mouse.
    pub fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], more: Value) {
        let mut parameters = json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": 1});
        parameters.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        self.call("Input.dispatchMouseEvent", parameters);
    }

    /// Drags from one place to another in steps.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2], steps: u32, button: &str) {
        let buttons = if button == "right" { 2 } else { 1 };
        let more = json!({"button": button, "buttons": buttons, "clickCount": 1});
        self.mouse("mousePressed", from, more.clone());
        for i in 1..=steps {
            let t = f64::from(i) / f64::from(steps);
            self.mouse("mouseMoved", [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])], more.clone());
            std::thread::sleep(Duration::from_millis(8));
        }
        self.mouse("mouseReleased", to, json!({"button": button, "buttons": 0, "clickCount": 1}));
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str, modifiers: u32) {
        let text = if key.len() == 1 && modifiers & 2 == 0 { key } else { "" };
        for kind in ["keyDown", "keyUp"] {
            self.call(
                "Input.dispatchKeyEvent",
                json!({"type": kind, "key": key, "text": text, "modifiers": modifiers}),
            );
        }
    }

    /// The page as PNG.
    pub fn screenshot(&mut self) -> Vec<u8> {
        use base64::Engine;
        let shot = self.call("Page.captureScreenshot", json!({"format": "png"}));
        base64::engine::general_purpose::STANDARD.decode(shot["data"].as_str().unwrap()).unwrap()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
