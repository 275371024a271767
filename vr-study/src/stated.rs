//! Renderers as scene files and records state them.

use vr_core::{OptionSpec, Options, StudiedRenderer};

/// A renderer as a scene file states it, of which nothing is left open.
#[derive(Clone, Debug)]
pub struct StatedRenderer {
    /// Name.
    pub name: String,
    /// Every option with its value, but that of the error bound where that is stated on its own.
    pub options: Options,
    /// Error bound that was asked for.
    pub max_error: Option<f64>,
}

impl StatedRenderer {
    /// States a renderer that an error bound is yet to be asked of, if there is one.
    pub fn of(renderer: &dyn StudiedRenderer, max_error: Option<f64>) -> Self {
        let mut options = renderer.option_values();
        for OptionSpec { key, default, promises, .. } in renderer.option_specs() {
            // A bound by default is none that was asked for; and one alone may be stated.
            if promises && (max_error.is_some() || options.0.get(key) == Some(&default)) {
                options.0.remove(key);
            }
        }
        Self { name: renderer.name().to_owned(), options, max_error }
    }
}
