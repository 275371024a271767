//! A ray caster that has seen its scene.

use std::sync::Arc;

use vr_core::transfer::BakedTransfer;
use vr_core::{
    Compositing, Control, Filter, Model, Prepared, Projection, Rays, Real, RenderError, Rendered, Scene, UniformVolume,
    View,
};

use crate::caster::{Classification, Connectivity, Order, Precision, RayCaster, Rule, Screen, Step, Traversal};
use crate::instruments::{Instruments, Kernel};
use crate::operator::{Accumulate, Average, Brightest, Extreme, First, Operator, OverBackToFront, OverFrontToBack};
use crate::packet::LocalFrame;
use crate::pipeline::Pipeline;
use crate::screen::{CoherenceBuffer, Stage, Template};
use crate::table_range::table_range;
use crate::tolerance::{Promise, Promised};

/// A ray caster that has seen its scene: the scene, and what its kernels look things up in.
pub(crate) struct PreparedCaster {
    caster: RayCaster,
    scene: Scene,
    /// What the coherent screen keeps from picture to picture.
    coherence: Option<CoherenceBuffer>,
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
        let coherence = control.run(|| coherence(&caster, scene, volume, &engine));
        Ok(Self { caster, scene: scene.clone(), engine, coherence })
    }
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let volume = check(&self.caster, scene)?;
        control.check()?;
        control.run(|| volume.warm(self.caster.filter_of(scene)));
        self.engine = control.run(|| Engine::new(&self.caster, scene, volume, Some((&self.scene, &self.engine))))?;
        let then = &self.scene;
        let same = then.volume.same(&scene.volume) && then.filter == scene.filter && then.transfer == scene.transfer;
        if !same {
            self.coherence = control.run(|| coherence(&self.caster, scene, volume, &self.engine));
        }
        self.scene = scene.clone();
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        // Taken out for the while, so that the rest can be shared.
        let mut coherence = self.coherence.take();
        let rendered = match &self.engine {
            Engine::Plain(Kernel::F32(instruments)) => self.render_with(instruments, coherence.as_mut(), view, control),
            Engine::Plain(Kernel::F64(instruments)) => self.render_with(instruments, coherence.as_mut(), view, control),
            Engine::Promise(promise) => self.render_promised(promise, view, control),
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
fn coherence(caster: &RayCaster, scene: &Scene, volume: &UniformVolume, engine: &Engine) -> Option<CoherenceBuffer> {
    match engine {
        Engine::Plain(kernel) if caster.screen == Screen::Coherent => {
            Some(CoherenceBuffer::new(volume, caster.filter_of(scene), kernel.sight()))
        }
        _ => None,
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
    if let Some(what) = beyond_screen(caster, scene) {
        return Err(unsupported(what));
    }
    if caster.rule == Rule::Exact {
        if !scene.compositing.integrates_light() {
            return Err(unsupported(format!("compositing '{}' by the rule 'exact'", scene.compositing.name())));
        }
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

/// What this caster's screen has no answer to.
fn beyond_screen(caster: &RayCaster, scene: &Scene) -> Option<String> {
    let compositing = format!("compositing '{}'", scene.compositing.name());
    let filter = caster.filter_of(scene);
    let uneven = !matches!(caster.step, Step::Uniform(_)) || caster.traversal != Traversal::Samples;
    let uneven = uneven.then_some("steps that are not all of one length".to_owned());
    let found = match caster.screen {
        Screen::EveryPixel => vec![],
        // A promise for each pixel is none for what lies between them.
        Screen::Adaptive { .. } => {
            vec![matches!(caster.step, Step::Tolerance(_)).then_some("a promised error".to_owned())]
        }
        Screen::Coherent => vec![
            (!scene.compositing.integrates_light()).then_some(compositing),
            uneven,
            // What a table of segments shows cannot be told from the values at their ends.
            (!matches!(caster.rule, Rule::Midpoint | Rule::Left)).then(|| format!("the rule '{}'", caster.rule.name())),
        ],
        Screen::Template { connectivity } => {
            let own_values = connectivity == Connectivity::Discrete && filter == Filter::Nearest;
            vec![
                (scene.compositing != Compositing::Over).then_some(compositing),
                scene.shading.is_some().then_some("shading".to_owned()),
                (!own_values && filter != Filter::Trilinear).then(|| format!("the filter '{filter}'")),
                (caster.order == Order::BackToFront).then_some("compositing back to front".to_owned()),
                uneven,
                (caster.rule != Rule::Midpoint).then(|| format!("the rule '{}'", caster.rule.name())),
                (caster.precision == Precision::F64).then_some("64-bit precision".to_owned()),
                (caster.classification == Classification::Exact).then_some("exact classification".to_owned()),
            ]
        }
    };
    let what = found.into_iter().flatten().next()?;
    Some(format!("{what} with the screen '{}'", caster.screen.name()))
}

impl PreparedCaster {
    /// Draws by a template.
    fn render_template<R: Real>(
        &self,
        connectivity: Connectivity,
        instruments: &Instruments<R>,
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
        let most = match instruments.brightest() {
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

    /// Draws as a promised error asks for.
    fn render_promised(&self, promise: &Promise, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let volume = check(&self.caster, &self.scene)?;
        let single = self.caster.precision == Precision::F32;
        let tracer = Promised { promise, volume, view, rays: Rays::new(view)?, single };
        let step = self.caster.world_step(volume);
        Stage { screen: self.caster.screen, coherence: None, volume, step, view, control }.draw(&tracer)
    }

    /// Chooses the operator: once a frame.
    fn render_with<R: Real>(
        &self,
        instruments: &Instruments<R>,
        coherence: Option<&mut CoherenceBuffer>,
        view: &View,
        control: &Control,
    ) -> Result<Rendered, RenderError> {
        if let Screen::Template { connectivity } = self.caster.screen {
            return self.render_template(connectivity, instruments, view, control);
        }
        let volume = check(&self.caster, &self.scene)?;
        let step = self.caster.world_step(volume);
        let stage = Stage { screen: self.caster.screen, coherence, volume, step, view, control };
        if let Some(engine) = &instruments.vector {
            let frame = LocalFrame { engine, volume, rays: Rays::new(view)?, view };
            return stage.draw(&frame);
        }
        let transfer = || Arc::clone(&self.scene.transfer);
        let calibration = volume.calibration();
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
        self.stage.draw(&pipeline)
    }
}
