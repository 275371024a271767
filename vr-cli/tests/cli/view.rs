//! `vr view`, from end to end.
#![cfg(feature = "view")]

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

use crate::harness::Vr;

/// Time for a small picture on a machine that does other work.
const PATIENCE: Duration = Duration::from_secs(60);

/// Program that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A single thread draws: the server needs none of those that do.
#[test]
fn one_thread_draws_up_to_the_proven_picture() {
    let vr = Vr::new();
    let arguments = "view --phantom blobs --phantom-size 16 --size 24x20 --threads 1 --no-open --stay";
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let mut program = Running(vr.command(&arguments).stdout(Stdio::piped()).spawn().unwrap());
    let mut lines = BufReader::new(program.0.stdout.take().unwrap()).lines().map_while(Result::ok);
    let opened = lines.find(|line| line.starts_with("open ")).expect("it says where it listens");
    let address = opened[opened.find("http://").unwrap()..].trim().to_owned();

    let host = address["http://".len()..].split('/').next().unwrap().to_owned();
    let mut request = format!("{}socket", address.replacen("http", "ws", 1)).into_client_request().unwrap();
    request.headers_mut().insert("Origin", format!("http://{host}").parse().unwrap());
    let stream = TcpStream::connect(&host).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let (mut client, _) = tungstenite::client(request, stream).unwrap();
    let end = Instant::now() + PATIENCE;
    loop {
        assert!(Instant::now() < end, "no proven picture in time");
        if let Message::Binary(bytes) = client.read().unwrap() {
            // A picture's head is JSON, behind its length.
            let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
            let head = std::str::from_utf8(&bytes[4..4 + length]).unwrap();
            if head.contains(r#""stage":"proven""#) {
                return;
            }
        }
    }
}
