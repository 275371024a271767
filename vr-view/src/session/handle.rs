//! Handle of a session: what its callers do with it. Edits change the scene; questions are answered beside the pictures.

use std::sync::atomic::Ordering;
use std::sync::{Arc, MutexGuard};
use std::thread::{self, JoinHandle};

use glam::DVec3;
use vr_core::clock::Instant;
use vr_core::{Control, RenderError, Renderer, Scene, View, Volume};
use vr_io::LabelsSection;
use vr_look::Survey;

use super::describe::{Opened, State};
use super::desk::{Desk, Shared};
use super::document::{Change, Document};
use super::edit::Edit;
use super::engine::Engine;
use super::error::{EditError, TruthError};
use super::error_map::ErrorMap;
use super::export::{Export, ExportError};
use super::output::Output;
use super::painter::Painter;
use super::pick::Pick;
use super::picture::ClientId;
use super::ray_plot::RayPlot;
use super::second::{SecondPicture, Setting};
use super::slice::{Place, Slice, SliceQuery};
use super::subject::Subject;
use super::value_at::value_at;

/// A scene that is looked at: edits in, pictures out.
pub struct Session {
    shared: Arc<Shared>,
    control: Control,
    thread: Option<JoinHandle<()>>,
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
        let (subject, volume, section) = {
            let mut desk = self.shared.desk();
            if desk.ended {
                return Err(RenderError::Cancelled.into());
            }
            desk.sliced.push(Arc::clone(&flag));
            field_and_labels(&desk.document)
        };
        let made = control.cancellable(|| {
            let labels = subject.read_labels()?.map(|read| read.under(section.as_ref()));
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
        let (subject, volume, section) = field_and_labels(&self.shared.desk().document);
        let looks = subject.read_labels()?.map(|read| read.under(section.as_ref()));
        let label = looks.and_then(|looks| looks.look(looks.number_at(at)?));
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

/// Returns the current document's subject, volume and `[labels]` section, from which slices and values under the crosshair are made.
fn field_and_labels(document: &Document) -> (Arc<Subject>, Volume, Option<LabelsSection>) {
    (Arc::clone(document.subject()), document.values().clone(), document.labels().cloned())
}

/// The renderer of a document's picture at rest.
fn best(document: &Document) -> Result<Box<dyn Renderer>, EditError> {
    let stages = document.stages()?;
    Ok(stages.proven.map_or(stages.sharp, |(renderer, _)| renderer))
}
