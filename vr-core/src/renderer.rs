//! Interface of renderers: [`Renderer`], and [`Prepared`] for one that has seen its scene.

use crate::control::Control;
use crate::error::{OptionError, RenderError};
use crate::frame::Frame;
use crate::model::Model;
use crate::probe::Probe;
use crate::scene::Scene;
use crate::stats::{Counts, RenderStats};
use crate::unsupported::{Feature, Unsupported};
use crate::view::View;

/// A way to draw scenes.
///
/// # Examples
/// ```
/// use vr_core::*;
///
/// fn draw(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Result<Frame, RenderError> {
///     renderer.supports(scene, Some(view))?;
///     let control = Control::default();
///     let mut prepared = renderer.prepare(scene, &control)?;
///     Ok(prepared.render(view, &control)?.frame)
/// }
/// # struct Blank;
/// # impl Renderer for Blank {
/// #     fn name(&self) -> &'static str { "blank" }
/// #     fn supports(&self, _: &Scene, _: Option<&View>) -> Result<(), RenderError> { Ok(()) }
/// #     fn prepare(&self, _: &Scene, _: &Control) -> Result<Box<dyn Prepared>, RenderError> { Ok(Box::new(Blank)) }
/// # }
/// # impl Prepared for Blank {
/// #     fn update(&mut self, _: &Scene, _: &Control) -> Result<(), RenderError> { Ok(()) }
/// #     fn render(&mut self, view: &View, _: &Control) -> Result<Rendered, RenderError> {
/// #         let pixels = vec![[0.0; 4]; (view.size[0] * view.size[1]) as usize];
/// #         Ok(Rendered { frame: Frame::new(view.size, pixels, None), stats: RenderStats::default() })
/// #     }
/// #     fn model(&self, _: &View) -> Result<Model, RenderError> { Ok(Model::Canonical) }
/// # }
/// let scene = phantom::by_name("fog").unwrap().scene(5)?;
/// let view = View::new(Camera::framing(scene.bounds(), 0.0, 0.0, None), [4, 3]);
/// # let renderer = Blank; // `vr_raycast::RayCaster::default()`, say
/// assert_eq!(draw(&renderer, &scene, &view)?.size(), [4, 3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Renderer: Send + Sync {
    /// Name in scene files and on the command line.
    fn name(&self) -> &'static str;

    /// Checks that it can draw a scene, and a view of it if one is given, as it is configured: cheap, for no voxel is looked at.
    ///
    /// # Errors
    /// [`RenderError::Unsupported`] with the feature that it lacks and the reason; or an error of the scene or the view themselves.
    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError>;

    /// Does all that can be done before the view is known.
    ///
    /// # Errors
    /// Same as for [`Self::supports`]: nothing else is ever prepared in place of what cannot be drawn.
    fn prepare(&self, scene: &Scene, control: &Control) -> Result<Box<dyn Prepared>, RenderError>;

    /// Largest error that it promises, as it is configured, of any component of a pixel, in units of max(1, the picture's largest
    /// magnitude); `None` if it promises none. Pixels for which it cannot prove that are counted
    /// ([`Counts::unbounded`](crate::Counts::unbounded)).
    fn max_error(&self) -> Option<f64> {
        None
    }

    /// The same renderer, promising a largest error; `None` from one that cannot promise.
    ///
    /// # Errors
    /// [`OptionError`] for an error that no picture can keep (below [`MIN_MAX_ERROR`]), or settings that the promise does not go with.
    fn with_max_error(&self, _error: f64) -> Option<Result<Box<dyn Renderer>, OptionError>> {
        None
    }
}

/// Smallest error that can be promised: frames are f32.
pub const MIN_MAX_ERROR: f64 = 1e-6;

/// A renderer that has seen its scene.
///
/// A frame is a function of scene, view and options only, never of earlier frames: `&mut self` is for caches.
pub trait Prepared: Send {
    /// Takes over a changed scene, redoing only what the change makes necessary.
    ///
    /// # Errors
    /// Same as for [`Renderer::prepare`].
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError>;

    /// Draws a view.
    ///
    /// # Errors
    /// Same as for [`View::validate`]; also [`RenderError::Cancelled`] or [`RenderError::Unsupported`].
    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError>;

    /// The model that this renderer integrates: it is judged against the correct pixel, and against the reference of this model.
    ///
    /// # Errors
    /// Same as for [`Self::render`].
    fn model(&self, view: &View) -> Result<Model, RenderError>;

    /// Returns the model if it differs from [`Model::Canonical`]; `None` if it does not, or if the renderer has no [`Model`] to describe it.
    ///
    /// # Errors
    /// Same as for [`Self::render`].
    fn own_model(&self, view: &View) -> Result<Option<Model>, RenderError> {
        match self.model(view) {
            Ok(Model::Canonical) => Ok(None),
            Ok(model) => Ok(Some(model)),
            Err(RenderError::Unsupported(Unsupported { feature: Feature::Model, .. })) => Ok(None),
            Err(other) => Err(other),
        }
    }

    /// Record of the steps along the ray through the centre of pixel (x, y) of a view; `None` from a renderer that keeps none.
    ///
    /// It is about that ray even where the picture's pixel is made otherwise: as a mean of several, or from its neighbours.
    ///
    /// # Errors
    /// Same as for [`Self::render`]; also an error for a pixel that the view does not have.
    fn probe(&mut self, _view: &View, _pixel: [u32; 2], _control: &Control) -> Result<Option<Probe>, RenderError> {
        Ok(None)
    }

    /// Draws some pixels (x, y) of a view alone, each as its own rays make it; `None` from a renderer whose pixels cannot be drawn one by one.
    ///
    /// # Errors
    /// Same as for [`Self::render`]; also an error for a pixel that the view does not have.
    fn pixels(
        &mut self,
        _view: &View,
        _pixels: &[[u32; 2]],
        _control: &Control,
    ) -> Result<Option<DrawnPixels>, RenderError> {
        Ok(None)
    }
}

/// Some pixels of a view, and the work that they took.
#[derive(Clone, Debug)]
pub struct DrawnPixels {
    /// Premultiplied linear RGBA of each, in the order in which they were asked for.
    pub rgba: Vec<[f32; 4]>,
    /// The work done for them.
    pub counts: Counts,
}

/// A frame and the work that it took.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub frame: Frame,
    /// The work done for it.
    pub stats: RenderStats,
}
