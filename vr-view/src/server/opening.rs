//! Opening of another file: by its path below the folder that the user has named, or from the page itself.

use std::error::Error;
use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::path::{Component, Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use axum::body::Bytes;
use axum::extract::{Path as UrlPath, Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use tempfile::TempDir;
use tokio::sync::Semaphore;
use vr_core::clock::Instant;
use vr_io::VolumeSource;

use super::Service;
use super::token::Token;
use crate::session::{EditError, Subject};
use crate::upload::{
    BeginQuery, Begun, Listing, NameQuery, PieceQuery, UploadError, UploadFolder, Uploads, check_name, without_folder,
};

/// Most files of a folder that are listed, and folders below each other that are looked into.
const MAX_LISTED: usize = 500;
const MAX_DEPTH: usize = 3;

/// Reader of a file: gives it with a scene around it, of which nothing is left open.
pub type SubjectReader = dyn Fn(&Path) -> Result<Subject, Box<dyn Error + Send + Sync>> + Send + Sync;

/// Permission to open other files from within the page.
pub struct Opening {
    /// Folder below which files may be opened by their path; `None` for none.
    pub folder: Option<PathBuf>,
    /// Most bytes of files that a page sends.
    pub max_upload: u64,
    /// Reader of files.
    pub read: Box<SubjectReader>,
}

/// Opening, and what is on its way.
pub struct Openings {
    opening: Opening,
    /// The folder without links in its path.
    real_folder: Option<PathBuf>,
    uploads: Mutex<Uploads<TempDir>>,
    /// One file is read at a time.
    turn: Semaphore,
}

/// Reason why another file is not opened.
#[derive(Debug, thiserror::Error)]
enum OpenError {
    /// The program opens no other files.
    #[error("this program opens no other files")]
    Never,
    /// No folder was named.
    #[error("no folder was named: start vr view with --folder FOLDER to open the files below it by their paths")]
    NoFolder,
    /// A path that leads out of the folder, or to nothing in it.
    #[error("path: found {0:?}; must be that of a file below the folder that was named with --folder")]
    Outside(String),
    /// A file that takes its numbers from another place.
    #[error("the file reads another one that is not beside it; all that it reads must be in the same folder, or below")]
    Elsewhere,
    /// Files that are not taken.
    #[error(transparent)]
    Upload(#[from] UploadError),
    /// A file that cannot be read; no path of the machine stands in the words.
    #[error("{0}")]
    Read(String),
    /// A scene that cannot be made of it.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// No random number.
    #[error("the system gives no random numbers")]
    Random,
    /// A reader that has given up.
    #[error("reading has failed")]
    Failed,
}

impl IntoResponse for OpenError {
    fn into_response(self) -> Response {
        let status = match &self {
            Self::Never | Self::NoFolder | Self::Outside(_) | Self::Elsewhere => StatusCode::FORBIDDEN,
            Self::Upload(UploadError::Busy) => StatusCode::CONFLICT,
            Self::Upload(UploadError::Size { .. } | UploadError::More(_)) => StatusCode::PAYLOAD_TOO_LARGE,
            Self::Upload(UploadError::Unknown) => StatusCode::NOT_FOUND,
            Self::Failed | Self::Random => StatusCode::INTERNAL_SERVER_ERROR,
            Self::Upload(_) | Self::Read(_) | Self::Edit(_) => StatusCode::UNPROCESSABLE_ENTITY,
        };
        (status, format!("{self}\n")).into_response()
    }
}

impl Openings {
    /// Opening as it is permitted.
    ///
    /// # Errors
    /// A folder that is none.
    pub fn new(opening: Opening) -> io::Result<Self> {
        let real_folder = opening.folder.as_ref().map(fs::canonicalize).transpose()?;
        if real_folder.as_ref().is_some_and(|folder| !folder.is_dir()) {
            return Err(io::ErrorKind::NotADirectory.into());
        }
        let uploads = Mutex::new(Uploads::new(opening.max_upload));
        Ok(Self { opening, real_folder, uploads, turn: Semaphore::new(1) })
    }

    /// Path of a file below the folder, without links: one that leads out of the folder is refused, and so is one that is not there.
    fn inside(&self, name: &str) -> Result<PathBuf, OpenError> {
        let folder = self.real_folder.as_ref().ok_or(OpenError::NoFolder)?;
        let outside = || OpenError::Outside(name.to_owned());
        let is_plain =
            Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !is_plain || name.is_empty() {
            return Err(outside());
        }
        let path = fs::canonicalize(folder.join(name)).map_err(|_| outside())?;
        if path.starts_with(folder) && path != *folder { Ok(path) } else { Err(outside()) }
    }

    /// Reads a file, which may name others: nothing is shown of what lies outside of the folder. What is said of it has no path of the machine.
    fn read(&self, path: &Path, folder: &Path) -> Result<Subject, OpenError> {
        let mut subject =
            (self.opening.read)(path).map_err(|e| OpenError::Read(without_folder(folder, &e.to_string())))?;
        let real = fs::canonicalize(folder).map_err(|_| OpenError::Failed)?;
        let is_inside = |file: &PathBuf| fs::canonicalize(file).is_ok_and(|file| file.starts_with(&real));
        if !subject.volume.info.iter().flat_map(|info| &info.files).all(is_inside) {
            return Err(OpenError::Elsewhere);
        }
        subject.title = without_folder(folder, &subject.title);
        subject.notes.iter_mut().for_each(|note| *note = without_folder(folder, note));
        Ok(subject)
    }
}

impl UploadFolder for TempDir {
    fn empty() -> io::Result<Self> {
        // With the process's number, which tells whose folder a crash left behind.
        tempfile::Builder::new().prefix(&format!("vr-view-{}-", std::process::id())).tempdir()
    }

    fn append(&mut self, name: &str, is_new: bool, bytes: &[u8]) -> io::Result<()> {
        // A name is new where nothing of it is here yet: names that differ in case may be one file.
        let mut options = OpenOptions::new();
        let options = if is_new { options.write(true).create_new(true) } else { options.append(true) };
        options.open(self.path().join(name))?.write_all(bytes)
    }
}

/// An answer in JSON.
fn json<T: Serialize>(found: T) -> Response {
    let text = serde_json::to_string(&found).expect("words and numbers have texts");
    ([(CONTENT_TYPE, "application/json")], text).into_response()
}

/// Answers with the files that can be opened.
pub async fn list(State(service): State<Service>) -> Response {
    let Some(openings) = service.openings.clone() else {
        return json(Listing { opens: false, has_folder: false, files: Vec::new(), max_upload: 0 });
    };
    let listed = tokio::task::spawn_blocking(move || {
        let mut files = Vec::new();
        if let Some(folder) = &openings.real_folder {
            list_files(folder, "", MAX_DEPTH, &mut files);
        }
        Listing {
            opens: true,
            has_folder: openings.real_folder.is_some(),
            files,
            max_upload: openings.opening.max_upload,
        }
    });
    match listed.await {
        Ok(listing) => json(listing),
        Err(_) => OpenError::Failed.into_response(),
    }
}

/// Appends the files of a folder and of those below it; hidden ones and links are not listed.
fn list_files(folder: &Path, before: &str, depth: usize, files: &mut Vec<String>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut entries: Vec<_> = entries.flatten().collect();
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let (Ok(kind), Ok(name)) = (entry.file_type(), entry.file_name().into_string()) else { continue };
        if files.len() >= MAX_LISTED || name.starts_with('.') {
            continue;
        }
        if kind.is_file() {
            files.push(format!("{before}{name}"));
        } else if kind.is_dir() && depth > 1 {
            list_files(&entry.path(), &format!("{before}{name}/"), depth - 1, files);
        }
    }
}

/// Path of a file below the folder.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OpenQuery {
    path: String,
}

/// Opens a file below the folder.
pub async fn open(State(service): State<Service>, Query(OpenQuery { path }): Query<OpenQuery>) -> Response {
    let outcome = opened(service, move |openings| {
        let inside = openings.inside(&path)?;
        let folder = openings.real_folder.clone().ok_or(OpenError::NoFolder)?;
        openings.read(&inside, &folder)
    });
    outcome.await.map_or_else(IntoResponse::into_response, |()| StatusCode::NO_CONTENT.into_response())
}

/// Begins an upload.
pub async fn begin(State(service): State<Service>, Query(BeginQuery { bytes }): Query<BeginQuery>) -> Response {
    let Ok(id) = Token::random().map(|id| id.text().to_owned()) else { return OpenError::Random.into_response() };
    let begun = id.clone();
    match in_upload(service, move |uploads| uploads.begin(begun, bytes, Instant::now())).await {
        Ok(()) => json(Begun { id }),
        Err(e) => e.into_response(),
    }
}

/// Takes a piece of a file.
pub async fn piece(
    State(service): State<Service>,
    UrlPath((_, id)): UrlPath<(String, String)>,
    Query(PieceQuery { name, offset }): Query<PieceQuery>,
    bytes: Bytes,
) -> Response {
    let taken = in_upload(service, move |uploads| uploads.piece(&id, &name, offset, &bytes, Instant::now())).await;
    taken.map_or_else(IntoResponse::into_response, |()| StatusCode::NO_CONTENT.into_response())
}

/// Gives an upload up.
pub async fn give_up(State(service): State<Service>, UrlPath((_, id)): UrlPath<(String, String)>) -> Response {
    let ended = in_upload(service, move |uploads| uploads.end(&id)).await;
    ended.map_or_else(IntoResponse::into_response, |_| StatusCode::NO_CONTENT.into_response())
}

/// Ends an upload, and opens a file of it.
pub async fn open_upload(
    State(service): State<Service>,
    UrlPath((_, id)): UrlPath<(String, String)>,
    Query(NameQuery { name }): Query<NameQuery>,
) -> Response {
    let outcome = opened(service, move |openings| {
        let arrived = openings.uploads.lock().unwrap_or_else(PoisonError::into_inner).end(&id)?;
        let mut path = arrived.path().to_owned();
        if !name.is_empty() {
            check_name(&name)?;
            path.push(&name);
        }
        let mut subject = openings.read(&path, arrived.path())?;
        // The scene file that is saved names the file as the user knows it: beside it, it is drawn again.
        if let Some(VolumeSource::File(source)) = &mut subject.file.volume.source {
            source.path = if name.is_empty() { ".".into() } else { name.into() };
        }
        Ok(subject)
    });
    outcome.await.map_or_else(IntoResponse::into_response, |()| StatusCode::NO_CONTENT.into_response())
}

/// Does something to the upload, off the server's thread.
async fn in_upload<T: Send + 'static>(
    service: Service,
    act: impl FnOnce(&mut Uploads<TempDir>) -> Result<T, UploadError> + Send + 'static,
) -> Result<T, OpenError> {
    let openings = service.openings.ok_or(OpenError::Never)?;
    let acted =
        tokio::task::spawn_blocking(move || act(&mut openings.uploads.lock().unwrap_or_else(PoisonError::into_inner)));
    Ok(acted.await.map_err(|_| OpenError::Failed)??)
}

/// Reads a file and shows it, one at a time.
async fn opened(
    service: Service,
    read: impl FnOnce(&Openings) -> Result<Subject, OpenError> + Send + 'static,
) -> Result<(), OpenError> {
    let openings = service.openings.ok_or(OpenError::Never)?;
    let session = Arc::clone(&service.session);
    let reading = Arc::clone(&openings);
    let _turn = openings.turn.acquire().await;
    let acted = tokio::task::spawn_blocking(move || Ok(session.open(read(&reading)?)?));
    acted.await.map_err(|_| OpenError::Failed)?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_temporary_folder_takes_pieces_and_goes() {
        let mut folder = TempDir::empty().unwrap();
        folder.append("a.raw", true, b"12345").unwrap();
        folder.append("a.raw", false, b"67").unwrap();
        assert_eq!(folder.append("a.raw", true, b"x").unwrap_err().kind(), io::ErrorKind::AlreadyExists);
        let path = folder.path().join("a.raw");
        assert_eq!(fs::read(&path).unwrap(), b"1234567");
        drop(folder);
        assert!(!path.exists());
    }
}
