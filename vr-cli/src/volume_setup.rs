//! From the command line to a volume, for commands that draw nothing.

use std::path::Path;

use vr_core::Volume;
use vr_core::scene_file::TransferSection;
use vr_io::FileInfo;

use crate::args::VolumeArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::scene_setup::{Origin, default_scene, title};

/// A volume, and what is known about it.
pub struct LoadedVolume {
    /// The volume.
    pub volume: Volume,
    /// What it is, in a few words.
    pub title: String,
    /// What its file said; `None` for a phantom.
    pub info: Option<FileInfo>,
    /// What was assumed.
    pub notes: Vec<String>,
}

impl LoadedVolume {
    /// Reads the volume that flags name, or makes the embedded one. Tells what was assumed.
    ///
    /// # Errors
    /// Whatever is wrong with the flags or the file.
    pub fn new(args: &VolumeArgs, console: Console) -> Result<Self, Failure> {
        let mut file = default_scene(args.path.is_some() || args.phantom.is_some())?;
        let mut origin = Origin::default();
        origin.overrides.volume(args, &mut file.volume)?;
        // Nothing is drawn: nothing has to be assumed about how.
        let unused =
            TransferSection { preset: Some("grey".to_owned()), unit_distance: Some(1.0), ..Default::default() };
        file.transfer = Some(unused);
        let loaded = vr_io::resolve_scene(&file, Path::new("")).map_err(|e| origin.scene_failure(e))?;
        for note in &loaded.notes {
            console.note(note);
        }
        let title = title(&file.volume, &loaded.scene.volume);
        Ok(Self { volume: loaded.scene.volume, title, info: loaded.info, notes: loaded.notes })
    }
}
