//! Renderers that `vr` knows.

use std::fmt::Write;

use vr_cells::{CellMarcher, CellProjector};
use vr_core::{OptionSpec, OptionValue, Options, Scene, StudiedRenderer, Volume};
use vr_light::LightRenderer;
use vr_physics::Reference;
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatter;
use vr_study::features::FeatureMatrix;
use vr_texslice::TextureSlicer;

use crate::failure::Failure;
use crate::wrapping::wrapped;

pub use vr_study::stated::StatedRenderer;

/// Returns every renderer, one line each.
pub fn all() -> Vec<Box<dyn StudiedRenderer>> {
    vec![
        Box::new(RayCaster::default()),
        Box::new(ShearWarp::default()),
        Box::new(TextureSlicer::default()),
        Box::new(Splatter::default()),
        Box::new(CellMarcher::default()),
        Box::new(CellProjector::default()),
        Box::new(LightRenderer::default()),
        Box::new(Reference::default()),
    ]
}

/// Returns the renderer of a name.
///
/// # Errors
/// The fault of the name, in one line.
pub fn named(name: &str) -> Result<Box<dyn StudiedRenderer>, String> {
    let known = all();
    let names = known.iter().map(|r| r.name()).collect::<Vec<_>>().join(", ");
    known
        .into_iter()
        .find(|r| r.name() == name)
        .ok_or_else(|| format!("render.renderer: found {name:?}; must be one of {names}"))
}

/// Returns the name of the renderer that draws a scene where no other is named.
pub fn usual(scene: &Scene) -> &'static str {
    match &scene.volume {
        _ if scene.scattering.is_some() => "light",
        // No ray caster finds the few points, of all, that a ray meets.
        Volume::Points(_) => "splat",
        Volume::Cells(_) => "march",
        _ => "raycast",
    }
}

/// Returns the renderers of these names; all renderers if there are no names.
///
/// # Errors
/// [`Failure::Usage`] for an unknown name.
pub fn chosen(names: &[String]) -> Result<Vec<Box<dyn StudiedRenderer>>, Failure> {
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

/// Adds the options that the command line sets, as it spells them.
pub fn with_flags(mut options: Options, flags: &[(String, String)]) -> Options {
    for (key, value) in flags {
        options.0.insert(key.clone(), OptionValue::parse(value));
    }
    options
}

/// Returns the features by renderer, for the help text and beside a comparison.
pub fn feature_table() -> String {
    let matrix = FeatureMatrix::of(&all());
    format!("Features (yes: drawn; some: in some settings; -: refused; the reasons: vr help features):\n{matrix}")
}

/// Returns the page on the features of every renderer, with the reason for each that is refused.
pub fn feature_page() -> String {
    let renderers = all();
    let matrix = FeatureMatrix::of(&renderers).with_depths(&renderers).page();
    format!("# Features of scenes, by renderer\n\n{FEATURES}\n\n{matrix}")
}

/// First lines of the page on features.
const FEATURES: &str = "\
Each renderer was asked whether it draws a small scene that has the feature. yes: drawn; some: in some settings, not at the
defaults; -: refused. The reasons stand under the table. `vr help features` prints this page.";

/// Returns the page on a renderer: the options that `--set` takes; `None` if there is no renderer of that name.
pub fn option_help(name: &str) -> Option<String> {
    let renderer = named(name).ok()?;
    let mut text = format!("Options of {name} (--set KEY=VALUE; here with their defaults):\n");
    for OptionSpec { key, kind, default, help, only_with, .. } in renderer.option_specs() {
        let only_with = only_with.map(|setting| format!("; only with {setting}")).unwrap_or_default();
        let setting = format!("{key}={default}");
        let mut margin = format!("  {setting:<SETTING_WIDTH$}");
        for paragraph in [help.to_owned(), format!("{kind}{only_with}")] {
            for line in wrapped(&paragraph, |line| line.chars().count() <= HELP_WIDTH) {
                let _ = writeln!(text, "{margin}  {line}");
                margin = " ".repeat(2 + SETTING_WIDTH);
            }
        }
    }
    Some(text)
}

/// Width of an option and its default in the help text, in characters.
const SETTING_WIDTH: usize = 28;
/// Width of an option's description in the help text, in characters.
const HELP_WIDTH: usize = 78;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_has_every_option_in_short_lines() {
        for renderer in all() {
            let help = option_help(renderer.name()).unwrap();
            assert!(help.lines().all(|line| line.chars().count() <= 2 + SETTING_WIDTH + 2 + HELP_WIDTH), "{help}");
            for OptionSpec { key, default, .. } in renderer.option_specs() {
                assert!(help.contains(&format!("  {key}={default} ")), "{key}: {help}");
            }
        }
        assert_eq!(option_help("no-such"), None);
    }
}
