//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::{Compositing, Control, Model, Prepared, Rays, Real, RenderError, Rendered, Scene, UniformVolume, View};

use crate::caster::{Order, RayCaster, Rule, Screen, Step};
use crate::instruments::{Instruments, Kernel};
use crate::operator::{Accumulate, Average, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
use crate::pipeline::Pipeline;
use crate::screen::{CoherenceBuffer, Stage};

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    caster: RayCaster,
    scene: Scene,
    kernel: Kernel,
    /// What the coherent screen keeps from picture to picture.
    coherence: Option<CoherenceBuffer>,
}

impl PreparedCaster {
    pub(crate) fn new(caster: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        let kernel = Kernel::new(&caster, scene, volume, None);
        let coherence = coherence(&caster, scene, volume, &kernel, control);
        Ok(Self { caster, scene: scene.clone(), kernel, coherence })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(self.caster.filter_of(scene)));
        self.kernel = Kernel::new(&self.caster, scene, volume, Some((&self.scene, &self.kernel)));
        let then = &self.scene;
        let same = then.volume.same(&scene.volume) && then.filter == scene.filter && then.transfer == scene.transfer;
        if !same {
            self.coherence = coherence(&self.caster, scene, volume, &self.kernel, control);
        }
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        // Taken out for the while, so that the rest can be shared.
        let mut coherence = self.coherence.take();
        let rendered = match &self.kernel {
            Kernel::F32(instruments) => self.render_with(instruments, coherence.as_mut(), view, control),
            Kernel::F64(instruments) => self.render_with(instruments, coherence.as_mut(), view, control),
        };
        self.coherence = coherence;
        rendered
    }

    fn model(&self, _: &View) -> Model {
        match self.caster.filter {
            Some(filter) if filter != self.scene.filter => Model::Filtered(filter),
            _ => Model::Canonical,
        }
    }
}

/// What the coherent screen knows before its first picture; `None` for the others.
fn coherence(
    caster: &RayCaster,
    scene: &Scene,
    volume: &UniformVolume,
    kernel: &Kernel,
    control: &Control,
) -> Option<CoherenceBuffer> {
    (caster.screen == Screen::Coherent)
        .then(|| control.run(|| CoherenceBuffer::new(volume, caster.filter_of(scene), kernel.sight())))
}

fn unsupported(feature: String) -> RenderError {
    RenderError::Unsupported { renderer: RayCaster::NAME, feature }
}

/// Whether this caster can draw this scene; its volume, if so.
fn check<'s>(caster: &RayCaster, scene: &'s Scene) -> Result<&'s UniformVolume, RenderError> {
    caster.validate()?;
    scene.validate()?;
    if caster.order == Order::BackToFront && scene.compositing != Compositing::Over {
        return Err(unsupported(format!("compositing '{}' back to front", scene.compositing.name())));
    }
    let name = scene.compositing.name();
    if caster.screen == Screen::Coherent && !scene.compositing.integrates_light() {
        return Err(unsupported(format!("compositing '{name}' with the screen 'coherent'")));
    }
    if caster.screen == Screen::Coherent && !matches!(caster.step, Step::Uniform(_)) {
        return Err(unsupported("steps that are not uniform with the screen 'coherent'".to_owned()));
    }
    scene.volume.uniform().ok_or_else(|| unsupported(format!("volumes of the kind '{}'", scene.volume.kind())))
}

impl PreparedCaster {
    /// Chooses the operator: once a frame.
    fn render_with<R: Real>(
        &self,
        instruments: &Instruments<R>,
        coherence: Option<&mut CoherenceBuffer>,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let volume = check(&self.caster, &self.scene)?;
        let transfer = || Arc::clone(&self.scene.transfer);
        let calibration = volume.calibration();
        let stage = Stage { screen: self.caster.screen, coherence, volume, step: self.caster.world_step(volume), view, control };
        let plain = Plain { prepared: self, volume, instruments, view, stage };
        match (self.scene.compositing, self.caster.order) {
            (Compositing::Over, Order::BackToFront) => plain.draw(OverBackToFront::default),
            (Compositing::Over, Order::FrontToBack { termination }) => {
                plain.draw(|| OverFrontToBack::new(termination, instruments.brightest()))
            }
            (Compositing::Accumulate { level }, _) => plain.draw(|| Accumulate::new(level)),
            (Compositing::First { threshold }, _) => plain.draw(|| First::new(transfer(), calibration, threshold)),
            (Compositing::Average, _) => plain.draw(|| Average::new(transfer(), calibration)),
            (Compositing::Maximum, _) => plain.draw(|| Extreme::new(transfer(), calibration, true)),
            (Compositing::Minimum, _) => plain.draw(|| Extreme::new(transfer(), calibration, false)),
        }
    }
}

/// A frame by the plain engine, but for its operator.
struct Plain<'a, R> {
    prepared: &'a PreparedCaster,
    volume: &'a UniformVolume,
    instruments: &'a Instruments<R>,
    view: &'a View,
    stage: Stage<'a>,
}

impl<R: Real> Plain<'_, R> {
    fn draw<O: Operator<R>>(self, operator: impl Fn() -> O + Sync) -> Result<Rendered, RenderError> {
        let caster = &self.prepared.caster;
        let pipeline = Pipeline {
            volume: self.volume,
            filter: caster.filter_of(&self.prepared.scene),
            step: caster.world_step(self.volume),
            offset: match caster.rule {
                Rule::Midpoint => 0.5,
                Rule::Left => 0.0,
            },
            classifier: &self.instruments.classifier,
            shader: self.instruments.shader.as_ref(),
            view: self.view,
            rays: Rays::new(self.view)?,
            operator,
        };
        self.stage.draw(&pipeline)
    }
}
