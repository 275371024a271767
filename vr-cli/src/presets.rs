//! `vr presets`.

use serde::Serialize;
use vr_core::transfer::Preset;
use vr_core::{Control, Frame, RenderError};
use vr_io::{FileInfo, LoadedVolume, PngOptions};
use vr_look::Survey;

use crate::args::{PresetsArgs, SceneArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::output_file;
use crate::preset_sheet::{self, Entry};
use crate::progress::under_bar;
use crate::scene_setup::{PresetSetups, Setup};
use crate::table::Table;

/// Size of the pictures where none is given.
const DEFAULT_SIZE: [u32; 2] = [256, 256];

/// Draws the volume under each preset that suits it, and writes the sheet.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the sheet.
pub fn run(args: &PresetsArgs, console: Console, control: &Control) -> Result<(), Failure> {
    args.scene.image.check_opaque()?;
    output_file::check(&args.output, &["png"])?;
    refuse_transfer(&args.scene)?;
    let choose = |found: &LoadedVolume| if args.all { Preset::ALL.to_vec() } else { suitable(found) };
    let PresetSetups { setups, notes } = PresetSetups::new(&args.scene, choose, console)?;
    for (_, setup) in &setups {
        setup.protect([("--output", &*args.output)])?;
    }
    let has_size = args.scene.scene.is_some() || args.scene.image.size.is_some();
    let mut drawn: Vec<(Preset, Setup, Frame)> = Vec::new();
    for (preset, mut setup) in setups {
        if !has_size {
            setup.view.size = DEFAULT_SIZE;
        }
        let draw = |control: &Control| {
            let renderer = setup.renderer(&args.renderer, Console { quiet: true, ..console })?.renderer;
            let draw = || Ok(renderer.prepare(&setup.scene, control)?.render(&setup.view, control)?.frame);
            match draw() {
                Ok(frame) => Ok(Some(frame)),
                Err(e @ RenderError::Unsupported { .. }) => {
                    console.note(&format!("{preset} is left out: {e}"));
                    Ok(None)
                }
                Err(e) => Err(setup.render_failure(e)),
            }
        };
        if let Some(frame) = under_bar(console, control, preset.name(), draw)? {
            drawn.push((preset, setup, frame));
        }
    }
    let Some((_, first, _)) = drawn.first() else {
        return Err(Failure::failed("no preset can be drawn for this scene"));
    };
    let entries: Vec<Entry<'_>> = drawn
        .iter()
        .map(|(preset, setup, frame)| Entry { frame, background: setup.scene.background, name: preset.name() })
        .collect();
    vr_io::write(&args.output, &preset_sheet::draw(&entries), &PngOptions::default()).map_err(Failure::failed)?;

    let volume = args.scene.volume.path.as_ref().map_or_else(|| "VOLUME".to_owned(), |path| path.display().to_string());
    let mut table = Table::of_words(&["preset", "values in", "shows"]);
    for (preset, ..) in &drawn {
        table.row([preset.name(), preset.unit().name(), preset.title()].map(str::to_owned));
    }
    let more = if args.all { "" } else { "; --all draws the others, too" };
    let text = format!(
        "scene    {}\n{table}draw one vr render {volume} --preset {}{more}\nwrote    {}\n",
        first.title,
        drawn[0].0,
        args.output.display()
    );
    let json = Json {
        volume: &first.title,
        presets: drawn.iter().map(|(preset, ..)| PresetJson::of(*preset)).collect(),
        output: &args.output.to_string_lossy(),
        notes: &notes,
    };
    console.result(&text, &json)
}

/// Refuses flags that name another transfer function.
fn refuse_transfer(scene: &SceneArgs) -> Result<(), Failure> {
    let transfer = &scene.transfer;
    let given = [
        ("--preset", transfer.preset.is_some()),
        ("--transfer", transfer.transfer.is_some()),
        ("--look", transfer.look.is_some()),
        ("--point", !transfer.point.is_empty()),
        ("--transfer-box", !transfer.transfer_box.is_empty()),
    ];
    match given.iter().find(|g| g.1) {
        Some((flag, _)) => Err(Failure::usage(format!("{flag}: every preset is drawn; vr render draws one alone"))),
        None => Ok(()),
    }
}

/// The presets that suit a volume.
fn suitable(found: &LoadedVolume) -> Vec<Preset> {
    let info = found.info.as_ref();
    let hints = info.map(FileInfo::hints).unwrap_or_default();
    let values = found.volume.value_range().unwrap_or((0.0, 1.0));
    Survey::new(&found.volume).suitable_presets(values, info.and_then(|info| info.modality.as_deref()), &hints)
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    presets: Vec<PresetJson>,
    output: &'a str,
    notes: &'a [String],
}

#[derive(Serialize)]
struct PresetJson {
    name: &'static str,
    shows: &'static str,
    values_in: &'static str,
}

impl PresetJson {
    fn of(preset: Preset) -> Self {
        Self { name: preset.name(), shows: preset.title(), values_in: preset.unit().name() }
    }
}
