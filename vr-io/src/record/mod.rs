//! Records in pictures: all that it takes to draw a picture again, kept in its file.

mod carrier;
mod earlier_layout;
mod section;

use std::path::Path;

use vr_core::Frame;

use crate::atomic::write_bytes;
use crate::error::WriteError;
use crate::exr::write_exr_with;
use crate::picture_read::{PictureError, StoredPixels};
use crate::png::{Encode, PngDepth, PngOptions, encode_samples, samples};
use crate::scene::{SceneFile, SceneFileError};
use crate::toml_table::{table_of, value_of};

pub use section::{
    ErrorRecord, FileRecord, PictureFormat, PixelsRecord, RecordSection, SheetPicture, SheetRecord, VolumeRecord,
};

/// The layout of records that this version writes and reads.
const LAYOUT: u32 = 2;

/// Record that is enough to draw a picture again: its scene, and the hashes by which volume and picture are known again.
///
/// No folder is named in it, and a patient's data are not: a volume file is there by its name alone, a DICOM series without one.
///
/// # Examples
/// ```
/// use vr_core::{View, phantom};
/// use vr_io::{PngOptions, PictureRecord, SceneFile, VolumeRecord, read_record, volume_hash, write_with_record};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let scene = phantom::by_name("fog").unwrap().scene(4)?;
/// let view = View::new(vr_core::Camera::framing(scene.bounds(), 0.0, 0.0, None), [2, 1]);
/// let frame = vr_core::Frame::new(view.size, vec![[0.25; 4], [0.5; 4]], None);
/// let volume = VolumeRecord { title: "fog".to_owned(), hash: volume_hash(&scene.volume) };
/// let record = PictureRecord::new("0.1.0", SceneFile::describe(&scene, &view)?, volume);
///
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("fog.png");
/// write_with_record(&path, &frame, &PngOptions::default(), record)?;
/// let found = read_record(&path)?.unwrap();
/// assert_eq!(found.scene.image.size, [2, 1]);
/// assert_eq!(found.record.picture.unwrap().hash, vr_io::StoredPixels::read(&path)?.hash());
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PictureRecord {
    /// Facts about the picture beside its scene.
    pub record: RecordSection,
    /// The scene, of which nothing is left open.
    pub scene: SceneFile,
}

impl PictureRecord {
    /// A record of a scene of which nothing is left open, drawn by a version of the program.
    pub fn new(version: &str, scene: SceneFile, volume: VolumeRecord) -> Self {
        let version = version.to_owned();
        let record = RecordSection {
            layout: LAYOUT,
            version,
            volume,
            mesh: None,
            labels: None,
            environment_map: None,
            transfer_file: None,
            error: None,
            sheet: None,
            picture: None,
        };
        Self { record, scene }
    }

    /// The record as TOML: the scene file, and `[record]`.
    ///
    /// # Errors
    /// [`SceneFileError::Text`] for a number that TOML cannot hold.
    pub fn text(&self) -> Result<String, SceneFileError> {
        let mut table = table_of(&self.scene)?;
        table.insert("record".to_owned(), table_of(&self.record)?.into());
        toml::to_string(&table).map_err(|e| SceneFileError::Text { message: e.to_string() })
    }

    /// Reads a record's text; `path` is the picture, which errors name.
    ///
    /// # Errors
    /// A [`SceneFileError`] naming the picture: a text that is no record, or one of a newer layout.
    pub fn parse(text: &str, path: &Path) -> Result<Self, SceneFileError> {
        // A picture has no lines.
        let wrong = |e: toml::de::Error| match SceneFileError::of_toml(&e, "", path) {
            SceneFileError::Syntax { path, message, .. } => {
                SceneFileError::Syntax { path, line: None, message: format!("the record in it is damaged: {message}") }
            }
            SceneFileError::UnknownKey { path, key, nearest, known, .. } => {
                SceneFileError::UnknownKey { path, line: None, key, nearest, known }
            }
            other => other,
        };
        let damaged = |message: &str| SceneFileError::Syntax {
            path: path.into(),
            line: None,
            message: format!("the record in it is damaged: {message}"),
        };
        let mut table: toml::Table = toml::from_str(text).map_err(wrong)?;
        let Some(toml::Value::Table(mut section)) = table.remove("record") else {
            return Err(damaged("it has no section [record]"));
        };
        // The layout first: what a newer one holds is not known here.
        let layout = section.get("layout").and_then(toml::Value::as_integer);
        match layout {
            Some(found) if found > i64::from(LAYOUT) => {
                let message = format!(
                    "the record in it has layout {found}, and this version reads up to {LAYOUT}: take a newer vr"
                );
                return Err(SceneFileError::Syntax { path: path.into(), line: None, message });
            }
            Some(1) => earlier_layout::upgrade(&mut section, &mut table).map_err(|message| damaged(&message))?,
            Some(_) => {}
            None => return Err(damaged("[record] has no layout")),
        }
        Ok(Self { record: value_of(&section).map_err(wrong)?, scene: value_of(&table).map_err(wrong)? })
    }

    /// One line about the picture, for programs that show a description.
    fn description(&self) -> String {
        let [width, height] = self.scene.image.size;
        let renderer = self.scene.render.renderer.as_deref().unwrap_or("vr");
        let title = &self.record.volume.title;
        match &self.record.sheet {
            Some(sheet) => {
                format!("{title}, {} pictures of {width}×{height} pixels, vr {}", sheet.pictures.len(), sheet.command)
            }
            None => format!("{title}, {width}×{height} pixels, {renderer}"),
        }
    }
}

/// Writes a frame as what the name says, `.png` (with these options) or `.exr`, with a record, whose `picture` is set to what is written.
///
/// # Errors
/// A [`WriteError`] naming the file, also for any other name; no part of it is left behind then.
pub fn write_with_record(
    path: impl AsRef<Path>,
    frame: &Frame,
    options: &PngOptions,
    mut record: PictureRecord,
) -> Result<(), WriteError> {
    let path = path.as_ref();
    let refuse = |message: String| WriteError::Encode { path: path.into(), message };
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("png") => {
            let bytes = encode_png_with_record(frame, options, record).map_err(|e| refuse(e.to_string()))?;
            write_bytes(path, &bytes)
        }
        Some("exr") => {
            record.record.picture = Some(PixelsRecord {
                format: PictureFormat::Exr,
                bits: 32,
                encode: Encode::None,
                alpha: true,
                hash: StoredPixels::of_frame(frame).hash(),
            });
            let texts = texts(&record).map_err(|e| refuse(e.to_string()))?;
            write_exr_with(path, frame, carrier::exr_attributes(&texts))
        }
        other => Err(refuse(format!("extension {}: must be png or exr", other.unwrap_or("missing")))),
    }
}

/// Returns a frame as a PNG with a record, whose `picture` is set to its pixels.
///
/// # Errors
/// [`SceneFileError::Text`] for a number that a record cannot hold.
pub fn encode_png_with_record(
    frame: &Frame,
    options: &PngOptions,
    mut record: PictureRecord,
) -> Result<Vec<u8>, SceneFileError> {
    let samples = samples(frame, options);
    record.record.picture = Some(PixelsRecord {
        format: PictureFormat::Png,
        bits: if options.depth == PngDepth::Sixteen { 16 } else { 8 },
        encode: options.encode,
        alpha: options.alpha,
        hash: StoredPixels::of_samples(frame.size(), &samples).hash(),
    });
    let chunks = carrier::png_chunks(&texts(&record)?);
    encode_samples(frame.size(), &samples, &chunks).map_err(|message| SceneFileError::Text { message })
}

/// Texts that a picture's file holds.
struct Texts {
    description: String,
    record: String,
}

fn texts(record: &PictureRecord) -> Result<Texts, SceneFileError> {
    Ok(Texts { description: record.description(), record: record.text()? })
}

/// The reason why no record comes out of a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file is no picture, or is damaged.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The record in it is damaged, or newer than this version.
    #[error(transparent)]
    Record(#[from] SceneFileError),
}

/// Reads the record in a picture; `None` for a picture without one.
///
/// # Errors
/// A [`RecordError`] naming the file.
pub fn read_record(path: impl AsRef<Path>) -> Result<Option<PictureRecord>, RecordError> {
    let path = path.as_ref();
    let text = carrier::read_text(path)?;
    Ok(text.map(|text| PictureRecord::parse(&text, path)).transpose()?)
}

#[cfg(test)]
mod tests {
    use vr_core::Frame;

    use super::*;
    use crate::{AnnotationsSection, parse_scene, write};

    fn record() -> PictureRecord {
        let text = "[volume]\npath = \"Größe \\\"x\\\" 脳.nrrd\"\n[image]\nsize = [2, 1]\nbackground = [0.1, 0.2, 0.3]\n[render]\nstep = 0.1\n";
        let scene = parse_scene(text, Path::new("")).unwrap();
        let volume = VolumeRecord { title: "Größe 脳, 2×2×2 u8".to_owned(), hash: Some("ab".to_owned()) };
        PictureRecord::new("1.2.3", scene, volume)
    }

    fn frame() -> Frame {
        Frame::new([2, 1], vec![[0.25; 4], [0.5, 0.125, 0.0, 1.0]], Some(vec![1.0, 2.0]))
    }

    #[test]
    fn records_come_back_from_both_formats() {
        let folder = tempfile::tempdir().unwrap();
        let options = PngOptions { background: [0.1, 0.2, 0.3], depth: PngDepth::Sixteen, ..PngOptions::default() };
        for name in ["x.png", "x.EXR"] {
            let path = folder.path().join(name);
            write_with_record(&path, &frame(), &options, record()).unwrap();
            let found = read_record(&path).unwrap().unwrap();
            let picture = found.record.picture.clone().unwrap();
            assert_eq!(picture.hash, StoredPixels::read(&path).unwrap().hash());
            assert_eq!(picture.pixels(&frame(), options.background), StoredPixels::read(&path).unwrap());
            let expected = record();
            assert_eq!(found.scene, expected.scene);
            assert_eq!(found.record, RecordSection { picture: Some(picture), ..expected.record });
        }
        let other = write_with_record(folder.path().join("x.jpg"), &frame(), &options, record()).unwrap_err();
        assert!(other.to_string().contains("must be png or exr"));
    }

    #[test]
    fn a_record_may_stand_behind_the_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.png");
        write_with_record(&path, &frame(), &PngOptions::default(), record()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let at = |name: &[u8]| bytes.windows(4).position(|w| w == name).unwrap() - 4;
        let (text, data, end) = (at(b"iTXt"), at(b"IDAT"), at(b"IEND"));
        let moved = [&bytes[..text], &bytes[data..end], &bytes[text..data], &bytes[end..]].concat();
        std::fs::write(&path, moved).unwrap();
        assert_eq!(read_record(&path).unwrap().unwrap().scene, record().scene);
        // Cut off before it.
        std::fs::write(&path, &bytes[..text + 40]).unwrap();
        assert!(read_record(&path).unwrap_err().to_string().contains("PNG: damaged"));
    }

    #[test]
    fn pictures_without_a_record_have_none() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["x.png", "x.exr"] {
            let path = folder.path().join(name);
            write(&path, &frame(), &PngOptions::default()).unwrap();
            assert_eq!(read_record(&path).unwrap(), None, "{name}");
        }
        let path = folder.path().join("x.txt");
        std::fs::write(&path, "words").unwrap();
        assert!(read_record(&path).unwrap_err().to_string().contains("only PNG and EXR"));
    }

    #[test]
    fn records_of_the_first_layout_keep_their_annotations() {
        let old = |names: &str| {
            let lines = format!("layout = 1\nannotations = [{names}]\ntitle = \"A title\"");
            PictureRecord::parse(&record().text().unwrap().replace("layout = 2", &lines), Path::new("x.png"))
        };
        let annotations = |names: &str| old(names).unwrap().scene.annotations;
        let title = Some("A title".to_owned());
        let scale = AnnotationsSection { title: title.clone(), scale: true, ..AnnotationsSection::default() };
        assert_eq!(annotations("\"scale\""), scale);
        assert_eq!(annotations("\"all\""), AnnotationsSection { marker: true, legend: true, ..scale });
        assert_eq!(annotations(""), AnnotationsSection { title, ..AnnotationsSection::default() });
        assert!(old("\"compass\"").unwrap_err().to_string().contains("names annotation \"compass\""));
        let mut expected = record();
        expected.record.layout = 1;
        assert_eq!(old("").unwrap().record, expected.record);
    }

    #[test]
    fn damaged_and_newer_records_are_refused() {
        let text = record().text().unwrap();
        let error = |text: &str| PictureRecord::parse(text, Path::new("x.png")).unwrap_err().to_string();
        assert_eq!(PictureRecord::parse(&text, Path::new("")).unwrap(), record());
        let newer = error(&text.replace("layout = 2", "layout = 3\nmore = true"));
        assert!(newer.starts_with("x.png: the record in it has layout 3") && newer.contains("newer vr"), "{newer}");
        for bad in [
            text.replace("[record]", "[recorded]"),
            text.replace("layout = 2", ""),
            text.replace("1.2.3\"", ""),
            String::new(),
        ] {
            let message = error(&bad);
            assert!(
                message.starts_with("x.png: ") && message.contains("damaged") && !message.contains('\n'),
                "{message}"
            );
        }
    }
}
