//! The reference renderer: every pixel in f64, with a bound.

use std::sync::Arc;

use vr_core::filter::Reconstruction;
use vr_core::image_order::{PixelValue, Spot, trace_pixels, trace_view};
use vr_core::{
    Compositing, Control, Counts, Filter, Frame, Geometry, GradientMethod, IndexRay, Model, NamedSetting, OptionError,
    OptionKind, OptionSpec, OptionValue, Options, PointSet, Prepared, Ray, RenderError, RenderStats, Rendered,
    Renderer, Sampler, SamplerVisitor, Scene, UniformVolume, View, Voxel, gradient_at_sample,
};

use crate::grid_line::{GradientSource, GridLine};
use crate::line::{LineField, RayField};
use crate::model_solvers::{integrate_continuous, sum_segments};
use crate::optics::Optics;
use crate::picks;
use crate::point_line::PointLine;
use crate::segments::{RaySegment, segments};
use crate::transport::{Certainty, Transport, transport};

/// Solves the equation of transfer for every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    tolerance: f64,
    options: Vec<OptionSpec>,
}

/// The default tolerance, relative to max(1, the picture's largest magnitude).
pub const DEFAULT_TOLERANCE: f64 = 1e-10;
/// The smallest tolerance: rounding is not far below.
pub const LEAST_TOLERANCE: f64 = 1e-13;

impl Default for Reference {
    fn default() -> Self {
        Self::new(DEFAULT_TOLERANCE)
    }
}

/// A solved picture, or some pixels of one.
#[derive(Clone, Debug)]
pub struct Solution {
    /// One entry per pixel asked for.
    pub pixels: Vec<Pixel>,
    /// The work done; `samples` counts stretches integrated.
    pub counts: Counts,
}

impl Solution {
    /// The largest error of any pixel.
    pub fn certainty(&self) -> Certainty {
        let worst = Certainty::Bound(0.0);
        self.pixels.iter().fold(worst, |w, p| w.and(p.certainty, w.value().max(p.certainty.value())))
    }
}

/// A pixel in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Premultiplied linear RGBA, without the background.
    pub rgba: [f64; 4],
    /// World distance along the ray to what is seen; +∞ where there is nothing.
    pub depth: f64,
    /// How far any component of `rgba` may be from the truth.
    pub certainty: Certainty,
}

impl Pixel {
    pub(crate) const EMPTY: Self = Self { rgba: [0.0; 4], depth: f64::INFINITY, certainty: Certainty::Bound(0.0) };

    /// The pixel of a ray's light; the ray's distances begin `offset` behind its origin.
    pub(crate) fn emitted(t: &Transport, offset: f64) -> Self {
        let [r, g, b] = t.radiance;
        Self { rgba: [r, g, b, t.opacity()], depth: t.half_way + offset, certainty: t.certainty }
    }
}

impl PixelValue for Pixel {
    fn mean(values: &[Self]) -> Self {
        let n = values.len() as f64;
        let mut mean = Self::EMPTY;
        let mut error = 0.0;
        for v in values {
            for c in 0..4 {
                mean.rgba[c] += v.rgba[c] / n;
            }
            error += v.certainty.value() / n;
            mean.certainty = mean.certainty.and(v.certainty, error);
            mean.depth = mean.depth.min(v.depth);
        }
        let size = mean.rgba.into_iter().fold(0.0, f64::max);
        mean.certainty = mean.certainty.and(mean.certainty, error + 2.0 * n * f64::EPSILON * size);
        mean
    }
}

impl Reference {
    /// A reference of the given tolerance (at least [`LEAST_TOLERANCE`]).
    pub fn new(tolerance: f64) -> Self {
        let options = vec![OptionSpec {
            key: "tolerance",
            kind: OptionKind::Number { above: 0.0, most: 1e-2 },
            default: OptionValue::Number(DEFAULT_TOLERANCE),
            help: "largest error of a pixel, relative to max(1, the picture's largest magnitude); 1e-13 at the least",
        }];
        Self { tolerance: tolerance.max(LEAST_TOLERANCE), options }
    }

    /// The tolerance.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Solves all pixels of a view, row by row: the scene as it is ([`Model::Canonical`]), or what a renderer makes of it.
    ///
    /// # Errors
    /// A view or scene that makes no sense, a volume of a kind that is not known here, or cancellation.
    pub fn solve(&self, scene: &Scene, view: &View, model: &Model, control: &Control) -> Result<Solution, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, model)?;
        let (pixels, counts) =
            trace_view(view, control, || (), |(), ray, spot, counts| solver.pixel(ray, spot, counts))?;
        Ok(Solution { pixels, counts })
    }

    /// Solves some pixels only, in the order given.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn solve_pixels(
        &self,
        scene: &Scene,
        view: &View,
        model: &Model,
        pixels: &[[u32; 2]],
        control: &Control,
    ) -> Result<Solution, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, model)?;
        let trace = |(): &mut (), ray: &Ray, spot: Spot, counts: &mut Counts| solver.pixel(ray, spot, counts);
        let (pixels, counts) = trace_pixels(view, pixels, control, || (), trace)?;
        Ok(Solution { pixels, counts })
    }

    /// Light and optical depth along one ray through a scene under emission and absorption; `None` where it misses the volume.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn transport(&self, scene: &Scene, view: &View, ray: &Ray) -> Result<Option<Transport>, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, &Model::Canonical)?;
        match solver.ask(ray, f64::INFINITY, Want::Transport(1.0)) {
            None => Ok(None),
            Some((Answer::Transport(t), _)) => Ok(Some(t)),
            _ => unreachable!("asked for transport"),
        }
    }

    /// One ray through a scene, front to back, cut at every cell face, wherever its value crosses a knot of the transfer function, and
    /// at the world distances `cuts` along it (those outside the volume are left out): each part, and the ray up to its end, solved.
    /// Nothing for a ray that misses the volume.
    ///
    /// The last running sum is the pixel that [`solve`](Self::solve) finds for this ray, to what both may be off by.
    ///
    /// # Errors
    /// As [`solve`](Self::solve).
    pub fn segments(
        &self,
        scene: &Scene,
        view: &View,
        ray: &Ray,
        cuts: &[f64],
    ) -> Result<Vec<RaySegment>, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, &Model::Canonical)?;
        match solver.ask(ray, f64::INFINITY, Want::Segments(cuts)) {
            None => Ok(Vec::new()),
            Some((Answer::Segments(all), _)) => Ok(all),
            _ => unreachable!("asked for segments"),
        }
    }
}

/// Everything that the rays of a view share.
struct Solver<'a> {
    tolerance: f64,
    scene: &'a Scene,
    view: &'a View,
    model: &'a Model,
    source: Source<'a>,
}

/// What a field along a ray comes from.
#[derive(Clone, Copy)]
enum Source<'a> {
    Grid(&'a UniformVolume, Filter),
    Points(&'a PointSet),
    /// From nothing here: the renderer's model says it all.
    Model,
}

impl<'a> Solver<'a> {
    fn new(tolerance: f64, scene: &'a Scene, view: &'a View, model: &'a Model) -> Result<Self, RenderError> {
        scene.validate()?;
        let unsupported = |feature: String| RenderError::Unsupported { renderer: "physics", feature };
        let grid = |volume: &'a UniformVolume, filter| {
            volume.warm(filter);
            Source::Grid(volume, filter)
        };
        let source = match (model, scene.volume.geometry()) {
            (Model::Continuous(_) | Model::Discrete(_), _) => Source::Model,
            (Model::Canonical, Geometry::Uniform(volume)) => grid(volume, scene.filter),
            (Model::Filtered(filter), Geometry::Uniform(volume)) => grid(volume, *filter),
            (Model::Canonical, Geometry::Points(points)) => {
                if scene.shading.is_some() {
                    return Err(unsupported("shading of scattered points".to_owned()));
                }
                points.warm();
                Source::Points(points)
            }
            (Model::Filtered(_), Geometry::Points(_)) => {
                return Err(unsupported("a reconstruction filter over scattered points".to_owned()));
            }
            (Model::Canonical | Model::Filtered(_), _) => {
                return Err(unsupported(format!("a volume of kind {}", scene.volume.kind())));
            }
            _ => return Err(unsupported(format!("the model {model:?}"))),
        };
        Ok(Self { tolerance, scene, view, model, source })
    }

    /// What is wanted of a ray up to the world distance `far`, and the world distance that its distances are counted from; `None` where it
    /// meets nothing.
    fn ask(&self, ray: &Ray, far: f64, want: Want<'_>) -> Option<(Answer, f64)> {
        match self.source {
            Source::Grid(volume, filter) => {
                let index_ray = IndexRay::new(ray, volume.placement(), volume.dims(), &self.view.clip, far)?;
                let job = Job { solver: self, volume, ray, index_ray, want };
                Some((volume.with_sampler(filter, job), index_ray.offset))
            }
            Source::Points(points) => {
                let line = PointLine::new(points, ray, &self.view.clip, far)?;
                Some((self.answer(&line, &Optics::new(&self.scene.transfer, None), want), line.offset()))
            }
            Source::Model => None,
        }
    }

    fn answer(&self, line: &dyn RayField, optics: &Optics<'_>, want: Want<'_>) -> Answer {
        match want {
            Want::Transport(level) => Answer::Transport(transport(line, optics, self.tolerance, level)),
            Want::Pick(compositing) => Answer::Pixel(pick(line, optics, compositing)),
            Want::Segments(cuts) => {
                let level = level(self.scene.compositing);
                Answer::Segments(segments(line, optics, self.tolerance, level, cuts))
            }
        }
    }

    fn pixel(&self, ray: &Ray, spot: Spot, counts: &mut Counts) -> Pixel {
        let far = self.view.layer.as_ref().map_or(f64::INFINITY, |l| l.depth(spot.pixel));
        let mut pixel = self.volume_pixel(ray, spot, far, counts);
        if let Some(layer) = &self.view.layer {
            pixel.rgba = layer.under(spot.pixel, pixel.rgba);
            pixel.depth = pixel.depth.min(far);
        }
        pixel
    }

    fn volume_pixel(&self, ray: &Ray, spot: Spot, far: f64, counts: &mut Counts) -> Pixel {
        match self.model {
            Model::Discrete(m) => return Pixel::emitted(&sum_segments(&m.segments(spot.x, spot.y)), 0.0),
            Model::Continuous(m) => return Pixel::emitted(&integrate_continuous(&**m, ray), 0.0),
            _ => {}
        }
        let want = match level(self.scene.compositing) {
            Some(level) => Want::Transport(level),
            None => Want::Pick(self.scene.compositing),
        };
        let Some((answer, offset)) = self.ask(ray, far, want) else { return Pixel::EMPTY };
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
enum Want<'a> {
    Transport(f64),
    Pick(Compositing),
    /// With further cuts.
    Segments(&'a [f64]),
}

enum Answer {
    Transport(Transport),
    Pixel(Pixel),
    Segments(Vec<RaySegment>),
}

struct Job<'a> {
    solver: &'a Solver<'a>,
    volume: &'a UniformVolume,
    ray: &'a Ray,
    index_ray: IndexRay,
    want: Want<'a>,
}

impl SamplerVisitor for Job<'_> {
    type Output = Answer;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Answer {
        let Self { solver: Solver { scene, .. }, volume, .. } = self;
        let shading = scene.shading.as_deref();
        let optics = Optics::new(&scene.transfer, shading.map(|s| (s, s.along(self.ray.direction))));
        let at_sample = |index: [usize; 3]| volume.with_lattice(SampleGradient(index));
        let source = match shading.map(|s| s.gradient) {
            None => GradientSource::None,
            Some(GradientMethod::Analytic) => GradientSource::Analytic,
            Some(GradientMethod::CentralDifferences) => GradientSource::Samples(&at_sample),
        };
        let line = GridLine::new(volume, sampler, self.index_ray, source);
        self.solver.answer(&line, &optics, self.want)
    }
}

struct SampleGradient([usize; 3]);

impl vr_core::LatticeVisitor for SampleGradient {
    type Output = [f64; 3];
    fn visit<T: Voxel>(self, lattice: vr_core::filter::Lattice<'_, T>) -> [f64; 3] {
        gradient_at_sample(&lattice, self.0)
    }
}

fn pick(line: &dyn LineField, optics: &Optics<'_>, compositing: Compositing) -> Pixel {
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

impl Renderer for Reference {
    fn name(&self) -> &'static str {
        "physics"
    }

    fn options(&self) -> &[OptionSpec] {
        &self.options
    }

    fn configure(&self, options: &Options) -> Result<Box<dyn Renderer>, OptionError> {
        let mut tolerance = self.tolerance;
        for (_, value) in options.check(self.name(), &self.options)? {
            if let OptionValue::Number(x) = value {
                tolerance = *x;
            }
        }
        Ok(Box::new(Self::new(tolerance)))
    }

    fn settings(&self) -> Vec<NamedSetting> {
        // Others take the same time: bounds are found beforehand, and most pieces fit any of them.
        vec![NamedSetting {
            name: format!("tolerance {DEFAULT_TOLERANCE:e}"),
            options: Options::new().with("tolerance", DEFAULT_TOLERANCE),
            order: None,
            // The frame is f32.
            error_floor: f64::from(f32::EPSILON),
        }]
    }

    fn hard_case_error(&self, _case: &str) -> Option<f64> {
        // The picture is f32.
        Some(self.tolerance + f64::from(f32::EPSILON))
    }

    fn prepare(&self, scene: &Scene, _control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        scene.validate()?;
        match scene.volume.geometry() {
            Geometry::Uniform(volume) => volume.warm(scene.filter),
            Geometry::Points(points) => points.warm(),
            _ => {}
        }
        Ok(Box::new(PreparedReference { reference: self.clone(), scene: Arc::new(scene.clone()) }))
    }
}

struct PreparedReference {
    reference: Reference,
    scene: Arc<Scene>,
}

impl Prepared for PreparedReference {
    fn update(&mut self, scene: &Scene, _control: &Control) -> Result<(), RenderError> {
        scene.validate()?;
        self.scene = Arc::new(scene.clone());
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let mut stats = RenderStats::default();
        let solution = stats.time("rays", || self.reference.solve(&self.scene, view, &Model::Canonical, control))?;
        stats.counts = solution.counts;
        let pixels = solution.pixels.iter().map(|p| p.rgba.map(|x| x as f32)).collect();
        let depth = solution.pixels.iter().map(|p| p.depth as f32).collect();
        Ok(Rendered { frame: Frame::new(view.size, pixels, Some(depth)), stats })
    }

    fn model(&self, _view: &View) -> Model {
        Model::Canonical
    }
}
