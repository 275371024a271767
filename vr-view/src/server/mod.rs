//! Server: one session before browsers, on this machine unless told otherwise.
//!
//! Plain `GET` for the page, for files to be saved and for questions about the truth, a WebSocket for edits and pictures. Every address begins with a random [token](Token), and every
//! request is checked (`guard`).

mod guard;
mod hub;
mod opening;
mod page;
mod questions;
mod rate;
mod socket;
mod token;

use std::future::Future;
use std::io;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{DefaultBodyLimit, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use tokio::sync::{Mutex, Semaphore, watch};
use vr_core::Control;

use crate::message::{Coding, MAX_MESSAGE};
use crate::session::{Document, Opened, Session};
use crate::upload::MAX_PIECE;
use hub::Hub;
use opening::Openings;

pub use opening::{Opening, SubjectReader};
pub use token::Token;

/// Most pages that look at one session.
pub const MAX_CLIENTS: usize = 8;

/// Time after which a page that was closed is gone: one that is loaded anew comes back sooner.
const GONE: Duration = Duration::from_secs(3);

/// Time between looks at the outside's wish to end.
const GLANCE: Duration = Duration::from_millis(50);

/// Time that clients have to take a last word.
const FAREWELL: Duration = Duration::from_millis(60);

/// Error of the server.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// An address that cannot be listened at.
    #[error("--listen {address}: {source}")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// The system's reason.
        source: io::Error,
    },
    /// No random numbers for the token.
    #[error("the system gives no random numbers: {0}")]
    Token(getrandom::Error),
    /// A failure of the system while serving.
    #[error("server: {0}")]
    System(#[from] io::Error),
    /// A folder that is none.
    #[error("--folder {}: {source}", .folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// Server that listens already, so that its address is known.
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    token: Token,
    openings: Option<Arc<Openings>>,
}

impl Server {
    /// Address that is listened at where none is named: this machine alone, any port that is free.
    pub const USUAL: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(Ipv4Addr::LOCALHOST), 0);

    /// Listens at an address; port 0 takes one that is free.
    ///
    /// # Errors
    /// An address that is taken, or not this machine's.
    pub fn bind(address: SocketAddr) -> Result<Self, ServerError> {
        let failed = |source| ServerError::Listen { address, source };
        let listener = TcpListener::bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        Ok(Self { listener, address, token: Token::random().map_err(ServerError::Token)?, openings: None })
    }

    /// Lets pages open other files.
    ///
    /// # Errors
    /// A folder that is none.
    pub fn with_opening(mut self, opening: Opening) -> Result<Self, ServerError> {
        let folder = opening.folder.clone().unwrap_or_default();
        let openings = Openings::new(opening).map_err(|source| ServerError::Folder { folder, source })?;
        self.openings = Some(Arc::new(openings));
        Ok(self)
    }

    /// Address of the page, with the token.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token.text())
    }

    /// Serves a document until the control is cancelled or, unless it is to `stay`, the last page is closed. Pictures are drawn on the control's
    /// threads.
    ///
    /// # Errors
    /// A failure of the system.
    pub fn run(self, document: Document, control: &Control, stay: bool) -> Result<(), ServerError> {
        let hub = Arc::new(Hub::new());
        let telling = Arc::clone(&hub);
        let session = Arc::new(Session::start(document, control, move |output| telling.tell(output))?);
        let (end, _) = watch::channel(false);
        let service = Service {
            session,
            hub,
            token: self.token,
            address: self.address,
            clients: Arc::default(),
            next_client: Arc::new(AtomicU64::new(1)),
            opened: Arc::default(),
            openings: self.openings,
            exports: Arc::new(Semaphore::new(1)),
            slices: Arc::new(Semaphore::new(1)),
            end: Arc::new(end),
        };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let listener = self.listener;
        let outcome = runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener)?;
            let serving = axum::serve(listener, router(service.clone()));
            tokio::select! {
                outcome = serving.into_future() => outcome,
                () = until_end(&service, control, stay) => {
                    service.end.send_replace(true);
                    tokio::time::sleep(FAREWELL).await;
                    Ok(())
                }
            }
        });
        service.session.end();
        runtime.shutdown_timeout(FAREWELL);
        Ok(outcome?)
    }
}

/// State that all requests share.
#[derive(Clone)]
struct Service {
    session: Arc<Session>,
    hub: Arc<Hub>,
    token: Token,
    address: SocketAddr,
    clients: Arc<AtomicUsize>,
    next_client: Arc<AtomicU64>,
    opened: Arc<Mutex<Option<Arc<Opened>>>>,
    openings: Option<Arc<Openings>>,
    /// One picture at a time is drawn to be saved, or to be compared.
    exports: Arc<Semaphore>,
    /// One slice at a time is sampled: it takes milliseconds.
    slices: Arc<Semaphore>,
    end: Arc<watch::Sender<bool>>,
}

impl Service {
    /// Description of the volume that is shown: made once for each, beside the first pictures.
    async fn opened(self) -> Arc<Opened> {
        let mut kept = self.opened.lock().await;
        let session = Arc::clone(&self.session);
        let known = kept.clone();
        let make = move || {
            let known = known.filter(|opened| opened.volume == session.volume_revision());
            known.unwrap_or_else(|| Arc::new(session.opened()))
        };
        let opened = tokio::task::spawn_blocking(make).await.expect("a description does not panic");
        *kept = Some(Arc::clone(&opened));
        opened
    }

    /// Encoding of pixels: as they are on one machine, packed over a network.
    fn coding(&self) -> Coding {
        if self.address.ip().is_loopback() { Coding::Rgba } else { Coding::Png }
    }

    /// Waits until the server ends.
    fn ending(&self) -> impl Future<Output = ()> + use<> {
        let mut end = self.end.subscribe();
        async move {
            let _ = end.wait_for(|&ends| ends).await;
        }
    }
}

/// Waits until the control is cancelled, or the last page is gone.
async fn until_end(service: &Service, control: &Control, stay: bool) {
    let (mut had_client, mut alone) = (false, Duration::ZERO);
    while !control.is_cancelled() {
        tokio::time::sleep(GLANCE).await;
        if service.clients.load(Ordering::Relaxed) > 0 {
            (had_client, alone) = (true, Duration::ZERO);
        } else if had_client && !stay {
            alone += GLANCE;
            if alone >= GONE {
                return;
            }
        }
    }
}

fn router(service: Service) -> Router {
    let guarded = axum::middleware::from_fn_with_state(service.clone(), guard::guard);
    Router::new()
        .route("/{token}/", get(page::index))
        .route("/{token}/socket", get(connect))
        .route("/{token}/save/{name}", get(questions::answer))
        .route("/{token}/truth/{name}", get(questions::answer))
        .route("/{token}/slice", get(questions::answer))
        .route("/{token}/place", get(questions::answer))
        .route("/{token}/pick", get(questions::answer))
        .route("/{token}/files", get(opening::list))
        .route("/{token}/open", post(opening::open))
        .route("/{token}/upload", post(opening::begin))
        .route("/{token}/upload/{id}", post(opening::piece).delete(opening::give_up))
        .route("/{token}/upload/{id}/open", post(opening::open_upload))
        .layer(DefaultBodyLimit::max(MAX_PIECE))
        .route("/{token}/{name}", get(page::file))
        .layer(guarded)
        .with_state(service)
}

/// Place of a client among those that are there; free again when it is dropped.
struct Seat(Arc<AtomicUsize>);

impl Seat {
    fn take(clients: &Arc<AtomicUsize>) -> Option<Self> {
        let more = |n| (n < MAX_CLIENTS).then_some(n + 1);
        clients.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more).ok()?;
        Some(Self(Arc::clone(clients)))
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

async fn connect(State(service): State<Service>, upgrade: WebSocketUpgrade) -> Response {
    let Some(seat) = Seat::take(&service.clients) else {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages look at this volume\n").into_response();
    };
    let client = service.next_client.fetch_add(1, Ordering::Relaxed);
    let upgrade = upgrade.max_message_size(MAX_MESSAGE).max_frame_size(MAX_MESSAGE);
    upgrade.on_upgrade(move |socket| async move {
        let _seat = seat;
        socket::serve(socket, service, client).await;
    })
}
