//! `vr scene`.

use std::path::Path;

use serde::Serialize;
use vr_core::Control;
use vr_io::{FileName, SceneFile};

use crate::args::SceneFileArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::picture_record::VERSION;
use crate::renderers::{self, StatedRenderer};
use crate::scene_setup::Setup;
use crate::{annotate, exact_cache, output_file, target};

/// Writes or prints the complete scene file, with comments, of what `vr render` would draw.
///
/// # Errors
/// Any fault of the command line, the volume, the scene, or the file to be written.
pub fn run(args: &SceneFileArgs, console: Console, control: &Control) -> Result<(), Failure> {
    args.scene.image.check_opaque()?;
    if let Some(place) = &args.output {
        output_file::check(place, &["toml"])?;
    }
    annotate::check(&args.annotations)?;
    let mut setup = Setup::new(&args.scene, console)?;
    annotate::apply(&args.annotations, &mut setup)?;
    setup.protect(args.output.iter().map(|path| ("--output", path.as_path())), args.replace)?;
    // Only a picture tells the choice of a target.
    let stated = match args.target.target_rmse {
        Some(target) => {
            let cache = exact_cache::open(&args.cache, console);
            target::draw((target, args.target.search), &args.renderer, &setup, &cache, console, control)?.stated
        }
        None => setup.renderer(&args.renderer, console)?.stated,
    };

    let folder = args.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let file = read_from(setup.complete_file(&stated), folder, &setup);
    let title = format!("Scene of vr {VERSION}: {}, drawn by {}.", setup.title, stated.name);
    let text = text(&file, &title, &stated)?;

    #[derive(Serialize)]
    struct Json<'a> {
        output: Option<String>,
        scene: &'a SceneFile,
        notes: &'a [String],
    }
    let json = Json {
        output: args.output.as_ref().map(|place| place.display().to_string()),
        scene: &file,
        notes: &setup.notes,
    };
    match &args.output {
        Some(place) => {
            vr_io::write_bytes(place, text.as_bytes()).map_err(Failure::failed)?;
            console.result(&format!("scene    {}\nwrote    {}", setup.title, place.display()), &json)
        }
        None => console.result(&text, &json),
    }
}

fn text(file: &SceneFile, title: &str, stated: &StatedRenderer) -> Result<String, Failure> {
    let renderer = renderers::named(&stated.name).map_err(Failure::failed)?;
    vr_io::commented_scene(file, title, &renderer.option_specs()).map_err(Failure::failed)
}

/// Returns a scene file of a set-up with its paths as they are to be read from a folder.
pub fn read_from(file: SceneFile, folder: &Path, setup: &Setup) -> SceneFile {
    file.with_paths(|path| path_from(folder, &setup.path_of(path)))
}

/// Returns a path as a file in `folder` must hold it: relative to it where it leads further down, absolute otherwise.
fn path_from(folder: &Path, path: &Path) -> FileName {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let place = absolute(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let path = absolute(path);
    path.strip_prefix(place).unwrap_or(&path).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_relative_where_they_lead_down() {
        let here = std::env::current_dir().unwrap();
        assert_eq!(path_from(Path::new(""), Path::new("sub/a.raw")), "sub/a.raw".into());
        assert_eq!(path_from(Path::new("sub"), Path::new("sub/a.raw")), "a.raw".into());
        assert_eq!(path_from(Path::new("sub"), Path::new("a.raw")), here.join("a.raw").into());
    }
}
