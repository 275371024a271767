//! Drawing of all frames of an animation, and the files that they become.

use std::path::Path;
use std::time::{Duration, Instant};

use vr_core::cancel::catch_stopped;
use vr_core::{Control, Counts, Frame, Model, ParameterError, Prepared, RenderError, Scene, View};
use vr_io::{AnimationOptions, PngDepth, PngOptions};
use vr_physics::metrics::subgrid;
use vr_study::figures::ErrorFigures;
use vr_study::reference::{ReferencePixels, SUBGRID, frame_fingerprint};

use crate::args::{AnimationArgs, Bits, RendererArgs, ReplaceArgs};
use crate::console::Console;
use crate::error_bound::ErrorBound;
use crate::failure::Failure;
use crate::inputs::Inputs;
use crate::progress::{FrameBar, under_bar};
use crate::scene_setup::{Configured, Setup};

use super::frame_store::FrameStore;
use super::places::Places;
use super::shot::Shot;
use super::summary::Summary;
use super::time_series::Volumes;

/// Everything that makes an animation.
pub struct Film<'a> {
    /// Flags about frames and files.
    pub args: &'a AnimationArgs,
    /// Flags about the renderer.
    pub renderer: &'a RendererArgs,
    /// The scene.
    pub setup: Setup,
    /// Changes of each frame.
    pub shots: Vec<Shot>,
    /// Files to write.
    pub places: Places,
}

/// Work of all frames.
#[derive(Default)]
pub struct Drawn {
    /// Number of frames that were drawn; the others were there.
    pub drawn: usize,
    /// Counts of all frames, of those that were there too.
    pub counts: Counts,
    /// Time of preparations and of changes of the scene.
    pub prepare: Duration,
    /// Time of the frames.
    pub render: Duration,
    /// Errors of some frames, by number.
    pub errors: Vec<(usize, ErrorFigures)>,
}

impl Film<'_> {
    /// Draws the volumes of a scene, writes, and prints what it took.
    ///
    /// # Errors
    /// Any fault of the scene or the files; interruption, which leaves whole frames behind to go on from.
    pub fn make(self, mut volumes: Volumes, console: Console, control: &Control) -> Result<(), Failure> {
        let start = Instant::now();
        // Check everything that can be checked before anything is drawn.
        self.places.check_size(self.setup.view.size, self.args.fps)?;
        let configured = self.setup.renderer(self.renderer, console)?;
        self.check_shots()?;
        let inputs = Inputs::new("a file that is read", self.setup.inputs.iter().cloned());
        let replace = ReplaceArgs { force: self.args.force };
        self.places.animations.iter().try_for_each(|place| inputs.permit("--output", place, replace))?;
        let names = vr_io::numbered_names(&self.places.frames.pattern, self.shots.len()).map_err(Failure::usage)?;
        let mut frames = names.iter().map(|name| self.places.frames.folder.join(name));
        frames.try_for_each(|place| inputs.protect("--output", &place))?;

        for path in
            self.places.animations.iter().filter(|p| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")))
        {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            console.note(&format!("{} is an animated PNG; {stem}-%04d.png would name its frames", path.display()));
        }

        // Draw the frames, and put them together.
        let mut store = FrameStore::open(self.places.frames.clone(), self.shots.len(), self.args.force, console)?;
        let drawn = self.draw(&mut volumes, &configured, &mut store, (console, control))?;
        for path in &self.places.animations {
            self.write(path, &store, console, control)?;
        }

        let error_bound =
            configured.max_error.map(|bound| ErrorBound::new(bound, &drawn.counts, self.setup.view.supersampling));
        let summary = Summary {
            setup: &self.setup,
            renderer: configured.renderer.name(),
            frames: self.shots.len(),
            fps: self.args.fps,
            drawn: &drawn,
            animations: &self.places.animations,
            place: (!store.is_temporary()).then(|| store.place()),
            error_bound,
            elapsed: start.elapsed(),
        };
        console.result(&summary.text(), &summary.json())?;
        store.finish(console);
        error_bound.map_or(Ok(()), |bound| bound.outcome())
    }

    /// Refuses frames that cannot be drawn, by number.
    fn check_shots(&self) -> Result<(), Failure> {
        let own = &self.setup.scene;
        if self.setup.labels.is_some() && self.shots.iter().any(|shot| shot.points.is_some()) {
            let message = "keys: points of the transfer function cannot go with labels, whose styles are part of it; leave one of them out";
            return Err(Failure::failed(message));
        }
        for (i, shot) in self.shots.iter().enumerate() {
            let named = |e: ParameterError| Failure::failed(format!("frame {i}: {e}"));
            shot.view(&self.setup.view).validate().map_err(named)?;
            shot.change(&mut own.clone(), own).map_err(named)?;
        }
        Ok(())
    }

    /// Draws every frame that is not there.
    fn draw(
        &self,
        volumes: &mut Volumes,
        configured: &Configured,
        store: &mut FrameStore,
        (console, control): (Console, &Control),
    ) -> Result<Drawn, Failure> {
        let count = self.shots.len();
        let png = self.png();
        let Configured { renderer, options, max_error, .. } = configured;
        let described = format!("{} {options:?} {max_error:?} {:?} {}", renderer.name(), png.depth, png.alpha);
        let mut all = Drawn::default();
        let mut scene = self.setup.scene.clone();
        let mut prepared: Option<Box<dyn Prepared>> = None;
        // True if the scene is another than the one that is prepared.
        let mut is_changed = false;
        let bar = FrameBar::new(console, count as u64);
        for i in 0..count {
            let failed = |e| self.failure(e, i, store);
            control.check().map_err(failed)?;
            // Set the scene.
            let read = volumes.of_frame(i);
            let (volume, hash) =
                read.map_err(|e| if control.is_cancelled() { failed(RenderError::Cancelled) } else { e })?;
            if !volume.same(&scene.volume) {
                scene.volume = volume.clone();
                is_changed = true;
            }
            let shot = &self.shots[i];
            is_changed |= shot.change(&mut scene, &self.setup.scene).map_err(Failure::failed)?;
            let view = shot.view(&self.setup.view);
            // Keep the frame that is there, unless its numbers are needed.
            let made_of = hash.and_then(|hash| frame_fingerprint((&scene, &view), hash, &described));
            let is_measured = self.args.error.is_some_and(|every| i % every as usize == 0);
            if !is_measured
                && !self.args.force
                && let Some(counts) = store.kept(i, made_of.as_deref())
            {
                all.counts += counts;
                bar.kept();
                continue;
            }
            // Prepare once; afterwards only what has changed.
            let start = Instant::now();
            let made = catch_stopped(|| match prepared.take() {
                Some(mut ready) if is_changed => ready.update(&scene, control).map(|()| ready),
                Some(ready) => Ok(ready),
                None => renderer.prepare(&scene, control),
            });
            let ready = prepared.insert(made.map_err(failed)?);
            is_changed = false;
            all.prepare += start.elapsed();
            // Draw and write.
            let start = Instant::now();
            let rendered = catch_stopped(|| ready.render(&view, control)).map_err(failed)?;
            all.render += start.elapsed();
            store.put(i, made_of.as_deref(), &vr_io::encode_png(&rendered.frame, &png), &rendered.stats.counts)?;
            all.counts += rendered.stats.counts;
            all.drawn += 1;
            if is_measured {
                let judged = catch_stopped(|| judge((&scene, &view), &rendered.frame, control));
                all.errors.push((i, judged.map_err(|e| self.failure(e, i + 1, store))?));
            }
            bar.drawn();
        }
        Ok(all)
    }

    /// Returns the failure of an animation after some frames: interrupted, it says how to go on.
    fn failure(&self, error: RenderError, done: usize, store: &FrameStore) -> Failure {
        let (count, folder) = (self.shots.len(), store.place().folder.display());
        match error {
            RenderError::Cancelled => Failure::failed(format!(
                "interrupted: {done} of {count} frames are kept in {folder}; the same command goes on from there"
            )),
            other => self.setup.render_failure(other),
        }
    }

    fn png(&self) -> PngOptions {
        PngOptions {
            background: self.setup.scene.background,
            depth: match self.args.bits {
                Bits::Eight => PngDepth::Eight,
                Bits::Sixteen => PngDepth::Sixteen,
            },
            alpha: self.args.alpha,
            ..PngOptions::default()
        }
    }

    /// Puts the frames together in a file.
    fn write(&self, path: &Path, store: &FrameStore, console: Console, control: &Control) -> Result<(), Failure> {
        let options = AnimationOptions { fps: self.args.fps, repeats: self.args.repeats() };
        let label = format!("writing {}", path.file_name().unwrap_or_default().to_string_lossy());
        let write = |control: &Control| vr_io::write_animation(path, &store.files, &options, control);
        under_bar(console, control, &label, write).map_err(|e| match e {
            _ if control.is_cancelled() => self.failure(RenderError::Cancelled, self.shots.len(), store),
            other => Failure::failed(other),
        })
    }
}

/// Compares a frame with the reference.
fn judge((scene, view): (&Scene, &View), frame: &Frame, control: &Control) -> Result<ErrorFigures, RenderError> {
    let pixels = subgrid(SUBGRID, view.size);
    let reference = ReferencePixels::solve((scene, view), &Model::Canonical, pixels, control)?;
    Ok(ErrorFigures::new(&reference, frame))
}
