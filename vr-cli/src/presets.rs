//! `vr presets`.

use std::path::PathBuf;

use serde::Serialize;
use vr_core::transfer::Preset;
use vr_core::{Control, Frame, RenderError};
use vr_io::{FileInfo, LoadedVolume};
use vr_look::Survey;

use crate::args::{PresetsArgs, SceneArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::output_file;
use crate::preset_sheet::{self, Entry};
use crate::progress::under_bar;
use crate::renderers::StatedRenderer;
use crate::scene_setup::{Configured, PresetSetups, Setup};
use crate::sheet_record::{self, SinglePicture};
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
        setup.protect([("--output", &*args.output)], args.replace)?;
    }
    if let Some((_, setup)) = setups.first() {
        setup.note_unused_annotations(console);
    }
    if let (Some(folder), Some((_, setup))) = (&args.pictures, setups.first()) {
        let places: Vec<PathBuf> = setups.iter().map(|(p, _)| sheet_record::place_of(folder, p.name())).collect();
        setup.protect(places.iter().map(|place| ("--pictures", place.as_path())), args.replace)?;
    }
    let has_size = args.scene.scene.is_some() || args.scene.image.size.is_some();
    let mut drawn: Vec<(Preset, Setup, (Frame, StatedRenderer))> = Vec::new();
    for (preset, mut setup) in setups {
        if !has_size {
            setup.view.size = DEFAULT_SIZE;
        }
        let draw = |control: &Control| {
            let Configured { renderer, stated, .. } =
                setup.renderer(&args.renderer, Console { quiet: true, ..console })?;
            let draw = || Ok(renderer.prepare(&setup.scene, control)?.render(&setup.view, control)?.frame);
            match draw() {
                Ok(frame) => Ok(Some((frame, stated))),
                Err(e @ RenderError::Unsupported { .. }) => {
                    console.note(&format!("{preset} is left out: {e}"));
                    Ok(None)
                }
                Err(e) => Err(setup.render_failure(e)),
            }
        };
        if let Some(picture) = under_bar(console, control, preset.name(), draw)? {
            drawn.push((preset, setup, picture));
        }
    }
    let Some((_, first, _)) = drawn.first() else {
        return Err(Failure::failed("no preset can be drawn for this scene"));
    };
    let entries: Vec<Entry<'_>> = drawn
        .iter()
        .map(|(preset, setup, (frame, _))| Entry { frame, background: setup.scene.background, name: preset.name() })
        .collect();
    let singles: Vec<SinglePicture<'_>> = drawn
        .iter()
        .map(|(preset, setup, (frame, stated))| {
            let flags = ["--preset", preset.name()].map(str::to_owned).to_vec();
            SinglePicture { name: preset.name().to_owned(), flags, setup, stated, frame }
        })
        .collect();
    let sheet = (&*args.output, &preset_sheet::draw(&entries));
    let files = sheet_record::write(sheet, ("presets", false), &singles, args.pictures.as_deref())?;

    let volume = args.scene.volume.path.as_ref().map_or_else(|| "VOLUME".to_owned(), |path| path.display().to_string());
    let mut table = Table::of_words(&["preset", "values in", "shows"]);
    for (preset, ..) in &drawn {
        table.row([preset.name(), preset.unit().name(), preset.title()].map(str::to_owned));
    }
    let more = if args.all { "" } else { "; --all draws the others, too" };
    let text = format!(
        "scene    {}\n{table}draw one vr render {volume} --preset {}{more}\nwrote    {}{}\n",
        first.title,
        drawn[0].0,
        args.output.display(),
        match &args.pictures {
            Some(folder) => format!(", {} pictures in {}", files.len() - 1, folder.display()),
            None => String::new(),
        }
    );
    let json = Json {
        volume: &first.title,
        presets: drawn.iter().map(|(preset, ..)| PresetJson::of(*preset)).collect(),
        output: &args.output.to_string_lossy(),
        files: &files,
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
    Survey::of(&found.volume).suitable_presets(values, info.and_then(|info| info.modality.as_deref()), &hints)
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    presets: Vec<PresetJson>,
    output: &'a str,
    /// The sheet, and the single pictures if they were asked for.
    #[serde(serialize_with = "output_file::as_texts")]
    files: &'a [PathBuf],
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
