//! Help: the short form of a command's flags, and pages on renderers and names (`vr help TOPIC`).

use std::fmt::Write;

use clap::{ArgAction, Command};
use vr_core::phantom;
use vr_core::transfer::Preset;

use crate::args::HelpArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::renderers;

/// Exit codes, which scripts rely on.
pub const EXIT_CODES: &str = "\
Exit codes:
  0  done; an error bound that was asked for (--max-error) is proven for every pixel
  1  failed: a file, the scene in it, the disk, a check that did not pass
  2  wrong usage: the command line asks for something impossible, or for writing over a file that is read
  3  done and written, but the error bound could not be proven for every pixel; stderr says for how many, even under --quiet
  130  ended by Ctrl-C; nothing is half written";

/// Last lines of the short help of commands that draw.
const MORE: &str = "\
All flags: --help. Renderers, their features and options: vr help renderers, vr help raycast. Names: vr help presets, vr help phantoms.";

/// Commands that draw scenes: their flags are too many for a screen.
const DRAWING: [&str; 10] =
    ["render", "compare", "bench", "report", "turntable", "animate", "presets", "scene", "ray", "physics"];

/// Flags of the headings below that the short help shows; flags of other headings are all shown.
const ESSENTIAL: [&str; 29] = [
    "path",
    "phantom",
    "scene",
    "preset",
    "transfer",
    "no_shading",
    "model",
    "labels",
    "mesh",
    "azimuth",
    "elevation",
    "fov",
    "size",
    "background",
    "crop",
    "compositing",
    "renderer",
    "set",
    "quality",
    "max_error",
    "target_rmse",
    "outputs",
    "annotate",
    "show",
    "error",
    "frames",
    "turn",
    "time_series",
    "quiet",
];

/// Headings with too many flags for the short help.
const LONG: [&str; 15] = [
    "Volume",
    "Scene",
    "Transfer function",
    "Shading",
    "Scattering",
    "Labels",
    "Opaque surface",
    "Camera",
    "Image",
    "Compositing",
    "Annotations",
    "Turn",
    "Animation",
    "Output",
    "Reference pixels",
];

/// Adds what help alone needs to the command: the last lines, the features of renderers, and the short form.
pub fn complete(command: Command) -> Command {
    let features = renderers::feature_table();
    DRAWING.iter().fold(command.after_help(EXIT_CODES), |command, name| {
        command.mut_subcommand(name, |sub| {
            let long = match *name {
                "render" => format!("{features}\n{MORE}\n\n{EXIT_CODES}"),
                _ => format!("{MORE}\n\n{EXIT_CODES}"),
            };
            shortened(sub.after_help(MORE).after_long_help(long))
        })
    })
}

/// Leaves the rarer flags to the long help and, so that the rest fits a screen, the headings, too.
fn shortened(command: Command) -> Command {
    let is_short = std::env::args().any(|arg| arg == "-h");
    command.mut_args(|arg| {
        let is_long = arg.get_help_heading().is_some_and(|heading| LONG.contains(&heading));
        let is_global = arg.is_global_set();
        let is_help = matches!(arg.get_action(), ArgAction::Help | ArgAction::HelpShort | ArgAction::HelpLong);
        let is_rare = (is_long || is_global) && !is_help && !ESSENTIAL.contains(&arg.get_id().as_str());
        let arg = if is_rare { arg.hide_short_help(true) } else { arg };
        if !is_short {
            return arg;
        }
        let takes_values = arg.get_action().takes_values();
        arg.help_heading(None::<&str>).hide_possible_values(takes_values)
    })
}

/// Prints the page of a topic: a command, a renderer, `renderers`, `features`, `keys` of scene files, `presets` or `phantoms`; without one, the list of commands.
///
/// # Errors
/// [`Failure::Usage`] for an unknown topic, with all that are known.
pub fn run(args: &HelpArgs, command: Command) -> Result<(), Failure> {
    let mut command = complete(command);
    command.build();
    let page = match args.topic.as_deref().unwrap_or_default() {
        "" => command.render_help().to_string(),
        "renderers" => format!("{}\n{}", renderers::feature_table(), renderer_list()),
        "features" => renderers::feature_page(),
        "keys" => vr_io::scene_keys(),
        "presets" => presets(),
        "phantoms" => phantoms(),
        topic => match command.find_subcommand_mut(topic) {
            // One word is both a command and a renderer.
            Some(sub) => {
                sub.render_long_help().to_string()
                    + &renderers::option_help(topic).map(|page| format!("\n{page}")).unwrap_or_default()
            }
            None => renderers::option_help(topic).ok_or_else(|| unknown(topic, &command))?,
        },
    };
    Console::page(&page)
}

fn unknown(topic: &str, command: &Command) -> Failure {
    let mut commands: Vec<String> = command.get_subcommands().map(|sub| sub.get_name().to_owned()).collect();
    commands.sort_unstable();
    let renderers = renderers::all().into_iter().map(|r| r.name().to_owned());
    let pages = ["renderers", "features", "keys", "presets", "phantoms"].map(str::to_owned);
    let known: Vec<String> = commands.into_iter().chain(renderers).chain(pages).collect();
    Failure::usage(format!("help: found {topic:?}; must be one of {}", known.join(", ")))
}

fn renderer_list() -> String {
    let names: Vec<String> = renderers::all().iter().map(|r| format!("vr help {}", r.name())).collect();
    format!("Options of a renderer: {}\n", names.join(", "))
}

fn presets() -> String {
    let mut text = "Presets (--preset NAME), the unit of their values, and what they show:\n".to_owned();
    for preset in Preset::ALL {
        let _ = writeln!(text, "  {:<16} {:<20} {}", preset.name(), preset.unit().name(), preset.title());
    }
    text + "vr presets VOLUME draws those that suit a volume; vr tf NAME prints one.\n"
}

fn phantoms() -> String {
    format!(
        "Phantoms (--phantom NAME):\n  grids   {}\n  points  {}\n",
        phantom::NAMES.join(", "),
        phantom::POINT_NAMES.join(", ")
    )
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;
    use crate::args::Cli;

    #[test]
    fn essential_flags_exist() {
        let command = Cli::command();
        let all = || DRAWING.iter().flat_map(|name| command.find_subcommand(name).unwrap().get_arguments());
        for id in ESSENTIAL {
            assert!(all().chain(command.get_arguments()).any(|arg| arg.get_id() == id), "no flag {id}");
        }
        for heading in LONG {
            assert!(all().any(|arg| arg.get_help_heading() == Some(heading)), "no heading {heading}");
        }
    }
}
