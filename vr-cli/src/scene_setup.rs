//! Set-up: from the command line to a scene that can be drawn.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, FromArgMatches};
use vr_core::resample::{Resampled, Resampling, Resolution};
use vr_core::transfer::Preset;
use vr_core::{
    Control, Feature, OptionError, Options, ParameterError, RenderError, Renderer, Scene, Surfaces, TriangleMesh, View,
    Volume, memory,
};
use vr_io::{
    FileError, FileErrorKind, FileInfo, FileSource, LabelsSection, LoadedScene, LoadedVolume, ResampleSection,
    SceneFile, SceneFileError, SceneMesh, TransferSection, VolumeSection, VolumeSource,
};
use vr_mesh::Surface;

use crate::args::{Fit, QUALITY, Quality, RendererArgs, ReplaceArgs, SceneArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::inputs::Inputs;
use crate::overrides::Overrides;
use crate::renderers::StatedRenderer;
use crate::{number, renderers};

/// Memory that a pixel takes on its way into a file: light, depth, and the bytes of a PNG.
const BYTES_PER_PIXEL: u64 = 40;

/// Scene that is drawn where the command line names none.
const EMBEDDED: &str = include_str!("embedded.toml");

/// Scene and view, and where they came from.
#[derive(Clone)]
pub struct Setup {
    /// The scene.
    pub scene: Scene,
    /// The view.
    pub view: View,
    /// Description of the volume in a few words.
    pub title: String,
    /// Notes on everything assumed.
    pub notes: Vec<String>,
    /// Files that were read for it.
    pub inputs: Vec<PathBuf>,
    /// Phantom that the volume is made of, if it is.
    pub phantom: Option<String>,
    /// The scene file with the flags in it, of which things may be left open.
    pub file: SceneFile,
    /// The scene before labels are laid over its volume, and without surfaces.
    pub unlabelled: Scene,
    /// The labels, if there are any, with the style of each stated.
    pub labels: Option<LabelsSection>,
    /// Header of the volume's file, if it comes from one.
    pub info: Option<FileInfo>,
    /// The opaque surface among the volume, if there is one, and its colour.
    #[cfg_attr(not(feature = "view"), expect(dead_code, reason = "vr view alone lights it anew"))]
    pub mesh: Option<(Arc<TriangleMesh>, Option<[f64; 3]>)>,
    /// The renderer that the scene file names.
    renderer: Option<String>,
    options: Options,
    max_error: Option<f64>,
    origin: Origin,
}

/// Renderer that is ready to draw.
pub struct Configured {
    /// The renderer.
    pub renderer: Box<dyn Renderer>,
    /// The options that were set to make it; all others are at their defaults.
    pub options: Options,
    /// Error bound that was asked for, if any.
    pub max_error: Option<f64>,
    /// The renderer as scene files and records state it.
    pub stated: StatedRenderer,
}

impl Setup {
    /// The setup of a scene file whose paths are right from here, without flags.
    ///
    /// # Errors
    /// Any fault of the files, or the scene.
    pub fn of_file(file: &SceneFile, console: Console) -> Result<Self, Failure> {
        let loaded = vr_io::resolve_scene(file, Path::new("")).map_err(Failure::failed)?;
        Self::around(&no_flags()?, file, loaded, Origin::default(), console)
    }

    /// The scene file with everything stated that it leaves open, the renderer included; its paths are as they were.
    pub fn complete_file(&self, stated: &StatedRenderer) -> SceneFile {
        let StatedRenderer { name, options, max_error } = stated.clone();
        let completed = self.file.completed(&self.unlabelled, self.labels.clone(), &self.view, self.info.as_ref());
        completed.drawn_by(&name, options, max_error)
    }

    /// The same scene around the grid that its volume is resampled to.
    pub fn around_grid(&self, resampled: &Resampled) -> Self {
        let volume = Volume::from(resampled.grid.clone());
        let choices = Resampling { resolution: Resolution::Dims(resampled.grid.dims()), ..resampled.choices };
        let mut setup = self.clone();
        setup.scene.volume = volume.clone();
        setup.unlabelled.volume = volume;
        setup.file.volume.resample = Some(ResampleSection::describe(&choices));
        setup
    }

    /// Reads the scene file (or takes the embedded scene, where no volume is named either) and everything that it names,
    /// with the flags in place of what they override. Prints notes on everything assumed.
    ///
    /// # Errors
    /// Any fault of the flags, the files, or the scene.
    pub fn new(args: &SceneArgs, console: Console) -> Result<Self, Failure> {
        let (file, origin) = described(args)?;
        Self::of_described(args, &file, origin, console)
    }

    /// Reads what a scene file names, in which the flags are applied already, as [`described`] does.
    ///
    /// # Errors
    /// Any fault of the flags, the files, or the scene.
    pub fn of_described(args: &SceneArgs, file: &SceneFile, origin: Origin, console: Console) -> Result<Self, Failure> {
        let path = args.scene.as_deref().unwrap_or(Path::new(""));
        let loaded = vr_io::resolve_scene(file, path).map_err(|e| origin.scene_failure(e))?;
        Self::around(args, file, loaded, origin, console)
    }

    /// Reads the scene for a chosen renderer. If the volume is large, the renderer first says whether it supports the scene that the header
    /// describes, so that a refusal does not wait for gigabytes.
    ///
    /// # Errors
    /// Errors of [`Self::new`] and of [`Self::renderer`]; a scene that the renderer does not draw.
    pub fn for_renderer(args: &SceneArgs, renderer: &RendererArgs, console: Console) -> Result<Self, Failure> {
        let (file, origin) = described(args)?;
        let path = args.scene.as_deref().unwrap_or(Path::new(""));
        if let Some(outline) = vr_io::outline_scene(&file, path).map_err(|e| origin.scene_failure(e))? {
            // All that is worth a note comes again with the volume.
            let quiet = Console { quiet: true, ..console };
            let setup = Self::around(args, &file, outline, origin, quiet)?;
            let configured = setup.renderer(renderer, quiet)?;
            let supported = configured.renderer.supports(&setup.scene, Some(&setup.view));
            supported.map_err(|e| setup.render_failure(e))?;
        }
        Self::new(args, console)
    }

    /// The setup of a scene whose volume is there.
    fn around(
        args: &SceneArgs,
        file: &SceneFile,
        loaded: LoadedScene,
        origin: Origin,
        console: Console,
    ) -> Result<Self, Failure> {
        // What is visible was framed when the scene was loaded.
        let camera = match args.camera.fit {
            Fit::Visible => loaded.view.camera,
            Fit::Box => {
                let (section, info) = (file.camera.unwrap_or_default(), loaded.info.as_ref());
                let angles = section.angles(vr_io::default_angles(info));
                let whole = section.camera(|fov| vr_io::framing(loaded.bounds(), info, angles, fov));
                whole.map_err(|e| origin.parameter(&e))?
            }
        };
        let LoadedScene {
            mut scene,
            mut view,
            mesh,
            renderer,
            options,
            max_error,
            info,
            files,
            notes,
            unlabelled,
            labels,
            ..
        } = loaded;
        view.camera = camera;
        let inputs = args.scene.iter().cloned().chain(files).collect();
        for note in &notes {
            console.note(note);
        }
        let mut title = title(&file.volume, &scene.volume);
        if let (Some(section), Some(SceneMesh { mesh, .. })) = (&file.mesh, &mesh) {
            title += &format!(", with {} of {} triangles", section.path, mesh.triangles().len());
        }
        let mesh = mesh.map(|SceneMesh { mesh, color }| (Arc::new(mesh), color));
        scene.surfaces = mesh.clone().map(|(mesh, color)| {
            let surface = Surface::in_scene(mesh, color, &scene);
            Arc::new(surface) as Arc<dyn Surfaces>
        });
        let phantom = match &file.volume.source {
            Some(VolumeSource::Phantom { name, .. } | VolumeSource::PhantomPoints { name, .. }) => Some(name.clone()),
            _ => None,
        };
        let file = file.clone();
        let setup = Self {
            scene,
            view,
            title,
            notes,
            inputs,
            phantom,
            file,
            unlabelled,
            labels,
            info,
            mesh,
            renderer,
            options,
            max_error,
            origin,
        };
        setup.view.validate().map_err(|e| setup.render_failure(e.into()))?;
        let pixels = setup.view.size.map(u64::from).iter().product::<u64>();
        memory::check("the picture", pixels * BYTES_PER_PIXEL).map_err(Failure::failed)?;
        // Surfaces are drawn here for the note alone.
        if !console.quiet {
            let layer = setup.scene.layer(&setup.view, &Control::default()).map_err(|e| setup.render_failure(e))?;
            if layer.is_some_and(|layer| layer.pixels.iter().all(|p| p.1 == f32::INFINITY)) {
                console.note("the mesh is nowhere in the picture");
            }
        }
        Ok(setup)
    }

    /// Returns the renderer that flags or the scene file ask for, configured. Notes options of the scene file that are not for it.
    ///
    /// # Errors
    /// An unknown renderer, an option that it does not have or take, an error bound that it cannot keep, or two error bounds.
    pub fn renderer(&self, args: &RendererArgs, console: Console) -> Result<Configured, Failure> {
        let complaint = |by_flag: bool, message: String| match &self.origin.scene_file {
            Some(path) if !by_flag => Failure::failed(format!("{}: {message}", path.display())),
            _ => Failure::usage(message),
        };
        // Choose the renderer: a flag's, the scene file's, or the usual one.
        let usual = renderers::usual(&self.scene);
        let own_name = self.renderer.as_deref().unwrap_or_else(|| self.bounding(usual, args));
        let name = args.renderer.as_deref().unwrap_or(own_name);
        let renderer = renderers::named(name).map_err(|e| complaint(args.renderer.is_some(), e))?;
        if args.renderer.is_none() && self.renderer.is_none() && name != usual {
            console.note(&format!("renderer {name}, since {usual} cannot bound the error of this scene"));
        }
        // Another renderer than the scene file's: the options there are not for it.
        let is_own = name == own_name;
        let own = if is_own { self.options.clone() } else { Options::new() };
        if !is_own && !self.options.0.is_empty() {
            console.note(&format!("options of the scene file have no effect: they are for {own_name}, not {name}"));
        }
        // A quality is an option, or an error bound; a flag of either kind overrides the scene file's bound.
        let has_qualities = renderer.option_specs().iter().any(|option| option.key == QUALITY);
        let overrides_bound = args.quality.is_some();
        let args = &args.with_quality(name, has_qualities).map_err(Failure::usage)?;
        // Choose the error bound, which one source alone may set.
        let set = |key: &str| args.set.iter().any(|(k, _)| k == key);
        let bound_key = renderer.option_specs().into_iter().find(|option| option.promises).map(|option| option.key);
        let max_error = match (args.max_error, bound_key) {
            (Some(_), Some(key)) if set(key) => {
                let message =
                    format!("--max-error and --set {key} bound the same error of {name}: leave one of them out");
                return Err(Failure::usage(message));
            }
            (Some(max_error), _) => Some(max_error),
            // A flag overrides the scene file.
            (None, Some(key)) if set(key) => None,
            (None, Some(key)) if self.max_error.is_some() && own.0.contains_key(key) => {
                let message =
                    format!("render.max_error and render.{key} bound the same error of {name}: leave one of them out");
                return Err(complaint(false, message));
            }
            (None, _) => self.max_error.filter(|_| !overrides_bound),
        };
        // Set the options, and the bound.
        let options = renderers::with_flags(own, &args.set);
        let wrong_option = |e: OptionError| {
            let by_flag = match &e {
                OptionError::Unknown { key, .. } | OptionError::Value { key, .. } => {
                    args.renderer.is_some() || set(key)
                }
                _ => false,
            };
            complaint(by_flag, e.to_string())
        };
        let configured = renderer.with_options(&options).map_err(wrong_option)?;
        let Some(max_error) = max_error else {
            // A bound that options set, and not the default.
            let is_asked = renderer.max_error().is_none() || bound_key.is_some_and(|key| options.0.contains_key(key));
            let max_error = configured.max_error().filter(|_| is_asked);
            let stated = StatedRenderer::of(&*configured, None);
            return Ok(Configured { renderer: configured, options, max_error, stated });
        };
        let by_flag = args.max_error.is_some() || args.renderer.is_some();
        let stated = StatedRenderer::of(&*configured, Some(max_error));
        let renderer = configured
            .with_max_error(max_error)
            .ok_or_else(|| complaint(by_flag, format!("renderer {name} cannot bound the error (max_error)")))?
            .map_err(|e| complaint(by_flag, e.to_string()))?;
        Ok(Configured { renderer, options, max_error: Some(max_error), stated })
    }

    /// Returns the usual renderer, or another one if the error is to be bounded and only that one can bound it.
    fn bounding(&self, usual: &'static str, args: &RendererArgs) -> &'static str {
        let is_bounded = match args.quality {
            Some(quality) => quality == Quality::Proven,
            None => args.max_error.or(self.max_error).is_some(),
        };
        // Options belong to the usual renderer.
        if !is_bounded || !args.set.is_empty() || !self.options.0.is_empty() {
            return usual;
        }
        let able = self.drawn_by(true);
        if able.contains(&usual) { usual } else { able.first().copied().unwrap_or(usual) }
    }

    /// Returns the scene file that was read, if one was.
    pub fn scene_file(&self) -> Option<&Path> {
        self.origin.scene_file.as_deref()
    }

    /// Notes that the scene file's annotations have no effect, where it has any: for commands whose pictures have none.
    pub fn note_unused_annotations(&self, console: Console) {
        if !self.file.annotations.is_empty() {
            console.note("annotations of the scene file: without effect; vr render draws them");
        }
    }

    /// Returns a path of the scene file as it is from here.
    pub fn path_of(&self, path: &Path) -> PathBuf {
        let scene_file = self.origin.scene_file.as_deref();
        scene_file.and_then(Path::parent).map_or_else(|| path.into(), |folder| folder.join(path))
    }

    /// Notes that the scene file's choices about a renderer have no effect, where it makes any: for commands that try several.
    pub fn note_unused_renderer(&self, why: &str, console: Console) {
        let options = self.options.0.keys().map(|key| format!("render.{key}"));
        let max_error = self.max_error.map(|_| "render.max_error".to_owned());
        let named = self.renderer.as_ref().map(|_| "render.renderer".to_owned());
        let unused: Vec<String> = named.into_iter().chain(max_error).chain(options).collect();
        if !unused.is_empty() {
            console.note(&format!("{} of the scene file: without effect, {why}", unused.join(", ")));
        }
    }

    /// Refuses places to write where one of the scene's own files is, or one that is not to be replaced; each comes with its flag.
    ///
    /// # Errors
    /// Errors of [`Inputs::permit`].
    pub fn protect<'a>(
        &self,
        places: impl IntoIterator<Item = (&'a str, &'a Path)>,
        replace: ReplaceArgs,
    ) -> Result<(), Failure> {
        let inputs = Inputs::new("a file that is read", self.inputs.iter().cloned());
        places.into_iter().try_for_each(|(flag, place)| inputs.permit(flag, place, replace))
    }

    /// Returns the failure of a picture that cannot be drawn; a renderer that does not draw it is told with those that do.
    pub fn render_failure(&self, error: RenderError) -> Failure {
        match error {
            RenderError::Parameter(e) => self.origin.parameter(&e),
            RenderError::Unsupported(refused) => {
                let others = self.drawn_by(refused.feature == Feature::MaxError);
                if others.is_empty() {
                    return Failure::failed(refused);
                }
                Failure::failed(format!("{refused} (--renderer {} can)", others.join(" or ")))
            }
            other => Failure::failed(other),
        }
    }

    /// Returns the names of the renderers that draw the scene; with a bound of the error, if that is asked for.
    fn drawn_by(&self, with_bound: bool) -> Vec<&'static str> {
        let draws = |renderer: &dyn Renderer| renderer.supports(&self.scene, Some(&self.view)).is_ok();
        let all = renderers::all().into_iter();
        let drawing = all.filter(|renderer| match with_bound {
            false => draws(&**renderer),
            true => renderer.with_max_error(1e-3).is_some_and(|promising| promising.is_ok_and(|r| draws(&*r))),
        });
        drawing.map(|renderer| renderer.name()).collect()
    }
}

/// Set-ups of one volume under several presets.
pub struct PresetSetups {
    /// Each preset with its set-up.
    pub setups: Vec<(Preset, Setup)>,
    /// Notes on everything assumed.
    pub notes: Vec<String>,
}

impl PresetSetups {
    /// Reads the volume once, and sets up its scene under each preset that is chosen for it. Prints every note once.
    ///
    /// # Errors
    /// Errors of [`Setup::new`].
    pub fn new(
        args: &SceneArgs,
        choose: impl FnOnce(&LoadedVolume) -> Vec<Preset>,
        console: Console,
    ) -> Result<Self, Failure> {
        let (mut file, origin) = described(args)?;
        let path = args.scene.as_deref().unwrap_or(Path::new(""));
        let failure = |origin: &Origin, e: SceneFileError| origin.scene_failure(e);
        let found = vr_io::load_volume(&file.volume, path).map_err(|e| failure(&origin, e))?;
        let section = file.transfer.take().unwrap_or_default();
        let (mut setups, mut notes, mut known) = (Vec::new(), Vec::new(), Vec::new());
        for preset in choose(&found) {
            let transfer = TransferSection {
                preset: Some(preset.name().to_owned()),
                range: section.range,
                unit_distance: section.unit_distance,
                opacity_rule: section.opacity_rule,
                ..TransferSection::default()
            };
            let file = SceneFile { transfer: Some(transfer), ..file.clone() };
            let (_, origin) = described(args)?;
            let loaded = vr_io::resolve_scene_around(&file, path, found.clone()).map_err(|e| failure(&origin, e))?;
            let setup = Setup::around(args, &file, loaded, origin, Console { quiet: true, ..console })?;
            // Presets say the same of themselves.
            for note in &setup.notes {
                let general = note.replace(preset.name(), "");
                if !known.contains(&general) {
                    console.note(note);
                    notes.push(note.clone());
                    known.push(general);
                }
            }
            setups.push((preset, setup));
        }
        Ok(Self { setups, notes })
    }
}

/// The scene file, or the embedded scene, with the flags in place of what they override, and where each parameter came from.
///
/// # Errors
/// Any fault of the flags or the scene file.
pub fn described(args: &SceneArgs) -> Result<(SceneFile, Origin), Failure> {
    let mut file = match &args.scene {
        Some(path) => vr_io::read_scene(path).map_err(Failure::failed)?,
        None => default_scene(args.volume.path.is_some() || args.volume.phantom.is_some())?,
    };
    if args.scene.is_none() && args.mesh.mesh.is_some() {
        // The embedded camera sees the embedded volume, and may miss the mesh.
        file.camera = None;
    }
    let mut origin = Origin { scene_file: args.scene.clone(), overrides: Overrides::default() };
    origin.overrides.apply(args, &mut file)?;
    Ok((file, origin))
}

/// Returns the scene that flags name; `None` where they name nothing, for commands that have scenes of their own.
///
/// # Errors
/// Errors of [`Setup::new`]; flags about a scene where none is named.
pub fn named_scene(args: &SceneArgs, console: Console) -> Result<Option<Setup>, Failure> {
    if args.volume.path.is_some() || args.volume.phantom.is_some() || args.scene.is_some() {
        return Setup::new(args, console).map(Some);
    }
    // Every argument tells all that it holds.
    if format!("{args:?}") != format!("{:?}", no_flags()?) {
        return Err(Failure::usage("flags about a scene need one: name a volume, --phantom or --scene"));
    }
    Ok(None)
}

/// Returns the arguments about a scene where none is given.
fn no_flags() -> Result<SceneArgs, Failure> {
    let none = SceneArgs::augment_args(clap::Command::new("none")).get_matches_from(["none"]);
    SceneArgs::from_arg_matches(&none).map_err(Failure::failed)
}

/// Returns the embedded scene or, where a volume is named, an empty scene file.
pub fn default_scene(volume_named: bool) -> Result<SceneFile, Failure> {
    if volume_named {
        return Ok(SceneFile::default());
    }
    vr_io::parse_scene(EMBEDDED, Path::new("the embedded scene")).map_err(Failure::failed)
}

/// Describes a volume in a few words: `phantom fog, 64×64×64 f32`, or `halo.npy, 32314 points`.
pub fn title(section: &VolumeSection, volume: &Volume) -> String {
    let name = match &section.source {
        Some(VolumeSource::File(FileSource { path, .. })) => path.to_string(),
        Some(VolumeSource::Phantom { name, .. } | VolumeSource::PhantomPoints { name, .. }) => {
            format!("phantom {name}")
        }
        _ => "inline data".to_owned(),
    };
    match volume {
        Volume::Grid(u) => format!("{name}, {} {}", number::triple(u.dims(), "×"), u.voxel_type()),
        Volume::Color(c) => {
            let u = c.values();
            format!("{name}, {} {} with colours", number::triple(u.dims(), "×"), u.voxel_type())
        }
        Volume::Points(p) => format!("{name}, {} points", p.count()),
        Volume::Cells(mesh) => format!("{name}, {} cells", mesh.cells().len()),
        Volume::Rectilinear(grid) => format!("{name}, rectilinear {}", number::triple(grid.dims(), "×")),
        Volume::Amr(grid) => {
            let cells: usize = (0..grid.levels()).map(|level| grid.leaf_cells(level)).sum();
            format!("{name}, {cells} cells of {} levels", grid.levels())
        }
        Volume::Field(field) => format!("{name}, {}", field.kind()),
    }
}

/// Source of each parameter, scene file or flag, which decides the wording of an error and the exit code.
#[derive(Clone, Default)]
pub struct Origin {
    scene_file: Option<PathBuf>,
    /// Fields that flags set.
    pub overrides: Overrides,
}

impl Origin {
    /// Returns the failure of a wrong parameter: the scene file's, unless a flag set it or there is no file.
    fn parameter(&self, error: &ParameterError) -> Failure {
        match &self.scene_file {
            Some(path) if !self.overrides.set_by_flag(&error.field) => {
                Failure::failed(format!("{}: {error}", path.display()))
            }
            _ => Failure::usage(error),
        }
    }

    /// Returns the failure of a scene that cannot be made.
    pub fn scene_failure(&self, error: SceneFileError) -> Failure {
        match error {
            SceneFileError::Parameter { source, .. } => self.parameter(&source),
            SceneFileError::File(error) => match flag_for(&error) {
                Some(flag) => Failure::failed(format!("{error} ({flag})")),
                None => Failure::failed(error),
            },
            other => Failure::failed(other),
        }
    }
}

/// Returns the flag that supplies what a file leaves open.
fn flag_for(error: &FileError) -> Option<&'static str> {
    match &error.kind {
        FileErrorKind::Field(field) => match field.field.as_str() {
            "array" => Some("--value NAME"),
            "series" => Some("--series UID|NUMBER"),
            "level" => Some("--volume-level N"),
            _ => None,
        },
        FileErrorKind::Unsupported { .. } if vr_io::is_mesh(&error.path) => Some("--mesh FILE draws it among a volume"),
        _ => None,
    }
}
