//! Drawing of a session, on a thread of its own or step by step: from stage to stage, until an edit makes all of it stale.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use glam::DVec3;
use vr_core::clock::Instant;
use vr_core::{Control, Frame, Model, Prepared, RenderError, Renderer, Scene, View};
use vr_look::Survey;
use vr_physics::metrics::subgrid;
use vr_study::reference::ReferencePixels;

use super::describe::{Opened, State};
use super::document::{Change, Document};
use super::edit::Edit;
use super::error::{EditError, TruthError};
use super::error_map::ErrorMap;
use super::export::{Export, ExportError};
use super::pace::Pace;
use super::pick::Pick;
use super::picture::{COMPARED, ClientId, Head, Orientation, Picture, PictureError, Stage};
use super::ray_plot::RayPlot;
use super::second::{SecondPicture, Setting};
use super::slice::{Place, Slice, SliceQuery};
use super::subject::Subject;
use super::upsampled::rmse_upsampled;
use super::value_at::value_at;

/// Time without an edit after which the picture is at rest.
const REST: Duration = Duration::from_millis(100);

/// News from a session, for one client or for all.
#[derive(Clone)]
pub enum Output {
    /// A new picture.
    Picture(Arc<Picture>),
    /// The error of a picture that was given before.
    Error {
        /// Number of the picture.
        picture: u64,
        /// Its error, as it is known now.
        error: PictureError,
    },
    /// The scene after a change.
    State(Arc<State>),
    /// Another volume is shown: [`Session::opened`] describes it.
    Volume,
    /// The reason why there is no picture.
    Problem(String),
}

/// A scene that is looked at: edits in, pictures out.
pub struct Session {
    shared: Arc<Shared>,
    control: Control,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    state: Mutex<Desk>,
    wake: Condvar,
    tell: Box<dyn Fn(Output) + Send + Sync>,
    /// Tells, without a thread of its own, that the caller has an edit to make.
    interrupted: Option<Box<dyn Fn() -> bool + Send + Sync>>,
}

/// State that the thread and the callers share.
struct Desk {
    document: Document,
    /// Counts edits that change the picture.
    revision: u64,
    last_edit: Instant,
    answers: BTreeMap<ClientId, u64>,
    /// Cancel flag of the work that an edit makes stale.
    stale: Option<Arc<AtomicBool>>,
    /// Cancel flags of answers in the making, which an edit makes stale, too.
    asked: Vec<Arc<AtomicBool>>,
    /// Cancel flags of slices in the making, which moves and looks leave as they are.
    sliced: Vec<Arc<AtomicBool>>,
    /// Cancel flag of any work.
    working: Option<Arc<AtomicBool>>,
    ended: bool,
}

impl Shared {
    fn desk(&self) -> MutexGuard<'_, Desk> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Control of work that is given up as soon as the caller has an edit to make.
    fn control(self: &Arc<Self>) -> Control {
        let control = Control::default();
        if self.interrupted.is_none() {
            return control;
        }
        let (shared, flag) = (Arc::clone(self), control.cancel_flag());
        control.with_progress(move |_| {
            if shared.interrupted.as_ref().is_some_and(|interrupted| interrupted()) {
                flag.store(true, Ordering::Relaxed);
            }
        })
    }
}

impl Shared {
    fn new(
        document: Document,
        tell: impl Fn(Output) + Send + Sync + 'static,
        interrupted: Option<Box<dyn Fn() -> bool + Send + Sync>>,
    ) -> Self {
        let desk = Desk {
            document,
            revision: 1,
            last_edit: Instant::now(),
            answers: BTreeMap::new(),
            stale: None,
            asked: Vec::new(),
            sliced: Vec::new(),
            working: None,
            ended: false,
        };
        Self { state: Mutex::new(desk), wake: Condvar::new(), tell: Box::new(tell), interrupted }
    }
}

impl Desk {
    /// Cancels every answer in the making.
    fn give_up_answers(&mut self) {
        self.asked.drain(..).for_each(|flag| flag.store(true, Ordering::Relaxed));
    }

    /// Cancels every slice in the making.
    fn give_up_slices(&mut self) {
        self.sliced.drain(..).for_each(|flag| flag.store(true, Ordering::Relaxed));
    }
}

impl Session {
    /// Begins to draw a document on a control's threads; `tell` is called from any thread, and must not block.
    ///
    /// # Errors
    /// A thread that the system does not start.
    pub fn start(
        document: Document,
        control: &Control,
        tell: impl Fn(Output) + Send + Sync + 'static,
    ) -> std::io::Result<Self> {
        let shared = Arc::new(Shared::new(document, tell, None));
        let (theirs, pool) = (Arc::clone(&shared), control.clone());
        let thread =
            thread::Builder::new().name("session".to_owned()).spawn(move || Engine::new(theirs, pool).run())?;
        Ok(Self { shared, control: control.clone(), thread: Some(thread) })
    }

    /// Begins a session without a thread: the caller has the painter draw, step by step, and makes edits in between. `interrupted` is asked while a picture
    /// is drawn, often, and tells that there is an edit to make: all but a draft is then given up, and so is an answer.
    pub fn without_thread(
        document: Document,
        interrupted: impl Fn() -> bool + Send + Sync + 'static,
        tell: impl Fn(Output) + Send + Sync + 'static,
    ) -> (Self, Painter) {
        let shared = Arc::new(Shared::new(document, tell, Some(Box::new(interrupted))));
        let control = Control::default();
        let painter = Painter(Engine::new(Arc::clone(&shared), control.clone()));
        (Self { shared, control, thread: None }, painter)
    }

    /// Makes an edit of a client, who numbers its edits; the next picture says that it shows it.
    ///
    /// # Errors
    /// The reason why nothing was changed.
    pub fn apply(&self, client: ClientId, number: u64, edit: &Edit) -> Result<(), EditError> {
        if edit.needs_survey() {
            self.survey();
        }
        let mut desk = self.shared.desk();
        let outcome = desk.document.apply(edit);
        desk.answers.insert(client, number);
        let change = outcome?;
        // A move is told by the next picture.
        let tells =
            change > Change::View || matches!(edit, Edit::Crop { .. } | Edit::Planes { .. } | Edit::Undo | Edit::Redo);
        self.changed(desk, change, Some((client, number)), tells);
        Ok(())
    }

    /// Shows another volume in place of the one that is there, and keeps of its look what suits it; that can be undone. The volume before is kept in memory
    /// until a third one is opened.
    ///
    /// # Errors
    /// A scene that cannot be made, or that none of the renderers draws: nothing is changed.
    pub fn open(&self, subject: Subject) -> Result<(), EditError> {
        // Counting takes a while, and needs no lock.
        self.control.run(|| Survey::of(&subject.volume.volume));
        let mut desk = self.shared.desk();
        let change = desk.document.open(Arc::new(subject))?;
        self.changed(desk, change, None, true);
        Ok(())
    }

    /// Makes the survey that an edit asks for before the scene is locked, so that pictures and other edits go on meanwhile.
    fn survey(&self) {
        let volumes = {
            let desk = self.shared.desk();
            [desk.document.scene().volume.clone(), desk.document.values().clone()]
        };
        // A volume that keeps nothing would be surveyed again.
        for volume in volumes.iter().filter(|volume| volume.derived().is_some()) {
            self.control.run(|| Survey::of(volume));
        }
    }

    /// Cancels what a change makes stale, and tells of it.
    fn changed(&self, mut desk: MutexGuard<'_, Desk>, change: Change, by: Option<(ClientId, u64)>, tells: bool) {
        if change == Change::Nothing {
            return;
        }
        desk.revision += 1;
        desk.last_edit = Instant::now();
        if let Some(flag) = &desk.stale {
            flag.store(true, Ordering::Relaxed);
        }
        desk.give_up_answers();
        if change == Change::Volume {
            desk.give_up_slices();
            // A draft of the volume before is nothing to look at.
            if let Some(flag) = &desk.working {
                flag.store(true, Ordering::Relaxed);
            }
        }
        let state = tells.then(|| Arc::new(State::of(&desk.document, by)));
        drop(desk);
        self.shared.wake.notify_one();
        if change == Change::Volume {
            (self.shared.tell)(Output::Volume);
        }
        if let Some(state) = state {
            (self.shared.tell)(Output::State(state));
        }
    }

    /// Number of times that another volume was opened so far.
    pub fn volume_revision(&self) -> u64 {
        self.shared.desk().document.volume_revision()
    }

    /// Forgets the edits of a client that has gone.
    pub fn forget(&self, client: ClientId) {
        self.shared.desk().answers.remove(&client);
    }

    /// The scene as it is.
    pub fn state(&self) -> State {
        State::of(&self.shared.desk().document, None)
    }

    /// Describes the scene as it was opened: all that edits do not change.
    pub fn opened(&self) -> Opened {
        // Counting voxels takes a while, and needs no lock.
        let (subject, scene, revision) = {
            let desk = self.shared.desk();
            let d = &desk.document;
            (Arc::clone(d.subject()), d.scene().clone(), d.volume_revision())
        };
        self.control.run(|| Opened::of(&subject, &scene, revision))
    }

    /// Makes a file of the scene as it is, or of its picture at rest.
    ///
    /// # Errors
    /// A picture that cannot be drawn, or a format that does not hold it.
    pub fn export(&self, export: Export) -> Result<Vec<u8>, ExportError> {
        let (file, title, scene, view, stages) = {
            let desk = self.shared.desk();
            let d = &desk.document;
            (d.file(), d.subject().title.clone(), d.scene().clone(), d.view().clone(), d.stages()?)
        };
        let renderer = stages.proven.map_or(stages.sharp, |(renderer, _)| renderer);
        self.control.run(|| export.make(&file, &title, (&scene, &view), &*renderer))
    }

    /// Compares the picture at rest with the reference on a grid of its pixels. The next edit, and the end of the session, cancel it.
    ///
    /// # Errors
    /// A picture that cannot be drawn, a scene that has no reference, or [`RenderError::Cancelled`].
    pub fn error_map(&self) -> Result<ErrorMap, TruthError> {
        self.at_rest(best, |around, renderer, control| ErrorMap::of(around, &*renderer, control))
    }

    /// Follows the ray through the centre of a pixel of the picture at rest, and the reference along it. The next edit, and the end of the
    /// session, cancel it.
    ///
    /// # Errors
    /// A pixel that the picture does not have, a picture that cannot be drawn, a scene that has no reference, or [`RenderError::Cancelled`].
    pub fn ray(&self, pixel: [u32; 2]) -> Result<RayPlot, TruthError> {
        self.at_rest(best, |around, renderer, control| RayPlot::of(around, pixel, &*renderer, control))
    }

    /// The same by a second setting, as [`Self::second`] draws it.
    ///
    /// # Errors
    /// Those of [`Self::ray`]; a setting that no renderer has.
    pub fn ray_of(&self, pixel: [u32; 2], setting: &Setting) -> Result<RayPlot, TruthError> {
        self.at_rest(
            |document| document.second(setting).map(|(renderer, _)| renderer),
            |around, renderer, control| RayPlot::of(around, pixel, &*renderer, control),
        )
    }

    /// Finds what is seen at a place in the picture: `None` where nothing is. On the caller's thread: it waits for none of the pictures.
    ///
    /// # Errors
    /// A place that is not finite, or a view without rays.
    pub fn pick(&self, place: [f64; 2]) -> Result<Option<Pick>, TruthError> {
        let (scene, values, view) = {
            let desk = self.shared.desk();
            let d = &desk.document;
            (d.scene().clone(), d.values().clone(), d.view().clone())
        };
        Ok(Pick::of((&scene, &values), &view, place).map_err(RenderError::from)?)
    }

    /// Draws scene and view by a second setting, and measures its error as that of the first picture. The next edit, and the end of the
    /// session, cancel it.
    ///
    /// # Errors
    /// A setting that no renderer has, a scene that it does not draw, or [`RenderError::Cancelled`].
    pub fn second(&self, setting: &Setting) -> Result<SecondPicture, TruthError> {
        self.at_rest(
            |document| document.second(setting),
            |around, (renderer, bound), control| SecondPicture::of(around, (&*renderer, bound), control),
        )
    }

    /// Samples the scene's volume on a plane, on the caller's thread: it waits for none of the pictures. The control's flag cancels it, and so does the end
    /// of the session.
    ///
    /// # Errors
    /// A slice that makes no sense, labels that cannot be read, or [`RenderError::Cancelled`].
    pub fn slice(&self, query: &SliceQuery, control: &Control) -> Result<Slice, TruthError> {
        let flag = control.cancel_flag();
        let (subject, volume) = {
            let mut desk = self.shared.desk();
            if desk.ended {
                return Err(RenderError::Cancelled.into());
            }
            desk.sliced.push(Arc::clone(&flag));
            (Arc::clone(desk.document.subject()), desk.document.values().clone())
        };
        let made = control.cancellable(|| {
            let labels = subject.label_looks()?;
            Ok(Slice::of(&volume, labels, subject.is_patient(), query, control)?)
        });
        self.shared.desk().sliced.retain(|sliced| !Arc::ptr_eq(sliced, &flag));
        made.unwrap_or_else(|stopped| Err(RenderError::from(stopped).into()))
    }

    /// The value, and the label, at a world position.
    ///
    /// # Errors
    /// Labels that cannot be read.
    pub fn place(&self, at: DVec3) -> Result<Place, TruthError> {
        let (subject, volume) = {
            let desk = self.shared.desk();
            (Arc::clone(desk.document.subject()), desk.document.values().clone())
        };
        let label = subject.label_looks()?.and_then(|looks| looks.at(at)).cloned();
        Ok(Place { at, value: value_at(&volume, at), label })
    }

    /// Asks a question of the scene, the view and a renderer of the document, which the next edit cancels.
    fn at_rest<R: Send, T: Send>(
        &self,
        choose: impl FnOnce(&Document) -> Result<R, EditError>,
        question: impl FnOnce((&Scene, &View), R, &Control) -> Result<T, RenderError> + Send,
    ) -> Result<T, TruthError> {
        let control = self.shared.control();
        let flag = control.cancel_flag();
        let (scene, view, chosen) = {
            let mut desk = self.shared.desk();
            if desk.ended {
                return Err(RenderError::Cancelled.into());
            }
            desk.asked.push(Arc::clone(&flag));
            let d = &desk.document;
            (d.scene().clone(), d.view().clone(), choose(d))
        };
        let found = chosen.map_err(TruthError::from).and_then(|renderer| {
            let ask = || question((&scene, &view), renderer, &control);
            let found = self.control.run(|| control.cancellable(ask));
            Ok(found.unwrap_or_else(|stopped| Err(stopped.into()))?)
        });
        self.shared.desk().asked.retain(|asked| !Arc::ptr_eq(asked, &flag));
        found
    }

    /// Ends the work in progress, and the thread.
    pub fn end(&self) {
        let mut desk = self.shared.desk();
        desk.ended = true;
        desk.give_up_answers();
        desk.give_up_slices();
        if let Some(flag) = &desk.working {
            flag.store(true, Ordering::Relaxed);
        }
        drop(desk);
        self.shared.wake.notify_one();
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.end();
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has said so.
            let _ = thread.join();
        }
    }
}

/// The renderer of a document's picture at rest.
fn best(document: &Document) -> Result<Box<dyn Renderer>, EditError> {
    let stages = document.stages()?;
    Ok(stages.proven.map_or(stages.sharp, |(renderer, _)| renderer))
}

/// Work of the thread: one stage of one revision.
struct Job {
    revision: u64,
    stage: Stage,
    scene: Scene,
    scene_revision: u64,
    view: View,
    renderer: Option<Box<dyn Renderer>>,
    /// Size of the picture at rest.
    full_size: [u32; 2],
    /// Bound that is asked for.
    bound: Option<f64>,
    /// Identity of renderer and options.
    setting: String,
    answers: BTreeMap<ClientId, u64>,
    control: Control,
}

/// A renderer that has seen the scene, kept from picture to picture.
struct Slot {
    setting: String,
    scene_revision: u64,
    prepared: Box<dyn Prepared>,
}

/// Progress of the last revision that was drawn at all.
struct Progress {
    revision: u64,
    /// The stage that is done, and the size of its picture; `None` where drawing has failed, so that nothing further is tried.
    stage: Option<(Stage, [u32; 2])>,
}

/// What the engine is to do next.
enum Turn {
    Work(Box<Job>),
    /// Nothing before so much time has passed.
    Wait(Duration),
    /// Nothing before the next edit.
    Idle,
    End,
}

/// Draws the pictures of a session that has no thread.
pub struct Painter(Engine);

/// Outcome of a step of a [`Painter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// A stage was drawn, or given up for an edit: there may be another one.
    Worked,
    /// The next stage is drawn when no edit has come for so much longer.
    Wait(Duration),
    /// Nothing is left to do before the next edit.
    Idle,
}

impl Painter {
    /// Draws one stage, if one is due.
    pub fn step(&mut self) -> Step {
        let shared = Arc::clone(&self.0.shared);
        let turn = self.0.turn(&mut shared.desk());
        match turn {
            Turn::Work(job) => {
                self.0.do_job(&job);
                Step::Worked
            }
            Turn::Wait(time) => Step::Wait(time),
            Turn::Idle | Turn::End => Step::Idle,
        }
    }
}

struct Engine {
    shared: Arc<Shared>,
    pool: Control,
    pace: Pace,
    slots: [Option<Slot>; 3],
    progress: Option<Progress>,
    pictures: u64,
    /// The coarse pictures of a revision.
    coarse: (u64, Vec<Frame>),
    /// The last picture of all pixels, its revision and its number.
    sharp: Option<(u64, u64, Frame)>,
    /// Reference pixels of a revision.
    reference: Option<(u64, ReferencePixels)>,
    /// RMSE of the last coarse pictures against a sharp one, by the logarithm of the pixels that each of theirs covers.
    coarse_rmse: BTreeMap<i32, f64>,
    /// RMSE of the last sharp picture against the reference.
    sharp_rmse: Option<f64>,
}

impl Engine {
    fn new(shared: Arc<Shared>, pool: Control) -> Self {
        Self {
            shared,
            pool,
            pace: Pace::default(),
            slots: [None, None, None],
            progress: None,
            pictures: 0,
            coarse: (0, Vec::new()),
            sharp: None,
            reference: None,
            coarse_rmse: BTreeMap::new(),
            sharp_rmse: None,
        }
    }

    fn run(mut self) {
        while let Some(job) = self.next() {
            self.do_job(&job);
        }
    }

    fn do_job(&mut self, job: &Job) {
        // The job has a cancel flag of its own, and runs on the session's threads.
        let (pool, engine) = (self.pool.clone(), &mut *self);
        let outcome = pool.run(move || job.control.cancellable(|| engine.work(job)));
        let outcome = outcome.unwrap_or_else(|stopped| Err(RenderError::from(stopped)));
        let mut desk = self.shared.desk();
        (desk.stale, desk.working) = (None, None);
        let is_stale = desk.revision != job.revision || desk.ended;
        drop(desk);
        match outcome {
            Ok(()) => {
                self.progress = Some(Progress { revision: job.revision, stage: Some((job.stage, job.view.size)) });
            }
            // The edit that has interrupted it is yet to be made.
            Err(RenderError::Cancelled) if is_stale || self.shared.interrupted.is_some() => {}
            Err(e) => {
                self.progress = Some(Progress { revision: job.revision, stage: None });
                (self.shared.tell)(Output::Problem(e.to_string()));
            }
        }
    }

    /// Waits for work; `None` at the end.
    fn next(&mut self) -> Option<Job> {
        let shared = Arc::clone(&self.shared);
        let mut desk = shared.desk();
        loop {
            desk = match self.turn(&mut desk) {
                Turn::Work(job) => return Some(*job),
                Turn::Wait(time) => shared.wake.wait_timeout(desk, time).unwrap_or_else(PoisonError::into_inner).0,
                Turn::Idle => shared.wake.wait(desk).unwrap_or_else(PoisonError::into_inner),
                Turn::End => return None,
            };
        }
    }

    /// Finds out what is to be done.
    fn turn(&mut self, desk: &mut Desk) -> Turn {
        loop {
            if desk.ended {
                return Turn::End;
            }
            let drawn = self.progress.as_ref().filter(|progress| progress.revision == desk.revision);
            let has_proof = desk.document.max_error().is_some();
            let full = desk.document.view().size;
            let next = match drawn.map(|progress| progress.stage) {
                None => Some((Stage::Draft, self.pace.size(full))),
                Some(None) => None,
                Some(Some((Stage::Draft | Stage::Finer, size))) => {
                    Some(finer(size, full).map_or((Stage::Sharp, full), |size| (Stage::Finer, size)))
                }
                Some(Some((Stage::Sharp, size))) => Some((Stage::Measured, size)),
                Some(Some((Stage::Measured, size))) => has_proof.then_some((Stage::Proven, size)),
                Some(Some((Stage::Proven, _))) => None,
            };
            let Some(next) = next else { return Turn::Idle };
            let moved = desk.last_edit.elapsed();
            if next.0 != Stage::Draft && moved < REST {
                return Turn::Wait(REST - moved);
            }
            match job(desk, next, &self.shared) {
                Ok(job) => return Turn::Work(Box::new(job)),
                Err(e) => {
                    self.progress = Some(Progress { revision: desk.revision, stage: None });
                    (self.shared.tell)(Output::Problem(e.to_string()));
                }
            }
        }
    }

    fn work(&mut self, job: &Job) -> Result<(), RenderError> {
        match &job.renderer {
            Some(renderer) => self.draw(job, &**renderer, &job.control),
            None => self.measure(job, &job.control),
        }
    }

    /// Draws a picture, and tells of it.
    fn draw(&mut self, job: &Job, renderer: &dyn Renderer, control: &Control) -> Result<(), RenderError> {
        let slot = match job.stage {
            Stage::Draft | Stage::Finer => 0,
            Stage::Sharp | Stage::Measured => 1,
            Stage::Proven => 2,
        };
        // Prepare what the last picture has not prepared. What is cancelled half-way is made anew.
        let start = Instant::now();
        let prepared = match self.slots[slot].take().filter(|slot| slot.setting == job.setting) {
            Some(mut kept) => {
                if kept.scene_revision != job.scene_revision {
                    kept.prepared.update(&job.scene, control)?;
                }
                kept.prepared
            }
            None => renderer.prepare(&job.scene, control)?,
        };
        let prepare = start.elapsed();
        let kept = Slot { setting: job.setting.clone(), scene_revision: job.scene_revision, prepared };
        let prepared = &mut self.slots[slot].insert(kept).prepared;
        // Draw.
        let start = Instant::now();
        let rendered = prepared.render(&job.view, control)?;
        let time = start.elapsed();
        let rgba = vr_io::screen_rgba(&rendered.frame, job.scene.background);
        let [w, h] = job.view.size.map(u64::from);
        // Tell of it.
        let known = |rmse: Option<f64>| rmse.map_or(PictureError::Unknown, |rmse| PictureError::Estimated { rmse });
        let (error, full_size) = match job.stage {
            Stage::Draft | Stage::Finer => {
                if job.stage == Stage::Draft {
                    self.pace.measured(w * h, start.elapsed());
                }
                // A coarser one is hardly nearer to the truth.
                let as_coarse = self.coarse_rmse.range(coarseness(job.view.size, job.full_size)..).next();
                (known(as_coarse.map(|(_, rmse)| rmse.hypot(self.sharp_rmse.unwrap_or(0.0)))), job.full_size)
            }
            Stage::Proven => {
                let reference = self.reference.as_ref().filter(|(revision, _)| *revision == job.revision);
                let bound = job.bound.unwrap_or(f64::INFINITY);
                (PictureError::under_bound(bound, &rendered, reference.map(|(_, pixels)| pixels)), job.view.size)
            }
            _ => (known(self.sharp_rmse), job.view.size),
        };
        self.pictures += 1;
        let head = Head {
            picture: self.pictures,
            size: job.view.size,
            full_size,
            stage: job.stage,
            renderer: renderer.name().to_owned(),
            milliseconds: 1e3 * time.as_secs_f64(),
            prepare_milliseconds: 1e3 * prepare.as_secs_f64(),
            error,
            camera: Orientation::of(&job.view),
        };
        (self.shared.tell)(Output::Picture(Arc::new(Picture { head, rgba, answers: job.answers.clone() })));
        // Keep what the next stage compares with it.
        let frame = rendered.frame;
        match job.stage {
            Stage::Draft => self.coarse = (job.revision, vec![frame]),
            Stage::Finer if self.coarse.0 == job.revision => self.coarse.1.push(frame),
            Stage::Sharp => {
                for coarse in self.coarse.1.drain(..).filter(|_| self.coarse.0 == job.revision) {
                    self.coarse_rmse.insert(coarseness(coarse.size(), job.full_size), rmse_upsampled(&coarse, &frame));
                }
                self.sharp = Some((job.revision, self.pictures, frame));
            }
            _ => {}
        }
        Ok(())
    }

    /// Compares the sharp picture with the reference.
    fn measure(&mut self, job: &Job, control: &Control) -> Result<(), RenderError> {
        let Some((revision, picture, frame)) = &self.sharp else { return Ok(()) };
        if *revision != job.revision {
            return Ok(());
        }
        let pixels = subgrid(COMPARED, job.view.size);
        let reference = match ReferencePixels::solve((&job.scene, &job.view), &Model::Canonical, pixels, control) {
            // No reference is no reason to draw nothing.
            Err(RenderError::Unsupported(_)) => return Ok(()),
            solved => solved?,
        };
        (self.shared.tell)(Output::Error { picture: *picture, error: PictureError::measured(&reference, frame) });
        self.sharp_rmse = Some(reference.judge(frame).rmse);
        self.reference = Some((job.revision, reference));
        Ok(())
    }
}

/// Twice as many pixels on each side, where that is well below all of them: what comes in between costs a third of the whole picture at most.
fn finer(size: [u32; 2], full: [u32; 2]) -> Option<[u32; 2]> {
    let twice = size.map(|n| 2 * n);
    (4 * twice[0] <= 3 * full[0] && 4 * twice[1] <= 3 * full[1]).then_some(twice)
}

/// Logarithm of the pixels of a picture at rest that a pixel of a coarse one covers, along a side.
fn coarseness(size: [u32; 2], full: [u32; 2]) -> i32 {
    f64::log2(f64::from(full[1]) / f64::from(size[1])).round() as i32
}

/// The work of a stage on a picture of a size.
fn job(desk: &mut Desk, (stage, size): (Stage, [u32; 2]), shared: &Arc<Shared>) -> Result<Job, EditError> {
    let document = &desk.document;
    let mut view = View { size, ..document.view().clone() };
    let mut bound = None;
    let renderer = match stage {
        Stage::Draft | Stage::Finer => {
            view.supersampling = 1;
            Some(document.stages()?.draft)
        }
        Stage::Sharp => Some(document.stages()?.sharp),
        Stage::Measured => None,
        Stage::Proven => document.stages()?.proven.map(|(renderer, error)| {
            bound = Some(error);
            renderer
        }),
    };
    let file = document.file();
    let control = if stage > Stage::Draft { shared.control() } else { Control::default() };
    let cancel = control.cancel_flag();
    // A draft is soon done, and is something to look at; what comes after it is stale with the next edit.
    desk.stale = (stage > Stage::Draft).then(|| Arc::clone(&cancel));
    desk.working = Some(cancel);
    Ok(Job {
        revision: desk.revision,
        stage,
        scene: document.scene().clone(),
        scene_revision: document.scene_revision(),
        view,
        renderer,
        full_size: document.view().size,
        bound,
        setting: format!(
            "{} {} {:?} {bound:?}",
            document.volume_revision(),
            document.renderer_name(),
            file.render.options
        ),
        answers: desk.answers.clone(),
        control,
    })
}
