//! Ray caster that has seen its scene.

use glam::DVec3;
use vr_core::{
    Control, DrawnPixels, Filter, Layer, Model, ParameterError, Prepared, Probe, Rays, Real, RenderError, Rendered,
    Scene, View,
};

use crate::capabilities::{check, check_view};
use crate::caster::{EmptySpace, ImageSampling, Precision, RayCaster, Rule, Step, Traversal};
use crate::engine::Engine;
use crate::error_bound::BoundedRays;
use crate::leap::visibility;
use crate::pace::Pace;
use crate::packet::{
    Choice, LabelFrame, PacketFrame, PatchFrame, PatchPickFrame, PickFrame, PointFrame, PointPickFrame, Trial,
};
use crate::pipeline::Pipeline;
use crate::place_colors::PlaceColors;
use crate::polled_tracer::PolledTracer;
use crate::render_tables::{RenderTables, TablesByPrecision};
use crate::screen::{self, AdaptiveRays};
use crate::source::Source;
use crate::step_map::SHORTEST;
use crate::thin_parts::ThinParts;
use crate::tracer::Tracer;
use crate::walk::{WalkKind, Walks};

/// Ray caster that has seen its scene: the scene, and the engine that draws it.
pub(crate) struct PreparedCaster {
    /// The caster as the user set it.
    asked: RayCaster,
    /// The caster as it draws the scene, with automatic steps settled.
    pub(crate) caster: RayCaster,
    /// The scene, under the filter that the caster samples it with.
    pub(crate) scene: Scene,
    pub(crate) source: Source,
    /// Filter of the caster, where it is not the scene's.
    filtered: Option<Filter>,
    pub(crate) engine: Engine,
    /// Parts of a grid that adaptive rays may miss; found when the first picture asks for them.
    thin_parts: Option<ThinParts>,
    /// Choice of steps and rays, where they are left to the caster and can be chosen for each picture: made when the first large picture asks for it.
    trial: Option<Option<Trial>>,
    /// State that the coherent screens keep from picture to picture.
    #[cfg(feature = "classics")]
    pub(crate) coherence: Option<crate::classics::Coherence>,
}

/// Caster and scene that go together, before anything is made for them.
struct Settled {
    caster: RayCaster,
    scene: Scene,
    source: Source,
    filtered: Option<Filter>,
}

impl Settled {
    /// Checks that a caster can draw a scene, and settles its automatic steps and the filter.
    fn new(asked: &RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let filtered = asked.filter.filter(|filter| scene.volume.filter() != Some(*filter));
        let (caster, scene) = (asked.settled_for(scene), asked.scene_of(scene));
        let source = check(&caster, &scene)?;
        control.check()?;
        control.run(|| scene.volume.prepare_derived());
        Ok(Self { caster, scene, source, filtered })
    }
}

impl PreparedCaster {
    pub(crate) fn new(asked: RayCaster, scene: &Scene, control: &Control) -> Result<Self, RenderError> {
        let Settled { caster, scene, source, filtered } = Settled::new(&asked, scene, control)?;
        let engine = control.run(|| Engine::new(&caster, &scene, &source, None))?;
        Ok(Self {
            #[cfg(feature = "classics")]
            coherence: control.run(|| crate::classics::Coherence::of(&caster, &scene, source.grid()?, &engine)),
            asked,
            caster,
            scene,
            source,
            filtered,
            engine,
            thin_parts: None,
            trial: None,
        })
    }
}

/// Checks that a view has a pixel.
fn check_pixel(view: &View, pixel: [u32; 2]) -> Result<(), RenderError> {
    if pixel[0] >= view.size[0] || pixel[1] >= view.size[1] {
        return Err(ParameterError::new("pixel", pixel, "must lie in the picture").into());
    }
    Ok(())
}

impl Prepared for PreparedCaster {
    fn update(&mut self, scene: &Scene, control: &Control) -> Result<(), RenderError> {
        let Settled { caster, scene, source, filtered } = Settled::new(&self.asked, scene, control)?;
        self.engine = control.run(|| Engine::new(&caster, &scene, &source, Some((&self.scene, &self.engine))))?;
        #[cfg(feature = "classics")]
        if !crate::classics::Coherence::holds_for(&self.scene, &scene) {
            self.coherence =
                control.run(|| crate::classics::Coherence::of(&caster, &scene, source.grid()?, &self.engine));
        }
        self.trial = None;
        (self.caster, self.scene, self.source, self.filtered) = (caster, scene, source, filtered);
        self.thin_parts = None;
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        check_view(&self.caster, view)?;
        let layer = self.scene.layer(view, control)?;
        let layer = layer.as_ref();
        #[cfg(feature = "classics")]
        if let Some(drawn) = self.draw_by_classic_screen((view, layer), control) {
            return drawn;
        }
        let pixels = view.size.map(u64::from).iter().product();
        let mut threshold = self.caster.adaptive_threshold(pixels);
        let choice = if pixels < ImageSampling::LARGE { None } else { self.choose((view, layer), threshold, control)? };
        let all_are_quicker = choice.as_ref().map(|choice| choice.every_pixel);
        if all_are_quicker == Some(true) && self.asked.image_sampling == ImageSampling::Auto {
            threshold = None;
        }
        if let (Some(_), None, Some(volume)) = (threshold, &self.thin_parts, self.source.grid()) {
            self.thin_parts = Some(control.run(|| ThinParts::new(&self.scene, volume)));
        }
        let rays = threshold.map(|threshold| AdaptiveRays {
            threshold,
            thin_parts: self.thin_parts.as_ref(),
            are_few: all_are_quicker == Some(false),
        });
        let even = choice.and_then(|choice| choice.even);
        let tracer = match &even {
            Some(engine) => self.polled(Box::new(PacketFrame::new(engine, &engine.volume, (view, layer))?)),
            None => self.tracer((view, layer))?,
        };
        screen::draw(rays, tracer.as_ref(), (view, layer), control)
    }

    fn pixels(
        &mut self,
        view: &View,
        pixels: &[[u32; 2]],
        control: &Control,
    ) -> Result<Option<DrawnPixels>, RenderError> {
        check_view(&self.caster, view)?;
        pixels.iter().try_for_each(|&pixel| check_pixel(view, pixel))?;
        if !self.caster.image_sampling.casts_pixels() {
            return Ok(None);
        }
        let layer = self.scene.layer(view, control)?;
        let tracer = self.tracer((view, layer.as_ref()))?;
        screen::some_pixels(tracer.as_ref(), view, pixels, control).map(Some)
    }

    fn model(&self, _: &View) -> Result<Model, RenderError> {
        Ok(self.filtered.map_or(Model::Canonical, Model::Filtered))
    }

    /// Returns `None` for templates, whose rays are not those of pixels, and under an error bound.
    fn probe(&mut self, view: &View, pixel: [u32; 2], control: &Control) -> Result<Option<Probe>, RenderError> {
        view.validate()?;
        check_pixel(view, pixel)?;
        if !self.caster.image_sampling.casts_pixels() {
            return Ok(None);
        }
        control.check()?;
        let layer = self.scene.layer(view, control)?;
        let seen = (view, layer.as_ref());
        // Packets have empty space of their own to leap over: the plain kernel is told only now that it draws, too.
        if let Engine::Packets(engine, kernel) = &mut self.engine {
            control.run(|| kernel.find_empty_space(&self.caster, &self.scene, &engine.volume, None));
        }
        let (kernel, own_kernel) = match &self.engine {
            Engine::Plain(kernel) | Engine::Field(kernel, _) => (kernel, true),
            Engine::Packets(_, kernel)
            | Engine::Picks(_, kernel)
            | Engine::Patches(_, kernel, _)
            | Engine::Points(_, kernel, _)
            | Engine::Labels(_, kernel, _)
            | Engine::PatchPicks(_, kernel, _)
            | Engine::PointPicks(_, kernel, _) => (kernel, false),
            Engine::ErrorBound(_) => return Ok(None),
        };
        control.run(|| match kernel {
            TablesByPrecision::F32(tables) => Ok(Some(self.pipeline(tables, seen)?.probe(pixel, own_kernel))),
            TablesByPrecision::F64(tables) => Ok(Some(self.pipeline(tables, seen)?.probe(pixel, own_kernel))),
        })
    }
}

impl PreparedCaster {
    /// Returns steps and rays for a view, where they are left to the caster and a few rays tell enough; `threshold` is that of adaptive rays.
    fn choose(
        &mut self,
        seen: (&View, Option<&Layer>),
        threshold: Option<f64>,
        control: &Control,
    ) -> Result<Option<Choice>, RenderError> {
        let Self { asked, caster, scene, engine, trial, .. } = self;
        let ((Step::Auto, Rule::Auto), Step::Local { error }, Engine::Packets(local, _)) =
            ((asked.step, asked.rule), caster.step, &*engine)
        else {
            return Ok(None);
        };
        let trial = trial.get_or_insert_with(|| Trial::new(local, scene, caster.rule, error));
        let adaptive = (screen::COARSE, threshold.unwrap_or(f64::INFINITY));
        trial.as_mut().map_or(Ok(None), |trial| trial.choose((local, scene), seen, adaptive, control))
    }

    /// Returns the engine with a view and the surfaces in it.
    pub(crate) fn tracer<'a>(
        &'a self,
        seen @ (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Box<dyn Tracer + 'a>, RenderError> {
        let tracer: Box<dyn Tracer + 'a> = match &self.engine {
            Engine::Picks(engine, TablesByPrecision::F32(tables)) => {
                Box::new(PickFrame::new(engine, self.pipeline(tables, seen)?)?)
            }
            Engine::PatchPicks(engine, TablesByPrecision::F64(tables), _) => {
                Box::new(PatchPickFrame::new(engine, self.pipeline(tables, seen)?))
            }
            Engine::PointPicks(engine, TablesByPrecision::F64(tables), _) => {
                Box::new(PointPickFrame::new(engine, self.pipeline(tables, seen)?)?)
            }
            Engine::Plain(kernel)
            | Engine::Picks(_, kernel)
            | Engine::PatchPicks(_, kernel, _)
            | Engine::PointPicks(_, kernel, _)
            | Engine::Field(kernel, _) => match kernel {
                TablesByPrecision::F32(tables) => Box::new(self.pipeline(tables, seen)?),
                TablesByPrecision::F64(tables) => Box::new(self.pipeline(tables, seen)?),
            },
            Engine::Packets(engine, _) => Box::new(PacketFrame::new(engine, &engine.volume, seen)?),
            Engine::Patches(engine, ..) => Box::new(PatchFrame::new(engine, &self.source, seen)?),
            Engine::Points(engine, ..) => Box::new(PointFrame::new(engine, seen)?),
            Engine::Labels(engine, ..) => Box::new(LabelFrame::new(engine, (&self.scene, &self.source), seen)?),
            Engine::ErrorBound(error_bound) => {
                let single = self.caster.precision == Precision::F32;
                Box::new(BoundedRays {
                    error_bound,
                    view,
                    layer,
                    rays: Rays::new(view)?,
                    single,
                    packets: error_bound.packets(view)?,
                })
            }
        };
        Ok(self.polled(tracer))
    }

    /// Returns a tracer that looks at the cancel flag between a few of its rays and the next.
    fn polled<'a>(&self, tracer: Box<dyn Tracer + 'a>) -> Box<dyn Tracer + 'a> {
        Box::new(PolledTracer::new(tracer, self.max_steps()))
    }

    /// Number of steps that a ray takes at most, about: from corner to corner in the shortest ones.
    fn max_steps(&self) -> f64 {
        let (placement, dims) = (self.source.placement(), self.source.dims());
        let diagonal = placement.axes() * DVec3::from_array(dims.map(|n| (n - 1) as f64));
        let shortest = match self.caster.step {
            Step::Local { .. } => SHORTEST * placement.spacing().min_element(),
            // A voxel where steps have no one length: cells are crossed in few.
            _ => self.caster.world_step(placement),
        };
        diagonal.length() / shortest
    }

    /// Returns the plain engine with a view and the surfaces in it.
    pub(crate) fn pipeline<'a, R: Real>(
        &'a self,
        tables: &'a RenderTables<R>,
        (view, layer): (&'a View, Option<&'a Layer>),
    ) -> Result<Pipeline<'a, R>, RenderError> {
        let Self { caster, scene, source, .. } = self;
        let placement = source.placement();
        Ok(Pipeline {
            scene,
            source,
            colors: PlaceColors::of(&scene.volume, source),
            walks: Walks {
                kind: self.walk_kind(tables),
                step: caster.longest_step(placement),
                voxel: placement.spacing().min_element(),
                dims: source.dims(),
            },
            pace: self.engine.lengths().map(|lengths| {
                let leaps = caster.empty_space != EmptySpace::None;
                let visibility = if leaps { visibility(scene, &tables.classifier) } else { None };
                Pace { lengths: lengths.clone(), visibility }
            }),
            offset: if caster.rule == Rule::Left { 0.0 } else { 0.5 },
            classifier: &tables.classifier,
            shader: tables.shader.as_ref(),
            view,
            layer,
            rays: Rays::new(view)?,
            order: caster.order,
        })
    }

    fn walk_kind<'a, R: Real>(&self, tables: &'a RenderTables<R>) -> WalkKind<'a> {
        #[cfg(feature = "classics")]
        if let Some(kind) = crate::classics::walk_kind(&self.caster, tables) {
            return WalkKind::Classic(kind);
        }
        match &tables.step_map {
            _ if self.caster.traversal == Traversal::Cells => WalkKind::Cells,
            Some(map) => WalkKind::Local(map),
            None => WalkKind::Lattice(tables.empty_space.as_deref()),
        }
    }
}
