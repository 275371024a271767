//! Documentation of a renderer's settings, convergence and errors, as data that programs put to the test.

use crate::configurable::Configurable;
use crate::options::Options;
use crate::renderer::Renderer;

/// A renderer that documents itself for a study of speed against error. By default, nothing is documented.
///
/// # Examples
/// A renderer of order 2 in its step, on the page that a study reads:
/// ```
/// use vr_core::*;
///
/// #[derive(Clone, Default)]
/// struct Marcher { step: f64 }
/// # impl Configurable for Marcher {
/// #     fn options() -> OptionTable<Self> {
/// #         let range = NumberRange::at_least(0.0).up_to(16.0);
/// #         let (get, set) = (|m: &Self| m.step, |m: &mut Self, x| m.step = x);
/// #         OptionTable::new("marcher", [DeclaredOption::number("step", "length of a step", range, get, set)])
/// #     }
/// # }
/// # impl Renderer for Marcher {
/// #     fn name(&self) -> &'static str { "marcher" }
/// #     fn supports(&self, _: &Scene, _: Option<&View>) -> Result<(), RenderError> { Ok(()) }
/// #     fn prepare(&self, _: &Scene, _: &Control) -> Result<Box<dyn Prepared>, RenderError> {
/// #         Err(RenderError::Cancelled)
/// #     }
/// # }
/// impl Documented for Marcher {
///     fn settings(&self) -> Vec<NamedSetting> {
///         [1.0, 0.5].map(|step| NamedSetting::new(format!("step {step}"), &Marcher { step }, 2.0, 1e-6)).to_vec()
///     }
///     fn convergence(&self) -> Vec<ConvergenceClaim> {
///         let orders = ConvergenceOrders { smooth: 2.0, jumps: 1.0, grid: 2.0, pixels: 2.0 };
///         vec![ConvergenceClaim::new("midpoint", self, "step", 1e-7, orders)]
///     }
/// }
///
/// let marcher: &dyn StudiedRenderer = &Marcher::default();
/// assert_eq!(marcher.settings()[1].options, Options::new().with("step", 0.5));
/// assert_eq!(marcher.convergence()[0].options, Options::new(), "all options but the step are held fixed");
/// assert_eq!(marcher.option_specs()[0].key, "step");
/// ```
pub trait Documented: Renderer {
    /// The settings that are worth a try.
    fn settings(&self) -> Vec<NamedSetting> {
        Vec::new()
    }

    /// Its claims of convergence.
    fn convergence(&self) -> Vec<ConvergenceClaim> {
        Vec::new()
    }

    /// Its documented errors, as it is configured, on the hard cases (`vr_physics::cases`).
    fn hard_case_errors(&self) -> HardCaseErrors {
        HardCaseErrors::default()
    }
}

/// A setting worth measuring.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedSetting {
    /// Name, short and unique within the renderer.
    pub name: String,
    /// The options that make it.
    pub options: Options,
    /// Documented order of convergence in the step, on smooth fields and transfer functions; `None` for an exact method.
    pub order: Option<f64>,
    /// Error that no step goes below: rounding and tables.
    pub error_floor: f64,
}

impl NamedSetting {
    /// The setting that a renderer has.
    pub fn new(
        name: impl Into<String>,
        renderer: &impl Configurable,
        order: impl Into<Option<f64>>,
        error_floor: f64,
    ) -> Self {
        Self { name: name.into(), options: renderer.to_options(), order: order.into(), error_floor }
    }
}

/// A claim: as an option gets smaller, errors fall like a power of it.
///
/// Errors are against the correct pixel, or against that of the renderer's own filter where it has one
/// ([`Model::Filtered`](crate::Model::Filtered)).
#[derive(Clone, Debug, PartialEq)]
pub struct ConvergenceClaim {
    /// Name, short and unique within the renderer.
    pub name: String,
    /// Options held fixed: those that keep rounding, tables and early termination out of the way.
    pub options: Options,
    /// The option that is halved again and again: a length in voxels.
    pub key: &'static str,
    /// The value from which on it is halved.
    pub coarsest: f64,
    /// RMSE below which rounding decides, and no order can be seen.
    pub floor: f64,
    /// The exponents.
    pub orders: ConvergenceOrders,
}

impl ConvergenceClaim {
    /// A claim about a renderer, all of whose options but `key` are held fixed; it begins at 1 voxel.
    pub fn new(
        name: impl Into<String>,
        renderer: &impl Configurable,
        key: &'static str,
        floor: f64,
        orders: ConvergenceOrders,
    ) -> Self {
        let mut options = renderer.to_options();
        options.0.remove(key);
        Self { name: name.into(), options, key, coarsest: 1.0, floor, orders }
    }
}

/// Exponents with which errors fall, by what is refined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvergenceOrders {
    /// Order in the option, where field and transfer function are continuous.
    pub smooth: f64,
    /// Order in the option, where the transfer function jumps.
    pub jumps: f64,
    /// Order in the spacing of the voxels of a smooth field, the option being held fixed in voxels.
    pub grid: f64,
    /// Order in the size of a pixel: of the light that falls on a patch of the picture.
    pub pixels: f64,
}

/// Documented errors of a renderer on hard cases, by the names of these.
///
/// # Examples
/// ```
/// use vr_core::{DocumentedError, HardCaseErrors};
///
/// #[derive(Default, PartialEq)]
/// struct Marcher { skip: bool }
/// let of = |marcher| HardCaseErrors::of_default(&marcher, [("thin shell", DocumentedError::Rmse(0.02))]);
/// assert_eq!(of(Marcher::default()).for_case("thin shell"), Some(DocumentedError::Rmse(0.02)));
/// assert_eq!(of(Marcher::default()).for_case("fog"), None);
/// assert_eq!(of(Marcher { skip: true }).for_case("thin shell"), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HardCaseErrors {
    /// Errors of single cases, by name.
    pub by_case: Vec<(&'static str, DocumentedError)>,
    /// Error of every other case; `None` if nothing is documented of them.
    pub otherwise: Option<DocumentedError>,
}

impl HardCaseErrors {
    /// Errors that are documented for a renderer's default settings alone.
    pub fn of_default<R: Default + PartialEq>(
        renderer: &R,
        by_case: impl Into<Vec<(&'static str, DocumentedError)>>,
    ) -> Self {
        if *renderer == R::default() { Self { by_case: by_case.into(), otherwise: None } } else { Self::default() }
    }

    /// The error of a case; `None` where none is documented.
    pub fn for_case(&self, case: &str) -> Option<DocumentedError> {
        self.by_case.iter().find(|(name, _)| *name == case).map(|(_, error)| *error).or(self.otherwise)
    }
}

/// Documented error of a renderer in a picture, relative to max(1, largest magnitude of the picture).
///
/// If a wall or a shell decides between everything and nothing, the largest error says little: a single ray on the wrong side makes it
/// as large as it can be. The root mean square tells how many rays are.
///
/// # Examples
/// ```
/// use vr_core::DocumentedError;
///
/// let (max, rmse) = (0.3, 0.004); // of a picture, measured
/// let documented = DocumentedError::Rmse(0.005);
/// assert!(documented.choose(max, rmse) <= documented.value());
/// assert_eq!(DocumentedError::from(0.1), DocumentedError::Max(0.1));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DocumentedError {
    /// Largest error of any component of any pixel.
    Max(f64),
    /// Root mean square over all components of all pixels.
    Rmse(f64),
}

impl DocumentedError {
    /// The number, for either kind.
    pub fn value(self) -> f64 {
        match self {
            Self::Max(error) | Self::Rmse(error) => error,
        }
    }

    /// Chooses the one of a picture's largest error and its RMSE that this is about.
    pub fn choose(self, max: f64, rmse: f64) -> f64 {
        match self {
            Self::Max(_) => max,
            Self::Rmse(_) => rmse,
        }
    }
}

/// A bound of the largest error.
impl From<f64> for DocumentedError {
    fn from(error: f64) -> Self {
        Self::Max(error)
    }
}
