//! Engine of a session, which draws: from stage to stage, until an edit makes all of it stale.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use vr_core::clock::Instant;
use vr_core::{Control, Frame, Prepared, RenderError, Renderer, Scene, View};
use vr_study::reference::ReferencePixels;

use super::desk::{Desk, Shared};
use super::document::Document;
use super::error::EditError;
use super::moving::{Choice, Moving, QUICK, Trial, WHOLE};
use super::output::Output;
use super::pace::sized;
use super::picture::{ClientId, Head, Orientation, Picture, PictureError, Stage, compared};
use super::upsampled::rmse_upsampled;

/// Time without an edit after which the picture is at rest.
const REST: Duration = Duration::from_millis(100);

/// Longest time of a quick picture of full size that is drawn without coarser ones before it.
const SOON: Duration = Duration::from_millis(400);

/// Pixels of the pictures that settings are tried with.
const TRIED: [f64; 2] = [128.0 * 128.0, 256.0 * 256.0];
/// Time of a trial's smaller picture beyond which the larger one is not drawn.
const LONG: Duration = Duration::from_millis(250);

/// Work of the engine: one stage of one revision.
pub(super) struct Job {
    revision: u64,
    stage: Stage,
    task: Task,
    scene: Scene,
    scene_revision: u64,
    view: View,
    /// Size of the picture at rest.
    full_size: [u32; 2],
    /// Bound that is asked for.
    bound: Option<f64>,
    /// RMSE estimated by trials.
    rmse: Option<f64>,
    answers: BTreeMap<ClientId, u64>,
    control: Control,
}

/// Settings for quick pictures, and their numbers.
type Settings = Vec<(usize, Box<dyn Renderer>)>;

/// Work of a job.
enum Task {
    /// Draws by a renderer, whose prepared state is kept in a slot.
    Draw(Box<dyn Renderer>, SlotName),
    /// Tries settings for moving pictures; the trials have this key.
    Try(Settings, String),
    /// Compares the sharp picture with the reference.
    Measure,
}

/// Name of a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum SlotName {
    /// A setting for quick pictures, by its number.
    Quick(usize),
    Sharp,
    Proven,
}

/// Next step of a revision.
enum Next {
    Draft,
    Finer([u32; 2]),
    Sharp,
    Try,
    Measure,
    Prove,
}

/// A renderer that has seen the scene, kept from picture to picture.
struct Slot {
    bound: Option<f64>,
    scene_revision: u64,
    prepared: Box<dyn Prepared>,
}

/// Progress of the last revision that was drawn at all.
struct Progress {
    revision: u64,
    /// The stage that is done, and the size of its picture; `None` where drawing has failed, so that nothing further is tried.
    stage: Option<(Stage, [u32; 2])>,
}

/// Work that is due, or the time until some is.
pub(super) enum Due {
    Work(Box<Job>),
    /// Nothing before so much time has passed.
    Wait(Duration),
    /// Nothing before the next edit.
    Idle,
    End,
}

/// Draws the pictures of a session.
pub(super) struct Engine {
    pub(super) shared: Arc<Shared>,
    pool: Control,
    moving: Moving,
    /// Identity of the volume, renderer and options that trials, slots and `whole_cost` belong to.
    setting: String,
    slots: BTreeMap<SlotName, Slot>,
    /// Seconds a pixel of the last quick picture of full size.
    whole_cost: Option<f64>,
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
    pub(super) fn new(shared: Arc<Shared>, pool: Control) -> Self {
        Self {
            shared,
            pool,
            moving: Moving::default(),
            setting: String::new(),
            slots: BTreeMap::new(),
            whole_cost: None,
            progress: None,
            pictures: 0,
            coarse: (0, Vec::new()),
            sharp: None,
            reference: None,
            coarse_rmse: BTreeMap::new(),
            sharp_rmse: None,
        }
    }

    pub(super) fn run(mut self) {
        while let Some(job) = self.next() {
            self.do_job(&job);
        }
    }

    pub(super) fn do_job(&mut self, job: &Job) {
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
            desk = match self.due(&mut desk) {
                Due::Work(job) => return Some(*job),
                Due::Wait(time) => shared.wake.wait_timeout(desk, time).unwrap_or_else(PoisonError::into_inner).0,
                Due::Idle => shared.wake.wait(desk).unwrap_or_else(PoisonError::into_inner),
                Due::End => return None,
            };
        }
    }

    /// Finds out what is to be done.
    pub(super) fn due(&mut self, desk: &mut Desk) -> Due {
        loop {
            if desk.ended {
                return Due::End;
            }
            let setting = setting_of(&desk.document);
            if self.setting != setting {
                self.setting = setting;
                self.moving.forget();
                self.slots.clear();
                self.whole_cost = None;
            }
            let drawn = self.progress.as_ref().filter(|progress| progress.revision == desk.revision);
            let next = match drawn.map(|progress| progress.stage) {
                None => Next::Draft,
                Some(None) => return Due::Idle,
                Some(Some((Stage::Draft | Stage::Finer, size))) => self.refined(&desk.document, size),
                Some(Some((Stage::Sharp, _))) if self.moving.is_untried(&self.trials_key(&desk.document)) => Next::Try,
                Some(Some((Stage::Sharp, _))) => Next::Measure,
                Some(Some((Stage::Measured, _))) if desk.document.max_error().is_some() => Next::Prove,
                Some(Some((Stage::Measured | Stage::Proven, _))) => return Due::Idle,
            };
            let moved = desk.last_edit.elapsed();
            if !matches!(next, Next::Draft) && moved < REST {
                return Due::Wait(REST - moved);
            }
            match self.job(desk, next) {
                Ok(job) => return Due::Work(Box::new(job)),
                Err(e) => {
                    self.progress = Some(Progress { revision: desk.revision, stage: None });
                    (self.shared.tell)(Output::Problem(e.to_string()));
                }
            }
        }
    }

    /// Returns the step at rest that follows a moving or coarse picture of a size.
    fn refined(&self, document: &Document, size: [u32; 2]) -> Next {
        let full = document.view().size;
        let whole = size == full;
        if whole || !has_quick(document, WHOLE) {
            return finer(size, full).filter(|_| !whole).map_or(Next::Sharp, Next::Finer);
        }
        // All pixels at once, where that is soon done or not known.
        let pixels = full.map(f64::from).iter().product::<f64>();
        let soon = self.whole_cost.is_none_or(|cost| cost * pixels < SOON.as_secs_f64());
        Next::Finer(finer(size, full).filter(|_| !soon).unwrap_or(full))
    }

    /// Returns the key of the trials of a renderer, scene and size.
    fn trials_key(&self, document: &Document) -> String {
        format!("{} {} {:?}", self.setting, document.scene_revision(), document.view().size)
    }

    /// Makes the job of a step.
    fn job(&mut self, desk: &mut Desk, next: Next) -> Result<Job, EditError> {
        let document = &desk.document;
        let full = document.view().size;
        let scene_revision = document.scene_revision();
        let mut view = document.view().clone();
        let (mut bound, mut rmse) = (None, None);
        let (stage, task) = match next {
            Next::Draft => {
                let slots = &self.slots;
                let renews = |setting| !has_seen(slots, SlotName::Quick(setting), scene_revision);
                let choice = self.moving.choose(full, |setting| has_quick(document, setting), renews);
                let Choice { setting, size, .. } = choice;
                (view.size, view.supersampling, rmse) = (size, 1, choice.rmse);
                (Stage::Draft, quick(document, setting)?)
            }
            Next::Finer(size) => {
                (view.size, view.supersampling) = (size, 1);
                (Stage::Finer, quick(document, WHOLE)?)
            }
            Next::Sharp => (Stage::Sharp, Task::Draw(document.stages()?.sharp, SlotName::Sharp)),
            Next::Try => {
                let all = (0..=QUICK.len()).filter_map(|setting| Some((setting, document.quick(setting).ok()??)));
                let mut all: Settings = all.collect();
                if all.len() == 1 {
                    // There is no choice.
                    all.clear();
                }
                (Stage::Sharp, Task::Try(all, self.trials_key(document)))
            }
            Next::Measure => (Stage::Measured, Task::Measure),
            Next::Prove => match document.stages()?.proven {
                Some((renderer, error)) => {
                    bound = Some(error);
                    (Stage::Proven, Task::Draw(renderer, SlotName::Proven))
                }
                None => (Stage::Measured, Task::Measure),
            },
        };
        let control = if stage > Stage::Draft { self.shared.control() } else { Control::default() };
        let cancel = control.cancel_flag();
        let scene = document.scene().clone();
        // A draft is soon done, and is something to look at; what comes after it is stale with the next edit.
        desk.stale = (stage > Stage::Draft).then(|| Arc::clone(&cancel));
        desk.working = Some(cancel);
        Ok(Job {
            revision: desk.revision,
            stage,
            task,
            scene,
            scene_revision,
            view,
            full_size: full,
            bound,
            rmse,
            answers: desk.answers.clone(),
            control,
        })
    }

    fn work(&mut self, job: &Job) -> Result<(), RenderError> {
        match &job.task {
            Task::Draw(renderer, slot) => self.draw(job, (&**renderer, *slot), &job.control),
            Task::Try(settings, key) => self.try_settings(job, (settings, key), &job.control),
            Task::Measure => self.measure(job, &job.control),
        }
    }

    /// Takes a renderer out of its slot and updates it to the job's scene, or prepares it. One that is cancelled half-way is lost, and prepared anew the next time.
    fn prepared(
        &mut self,
        job: &Job,
        (renderer, slot): (&dyn Renderer, SlotName),
        control: &Control,
    ) -> Result<Slot, RenderError> {
        let bound = job.bound;
        let prepared = match self.slots.remove(&slot).filter(|slot| slot.bound == bound) {
            Some(mut kept) => {
                if kept.scene_revision != job.scene_revision {
                    kept.prepared.update(&job.scene, control)?;
                }
                kept.prepared
            }
            None => renderer.prepare(&job.scene, control)?,
        };
        Ok(Slot { bound, scene_revision: job.scene_revision, prepared })
    }

    /// Draws a picture, and tells of it.
    fn draw(
        &mut self,
        job: &Job,
        (renderer, slot): (&dyn Renderer, SlotName),
        control: &Control,
    ) -> Result<(), RenderError> {
        let start = Instant::now();
        let is_known = has_seen(&self.slots, slot, job.scene_revision);
        let kept = self.prepared(job, (renderer, slot), control)?;
        let prepare = start.elapsed();
        let prepared = &mut self.slots.entry(slot).or_insert(kept).prepared;
        // Draw.
        let start = Instant::now();
        let rendered = prepared.render(&job.view, control)?;
        let time = start.elapsed();
        let rgba = vr_io::screen_rgba(&rendered.frame, job.scene.background);
        let pixels = job.view.size.map(u64::from).iter().product::<u64>();
        // Tell of it.
        let known = |rmse: Option<f64>| rmse.map_or(PictureError::Unknown, |rmse| PictureError::Estimated { rmse });
        let (error, full_size) = match job.stage {
            Stage::Draft | Stage::Finer => {
                if job.stage == Stage::Draft {
                    let renewal = (!is_known).then_some(prepare.as_secs_f64());
                    self.moving.measured(pixels, start.elapsed().as_secs_f64(), renewal);
                } else if job.view.size == job.full_size {
                    self.whole_cost = Some((prepare + start.elapsed()).as_secs_f64() / pixels as f64);
                }
                // A coarser one is hardly nearer to the truth.
                let as_coarse = self.coarse_rmse.range(coarseness(job.view.size, job.full_size)..).next();
                let rmse = job.rmse.or(as_coarse.map(|(_, rmse)| *rmse));
                (known(rmse.map(|rmse| rmse.hypot(self.sharp_rmse.unwrap_or(0.0)))), job.full_size)
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

    /// Tries settings for moving pictures on the view at rest: their times, and their distances from the sharp picture.
    fn try_settings(
        &mut self,
        job: &Job,
        (settings, key): (&Settings, &str),
        control: &Control,
    ) -> Result<(), RenderError> {
        let Some((revision, number, sharp)) = self.sharp.take().filter(|(revision, ..)| *revision == job.revision)
        else {
            self.moving.tried(key.to_owned(), Vec::new());
            return Ok(());
        };
        let mut trials = Vec::new();
        let outcome = settings.iter().try_for_each(|(setting, renderer)| {
            match self.trial(job, (*setting, &**renderer), &sharp, control) {
                Ok(trial) => trials.extend(trial.map(|trial| (*setting, trial))),
                Err(RenderError::Cancelled) => return Err(RenderError::Cancelled),
                // A setting that cannot draw the scene is left out.
                Err(_) => {}
            }
            Ok(())
        });
        self.sharp = Some((revision, number, sharp));
        outcome?;
        self.moving.tried(key.to_owned(), trials);
        Ok(())
    }

    /// Tries one setting; `None` if the picture is too small for two sizes.
    fn trial(
        &mut self,
        job: &Job,
        (setting, renderer): (usize, &dyn Renderer),
        sharp: &Frame,
        control: &Control,
    ) -> Result<Option<Trial>, RenderError> {
        let all = job.full_size.map(f64::from).iter().product::<f64>();
        let [small, large] = [TRIED[0].min(all / 16.0), TRIED[1].min(all / 4.0)].map(|n| sized(n, job.full_size));
        let pixels = [small, large].map(|size| size.map(f64::from).iter().product::<f64>());
        if pixels[0] >= pixels[1] {
            return Ok(None);
        }
        let name = SlotName::Quick(setting);
        let is_known = has_seen(&self.slots, name, job.scene_revision);
        let start = Instant::now();
        let kept = self.prepared(job, (renderer, name), control)?;
        let prepared = &mut self.slots.entry(name).or_insert(kept).prepared;
        let mut drawn = |size| {
            let start = Instant::now();
            let frame = prepared.render(&View { size, supersampling: 1, ..job.view.clone() }, control)?.frame;
            Ok::<_, RenderError>((start.elapsed(), frame))
        };
        // The first picture may prepare what depends on the view.
        drawn(small)?;
        let first = start.elapsed();
        let (quick, coarse) = drawn(small)?;
        let rmse = rmse_upsampled(&coarse, sharp);
        let known = self.moving.trial(setting).filter(|_| is_known);
        let renewal = known.map_or_else(|| first.saturating_sub(quick).as_secs_f64(), |trial| trial.renewal);
        let quick_seconds = quick.as_secs_f64();
        let (seconds, rmse) = if quick > LONG {
            ([quick_seconds, quick_seconds * pixels[1] / pixels[0]], [rmse; 2])
        } else {
            let (time, fine) = drawn(large)?;
            ([quick_seconds, time.as_secs_f64()], [rmse, rmse_upsampled(&fine, sharp)])
        };
        Ok(Some(Trial { pixels, seconds, rmse, renewal }))
    }

    /// Compares the sharp picture with the reference.
    fn measure(&mut self, job: &Job, control: &Control) -> Result<(), RenderError> {
        let Some((revision, picture, frame)) = &self.sharp else { return Ok(()) };
        if *revision != job.revision {
            return Ok(());
        }
        let Some(reference) = compared((&job.scene, &job.view), control)? else { return Ok(()) };
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

/// Identity of volume, renderer and options.
fn setting_of(document: &Document) -> String {
    let options = &document.file_render().options;
    format!("{} {} {options:?}", document.volume_revision(), document.renderer_name())
}

/// True if a slot has a renderer that has seen a revision of the scene.
fn has_seen(slots: &BTreeMap<SlotName, Slot>, name: SlotName, scene_revision: u64) -> bool {
    slots.get(&name).is_some_and(|slot| slot.scene_revision == scene_revision)
}

/// True if a quick setting draws a document's scene.
fn has_quick(document: &Document, setting: usize) -> bool {
    document.quick(setting).is_ok_and(|renderer| renderer.is_some())
}

/// Returns the task of drawing by a quick setting, or by the renderer's own draft if that does not draw the scene.
fn quick(document: &Document, setting: usize) -> Result<Task, EditError> {
    Ok(match document.quick(setting)? {
        Some(renderer) => Task::Draw(renderer, SlotName::Quick(setting)),
        None => Task::Draw(document.stages()?.draft, SlotName::Quick(0)),
    })
}
