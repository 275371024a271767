//! Records of sheets, and the single pictures of a sheet in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use vr_core::Frame;
use vr_io::{PictureRecord, PngOptions, SheetPicture, SheetRecord};

use crate::failure::Failure;
use crate::picture_record::record_of;
use crate::renderers::StatedRenderer;
use crate::scene_setup::Setup;

/// Picture of a sheet.
pub struct SinglePicture<'a> {
    /// Name on the sheet.
    pub name: String,
    /// Flags that draw it of the scene.
    pub flags: Vec<String>,
    /// Scene and view.
    pub setup: &'a Setup,
    /// The renderer that drew it.
    pub stated: &'a StatedRenderer,
    /// The picture.
    pub frame: &'a Frame,
}

/// Writes a sheet with a record of the scene and of what differs between its pictures; and each picture, with a record of its own, into a folder
/// if one is named. Returns the files, the sheet first. There is at least one picture.
///
/// # Errors
/// A mesh or a file of a transfer function that can no longer be read, or a file that cannot be written.
pub fn write(
    sheet: (&Path, &Frame),
    (command, shares_transfer): (&str, bool),
    pictures: &[SinglePicture<'_>],
    folder: Option<&Path>,
) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    let (place, frame) = sheet;
    let record = sheet_record((command, shares_transfer), pictures)?;
    vr_io::write_with_record(place, frame, &PngOptions::default(), record).map_err(Failure::failed)?;
    files.push(place.to_owned());
    if let Some(folder) = folder {
        let unmade = |e: std::io::Error| Failure::failed(format!("{}: cannot be made: {e}", folder.display()));
        fs::create_dir_all(folder).map_err(unmade)?;
        for picture in pictures {
            let place = place_of(folder, &picture.name);
            let record = record_of(picture.setup, picture.stated, None)?;
            let png = PngOptions { background: picture.setup.scene.background, ..PngOptions::default() };
            vr_io::write_with_record(&place, picture.frame, &png, record).map_err(Failure::failed)?;
            files.push(place);
        }
    }
    Ok(files)
}

/// Returns the record of a sheet: the scene without what its pictures have of their own, and the flags of each.
fn sheet_record(
    (command, shares_transfer): (&str, bool),
    pictures: &[SinglePicture<'_>],
) -> Result<PictureRecord, Failure> {
    let first = &pictures[0];
    let mut record = record_of(first.setup, first.stated, None)?;
    if shares_transfer {
        // They differ in the renderer and its options.
        let render = &mut record.scene.render;
        (render.renderer, render.max_error) = (None, None);
        render.options.0.clear();
    } else {
        record.scene.transfer = None;
        record.record.transfer_file = None;
    }
    let picture =
        |picture: &SinglePicture<'_>| SheetPicture { name: picture.name.clone(), flags: picture.flags.join(" ") };
    record.record.sheet =
        Some(SheetRecord { command: command.to_owned(), pictures: pictures.iter().map(picture).collect() });
    Ok(record)
}

/// Returns the file of a picture in a folder.
pub fn place_of(folder: &Path, name: &str) -> PathBuf {
    let name: String = name.chars().map(|c| if c.is_alphanumeric() || "._=".contains(c) { c } else { '-' }).collect();
    folder.join(name + ".png")
}

/// Returns the reason why a sheet is not drawn again.
pub fn refusal(picture: &Path, sheet: &SheetRecord) -> Failure {
    let SheetRecord { command, pictures } = sheet;
    Failure::failed(format!(
        "{}: a sheet of {} pictures by vr {command}, and rerun draws single ones; vr {command} --pictures FOLDER writes each with a record of \
         its own, and vr info {0} lists their flags",
        picture.display(),
        pictures.len(),
    ))
}
