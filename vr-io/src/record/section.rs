//! `[record]`: what is known of a picture beside its scene.

use serde::{Deserialize, Serialize};
use vr_core::Frame;

use crate::picture_read::StoredPixels;
use crate::png::{Encode, PngDepth, PngOptions, samples};

/// `[record]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordSection {
    /// Number of the layout, which newer programs may raise.
    pub layout: u32,
    /// Version of the program that drew the picture.
    pub version: String,
    /// The volume.
    pub volume: VolumeRecord,
    /// The mesh, if the scene has one.
    pub mesh: Option<FileRecord>,
    /// The labels beside the volume, if the scene has any.
    pub labels: Option<FileRecord>,
    /// The picture of the light from all sides, if the scene has one.
    #[serde(default)]
    pub environment_map: Option<FileRecord>,
    /// The file that the points of the transfer function are from, if they are from one.
    pub transfer_file: Option<FileRecord>,
    /// Error of the picture, if it was measured; of the bare picture, where annotations are drawn over it.
    pub error: Option<ErrorRecord>,
    /// The pictures of a sheet, if it is one: the scene is what they share.
    pub sheet: Option<SheetRecord>,
    /// The picture; set when it is written.
    pub picture: Option<PixelsRecord>,
}

/// A sheet of several pictures of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SheetRecord {
    /// Command of the program that draws the sheet: `compare` or `presets`.
    pub command: String,
    /// The pictures, row by row.
    pub pictures: Vec<SheetPicture>,
}

/// A picture of a sheet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SheetPicture {
    /// Name on the sheet.
    pub name: String,
    /// Flags that draw it of the scene.
    pub flags: String,
}

/// The volume of a picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VolumeRecord {
    /// Description in a few words.
    pub title: String,
    /// Its [`crate::volume_hash`].
    pub hash: Option<String>,
}

/// A file beside the volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FileRecord {
    /// Name without a folder.
    pub name: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
}

/// Error of a picture, in units of max(1, largest magnitude of the reference).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ErrorRecord {
    /// Root of the mean square.
    pub rmse: f64,
    /// The largest.
    pub max: f64,
    /// Number of pixels that were compared with the reference.
    pub pixels: u64,
    /// Number of all pixels.
    pub of: u64,
    /// Description of the way it was measured.
    pub method: String,
}

/// The pixels of a picture, and the way they are encoded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelsRecord {
    /// `png` or `exr`.
    pub format: PictureFormat,
    /// Bits per channel.
    pub bits: u32,
    /// Encoding of light.
    pub encode: Encode,
    /// True if α is kept, and no background added.
    pub alpha: bool,
    /// [`StoredPixels::hash`].
    pub hash: String,
}

/// Format of a picture with a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PictureFormat {
    /// Integers before a background, encoded for a screen.
    Png,
    /// Floats as the renderer gives them, with depth.
    Exr,
}

impl PixelsRecord {
    /// The options that make a PNG of a frame, before a background.
    pub fn png(&self, background: [f32; 3]) -> PngOptions {
        let depth = if self.bits == 16 { PngDepth::Sixteen } else { PngDepth::Eight };
        PngOptions { depth, encode: self.encode, background, alpha: self.alpha }
    }

    /// The pixels that a frame of the same scene gives a file that is encoded this way.
    pub fn pixels(&self, frame: &Frame, background: [f32; 3]) -> StoredPixels {
        match self.format {
            PictureFormat::Png => StoredPixels::of_samples(frame.size(), &samples(frame, &self.png(background))),
            PictureFormat::Exr => StoredPixels::of_frame(frame),
        }
    }
}
