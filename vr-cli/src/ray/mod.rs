//! `vr ray`.

mod causes;
mod csv_file;
mod drawing;
mod figures;
mod header;
mod json;
mod plot;
mod tables;

use vr_core::{Control, RenderError};
use vr_study::ray::RayAccount;

use crate::args::RayArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::output_file;
use crate::progress::under_bar;
use crate::scene_setup::Setup;

/// Lets the renderer list the steps of a pixel's ray, solves it by the reference, and shows both.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the file to be written; a pixel that the picture does not have.
pub fn run(args: &RayArgs, console: Console, control: &Control) -> Result<(), Failure> {
    args.scene.image.check_opaque()?;
    if let Some(path) = &args.csv {
        output_file::check(path, &["csv"])?;
    }
    let setup = Setup::for_renderer(&args.scene, &args.renderer, console)?;
    setup.protect(args.csv.iter().map(|path| ("--csv", path.as_path())), args.replace)?;
    let pixel = pixel(args, setup.view.size)?;
    let renderer = setup.renderer(&args.renderer, console)?.renderer;
    // The one ray through the pixel's centre, whatever else the picture's pixel is made of.
    if setup.view.supersampling > 1 {
        let n = setup.view.supersampling;
        console.note(&format!("only the ray through the pixel's centre is shown: image.samples = {n} has no effect"));
    }
    let failed = |e: RenderError| setup.render_failure(e);
    let account = under_bar(console, control, "looking", |control| {
        RayAccount::of((&setup.scene, &setup.view), pixel, &*renderer, control)
    })
    .map_err(failed)?;
    if let Some(path) = &args.csv {
        csv_file::write(path, &account)?;
    }
    let mut text = header::text(&setup, &account);
    // Drawings and tables are for text output alone.
    if !console.json && !console.quiet {
        text += &drawing::text(&account).map_err(failed)?;
        text += &tables::text(&account, args.all);
        if let Some(path) = &args.csv {
            text += &format!("\nwrote    {}\n", path.display());
        }
    }
    console.result(&text, &json::Json::new(&setup, &account))
}

/// Returns the pixel asked for.
fn pixel(args: &RayArgs, [width, height]: [u32; 2]) -> Result<[u32; 2], Failure> {
    let inside = |name: &str, found: i64, size: u32| {
        let allowed = || format!("{name}: found {found}; must be 0 to {}: the picture is {width}x{height}", size - 1);
        u32::try_from(found).ok().filter(|&n| n < size).ok_or_else(|| Failure::usage(allowed()))
    };
    // Any other fault of the size is an error of the renderer.
    Ok([inside("X", args.x, width.max(1))?, inside("Y", args.y, height.max(1))?])
}
