//! One client: its edits in, pictures and words out.

use std::pin::pin;
use std::sync::Arc;
use std::time::{Duration, Instant};

use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{mpsc, watch};
use tokio::time::timeout;

use super::Service;
use super::rate::Rate;
use crate::message::{Request, Shown, Told, VERSION, picture_message};
use crate::session::{ClientId, Output, Session};

/// Time after which a client that takes nothing is given up.
const PATIENCE: Duration = Duration::from_secs(20);
/// Time that a last word has to arrive.
const LAST_WORD: Duration = Duration::from_millis(200);
/// Messages without sense after which a client is given up.
const MAX_MALFORMED: u32 = 20;
/// Answers that wait for a client at most.
const WAITING: usize = 64;
/// Largest number of pictures on their way to a client that tells which ones it has shown: one to be shown, and one to follow it. More would wait in
/// a page that is slower than the program, and be old when they are shown.
const AHEAD: usize = 2;

/// Serves a client until one side ends.
pub async fn serve(socket: WebSocket, service: Service, client: ClientId) {
    let (sink, stream) = socket.split();
    let (answers, waiting) = mpsc::channel(WAITING);
    // Whichever ends first ends the other. A connection that is cut while messages wait to be read loses the last word: they are read.
    let (showing, shown) = watch::channel(None);
    let mut receiving = pin!(receive(stream, &service, client, (answers, showing)));
    tokio::select! {
        () = &mut receiving => {}
        has_closed = send(sink, &service, client, (waiting, shown)) => if has_closed.is_some() {
            let _ = timeout(LAST_WORD, receiving).await;
        }
    }
    blocking(&service, move |session| session.forget(client)).await;
}

/// Asks the session something off the server's thread; `None` where that has panicked.
async fn blocking<T: Send + 'static>(service: &Service, ask: impl FnOnce(&Session) -> T + Send + 'static) -> Option<T> {
    let session = Arc::clone(&service.session);
    tokio::task::spawn_blocking(move || ask(&session)).await.ok()
}

/// Reads edits until the client goes, or has to.
async fn receive(
    mut stream: SplitStream<WebSocket>,
    service: &Service,
    client: ClientId,
    (answers, showing): (mpsc::Sender<Message>, watch::Sender<Option<u64>>),
) {
    let (mut rate, mut malformed) = (Rate::new(Instant::now()), 0);
    let close = |reason: &'static str| {
        let frame = CloseFrame { code: close_code::POLICY, reason: reason.into() };
        answers.send(Message::Close(Some(frame)))
    };
    while let Some(Ok(message)) = stream.next().await {
        if !rate.allows(Instant::now()) {
            let _ = close("too many messages").await;
            break;
        }
        let refused = match message {
            Message::Text(text) if has_shown(&text, &showing) => continue,
            Message::Text(text) => match Request::read(&text) {
                Ok(Request { number, edit }) => {
                    // An edit may ask for a survey of the volume, which would hold up every other client.
                    let edited = blocking(service, move |session| session.apply(client, number, &edit)).await;
                    match edited {
                        Some(Ok(())) => continue,
                        Some(Err(e)) => Told::Refused { number: Some(number), reason: e.to_string() },
                        None => Told::Refused { number: Some(number), reason: "the edit has failed".to_owned() },
                    }
                }
                Err(refused) => {
                    malformed += 1;
                    refused
                }
            },
            Message::Binary(_) => {
                malformed += 1;
                Told::Refused { number: None, reason: "message: found bytes; must be text".to_owned() }
            }
            Message::Ping(_) | Message::Pong(_) => continue,
            Message::Close(_) => break,
        };
        if malformed > MAX_MALFORMED {
            let _ = close("too many messages without sense").await;
            break;
        }
        if answers.send(text_message(&refused)).await.is_err() {
            break;
        }
    }
    let _ = timeout(LAST_WORD, async { while let Some(Ok(_)) = stream.next().await {} }).await;
}

/// Sends pictures and words until the client takes none (`None`), or the connection was closed for a reason. The newest picture is sent, and those that have become old while it was on its way are not.
async fn send(
    mut sink: SplitSink<WebSocket, Message>,
    service: &Service,
    client: ClientId,
    (mut answers, mut shown): (mpsc::Receiver<Message>, watch::Receiver<Option<u64>>),
) -> Option<()> {
    let (mut pictures, mut words) = service.hub.listen();
    let coding = service.coding();
    let state = blocking(service, Session::state).await?;
    put(&mut sink, text_message(&Told::Hello { client, version: VERSION })).await?;
    put(&mut sink, text_message(&Told::State { state: &state })).await?;
    pictures.mark_changed();
    let mut opened = Box::pin(service.clone().opened());
    let mut has_opened = false;
    // Numbers of the pictures that were sent and not shown yet, if the client tells which ones it has shown.
    let mut ahead: Vec<u64> = Vec::new();
    loop {
        let message = tokio::select! {
            biased;
            answer = answers.recv() => answer?,
            opened = &mut opened, if !has_opened => {
                has_opened = true;
                text_message(&Told::Opened { opened: &opened })
            }
            word = words.recv() => match word {
                Ok(Output::Volume) => {
                    (opened, has_opened) = (Box::pin(service.clone().opened()), false);
                    continue;
                }
                Ok(output) => match Told::of(&output) {
                    Some(told) => text_message(&told),
                    None => continue,
                },
                Err(RecvError::Lagged(_)) => {
                    // Another volume may have been among the words that were missed.
                    (opened, has_opened) = (Box::pin(service.clone().opened()), false);
                    text_message(&Told::State { state: &blocking(service, Session::state).await? })
                }
                Err(RecvError::Closed) => return None,
            },
            Ok(()) = shown.changed() => {
                let last = *shown.borrow_and_update();
                ahead.retain(|&number| Some(number) > last);
                continue;
            }
            changed = pictures.changed(), if ahead.len() < AHEAD => {
                changed.ok()?;
                let picture = pictures.borrow_and_update().clone();
                let Some(picture) = picture else { continue };
                if shown.borrow().is_some() {
                    ahead.push(picture.head.picture);
                }
                Message::Binary(picture_message(&picture, client, coding).into())
            }
            () = service.ending() => {
                put(&mut sink, text_message(&Told::Bye)).await?;
                return None;
            }
        };
        let closes = matches!(message, Message::Close(_));
        put(&mut sink, message).await?;
        if closes {
            return Some(());
        }
    }
}

/// Passes on that a picture was shown, and returns true, if that is what a message says.
fn has_shown(text: &str, showing: &watch::Sender<Option<u64>>) -> bool {
    let shown = Shown::read(text);
    if let Some(Shown { shown }) = shown {
        showing.send_replace(Some(shown));
    }
    shown.is_some()
}

fn text_message(told: &Told<'_>) -> Message {
    Message::Text(told.text().into())
}

/// Sends a message; `None` where the client is gone, or takes too long.
async fn put(sink: &mut SplitSink<WebSocket, Message>, message: Message) -> Option<()> {
    timeout(PATIENCE, sink.send(message)).await.ok()?.ok()
}
