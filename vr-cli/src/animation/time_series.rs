//! Volumes of an animation: one, or a series that changes with time.

use std::path::{Path, PathBuf};

use vr_core::{Filter, Volume};
use vr_io::{FileName, FileSource, LookName, SceneFile, VolumeSection, VolumeSource, volume_hash};

use crate::args::{AnimationArgs, LookFrom, RendererArgs, SceneArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::scene_setup::{Setup, described};

/// Volumes of an animation, of which one is in memory.
pub struct Volumes {
    /// Sections of scene files that name them; none for a still volume.
    sections: Vec<VolumeSection>,
    /// Scene file, to whose folder paths are relative.
    scene_file: PathBuf,
    /// Filter of all.
    filter: Option<Filter>,
    /// Number of pictures of each.
    hold: usize,
    current: Current,
}

/// A volume that is there.
struct Current {
    /// Its number, if it was read for a frame.
    number: Option<usize>,
    volume: Volume,
    /// Its hash, once it is asked for.
    hash: Option<Option<String>>,
}

/// Sets up the scene of an animation, and its volumes. All volumes of a series are drawn with one transfer function.
///
/// # Errors
/// Any fault of the flags, the files, or the scene; a series that is none.
pub fn set_up(
    args: &SceneArgs,
    renderer: &RendererArgs,
    animation: &AnimationArgs,
    console: Console,
) -> Result<(Setup, Volumes), Failure> {
    let current = |volume: &Volume| Current { number: None, volume: volume.clone(), hash: None };
    if !animation.time_series {
        let setup = Setup::for_renderer(args, renderer, console)?;
        setup.note_unused_annotations(console);
        let current = current(&setup.scene.volume);
        let volumes = Volumes { sections: Vec::new(), scene_file: PathBuf::new(), filter: None, hold: 1, current };
        return Ok((setup, volumes));
    }
    let (mut file, origin) = described(args)?;
    if file.labels.is_some() {
        return Err(Failure::usage(
            "--time-series: labels are of one volume, and cannot go with a series; leave one of them out",
        ));
    }
    let scene_file = args.scene.clone().unwrap_or_default();
    let (sections, files) = series(&file.volume, &scene_file)?;
    let strongest = match animation.look_from {
        LookFrom::First => 0,
        LookFrom::All => common_range(&mut file, &sections, &scene_file)?,
    };
    file.volume = sections[strongest].clone();
    let mut setup = Setup::of_described(args, &file, origin, console)?;
    setup.note_unused_annotations(console);
    let count = sections.len();
    console.note(&format!(
        "time series of {count} volumes: transfer function{} from number {strongest}, from 0",
        if animation.look_from == LookFrom::All { " over the range of all," } else { "" }
    ));
    setup.inputs.extend(files);
    let (filter, current) = (setup.scene.volume.filter(), current(&setup.scene.volume));
    Ok((setup, Volumes { sections, scene_file, filter, hold: animation.hold as usize, current }))
}

impl Volumes {
    /// Returns the number of pictures of all volumes.
    pub fn pictures(&self) -> usize {
        self.sections.len() * self.hold
    }

    /// Returns the volume of a frame, and its hash; reads it, if it is another than before.
    ///
    /// # Errors
    /// Any fault of its file.
    pub fn of_frame(&mut self, frame: usize) -> Result<(&Volume, Option<&str>), Failure> {
        if !self.sections.is_empty() {
            let number = frame / self.hold % self.sections.len();
            if self.current.number != Some(number) {
                let loaded = vr_io::load_volume(&self.sections[number], &self.scene_file).map_err(Failure::failed)?;
                let volume = self.filter.map_or(loaded.volume.clone(), |filter| loaded.volume.with_filter(filter));
                self.current = Current { number: Some(number), volume, hash: None };
            }
        }
        let Current { volume, hash, .. } = &mut self.current;
        let hash = hash.get_or_insert_with(|| volume_hash(volume));
        Ok((&*volume, hash.as_deref()))
    }
}

/// Returns a section for each volume of a series, and the files that are read for them.
fn series(section: &VolumeSection, scene_file: &Path) -> Result<(Vec<VolumeSection>, Vec<PathBuf>), Failure> {
    let Some(VolumeSource::File(source)) = &section.source else {
        return Err(Failure::usage(
            "--time-series: the volume is no file: name a pattern of files, or a file of several frames",
        ));
    };
    let folder = scene_file.parent().unwrap_or(Path::new(""));
    let of = |source: FileSource| VolumeSection { source: Some(VolumeSource::File(source)), ..section.clone() };
    let path = &*source.path;
    let is_pattern = path.file_name().is_some_and(|name| name.to_string_lossy().contains('%'));
    if is_pattern && !folder.join(path).exists() {
        let files = vr_io::files_of_pattern(folder.join(path)).map_err(Failure::failed)?;
        let named = |file: &PathBuf| of(FileSource { path: file_beside(path, file), ..source.clone() });
        return Ok((files.iter().map(named).collect(), files));
    }
    if let Some(frame) = source.frame {
        return Err(Failure::usage(format!("--frame: {frame} is one of the frames, of which --time-series takes all")));
    }
    // The first frame tells how many there are.
    let first = of(FileSource { frame: Some(0), ..source.clone() });
    let info = vr_io::load_volume(&first, scene_file).map_err(Failure::failed)?.info;
    let frames = info.map_or(1, |info| info.frames);
    if frames < 2 {
        return Err(Failure::usage(format!(
            "--time-series: {} holds one volume: name a file of several frames, or a pattern such as vol-%03d.nrrd",
            path.display()
        )));
    }
    let sections = (0..frames).map(|frame| of(FileSource { frame: Some(frame), ..source.clone() }));
    Ok((sections.collect(), Vec::new()))
}

/// Returns the path of a file of a pattern, relative to what the pattern is relative to.
fn file_beside(pattern: &Path, file: &Path) -> FileName {
    let name = file.file_name().unwrap_or_default();
    pattern.with_file_name(name).into()
}

/// Reads all volumes, stretches what is stretched over the range of all, and returns the number of the one with the largest value.
fn common_range(file: &mut SceneFile, sections: &[VolumeSection], scene_file: &Path) -> Result<usize, Failure> {
    let (mut low, mut high, mut strongest) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for (number, section) in sections.iter().enumerate() {
        let loaded = vr_io::load_volume(section, scene_file).map_err(Failure::failed)?;
        if let Some((min, max)) = loaded.volume.value_range() {
            low = low.min(min);
            if max > high {
                (high, strongest) = (max, number);
            }
        }
    }
    if let Some(transfer) = &mut file.transfer {
        let is_stretched = transfer.preset.is_some() || transfer.file.is_some() || transfer.look == LookName::Flat;
        if is_stretched && transfer.points.is_none() && low <= high {
            transfer.range.get_or_insert([low, high]);
        }
    }
    Ok(strongest)
}
