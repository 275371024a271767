//! Set-up: from the command line to a volume, for commands that draw nothing.

use std::path::Path;

use vr_io::LoadedVolume;

use crate::args::VolumeArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::scene_setup::{Origin, default_scene, title};

/// Reads the volume that flags name, or makes the embedded one; returns a description in a few words, too. Prints notes on everything
/// assumed.
///
/// # Errors
/// Any fault of the flags or the file.
pub fn load(args: &VolumeArgs, console: Console) -> Result<(String, LoadedVolume), Failure> {
    let mut section = default_scene(args.path.is_some() || args.phantom.is_some())?.volume;
    let mut origin = Origin::default();
    origin.overrides.volume(args, &mut section)?;
    let loaded = vr_io::load_volume(&section, Path::new("")).map_err(|e| origin.scene_failure(e))?;
    for note in &loaded.notes {
        console.note(note);
    }
    Ok((title(&section, &loaded.volume), loaded))
}
