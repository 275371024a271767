//! Messages between the program and a page, whatever carries them.

use serde::{Deserialize, Serialize};

use crate::session::{ClientId, Edit, Head, Opened, Output, Picture, PictureError, SecondPicture, Slice, State};

/// Most bytes of a message from a page: a transfer function of some thousand points.
pub const MAX_MESSAGE: usize = 256 << 10;

/// Version of the program, which a page of another one is told.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Message of a page: an edit, and its number.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Number of the edit; numbers of one page rise.
    pub number: u64,
    /// The edit.
    pub edit: Edit,
}

impl Request {
    /// Reads the text of a message.
    ///
    /// # Errors
    /// The refusal of a text that makes no sense.
    pub fn read(text: &str) -> Result<Self, Told<'static>> {
        serde_json::from_str(text).map_err(|e| Told::Refused { number: None, reason: format!("message: {e}") })
    }
}

/// Message of a page that has shown a picture. A page that sends these is sent at most two pictures ahead of the last one that it has shown.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// Number of the picture.
    pub shown: u64,
}

impl Shown {
    /// Reads the text of a message; `None` for any other message.
    pub fn read(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }
}

/// Message in words to a page.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Told<'a> {
    /// The first one: the client's number.
    Hello {
        /// The client's number.
        client: ClientId,
        /// Version of the program: a page of another one is to load itself anew.
        version: &'static str,
    },
    /// The scene was opened.
    Opened {
        /// All that edits do not change.
        opened: &'a Opened,
    },
    /// The scene as it is now.
    State {
        /// The scene.
        state: &'a State,
    },
    /// The error of a picture that was sent before.
    Error {
        /// Number of the picture.
        picture: u64,
        /// The error.
        error: PictureError,
    },
    /// The reason why an edit was refused.
    Refused {
        /// Number of the edit; `None` where the message could not be read.
        number: Option<u64>,
        /// The reason.
        reason: String,
    },
    /// The reason why there is no picture.
    Problem {
        /// The reason.
        reason: &'a str,
    },
    /// The program ends.
    Bye,
}

impl<'a> Told<'a> {
    /// The words of a session; `None` for a picture, and for another volume, which is described when it was surveyed.
    pub fn of(output: &'a Output) -> Option<Self> {
        Some(match output {
            Output::State(state) => Told::State { state },
            Output::Error { picture, error } => Told::Error { picture: *picture, error: *error },
            Output::Problem(reason) => Told::Problem { reason },
            Output::Picture(_) | Output::Volume => return None,
        })
    }

    /// The message as text.
    pub fn text(&self) -> String {
        serde_json::to_string(self).expect("words and numbers have texts")
    }
}

/// Encoding of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Coding {
    /// Four bytes a pixel, as they are: on one machine, nothing is faster.
    Rgba,
    /// PNG, which loses nothing: over a network.
    Png,
}

#[derive(Serialize)]
struct FullHead<'a> {
    #[serde(flatten)]
    head: &'a Head,
    /// Number of the client's last edit that the picture shows.
    answers: u64,
    coding: Coding,
}

#[derive(Serialize)]
struct SecondHead<'a> {
    #[serde(flatten)]
    picture: &'a SecondPicture,
    coding: Coding,
}

/// A picture as a message to a client.
pub fn picture_message(picture: &Picture, client: ClientId, coding: Coding) -> Vec<u8> {
    let answers = picture.answers.get(&client).copied().unwrap_or(0);
    let head = FullHead { head: &picture.head, answers, coding };
    picture_bytes(&head, coding, picture.head.size, &picture.rgba)
}

/// A second picture, laid out as the first ones are.
pub fn second_picture_bytes(picture: &SecondPicture, coding: Coding) -> Vec<u8> {
    picture_bytes(&SecondHead { picture, coding }, coding, picture.size, &picture.rgba)
}

/// A slice: its values as `f32`, the smallest byte first, NaN in vacuum; then, where there are labels, two bytes a pixel.
pub fn slice_bytes(slice: &Slice) -> Vec<u8> {
    let values = slice.values.iter().flat_map(|&value| (value as f32).to_le_bytes());
    let labels = slice.label_indices.iter().flat_map(|index| index.to_le_bytes());
    headed(slice, &values.chain(labels).collect::<Vec<u8>>())
}

/// The head of a picture, and its pixels.
fn picture_bytes(head: &impl Serialize, coding: Coding, size: [u32; 2], rgba: &[u8]) -> Vec<u8> {
    let png;
    let pixels = match coding {
        Coding::Rgba => rgba,
        Coding::Png => {
            png = vr_io::encode_rgba_png(size, rgba);
            &png
        }
    };
    headed(head, pixels)
}

/// The length of the head in four bytes, the smallest first; the head in JSON; the rest.
pub fn headed(head: &impl Serialize, rest: &[u8]) -> Vec<u8> {
    let head = serde_json::to_vec(head).expect("words and numbers have texts");
    let mut bytes = Vec::with_capacity(4 + head.len() + rest.len());
    bytes.extend((head.len() as u32).to_le_bytes());
    bytes.extend(&head);
    bytes.extend(rest);
    bytes
}
