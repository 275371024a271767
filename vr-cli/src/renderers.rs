//! Every renderer that `vr` knows.

use std::fmt::Write;

use vr_core::{Geometry, OptionKind, OptionValue, Options, ParameterError, RenderError, Renderer, Volume};
use vr_physics::Reference;
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatting;
use vr_texslice::TexSlice;

use crate::failure::Failure;

/// All of them, one line each.
pub fn all() -> Vec<Box<dyn Renderer>> {
    vec![
        Box::new(RayCaster::default()),
        Box::new(ShearWarp::default()),
        Box::new(TexSlice::default()),
        Box::new(Splatting::default()),
        Box::new(Reference::default()),
    ]
}

/// The renderer of a name.
///
/// # Errors
/// What is wrong with the name, in one line.
pub fn named(name: &str) -> Result<Box<dyn Renderer>, String> {
    let known = all();
    let names = known.iter().map(|r| r.name()).collect::<Vec<_>>().join(", ");
    known
        .into_iter()
        .find(|r| r.name() == name)
        .ok_or_else(|| format!("render.renderer: found {name:?}; must be one of {names}"))
}

/// Returns the name of the renderer that draws volumes of a kind where no other is named.
pub fn usual(volume: &Volume) -> &'static str {
    match volume.geometry() {
        // No ray caster finds the few points, of all, that a ray meets.
        Geometry::Points(_) => "splat",
        _ => "raycast",
    }
}

/// Those of the names; all where there are none.
///
/// # Errors
/// [`Failure::Usage`] for an unknown name.
pub fn chosen(names: &[String]) -> Result<Vec<Box<dyn Renderer>>, Failure> {
    match names {
        [] => Ok(all()),
        names => {
            let mut each: Vec<&String> = Vec::new();
            names.iter().for_each(|n| {
                if !each.contains(&n) {
                    each.push(n)
                }
            });
            each.into_iter().map(|n| named(n)).collect::<Result<_, _>>().map_err(Failure::usage)
        }
    }
}

/// Options with those that the command line sets, as it spells them.
pub fn with_flags(mut options: Options, flags: &[(String, String)]) -> Options {
    for (key, value) in flags {
        options.0.insert(key.clone(), OptionValue::parse(value));
    }
    options
}

/// Options under which a renderer promises a largest error: those that have an option `max-error` are told it; for those that have
/// `tolerance`, half of it leaves room for storing pixels as f32; the others refuse.
///
/// # Errors
/// A renderer that cannot promise, or a promise that no picture can keep.
pub fn promise(renderer: &dyn Renderer, options: Options, max_error: f64) -> Result<Options, RenderError> {
    let key = promising_option(renderer);
    let Some(option) = renderer.options().iter().find(|option| Some(option.key) == key) else {
        let feature = "max_error: it cannot promise one".to_owned();
        return Err(RenderError::Unsupported { renderer: renderer.name(), feature });
    };
    if max_error.is_nan() || max_error < LEAST_MAX_ERROR {
        return Err(
            ParameterError::new("render.max_error", max_error, "must be at least 1e-6: pictures are f32").into()
        );
    }
    let wanted = if option.key == TOLERANCE { 0.5 * max_error } else { max_error };
    let most = if let OptionKind::Number { most, .. } = option.kind { most } else { wanted };
    Ok(options.with(option.key, wanted.min(most)))
}

/// The option by which a renderer is told what to promise; `None` for one that cannot.
pub fn promising_option(renderer: &dyn Renderer) -> Option<&'static str> {
    [MAX_ERROR, TOLERANCE].into_iter().find(|key| renderer.options().iter().any(|option| option.key == *key))
}

/// The smallest error that is promised. Frames are f32: rounding is half of this at most.
pub const LEAST_MAX_ERROR: f64 = 1e-6;

/// The option in which a promise is expressed.
pub const MAX_ERROR: &str = "max-error";
/// The same, of a renderer of which it is the accuracy.
pub const TOLERANCE: &str = "tolerance";

/// What `--set` takes, for the help text.
pub fn option_help() -> String {
    let mut text = String::new();
    for renderer in all() {
        let _ = writeln!(text, "Options of {} (--set KEY=VALUE):", renderer.name());
        for option in renderer.options() {
            let _ = writeln!(text, "  {}={}  {} ({})", option.key, option.default, option.help, option.kind);
        }
        text.push('\n');
    }
    text
}
