//! Renderers whose settings are options, and renderers of any type that a study can configure.

use crate::documented::Documented;
use crate::error::OptionError;
use crate::option_table::OptionTable;
use crate::options::{OptionSpec, Options};
use crate::renderer::Renderer;

/// A renderer whose settings are named options.
///
/// # Examples
/// A renderer that draws nothing, with one option:
/// ```
/// use vr_core::*;
///
/// #[derive(Clone, Default)]
/// struct Marcher { step: f64 }
///
/// impl Configurable for Marcher {
///     fn options() -> OptionTable<Self> {
///         let range = NumberRange::at_least(0.0).up_to(16.0);
///         let (get, set) = (|m: &Self| m.step, |m: &mut Self, x| m.step = x);
///         OptionTable::new("marcher", [DeclaredOption::number("step", "length of a step", range, get, set)])
///     }
/// }
/// # impl Renderer for Marcher {
/// #     fn name(&self) -> &'static str { "marcher" }
/// #     fn supports(&self, _: &Scene, _: Option<&View>) -> Result<(), RenderError> { Ok(()) }
/// #     fn prepare(&self, _: &Scene, _: &Control) -> Result<Box<dyn Prepared>, RenderError> {
/// #         Err(RenderError::Cancelled)
/// #     }
/// # }
///
/// let half = Marcher::default().configure(&Options::new().with("step", 0.5))?;
/// assert_eq!(half.to_options(), Options::new().with("step", 0.5));
/// let error = half.configure(&Options::new().with("stop", 0.5)).err().unwrap();
/// assert_eq!(error.to_string(), "renderer marcher has no option 'stop'; did you mean 'step'?");
/// # Ok::<(), OptionError>(())
/// ```
pub trait Configurable: Renderer + Clone + Default + 'static {
    /// Its options: the one place where each is declared.
    fn options() -> OptionTable<Self>;

    /// The same renderer with options set; those not given keep the value that they have here.
    ///
    /// # Errors
    /// Same as for [`OptionTable::configure`].
    fn configure(&self, options: &Options) -> Result<Self, OptionError> {
        Self::options().configure(self, options)
    }

    /// Checks the numbers, and that they go together.
    ///
    /// # Errors
    /// An [`OptionError`] naming the option.
    fn validate(&self) -> Result<(), OptionError> {
        Self::options().check(self)
    }

    /// All options, with the values that this renderer has.
    fn to_options(&self) -> Options {
        Self::options().values(self)
    }
}

/// A renderer of any type that can be drawn with, configured, and held to its documentation: every [`Configurable`] one that is
/// [`Documented`].
pub trait StudiedRenderer: Documented {
    /// Description of each of its options.
    fn option_specs(&self) -> Vec<OptionSpec>;

    /// All options, with the values that this renderer has.
    fn option_values(&self) -> Options;

    /// The same renderer with options set; those not given keep the value that they have here.
    ///
    /// # Errors
    /// Same as for [`OptionTable::configure`].
    fn with_options(&self, options: &Options) -> Result<Box<dyn StudiedRenderer>, OptionError>;
}

impl<R: Configurable + Documented> StudiedRenderer for R {
    fn option_specs(&self) -> Vec<OptionSpec> {
        R::options().specs()
    }

    fn option_values(&self) -> Options {
        self.to_options()
    }

    fn with_options(&self, options: &Options) -> Result<Box<dyn StudiedRenderer>, OptionError> {
        Ok(Box::new(self.configure(options)?))
    }
}
