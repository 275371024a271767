//! A ray caster that has seen its scene.

use vr_core::{
    Control, Model, ParameterError, Prepared, Probe, Rays, Real, RenderError, Rendered, Scene, UniformVolume, View,
};

#[cfg(feature = "classics")]
use crate::caster::Screen;
use crate::caster::{Precision, RayCaster, Rule, Traversal};
#[cfg(feature = "classics")]
use crate::classics::{CoherenceBuffer, coherent, draw_by_template};
use crate::engine::Engine;
use crate::instruments::{Instruments, Kernel};
use crate::packet::PacketFrame;
use crate::pipeline::Pipeline;
use crate::screen;
use crate::support::check;
use crate::tolerance::Promised;
use crate::tracer::Tracer;
use crate::walk::{WalkKind, Walks};

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    /// As it was set.
    asked: RayCaster,
    /// As it draws the scene.
    caster: RayCaster,
    scene: Scene,
    engine: Engine,
    /// What the coherent screen keeps from picture to picture.
    #[cfg(feature = "classics")]
    coherence: Option<CoherenceBuffer>,
}

impl PreparedCaster {
    pub(crate) fn new(asked: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let caster = asked.settled_for(scene);
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        let engine = control.run(|| Engine::new(&caster, scene, volume, None))?;
        Ok(Self {
            #[cfg(feature = "classics")]
            coherence: control.run(|| CoherenceBuffer::of(&caster, scene, volume, &engine)),
            asked,
            caster,
            scene: scene.clone(),
            engine,
        })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let caster = self.asked.settled_for(scene);
        let volume = check(&caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(caster.filter_of(scene)));
        self.engine = control.run(|| Engine::new(&caster, scene, volume, Some((&self.scene, &self.engine))))?;
        #[cfg(feature = "classics")]
        if !CoherenceBuffer::holds_for(&self.scene, scene) {
            self.coherence = control.run(|| CoherenceBuffer::of(&caster, scene, volume, &self.engine));
        }
        (self.caster, self.scene) = (caster, scene.clone());
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let volume = check(&self.caster, &self.scene)?;
        #[cfg(feature = "classics")]
        if let (Screen::Template { connectivity }, Some(kernel)) = (self.caster.screen, self.engine.kernel()) {
            return draw_by_template(connectivity, &self.caster, &self.scene, volume, kernel, view, control);
        }
        #[cfg(feature = "classics")]
        if let Some(mut buffer) = self.coherence.take() {
            let step = self.caster.world_step(volume);
            let tracer = self.tracer(volume, view);
            let drawn = tracer.and_then(|tracer| coherent(tracer.as_ref(), &mut buffer, volume, step, view, control));
            self.coherence = Some(buffer);
            return drawn;
        }
        screen::draw(self.caster.screen, self.tracer(volume, view)?.as_ref(), view, control)
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
        if !self.caster.screen.casts_pixels() {
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

impl PreparedCaster {
    /// Returns the engine with a view.
    fn tracer<'a>(&'a self, volume: &'a UniformVolume, view: &'a View) -> Result<Box<dyn Tracer + 'a>, RenderError> {
        Ok(match &self.engine {
            Engine::Plain(Kernel::F32(instruments)) => Box::new(self.pipeline(instruments, view)?),
            Engine::Plain(Kernel::F64(instruments)) => Box::new(self.pipeline(instruments, view)?),
            Engine::Packets(engine, _) => Box::new(PacketFrame::new(engine, volume, view)?),
            Engine::Promise(promise) => {
                let single = self.caster.precision == Precision::F32;
                Box::new(Promised { promise, volume, view, rays: Rays::new(view)?, single })
            }
        })
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
            walks: Walks {
                kind: self.walk_kind(instruments),
                step: caster.longest_step(volume),
                voxel: volume.placement().spacing().min_element(),
                dims: volume.dims(),
            },
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            classifier: &instruments.classifier,
            shader: instruments.shader.as_ref(),
            view,
            rays: Rays::new(view)?,
            order: caster.order,
            brightest: instruments.brightest(),
        })
    }

    fn walk_kind<'a, R: Real>(&self, instruments: &'a Instruments<R>) -> WalkKind<'a> {
        match (self.caster.traversal, &instruments.pace) {
            (Traversal::Cells, _) => return WalkKind::Cells,
            #[cfg(feature = "classics")]
            (Traversal::Voxels, _) => return WalkKind::Voxels,
            (Traversal::Samples, Some(map)) => return WalkKind::Local(map),
            (Traversal::Samples, None) => {}
        }
        #[cfg(feature = "classics")]
        if let Some(map) = &instruments.homogeneity {
            return WalkKind::Homogeneous(map);
        }
        WalkKind::Lattice(instruments.empty_space.as_deref())
    }
}
