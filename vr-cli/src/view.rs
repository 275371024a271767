//! `vr view`.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use vr_core::Control;
use vr_io::{FileName, FileSource, LoadedVolume, SceneFile, VolumeSource};
use vr_view::server::{Opening, Server};
use vr_view::session::{Document, LabelFiles, Labels, PROVEN, RendererList, Subject};

use crate::args::{RendererArgs, ViewArgs};
use crate::browser;
use crate::console::Console;
use crate::failure::Failure;
use crate::renderers;
use crate::scene_setup::{Configured, Setup};

/// Scene that is open in the browser, and waits for its server to run.
pub struct Page {
    server: Server,
    document: Document,
    stays: bool,
}

impl Page {
    /// Draws what the page asks for, on the control's threads, until it is closed, or Ctrl-C.
    ///
    /// # Errors
    /// A fault of the network.
    pub fn serve(self, control: &Control) -> Result<(), Failure> {
        self.server.run(self.document, control, self.stays).map_err(Failure::failed)
    }
}

/// Opens a scene in the browser.
///
/// # Errors
/// Any fault of the command line, the volume or the scene; an address that cannot be listened at.
pub fn open(args: &ViewArgs, console: Console) -> Result<Page, Failure> {
    args.scene.image.check_opaque()?;
    // An address that is taken is said before gigabytes are read.
    let opening = Opening {
        folder: args.page.folder.clone(),
        max_upload: args.page.max_upload,
        read: Box::new(move |path| read(path, Console { quiet: true, ..console }).map_err(|e| e.to_string().into())),
    };
    let server = Server::bind(args.page.listen).and_then(|server| server.with_opening(opening));
    let server = server.map_err(Failure::failed)?;
    let setup = Setup::for_renderer(&args.scene, &args.renderer, console)?;
    setup.note_unused_annotations(console);
    let subject = Arc::new(subject(&setup, &args.renderer, console)?);
    let list = Arc::new(RendererList { all: renderers::all(), usual: renderers::usual });
    let document = Document::new(subject, list).map_err(Failure::failed)?;

    #[derive(Serialize)]
    struct Json<'a> {
        volume: &'a str,
        address: &'a str,
    }
    let address = server.url();
    let text = format!("scene    {}\nopen     {address}\n         Ctrl-C ends it\n", setup.title);
    console.result(&text, &Json { volume: &setup.title, address: &address })?;
    if !args.page.no_open && !browser::open(&address) {
        console.note("no browser was found to open: open the address in one");
    }
    Ok(Page { server, document, stays: args.page.stay })
}

/// Reads a volume that was chosen in the page, with the scene that suits it.
fn read(path: &Path, console: Console) -> Result<Subject, Failure> {
    let mut file = SceneFile::default();
    file.volume.source = Some(VolumeSource::File(FileSource { path: path.into(), ..FileSource::default() }));
    subject(&Setup::of_file(&file, console)?, &RendererArgs::default(), console)
}

/// Returns the scene to look at, with nothing left open. Its picture at rest is proven, unless something else is asked for.
fn subject(setup: &Setup, args: &RendererArgs, console: Console) -> Result<Subject, Failure> {
    let Configured { mut stated, max_error, options, .. } = setup.renderer(args, console)?;
    if max_error.is_none() && options.0.is_empty() && args.quality.is_none() {
        // A renderer that cannot promise leaves it without effect.
        stated.max_error = Some(PROVEN);
    }
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let file: SceneFile = setup.complete_file(&stated).with_paths(|path| absolute(&setup.path_of(path)).into());
    let volume = setup.unlabelled.volume.clone();
    let labels = setup.file.labels.as_ref().map_or_else(Labels::default, |section| {
        let of = |name: &FileName| absolute(&setup.path_of(name.as_ref()));
        LabelFiles { file: of(&section.file), names: section.names.as_ref().map(of) }.into()
    });
    Ok(Subject {
        file,
        volume: LoadedVolume { volume, info: setup.info.clone(), transfer: None, notes: Vec::new() },
        mesh: setup.mesh.clone(),
        title: setup.title.clone(),
        notes: setup.notes.clone(),
        labels,
    })
}
