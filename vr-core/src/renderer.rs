//! The seam: everything that draws scenes stands behind [`Renderer`].

use crate::claim::{DocumentedError, OrderClaim};
use crate::control::Control;
use crate::error::{OptionError, RenderError};
use crate::frame::Frame;
use crate::model::Model;
use crate::options::{OptionSpec, Options};
use crate::probe::Probe;
use crate::scene::Scene;
use crate::stats::RenderStats;
use crate::view::View;

/// A way to draw scenes.
pub trait Renderer: Send + Sync {
    /// Its name, as scene files and command lines use it.
    fn name(&self) -> &'static str;

    /// The options it has.
    fn options(&self) -> &[OptionSpec];

    /// The same renderer with options set; those not given keep the value that they have here.
    ///
    /// # Errors
    /// [`OptionError`] for an option that it does not have, or a value that it does not take.
    fn configure(&self, options: &Options) -> Result<Box<dyn Renderer>, OptionError>;

    /// The settings that a study of speed against error should try.
    fn settings(&self) -> Vec<NamedSetting>;

    /// What its documentation says of convergence, in a form that a program can put to the test.
    fn orders(&self) -> Vec<OrderClaim> {
        Vec::new()
    }

    /// The error that it documents, as it is configured, for a hard case of that name (`vr_physics::cases`); `None` where it documents
    /// none.
    fn hard_case_error(&self, _case: &str) -> Option<DocumentedError> {
        None
    }

    /// Does all that can be done before the view is known.
    ///
    /// # Errors
    /// [`RenderError::Unsupported`] for a scene that it cannot draw; never a silently different picture.
    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError>;
}

/// A renderer that has seen its scene.
///
/// A frame is a function of scene, view and options only, never of earlier frames: `&mut self` is for caches.
pub trait Prepared: Send {
    /// Takes over a changed scene, redoing only what the change makes necessary.
    ///
    /// # Errors
    /// As [`Renderer::prepare`].
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError>;

    /// Draws a view.
    ///
    /// # Errors
    /// A view that makes no sense, cancellation, or what the renderer cannot do.
    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError>;

    /// What this renderer integrates: it is judged against the canonical pixel, and against this done exactly.
    fn model(&self, view: &View) -> Model;

    /// What was done for the ray through the centre of pixel (x, y) of a view; `None` from a renderer that cannot tell.
    ///
    /// It is about that ray even where the picture's pixel is made otherwise: as a mean of several, or from its neighbours.
    ///
    /// # Errors
    /// As [`Self::render`]; a pixel that the view does not have.
    fn probe(&mut self, _view: &View, _pixel: [u32; 2], _control: &Control) -> Result<Option<Probe>, RenderError> {
        Ok(None)
    }
}

/// A frame and what it took.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// What was done for it.
    pub stats: RenderStats,
}

/// A setting worth measuring, with what its documentation promises.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSetting {
    /// Short and unique within the renderer.
    pub name: String,
    /// The options that make it.
    pub options: Options,
    /// Documented order of convergence in the step, on smooth fields and transfer functions; `None` for an exact method.
    pub order: Option<f64>,
    /// Error that no step goes below: rounding and tables.
    pub error_floor: f64,
}
