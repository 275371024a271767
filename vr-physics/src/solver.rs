//! State that the rays of a view share: the source of the field, and the queries to it.

use std::sync::Arc;

use vr_core::field::FieldLine;
use vr_core::filter::{Nearest, Reconstruction, Trilinear};
use vr_core::image_order::ImageSample;
use vr_core::{
    ColorGrid, Compositing, Control, Counts, Feature, Field, Filter, GradientMethod, GridVolume, IndexRay, Layer,
    Light, Model, Ray, RenderError, Sampler, SamplerVisitor, Scene, Shading, Unsupported, View, Volume, Voxel,
};

use crate::colored_line::ColoredLine;
use crate::exact_ray::{ExactPlacement, ExactRay, ExactRays, IndexChord};
use crate::grid_line::{GradientSource, GridLine};
use crate::model_solvers::{integrate_continuous, sum_segments};
use crate::optics::Optics;
use crate::reference::Pixel;
use crate::segments::{RaySegment, segments};
use crate::transport::{Transport, transport};
use crate::value_operators;

/// Everything that the rays of a view share.
pub(crate) struct Solver<'a> {
    tolerance: f64,
    scene: &'a Scene,
    view: &'a View,
    model: &'a Model,
    rays: ExactRays,
    layer: Option<Layer>,
    source: Source<'a>,
    /// Shading by which gradients are found, where any are wanted.
    shading: Option<Arc<Shading>>,
}

/// The source of a field along a ray.
// There is one for each view.
#[expect(clippy::large_enum_variant)]
enum Source<'a> {
    Grid(Arc<GridVolume>, ExactPlacement, Option<Arc<ColorGrid>>),
    Field(&'a dyn Field),
    /// No field: the renderer's model is integrated.
    Model,
}

fn unsupported(feature: Feature, what: String) -> RenderError {
    Unsupported { renderer: "physics", feature, what }.into()
}

/// Checks that a scene, or a renderer's model of it, can be solved.
pub(crate) fn check(scene: &Scene, model: &Model) -> Result<(), RenderError> {
    scene.validate()?;
    scene.without_scattering("physics")?;
    match (model, scene.volume.field()) {
        (Model::Filtered(_), Some(field)) => {
            let what = format!("a reconstruction filter over volumes of the kind '{}'", field.kind());
            Err(unsupported(Feature::Filter, what))
        }
        (Model::Canonical, Some(field)) if scene.shading.is_some() && !field.has_gradient() => {
            let what = format!("shading of volumes of the kind '{}', which have no gradient", field.kind());
            Err(unsupported(Feature::Shading, what))
        }
        (Model::Canonical, Some(field)) if scene.transfer.has_rows() && !field.has_gradient() => {
            let kind = field.kind();
            let what = format!("transfer functions by gradient of volumes of the kind '{kind}', which have none");
            Err(unsupported(Feature::GradientOpacity, what))
        }
        _ => Ok(()),
    }
}

impl<'a> Solver<'a> {
    pub(crate) fn new(tolerance: f64, scene: &'a Scene, view: &'a View, model: &'a Model) -> Result<Self, RenderError> {
        check(scene, model)?;
        let grid = |volume: Arc<GridVolume>, colors: Option<Arc<ColorGrid>>| {
            volume.prepare_derived();
            let placement = ExactPlacement::new(volume.placement(), volume.dims());
            Source::Grid(volume, placement, colors)
        };
        let colored = |colors: Arc<ColorGrid>| grid(Arc::clone(colors.values()), Some(colors));
        let field = |field: &'a dyn Field| {
            field.prepare_derived();
            Source::Field(field)
        };
        let source = match (model, &scene.volume) {
            (Model::Continuous(_) | Model::Discrete(_), _) => Source::Model,
            (Model::Canonical, Volume::Grid(volume)) => grid(Arc::clone(volume), None),
            (Model::Filtered(filter), Volume::Grid(volume)) => grid(Arc::new(volume.with_filter(*filter)), None),
            (Model::Canonical, Volume::Color(colors)) => colored(Arc::clone(colors)),
            (Model::Filtered(filter), Volume::Color(colors)) => colored(Arc::new(colors.with_filter(*filter))),
            (Model::Canonical, Volume::Points(points)) => field(&**points),
            (Model::Canonical, Volume::Cells(mesh)) => field(&**mesh),
            (Model::Canonical, Volume::Rectilinear(grid)) => field(&**grid),
            (Model::Canonical, Volume::Amr(grid)) => field(&**grid),
            (Model::Canonical, Volume::Field(any)) => field(&**any),
            _ => return Err(unsupported(Feature::Model, format!("the model {model:?}"))),
        };
        let rays = ExactRays::new(view)?;
        let shading = scene.gradient_shading();
        Ok(Self { tolerance, scene, view, model, rays, layer: None, source, shading })
    }

    /// Returns the solver with the layer of the scene's surfaces.
    pub(crate) fn with_surfaces(self, control: &Control) -> Result<Self, RenderError> {
        Ok(Self { layer: self.scene.layer(self.view, control)?, ..self })
    }

    /// Answers a query of a ray up to the world distance `far`; with it, the world distance that the ray's distances are counted from. `None`
    /// where the ray meets nothing.
    pub(crate) fn ask(&self, ray: &Ray, far: f64, query: RayQuery<'_>) -> Option<(RayResult, f64)> {
        self.ask_exactly(ray, &ExactRay::from(ray), far, query)
    }

    /// The same for a ray and the one that it was rounded from. Scattered points bound the displacement by rounding themselves.
    fn ask_exactly(&self, ray: &Ray, exact: &ExactRay, far: f64, query: RayQuery<'_>) -> Option<(RayResult, f64)> {
        match &self.source {
            Source::Grid(volume, placement, colors) => {
                let clip = &self.view.clip;
                let rounded = || IndexRay::new(ray, volume.placement(), volume.dims(), clip, far);
                let chord = placement.chord(exact, clip, far, rounded)?;
                let grid_ray =
                    GridRay { solver: self, volume, colors: colors.as_deref(), placement, ray, chord, query };
                Some((volume.with_sampler(grid_ray), chord.ray.offset))
            }
            Source::Field(field) => {
                let line = field.along(ray, &self.view.clip, far, self.shading.is_some())?;
                Some((self.answer(&*line, &self.optics(ray), query), line.chord().offset))
            }
            Source::Model => None,
        }
    }

    /// Transfer function and shading as a ray meets them.
    fn optics(&self, ray: &Ray) -> Optics<'_> {
        // Nothing is lit by lights where no shading is asked for.
        let lights: &[Light] = if self.scene.shading.is_some() { &self.scene.lights } else { &[] };
        Optics::new(&self.scene.transfer, self.shading.as_deref().map(|s| (s, s.along(lights, ray.direction))))
    }

    fn answer(&self, line: &dyn FieldLine, optics: &Optics<'_>, query: RayQuery<'_>) -> RayResult {
        match query {
            RayQuery::Transport(level) => RayResult::Transport(transport(line, optics, self.tolerance, level)),
            RayQuery::Pick(compositing) => RayResult::Pixel(pick(line, optics, compositing)),
            RayQuery::Segments(cuts) => {
                let level = level(self.scene.compositing);
                RayResult::Segments(segments(line, optics, self.tolerance, level, cuts))
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
        let query = match level(self.scene.compositing) {
            Some(level) => RayQuery::Transport(level),
            None => RayQuery::Pick(self.scene.compositing),
        };
        let exact = self.rays.at(spot.x, spot.y);
        let Some((answer, offset)) = self.ask_exactly(ray, &exact, far, query) else { return Pixel::EMPTY };
        counts.rays += 1;
        match answer {
            RayResult::Transport(t) => {
                counts.samples += t.pieces;
                Pixel::emitted(&t, offset)
            }
            RayResult::Pixel(p) => Pixel { depth: p.depth + offset, ..p },
            RayResult::Segments(_) => unreachable!("asked for a pixel"),
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

/// A query of one ray.
pub(crate) enum RayQuery<'a> {
    Transport(f64),
    Pick(Compositing),
    /// The segments, with further cuts.
    Segments(&'a [f64]),
}

/// The result of a [`RayQuery`].
pub(crate) enum RayResult {
    Transport(Transport),
    Pixel(Pixel),
    Segments(Vec<RaySegment>),
}

/// A query of a ray through a grid, for the sampler that the grid's type and filter select.
struct GridRay<'a> {
    solver: &'a Solver<'a>,
    volume: &'a GridVolume,
    colors: Option<&'a ColorGrid>,
    placement: &'a ExactPlacement,
    ray: &'a Ray,
    chord: IndexChord,
    query: RayQuery<'a>,
}

impl SamplerVisitor for GridRay<'_> {
    type Output = RayResult;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> RayResult {
        let Self { solver, volume, colors, placement, chord, .. } = self;
        let optics = solver.optics(self.ray);
        let at_sample = |index: [usize; 3]| volume.central_differences_at_sample(index);
        let source = match solver.shading.as_ref().map(|s| s.gradient) {
            None => GradientSource::None,
            Some(GradientMethod::Analytic) => GradientSource::Analytic,
            Some(GradientMethod::CentralDifferences) => GradientSource::Samples(&at_sample),
        };
        let line = GridLine::along(volume.calibration(), placement, sampler, chord, source);
        match colors {
            None => solver.answer(&line, &optics, self.query),
            Some(colors) if colors.color_filter() == Filter::Nearest => {
                let line = ColoredLine::<_, _, Nearest>::new(line, colors, placement, chord);
                solver.answer(&line, &optics, self.query)
            }
            Some(colors) => {
                let line = ColoredLine::<_, _, Trilinear>::new(line, colors, placement, chord);
                solver.answer(&line, &optics, self.query)
            }
        }
    }
}

fn pick(line: &dyn FieldLine, optics: &Optics<'_>, compositing: Compositing) -> Pixel {
    let picked = match compositing {
        Compositing::First { threshold } => {
            let first = value_operators::first(line, threshold);
            let (rgba, certainty) = first.pixel(optics);
            let depth = first.hit.map_or(f64::INFINITY, |h| h.s);
            return Pixel { rgba, depth, certainty };
        }
        Compositing::Maximum => value_operators::extreme(line, 1.0),
        Compositing::Minimum => value_operators::extreme(line, -1.0),
        Compositing::Average => value_operators::average(line),
        Compositing::Over | Compositing::Accumulate { .. } => unreachable!("integrated"),
    };
    picked.map_or(Pixel::EMPTY, |p| {
        let (rgba, certainty) = p.pixel(optics.transfer);
        Pixel { rgba, depth: p.s, certainty }
    })
}
