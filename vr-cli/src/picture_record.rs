//! Records of pictures that are drawn here, and those that are read.

use std::path::Path;

use serde::Serialize;
use vr_io::{
    AnnotationsSection, ErrorRecord, FileName, FileRecord, PictureFormat, PictureRecord, SceneFile, VolumeRecord,
    volume_hash,
};
use vr_physics::Metrics;
use vr_study::reference::ReferencePixels;

use crate::args::VolumeArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::number;
use crate::renderers::StatedRenderer;
use crate::scene_setup::{Setup, title};

/// Version of this program.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Makes the record of a picture that a renderer has drawn of a scene, without annotations, with the error that was measured, if one was.
///
/// # Errors
/// A mesh or a file of a transfer function that can no longer be read.
pub fn record_of(
    setup: &Setup,
    stated: &StatedRenderer,
    error: Option<&(Metrics, ReferencePixels)>,
) -> Result<PictureRecord, Failure> {
    let mut scene = setup.complete_file(stated).without_folders(setup.info.as_ref());
    scene.annotations = AnnotationsSection::default();
    let title = title(&scene.volume, &setup.scene.volume);
    let volume = VolumeRecord { title, hash: volume_hash(&setup.unlabelled.volume) };
    let mut record = PictureRecord::new(VERSION, scene, volume);
    let file = |path: &FileName| -> Result<FileRecord, Failure> {
        let path = setup.path_of(path);
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(FileRecord { name, sha256: vr_io::file_hash(&path).map_err(Failure::failed)? })
    };
    record.record.mesh = setup.file.mesh.as_ref().map(|mesh| file(&mesh.path)).transpose()?;
    record.record.labels = setup.labels.as_ref().map(|labels| file(&labels.file)).transpose()?;
    let map = setup.file.scattering.as_ref().and_then(|scattering| scattering.environment_map.as_ref());
    record.record.environment_map = map.map(file).transpose()?;
    let transfer_file = setup.file.transfer.as_ref().and_then(|transfer| transfer.file.as_ref());
    record.record.transfer_file = transfer_file.map(file).transpose()?;
    record.record.error = error.map(|(metrics, exact)| {
        let [width, height] = setup.view.size.map(u64::from);
        ErrorRecord {
            rmse: metrics.rmse,
            max: metrics.max,
            pixels: exact.count() as u64,
            of: width * height,
            method: format!("against the reference, {}", exact.certainty_text()),
        }
    });
    Ok(record)
}

/// Returns the record of the picture that flags name; `None` where they name no picture with a record.
///
/// # Errors
/// A record that is damaged, or newer than this program.
pub fn named(args: &VolumeArgs) -> Result<Option<(&Path, PictureRecord)>, Failure> {
    let Some(path) = args.path.as_deref().filter(|path| path.is_file()) else { return Ok(None) };
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    if !matches!(extension.as_deref(), Some("png" | "exr")) {
        return Ok(None);
    }
    let found = match vr_io::read_record(path) {
        Ok(found) => found,
        // What is wrong with a picture is said by what reads volumes; it may be a slice of one.
        Err(vr_io::RecordError::Picture(_)) => None,
        Err(e) => return Err(Failure::failed(e)),
    };
    if found.is_none() && extension.as_deref() == Some("exr") {
        let message = "no volume, and a picture without a record of vr, or none that can be read";
        return Err(Failure::failed(format!("{}: {message}", path.display())));
    }
    Ok(found.map(|record| (path, record)))
}

/// Prints the record of a picture.
///
/// # Errors
/// Errors of [`Console::result`].
pub fn show(path: &Path, found: &PictureRecord, console: Console) -> Result<(), Failure> {
    let PictureRecord { record, scene } = found;
    let mut text = format!("picture      {}\n", path.display());
    let mut line = |name: &str, what: String| text += &format!("{name:<12} {what}\n");
    line("scene", record.volume.title.clone());
    match &record.sheet {
        Some(sheet) => {
            line("drawn by", format!("vr {} {}, {} pictures", record.version, sheet.command, sheet.pictures.len()))
        }
        None => line(
            "drawn by",
            format!("vr {}, {}", record.version, scene.render.renderer.as_deref().unwrap_or("unknown")),
        ),
    }
    if let Some(picture) = &record.picture {
        let [width, height] = scene.image.size;
        let format = match picture.format {
            PictureFormat::Png => format!("PNG of {} bits", picture.bits),
            PictureFormat::Exr => "EXR".to_owned(),
        };
        line("size", format!("{width}x{height} pixels, {format}"));
        line("pixels", format!("hash {}", picture.hash));
    }
    if let Some(hash) = &record.volume.hash {
        line("volume", format!("hash {hash}"));
    }
    let files = [("mesh", &record.mesh), ("colours from", &record.transfer_file)];
    for (name, file) in files.into_iter().filter_map(|(name, file)| Some((name, file.as_ref()?))) {
        line(name, format!("{}, SHA-256 {}", file.name, file.sha256));
    }
    if let Some(ErrorRecord { rmse, max, pixels, of, method }) = &record.error {
        let (rmse, max) = (number::small(*rmse), number::small(*max));
        line("error", format!("RMSE {rmse}, max {max} on {pixels} of {of} pixels, {method}"));
    }
    let is_of_file = matches!(scene.volume.source, Some(vr_io::VolumeSource::File(_)));
    let volume = if is_of_file { " VOLUME" } else { "" };
    let mesh = if scene.mesh.is_some() { " --mesh FILE" } else { "" };
    match &record.sheet {
        Some(sheet) => {
            sheet.pictures.iter().for_each(|picture| line("", format!("{}: {}", picture.name, picture.flags)))
        }
        None => line("again", format!("vr rerun {}{volume}{mesh}", path.display())),
    }
    text += "\n";
    text += &vr_io::scene_text(scene).map_err(Failure::failed)?;
    #[derive(Serialize)]
    struct Json<'a> {
        picture: String,
        record: &'a vr_io::RecordSection,
        scene: &'a SceneFile,
    }
    console.result(&text, &Json { picture: path.display().to_string(), record, scene })
}
