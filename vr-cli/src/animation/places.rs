//! Places of an animation: the animation itself, and its frames.

use std::path::{MAIN_SEPARATOR, Path, PathBuf, is_separator};

use vr_io::AnimationFormat;

use crate::args::{AnimationArgs, Bits};
use crate::failure::Failure;
use crate::{inputs, output_file};

/// Files to write.
pub struct Places {
    /// Animations, each in one file.
    pub animations: Vec<PathBuf>,
    /// Frames, each in a file.
    pub frames: FramePlace,
}

/// Folder of the frames, and the pattern of their names.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePlace {
    /// The folder.
    pub folder: PathBuf,
    /// Name with one `%d`.
    pub pattern: String,
    /// True if the frames were not asked for themselves: the folder is removed when the animation is written.
    pub is_temporary: bool,
    /// True if the folder is made if it is not there.
    pub is_own_folder: bool,
}

impl Places {
    /// Sorts and checks the places that flags name, before anything is computed.
    ///
    /// # Errors
    /// A name of another kind, a folder that is not there, several places for frames; what a format cannot hold.
    pub fn new(args: &AnimationArgs) -> Result<Self, Failure> {
        let mut animations: Vec<PathBuf> = Vec::new();
        let mut frames = None;
        for path in args.places() {
            match frame_place(path)? {
                Some(_) if frames.is_some() => {
                    return Err(Failure::usage(format!("--output: {}: frames go to one place alone", path.display())));
                }
                Some(place) => frames = Some(place),
                None => {
                    check_animation(path, args)?;
                    animations
                        .iter()
                        .try_for_each(|other| inputs::apart(("--output", path), ("another one", other)))?;
                    animations.push(path.into());
                }
            }
        }
        // Every animation is put together from frames.
        let frames = match (frames, animations.first()) {
            (Some(frames), _) => frames,
            (None, Some(animation)) => temporary(animation),
            (None, None) => return Err(Failure::usage("--output: names no file")),
        };
        if !(0.02..=240.0).contains(&args.fps) {
            return Err(Failure::usage(format!("--fps: found {}; must be 0.02 to 240", args.fps)));
        }
        Ok(Self { animations, frames })
    }

    /// Checks that every format can hold pictures of a size.
    ///
    /// # Errors
    /// [`Failure::Usage`] naming the file and what is out of range.
    pub fn check_size(&self, size: [u32; 2], fps: f64) -> Result<(), Failure> {
        self.animations.iter().try_for_each(|path| {
            let format = AnimationFormat::of(path).unwrap_or(AnimationFormat::Apng);
            format.check(size, fps).map_err(|e| Failure::usage(format!("--output: {}: {e}", path.display())))
        })
    }
}

/// Returns the place of frames that a name stands for; `None` for a file of all.
fn frame_place(path: &Path) -> Result<Option<FramePlace>, Failure> {
    let is_folder = path.is_dir() || path.to_string_lossy().ends_with([MAIN_SEPARATOR, '/']);
    let shown = path.display();
    if is_folder {
        let folder: PathBuf = path.to_string_lossy().trim_end_matches(is_separator).into();
        let folder = if folder.as_os_str().is_empty() { path.into() } else { folder };
        let parent = folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() && (folder.exists() || !parent.is_dir()) {
            return Err(Failure::failed(format!(
                "{shown}: cannot be written: a file is there, or its folder does not exist"
            )));
        }
        let pattern = "frame-%04d.png".to_owned();
        return Ok(Some(FramePlace { folder, pattern, is_temporary: false, is_own_folder: true }));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    if !name.contains('%') {
        return Ok(None);
    }
    vr_io::numbered_names(&name, 1).map_err(|e| Failure::usage(format!("--output: {e}")))?;
    output_file::check(path, &["png"])?;
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).into();
    Ok(Some(FramePlace { folder, pattern: name, is_temporary: false, is_own_folder: false }))
}

/// Checks the name of an animation, and that its format holds what flags ask for.
fn check_animation(path: &Path, args: &AnimationArgs) -> Result<(), Failure> {
    let shown = path.display();
    let Some(format) = AnimationFormat::of(path) else {
        let found = path.extension().map_or("nothing".into(), |e| e.to_string_lossy());
        return Err(Failure::usage(format!(
            "--output: {shown}: extension: found {found}; must be gif, webp, apng or png; or name the frames, by a pattern such as \
             frame-%04d.png or a folder such as frames/, of which ffmpeg makes a video"
        )));
    };
    output_file::check(path, &["gif", "webp", "apng", "png"])?;
    if args.bits == Bits::Sixteen && format.bits() < 16 {
        return Err(Failure::usage(format!("--bits: {shown}: {} holds 8 bits per channel", format.name())));
    }
    if args.alpha && !format.has_opacity() {
        return Err(Failure::usage(format!(
            "--alpha: {shown}: a pixel of a GIF is there or not; .webp and .png hold opacity"
        )));
    }
    Ok(())
}

/// The folder beside an animation that holds its frames until it is written.
fn temporary(animation: &Path) -> FramePlace {
    let name = animation.file_name().unwrap_or_default().to_string_lossy();
    FramePlace {
        folder: animation.with_file_name(format!(".{name}.frames")),
        pattern: "frame-%06d.png".to_owned(),
        is_temporary: true,
        is_own_folder: true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_frames_from_animations() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let place = frame_place(&at("new/")).unwrap().unwrap();
        assert_eq!((place.folder, place.pattern.as_str()), (at("new"), "frame-%04d.png"));
        assert_eq!(frame_place(folder.path()).unwrap().unwrap().folder, folder.path());
        let place = frame_place(&at("a_%03d.png")).unwrap().unwrap();
        assert_eq!((place.folder.as_path(), place.is_own_folder), (folder.path(), false));
        assert_eq!(frame_place(&at("a.png")).unwrap(), None);
        for wrong in ["no/such/", "a_%s.png", "%d-%d.png", "a_%d.jpg"] {
            assert!(frame_place(&at(wrong)).is_err(), "{wrong}");
        }
        assert_eq!(temporary(Path::new("x/turn.gif")).folder, Path::new("x/.turn.gif.frames"));
    }
}
