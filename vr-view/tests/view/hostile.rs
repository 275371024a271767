//! The server with those who mean no good: other pages, floods, and clients that take nothing.

use std::io::Write;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::Message;
use vr_view::message::MAX_MESSAGE;
use vr_view::server::MAX_CLIENTS;

use crate::common::{Client, PATIENCE, Running, document};

fn running() -> Running {
    Running::new(document("fog", 8, [24, 24]), true)
}

/// Reads until a word of a kind comes; `None` at the end of the connection.
fn word(client: &mut Client, kind: &str) -> Option<serde_json::Value> {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        match client.read() {
            Ok(Message::Text(text)) => {
                let word: serde_json::Value = serde_json::from_str(&text).unwrap();
                if word["kind"] == kind {
                    return Some(word);
                }
            }
            Ok(Message::Close(_)) | Err(_) => return None,
            Ok(_) => {}
        }
    }
    panic!("nothing in time");
}

/// Code with which the server closes a connection; `None` where it is cut without one.
fn close_code(client: &mut Client) -> Option<u16> {
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        match client.read() {
            Ok(Message::Close(frame)) => return frame.map(|frame| frame.code.into()),
            Err(_) => return None,
            Ok(_) => {}
        }
    }
    panic!("it is not closed");
}

/// True if a page that behaves is served.
fn serves(running: &Running) -> bool {
    let mut client = running.connect();
    client.send(Message::text(r#"{"number": 3, "edit": {"kind": "orbit", "right": 1, "up": 0}}"#)).unwrap();
    let end = Instant::now() + PATIENCE;
    while Instant::now() < end {
        if let Message::Binary(bytes) = client.read().unwrap()
            && crate::common::taken_apart(&bytes).0["answers"] == 3
        {
            return true;
        }
    }
    false
}

#[test]
fn nothing_is_told_without_the_token() {
    let running = running();
    let host = &running.address;
    for path in ["/", "/index.html", "/socket", "/save/scene.toml", "/0/", "/../", "//", "/%2e%2e/", "/favicon.ico"] {
        let answer = running.request(&format!("GET {path} HTTP/1.1\nHost: {host}"));
        let text = String::from_utf8(answer.body).unwrap();
        assert!(answer.status == 404 && !text.contains(&running.token) && !text.contains("canvas"), "{path}: {text}");
        assert!(!answer.head.contains(&running.token), "{path}");
    }
    let wrong = format!("{}0", &running.token[..31]);
    let answer = running.request(&format!("GET /{wrong}/ HTTP/1.1\nHost: {host}"));
    assert!(answer.status == 404 || wrong == running.token);
    for method in ["POST", "PUT", "DELETE", "OPTIONS"] {
        let answer =
            running.request(&format!("{method} /{}/ HTTP/1.1\nHost: {host}\nContent-Length: 0", running.token));
        // Requests that may change something are refused where they do not say where they come from.
        assert_eq!(answer.status, if method == "OPTIONS" { 405 } else { 403 }, "{method}");
    }
    // Only files of the page are files.
    for path in ["../Cargo.toml", "%2e%2e/Cargo.toml", "..%2fCargo.toml", "etc/passwd", "save/../app.js", "app.js/"] {
        assert_eq!(running.get(path).status, 404, "{path}");
    }
    running.end();
}

#[test]
fn other_names_and_other_pages_are_refused() {
    let running = running();
    let (token, address) = (&running.token, &running.address);
    let port = address.rsplit_once(':').unwrap().1;
    let with = |headers: &str| running.request(&format!("GET /{token}/ HTTP/1.1\n{headers}")).status;
    assert_eq!(with(&format!("Host: {address}")), 200);
    assert_eq!(with(&format!("Host: localhost:{port}")), 200);
    // A name that leads here (DNS rebinding), another port, none, and two.
    for wrong in [
        format!("Host: evil.example:{port}"),
        "Host: 127.0.0.1:1".to_owned(),
        "Host: localhost".to_owned(),
        format!("Host: {address}\nHost: {address}"),
        format!("Host: {address}\nOrigin: http://evil.example"),
        format!("Host: {address}\nOrigin: null"),
        format!("Host: {address}\nOrigin: http://localhost:{port}"),
    ] {
        assert!([400, 403].contains(&with(&wrong)), "{wrong}");
    }
    assert_eq!(with(&format!("Host: {address}\nOrigin: http://{address}")), 200);
    for origin in [None, Some("http://evil.example"), Some("null"), Some("https://127.0.0.1"), Some("file://")] {
        assert_eq!(running.connect_from(origin).err(), Some(403), "{origin:?}");
    }
    assert!(running.connect_from(Some(&format!("http://{address}"))).is_ok());
    running.end();
}

#[test]
fn every_answer_keeps_other_pages_out() {
    let running = running();
    for answer in [
        running.get(""),
        running.get("app.js"),
        running.get("no-such"),
        running.request(&format!("GET / HTTP/1.1\nHost: {}", running.address)),
    ] {
        let head = answer.head.to_lowercase();
        for part in [
            "content-security-policy: default-src 'none'; script-src 'self'",
            "frame-ancestors 'none'",
            "x-content-type-options: nosniff",
            "x-frame-options: deny",
            "referrer-policy: no-referrer",
            "cross-origin-resource-policy: same-origin",
            "cache-control: no-store",
        ] {
            assert!(head.contains(part), "{part} in {head}");
        }
        assert!(!head.contains("access-control-allow") && !head.contains("unsafe"), "{head}");
    }
    running.end();
}

#[test]
fn messages_without_sense_are_answered_and_then_ended() {
    let running = running();
    let mut client = running.connect();
    for nonsense in [
        "",
        "{",
        "[]",
        r#"{"number": 1}"#,
        r#"{"number": -1, "edit": {"kind": "fit"}}"#,
        r#"{"number": 1, "edit": {"kind": "rm"}}"#,
    ] {
        client.send(Message::text(nonsense)).unwrap();
        let refused = word(&mut client, "refused").expect("it is answered");
        assert!(
            refused["number"].is_null() && refused["reason"].as_str().unwrap().starts_with("message: "),
            "{refused}"
        );
    }
    // An edit that makes no sense is no message without sense.
    client.send(Message::text(r#"{"number": 5, "edit": {"kind": "unit-distance", "length": -1}}"#)).unwrap();
    let refused = word(&mut client, "refused").unwrap();
    assert!(refused["number"] == 5 && refused["reason"].as_str().unwrap().contains("unit_distance"), "{refused}");
    // Deep nesting, and bytes.
    client.send(Message::text("[".repeat(100_000))).unwrap();
    assert!(word(&mut client, "refused").is_some());
    client.send(Message::binary(vec![0; 1000])).unwrap();
    assert!(word(&mut client, "refused").is_some());
    for _ in 0..20 {
        let _ = client.send(Message::text("nonsense"));
    }
    assert_eq!(close_code(&mut client), Some(1008));
    assert!(serves(&running));
    running.end();
}

#[test]
fn large_messages_and_floods_are_ended() {
    let running = running();
    let mut client = running.connect();
    let padded = |size: usize| {
        let head = r#"{"number": 1, "edit": {"kind": "fit"}"#;
        format!("{head}{}}}", " ".repeat(size - head.len() - 1))
    };
    client.send(Message::text(padded(MAX_MESSAGE))).unwrap();
    client.send(Message::text(r#"{"number": 2, "edit": {"kind": "undo"}}"#)).unwrap();
    assert_eq!(word(&mut client, "refused").expect("the large one was read")["number"], 2);
    // The server may end before all of it is sent.
    let _ = client.send(Message::text(padded(MAX_MESSAGE + 1)));
    assert!(word(&mut client, "refused").is_none());
    let mut client = running.connect();
    let mut sent = 0;
    while sent < 20_000
        && client.send(Message::text(r#"{"number": 1, "edit": {"kind": "gesture", "begins": true}}"#)).is_ok()
    {
        sent += 1;
    }
    assert!(matches!(close_code(&mut client), Some(1008) | None), "a flood is ended");
    assert!(serves(&running));
    running.end();
}

#[test]
fn there_are_seats_for_a_few() {
    let running = running();
    let mut clients: Vec<Client> = (0..MAX_CLIENTS).map(|_| running.connect()).collect();
    let origin = format!("http://{}", running.address);
    assert_eq!(running.connect_from(Some(&origin)).err(), Some(503));
    // Connections that ask for nothing take no seat, and hold up none of the others.
    let idle: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(&running.address).unwrap()).collect();
    assert_eq!(running.get("").status, 200);
    drop(clients.pop());
    let end = Instant::now() + PATIENCE;
    while running.connect_from(Some(&origin)).is_err() {
        assert!(Instant::now() < end, "a seat is free again");
        std::thread::sleep(Duration::from_millis(20));
    }
    drop((clients, idle));
    running.end();
}

#[test]
fn a_client_that_takes_nothing_holds_up_none_of_the_others() {
    // Pictures of 3 MB: a connection's buffers hold few of them.
    let running = Running::new(document("fog", 8, [1000, 800]), true);
    let slow = running.connect();
    let mut quick = running.connect();
    let start = Instant::now();
    let mut worst = Duration::ZERO;
    for number in 1..=60u64 {
        let sent = Instant::now();
        let text = format!(r#"{{"number": {number}, "edit": {{"kind": "orbit", "right": 3, "up": 0}}}}"#);
        quick.send(Message::text(text)).unwrap();
        loop {
            if let Message::Binary(bytes) = quick.read().unwrap()
                && crate::common::taken_apart(&bytes).0["answers"].as_u64().unwrap() >= number
            {
                break;
            }
        }
        worst = worst.max(sent.elapsed());
    }
    assert!(worst < Duration::from_secs(3) && start.elapsed() < Duration::from_secs(30), "{worst:?}");
    drop(slow);
    running.end();
}

#[test]
fn half_a_request_and_rubbish_are_no_end() {
    let running = running();
    let mut half = TcpStream::connect(&running.address).unwrap();
    write!(half, "GET /{}/ HTTP/1.1\r\nHost: ", running.token).unwrap();
    let mut rubbish = TcpStream::connect(&running.address).unwrap();
    rubbish.write_all(&[0xff; 4096]).unwrap();
    let long = running.request(&format!(
        "GET /{}/ HTTP/1.1\nHost: {}\nX: {}",
        running.token,
        running.address,
        "x".repeat(1 << 15)
    ));
    assert!([200, 431].contains(&long.status));
    assert!(serves(&running));
    drop((half, rubbish));
    running.end();
}
