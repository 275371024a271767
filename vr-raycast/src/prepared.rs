//! A ray caster that has seen its scene.

use vr_core::transfer::BakedTransfer;
use vr_core::{
    Control, Model, ParameterError, Prepared, Probe, Projection, Rays, Real, RenderError, Rendered, Scene,
    UniformVolume, View,
};

use crate::caster::{Connectivity, Order, Precision, RayCaster, Rule, Screen};
use crate::engine::Engine;
use crate::instruments::{Instruments, Kernel};
use crate::operator::Brightest;
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

    /// `None` from templates, whose rays are not those of pixels, and under a promised error.
    fn probe(&mut self, view: &View, pixel: [u32; 2], control: &Control) -> Result<Option<Probe>, RenderError> {
        view.validate()?;
        if pixel[0] >= view.size[0] || pixel[1] >= view.size[1] {
            return Err(ParameterError::new("pixel", pixel, "must lie in the picture").into());
        }
        if matches!(self.caster.screen, Screen::Template { .. }) {
            return Ok(None);
        }
        let volume = check(&self.caster, &self.scene)?;
        control.check()?;
        // Packets have empty space of their own to leap over: the plain kernel is told only now that it draws, too.
        if let Engine::Packets(_, kernel) = &mut self.engine {
            control.run(|| kernel.find_empty_space(&self.caster, &self.scene, volume, None));
        }
        let (kernel, own_kernel) = match &self.engine {
            Engine::Plain(kernel) => (kernel, true),
            Engine::Packets(_, kernel) => (kernel, false),
            Engine::Promise(_) => return Ok(None),
        };
        control.run(|| match kernel {
            Kernel::F32(instruments) => Ok(Some(self.pipeline(instruments, view)?.probe(pixel, own_kernel))),
            Kernel::F64(instruments) => Ok(Some(self.pipeline(instruments, view)?.probe(pixel, own_kernel))),
        })
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
            Engine::Plain(Kernel::F32(instruments)) => stage.draw(&self.pipeline(instruments, view)?),
            Engine::Plain(Kernel::F64(instruments)) => stage.draw(&self.pipeline(instruments, view)?),
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

    /// Returns the plain engine with a view.
    fn pipeline<'a, R: Real>(
        &'a self,
        instruments: &'a Instruments<R>,
        view: &'a View,
    ) -> Result<Pipeline<'a, R>, RenderError> {
        let (caster, scene) = (&self.caster, &self.scene);
        let volume = check(caster, scene)?;
        Ok(Pipeline {
            scene,
            volume,
            filter: caster.filter_of(scene),
            traversal: caster.traversal,
            voxel: volume.placement().spacing().min_element(),
            step: caster.longest_step(volume),
            pace: instruments.pace.as_deref(),
            homogeneity: instruments.homogeneity.as_deref(),
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            classifier: &instruments.classifier,
            shader: instruments.shader.as_ref(),
            empty_space: instruments.empty_space.as_ref(),
            view,
            rays: Rays::new(view)?,
            order: caster.order,
            brightest: instruments.brightest(),
        })
    }
}
