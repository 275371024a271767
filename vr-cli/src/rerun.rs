//! `vr rerun`.

use std::path::{Path, PathBuf};

use serde::Serialize;
use vr_core::{Control, Frame};
use vr_io::{FileName, FileRecord, PictureRecord, SceneFile, StoredPixels, VolumeSource, volume_hash};

use crate::annotate::Annotations;
use crate::args::{RendererArgs, RerunArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::inputs::Inputs;
use crate::picture_record::VERSION;
use crate::render::draw;
use crate::scene_setup::{Setup, title};
use crate::{output_file, sheet_record};

/// Draws a picture again from the record in it, and compares the two bit for bit.
///
/// # Errors
/// A picture without a record, a volume that is not the recorded one, pixels that differ, or any fault of the files.
pub fn run(args: &RerunArgs, console: Console, control: &Control) -> Result<(), Failure> {
    let picture = &args.picture;
    if let Some(place) = &args.output {
        output_file::check(place, &["png", "exr"])?;
    }
    let found = vr_io::read_record(picture).map_err(Failure::failed)?.ok_or_else(|| {
        let message = "no record of vr in it; vr render writes one into each PNG and EXR, unless --no-record is given or another \
                       program has saved the picture since";
        Failure::failed(format!("{}: {message}", picture.display()))
    })?;
    if let Some(sheet) = &found.record.sheet {
        return Err(sheet_record::refusal(picture, sheet));
    }
    let recorded = found.record.picture.clone().ok_or_else(|| {
        Failure::failed(format!("{}: the record in it is damaged: it says nothing of the pixels", picture.display()))
    })?;

    // Set up the scene around the volume that is there now.
    let file = with_files(args, &found)?;
    let setup = Setup::of_file(&file, console)?;
    if let Some(place) = &args.output {
        let inputs = setup.inputs.iter().cloned().chain([picture.clone()]);
        Inputs::new("a file that is read", inputs).permit("--output", place, args.replace)?;
    }
    let strangers = strangers(args, &found, &setup)?;
    if let (Some(stranger), false) = (strangers.first(), args.anyway) {
        return Err(Failure::failed(format!("{stranger}; --anyway goes on with it")));
    }
    for stranger in &strangers {
        console.note(stranger);
    }

    // Draw, and compare with what was recorded and with what is in the file.
    let none = RendererArgs { renderer: None, set: Vec::new(), quality: None, max_error: None };
    let drawn = draw(&none, &setup, console, control)?;
    let background = setup.scene.background;
    let annotations = Annotations::new(&setup, console)?;
    let annotated = annotations.map(|over| over.over(&drawn.frame, &recorded.png(background), console));
    let frame = annotated.as_ref().unwrap_or(&drawn.frame);
    let now = recorded.pixels(frame, background);
    let then = StoredPixels::read(picture).map_err(Failure::failed)?;
    let outcome = Outcome {
        as_recorded: now.hash() == recorded.hash,
        untouched: then.hash() == recorded.hash,
        differing: then.differing(&now),
        size: then.size(),
    };
    if let Some(place) = &args.output {
        write(place, &found, &outcome, &setup, frame)?;
    }
    let json = Json {
        picture: picture.display().to_string(),
        volume: &setup.title,
        renderer: &drawn.renderer,
        recorded_version: &found.record.version,
        version: VERSION,
        same_volume: strangers.is_empty(),
        same_pixels: outcome.is_same(),
        differing_pixels: outcome.differing,
        changed_since: !outcome.untouched,
        output: args.output.as_ref(),
    };
    console.result(&json.text(&outcome), &json)?;
    outcome.verdict(picture, &found, &setup, strangers.is_empty())
}

/// Returns the recorded scene with the files that flags name in place of names.
fn with_files(args: &RerunArgs, found: &PictureRecord) -> Result<SceneFile, Failure> {
    let mut file = found.scene.clone();
    let shown = args.picture.display();
    match (&mut file.volume.source, &args.volume) {
        (Some(VolumeSource::File(source)), Some(path)) => {
            source.path = path.into();
            source.series = args.series.clone().or(source.series.take());
        }
        (Some(VolumeSource::File(source)), None) => {
            let message = format!("the picture is of a file, {}: name it, as in vr rerun {shown} VOLUME", source.path);
            return Err(Failure::usage(message));
        }
        (_, Some(path)) => {
            let message = format!(
                "{}: {shown} needs no volume: all of it is in the record ({}); leave it out",
                path.display(),
                found.record.volume.title
            );
            return Err(Failure::usage(message));
        }
        (_, None) => {}
    }
    let set = |recorded, given: &Option<PathBuf>, words| set_path(recorded, given.as_deref(), words, args);
    let mesh = file.mesh.as_mut().map(|mesh| &mut mesh.path);
    set(mesh, &args.mesh, ["--mesh", "shows a mesh", "it", "shows no mesh"])?;
    let labels = file.labels.as_mut().map(|labels| &mut labels.file);
    set(labels, &args.labels, ["--labels", "shows labels", "them", "shows no labels"])?;
    let map = file.scattering.as_mut().and_then(|scattering| scattering.environment_map.as_mut());
    let words = ["--environment-map", "is lit by an environment map", "it", "is lit by none"];
    set(map, &args.environment_map, words)?;
    Ok(file)
}

/// Sets the path of a file that the record knows by name alone. The words are its flag, that the picture has it, a pronoun for it, and that the picture
/// has none.
fn set_path(
    recorded: Option<&mut FileName>,
    given: Option<&Path>,
    [flag, has, pronoun, has_none]: [&str; 4],
    args: &RerunArgs,
) -> Result<(), Failure> {
    match (recorded, given) {
        (Some(recorded), Some(path)) => *recorded = path.into(),
        (Some(recorded), None) => {
            let message = format!("the picture {has}, {recorded}: name {pronoun} with {flag} FILE");
            return Err(Failure::usage(message));
        }
        (None, Some(_)) => {
            return Err(Failure::usage(format!("{flag}: {} {has_none}; leave it out", args.picture.display())));
        }
        (None, None) => {}
    }
    Ok(())
}

/// Returns a sentence about each file that is not the recorded one.
fn strangers(args: &RerunArgs, found: &PictureRecord, setup: &Setup) -> Result<Vec<String>, Failure> {
    let mut strangers = Vec::new();
    let recorded = &found.record.volume;
    if volume_hash(&setup.unlabelled.volume) != recorded.hash {
        // Without folders, and without the names of a patient's files: as the record has it.
        let own = setup.file.clone().without_folders(setup.info.as_ref());
        let own = title(&own.volume, &setup.scene.volume);
        strangers.push(match &args.volume {
            Some(path) => format!(
                "{}: not the volume of the picture: its content has another hash (size, placement, type or a voxel differs); the picture \
                 is of {}, this is {own}",
                path.display(),
                recorded.title
            ),
            None => format!("{own}: this version of vr makes another volume of it than the one that drew the picture"),
        });
    }
    let beside = [
        ("mesh", &found.record.mesh, &args.mesh),
        ("labels", &found.record.labels, &args.labels),
        ("environment map", &found.record.environment_map, &args.environment_map),
    ];
    for (what, recorded, path) in beside {
        if let (Some(FileRecord { name, sha256 }), Some(path)) = (recorded, path)
            && vr_io::file_hash(path).map_err(Failure::failed)? != *sha256
        {
            let path = path.display();
            strangers.push(format!("{path}: not the {what} of the picture: it differs from {name} in its bytes"));
        }
    }
    Ok(strangers)
}

/// Writes the new picture with a record of its own.
fn write(place: &Path, found: &PictureRecord, outcome: &Outcome, setup: &Setup, frame: &Frame) -> Result<(), Failure> {
    let mut record = found.clone();
    VERSION.clone_into(&mut record.record.version);
    record.record.volume.hash = volume_hash(&setup.unlabelled.volume);
    let own = setup.file.clone().without_folders(setup.info.as_ref());
    record.record.volume.title = title(&own.volume, &setup.scene.volume);
    record.scene.volume = own.volume;
    if !outcome.as_recorded {
        // The error was another picture's.
        record.record.error = None;
    }
    let options = match &record.record.picture {
        Some(picture) if picture.format == vr_io::PictureFormat::Png => picture.png(setup.scene.background),
        _ => vr_io::PngOptions { background: setup.scene.background, ..vr_io::PngOptions::default() },
    };
    vr_io::write_with_record(place, frame, &options, record).map_err(Failure::failed)
}

/// Comparison of the new pixels with the old ones.
struct Outcome {
    /// True if the new pixels are those of the record.
    as_recorded: bool,
    /// True if the pixels in the file are those of the record.
    untouched: bool,
    /// Number of pixels in the file that differ from the new ones; `None` where the picture has another size or other channels now.
    differing: Option<u64>,
    /// Size of the picture in the file.
    size: [u32; 2],
}

impl Outcome {
    fn is_same(&self) -> bool {
        self.as_recorded && self.untouched
    }

    /// Returns the outcome in a few words.
    fn words(&self) -> String {
        let all: u64 = self.size.iter().map(|&side| u64::from(side)).product();
        match self.differing {
            Some(0) => format!("all {all} pixels are the same, bit for bit"),
            Some(differing) => format!("{differing} of {all} pixels differ"),
            None => {
                format!("the picture in the file has {}x{} pixels or other channels now", self.size[0], self.size[1])
            }
        }
    }

    /// Ends the command with exit code 1 where pixels differ, with the likely reason.
    fn verdict(&self, picture: &Path, found: &PictureRecord, setup: &Setup, same_files: bool) -> Result<(), Failure> {
        let picture = picture.display();
        let version = &found.record.version;
        let reason = match (self.as_recorded, self.untouched) {
            (true, true) => return Ok(()),
            (true, false) => {
                "it was drawn again as it was recorded, but the pixels in the file were changed since".to_owned()
            }
            (false, _) if !same_files => "the volume or the mesh is not the recorded one".to_owned(),
            (false, _) if version != VERSION => {
                format!(
                    "likely because vr {version} drew it, and this is vr {VERSION}, which may round or choose otherwise"
                )
            }
            (false, false) => "the pixels in the file were changed since it was written".to_owned(),
            (false, true) => format!(
                "though volume and version are the same: vr {VERSION} was built otherwise, or this is a fault of the renderer {}",
                setup.file.render.renderer.as_deref().unwrap_or_default()
            ),
        };
        Err(Failure::failed(format!("{picture}: {}: {reason}", self.words())))
    }
}

#[derive(Serialize)]
struct Json<'a> {
    picture: String,
    volume: &'a str,
    renderer: &'a str,
    recorded_version: &'a str,
    version: &'a str,
    same_volume: bool,
    same_pixels: bool,
    /// Pixels in the file that differ from the new ones; `null` where the sizes differ.
    differing_pixels: Option<u64>,
    /// True if the pixels in the file are not those of the record.
    changed_since: bool,
    output: Option<&'a PathBuf>,
}

impl Json<'_> {
    fn text(&self, outcome: &Outcome) -> String {
        let Self { volume, renderer, recorded_version, .. } = self;
        let mut text = format!("scene    {volume}, {renderer}, recorded by vr {recorded_version}\n");
        text += &format!("again    {}\n", outcome.words());
        if let Some(place) = self.output {
            text += &format!("wrote    {}\n", place.display());
        }
        text
    }
}
