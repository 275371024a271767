//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::{Compositing, Control, Model, Prepared, Rays, Real, RenderError, Rendered, Scene, UniformVolume, View};

use crate::caster::{Order, Precision, RayCaster, Rule, Step, Traversal};
use crate::instruments::{Instruments, Kernel};
use crate::operator::{Accumulate, Average, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
use crate::packet::LocalFrame;
use crate::pipeline::Pipeline;
use crate::screen::every_pixel;
use crate::tolerance::{Promise, Promised};

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    caster: RayCaster,
    scene: Scene,
    engine: Engine,
}

/// What draws.
enum Engine {
    /// Steps as the settings say.
    Plain(Kernel),
    /// Steps as a promised error asks for.
    Promise(Box<Promise>),
}

impl Engine {
    /// Makes what the scene needs, and takes over from `last` what has not changed since.
    fn new(
        caster: &RayCaster,
        scene: &Scene,
        volume: &UniformVolume,
        last: Option<(&Scene, &Self)>,
    ) -> Result<Self, RenderError> {
        if let Step::Tolerance(error) = caster.step {
            let promise = Promise::new(error, scene, volume, caster.filter_of(scene))?;
            return Ok(Self::Promise(Box::new(promise)));
        }
        let last = match last {
            Some((scene, Self::Plain(kernel))) => Some((scene, kernel)),
            _ => None,
        };
        Ok(Self::Plain(Kernel::new(caster, scene, volume, last)))
    }
}

impl PreparedCaster {
    pub(crate) fn new(caster: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        let engine = control.run(|| Engine::new(&caster, scene, volume, None))?;
        Ok(Self { caster, scene: scene.clone(), engine })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(self.caster.filter_of(scene)));
        self.engine = control.run(|| Engine::new(&self.caster, scene, volume, Some((&self.scene, &self.engine))))?;
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        match &self.engine {
            Engine::Plain(Kernel::F32(instruments)) => self.render_with(instruments, view, control),
            Engine::Plain(Kernel::F64(instruments)) => self.render_with(instruments, view, control),
            Engine::Promise(promise) => {
                let volume = check(&self.caster, &self.scene)?;
                let single = self.caster.precision == Precision::F32;
                let tracer = Promised { promise, volume, view, rays: Rays::new(view)?, single };
                every_pixel(&tracer, view, control)
            }
        }
    }

    fn model(&self, _: &View) -> Model {
        match self.caster.filter {
            Some(filter) if filter != self.scene.filter => Model::Filtered(filter),
            _ => Model::Canonical,
        }
    }
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
    if caster.rule == Rule::Exact && !scene.compositing.integrates_light() {
        return Err(unsupported(format!("compositing '{}' by the rule 'exact'", scene.compositing.name())));
    }
    let filter = caster.filter_of(scene);
    if !caster.rule.goes_with(filter) {
        return Err(unsupported(format!("the filter '{filter}' by the rule '{}'", caster.rule.name())));
    }
    if matches!(caster.step, Step::Local { .. }) && caster.traversal == Traversal::Samples {
        if !scene.compositing.integrates_light() {
            return Err(unsupported(format!(
                "compositing '{}' in steps that follow the light",
                scene.compositing.name()
            )));
        }
        if caster.order == Order::BackToFront {
            return Err(unsupported("steps that follow the data, back to front".to_owned()));
        }
    }
    if matches!(caster.step, Step::Homogeneous { .. }) {
        if scene.compositing != Compositing::Over || caster.order == Order::BackToFront {
            return Err(unsupported("homogeneous steps under anything but over, front to back".to_owned()));
        }
        if caster.rule != Rule::Midpoint {
            return Err(unsupported("homogeneous steps by another rule than the midpoint's".to_owned()));
        }
        if scene.shading.is_some() {
            return Err(unsupported("homogeneous steps with shading: values do not tell how it changes".to_owned()));
        }
    }
    scene.volume.uniform().ok_or_else(|| unsupported(format!("volumes of the kind '{}'", scene.volume.kind())))
}

impl PreparedCaster {
    /// Chooses the operator: once a frame.
    fn render_with<R: Real>(
        &self,
        instruments: &Instruments<R>,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let volume = check(&self.caster, &self.scene)?;
        if let Some(engine) = &instruments.vector {
            let frame = LocalFrame { engine, volume, rays: Rays::new(view)?, view };
            return every_pixel(&frame, view, control);
        }
        let transfer = || Arc::clone(&self.scene.transfer);
        let calibration = volume.calibration();
        let plain = Plain { prepared: self, volume, instruments, view, control };
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
    control: &'a Control,
}

impl<R: Real> Plain<'_, R> {
    fn draw<O: Operator<R>>(self, operator: impl Fn() -> O + Sync) -> Result<Rendered, RenderError> {
        let caster = &self.prepared.caster;
        let pipeline = Pipeline {
            volume: self.volume,
            filter: caster.filter_of(&self.prepared.scene),
            traversal: caster.traversal,
            voxel: self.volume.placement().spacing().min_element(),
            step: caster.longest_step(self.volume),
            pace: self.instruments.pace.as_deref(),
            homogeneity: self.instruments.homogeneity.as_deref(),
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            classifier: &self.instruments.classifier,
            shader: self.instruments.shader.as_ref(),
            view: self.view,
            rays: Rays::new(self.view)?,
            operator,
        };
        every_pixel(&pipeline, self.view, self.control)
    }
}
