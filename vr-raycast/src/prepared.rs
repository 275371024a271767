//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::{
    Compositing, Control, Feature, Filter, GridVolume, Layer, Model, ParameterError, Prepared, Probe, Rays, Real,
    RenderError, Rendered, Scene, View,
};
use vr_kernels::tables::BakedTransfer;

use crate::caster::{Connectivity, Order, Precision, RayCaster, Rule, Screen};
use crate::engine::Engine;
use crate::instruments::{Instruments, Kernel};
use crate::operator::{Accumulate, Average, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
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
    /// The scene, under the filter that the caster samples it with.
    scene: Scene,
    volume: Arc<GridVolume>,
    /// The caster's own filter, where it is not the scene's.
    filtered: Option<Filter>,
    engine: Engine,
    /// What the coherent screen keeps from picture to picture.
    coherence: Option<CoherenceBuffer>,
}

impl PreparedCaster {
    pub(crate) fn new(asked: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let filtered = asked.filter.filter(|filter| scene.volume.filter() != Some(*filter));
        let (caster, scene) = (asked.settled_for(scene), asked.scene_of(scene));
        let volume = check(&caster, &scene)?;
        control.check()?;
        control.run(|| volume.prepare_derived());
        let engine = control.run(|| Engine::new(&caster, &scene, &volume, None))?;
        let coherence = control.run(|| coherence(&caster, &volume, &engine));
        Ok(Self { asked, caster, scene, volume, filtered, engine, coherence })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        self.filtered = self.asked.filter.filter(|filter| scene.volume.filter() != Some(*filter));
        let (caster, scene) = (self.asked.settled_for(scene), self.asked.scene_of(scene));
        let volume = check(&caster, &scene)?;
        control.check()?;
        control.run(|| volume.prepare_derived());
        self.engine = control.run(|| Engine::new(&caster, &scene, &volume, Some((&self.scene, &self.engine))))?;
        let then = &self.scene;
        let same = then.volume.same(&scene.volume) && then.transfer == scene.transfer;
        // Compositing decides what a table is needed for, and so what can be seen.
        if !same || then.compositing != scene.compositing {
            self.coherence = control.run(|| coherence(&caster, &volume, &self.engine));
        }
        (self.caster, self.scene, self.volume) = (caster, scene, volume);
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        // Taken out for the while, so that the rest can be shared.
        let mut coherence = self.coherence.take();
        let rendered = self.draw(coherence.as_mut(), view, control);
        self.coherence = coherence;
        rendered
    }

    fn model(&self, _: &View) -> Result<Model, RenderError> {
        Ok(self.filtered.map_or(Model::Canonical, Model::Filtered))
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
        control.check()?;
        let volume = &self.volume;
        let layer = self.scene.layer(view, control)?;
        // Packets have empty space of their own to leap over: the plain kernel is told only now that it draws, too.
        if let Engine::Packets(_, kernel) = &mut self.engine {
            control.run(|| kernel.find_empty_space(&self.caster, &self.scene, volume, None));
        }
        let (kernel, own_kernel) = match &self.engine {
            Engine::Plain(kernel) => (kernel, true),
            Engine::Packets(_, kernel) => (kernel, false),
            Engine::Promise(_) => return Ok(None),
        };
        let probing = Probing { view, layer: layer.as_ref(), pixel, own_kernel };
        control.run(|| match kernel {
            Kernel::F32(instruments) => self.by_plain_engine(instruments, probing),
            Kernel::F64(instruments) => self.by_plain_engine(instruments, probing),
        })
    }
}

/// What the coherent screen knows before its first picture; `None` for the others.
fn coherence(caster: &RayCaster, volume: &GridVolume, engine: &Engine) -> Option<CoherenceBuffer> {
    match engine {
        Engine::Plain(kernel) | Engine::Packets(_, kernel) if caster.screen == Screen::Coherent => {
            Some(CoherenceBuffer::new(volume, kernel.sight()))
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
        if let (Screen::Template { connectivity }, Engine::Plain(_) | Engine::Packets(..)) =
            (self.caster.screen, &self.engine)
        {
            return self.draw_by_template(connectivity, view, control);
        }
        let volume = &*self.volume;
        let layer = self.scene.layer(view, control)?;
        let layer = layer.as_ref();
        let step = self.caster.world_step(volume);
        let stage = Stage { screen: self.caster.screen, coherence, volume, step, view, layer, control };
        match &self.engine {
            Engine::Plain(Kernel::F32(instruments)) => self.by_plain_engine(instruments, stage),
            Engine::Plain(Kernel::F64(instruments)) => self.by_plain_engine(instruments, stage),
            Engine::Packets(engine, _) => stage.draw(&PacketFrame::new(engine, volume, (view, layer))?),
            Engine::Promise(promise) => {
                let single = self.caster.precision == Precision::F32;
                stage.draw(&Promised { promise, volume, view, layer, rays: Rays::new(view)?, single })
            }
        }
    }

    /// Draws by a template.
    fn draw_by_template(
        &self,
        connectivity: Connectivity,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        let volume = &*self.volume;
        let Order::FrontToBack { termination } = self.caster.order else {
            return Err(unsupported(
                Feature::Compositing,
                "compositing back to front with a template screen".to_owned(),
            ));
        };
        let (low, high) = self.scene.volume.bounds();
        let most = self.scene.max_radiance().over(low.distance(high));
        let step = self.caster.world_step(volume);
        let template = Template { volume, connectivity, step, enough: 1.0 - (1.0 - termination) / most };
        let range = table_range(volume, &self.scene.transfer);
        let integer = volume.voxel_type().is_integer();
        let bake = |length| BakedTransfer::new(&self.scene.transfer, volume.calibration(), range, integer, length);
        template.draw(bake, view, control)
    }

    /// Has the plain engine do something: chooses the operator, once a frame.
    fn by_plain_engine<'v, R: Real, T: PlainTask<'v>>(
        &self,
        instruments: &Instruments<R>,
        task: T,
    ) -> Result<T::Output, RenderError> {
        let transfer = || Arc::clone(&self.scene.transfer);
        let calibration = self.volume.calibration();
        let plain = Plain { prepared: self, instruments, task };
        match (self.scene.compositing, self.caster.order) {
            (Compositing::Over, Order::BackToFront) => plain.with(OverBackToFront::default),
            (Compositing::Over, Order::FrontToBack { termination }) => {
                plain.with(|| OverFrontToBack::new(termination, self.scene.max_radiance()))
            }
            (Compositing::Accumulate { level }, _) => plain.with(|| Accumulate::new(level)),
            (Compositing::First { threshold }, _) => plain.with(|| First::new(transfer(), calibration, threshold)),
            (Compositing::Average, _) => plain.with(|| Average::new(transfer(), calibration)),
            (Compositing::Maximum, _) => plain.with(|| Extreme::new(transfer(), calibration, true)),
            (Compositing::Minimum, _) => plain.with(|| Extreme::new(transfer(), calibration, false)),
        }
    }
}

/// What the plain engine is to do once its operator is chosen.
trait PlainTask<'v> {
    type Output;

    /// The view that it is about, and the surfaces in it.
    fn view(&self) -> (&'v View, Option<&'v Layer>);

    fn done_by<R: Real, O: Operator<R>>(
        self,
        pipeline: &Pipeline<'_, R, impl Fn() -> O + Sync>,
    ) -> Result<Self::Output, RenderError>;
}

/// A frame.
impl<'v> PlainTask<'v> for Stage<'v> {
    type Output = Rendered;

    fn view(&self) -> (&'v View, Option<&'v Layer>) {
        (self.view, self.layer)
    }

    fn done_by<R: Real, O: Operator<R>>(
        self,
        pipeline: &Pipeline<'_, R, impl Fn() -> O + Sync>,
    ) -> Result<Rendered, RenderError> {
        self.draw(pipeline)
    }
}

/// One ray, watched.
struct Probing<'a> {
    view: &'a View,
    layer: Option<&'a Layer>,
    pixel: [u32; 2],
    own_kernel: bool,
}

impl<'v> PlainTask<'v> for Probing<'v> {
    type Output = Option<Probe>;

    fn view(&self) -> (&'v View, Option<&'v Layer>) {
        (self.view, self.layer)
    }

    fn done_by<R: Real, O: Operator<R>>(
        self,
        pipeline: &Pipeline<'_, R, impl Fn() -> O + Sync>,
    ) -> Result<Option<Probe>, RenderError> {
        Ok(Some(pipeline.probe(self.pixel, self.own_kernel)))
    }
}

/// The plain engine before a task, but for its operator.
struct Plain<'a, R, T> {
    prepared: &'a PreparedCaster,
    instruments: &'a Instruments<R>,
    task: T,
}

impl<'v, R: Real, T: PlainTask<'v>> Plain<'_, R, T> {
    fn with<O: Operator<R>>(self, operator: impl Fn() -> O + Sync) -> Result<T::Output, RenderError> {
        let PreparedCaster { caster, volume, .. } = self.prepared;
        let (view, layer) = self.task.view();
        let pipeline = Pipeline {
            volume,
            traversal: caster.traversal,
            voxel: volume.placement().spacing().min_element(),
            step: caster.longest_step(volume),
            pace: self.instruments.pace.as_deref(),
            homogeneity: self.instruments.homogeneity.as_deref(),
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            classifier: &self.instruments.classifier,
            shader: self.instruments.shader.as_ref(),
            empty_space: self.instruments.empty_space.as_ref(),
            view,
            layer,
            rays: Rays::new(view)?,
            operator,
        };
        self.task.done_by(&pipeline)
    }
}
