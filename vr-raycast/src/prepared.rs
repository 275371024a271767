//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::transfer::BakedTransfer;
use vr_core::{
    Compositing, Control, Model, Prepared, Projection, Rays, Real, RenderError, Rendered, Scene, UniformVolume, View,
};

use crate::caster::{Connectivity, Order, Precision, RayCaster, Rule, Screen};
use crate::engine::Engine;
use crate::instruments::{Instruments, Kernel};
use crate::operator::{Accumulate, Average, Brightest, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
use crate::packet::PacketFrame;
use crate::pipeline::Pipeline;
use crate::screen::{CoherenceBuffer, Stage, Template};
use crate::support::{check, unsupported};
use crate::table_range::table_range;
use crate::tolerance::Promised;

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    /// As it was set.
    asked: RayCaster,
    /// As it draws the scene.
    caster: RayCaster,
    scene: Scene,
    engine: Engine,
    /// What the coherent screen keeps from picture to picture.
    coherence: Option<CoherenceBuffer>,
}

impl PreparedCaster {
    pub(crate) fn new(asked: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let caster = asked.settled_for(scene);
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        let engine = control.run(|| Engine::new(&caster, scene, volume, None))?;
        let coherence = control.run(|| coherence(&caster, scene, volume, &engine));
        Ok(Self { asked, caster, scene: scene.clone(), engine, coherence })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let caster = self.asked.settled_for(scene);
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        self.engine = control.run(|| Engine::new(&caster, scene, volume, Some((&self.scene, &self.engine))))?;
        let then = &self.scene;
        let same = then.volume.same(&scene.volume) && then.filter == scene.filter && then.transfer == scene.transfer;
        // Compositing decides what a table is needed for, and so what can be seen.
        if !same || then.compositing != scene.compositing {
            self.coherence = control.run(|| coherence(&caster, scene, volume, &self.engine));
        }
        (self.caster, self.scene) = (caster, scene.clone());
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        // Taken out for the while, so that the rest can be shared.
        let mut coherence = self.coherence.take();
        let rendered = self.draw(coherence.as_mut(), view, control);
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
fn coherence(caster: &RayCaster, scene: &Scene, volume: &UniformVolume, engine: &Engine) -> Option<CoherenceBuffer> {
    match engine {
        Engine::Plain(kernel) | Engine::Packets(_, kernel) if caster.screen == Screen::Coherent => {
            Some(CoherenceBuffer::new(volume, caster.filter_of(scene), kernel.sight()))
        }
        _ => None,
    }
}

impl PreparedCaster {
    /// Chooses the engine.
    fn draw(
        &self,
        coherence: Option<&mut CoherenceBuffer>,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let volume = check(&self.caster, &self.scene)?;
        if let (Screen::Template { connectivity }, Engine::Plain(kernel) | Engine::Packets(_, kernel)) =
            (self.caster.screen, &self.engine)
        {
            return self.draw_by_template(connectivity, kernel.brightest(), view, control);
        }
        let step = self.caster.world_step(volume);
        let stage = Stage { screen: self.caster.screen, coherence, volume, step, view, control };
        match &self.engine {
            Engine::Plain(Kernel::F32(instruments)) => self.render_with(instruments, stage),
            Engine::Plain(Kernel::F64(instruments)) => self.render_with(instruments, stage),
            Engine::Packets(engine, _) => stage.draw(&PacketFrame::new(engine, volume, view)?),
            Engine::Promise(promise) => {
                let single = self.caster.precision == Precision::F32;
                stage.draw(&Promised { promise, volume, view, rays: Rays::new(view)?, single })
            }
        }
    }

    /// Draws by a template.
    fn draw_by_template(
        &self,
        connectivity: Connectivity,
        brightest: Brightest,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        if !matches!(view.camera.projection, Projection::Orthographic { .. }) {
            return Err(unsupported("perspective with a template screen".to_owned()));
        }
        if view.layer.is_some() {
            return Err(unsupported("opaque layers with a template screen".to_owned()));
        }
        let volume = check(&self.caster, &self.scene)?;
        let Order::FrontToBack { termination } = self.caster.order else {
            return Err(unsupported("compositing back to front with a template screen".to_owned()));
        };
        let (low, high) = self.scene.volume.bounds();
        let most = match brightest {
            Brightest::Radiance(c) => c.max(1.0),
            Brightest::Emission(q) => (q * low.distance(high)).max(1.0),
        };
        let step = self.caster.world_step(volume);
        let template = Template { volume, connectivity, step, enough: 1.0 - (1.0 - termination) / most };
        let range = table_range(volume, self.caster.filter_of(&self.scene), &self.scene.transfer);
        let integer = volume.voxel_type().is_integer();
        let bake = |length| BakedTransfer::new(&self.scene.transfer, volume.calibration(), range, integer, length);
        template.draw(bake, view, control)
    }

    /// Chooses the operator: once a frame.
    fn render_with<R: Real>(&self, instruments: &Instruments<R>, stage: Stage<'_>) -> Result<Rendered, RenderError> {
        let volume = stage.volume;
        let transfer = || Arc::clone(&self.scene.transfer);
        let calibration = volume.calibration();
        let plain = Plain { prepared: self, volume, instruments, stage };
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
    stage: Stage<'a>,
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
            empty_space: self.instruments.empty_space.as_ref(),
            view: self.stage.view,
            rays: Rays::new(self.stage.view)?,
            operator,
        };
        self.stage.draw(&pipeline)
    }
}
