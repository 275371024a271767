//! Scenes, sessions and clients of the tests.

use std::error::Error;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::DVec3;
use tungstenite::client::IntoClientRequest;
use tungstenite::protocol::WebSocket;
use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid};
use vr_core::rectilinear::Centering;
use vr_core::{
    Calibration, CellMesh, Control, Filter, Frame, GridVolume, Placement, PointKernel, PointSet, RectilinearGrid,
    StudiedRenderer, UniformGrid, Volume,
};
use vr_io::{FileSource, LoadedScene, LoadedVolume, SceneFile, VolumeSource};
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_study::stated::StatedRenderer;
use vr_view::server::{Opening, Server, ServerError};
use vr_view::session::{Document, Labels, Output, PROVEN, Picture, RendererList, Session, Stage, Subject};

/// Time after which a test gives up: many times what anything here takes.
pub const PATIENCE: Duration = Duration::from_secs(60);

pub fn renderers() -> RendererList {
    let all: Vec<Box<dyn StudiedRenderer>> = vec![Box::new(RayCaster::default()), Box::new(ShearWarp::default())];
    RendererList { all, usual: |_| "raycast" }
}

/// A phantom, drawn by the ray caster under a bound, its scene file complete.
pub fn phantom(name: &str, size: usize, pixels: [u32; 2]) -> Subject {
    let mut file = SceneFile::default();
    file.volume.source = Some(VolumeSource::Phantom { name: name.to_owned(), size: Some(size) });
    let volume = vr_io::load_volume(&file.volume, Path::new("")).unwrap();
    let mut subject = around(file, volume, pixels);
    (subject.title, subject.notes) = (format!("phantom {name}"), vec!["a note".to_owned()]);
    subject
}

/// A volume from no file, drawn likewise.
pub fn subject_of(volume: Volume, pixels: [u32; 2]) -> Subject {
    let volume = LoadedVolume { volume, info: None, transfer: None, notes: Vec::new() };
    around(SceneFile::default(), volume, pixels)
}

/// Reads a file as `vr view` does; its title has the whole path.
pub fn read(path: &Path) -> Result<Subject, Box<dyn Error + Send + Sync>> {
    let mut file = SceneFile::default();
    file.volume.source = Some(VolumeSource::File(FileSource { path: path.into(), ..FileSource::default() }));
    let volume = vr_io::load_volume(&file.volume, Path::new(""))?;
    let subject = around(file, volume, [32, 24]);
    Ok(Subject { title: path.display().to_string(), ..subject })
}

/// A grid as NRRD: 8×8×8 voxels of a sum of waves, all of them times a factor.
pub fn nrrd(factor: f32) -> Vec<u8> {
    let wave =
        |i: usize| factor * ((0.9 * (i % 8) as f32).sin() + (0.7 * (i / 8 % 8) as f32).cos() + 0.1 * (i / 64) as f32);
    let head = "NRRD0005\ntype: float\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n";
    head.bytes().chain((0..512).flat_map(|i| wave(i).to_le_bytes())).collect()
}

/// The subject of a scene file around its volume.
fn around(mut file: SceneFile, volume: LoadedVolume, pixels: [u32; 2]) -> Subject {
    file.image.size = pixels;
    let loaded = vr_io::resolve_scene_around(&file, Path::new(""), volume.clone()).unwrap();
    let stated = StatedRenderer::of(&RayCaster::default(), Some(PROVEN));
    let file = file.completed(&loaded.unlabelled, None, &loaded.view, None);
    let file = file.drawn_by(&stated.name, stated.options, stated.max_error);
    Subject { file, volume, mesh: None, title: String::new(), notes: Vec::new(), labels: Labels::default() }
}

pub fn of_volume(volume: Volume, pixels: [u32; 2]) -> Document {
    Document::new(Arc::new(subject_of(volume, pixels)), Arc::new(renderers())).unwrap()
}

/// A volume of every kind.
pub fn kinds() -> Vec<(&'static str, Volume)> {
    let grid = |spacing: [f64; 3], n: usize| {
        let wave =
            |i: usize| (0.7 * (i % n) as f64).sin() + (0.4 * (i / n % n) as f64).cos() - 0.1 * (i / n / n) as f64;
        let voxels: Vec<f32> = (0..n * n * n).map(|i| wave(i) as f32).collect();
        let placement = Placement::from_spacing(spacing).unwrap();
        UniformGrid::new([n; 3], voxels, placement, Calibration { slope: 3.0, intercept: 1.0 }).unwrap()
    };
    let mesh = CellMesh::of_grid(&GridVolume::new(grid([1.0; 3], 5).into(), Filter::Trilinear)).unwrap();
    let positions: Vec<DVec3> =
        (0..60).map(|i| DVec3::new((i % 4) as f64, (i / 4 % 4) as f64, (i / 16) as f64)).collect();
    let values = (0..60).map(|i| 1.0 + (i % 7) as f32).collect();
    let points = PointSet::new(positions, vec![1.1; 60], vec![1.0; 60], values, PointKernel::CubicSpline).unwrap();
    let axes = [vec![0.0, 1.0, 3.0, 4.0], vec![0.0, 0.5, 2.0], vec![0.0, 2.0, 3.0]];
    let uneven = RectilinearGrid::new(axes, (0..36).map(|i| (i * i % 11) as f32).collect(), Centering::Points).unwrap();
    let block = |level, first, dims: [usize; 3]| AmrBlock {
        level,
        first,
        dims,
        values: (0..dims.iter().product()).map(|i: usize| (i * 7 % 13) as f32).collect(),
    };
    let blocks = vec![block(0, [0; 3], [4; 3]), block(1, [0; 3], [4, 8, 8])];
    let amr = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![[2; 3]], blocks, AmrCentring::Cells).unwrap();
    vec![
        ("grid", grid([1.0; 3], 12).into()),
        ("uneven grid", grid([1.0, 2.0, 3.0], 8).into()),
        ("points", points.into()),
        ("mesh of cells", mesh.into()),
        ("rectilinear grid", uneven.into()),
        ("adaptive grid", amr.into()),
    ]
}

pub fn document(name: &str, size: usize, pixels: [u32; 2]) -> Document {
    Document::new(Arc::new(phantom(name, size, pixels)), Arc::new(renderers())).unwrap()
}

/// Picture that `vr render --scene` draws from the text of a scene file: read anew, with nothing kept from any session.
pub fn drawn_anew(text: &str) -> ([u32; 2], Vec<u8>) {
    let (loaded, frame) = frame_anew(text);
    (frame.size(), vr_io::screen_rgba(&frame, loaded.scene.background))
}

/// The same, and its frame in linear light.
pub fn frame_anew(text: &str) -> (LoadedScene, Frame) {
    let file = vr_io::parse_scene(text, Path::new("saved")).unwrap();
    let loaded = vr_io::resolve_scene(&file, Path::new("")).unwrap();
    let name = loaded.renderer.as_deref().unwrap();
    let renderers = renderers().all;
    let renderer = renderers.iter().find(|r| r.name() == name).unwrap().with_options(&loaded.options).unwrap();
    let control = Control::default();
    let prepared = match loaded.max_error {
        Some(error) => renderer.with_max_error(error).unwrap().unwrap().prepare(&loaded.scene, &control),
        None => renderer.prepare(&loaded.scene, &control),
    };
    let frame = prepared.unwrap().render(&loaded.view, &control).unwrap().frame;
    (loaded, frame)
}

/// A session, and what it tells.
pub struct Watched {
    pub session: Session,
    pub told: Receiver<Output>,
}

impl Watched {
    pub fn of(document: Document) -> Self {
        let (tell, told) = channel();
        let control = Control::default().with_threads(2);
        let session = Session::start(document, &control, move |output| drop(tell.send(output))).unwrap();
        Self { session, told }
    }

    /// Waits for something that is told.
    pub fn wait<T>(&self, mut wanted: impl FnMut(&Output) -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let output = self.told.recv_timeout(left).expect("it is told in time");
            if let Output::Problem(reason) = &output {
                panic!("{reason}");
            }
            if let Some(found) = wanted(&output) {
                return found;
            }
        }
    }

    /// Waits for a picture of a stage that shows an edit of client 1.
    pub fn picture(&self, stage: Stage, edit: u64) -> Arc<Picture> {
        self.wait(|output| match output {
            Output::Picture(p) if p.head.stage == stage && p.answers.get(&1).copied().unwrap_or(0) >= edit => {
                Some(p.clone())
            }
            _ => None,
        })
    }
}

/// A server on a thread of its own.
pub struct Running {
    pub address: String,
    pub token: String,
    pub control: Control,
    pub thread: JoinHandle<Result<(), ServerError>>,
}

/// Bytes of a head and of a body, read apart.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

pub type Client = WebSocket<TcpStream>;

impl Running {
    pub fn new(document: Document, stay: bool) -> Self {
        Self::serving(Server::bind(Server::USUAL).unwrap(), document, stay)
    }

    /// One that opens other files: below a folder, and of so many bytes from the page.
    pub fn opening(document: Document, folder: Option<&Path>, max_upload: u64) -> Self {
        let opening = Opening { folder: folder.map(Path::to_owned), max_upload, read: Box::new(read) };
        Self::serving(Server::bind(Server::USUAL).unwrap().with_opening(opening).unwrap(), document, true)
    }

    fn serving(server: Server, document: Document, stay: bool) -> Self {
        let url = server.url();
        let rest = url.strip_prefix("http://").unwrap();
        let (address, token) = rest.split_once('/').unwrap();
        let control = Control::default().with_threads(2);
        let theirs = control.clone();
        let thread = std::thread::spawn(move || server.run(document, &theirs, stay));
        Self { address: address.to_owned(), token: token.trim_end_matches('/').to_owned(), control, thread }
    }

    /// Sends the lines of a request as they are, and reads all of the answer.
    pub fn request(&self, lines: &str) -> Answer {
        self.request_with(lines, &[])
    }

    /// The same with a body.
    pub fn request_with(&self, lines: &str, body: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(stream, "{}\r\nConnection: close\r\n\r\n", lines.replace('\n', "\r\n")).unwrap();
        // The server may answer before it has read all.
        let _ = stream.write_all(body);
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n").expect("an answer has a head");
        let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        Answer { status, head, body: bytes[end + 4..].to_vec() }
    }

    /// A plain `GET` of a path after the token.
    pub fn get(&self, path: &str) -> Answer {
        self.request(&format!("GET /{}/{path} HTTP/1.1\nHost: {}", self.token, self.address))
    }

    /// A `POST` of bytes to a path after the token, as the page does it.
    pub fn post(&self, path: &str, body: &[u8]) -> Answer {
        let (token, address, length) = (&self.token, &self.address, body.len());
        let lines = format!(
            "POST /{token}/{path} HTTP/1.1\nHost: {address}\nOrigin: http://{address}\nContent-Length: {length}"
        );
        self.request_with(&lines, body)
    }

    /// Opens a socket from an origin.
    pub fn connect_from(&self, origin: Option<&str>) -> Result<Client, u16> {
        let mut request = format!("ws://{}/{}/socket", self.address, self.token).into_client_request().unwrap();
        if let Some(origin) = origin {
            request.headers_mut().insert("Origin", origin.parse().unwrap());
        }
        let stream = TcpStream::connect(&self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.set_nodelay(true).unwrap();
        match tungstenite::client(request, stream) {
            Ok((client, _)) => Ok(client),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(e) => panic!("{e}"),
        }
    }

    /// Opens a socket as the page does.
    pub fn connect(&self) -> Client {
        self.connect_from(Some(&format!("http://{}", self.address))).unwrap()
    }

    /// Ends the server, and checks that it ends well.
    pub fn end(self) {
        self.control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
        self.thread.join().unwrap().unwrap();
    }
}

/// Head of a picture's message, and its pixels.
pub fn taken_apart(message: &[u8]) -> (serde_json::Value, &[u8]) {
    let length = u32::from_le_bytes(message[..4].try_into().unwrap()) as usize;
    (serde_json::from_slice(&message[4..4 + length]).unwrap(), &message[4 + length..])
}
