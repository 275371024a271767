//! Hub: what the session tells, on its way to every client.

use std::sync::Arc;

use tokio::sync::{broadcast, watch};

use crate::session::{Output, Picture, Stage};

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
                if let Output::Error { picture, error } = words {
                    self.pictures.send_if_modified(|latest| {
                        if let Some(latest) = latest.as_mut().filter(|latest| latest.head.picture == picture) {
                            let latest = Arc::make_mut(latest);
                            (latest.head.error, latest.head.stage) = (error, Stage::Measured);
                        }
                        // Those who have the picture are told in words; those who come later see it in its head.
                        false
                    });
                }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::session::{Head, Orientation, PictureError};

    #[test]
    fn who_comes_late_is_told_the_error_too() {
        let camera = Orientation {
            eye: glam::DVec3::Z,
            right: glam::DVec3::X,
            up: glam::DVec3::Y,
            forward: glam::DVec3::NEG_Z,
            height: 1.0,
            fov: None,
        };
        let head = Head {
            picture: 7,
            size: [1, 1],
            full_size: [1, 1],
            stage: Stage::Sharp,
            renderer: "raycast".to_owned(),
            milliseconds: 1.0,
            prepare_milliseconds: 0.0,
            error: PictureError::Unknown,
            camera,
        };
        let hub = Hub::new();
        let (mut early, _) = hub.listen();
        hub.tell(Output::Picture(Arc::new(Picture { head, rgba: vec![0; 4], answers: Default::default() })));
        assert!(early.has_changed().unwrap() && early.borrow_and_update().is_some());
        let error = PictureError::Estimated { rmse: 0.5 };
        hub.tell(Output::Error { picture: 6, error: PictureError::Unknown });
        hub.tell(Output::Error { picture: 7, error });
        assert!(!early.has_changed().unwrap(), "the pixels are not sent again");
        let (late, _) = hub.listen();
        let seen = late.borrow().clone().unwrap();
        assert_eq!((seen.head.error, seen.head.stage), (error, Stage::Measured));
    }
}
