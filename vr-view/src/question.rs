//! Questions of a page about the scene, its picture and its volume, and their answers, whatever carries them.

use glam::DVec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use vr_core::{Control, RenderError};

use crate::message::{Coding, second_picture_bytes, slice_bytes};
use crate::session::{Export, ExportError, Quality, Session, Setting, SliceQuery, TruthError};

const BYTES: &str = "application/octet-stream";
const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// Question, as its address states it.
#[derive(Clone, Debug)]
pub enum Question {
    /// A file of the scene or of its picture: `save/NAME?width=…&height=…`.
    Save(Export),
    /// The error map: `truth/error-map`.
    ErrorMap,
    /// Plot of a pixel's ray, by the second setting if one is named: `truth/ray?x=…&y=…&renderer=…&quality=…`.
    Ray([u32; 2], Option<Setting>),
    /// The picture of a second setting: `truth/second?renderer=…&quality=…`.
    Second(Setting),
    /// A slice: `slice?axis=…&at=…&side=…`.
    Slice(SliceQuery),
    /// Value and label at a place of the world: `place?x=…&y=…&z=…`.
    Place(DVec3),
    /// Value under a place in the picture, which is given in picture heights from its middle: `pick?x=…&y=…`. The answer is `null` where nothing is seen.
    Pick([f64; 2]),
}

/// Kind of a question, of each of which one is answered at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// One that draws a picture.
    Picture,
    /// One that samples a slice: it takes milliseconds.
    Slice,
    /// One that waits for none.
    None,
}

/// Answer to a question.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Status as HTTP has it: 200, 400 (the address makes no sense), 404 (there is no such question), 409 (the scene has changed meanwhile, so that the question is
    /// stale), or 422 (there is no answer, and the reason stands in words).
    pub status: u16,
    /// Media type.
    pub media_type: &'static str,
    /// Name of the file that is to be saved.
    pub file_name: Option<&'static str>,
    /// The answer itself.
    pub bytes: Vec<u8>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SaveQuery {
    width: Option<u32>,
    height: Option<u32>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PixelQuery {
    x: u32,
    y: u32,
    renderer: Option<String>,
    quality: Option<Quality>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceQuery {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PickQuery {
    x: f64,
    y: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NoQuery {}

impl Question {
    /// Reads the address of a question: a path, and the query behind its question mark.
    ///
    /// # Errors
    /// The answer to an address that is none.
    pub fn parse(path: &str, query: &str) -> Result<Self, Answer> {
        Ok(match path {
            "truth/error-map" => {
                let NoQuery {} = read(query)?;
                Self::ErrorMap
            }
            "truth/ray" => {
                let PixelQuery { x, y, renderer, quality } = read(query)?;
                Self::Ray([x, y], renderer.map(|renderer| Setting { renderer, quality }))
            }
            "truth/second" => Self::Second(read(query)?),
            "slice" => Self::Slice(read(query)?),
            "place" => {
                let PlaceQuery { x, y, z } = read(query)?;
                Self::Place(DVec3::new(x, y, z))
            }
            "pick" => {
                let PickQuery { x, y } = read(query)?;
                Self::Pick([x, y])
            }
            _ => {
                let SaveQuery { width, height } = match path.strip_prefix("save/") {
                    Some(_) => read(query)?,
                    None => return Err(Answer::words(404, "not found")),
                };
                let size = width.zip(height).map(|(width, height)| [width, height]);
                let all = [Export::Scene, Export::Png { size }, Export::Exr { size }, Export::Transfer];
                let named = all.into_iter().find(|export| path.strip_prefix("save/") == Some(export.file_name()));
                Self::Save(named.ok_or_else(|| Answer::words(404, "not found"))?)
            }
        })
    }

    /// The kind of which one is answered at a time.
    pub fn turn(&self) -> Turn {
        match self {
            Self::Save(_) | Self::ErrorMap | Self::Ray(..) | Self::Second(_) => Turn::Picture,
            Self::Slice(_) => Turn::Slice,
            Self::Place(_) | Self::Pick(_) => Turn::None,
        }
    }

    /// Answers by a session. The control cancels a slice; the next edit cancels what is about the picture at rest.
    pub fn answer(&self, session: &Session, coding: Coding, control: &Control) -> Answer {
        let found = match self {
            Self::Save(export) => return Answer::file(*export, session.export(*export)),
            Self::ErrorMap => session.error_map().map(|map| Answer::json(&map)),
            Self::Ray(pixel, None) => session.ray(*pixel).map(|plot| Answer::json(&plot)),
            Self::Ray(pixel, Some(setting)) => session.ray_of(*pixel, setting).map(|plot| Answer::json(&plot)),
            Self::Second(setting) => {
                session.second(setting).map(|picture| Answer::found(BYTES, second_picture_bytes(&picture, coding)))
            }
            Self::Slice(query) => session.slice(query, control).map(|slice| Answer::found(BYTES, slice_bytes(&slice))),
            Self::Place(at) => session.place(*at).map(|place| Answer::json(&place)),
            Self::Pick(place) => session.pick(*place).map(|pick| Answer::json(&pick)),
        };
        found.unwrap_or_else(|error| match error {
            TruthError::Render(RenderError::Cancelled) => Answer::words(409, "the scene has changed"),
            e => Answer::words(422, e),
        })
    }
}

impl Answer {
    /// An answer in words, such as the reason why there is no other.
    pub fn words(status: u16, text: impl std::fmt::Display) -> Self {
        Self { status, media_type: TEXT, file_name: None, bytes: format!("{text}\n").into_bytes() }
    }

    /// An answer in JSON.
    pub fn json(found: &impl Serialize) -> Self {
        Self::found(JSON, serde_json::to_vec(found).expect("words and numbers have texts"))
    }

    fn found(media_type: &'static str, bytes: Vec<u8>) -> Self {
        Self { status: 200, media_type, file_name: None, bytes }
    }

    fn file(export: Export, made: Result<Vec<u8>, ExportError>) -> Self {
        match made {
            Ok(bytes) => Self { file_name: Some(export.file_name()), ..Self::found(export.media_type(), bytes) },
            Err(e) => Self::words(422, e),
        }
    }
}

/// Reads the query of an address.
///
/// # Errors
/// The answer to one that makes no sense.
pub fn read<T: DeserializeOwned>(query: &str) -> Result<T, Answer> {
    serde_urlencoded::from_str(query).map_err(|e| Answer::words(400, format_args!("address: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_whole_or_refused() {
        let status =
            |path: &str, query: &str| Question::parse(path, query).map_or_else(|answer| answer.status, |_| 200);
        for (path, query) in [
            ("truth/error-map", ""),
            ("truth/ray", "x=1&y=2"),
            ("truth/ray", "x=1&y=2&renderer=shearwarp&quality=fine"),
            ("truth/second", "renderer=raycast"),
            ("slice", "axis=2&at=-1.5&side=64"),
            ("place", "x=1&y=2&z=3e2"),
            ("pick", "x=0.25&y=-0.5"),
            ("save/scene.toml", ""),
            ("save/picture.png", "width=64&height=32"),
        ] {
            assert_eq!(status(path, query), 200, "{path} {query}");
        }
        for (path, query) in [
            ("truth/error-map", "x=1"),
            ("truth/ray", "x=1"),
            ("truth/ray", "x=-1&y=2"),
            ("truth/second", ""),
            ("slice", "axis=2&at=here&side=64"),
            ("pick", "x=0.25&y=-0.5&z=1"),
            ("save/picture.png", "width=wide"),
        ] {
            assert_eq!(status(path, query), 400, "{path} {query}");
        }
        for path in ["", "save", "save/", "save/other", "truth", "files", "../scene.toml"] {
            assert_eq!(status(path, ""), 404, "{path}");
        }
        let Ok(Question::Save(Export::Png { size })) = Question::parse("save/picture.png", "width=64&height=32") else {
            panic!("a picture");
        };
        assert_eq!(size, Some([64, 32]));
    }
}
