//! `vr info`: facts of a volume, a mesh, or a picture with a record.

mod amr;
mod cells;
mod facts;
mod grid;
mod label_table;
mod lines;
mod mesh;
mod points;
mod rectilinear;
mod slices;

use vr_core::Volume;

use crate::args::InfoArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::info::amr::AmrInfo;
use crate::info::cells::CellsInfo;
use crate::info::points::PointsInfo;
use crate::info::rectilinear::RectilinearInfo;
use crate::{output_file, picture_record, volume_setup};

/// Describes a volume of any kind; or a mesh; or a picture with a record.
///
/// # Errors
/// Any fault of the command line or the file.
pub fn run(args: &InfoArgs, console: Console) -> Result<(), Failure> {
    if let Some(place) = &args.output {
        output_file::check(place, &["png"])?;
    }
    let without_slices = |kind: &str| match args.output {
        Some(_) => Err(Failure::usage(format!("--output: slices are drawn of grids; found: {kind}"))),
        None => Ok(()),
    };
    if let Some((path, record)) = picture_record::named(&args.volume)? {
        without_slices("picture")?;
        return picture_record::show(path, &record, console);
    }
    if let Some(path) = mesh::named(&args.volume) {
        without_slices("mesh of triangles")?;
        return mesh::run(path, console);
    }
    let (title, loaded) = volume_setup::load(&args.volume, console)?;
    let volume = &loaded.volume;
    if let Some(grid) = volume.value_grid() {
        return grid::run(args, &title, &loaded, grid, console);
    }
    without_slices(volume.kind())?;
    match volume {
        Volume::Cells(mesh) => {
            let found = CellsInfo::new(&title, &loaded, mesh);
            console.result(&found.text(), &found)
        }
        Volume::Rectilinear(grid) => {
            let found = RectilinearInfo::new(&title, &loaded, grid);
            console.result(&found.text(), &found)
        }
        Volume::Amr(grid) => {
            let found = AmrInfo::new(&title, &loaded, grid);
            console.result(&found.text(), &found)
        }
        _ => {
            let points = volume
                .points()
                .ok_or_else(|| Failure::failed(format!("{title}: a {} cannot be described yet", volume.kind())))?;
            let found = PointsInfo::new(&title, &loaded, points);
            console.result(&found.text(), &found)
        }
    }
}
