//! Conversion of a scene file's sections to the scene that they describe: volumes, phantoms, presets and colour maps by name.

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock, OnceLock};

use glam::DVec3;
use vr_core::transfer::Preset;
use vr_core::{Compositing, Light, Options, ParameterError, Scene, TriangleMesh, View, Volume, number_text};
use vr_look::{Hints, Survey, fit};

use crate::environment_map::{LoadedEnvironment, read_environment_map};
use crate::framing::{default_angles, framing};
use crate::mesh::read_mesh;
use crate::read::{FileInfo, each_once};
use crate::transfer::read_transfer;

use super::error::{SceneFileError, unknown_name};
use super::labels::SceneLabels;
use super::labels_section::LabelsSection;
use super::named_transfer::NamedTransfer;
use super::scene_file::SceneFile;
use super::sections::{ColorEncoding, LookName, ShadingSection, TransferSection};
use super::transfer_points::TransferPoints;
use super::volume::{LoadedVolume, load_volume, outline_volume};

/// A scene, ready to be rendered.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene, without surfaces: the caller makes them of `mesh`.
    pub scene: Scene,
    /// The view: camera, clipping and size of the picture.
    pub view: View,
    /// The opaque surface among the volume, where the file names one.
    pub mesh: Option<SceneMesh>,
    /// The renderer that the file asks for, where it names one.
    pub renderer: Option<String>,
    /// The renderer's own options.
    pub options: Options,
    /// The largest error that the picture may have, where the file promises one.
    pub max_error: Option<f64>,
    /// Everything that the volume's file says, where there is one.
    pub info: Option<FileInfo>,
    /// Every file that was read for it, once each: the scene file (by [`crate::load_scene`]), headers, data files, the mesh and the colour
    /// map. None of them may be written over.
    pub files: Vec<PathBuf>,
    /// Notes on everything assumed, one line each.
    pub notes: Vec<String>,
    /// The scene before labels are laid over its volume; the same where there are none.
    pub unlabelled: Scene,
    /// The labels, if there are any, with the style of each stated.
    pub labels: Option<LabelsSection>,
    visible: OnceLock<Vec<DVec3>>,
}

/// The surface of a scene.
#[derive(Clone, Debug)]
pub struct SceneMesh {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Linear RGB all over; the mesh's own colours, or a default, if `None`.
    pub color: Option<[f64; 3]>,
}

impl LoadedScene {
    /// Lower and upper corner of the world box around all that there is to see: the volume, and the mesh where there is one.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        bounds(&self.scene, self.mesh.as_ref())
    }

    /// World positions that enclose all that is visible of the scene as it was loaded: of the volume, and the mesh where there is one.
    /// Found once, and kept.
    pub fn visible(&self) -> &[DVec3] {
        self.visible.get_or_init(|| visible(&self.scene, &self.view, self.mesh.as_ref()))
    }
}

fn visible(scene: &Scene, view: &View, mesh: Option<&SceneMesh>) -> Vec<DVec3> {
    let mut points = Survey::of(&scene.volume).visible(&scene.transfer, scene.compositing, &view.clip);
    points.extend(mesh.into_iter().flat_map(|mesh| mesh.mesh.positions().iter().copied()));
    points
}

fn bounds(scene: &Scene, mesh: Option<&SceneMesh>) -> (DVec3, DVec3) {
    let (low, high) = scene.volume.bounds();
    let (mesh_low, mesh_high) = mesh.map_or((low, high), |m| m.mesh.bounds());
    (low.min(mesh_low), high.max(mesh_high))
}

/// The scene that a scene file describes. Paths in it are relative to the folder of `path`, which is also what errors call it;
/// it may be empty for a scene from no file.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn resolve_scene(file: &SceneFile, path: &Path) -> Result<LoadedScene, SceneFileError> {
    resolve_scene_around(file, path, load_volume(&file.volume, path)?)
}

/// The scene that a scene file describes around a large volume of which only the header is read ([`crate::outline`]): enough to ask a
/// renderer whether it draws it before gigabytes are read. `None` where the volume is not large, or comes from no file of a grid.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn outline_scene(file: &SceneFile, path: &Path) -> Result<Option<LoadedScene>, SceneFileError> {
    let outline = outline_volume(&file.volume, path)?;
    outline.map(|outline| resolve_scene_around(file, path, outline)).transpose()
}

/// The scene that a scene file describes around a volume that is there already, for callers that draw one in several ways. See
/// [`resolve_scene`].
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn resolve_scene_around(
    file: &SceneFile,
    path: &Path,
    mut found: LoadedVolume,
) -> Result<LoadedScene, SceneFileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let in_file = |source| SceneFileError::Parameter { path: path.into(), source };
    let mut notes = Vec::new();
    // List every file that is read.
    notes.append(&mut found.notes);
    let volume_files = found.info.as_ref().map_or_else(Vec::new, |info| info.files.clone());
    let named = file.mesh.as_ref().map(|mesh| &mesh.path).into_iter();
    let named = named.chain(file.transfer.as_ref().and_then(|transfer| transfer.file.as_ref()));
    let named = named.chain(file.scattering.as_ref().and_then(|scattering| scattering.environment_map.as_ref()));
    let files = each_once(volume_files.into_iter().chain(named.map(|name| folder.join(name))));

    // Choose the transfer function: the phantom's own, or that of the section.
    let mut file = file.clone();
    if let Some(section) = &file.transfer {
        check_transfer(section, &mut notes).map_err(in_file)?;
    }
    let labels = file.labels.clone();
    let labels = labels.as_ref().map(|section| SceneLabels::read(section, folder)).transpose()?;
    let files = each_once(files.into_iter().chain(labels.iter().flat_map(|labels| labels.files().to_vec())));
    let mut automatic = false;
    let own = found.transfer.take();
    let points: TransferPoints = match (&mut file.transfer, own) {
        // A phantom brings its own, made for one unit distance.
        (transfer, Some((points, unit_distance))) if transfer.as_ref().is_none_or(names_no_points) => {
            transfer.get_or_insert_default().unit_distance.get_or_insert(unit_distance);
            points.into()
        }
        // Nothing is asked for: the volume tells.
        (transfer, _) if transfer.as_ref().is_none_or(|t| names_no_points(t) && t.look == LookName::Auto) => {
            automatic = true;
            let hints = hints(&found, file.render.compositing().map_err(in_file)?);
            let look = Survey::of(&found.volume).look(&hints);
            notes.push(look.reason);
            if file.shading.is_none()
                && file.scattering.is_none()
                && let Some(shading) = &look.shading
            {
                file.shading = Some(ShadingSection::describe(shading, &[Light::default()]));
            }
            file.volume.filter = file.volume.filter.or(look.filter);
            look.points.into()
        }
        (transfer, _) => {
            let transfer = transfer.get_or_insert_default();
            let named = named_transfer(transfer, &found, folder, in_file, &mut notes)?;
            named.complete(transfer);
            if transfer.unit_distance.is_none() {
                let what = match &found.volume {
                    Volume::Points(_) => "half the mean radius",
                    Volume::Cells(_) => "the edge of a cube of six cells",
                    Volume::Rectilinear(_) => "the mean step of the axes",
                    Volume::Amr(_) => "the mean edge of the finest cells",
                    _ => "the mean spacing",
                };
                notes.push(format!("unit_distance is {what}, {}", number_text(found.volume.mean_spacing())));
            }
            named.apply(&mut file, &mut notes)
        }
    };
    // Solids are lit, unless the file says otherwise.
    if file.shading.is_none() && file.scattering.is_none() && labels.as_ref().is_some_and(SceneLabels::has_solids) {
        notes.push("labels are lit by a headlight: no shading is named".to_owned());
        file.shading = Some(ShadingSection::default());
    }
    // Load the mesh, and set up scene and view.
    let mesh = match &file.mesh {
        Some(section) => {
            let loaded = read_mesh(folder.join(&section.path))?;
            notes.extend(loaded.notes);
            Some(SceneMesh { mesh: loaded.mesh, color: section.color })
        }
        None => None,
    };
    let (mut scene, mut view) = file.assemble(found.volume, points).map_err(in_file)?;
    let map = file.scattering.as_ref().and_then(|section| section.environment_map.as_ref());
    if let (Some(name), Some(scattering)) = (map, &mut scene.scattering) {
        let LoadedEnvironment { image, notes: said } = read_environment_map(folder.join(name))?;
        notes.extend(said);
        Arc::make_mut(scattering).environment_map = Some(Arc::new(image));
    }
    let unlabelled = scene.clone();
    let labels = match &labels {
        Some(labels) => {
            let (labelled, stated) = labels.over(scene, automatic, found.info.as_ref(), &mut notes, in_file)?;
            scene = labelled;
            Some(stated)
        }
        None => None,
    };
    let seen = OnceLock::new();
    // Frame all that is visible, where the file does not say all of the camera.
    let info = found.info.as_ref();
    let section = file.camera.unwrap_or_default();
    let framed = |fov| {
        let whole = framing(bounds(&scene, mesh.as_ref()), info, section.angles(default_angles(info)), fov);
        fit(&whole, seen.get_or_init(|| visible(&scene, &view, mesh.as_ref())), view.aspect())
    };
    let camera = section.camera(framed).map_err(in_file)?;
    view.camera = camera;
    let render = file.render;
    Ok(LoadedScene {
        scene,
        view,
        mesh,
        renderer: render.renderer,
        options: render.options,
        max_error: render.max_error,
        info: found.info,
        files,
        notes,
        unlabelled,
        labels,
        visible: seen,
    })
}

/// Refuses, or says, what has no effect on the points of a section.
fn check_transfer(section: &TransferSection, notes: &mut Vec<String>) -> Result<(), ParameterError> {
    let TransferSection { preset, range, file, points, rows, colors, .. } = section;
    match (points.is_some() || rows.is_some(), range) {
        (true, Some(range)) if preset.is_none() && file.is_none() => {
            let allowed = "points have values of their own: only a preset or a file is stretched over a range";
            return Err(ParameterError::new("transfer.range", range, allowed));
        }
        (false, _) if *colors == ColorEncoding::Srgb => {
            notes
                .push("transfer.colors has no effect: only points leave open how their colours are encoded".to_owned());
        }
        _ => {}
    }
    Ok(())
}

/// Names that a preset may have.
static PRESETS: LazyLock<String> = LazyLock::new(|| format!("must be one of {}", Preset::NAMES.join(", ")));

/// The preset of a name.
///
/// # Errors
/// A [`ParameterError`] with the name most like it, and all that there are.
pub fn preset_by_name(name: &str) -> Result<Preset, ParameterError> {
    Preset::from_name(name).ok_or_else(|| unknown_name("transfer.preset", name, &Preset::NAMES, &PRESETS))
}

/// True if a section leaves the points to the volume.
fn names_no_points(section: &TransferSection) -> bool {
    let TransferSection { preset, range, file, points, rows, .. } = section;
    preset.is_none() && range.is_none() && file.is_none() && points.is_none() && rows.is_none()
}

/// Facts about a volume besides its values.
fn hints(found: &LoadedVolume, compositing: Compositing) -> Hints {
    Hints { compositing, ..found.info.as_ref().map(FileInfo::hints).unwrap_or_default() }
}

/// A transfer function: given, by preset, from a file, or suggested by the values.
fn named_transfer(
    section: &TransferSection,
    found: &LoadedVolume,
    folder: &Path,
    in_file: impl Fn(ParameterError) -> SceneFileError + Copy,
    notes: &mut Vec<String>,
) -> Result<NamedTransfer, SceneFileError> {
    let volume = &found.volume;
    // A volume without a single finite voxel is vacuum: any range will do.
    let values = || volume.value_range().unwrap_or((0.0, 1.0));
    let asked = match section.range {
        Some([low, high]) if low <= high && low.is_finite() && high.is_finite() => Some((low, high)),
        Some(range) => {
            let allowed = "must be two finite numbers, the smaller one first";
            return Err(in_file(ParameterError::new("transfer.range", range, allowed)));
        }
        None => None,
    };
    match (TransferPoints::of_section(section).map_err(in_file)?, &section.preset, &section.file) {
        (Some(points), None, None) => Ok(points.into()),
        (None, Some(name), None) => {
            let preset = preset_by_name(name).map_err(in_file)?;
            let hints = hints(found, Compositing::default());
            let mut fitted = Survey::of(volume).preset(preset, values(), asked, &hints);
            notes.append(&mut fitted.notes);
            Ok(NamedTransfer::from(fitted).beside(volume))
        }
        (None, None, Some(name)) => {
            let mut file = read_transfer(folder.join(name))?;
            notes.append(&mut file.notes);
            Ok(NamedTransfer::of_file(&file, asked, values(), volume.mean_spacing()))
        }
        (None, None, None) => {
            let range = asked.unwrap_or_else(values);
            let integer = volume.grid().is_some_and(|u| u.voxel_type().is_integer());
            let preset = Preset::suggest(range, integer).first().copied().unwrap_or(Preset::Grey);
            notes.push(format!(
                "no transfer function: preset {preset} over {} to {}",
                number_text(range.0),
                number_text(range.1)
            ));
            Ok(NamedTransfer::from(TransferPoints::from(preset.points(range))).beside(volume))
        }
        _ => {
            let allowed = "must have one of them";
            Err(in_file(ParameterError {
                field: "transfer".into(),
                found: "several of points, rows, preset and file".into(),
                allowed,
            }))
        }
    }
}
