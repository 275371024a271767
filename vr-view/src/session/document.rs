//! Document: the scene as it stands, and what edits do to it.

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use vr_core::{Camera, Clip, Options, Projection, RenderError, Renderer, Scene, Surfaces, View, Volume};
use vr_io::{
    CameraSection, CompositingName, LabelsSection, LoadedScene, RenderSection, SceneFile, TransferSection, USUAL_FOV,
};
use vr_look::{Survey, fit};
use vr_mesh::Surface;
use vr_study::stated::StatedRenderer;

use super::edit::{Edit, PROVEN, Quality, Side};
use super::error::EditError;
use super::moving::{QUICK, Quick};
use super::navigation;
use super::second::Setting;
use super::subject::{RendererList, Subject};

/// Largest width or height of a picture.
const MAX_SIDE: u32 = 8192;
/// Most pixels of a picture: a screen of 4K, and a half more.
pub const MAX_PIXELS: u32 = 3840 * 2160 * 3 / 2;

/// Most changes that can be taken back.
const MAX_HISTORY: usize = 200;
/// Most volumes that history keeps in memory besides the one that is shown.
const MAX_FORMER_VOLUMES: usize = 1;

/// Largest number of voxels for which a second renderer is prepared for moving pictures: it may need as much memory as the volume.
const MAX_VOXELS_BESIDE: usize = 1 << 25;

/// Part of two boxes that must be common for a camera to be kept when one takes the place of the other.
const ALIKE: f64 = 0.5;

/// Option of renderers that aim at an error by themselves.
const QUALITY: &str = "quality";

/// Part of a document that an edit has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// Nothing that is drawn.
    Nothing,
    /// Camera, size or clip.
    View,
    /// The renderer or its quality.
    Renderer,
    /// The scene itself.
    Scene,
    /// The volume: another file is shown.
    Volume,
}

/// The scene, its view and its renderer, always such as can be written to a scene file.
pub struct Document {
    subject: Arc<Subject>,
    renderers: Arc<RendererList>,
    /// The scene file, complete but for camera and size, which [`Self::view`] has.
    file: SceneFile,
    scene: Scene,
    /// The volume without labels.
    values: Volume,
    view: View,
    /// Camera and shape of the picture that the scene was opened with.
    first: (Camera, f64),
    visible: OnceLock<Vec<DVec3>>,
    /// Counts changes of the scene.
    scene_revision: u64,
    /// Counts changes of the volume.
    volume_revision: u64,
    undo: Vec<Former>,
    redo: Vec<Former>,
    gesture: Gesture,
}

/// State that can be come back to.
struct Former {
    subject: Arc<Subject>,
    file: SceneFile,
    /// The camera: come back to only with another volume.
    camera: Camera,
}

/// Gesture that edits may belong to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Gesture {
    /// None: each edit is undone by itself.
    None,
    /// One that has changed nothing yet.
    Begun,
    /// One whose former state is kept already.
    Kept,
}

impl Document {
    /// The document of a subject.
    ///
    /// # Errors
    /// A scene that cannot be made, or that its renderer does not draw.
    pub fn new(subject: Arc<Subject>, renderers: Arc<RendererList>) -> Result<Self, EditError> {
        let mut file = subject.file.clone();
        let LoadedScene { scene, view, unlabelled, .. } = resolved(&subject, &file)?;
        if file.render.renderer.is_none() {
            file.render.renderer = Some((renderers.usual)(&scene).to_owned());
        }
        let document = Self {
            first: (view.camera, view.aspect()),
            scene: with_surfaces(&subject, scene),
            values: unlabelled.volume,
            subject,
            renderers,
            file,
            view,
            visible: OnceLock::new(),
            scene_revision: 0,
            volume_revision: 0,
            undo: Vec::new(),
            redo: Vec::new(),
            gesture: Gesture::None,
        };
        document.renderer(&document.file.render, None)?.supports(&document.scene, Some(&document.view))?;
        Ok(document)
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The volume as slices show it: under the scene's filter, and without the codes that labels make of its values.
    pub fn values(&self) -> &Volume {
        &self.values
    }

    /// The scene's `[labels]` section, with the colours of labels; `None` if it has none.
    pub fn labels(&self) -> Option<&LabelsSection> {
        self.file.labels.as_ref()
    }

    /// The view of the picture at rest.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The volume and the scene that were opened.
    pub fn subject(&self) -> &Arc<Subject> {
        &self.subject
    }

    /// The renderers.
    pub fn renderers(&self) -> &RendererList {
        &self.renderers
    }

    /// Number of changes of the scene so far.
    pub fn scene_revision(&self) -> u64 {
        self.scene_revision
    }

    /// Number of changes of the volume so far.
    pub fn volume_revision(&self) -> u64 {
        self.volume_revision
    }

    /// True if there is a change to take back, and one to make again.
    pub fn history(&self) -> [bool; 2] {
        [!self.undo.is_empty(), !self.redo.is_empty()]
    }

    /// The scene file that `vr render --scene` draws the picture at rest from, bit for bit.
    pub fn file(&self) -> SceneFile {
        let mut file = self.file.clone();
        file.camera = Some(CameraSection::from(&self.view.camera));
        file.image.size = self.view.size;
        file.render.max_error = self.max_error();
        file
    }

    /// The section of the renderer and its options.
    pub(super) fn file_render(&self) -> &RenderSection {
        &self.file.render
    }

    /// Name of the renderer.
    pub fn renderer_name(&self) -> &str {
        self.file.render.renderer.as_deref().unwrap_or_default()
    }

    /// Quality of the picture at rest, where it is one that has a name.
    pub fn quality(&self) -> Option<Quality> {
        if self.max_error() == Some(PROVEN) {
            return Some(Quality::Proven);
        }
        let word = self.file.render.options.0.get(QUALITY)?.to_string();
        [Quality::Draft, Quality::Normal, Quality::Fine].into_iter().find(|q| q.option() == Some(word.as_str()))
    }

    /// Qualities that can be chosen for this renderer and scene.
    pub fn qualities(&self) -> Vec<Quality> {
        let mut qualities = Vec::new();
        if has_qualities(&self.file.render.options) {
            qualities.extend([Quality::Draft, Quality::Normal, Quality::Fine]);
        }
        if self.prover(&self.proven(&self.file.render), PROVEN).is_some() {
            qualities.push(Quality::Proven);
        }
        qualities
    }

    /// A section with a bound in place of a quality: the two do not go together.
    fn proven(&self, section: &RenderSection) -> RenderSection {
        let mut section = RenderSection { max_error: Some(PROVEN), ..section.clone() };
        let name = section.renderer.as_deref().unwrap_or_default();
        let usual = self.renderers.named(name).and_then(|r| r.option_values().0.remove(QUALITY));
        if let (Some(usual), Some(quality)) = (usual, section.options.0.get_mut(QUALITY)) {
            *quality = usual;
        }
        section
    }

    /// Largest error of a pixel that is asked for, if the renderer bounds that of this scene.
    pub fn max_error(&self) -> Option<f64> {
        self.file.render.max_error.filter(|&error| self.prover(&self.file.render, error).is_some())
    }

    /// The renderer of a section under a bound; `None` if it bounds no error of this scene.
    fn prover(&self, section: &RenderSection, max_error: f64) -> Option<Box<dyn Renderer>> {
        let renderer = self.renderer(section, None).ok()?.with_max_error(max_error)?.ok()?;
        renderer.supports(&self.scene, Some(&self.view)).ok().map(|()| renderer)
    }

    /// Renderers of the stages from the quickest to the best: while something moves, at full size, and proven.
    ///
    /// # Errors
    /// An option that the renderer does not take.
    pub fn stages(&self) -> Result<Stages, EditError> {
        let draft = self.renderer(&self.file.render, Quality::Draft.option());
        let sharp = self.renderer(&self.file.render, None)?;
        let max_error = self.max_error();
        let proven = max_error.and_then(|error| Some((self.prover(&self.file.render, error)?, error)));
        // Steps that are chosen by hand leave nothing to a quality.
        let draft = match draft {
            Ok(draft) if draft.supports(&self.scene, Some(&self.view)).is_ok() => draft,
            _ => self.renderer(&self.file.render, None)?,
        };
        Ok(Stages { draft, sharp, proven })
    }

    /// Returns the renderer of a setting for quick pictures, by its number (see [`QUICK`]). `None` if it does not draw the scene, or if the document's options were chosen by
    /// hand, so that other settings would draw something else.
    ///
    /// # Errors
    /// An option that the renderer does not take.
    pub(super) fn quick(&self, setting: usize) -> Result<Option<Box<dyn Renderer>>, EditError> {
        let Some(Quick { renderer, options }) = setting.checked_sub(1).map(|index| &QUICK[index]) else {
            return Ok(Some(self.stages()?.draft));
        };
        let Some(renderer) = self.renderers.named(renderer).filter(|_| self.has_usual_renderer()) else {
            return Ok(None);
        };
        let voxels = self.scene.volume.value_grid().map_or(0, |grid| grid.dims().iter().product());
        if renderer.name() != self.renderer_name() && voxels > MAX_VOXELS_BESIDE {
            return Ok(None);
        }
        let options = options.iter().fold(Options::new(), |all, (key, value)| all.with(key, *value));
        let configured = renderer.with_options(&options).ok();
        let drawing = configured.filter(|renderer| renderer.supports(&self.scene, Some(&self.view)).is_ok());
        Ok(drawing.map(|renderer| -> Box<dyn Renderer> { renderer }))
    }

    /// True if the renderer is the scene's usual one, with its usual options except for the quality.
    fn has_usual_renderer(&self) -> bool {
        let name = (self.renderers.usual)(&self.scene);
        let Some(usual) = self.renderers.named(name).filter(|_| name == self.renderer_name()) else { return false };
        let [mut own, mut usual] = [self.file.render.options.clone(), StatedRenderer::of(usual, None).options];
        // Options that the usual renderer does not list, such as a bound of the error, are not compared.
        own.0.retain(|key, _| key != QUALITY && usual.0.contains_key(key));
        usual.0.retain(|key, _| own.0.contains_key(key));
        own == usual
    }

    /// The renderer of a section without its bound, at a quality of its own where one is named.
    fn renderer(&self, section: &RenderSection, quality: Option<&str>) -> Result<Box<dyn Renderer>, EditError> {
        let name = section.renderer.as_deref().unwrap_or_default();
        let renderer = self.renderers.named(name).ok_or_else(|| EditError::UnknownRenderer(name.to_owned()))?;
        let mut options = section.options.clone();
        if let Some(quality) = quality.filter(|_| has_qualities(&options)) {
            options = options.with(QUALITY, quality);
        }
        Ok(renderer.with_options(&options)?)
    }

    /// The own section by another renderer, with its usual options.
    fn drawn_by(&self, name: &str) -> Result<RenderSection, EditError> {
        let renderer = self.renderers.named(name).ok_or_else(|| EditError::UnknownRenderer(name.to_owned()))?;
        Ok(RenderSection {
            renderer: Some(name.to_owned()),
            options: StatedRenderer::of(renderer, None).options,
            max_error: Some(PROVEN),
            ..self.file.render.clone()
        })
    }

    /// A section at another quality.
    fn at_quality(&self, mut section: RenderSection, quality: Quality) -> Result<RenderSection, EditError> {
        let name = || section.renderer.clone().unwrap_or_default();
        match quality.option() {
            Some(word) if has_qualities(&section.options) => {
                section.options.0.insert(QUALITY.to_owned(), word.into());
                section.max_error = None;
                Ok(section)
            }
            Some(word) => Err(EditError::NoQuality { quality: word, renderer: name() }),
            None => {
                let proven = self.proven(&section);
                if self.prover(&proven, PROVEN).is_none() {
                    return Err(EditError::NoProof(name()));
                }
                Ok(proven)
            }
        }
    }

    /// The renderer of a second setting, and the bound that it draws under, if it has one for this scene.
    ///
    /// # Errors
    /// A renderer that is not there, or does not draw the scene; a quality that it does not have.
    pub fn second(&self, setting: &Setting) -> Result<(Box<dyn Renderer>, Option<f64>), EditError> {
        let is_own = setting.renderer == self.renderer_name();
        let mut section = if is_own { self.file.render.clone() } else { self.drawn_by(&setting.renderer)? };
        if let Some(quality) = setting.quality {
            section = self.at_quality(section, quality)?;
        }
        let prover = section.max_error.and_then(|error| Some((self.prover(&section, error)?, error)));
        if let Some((renderer, error)) = prover {
            return Ok((renderer, Some(error)));
        }
        let renderer = self.renderer(&section, None)?;
        renderer.supports(&self.scene, Some(&self.view))?;
        Ok((renderer, None))
    }

    /// Makes an edit; returns what it has changed.
    ///
    /// # Errors
    /// The reason why nothing was changed.
    pub fn apply(&mut self, edit: &Edit) -> Result<Change, EditError> {
        match edit {
            Edit::Gesture { begins } => {
                self.gesture = if *begins { Gesture::Begun } else { Gesture::None };
                Ok(Change::Nothing)
            }
            Edit::Undo => self.step_back(),
            Edit::Redo => self.step_forward(),
            Edit::Size { size } => {
                let [w, h] = *size;
                let fits = |n: u32| (1..=MAX_SIDE).contains(&n);
                if !fits(w) || !fits(h) || w * h > MAX_PIXELS {
                    return Err(EditError::Size(*size));
                }
                let changed = self.view.size != *size;
                let is_first = self.view.camera == self.first_camera();
                self.view.size = *size;
                if is_first {
                    self.view.camera = self.first_camera();
                }
                Ok(if changed { Change::View } else { Change::Nothing })
            }
            _ => match self.moved(edit)? {
                Some(camera) => {
                    self.view.camera = camera;
                    Ok(Change::View)
                }
                None => self.change(edit),
            },
        }
    }

    /// The camera after a move; `None` for an edit that is none.
    fn moved(&self, edit: &Edit) -> Result<Option<Camera>, EditError> {
        let camera = &self.view.camera;
        Ok(Some(match edit {
            Edit::Orbit { right, up } => navigation::orbit(camera, *right, *up)?,
            Edit::Roll { degrees } => navigation::roll(camera, *degrees)?,
            Edit::Pan { right, up } => navigation::pan(camera, *right, *up)?,
            Edit::Zoom { factor, at } => navigation::zoom(camera, *factor, *at)?,
            Edit::Side { side } => self.camera_at(*side),
            Edit::Fit => fit(camera, self.visible(), self.view.aspect()),
            Edit::ResetCamera => self.first_camera(),
            Edit::Camera { camera } => {
                let stated = *camera;
                let camera = stated.camera(|_| self.first.0)?;
                if CameraSection::from(&camera) != stated {
                    let allowed = "must state projection, eye, target, up, and height or fov";
                    return Err(vr_core::ParameterError::new("camera", "an incomplete one", allowed).into());
                }
                camera
            }
            Edit::Projection { perspective } => {
                let is_perspective = camera.projection.is_perspective();
                match (perspective, is_perspective) {
                    (true, false) => navigation::project(camera, Some(USUAL_FOV))?,
                    (false, true) => navigation::project(camera, None)?,
                    _ => *camera,
                }
            }
            Edit::FieldOfView { degrees } => navigation::project(camera, Some(*degrees))?,
            _ => return Ok(None),
        }))
    }

    /// The camera of the scene as it was opened; in a narrower picture from further away, so that all is seen that was to be seen.
    fn first_camera(&self) -> Camera {
        let (camera, aspect) = self.first;
        let narrower = (self.view.aspect() / aspect).min(1.0);
        navigation::zoom(&camera, narrower, [0.0; 2]).unwrap_or(camera)
    }

    /// The camera that sees all that is visible from a side.
    fn camera_at(&self, side: Side) -> Camera {
        let fov = match self.view.camera.projection {
            Projection::Perspective { fov } => Some(fov),
            Projection::Orthographic { .. } => None,
        };
        let whole = vr_io::framing(self.bounds(), self.subject.volume.info.as_ref(), side.angles(), fov);
        fit(&whole, self.visible(), self.view.aspect())
    }

    /// Corners of the world box around all that there is to see.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let (low, high) = self.scene.volume.bounds();
        let (mesh_low, mesh_high) = self.subject.mesh.as_ref().map_or((low, high), |(mesh, _)| mesh.bounds());
        (low.min(mesh_low), high.max(mesh_high))
    }

    /// World positions that enclose all that is visible.
    fn visible(&self) -> &[DVec3] {
        self.visible.get_or_init(|| visible(&self.subject, &self.scene, &self.view.clip))
    }

    /// Makes an edit of what can be undone.
    fn change(&mut self, edit: &Edit) -> Result<Change, EditError> {
        let mut file = self.file.clone();
        match edit {
            Edit::Transfer { points } => {
                let transfer = file.transfer.get_or_insert_default();
                if transfer.rows.is_some() {
                    return Err(EditError::Rows);
                }
                transfer.points = Some(points.clone());
            }
            Edit::UnitDistance { length } => file.transfer.get_or_insert_default().unit_distance = Some(*length),
            Edit::Preset { name } => {
                let preset = Some(vr_io::preset_by_name(name)?.name().to_owned());
                look_anew(&mut file, Some(TransferSection { preset, ..TransferSection::default() }));
            }
            Edit::AutomaticLook => look_anew(&mut file, None),
            Edit::Shading { shading } => file.shading = Some(shading.clone()),
            Edit::Crop { corners } => file.clip.crop = corners.map(|[low, high]| (low.into(), high.into())),
            Edit::Planes { planes } => file.clip.planes.clone_from(planes),
            Edit::Background { color } => file.image.background = *color,
            Edit::Renderer { name } => file.render = self.drawn_by(name)?,
            Edit::Quality { quality } => file.render = self.at_quality(file.render, *quality)?,
            // Every other edit is done by the caller.
            _ => return Ok(Change::Nothing),
        }
        let former = self.former();
        let change = self.take(file)?;
        if change != Change::Nothing {
            self.redo.clear();
            if self.gesture != Gesture::Kept {
                self.keep(former);
            }
            if self.gesture == Gesture::Begun {
                self.gesture = Gesture::Kept;
            }
        }
        Ok(change)
    }

    /// Shows another volume under the transfer function, the light, the background and the renderer that are chosen, as far as they suit it: a curve
    /// under which nothing is seen gives way to the volume's own look. The camera
    /// stays where both volumes take up the same room; elsewhere it looks the same way at all that is visible. Crop box and planes, which belong to a
    /// place, are taken away.
    ///
    /// # Errors
    /// A scene that cannot be made, or that none of the renderers draws.
    pub fn open(&mut self, subject: Arc<Subject>) -> Result<Change, EditError> {
        let former = self.former();
        let own = &subject.file;
        let mut looked = SceneFile { transfer: self.file.transfer.clone(), ..own.clone() };
        looked.shading.clone_from(&self.file.shading);
        looked.image.clone_from(&self.file.image);
        let kept = SceneFile { render: self.file.render.clone(), ..looked.clone() };
        let mut own_look = own.clone();
        own_look.image.clone_from(&self.file.image);
        let curve = SceneFile { transfer: self.file.transfer.clone(), ..own_look.clone() };
        // Keep as much as the volume takes: all, all but the renderer, the curve alone, or nothing.
        // A curve under which nothing of it is seen is no look for it.
        let is_seen = |file: &SceneFile| resolved(&subject, file).is_ok_and(|loaded| shows(&loaded.scene));
        let kept = [kept, looked, curve].into_iter().filter(is_seen);
        let taken = kept.filter_map(|file| self.take_all(Arc::clone(&subject), file, None).ok()).next();
        let change = match taken {
            Some(change) => change,
            None => self.take_all(subject, own_look, None)?,
        };
        self.redo.clear();
        self.keep(former);
        self.gesture = Gesture::None;
        Ok(change)
    }

    /// The state as it is, to be come back to.
    fn former(&self) -> Former {
        Former { subject: Arc::clone(&self.subject), file: self.file.clone(), camera: self.view.camera }
    }

    /// Keeps a state that can be come back to; those that need a volume too many are forgotten.
    fn keep(&mut self, former: Former) {
        self.undo.push(former);
        if self.undo.len() > MAX_HISTORY {
            self.undo.remove(0);
        }
        let mut volumes = vec![Arc::as_ptr(&self.subject)];
        let too_old = self.undo.iter().rposition(|former| {
            let volume = Arc::as_ptr(&former.subject);
            if volumes.contains(&volume) {
                return false;
            }
            volumes.push(volume);
            volumes.len() > 1 + MAX_FORMER_VOLUMES
        });
        if let Some(last) = too_old {
            self.undo.drain(..=last);
        }
    }

    fn step_back(&mut self) -> Result<Change, EditError> {
        let Former { subject, file, camera } = self.undo.pop().ok_or(EditError::NoHistory("undo"))?;
        let now = self.former();
        let change = self.take_all(subject, file, Some(camera))?;
        self.redo.push(now);
        Ok(change)
    }

    fn step_forward(&mut self) -> Result<Change, EditError> {
        let Former { subject, file, camera } = self.redo.pop().ok_or(EditError::NoHistory("redo"))?;
        let now = self.former();
        let change = self.take_all(subject, file, Some(camera))?;
        self.undo.push(now);
        Ok(change)
    }

    /// Takes over a scene file in place of the own one, or none of it.
    fn take(&mut self, file: SceneFile) -> Result<Change, EditError> {
        self.take_all(Arc::clone(&self.subject), file, None)
    }

    /// Takes over a scene file and its volume in place of the own ones, or none of it. Another volume is seen by `camera`, or by one that is found.
    fn take_all(
        &mut self,
        subject: Arc<Subject>,
        mut file: SceneFile,
        camera: Option<Camera>,
    ) -> Result<Change, EditError> {
        let change = match () {
            () if !Arc::ptr_eq(&subject, &self.subject) => Change::Volume,
            () if file == self.file => return Ok(Change::Nothing),
            () if concerns_scene(&file, &self.file) => Change::Scene,
            () if file.clip != self.file.clip => Change::View,
            () => Change::Renderer,
        };
        let mut view = View { clip: file.clip.clone(), ..self.view.clone() };
        view.validate()?;
        let (mut scene, mut values, mut first) = (self.scene.clone(), self.values.clone(), self.first);
        if change >= Change::Scene {
            let loaded = resolved(&subject, &file)?;
            file = file.completed(&loaded.unlabelled, loaded.labels.clone(), &view, subject.volume.info.as_ref());
            (scene, values) = (with_surfaces(&subject, loaded.scene), loaded.unlabelled.volume);
        }
        if change == Change::Volume {
            let own = resolved(&subject, &subject.file)?.view;
            first = (own.camera, own.aspect());
            view.camera = match camera {
                Some(camera) => camera,
                None if are_alike(self.scene.volume.bounds(), scene.volume.bounds()) => view.camera,
                None => fit(&view.camera, &visible(&subject, &scene, &view.clip), view.aspect()),
            };
            view.validate()?;
        }
        self.renderer(&file.render, None)?.supports(&scene, Some(&view))?;
        self.file = file;
        self.view = view;
        if change >= Change::Scene {
            (self.scene, self.values, self.first, self.subject) = (scene, values, first, subject);
            self.scene_revision += 1;
        }
        self.volume_revision += u64::from(change == Change::Volume);
        if change != Change::Renderer {
            self.visible = OnceLock::new();
        }
        Ok(change)
    }
}

/// Renderers of a picture's stages.
pub struct Stages {
    /// While something moves.
    pub draft: Box<dyn Renderer>,
    /// At rest.
    pub sharp: Box<dyn Renderer>,
    /// Under an error bound, and that bound.
    pub proven: Option<(Box<dyn Renderer>, f64)>,
}

/// World positions that enclose all that is visible of a scene.
fn visible(subject: &Subject, scene: &Scene, clip: &Clip) -> Vec<DVec3> {
    let mut points = Survey::of(&scene.volume).visible(&scene.transfer, scene.compositing, clip);
    points.extend(subject.mesh.iter().flat_map(|(mesh, _)| mesh.positions().iter().copied()));
    points
}

/// True if some value between the volume's smallest and largest one is seen in a step as long as its spacing.
fn shows(scene: &Scene) -> bool {
    /// Values that are tried.
    const VALUES: u32 = 1024;
    /// Light or opacity of what is seen: four steps of 8 bits.
    const FAINT: f64 = 4.0 / 255.0;
    let Some((low, high)) = scene.volume.value_range().filter(|_| scene.compositing.integrates_light()) else {
        return true;
    };
    let value = |i: u32| low + (high - low) * f64::from(i) / f64::from(VALUES);
    let length = scene.volume.mean_spacing();
    (0..=VALUES).any(|i| scene.transfer.step(value(i), length).iter().any(|&part| part > FAINT))
}

/// True if what two boxes have in common is most of either.
fn are_alike((a_low, a_high): (DVec3, DVec3), (b_low, b_high): (DVec3, DVec3)) -> bool {
    let common = (a_high.min(b_high) - a_low.max(b_low)).max(DVec3::ZERO);
    let share = |low: DVec3, high: DVec3| {
        // A side without length is all in common where it is in the same place.
        let sides = (0..3).map(|k| if high[k] > low[k] { common[k] / (high[k] - low[k]) } else { 1.0 });
        sides.product::<f64>()
    };
    share(a_low, a_high) >= ALIKE && share(b_low, b_high) >= ALIKE
}

/// True if a renderer of these options has settings by error.
fn has_qualities(options: &Options) -> bool {
    options.0.contains_key(QUALITY)
}

/// Leaves transfer function, shading and operator to a section, or to the volume.
fn look_anew(file: &mut SceneFile, transfer: Option<TransferSection>) {
    file.transfer = transfer;
    file.shading = None;
    file.render.compositing = CompositingName::Over;
    (file.render.threshold, file.render.level) = (None, None);
}

/// True if two files differ in more than the view and the renderer.
fn concerns_scene(a: &SceneFile, b: &SceneFile) -> bool {
    let operator = |file: &SceneFile| (file.render.compositing, file.render.threshold, file.render.level);
    a.transfer != b.transfer
        || a.shading != b.shading
        || a.image.background != b.image.background
        || operator(a) != operator(b)
}

/// The scene of a file around the subject's volume, without surfaces: these are there already.
fn resolved(subject: &Subject, file: &SceneFile) -> Result<LoadedScene, EditError> {
    let without_mesh = SceneFile { mesh: None, ..file.clone() };
    Ok(vr_io::resolve_scene_around(&without_mesh, &subject.path(), subject.volume.clone())?)
}

fn with_surfaces(subject: &Subject, mut scene: Scene) -> Scene {
    scene.surfaces = subject.mesh.clone().map(|(mesh, color)| {
        let surface = Surface::in_scene(mesh, color, &scene);
        Arc::new(surface) as Arc<dyn Surfaces>
    });
    scene
}

/// Says in words why the renderer of a name does not draw a document's scene; `None` if it does.
pub fn refusal(document: &Document, renderer: &dyn Renderer) -> Option<String> {
    let refused: Result<(), RenderError> = renderer.supports(document.scene(), Some(document.view()));
    refused.err().map(|e| e.to_string())
}
