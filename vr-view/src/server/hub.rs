//! Hub: what the session tells, on its way to every client.

use std::sync::Arc;

use tokio::sync::{broadcast, watch};

use crate::session::{Output, Picture};

/// Words that wait for a client at most; one that is further behind is told the whole state anew.
const WAITING: usize = 64;

/// Latest picture and the words of a session. A slow client misses pictures, which the next one replaces, and holds up none of the others.
pub struct Hub {
    pictures: watch::Sender<Option<Arc<Picture>>>,
    words: broadcast::Sender<Output>,
}

impl Hub {
    /// A hub without a picture.
    pub fn new() -> Self {
        Self { pictures: watch::Sender::new(None), words: broadcast::Sender::new(WAITING) }
    }

    /// Passes on what the session tells. Never blocks.
    pub fn tell(&self, output: Output) {
        match output {
            Output::Picture(picture) => {
                self.pictures.send_replace(Some(picture));
            }
            words => {
                // Without clients there are no listeners.
                let _ = self.words.send(words);
            }
        }
    }

    /// The latest picture, and the words from now on.
    pub fn listen(&self) -> (watch::Receiver<Option<Arc<Picture>>>, broadcast::Receiver<Output>) {
        (self.pictures.subscribe(), self.words.subscribe())
    }
}
