//! A window into a volume: a session that takes edits and gives pictures with their errors, a server, and a page.
//!
//! [`session`] knows scenes and renderers, and no network; [`message`], [`question`] and [`upload`] are what passes between it and a [`page`], whatever
//! carries it; `server` (the feature of that name, on by default) puts one session before browsers.
//!
//! # Example
//! A phantom is turned, and drawn again until each of its pixels is proven to be within 0.004 of the truth:
//! ```
//! use std::path::Path;
//! use std::sync::{Arc, mpsc};
//!
//! use vr_core::Control;
//! use vr_io::{SceneFile, VolumeSource};
//! use vr_raycast::RayCaster;
//! use vr_study::stated::StatedRenderer;
//! use vr_view::session::{Document, Edit, Labels, Output, PROVEN, PictureError, RendererList, Session, Stage, Subject};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mut file = SceneFile::default();
//! file.volume.source = Some(VolumeSource::Phantom { name: "blobs".to_owned(), size: Some(16) });
//! file.image.size = [48, 32];
//! let volume = vr_io::load_volume(&file.volume, Path::new(""))?;
//! let loaded = vr_io::resolve_scene_around(&file, Path::new(""), volume.clone())?;
//! let stated = StatedRenderer::of(&RayCaster::default(), Some(PROVEN));
//! let file = file.completed(&loaded.unlabelled, None, &loaded.view, None);
//! let file = file.drawn_by(&stated.name, stated.options, stated.max_error);
//! let subject = Subject { file, volume, mesh: None, title: "blobs".to_owned(), notes: Vec::new(), labels: Labels::default() };
//!
//! let renderers = RendererList { all: vec![Box::new(RayCaster::default())], usual: |_| "raycast" };
//! let document = Document::new(Arc::new(subject), Arc::new(renderers))?;
//! let (tell, told) = mpsc::channel();
//! let session = Session::start(document, &Control::default(), move |output| drop(tell.send(output)))?;
//! let (client, number) = (1, 1);
//! session.apply(client, number, &Edit::Orbit { right: 30.0, up: 10.0 })?;
//! let proven = told.iter().find_map(|output| match output {
//!     Output::Picture(picture) if picture.head.stage == Stage::Proven => Some(picture),
//!     _ => None,
//! });
//! let proven = proven.expect("it rests");
//! assert!(matches!(proven.head.error, PictureError::Proven { bound, .. } if bound == PROVEN));
//! assert_eq!((proven.head.size, proven.rgba.len()), ([48, 32], 4 * 48 * 32));
//! # Ok(())
//! # }
//! ```

pub mod message;
pub mod page;
pub mod question;
#[cfg(feature = "server")]
pub mod server;
pub mod session;
pub mod upload;
