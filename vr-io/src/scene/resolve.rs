//! From a scene file's sections to the scene that they describe: volumes, phantoms, presets and colour maps by name.

use std::path::Path;

use glam::DVec3;
use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::scene_file::{ColorEncoding, SceneFile, TransferSection, VolumeSection};
use vr_core::transfer::{Preset, srgb_to_linear};
use vr_core::{ControlPoint, Options, ParameterError, Scene, TriangleMesh, View, Volume};

use crate::framing::{OBLIQUE, framing};
use crate::mesh::read_mesh;
use crate::nifti::Transform;
use crate::paraview::read_color_maps;
use crate::raw::RawDescription;
use crate::read::{FileInfo, ReadOptions, read};
use crate::scalar::{Endian, ScalarType};

use super::error::{SceneFileError, nearest};

/// A scene, ready to be rendered.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What is drawn.
    pub scene: Scene,
    /// From where, and how large. Its layer is empty: what the mesh looks like from there, a rasteriser finds out.
    pub view: View,
    /// The opaque surface among the volume, where the file names one.
    pub mesh: Option<SceneMesh>,
    /// The renderer that the file asks for.
    pub renderer: String,
    /// That renderer's own options.
    pub options: Options,
    /// The largest error that the picture may have, where the file promises one.
    pub max_error: Option<f64>,
    /// What the volume's file said, where there is one.
    pub info: Option<FileInfo>,
    /// What was assumed, one line each.
    pub notes: Vec<String>,
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
    let folder = path.parent().unwrap_or(Path::new(""));
    let in_file = |source| SceneFileError::Parameter { path: path.into(), source };
    let mut notes = Vec::new();
    let found = load_volume(&file.volume, path)?;
    notes.extend(found.notes);

    let mut file = file.clone();
    let points = match (&mut file.transfer, found.points) {
        // A phantom brings its own, made for one unit distance.
        (transfer, Some(points)) if transfer.as_ref().is_none_or(names_no_points) => {
            transfer.get_or_insert_default().unit_distance.get_or_insert(TRANSFER_UNIT_DISTANCE);
            points
        }
        (transfer, _) => {
            let transfer = transfer.get_or_insert_default();
            let points = points(transfer, &found.volume, folder, in_file, &mut notes)?;
            if transfer.unit_distance.is_none() {
                notes.push(format!("unit_distance is the mean spacing, {:.6}", found.volume.mean_spacing()));
            }
            points
        }
    };
    let mesh = match &file.mesh {
        Some(section) => {
            let loaded = read_mesh(folder.join(&section.path))?;
            notes.extend(loaded.notes);
            Some(SceneMesh { mesh: loaded.mesh, color: section.color })
        }
        None => None,
    };
    let (scene, mut view) = file.assemble(found.volume, points).map_err(in_file)?;
    if file.camera.is_none() {
        view.camera = framing(bounds(&scene, mesh.as_ref()), found.info.as_ref(), OBLIQUE, None);
    }
    let render = file.render;
    Ok(LoadedScene {
        scene,
        view,
        mesh,
        renderer: render.renderer,
        options: render.options,
        max_error: render.max_error,
        info: found.info,
        notes,
    })
}

/// Whether a section leaves the points to the volume.
fn names_no_points(section: &TransferSection) -> bool {
    let TransferSection { preset, range, file, points, .. } = section;
    preset.is_none() && range.is_none() && file.is_none() && points.is_none()
}

/// The volume of a scene file.
#[derive(Clone, Debug)]
pub struct LoadedVolume {
    /// The volume.
    pub volume: Volume,
    /// What its file said, where there is one.
    pub info: Option<FileInfo>,
    /// A phantom's own transfer function, for a unit distance of [`TRANSFER_UNIT_DISTANCE`].
    pub points: Option<Vec<ControlPoint>>,
    /// What was assumed, one line each.
    pub notes: Vec<String>,
}

/// The volume that a `[volume]` section describes. Paths in it are relative to the folder of `path`, which is also what errors
/// call it; it may be empty for a section from no file.
///
/// # Errors
/// A [`SceneFileError`] naming the file and the field.
pub fn load_volume(section: &VolumeSection, path: &Path) -> Result<LoadedVolume, SceneFileError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let in_file = |source| SceneFileError::Parameter { path: path.into(), source };
    let wrong = |field: &str, found: &str, allowed| {
        in_file(ParameterError { field: field.into(), found: found.into(), allowed })
    };
    let sampled = |volume: Volume, points| LoadedVolume { volume, info: None, points, notes: Vec::new() };
    match (&section.path, &section.phantom, &section.data) {
        (Some(name), None, None) => {
            let path = folder.join(name);
            let transform = section.transform.as_deref().unwrap_or(Transform::Auto.name());
            let options = ReadOptions {
                frame: section.frame,
                component: section.component,
                transform: transform.parse().map_err(|_| {
                    wrong("volume.transform", &format!("'{transform}'"), "must be auto, sform, qform or spacing")
                })?,
                raw: raw_description(section, &path).map_err(in_file)?,
                ..ReadOptions::default()
            };
            let loaded = read(&path, &options)?;
            if section.transform.is_some() && !loaded.info.format.starts_with("NIfTI") {
                return Err(wrong("volume.transform", loaded.info.format, "only NIfTI files have a choice"));
            }
            Ok(LoadedVolume { volume: loaded.volume, info: Some(loaded.info), points: None, notes: loaded.notes })
        }
        (None, Some(name), None) => {
            let phantom = phantom::by_name(name).ok_or_else(|| {
                let near =
                    nearest(name, phantom::NAMES).map_or_else(String::new, |n| format!(" (did you mean '{n}'?)"));
                wrong(
                    "volume.phantom",
                    &format!("'{name}'{near}"),
                    "must be marschner-lobb, shepp-logan, blobs, shells, fog or hydrogen",
                )
            })?;
            let size = section.size.unwrap_or(PHANTOM_SIZE);
            if !PHANTOM_SIZES.contains(&size) {
                return Err(wrong("volume.size", &size.to_string(), "must be 2 to 2048"));
            }
            let grid = phantom::sample::<f32>(phantom.as_ref(), [size; 3])
                .map_err(|e| wrong("volume.size", &e.to_string(), "must be 2 to 2048"))?;
            Ok(sampled(grid.into(), Some(phantom.transfer_points())))
        }
        (None, None, Some(_)) => Ok(sampled(section.inline().map_err(in_file)?, None)),
        (None, None, None) => Err(wrong("volume", "nothing", "must have a path, a phantom or data")),
        _ => Err(wrong("volume", "several of path, phantom and data", "must have one of them")),
    }
}

/// Samples along each axis of a phantom of which no size is given.
const PHANTOM_SIZE: usize = 64;
/// The sizes that a phantom may have; the largest takes 32 GiB.
const PHANTOM_SIZES: std::ops::RangeInclusive<usize> = 2..=2048;

/// The description of a raw file: dims and type from the section or, where it has none, from the file's name. `None` where
/// the section describes nothing, so that the file must.
fn raw_description(section: &VolumeSection, path: &Path) -> Result<Option<RawDescription>, ParameterError> {
    let s = section;
    let described = s.dims.is_some() || s.voxel_type.is_some() || s.endian.is_some() || s.skip.is_some();
    let placed = s.spacing.is_some() || s.origin.is_some() || s.direction.is_some();
    let calibrated = s.slope.is_some() || s.intercept.is_some();
    if !described && !placed && !calibrated {
        return Ok(None);
    }
    let named = RawDescription::from_name(path).and_then(Result::ok);
    let missing = |field: &str, allowed| ParameterError { field: field.into(), found: "nothing".into(), allowed };
    let dims = s.dims.or(named.as_ref().map(|n| n.dims)).ok_or_else(|| {
        missing(
            "volume.dims",
            "type, endian, skip, spacing, origin, direction, slope and intercept are for raw files, which need dims",
        )
    })?;
    let scalar = match (&s.voxel_type, named) {
        (Some(name), _) => ScalarType::from_name(name).ok_or_else(|| {
            ParameterError::new("volume.type", name, "must be u8, i8, u16, i16, u32, i32, u64, i64, f32 or f64")
        })?,
        (None, Some(named)) => named.scalar,
        (None, None) => return Err(missing("volume.type", "raw files need a type")),
    };
    let endian = match s.endian.as_deref() {
        None | Some("little") => Endian::Little,
        Some("big") => Endian::Big,
        Some(other) => return Err(ParameterError::new("volume.endian", other, "must be little or big")),
    };
    let plain = RawDescription::new(dims, scalar);
    Ok(Some(RawDescription {
        endian,
        spacing: s.spacing,
        origin: s.origin.unwrap_or(plain.origin),
        direction: s.direction.unwrap_or(plain.direction),
        skip: s.skip.unwrap_or(0),
        calibration: s.calibration(),
        ..plain
    }))
}

/// The control points of a transfer function: given, by preset, from a file, or suggested by the values.
fn points(
    section: &TransferSection,
    volume: &Volume,
    folder: &Path,
    in_file: impl Fn(ParameterError) -> SceneFileError + Copy,
    notes: &mut Vec<String>,
) -> Result<Vec<ControlPoint>, SceneFileError> {
    let range = match section.range {
        Some([low, high]) if low <= high && low.is_finite() && high.is_finite() => (low, high),
        Some(range) => {
            let allowed = "must be two finite numbers, the smaller one first";
            return Err(in_file(ParameterError::new("transfer.range", range, allowed)));
        }
        // A volume without a single finite sample is vacuum: any range will do.
        None => volume.value_range().unwrap_or((0.0, 1.0)),
    };
    match (&section.points, &section.preset, &section.file) {
        (Some(points), None, None) => {
            let decode = |c: [f64; 3]| match section.colors {
                ColorEncoding::Linear => c,
                ColorEncoding::Srgb => c.map(srgb_to_linear),
            };
            let point = |p: &vr_core::scene_file::PointEntry| ControlPoint {
                value: p.value,
                color: decode(p.color),
                opacity: p.opacity,
                emission: p.emission,
            };
            Ok(points.iter().map(point).collect())
        }
        (None, Some(name), None) => {
            let preset = Preset::from_name(name).ok_or_else(|| {
                let near =
                    nearest(name, &Preset::NAMES).map_or_else(String::new, |n| format!(" (did you mean '{n}'?)"));
                let allowed = "must be grey, x-ray, ct-bone, ct-soft-tissue, mr-default, viridis, inferno or cool-warm";
                in_file(ParameterError { field: "transfer.preset".into(), found: format!("'{name}'{near}"), allowed })
            })?;
            Ok(preset.points(range))
        }
        (None, None, Some(name)) => {
            let path = folder.join(name);
            let maps = read_color_maps(&path)?;
            let count = maps.len();
            let Some(map) = maps.into_iter().next() else { return Ok(Vec::new()) };
            if count > 1 {
                notes.push(format!(
                    "{} holds {count} colour maps: the first one, {}, is used",
                    path.display(),
                    map.name
                ));
            }
            let points = map.over(range);
            notes.extend(map.notes);
            Ok(points)
        }
        (None, None, None) => {
            let integer = volume.uniform().is_some_and(|u| u.voxel_type().is_integer());
            let preset = Preset::suggest(range, integer).first().copied().unwrap_or(Preset::Grey);
            notes.push(format!("no transfer function: preset {preset} over {} to {}", range.0, range.1));
            Ok(preset.points(range))
        }
        _ => {
            let allowed = "must have one of points, preset and file";
            Err(in_file(ParameterError { field: "transfer".into(), found: "several of them".into(), allowed }))
        }
    }
}
