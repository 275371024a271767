//! Program: a session before one page, without a network.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use vr_core::Control;
use vr_core::clock::Instant;
use vr_core::parallel::locked;
use vr_io::MemoryFolder;
use vr_view::message::{Coding, Request, Told, VERSION, picture_message};
use vr_view::question::{Answer, Question, read};
use vr_view::session::{ClientId, Document, Output as Said, Painter, Session, Step};
use vr_view::upload::{BeginQuery, Begun, Listing, NameQuery, PieceQuery, UploadError, Uploads, check_name};

use crate::files::Files;
use crate::renderers::renderers;
use crate::subject::{BeginError, opened, phantom};

/// The page, of which there is one.
const CLIENT: ClientId = 1;
/// Volume that the page begins with, and its voxels along a side.
const PHANTOM: (&str, usize) = ("hydrogen", 64);
/// Most bytes of files that are opened: they and the volume made of them fit four times into what a module can address.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Message to the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Output {
    /// Words, as a socket would carry them.
    Text(String),
    /// A picture, as a socket would carry it.
    Bytes(Vec<u8>),
}

/// Session before a page: messages in, messages out, and questions with their answers.
pub struct Program {
    session: Session,
    painter: Painter,
    said: Arc<Mutex<VecDeque<Said>>>,
    outputs: Vec<Output>,
    uploads: Uploads<Files>,
    /// Number of uploads so far.
    begun: u64,
}

impl Program {
    /// Begins with a phantom. `interrupted` is asked while something is drawn, and is true if a message waits that makes it stale.
    ///
    /// # Errors
    /// A scene that cannot be made.
    pub fn begin(interrupted: impl Fn() -> bool + Send + Sync + 'static) -> Result<Self, BeginError> {
        let document = Document::new(Arc::new(phantom(PHANTOM.0, PHANTOM.1)?), Arc::new(renderers()))?;
        let said = Arc::new(Mutex::new(VecDeque::new()));
        let saying = Arc::clone(&said);
        let (session, painter) =
            Session::without_thread(document, interrupted, move |output| locked(&saying).push_back(output));
        let outputs = vec![
            Output::Text(Told::Hello { client: CLIENT, version: VERSION }.text()),
            Output::Text(Told::State { state: &session.state() }.text()),
            Output::Text(Told::Opened { opened: &session.opened() }.text()),
        ];
        Ok(Self { session, painter, said, outputs, uploads: Uploads::new(MAX_FILE_BYTES), begun: 0 })
    }

    /// Takes a message of the page: an edit.
    pub fn receive(&mut self, text: &str) {
        let refused = match Request::read(text) {
            Ok(Request { number, edit }) => match self.session.apply(CLIENT, number, &edit) {
                Ok(()) => return,
                Err(e) => Told::Refused { number: Some(number), reason: e.to_string() },
            },
            Err(refused) => refused,
        };
        self.outputs.push(Output::Text(refused.text()));
    }

    /// Draws one stage, if one is due. Returns the milliseconds to wait before the next step; negative if nothing is left to do before a message comes.
    pub fn step(&mut self) -> f64 {
        match self.painter.step() {
            Step::Worked => 0.0,
            Step::Wait(time) => 1e3 * time.as_secs_f64(),
            Step::Idle => -1.0,
        }
    }

    /// Takes what was said since this was last called, in order.
    pub fn outputs(&mut self) -> Vec<Output> {
        let mut outputs = std::mem::take(&mut self.outputs);
        let said = std::mem::take(&mut *locked(&self.said));
        outputs.extend(said.iter().map(|said| match said {
            Said::Picture(picture) => Output::Bytes(picture_message(picture, CLIENT, Coding::Rgba)),
            Said::Volume => Output::Text(Told::Opened { opened: &self.session.opened() }.text()),
            said => Output::Text(Told::of(said).map(|told| told.text()).unwrap_or_default()),
        }));
        outputs
    }

    /// Answers what a server would be asked at an address, which has no slash before it.
    pub fn ask(&mut self, method: &str, address: &str, body: &[u8]) -> Answer {
        let (path, query) = address.split_once('?').unwrap_or((address, ""));
        let parts: Vec<&str> = path.split('/').collect();
        let answered = match (method, &parts[..]) {
            ("GET", ["files"]) => Ok(Answer::json(&Listing {
                opens: true,
                has_folder: false,
                files: Vec::new(),
                max_upload: MAX_FILE_BYTES,
            })),
            ("POST", ["upload"]) => read(query).and_then(|BeginQuery { bytes }| {
                self.begun += 1;
                let id = self.begun.to_string();
                self.uploads.begin(id.clone(), bytes, Instant::now()).map_err(in_words)?;
                Ok(Answer::json(&Begun { id }))
            }),
            ("POST", ["upload", id]) => read(query).and_then(|PieceQuery { name, offset }| {
                self.uploads.piece(id, &name, offset, body, Instant::now()).map_err(in_words)?;
                Ok(done())
            }),
            ("DELETE", ["upload", id]) => self.uploads.end(id).map(|_| done()).map_err(in_words),
            ("POST", ["upload", id, "open"]) => read(query).and_then(|NameQuery { name }| self.open(id, &name)),
            ("GET", _) => Question::parse(path, query)
                .map(|question| question.answer(&self.session, Coding::Rgba, &Control::default())),
            _ => Err(Answer::words(404, "not found")),
        };
        answered.unwrap_or_else(|refusal| refusal)
    }

    /// Ends an upload, and opens a file of it.
    fn open(&mut self, id: &str, name: &str) -> Result<Answer, Answer> {
        let Files(files) = self.uploads.end(id).map_err(in_words)?;
        if !name.is_empty() {
            check_name(name).map_err(in_words)?;
        }
        let subject = opened(&MemoryFolder::new(files), name).map_err(|e| Answer::words(422, e))?;
        self.session.open(subject).map_err(|e| Answer::words(422, e))?;
        Ok(done())
    }
}

fn in_words(error: UploadError) -> Answer {
    Answer::words(422, error)
}

/// The answer to what was done, and has nothing else to say.
fn done() -> Answer {
    Answer::json(&())
}
