//! Engine of a session, which draws: from stage to stage, until an edit makes all of it stale.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use vr_core::clock::Instant;
use vr_core::{Control, Frame, Model, Prepared, RenderError, Renderer, Scene, View};
use vr_physics::metrics::subgrid;
use vr_study::reference::ReferencePixels;

use super::desk::{Desk, Shared};
use super::error::EditError;
use super::output::Output;
use super::pace::Pace;
use super::picture::{COMPARED, ClientId, Head, Orientation, Picture, PictureError, Stage};
use super::upsampled::rmse_upsampled;

/// Time without an edit after which the picture is at rest.
const REST: Duration = Duration::from_millis(100);

/// Work of the engine: one stage of one revision.
pub(super) struct Job {
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
    pub(super) fn new(shared: Arc<Shared>, pool: Control) -> Self {
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
            let Some(next) = next else { return Due::Idle };
            let moved = desk.last_edit.elapsed();
            if next.0 != Stage::Draft && moved < REST {
                return Due::Wait(REST - moved);
            }
            match job(desk, next, &self.shared) {
                Ok(job) => return Due::Work(Box::new(job)),
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
