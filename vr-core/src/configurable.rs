//! Renderers whose settings are options, and renderers of any type that a study can configure.

use crate::documented::Documented;
use crate::error::OptionError;
use crate::option_table::OptionTable;
use crate::options::{OptionSpec, Options};
use crate::renderer::Renderer;

/// A renderer whose settings are named options.
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

    fn with_options(&self, options: &Options) -> Result<Box<dyn StudiedRenderer>, OptionError> {
        Ok(Box::new(self.configure(options)?))
    }
}
