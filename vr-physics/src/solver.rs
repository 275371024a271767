//! What the rays of a view share: where the field comes from, and what is asked of it.

use std::sync::Arc;

use vr_core::filter::{Lattice, Reconstruction};
use vr_core::image_order::ImageSample;
use vr_core::{
    Compositing, Control, Counts, Feature, Field, GradientMethod, GridVolume, IndexRay, LatticeVisitor, Layer, Model,
    Ray, RenderError, Sampler, SamplerVisitor, Scene, Unsupported, View, Volume, Voxel, gradient_at_sample,
};

use crate::exact_ray::{ExactPlacement, ExactRay, ExactRays, IndexChord};
use crate::grid_line::{GradientSource, GridLine};
use crate::model_solvers::{integrate_continuous, sum_segments};
use crate::optics::Optics;
use crate::picks;
use crate::reference::Pixel;
use crate::segments::{RaySegment, segments};
use crate::transport::{Transport, transport};
use vr_core::field::FieldLine;

/// Everything that the rays of a view share.
pub(crate) struct Solver<'a> {
    tolerance: f64,
    scene: &'a Scene,
    view: &'a View,
    model: &'a Model,
    rays: ExactRays,
    layer: Option<Layer>,
    source: Source<'a>,
}

/// What a field along a ray comes from.
// There is one for each view.
#[expect(clippy::large_enum_variant)]
enum Source<'a> {
    Grid(Arc<GridVolume>, ExactPlacement),
    Field(&'a dyn Field),
    /// From nothing here: the renderer's model says it all.
    Model,
}

fn unsupported(feature: Feature, what: String) -> RenderError {
    Unsupported { renderer: "physics", feature, what }.into()
}

/// Checks that a scene, or a renderer's model of it, can be solved.
pub(crate) fn check(scene: &Scene, model: &Model) -> Result<(), RenderError> {
    scene.validate()?;
    match (model, scene.volume.field()) {
        (Model::Filtered(_), Some(field)) => {
            let what = format!("a reconstruction filter over volumes of the kind '{}'", field.kind());
            Err(unsupported(Feature::Filter, what))
        }
        (Model::Canonical, Some(field)) if scene.shading.is_some() && !field.has_gradient() => {
            let what = format!("shading of volumes of the kind '{}', which have no gradient", field.kind());
            Err(unsupported(Feature::Shading, what))
        }
        _ => Ok(()),
    }
}

impl<'a> Solver<'a> {
    pub(crate) fn new(tolerance: f64, scene: &'a Scene, view: &'a View, model: &'a Model) -> Result<Self, RenderError> {
        check(scene, model)?;
        let grid = |volume: Arc<GridVolume>| {
            volume.prepare_derived();
            let placement = ExactPlacement::new(volume.placement(), volume.dims());
            Source::Grid(volume, placement)
        };
        let field = |field: &'a dyn Field| {
            field.prepare_derived();
            Source::Field(field)
        };
        let source = match (model, &scene.volume) {
            (Model::Continuous(_) | Model::Discrete(_), _) => Source::Model,
            (Model::Canonical, Volume::Grid(volume)) => grid(Arc::clone(volume)),
            (Model::Filtered(filter), Volume::Grid(volume)) => grid(Arc::new(volume.with_filter(*filter))),
            (Model::Canonical, Volume::Points(points)) => field(&**points),
            (Model::Canonical, Volume::Field(any)) => field(&**any),
            _ => return Err(unsupported(Feature::Model, format!("the model {model:?}"))),
        };
        let rays = ExactRays::new(view)?;
        Ok(Self { tolerance, scene, view, model, rays, layer: None, source })
    }

    /// The same with the scene's surfaces.
    pub(crate) fn with_surfaces(self, control: &Control) -> Result<Self, RenderError> {
        Ok(Self { layer: self.scene.layer(self.view, control)?, ..self })
    }

    /// What is wanted of a ray up to the world distance `far`, and the world distance that its distances are counted from; `None` where it
    /// meets nothing.
    pub(crate) fn ask(&self, ray: &Ray, far: f64, want: Want<'_>) -> Option<(Answer, f64)> {
        self.ask_exactly(ray, &ExactRay::from(ray), far, want)
    }

    /// The same of a ray and the one that it was rounded from. Scattered points know how far rounding displaces them.
    fn ask_exactly(&self, ray: &Ray, exact: &ExactRay, far: f64, want: Want<'_>) -> Option<(Answer, f64)> {
        match &self.source {
            Source::Grid(volume, placement) => {
                let clip = &self.view.clip;
                let rounded = || IndexRay::new(ray, volume.placement(), volume.dims(), clip, far);
                let chord = placement.chord(exact, clip, far, rounded)?;
                let job = Job { solver: self, volume, placement, ray, chord, want };
                Some((volume.with_sampler(job), chord.ray.offset))
            }
            Source::Field(field) => {
                let Scene { transfer, shading, lights, .. } = self.scene;
                let line = field.along(ray, &self.view.clip, far, shading.is_some())?;
                let shading = shading.as_deref().map(|s| (s, s.along(lights, ray.direction)));
                Some((self.answer(&*line, &Optics::new(transfer, shading), want), line.chord().offset))
            }
            Source::Model => None,
        }
    }

    fn answer(&self, line: &dyn FieldLine, optics: &Optics<'_>, want: Want<'_>) -> Answer {
        match want {
            Want::Transport(level) => Answer::Transport(transport(line, optics, self.tolerance, level)),
            Want::Pick(compositing) => Answer::Pixel(pick(line, optics, compositing)),
            Want::Segments(cuts) => {
                let level = level(self.scene.compositing);
                Answer::Segments(segments(line, optics, self.tolerance, level, cuts))
            }
        }
    }

    pub(crate) fn pixel(&self, ray: &Ray, spot: ImageSample, counts: &mut Counts) -> Pixel {
        let far = self.layer.as_ref().map_or(f64::INFINITY, |l| l.depth(spot.pixel));
        let mut pixel = self.volume_pixel(ray, spot, far, counts);
        if let Some(layer) = &self.layer {
            pixel.rgba = layer.under(spot.pixel, pixel.rgba);
            pixel.depth = pixel.depth.min(far);
        }
        pixel
    }

    fn volume_pixel(&self, ray: &Ray, spot: ImageSample, far: f64, counts: &mut Counts) -> Pixel {
        match self.model {
            Model::Discrete(m) => return Pixel::emitted(&sum_segments(&m.segments(spot.x, spot.y)), 0.0),
            Model::Continuous(m) => return Pixel::emitted(&integrate_continuous(&**m, ray), 0.0),
            _ => {}
        }
        let want = match level(self.scene.compositing) {
            Some(level) => Want::Transport(level),
            None => Want::Pick(self.scene.compositing),
        };
        let exact = self.rays.at(spot.x, spot.y);
        let Some((answer, offset)) = self.ask_exactly(ray, &exact, far, want) else { return Pixel::EMPTY };
        counts.rays += 1;
        match answer {
            Answer::Transport(t) => {
                counts.samples += t.pieces;
                Pixel::emitted(&t, offset)
            }
            Answer::Pixel(p) => Pixel { depth: p.depth + offset, ..p },
            Answer::Segments(_) => unreachable!("asked for a pixel"),
        }
    }
}

/// The opacity at which light ends (1: never); `None` where a compositing integrates no light.
pub(crate) fn level(compositing: Compositing) -> Option<f64> {
    match compositing {
        Compositing::Over => Some(1.0),
        Compositing::Accumulate { level } => Some(level),
        _ => None,
    }
}

/// What is asked of one ray.
pub(crate) enum Want<'a> {
    Transport(f64),
    Pick(Compositing),
    /// With further cuts.
    Segments(&'a [f64]),
}

pub(crate) enum Answer {
    Transport(Transport),
    Pixel(Pixel),
    Segments(Vec<RaySegment>),
}

struct Job<'a> {
    solver: &'a Solver<'a>,
    volume: &'a GridVolume,
    placement: &'a ExactPlacement,
    ray: &'a Ray,
    chord: IndexChord,
    want: Want<'a>,
}

impl SamplerVisitor for Job<'_> {
    type Output = Answer;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Answer {
        let Self { solver: Solver { scene, .. }, volume, placement, .. } = self;
        let shading = scene.shading.as_deref();
        let optics = Optics::new(&scene.transfer, shading.map(|s| (s, s.along(&scene.lights, self.ray.direction))));
        let at_sample = |index: [usize; 3]| volume.with_lattice(SampleGradient(index));
        let source = match shading.map(|s| s.gradient) {
            None => GradientSource::None,
            Some(GradientMethod::Analytic) => GradientSource::Analytic,
            Some(GradientMethod::CentralDifferences) => GradientSource::Samples(&at_sample),
        };
        let line = GridLine::along(volume, placement, sampler, self.chord, source);
        self.solver.answer(&line, &optics, self.want)
    }
}

struct SampleGradient([usize; 3]);

impl LatticeVisitor for SampleGradient {
    type Output = [f64; 3];
    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> [f64; 3] {
        gradient_at_sample(&lattice, self.0)
    }
}

fn pick(line: &dyn FieldLine, optics: &Optics<'_>, compositing: Compositing) -> Pixel {
    let picked = match compositing {
        Compositing::First { threshold } => {
            let first = picks::first(line, threshold);
            let (rgba, certainty) = first.pixel(optics);
            let depth = first.hit.map_or(f64::INFINITY, |h| h.s);
            return Pixel { rgba, depth, certainty };
        }
        Compositing::Maximum => picks::extreme(line, 1.0),
        Compositing::Minimum => picks::extreme(line, -1.0),
        Compositing::Average => picks::average(line),
        Compositing::Over | Compositing::Accumulate { .. } => unreachable!("integrated"),
    };
    picked.map_or(Pixel::EMPTY, |p| {
        let (rgba, certainty) = p.pixel(optics.transfer);
        Pixel { rgba, depth: p.s, certainty }
    })
}
