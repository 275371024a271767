//! Overrides of the scene file by flags.

use std::path::Path;

use vr_core::{ControlPoint, Options, Plane};
use vr_io::{
    AlbedoEntry, FileName, FileSource, GridDescription, LabelsSection, LightEntry, MeshSection, PhaseEntry,
    PointLightEntry, PointOptions, ResampleSection, SceneFile, ShadingSection, TransferSection, VolumeSection,
    VolumeSource,
};

use crate::args::{
    Background, CameraArgs, CompositingArgs, ImageArgs, LabelArgs, LightModel, MeshArgs, ScatteringArgs, SceneArgs,
    ShadingArgs, TransferArgs, VolumeArgs,
};
use crate::camera_flags;
use crate::failure::Failure;
use crate::transfer_box::TransferBox;

/// Renderer of media that scatter.
const LIGHT: &str = "light";

/// An albedo as scene files state it.
fn albedo_entry([r, g, b]: [f64; 3]) -> AlbedoEntry {
    if r == g && g == b { AlbedoEntry::Grey(r) } else { AlbedoEntry::Bands([r, g, b]) }
}

/// Writer of flags into a scene file that remembers the fields that they set: an error in one of those is about the command
/// line.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    fields: Vec<&'static str>,
    /// True if there is a scene file, whose folder the paths in it are relative to.
    over_file: bool,
}

impl Overrides {
    /// Writes every flag of a scene.
    ///
    /// # Errors
    /// A flag about files where there is a phantom, or the other way round; a colour for a mesh that there is not; flags of a camera that do not
    /// go together.
    pub fn apply(&mut self, args: &SceneArgs, file: &mut SceneFile) -> Result<(), Failure> {
        self.over_file = args.scene.is_some();
        self.volume(&args.volume, &mut file.volume)?;
        self.set_some("volume.filter", args.filter, &mut file.volume.filter);
        let resample = args.resample.choices().map(|choices| ResampleSection::describe(&choices));
        self.set_some("volume.resample", resample, &mut file.volume.resample);
        self.transfer(&args.transfer, file);
        self.shading(&args.shading, file);
        self.scattering(&args.scattering, file);
        self.labels(&args.labels, file)?;
        self.mesh(&args.mesh, file)?;
        self.image(&args.image, file);
        self.compositing(&args.compositing, file);
        self.camera(&args.camera, file)
    }

    /// Writes the flags of `[camera]`.
    ///
    /// # Errors
    /// Flags that do not go together.
    fn camera(&mut self, args: &CameraArgs, file: &mut SceneFile) -> Result<(), Failure> {
        let own = file.camera.unwrap_or_default();
        let section = camera_flags::overridden(args, own).map_err(|e| Failure::usage(&e))?;
        if section != own {
            file.camera = Some(section);
        }
        let CameraArgs { azimuth, elevation, eye, target, up, projection, height, fov, fit: _ } = args;
        let flags = [
            ("camera.azimuth", azimuth.is_some()),
            ("camera.elevation", elevation.is_some()),
            ("camera.eye", eye.is_some() || target.is_some()),
            ("camera.target", target.is_some()),
            ("camera.up", up.is_some() || eye.is_some() || target.is_some()),
            ("camera.height", height.is_some() || projection.is_some()),
            ("camera.fov", fov.is_some() || projection.is_some()),
        ];
        self.fields.extend(flags.into_iter().filter(|f| f.1).map(|f| f.0));
        Ok(())
    }

    /// Notes that a flag set a field, named as error messages name it.
    fn note(&mut self, field: &'static str) {
        self.fields.push(field);
    }

    /// True if a flag set a field, or a field that it is a part of: `shading.lights` for `shading.lights[0].color`.
    pub fn set_by_flag(&self, field: &str) -> bool {
        let part_of = |whole: &&str| {
            field.strip_prefix(*whole).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        self.fields.iter().any(part_of)
    }

    fn set<T>(&mut self, field: &'static str, flag: Option<T>, value: &mut T) {
        if let Some(flag) = flag {
            *value = flag;
            self.note(field);
        }
    }

    fn set_some<T>(&mut self, field: &'static str, flag: Option<T>, value: &mut Option<T>) {
        if flag.is_some() {
            *value = flag;
            self.note(field);
        }
    }

    /// Returns a path of the command line as the scene file must hold it: absolute, if that is relative to another folder.
    fn path_from_here(&self, path: &Path) -> FileName {
        let absolute = if self.over_file { std::path::absolute(path).ok() } else { None };
        absolute.as_deref().unwrap_or(path).into()
    }

    /// Writes the flags of `[volume]`, the filter's apart.
    ///
    /// # Errors
    /// An unknown phantom, or a flag that means nothing to the source of the volume: one about files where there is a phantom, say.
    pub fn volume(&mut self, args: &VolumeArgs, section: &mut VolumeSection) -> Result<(), Failure> {
        // Another volume: what the file says about its own is void, the filter apart.
        if let Some(path) = &args.path {
            let path = self.path_from_here(path);
            section.source = Some(VolumeSource::File(FileSource { path, ..FileSource::default() }));
            self.note("volume.path");
        } else if let Some(name) = &args.phantom {
            section.source = Some(VolumeSource::phantom(name).map_err(Failure::usage)?);
            self.note("volume.phantom");
        }
        match &mut section.source {
            Some(VolumeSource::File(file)) => {
                self.set_some("volume.frame", args.frame, &mut file.frame);
                self.set_some("volume.component", args.component, &mut file.component);
                self.set_some("volume.as", args.cells_or_points, &mut file.cells_or_points);
                self.set_some("volume.series", args.series.clone(), &mut file.series);
                self.set_some("volume.level", args.volume_level, &mut file.level);
                self.set_some("volume.transform", args.transform, &mut file.transform);
                self.set_some("volume.endian", args.endian, &mut file.endian);
                self.set_some("volume.skip", args.skip, &mut file.skip);
                self.grid(args, &mut file.grid);
                self.points(args, &mut file.points)?;
            }
            Some(VolumeSource::Phantom { size, .. }) => self.set_some("volume.size", args.phantom_size, size),
            Some(VolumeSource::PhantomPoints { count, .. }) => {
                self.set_some("volume.count", args.points_count, count);
            }
            Some(VolumeSource::Grid { grid, .. }) => self.grid(args, grid),
            Some(VolumeSource::Points { kernel, mixing, .. }) => {
                self.set_some("volume.kernel", args.kernel, kernel);
                self.set_some("volume.mixing", args.mixing, mixing);
            }
            None => {}
        }
        match (&section.source, given(args).find(|(field, _)| !self.fields.contains(field))) {
            (Some(source), Some((field, found))) => {
                Err(Failure::usage(source.refusal(field.trim_start_matches("volume."), found)))
            }
            _ => Ok(()),
        }
    }

    /// Writes the flags of a grid without a header.
    fn grid(&mut self, args: &VolumeArgs, grid: &mut GridDescription) {
        self.set_some("volume.dims", args.dims, &mut grid.dims);
        self.set_some("volume.type", args.voxel_type, &mut grid.scalar);
        self.set_some("volume.spacing", args.spacing, &mut grid.spacing);
        self.set_some("volume.origin", args.origin, &mut grid.origin);
    }

    /// Writes the flags of scattered points.
    fn points(&mut self, args: &VolumeArgs, points: &mut PointOptions) -> Result<(), Failure> {
        self.set_some("volume.value", args.value.clone(), &mut points.value);
        self.set_some("volume.kernel", args.kernel, &mut points.kernel);
        self.set_some("volume.mixing", args.mixing, &mut points.mixing);
        self.set_some("volume.color_value", args.color_value.clone(), &mut points.color_value);
        self.set_some("volume.color_map", args.color_map, &mut points.color_map);
        self.set_some("volume.color_range", args.color_range, &mut points.color_range);
        self.set_some("volume.radius", args.radius, &mut points.radius);
        self.set_some("volume.radius_scale", args.radius_scale, &mut points.radius_scale);
        let columns = &mut points.columns;
        self.set_some("volume.columns", args.position_columns.clone(), &mut columns.position);
        for (role, name) in &args.column {
            let column = match role.as_str() {
                "radius" => &mut columns.radius,
                "smoothing_length" => &mut columns.smoothing_length,
                "mass" => &mut columns.mass,
                "density" => &mut columns.density,
                "weight" => &mut columns.weight,
                _ => {
                    let allowed = "must be radius, smoothing_length, mass, density or weight";
                    return Err(Failure::usage(format!("--column: found {role:?}; {allowed}")));
                }
            };
            *column = Some(name.clone());
            self.note("volume.columns");
        }
        Ok(())
    }

    fn transfer(&mut self, args: &TransferArgs, file: &mut SceneFile) {
        let TransferArgs { look, preset, transfer, point, transfer_box, range, unit_distance, opacity_rule, colors } =
            args;
        let mut section = file.transfer.clone().unwrap_or_default();
        if preset.is_some() || transfer.is_some() {
            let TransferSection { unit_distance, opacity_rule, .. } = section;
            section = TransferSection { unit_distance, opacity_rule, ..TransferSection::default() };
        }
        match (preset, transfer) {
            (None, Some(file)) if names_file(file) => {
                section.file = Some(self.path_from_here(file));
                self.note("transfer.file");
            }
            (Some(name), _) => {
                section.preset = Some(name.clone());
                self.note("transfer.preset");
            }
            (None, Some(name)) => {
                section.preset = Some(name.to_string_lossy().into_owned());
                self.note("transfer.preset");
            }
            (None, None) => {}
        }
        if !point.is_empty() {
            let entry = |&[value, r, g, b, opacity]: &[f64; 5]| ControlPoint::new(value, [r, g, b], opacity);
            section.points = Some(point.iter().map(entry).collect());
            // What stretched those is not for points.
            (section.preset, section.file, section.range, section.rows) = (None, None, None, None);
            self.note("transfer.points");
        }
        if !transfer_box.is_empty() {
            section.rows = Some(TransferBox::rows(transfer_box));
            (section.preset, section.file, section.range, section.points) = (None, None, None, None);
            self.note("transfer.rows");
        }
        if let Some(look) = look {
            // In place of what the scene file names.
            section = TransferSection { look: *look, ..TransferSection::default() };
            self.note("transfer.look");
        }
        self.set_some("transfer.range", *range, &mut section.range);
        self.set_some("transfer.unit_distance", *unit_distance, &mut section.unit_distance);
        self.set("transfer.opacity_rule", *opacity_rule, &mut section.opacity_rule);
        self.set("transfer.colors", *colors, &mut section.colors);
        if look.is_some() || section != TransferSection::default() {
            file.transfer = Some(section);
        }
    }

    fn shading(&mut self, args: &ShadingArgs, file: &mut SceneFile) {
        if args.no_shading {
            file.shading = Some(ShadingSection { enabled: false, ..ShadingSection::default() });
            return;
        }
        let before = self.fields.len();
        let mut section = file.shading.clone().unwrap_or_default();
        self.set("shading.ambient", args.ambient, &mut section.ambient);
        self.set("shading.diffuse", args.diffuse, &mut section.diffuse);
        self.set("shading.specular", args.specular, &mut section.specular);
        self.set("shading.power", args.power, &mut section.power);
        self.set("shading.gradient", args.gradient, &mut section.gradient);
        if !args.light.is_empty() || args.headlight.is_some() {
            let from =
                |&(d, color): &([f64; 3], [f64; 3])| LightEntry { headlight: false, direction: Some(d.into()), color };
            let headlight = args.headlight.map(|color| LightEntry { headlight: true, direction: None, color });
            section.lights = headlight.into_iter().chain(args.light.iter().map(from)).collect();
            self.note("shading.lights");
        }
        if !args.gradient_opacity.is_empty() {
            section.gradient_opacity = args.gradient_opacity.iter().map(|&[m, f]| (m, f)).collect();
            self.note("shading.gradient_opacity");
        }
        if args.shading || self.fields.len() > before {
            section.enabled = true;
            file.shading = Some(section);
        }
    }

    /// Writes the flags of `[scattering]`. The lights of shading shine into the medium in place of those of the section.
    fn scattering(&mut self, args: &ScatteringArgs, file: &mut SceneFile) {
        let before = self.fields.len();
        let mut section = file.scattering.clone().unwrap_or_default();
        let lit_by_flag = self.set_by_flag("shading.lights");
        self.set("scattering.albedo", args.albedo.map(albedo_entry), &mut section.albedo);
        self.set("scattering.phase", args.anisotropy.map(PhaseEntry::HenyeyGreenstein), &mut section.phase);
        self.set("scattering.environment", args.environment, &mut section.environment);
        if let Some(path) = &args.environment_map {
            section.environment_map = Some(self.path_from_here(path));
            self.note("scattering.environment_map");
        }
        if !args.point_light.is_empty() {
            let entry =
                |&(position, color): &([f64; 3], [f64; 3])| PointLightEntry { position: position.into(), color };
            section.point_lights = args.point_light.iter().map(entry).collect();
            self.note("scattering.point_lights");
        }
        if !args.surface.is_empty() {
            section.surfaces.clone_from(&args.surface);
            self.note("scattering.surfaces");
        }
        let has_lamp = args.surface.iter().any(|surface| surface.emission != [0.0; 3]);
        let lit_otherwise = args.environment_map.is_some() || !args.point_light.is_empty() || has_lamp;
        match args.model.map(|model| model.option()) {
            Some(None) => {
                file.scattering = None;
                if file.render.renderer.as_deref() == Some(LIGHT) {
                    (file.render.renderer, file.render.options) = (None, Options::new());
                }
                return;
            }
            Some(Some(word)) => {
                if file.render.renderer.as_deref() != Some(LIGHT) {
                    (file.render.renderer, file.render.options) = (Some(LIGHT.to_owned()), Options::new());
                }
                file.render.options.0.insert("model".to_owned(), word.into());
            }
            None if file.scattering.is_none() && self.fields.len() == before => return,
            None => {}
        }
        let shading = file.shading.take().filter(|_| lit_by_flag || file.scattering.is_none());
        match shading {
            Some(shading) => section.lights = shading.lights,
            None if file.scattering.is_none() && lit_otherwise => section.lights = Vec::new(),
            // Of light that is scattered once a quarter comes back at most, and less than half of all.
            None if file.scattering.is_none() => {
                let color = [if args.model == Some(LightModel::Single) { 4.0 } else { 2.0 }; 3];
                section.lights = vec![LightEntry { headlight: true, direction: None, color }];
            }
            None => {}
        }
        file.scattering = Some(section);
    }

    fn labels(&mut self, args: &LabelArgs, file: &mut SceneFile) -> Result<(), Failure> {
        if let Some(path) = args.labels.as_ref().or(args.mask.as_ref()) {
            // Another file: what is said of single labels is not for it.
            let section = LabelsSection {
                file: self.path_from_here(path),
                mask: args.mask.is_some(),
                ..LabelsSection::default()
            };
            file.labels = Some(section);
            self.note("labels");
        }
        let given = args.label_names.is_some() || args.labels_as.is_some() || !args.label.is_empty();
        let Some(section) = &mut file.labels else {
            let complaint = "labels.file: there are no labels to name or draw; --labels FILE or --mask FILE names some";
            return if given { Err(Failure::usage(complaint)) } else { Ok(()) };
        };
        let names = args.label_names.as_ref().map(|path| self.path_from_here(path));
        self.set_some("labels.names", names, &mut section.names);
        self.set_some("labels.as", args.labels_as, &mut section.look);
        if !args.label.is_empty() {
            // After those of the file: the last word on a label holds.
            section.label.extend(args.label.iter().cloned());
            self.note("labels.label");
        }
        Ok(())
    }

    fn mesh(&mut self, args: &MeshArgs, file: &mut SceneFile) -> Result<(), Failure> {
        if let Some(path) = &args.mesh {
            // Another mesh: the colour in the file is not for it.
            file.mesh = Some(MeshSection { path: self.path_from_here(path), color: None });
            self.note("mesh.path");
        }
        match &mut file.mesh {
            Some(section) => self.set_some("mesh.color", args.mesh_color, &mut section.color),
            None if args.mesh_color.is_some() => {
                return Err(Failure::usage("mesh.color: there is no mesh to colour; --mesh FILE names one"));
            }
            None => {}
        }
        Ok(())
    }

    fn image(&mut self, args: &ImageArgs, file: &mut SceneFile) {
        self.set("image.size", args.size, &mut file.image.size);
        self.set("image.samples", args.samples, &mut file.image.samples);
        self.set("image.background", args.background.and_then(Background::color), &mut file.image.background);
        let crop = args.crop.map(|[low, high]| (low.into(), high.into()));
        self.set_some("clip.box", crop, &mut file.clip.crop);
        if !args.clip_plane.is_empty() {
            let plane = |&(normal, offset): &([f64; 3], f64)| Plane { normal: normal.into(), offset };
            file.clip.planes = args.clip_plane.iter().map(plane).collect();
            self.note("clip.planes");
        }
    }

    fn compositing(&mut self, args: &CompositingArgs, file: &mut SceneFile) {
        if let Some(name) = args.compositing {
            file.render.compositing = name;
            (file.render.threshold, file.render.level) = (None, None);
            self.note("render.compositing");
            // A scheme that lacks its parameter, too, is the command line's fault.
            self.note("render.threshold");
            self.note("render.level");
        }
        self.set_some("render.threshold", args.threshold, &mut file.render.threshold);
        self.set_some("render.level", args.level, &mut file.render.level);
    }
}

/// Returns the flags of `[volume]` that are given and name no source: the fields that they set, and to what.
fn given(args: &VolumeArgs) -> impl Iterator<Item = (&'static str, String)> {
    fn shown(value: &Option<impl std::fmt::Debug>) -> Option<String> {
        value.as_ref().map(|v| format!("{v:?}"))
    }
    let columns = (!args.column.is_empty()).then_some(&args.column);
    let flags = [
        ("volume.size", shown(&args.phantom_size)),
        ("volume.count", shown(&args.points_count)),
        ("volume.frame", shown(&args.frame)),
        ("volume.component", shown(&args.component)),
        ("volume.as", args.cells_or_points.map(|kind| kind.name().to_owned())),
        ("volume.series", shown(&args.series)),
        ("volume.level", shown(&args.volume_level)),
        ("volume.transform", shown(&args.transform)),
        ("volume.dims", shown(&args.dims)),
        ("volume.type", shown(&args.voxel_type)),
        ("volume.endian", shown(&args.endian)),
        ("volume.skip", shown(&args.skip)),
        ("volume.spacing", shown(&args.spacing)),
        ("volume.origin", shown(&args.origin)),
        ("volume.value", shown(&args.value)),
        ("volume.kernel", shown(&args.kernel)),
        ("volume.mixing", shown(&args.mixing)),
        ("volume.color_value", shown(&args.color_value)),
        ("volume.color_map", shown(&args.color_map)),
        ("volume.color_range", shown(&args.color_range)),
        ("volume.radius", shown(&args.radius)),
        ("volume.radius_scale", shown(&args.radius_scale)),
        ("volume.columns", shown(&args.position_columns).or_else(|| shown(&columns))),
    ];
    flags.into_iter().filter_map(|(field, found)| Some((field, found?)))
}
/// True if a word in the place of a transfer function names a file rather than a preset: it has an extension or leads into a folder.
pub fn names_file(word: &Path) -> bool {
    word.extension().is_some() || word.components().count() > 1
}
