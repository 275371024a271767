//! Session: a scene that takes edits and gives pictures of itself, each better than the one before while nothing changes.
//!
//! A thread draws, or the caller [step by step](Painter). After an edit comes a [draft](Stage::Draft), by the setting and at the size of least error that thirty pictures a second allow, found by trials at
//! rest; when no edit has come for a tenth of a second, all pixels by a quick setting, then by the renderer's own, whose error is then measured against the reference; at last, by renderers that can, a picture
//! each of whose pixels is within a proven bound. What has become stale is cancelled through [`Control`](vr_core::Control).

mod describe;
mod desk;
mod document;
mod edit;
mod engine;
mod error;
mod error_map;
mod export;
mod handle;
mod label_look;
mod moving;
mod navigation;
mod output;
mod pace;
mod painter;
mod pick;
mod picture;
mod ray_plot;
mod second;
mod slice;
mod subject;
mod upsampled;
mod value_at;

pub use describe::{Opened, State};
pub use document::{Document, MAX_PIXELS};
pub use edit::{Edit, PROVEN, Quality, Side};
pub use error::{EditError, TruthError};
pub use error_map::ErrorMap;
pub use export::{Export, ExportError};
pub use handle::Session;
pub use label_look::LabelFiles;
pub use output::Output;
pub use pace::{FRAME_TIME, Pace};
pub use painter::{Painter, Step};
pub use pick::Pick;
pub use picture::{ClientId, Head, Orientation, Picture, PictureError, Stage};
pub use ray_plot::{PlotPart, RayPlot};
pub use second::{SecondPicture, Setting};
pub use slice::{MAX_SLICE_SIDE, Place, PlaceLabel, Slice, SliceQuery};
pub use subject::{Labels, RendererList, Subject};
