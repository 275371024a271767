//! `vr convert`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;
use vr_core::{Control, Filter, GridVolume, Volume};
use vr_io::{FieldError, FileInfo, Levels, LoadedVolume, Reduction, Rounding, WriteError, WriteVolumeOptions};
use vr_look::{Kind, Survey};

use crate::args::{ChangeArgs, ConvertArgs, CropBox, ErrorMeasure, LevelArgs, Reduce};
use crate::console::Console;
use crate::failure::Failure;
use crate::inputs::Inputs;
use crate::resampled::{self, Account};
use crate::{number, output_file, volume_setup};

/// Writes a volume in another format, changed if flags ask for it.
///
/// # Errors
/// Any fault of the command line, the file that is read, or the place that is written to.
pub fn run(args: &ConvertArgs, console: Console, control: &Control) -> Result<(), Failure> {
    let is_named = args.volume.path.is_some() || args.volume.phantom.is_some();
    let Some(output) = args.place().filter(|_| is_named) else {
        let message = "convert takes a volume and the file to write, as in vr convert scan.nii.gz scan.nrrd; or --phantom NAME -o FILE";
        return Err(Failure::usage(message));
    };
    let (title, loaded) = volume_setup::load(&args.volume, console)?;
    let mut account = None;
    let grid = match (&loaded.volume, args.changes.resample.choices()) {
        // A grid is resampled in its turn, after what is cut off.
        (Volume::Grid(grid), _) if args.error.is_none() => Arc::clone(grid),
        (Volume::Grid(_), _) => {
            return Err(Failure::usage(
                "--error: must go with a volume that is no uniform grid; pictures of grids are not compared",
            ));
        }
        (volume, Some(choices)) if volume.colors().is_none() => {
            let measure = args.error.unwrap_or(ErrorMeasure::Subgrid);
            let resampled = resampled::run(volume, &choices, console, control)?;
            let picture = resampled::picture_error(&loaded, &resampled, measure, console, control)?;
            let mut said = resampled.notes();
            said.extend(picture.as_ref().map(resampled::picture_note));
            account = Some((said, Account::new(&resampled, picture)));
            Arc::new(GridVolume::new(resampled.grid.into(), Filter::default()))
        }
        (volume, _) => return Err(no_voxels(&title, volume)),
    };
    let LoadedVolume { info, mut notes, .. } = loaded;
    let (mut said, account) = account.map_or_else(Default::default, |(said, account)| (said, Some(account)));
    let (changed, also) = change(&grid, &args.changes, account.is_none(), console, control)?;
    said.extend(also);
    let volume = Volume::Grid(changed.map_or(grid, Arc::new));
    let mut options = info.as_ref().map_or_else(WriteVolumeOptions::default, WriteVolumeOptions::of_file);
    options.levels = levels(&args.levels, output, &volume, info.as_ref())?;
    let files = vr_io::volume_files(output, &volume).map_err(wrong_place)?;
    let inputs = Inputs::new("a file that is read", info.into_iter().flat_map(|info| info.files));
    files.iter().try_for_each(|place| inputs.permit("OUT", place, args.replace))?;
    let written = vr_io::write_volume(output, &volume, &options).map_err(Failure::failed)?;
    for note in said.iter().chain(&written.notes) {
        console.note(note);
    }
    notes.extend(said.into_iter().chain(written.notes));
    let json = Json {
        volume: &title,
        output: output.display().to_string(),
        format: written.format,
        dims: volume.grid().map_or([0; 3], |grid| grid.dims()),
        voxel_type: written.scalar.name(),
        files: written.files,
        resampled: account,
        notes: &notes,
    };
    console.result(&json.text(), &json)
}

/// The refusal of a volume without voxels.
fn no_voxels(title: &str, volume: &Volume) -> Failure {
    let why = if volume.colors().is_some() {
        "name one of its components, as in --component 0: formats are written with one number a voxel"
    } else if matches!(volume, Volume::Cells(_) | Volume::Amr(_)) {
        "its cells are no voxels, which every format here holds; make it a grid with --resample finest, or draw it as it is with vr render"
    } else {
        "there are no voxels in it, which every format here holds; make it a grid with --resample finest"
    };
    Failure::failed(format!("{title}: {} cannot be converted: {why}", volume.kind()))
}

/// Returns the resolutions that flags ask for; labels are told by the volume where no flag says how they are reduced.
fn levels(args: &LevelArgs, output: &Path, volume: &Volume, info: Option<&FileInfo>) -> Result<Levels, Failure> {
    let is_zarr = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("zarr"));
    let flags = [("--levels", args.levels.is_some()), ("--reduce", args.reduce.is_some())];
    if let (Some((flag, _)), false) = (flags.iter().find(|(_, given)| *given), is_zarr) {
        return Err(Failure::usage(format!("{flag}: only OME-Zarr (.zarr) holds several resolutions; leave it out")));
    }
    if !is_zarr || args.levels == Some(1) {
        return Ok(Levels { count: args.levels, ..Levels::default() });
    }
    let is_labels = || {
        let hints = info.map(FileInfo::hints).unwrap_or_default();
        matches!(Survey::of(volume).look(&hints).kind, Kind::Labels(_))
    };
    let reduction = match args.reduce {
        Some(Reduce::Mean) => Reduction::Mean,
        Some(Reduce::Mode) => Reduction::Mode,
        None if is_labels() => Reduction::Mode,
        None => Reduction::Mean,
    };
    Ok(Levels { count: args.levels, reduction })
}

/// Returns the grid that flags make of a grid, if they change it, and notes on how. `resamples` is false where it was resampled already.
fn change(
    grid: &GridVolume,
    args: &ChangeArgs,
    resamples: bool,
    console: Console,
    control: &Control,
) -> Result<(Option<GridVolume>, Vec<String>), Failure> {
    let wrong = |e: FieldError| Failure::usage(format!("--{e}"));
    let mut notes = Vec::new();
    let mut changed = None;
    if let Some(CropBox(ends)) = args.crop {
        let dims = grid.dims();
        let ranges = [0, 1, 2].map(|a| ends[a][0].unwrap_or(0)..ends[a][1].unwrap_or(dims[a]));
        changed = Some(vr_io::crop_grid(grid, ranges).map_err(wrong)?);
    }
    for &axis in &args.flip {
        changed = Some(vr_io::flip_grid(changed.as_ref().unwrap_or(grid), axis as usize).map_err(wrong)?);
    }
    if !args.flip.is_empty() {
        notes.push(
            "flipped: order and direction are reversed, so that each voxel stays where it is in the world".to_owned(),
        );
    }
    if let Some(dims) = args.resample.plain_dims().filter(|_| resamples) {
        let before = changed.as_ref().unwrap_or(grid);
        let [from, to] = [before.dims(), dims].map(|dims| number::triple(dims, "×"));
        notes.push(format!(
            "resampled from {from} to {to} by linear interpolation over the same box, without smoothing"
        ));
        changed = Some(vr_io::resample_grid(before, dims).map_err(wrong)?);
    } else if let Some(choices) = args.resample.choices().filter(|_| resamples) {
        let before = Volume::Grid(Arc::new(changed.as_ref().unwrap_or(grid).clone()));
        let resampled = resampled::run(&before, &choices, console, control)?;
        notes.extend(resampled.notes());
        changed = Some(GridVolume::new(resampled.grid.into(), grid.filter()));
    }
    if let Some(to) = args.to {
        let before = changed.as_ref().unwrap_or(grid);
        let (converted, Rounding { rounded, clamped, missing }) =
            vr_io::convert_grid(before, to, args.rescale).map_err(wrong)?;
        let count = before.dims().iter().product::<usize>();
        if let Some([low, high]) = args.rescale {
            let (low, high) = (number::value(low), number::value(high));
            notes.push(format!("values from {low} to {high} are stretched over the range of {to}"));
        }
        if rounded + clamped + missing > 0 {
            let became = if missing > 0 { format!(", {missing} that are missing become 0") } else { String::new() };
            notes.push(format!("of {count} voxels, {rounded} are rounded and {clamped} clamped to {to}{became}"));
        }
        changed = Some(converted);
    }
    Ok((changed, notes))
}

/// A name of no format is wrong usage; what the disk says is not.
fn wrong_place(error: WriteError) -> Failure {
    match error {
        WriteError::Encode { .. } => Failure::usage(error),
        _ => Failure::failed(error),
    }
}

#[derive(Serialize)]
struct Json<'a> {
    volume: &'a str,
    output: String,
    format: &'static str,
    dims: [usize; 3],
    #[serde(rename = "type")]
    voxel_type: &'static str,
    #[serde(serialize_with = "output_file::as_texts")]
    files: Vec<PathBuf>,
    /// Account of the resampling of a volume that is no grid.
    resampled: Option<Account>,
    notes: &'a [String],
}

impl Json<'_> {
    fn text(&self) -> String {
        let Self { volume, output, format, dims, voxel_type, files, .. } = self;
        let dims = number::triple(*dims, "×");
        let files = if files.len() > 1 { format!(", {} files", files.len()) } else { String::new() };
        format!("volume   {volume}\nwrote    {output}: {format}, {dims} {voxel_type}{files}")
    }
}
