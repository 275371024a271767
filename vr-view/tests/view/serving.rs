//! The server with a page that behaves: files, pictures, edits, and the end.

use std::time::{Duration, Instant};

use serde_json::Value;
use tungstenite::Message;

use crate::common::{Client, PATIENCE, Running, document, drawn_anew, taken_apart};

/// Waits for a picture at rest that shows an edit, and returns its head and pixels; words on the way are collected.
fn picture(client: &mut Client, stage: &str, edit: u64, words: &mut Vec<Value>) -> (Value, Vec<u8>) {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        match client.read().unwrap() {
            Message::Binary(bytes) => {
                let (head, pixels) = taken_apart(&bytes);
                if head["stage"] == stage && head["answers"].as_u64().unwrap() >= edit {
                    return (head, pixels.to_vec());
                }
            }
            Message::Text(text) => words.push(serde_json::from_str(&text).unwrap()),
            _ => {}
        }
    }
    panic!("no picture in time");
}

fn edit(client: &mut Client, number: u64, edit: &str) {
    client.send(Message::text(format!(r#"{{"number": {number}, "edit": {edit}}}"#))).unwrap();
}

#[test]
fn a_page_is_served_and_told_everything() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    for (path, kind, part) in [
        ("", "text/html", "<canvas"),
        ("app.js", "text/javascript", "import"),
        ("style.css", "text/css", "--accent"),
        ("icon.svg", "image/svg+xml", "<svg"),
    ] {
        let answer = running.get(path);
        assert!(
            answer.status == 200 && answer.head.to_lowercase().contains(&format!("content-type: {kind}")),
            "{path}"
        );
        assert!(String::from_utf8(answer.body).unwrap().contains(part), "{path}");
    }
    let mut client = running.connect();
    let mut words = Vec::new();
    let (head, pixels) = picture(&mut client, "proven", 0, &mut words);
    assert_eq!((&head["size"], head["coding"].as_str()), (&serde_json::json!([40, 30]), Some("rgba")));
    assert_eq!(pixels.len(), 4 * 40 * 30);
    while !words.iter().any(|w| w["kind"] == "opened") {
        if let Message::Text(text) = client.read().unwrap() {
            words.push(serde_json::from_str(&text).unwrap());
        }
    }
    let of = |kind: &str| words.iter().find(|w| w["kind"] == kind).unwrap_or_else(|| panic!("{kind} in {words:?}"));
    assert_eq!(of("hello")["version"], env!("CARGO_PKG_VERSION"));
    let opened = &of("opened")["opened"];
    assert_eq!((opened["title"].as_str(), &opened["notes"]), (Some("phantom blobs"), &serde_json::json!(["a note"])));
    let counted: u64 = opened["histogram"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(counted, 16 * 16 * 16);
    let state = &of("state")["state"];
    assert_eq!((state["quality"].as_str(), state["render"]["renderer"].as_str()), (Some("proven"), Some("raycast")));
    running.end();
}

#[test]
fn what_is_saved_is_what_is_shown() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let mut client = running.connect();
    edit(&mut client, 1, r#"{"kind": "size", "size": [61, 47]}"#);
    edit(&mut client, 2, r#"{"kind": "orbit", "right": 25, "up": 10}"#);
    edit(&mut client, 3, r#"{"kind": "preset", "name": "inferno"}"#);
    let (_, shown) = picture(&mut client, "proven", 3, &mut Vec::new());
    let scene = running.get("save/scene.toml");
    assert!(scene.head.contains("attachment; filename=\"scene.toml\""), "{}", scene.head);
    let (size, rgba) = drawn_anew(&String::from_utf8(scene.body).unwrap());
    assert!(size == [61, 47] && rgba == shown);
    let rgb: Vec<u8> = rgba.chunks(4).flat_map(|p| p[..3].to_vec()).collect();
    let decoded = |bytes: &[u8]| image::load_from_memory(bytes).unwrap();
    let png = decoded(&running.get("save/picture.png").body);
    assert!((png.width(), png.height()) == (61, 47) && png.to_rgb8().into_raw() == rgb);
    let large = decoded(&running.get("save/picture.png?width=200&height=100").body);
    assert_eq!((large.width(), large.height()), (200, 100));
    let exr = running.get("save/picture.exr");
    assert_eq!(exr.body[..4], [0x76, 0x2f, 0x31, 0x01]);
    let map = running.get("save/transfer.json");
    let maps = vr_io::parse_color_maps(std::str::from_utf8(&map.body).unwrap(), "map.json".as_ref()).unwrap();
    assert_eq!(maps.len(), 1);
    for (path, status) in [
        ("save/passwd", 404),
        ("save/picture.png?width=0&height=5", 422),
        ("save/picture.png?width=60000&height=60000", 422),
    ] {
        assert_eq!(running.get(path).status, status, "{path}");
    }
    running.end();
}

#[test]
fn an_error_map_is_told_when_asked_for() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let answer = running.get("truth/error-map");
    assert!(answer.status == 200 && answer.head.to_lowercase().contains("content-type: application/json"));
    let map: Value = serde_json::from_slice(&answer.body).unwrap();
    assert_eq!((&map["size"], &map["parts"]), (&serde_json::json!([40, 30]), &serde_json::json!([40, 30])));
    // So small a picture is compared whole.
    for list in ["pixels", "errors", "colors"] {
        assert_eq!(map[list].as_array().unwrap().len(), 40 * 30, "{list}");
    }
    let errors = map["errors"].as_array().unwrap().iter().map(|e| e.as_f64().unwrap());
    let max = map["max"].as_f64().unwrap();
    assert!(max > 0.0 && max <= 4e-3 && errors.fold(0.0, f64::max) == max, "{max}");
    assert_eq!(running.get("truth/else").status, 404);
    let wrong =
        running.request(&format!("GET /{}/truth/error-map HTTP/1.1\nHost: {}", "0".repeat(32), running.address));
    assert_eq!(wrong.status, 404);
    running.end();
}

#[test]
fn a_ray_is_told_when_asked_for() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let answer = running.get("truth/ray?x=20&y=15");
    assert!(answer.status == 200 && answer.head.to_lowercase().contains("content-type: application/json"));
    let plot: Value = serde_json::from_slice(&answer.body).unwrap();
    assert_eq!((&plot["pixel"], &plot["size"]), (&serde_json::json!([20, 15]), &serde_json::json!([40, 30])));
    let [drawn, exact] = ["rgba", "exact"].map(|key| plot[key][3].as_f64().unwrap());
    assert!((drawn - exact).abs() <= 4e-3 && exact > 0.0, "{drawn} {exact}");
    assert!(plot["parts"].as_array().unwrap().len() > 100 && plot["parts"][0]["ends"].is_array());
    let refused = running.get("truth/ray?x=40&y=15");
    assert_eq!((refused.status, refused.body.starts_with(b"pixel")), (422, true));
    for path in ["truth/ray", "truth/ray?x=1", "truth/ray?x=-1&y=1", "truth/ray?x=1&y=1&z=1"] {
        assert_eq!(running.get(path).status, 400, "{path}");
    }
    running.end();
}

#[test]
fn a_second_picture_is_told_when_asked_for() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let answer = running.get("truth/second?renderer=shearwarp");
    assert!(answer.status == 200 && answer.head.to_lowercase().contains("content-type: application/octet-stream"));
    let (head, pixels) = taken_apart(&answer.body);
    assert_eq!((&head["renderer"], &head["size"]), (&"shearwarp".into(), &serde_json::json!([40, 30])));
    assert!(head["error"]["kind"] == "measured" && head["milliseconds"].as_f64().unwrap() > 0.0, "{head}");
    assert!(pixels.len() == 4 * 40 * 30 && pixels.chunks(4).any(|p| p != &pixels[..4]));
    let refused = running.get("truth/second?renderer=oil");
    assert!(refused.status == 422 && String::from_utf8(refused.body).unwrap().contains("oil"));
    for path in ["truth/second", "truth/second?renderer=raycast&quality=best", "truth/second?renderer=raycast&more=1"] {
        assert_eq!(running.get(path).status, 400, "{path}");
    }
    running.end();
}

#[test]
fn two_pages_see_each_others_edits() {
    let running = Running::new(document("fog", 8, [16, 16]), true);
    let (mut one, mut other) = (running.connect(), running.connect());
    picture(&mut one, "proven", 0, &mut Vec::new());
    picture(&mut other, "proven", 0, &mut Vec::new());
    edit(&mut one, 7, r#"{"kind": "background", "color": [0, 0, 1]}"#);
    let mut words = Vec::new();
    picture(&mut one, "proven", 7, &mut words);
    let by = |words: &[Value]| words.iter().rev().find(|w| w["kind"] == "state").map(|w| w["state"]["by"].clone());
    let told = by(&words).unwrap();
    // The other page numbers its own edits, of which there are none.
    let end = Instant::now() + PATIENCE;
    let mut words = Vec::new();
    loop {
        let (head, pixels) = picture(&mut other, "proven", 0, &mut words);
        assert!(head["answers"] == 0 && Instant::now() < end);
        if pixels[..3] == [0, 0, 255] || by(&words) == Some(told.clone()) {
            break;
        }
    }
    assert_eq!(told[1], 7);
    running.end();
}

#[test]
fn it_ends_when_the_last_page_is_closed_and_a_reload_is_no_end() {
    let running = Running::new(document("fog", 8, [16, 16]), false);
    // Nothing ends before the first page came.
    std::thread::sleep(Duration::from_millis(300));
    let mut client = running.connect();
    picture(&mut client, "proven", 0, &mut Vec::new());
    client.close(None).unwrap();
    drop(client);
    std::thread::sleep(Duration::from_millis(500));
    let mut again = running.connect();
    picture(&mut again, "proven", 0, &mut Vec::new());
    std::thread::sleep(Duration::from_millis(3500));
    assert!(!running.thread.is_finished(), "a page is there");
    drop(again);
    let closed = Instant::now();
    running.thread.join().unwrap().unwrap();
    assert!(closed.elapsed() > Duration::from_secs(2) && closed.elapsed() < Duration::from_secs(20));
}

#[test]
fn it_stays_when_told_to_and_says_goodbye() {
    let running = Running::new(document("fog", 8, [16, 16]), true);
    drop(running.connect());
    std::thread::sleep(Duration::from_millis(3800));
    assert!(!running.thread.is_finished());
    let mut client = running.connect();
    picture(&mut client, "proven", 0, &mut Vec::new());
    let start = Instant::now();
    running.end();
    // Ctrl-C has little patience.
    assert!(start.elapsed() < Duration::from_millis(400), "{:?}", start.elapsed());
    let mut last = Value::Null;
    while let Ok(message) = client.read() {
        if let Message::Text(text) = message {
            last = serde_json::from_str(&text).unwrap();
        }
    }
    assert_eq!(last["kind"], "bye");
}

#[test]
fn a_page_that_says_what_it_has_shown_is_sent_no_more_than_two_pictures_ahead() {
    let running = Running::new(document("blobs", 16, [40, 30]), true);
    let mut client = running.connect();
    let mut words = Vec::new();
    picture(&mut client, "proven", 0, &mut words);
    client.send(Message::text(r#"{"shown": 0}"#)).unwrap();
    for number in 1..=20 {
        edit(&mut client, number, r#"{"kind": "orbit", "right": 3, "up": 1}"#);
        std::thread::sleep(Duration::from_millis(40));
    }
    // What is refused is answered at once, and tells that all pictures before it have come.
    client.send(Message::text("nonsense")).unwrap();
    let mut numbers = Vec::new();
    loop {
        match client.read().unwrap() {
            Message::Binary(bytes) => numbers.push(taken_apart(&bytes).0["picture"].as_u64().unwrap()),
            Message::Text(text) if text.contains("refused") => break,
            _ => {}
        }
    }
    assert_eq!(numbers.len(), 2, "{numbers:?}");
    // Nothing is lost by that: the last picture of all comes when these are shown.
    for shown in numbers {
        client.send(Message::text(format!(r#"{{"shown": {shown}}}"#))).unwrap();
    }
    let end = Instant::now() + PATIENCE;
    let is_last = |head: &Value| head["stage"] == "proven" && head["answers"] == 20;
    loop {
        assert!(Instant::now() < end, "no picture in time");
        let Message::Binary(bytes) = client.read().unwrap() else { continue };
        let (head, _) = taken_apart(&bytes);
        if is_last(&head) {
            break;
        }
        client.send(Message::text(format!(r#"{{"shown": {}}}"#, head["picture"]))).unwrap();
    }
    running.end();
}
