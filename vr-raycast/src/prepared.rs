//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::{Compositing, Control, Model, Prepared, Rays, Real, RenderError, Rendered, Scene, UniformVolume, View};

use crate::caster::{Order, RayCaster, Rule, Step};
use crate::instruments::{Instruments, Kernel};
use crate::operator::{Accumulate, Average, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
use crate::pipeline::Pipeline;
use crate::screen::every_pixel;

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    caster: RayCaster,
    scene: Scene,
    kernel: Kernel,
}

impl PreparedCaster {
    pub(crate) fn new(caster: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        let kernel = control.run(|| Kernel::new(&caster, scene, volume, None));
        Ok(Self { caster, scene: scene.clone(), kernel })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(self.caster.filter_of(scene)));
        self.kernel = control.run(|| Kernel::new(&self.caster, scene, volume, Some((&self.scene, &self.kernel))));
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        match &self.kernel {
            Kernel::F32(instruments) => self.render_with(instruments, view, control),
            Kernel::F64(instruments) => self.render_with(instruments, view, control),
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
    if matches!(caster.step, Step::Local { .. }) {
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
            voxel: self.volume.placement().spacing().min_element(),
            step: caster.world_step(self.volume),
            pace: self.instruments.pace.as_deref(),
            offset: match caster.rule {
                Rule::Midpoint => 0.5,
                Rule::Left => 0.0,
            },
            classifier: &self.instruments.classifier,
            shader: self.instruments.shader.as_ref(),
            empty_space: self.instruments.empty_space.as_ref(),
            view: self.view,
            rays: Rays::new(self.view)?,
            operator,
        };
        every_pixel(&pipeline, self.view, self.control)
    }
}
