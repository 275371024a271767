//! The reference renderer: every pixel in f64, with a bound.

use std::sync::Arc;

use vr_core::bound::{Bound, largest};
use vr_core::image_order::{ImageSample, PixelValue, trace_pixels, trace_view};
use vr_core::{
    Configurable, Control, Counts, DeclaredOption, Documented, DocumentedError, Frame, HardCaseErrors, MIN_MAX_ERROR,
    Model, NamedSetting, NumberRange, OptionError, OptionTable, Prepared, Ray, RenderError, RenderStats, Rendered,
    Renderer, Scene, View,
};

use crate::segments::RaySegment;
use crate::solver::{RayQuery, RayResult, Solver, check};
use crate::transport::{Certainty, Transport};

/// Solves the equation of transfer for every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    tolerance: f64,
}

/// The default tolerance, relative to max(1, the picture's largest magnitude).
pub const DEFAULT_TOLERANCE: f64 = 1e-10;
/// The smallest tolerance: rounding is not far below.
pub const MIN_TOLERANCE: f64 = 1e-13;
/// The largest tolerance that is an option.
const MAX_TOLERANCE: f64 = 1e-2;
/// Storing a pixel as f32 adds this to its error.
const F32_ROUNDING: f64 = f32::EPSILON as f64;

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
        let larger = |w: Certainty, c: Certainty| w.and(c, Bound::new(w.value()).max(c.value()));
        self.pixels.iter().fold(worst, |w, p| larger(w, p.certainty))
    }

    /// Counts the pixels of a whole picture that are not proven to be within a tolerance, relative to max(1, the picture's largest
    /// magnitude).
    fn count_unbounded(&self, tolerance: f64, counts: &mut Counts) {
        let peak = self.pixels.iter().flat_map(|p| p.rgba).map(f64::abs).fold(1.0, f64::max);
        for pixel in &self.pixels {
            match pixel.certainty {
                Certainty::Bound(error) if error <= tolerance * peak => {}
                Certainty::Bound(error) => counts.count_unbounded(error / peak),
                // What is estimated may be off by anything.
                Certainty::Estimate(_) => counts.count_unbounded(f64::INFINITY),
            }
        }
    }
}

/// A pixel in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Premultiplied linear RGBA, without the background.
    pub rgba: [f64; 4],
    /// World distance along the ray to what is seen; +∞ where there is nothing.
    pub depth: f64,
    /// Bound or estimate of the error of any component of `rgba`.
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
        let mut error = Bound::ZERO;
        for v in values {
            for c in 0..4 {
                mean.rgba[c] += v.rgba[c] / n;
            }
            error += Bound::new(v.certainty.value()) / n;
            mean.certainty = mean.certainty.and(v.certainty, error);
            mean.depth = mean.depth.min(v.depth);
        }
        let size = largest(mean.rgba);
        mean.certainty = mean.certainty.and(mean.certainty, error + 2.0 * n * f64::EPSILON * size);
        mean
    }
}

impl Reference {
    /// The name in scene files and on command lines.
    pub const NAME: &'static str = "physics";

    /// A reference of the given tolerance (at least [`MIN_TOLERANCE`]).
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance: tolerance.max(MIN_TOLERANCE) }
    }

    /// The tolerance.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// Solves all pixels of a view, row by row: the scene as it is ([`Model::Canonical`]), or a renderer's own model of it.
    ///
    /// # Errors
    /// A view or scene that makes no sense, a volume of an unknown kind, or cancellation.
    pub fn solve(&self, scene: &Scene, view: &View, model: &Model, control: &Control) -> Result<Solution, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, model)?.with_surfaces(control)?;
        let (pixels, counts) =
            trace_view(view, control, || (), |(), ray, spot, counts| solver.pixel(ray, spot, counts))?;
        Ok(Solution { pixels, counts })
    }

    /// Solves some pixels only, in the order given.
    ///
    /// # Errors
    /// Same as for [`solve`](Self::solve).
    pub fn solve_pixels(
        &self,
        scene: &Scene,
        view: &View,
        model: &Model,
        pixels: &[[u32; 2]],
        control: &Control,
    ) -> Result<Solution, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, model)?.with_surfaces(control)?;
        let trace = |(): &mut (), ray: &Ray, spot: ImageSample, counts: &mut Counts| solver.pixel(ray, spot, counts);
        let (pixels, counts) = trace_pixels(view, pixels, control, || (), trace)?;
        Ok(Solution { pixels, counts })
    }

    /// Light and optical depth along one ray through a scene under emission and absorption; `None` where it misses the volume.
    ///
    /// # Errors
    /// Same as for [`solve`](Self::solve).
    pub fn transport(&self, scene: &Scene, view: &View, ray: &Ray) -> Result<Option<Transport>, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, &Model::Canonical)?;
        match solver.ask(ray, f64::INFINITY, RayQuery::Transport(1.0)) {
            None => Ok(None),
            Some((RayResult::Transport(t), _)) => Ok(Some(t)),
            _ => unreachable!("asked for transport"),
        }
    }

    /// One ray through a scene, front to back, cut at every cell face, at every point where its value crosses a knot of the transfer function, and
    /// at the world distances `cuts` along it (those outside the volume are left out): each part, and the ray up to its end, solved.
    /// Nothing for a ray that misses the volume.
    ///
    /// The last running sum is the pixel that [`solve`](Self::solve) finds for this ray, to what both may be off by.
    ///
    /// # Errors
    /// Same as for [`solve`](Self::solve).
    pub fn segments(
        &self,
        scene: &Scene,
        view: &View,
        ray: &Ray,
        cuts: &[f64],
    ) -> Result<Vec<RaySegment>, RenderError> {
        let solver = Solver::new(self.tolerance, scene, view, &Model::Canonical)?;
        match solver.ask(ray, f64::INFINITY, RayQuery::Segments(cuts)) {
            None => Ok(Vec::new()),
            Some((RayResult::Segments(all), _)) => Ok(all),
            _ => unreachable!("asked for segments"),
        }
    }
}

impl Renderer for Reference {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn max_error(&self) -> Option<f64> {
        Some(self.tolerance + F32_ROUNDING)
    }

    /// Half of the error is the tolerance, and leaves room for storing pixels as f32.
    fn with_max_error(&self, error: f64) -> Option<Result<Box<dyn Renderer>, OptionError>> {
        let range = NumberRange::at_least(MIN_MAX_ERROR);
        Some(if error == f64::INFINITY || range.contains(error) {
            Ok(Box::new(Self::new((0.5 * error).min(MAX_TOLERANCE))))
        } else {
            let (renderer, key) = (Self::NAME, "max-error".to_owned());
            Err(OptionError::Value { renderer, key, found: error.to_string(), allowed: format!("must be {range}") })
        })
    }

    fn supports(&self, scene: &Scene, view: Option<&View>) -> Result<(), RenderError> {
        check(scene, &Model::Canonical)?;
        view.map_or(Ok(()), |view| Ok(view.validate()?))
    }

    fn prepare(&self, scene: &Scene, _control: &Control) -> Result<Box<dyn Prepared>, RenderError> {
        check(scene, &Model::Canonical)?;
        scene.volume.prepare_derived();
        Ok(Box::new(PreparedReference { reference: self.clone(), scene: Arc::new(scene.clone()) }))
    }
}

impl Configurable for Reference {
    fn options() -> OptionTable<Self> {
        OptionTable::new(
            Self::NAME,
            [DeclaredOption::<Self>::number(
                "tolerance",
                "largest error of a pixel, in units of max(1, the picture's largest magnitude)",
                NumberRange::at_least(MIN_TOLERANCE).up_to(MAX_TOLERANCE),
                |r| r.tolerance,
                |r, x| r.tolerance = x,
            )
            .promise()],
        )
    }
}

impl Documented for Reference {
    /// The default alone. Others take the same time: bounds are found beforehand, and most pieces fit any of them.
    fn settings(&self) -> Vec<NamedSetting> {
        let reference = Self::default();
        vec![NamedSetting::new(format!("tolerance {:e}", reference.tolerance), &reference, None, F32_ROUNDING)]
    }

    fn hard_case_errors(&self) -> HardCaseErrors {
        let otherwise = self.max_error().map(DocumentedError::Max);
        HardCaseErrors { otherwise, ..HardCaseErrors::default() }
    }
}

struct PreparedReference {
    reference: Reference,
    scene: Arc<Scene>,
}

impl Prepared for PreparedReference {
    fn update(&mut self, scene: &Scene, _control: &Control) -> Result<(), RenderError> {
        check(scene, &Model::Canonical)?;
        self.scene = Arc::new(scene.clone());
        Ok(())
    }

    fn render(&mut self, view: &View, control: &Control) -> Result<Rendered, RenderError> {
        let mut stats = RenderStats::default();
        let solution = stats.time("rays", || self.reference.solve(&self.scene, view, &Model::Canonical, control))?;
        stats.counts = solution.counts;
        solution.count_unbounded(self.reference.tolerance, &mut stats.counts);
        let pixels = solution.pixels.iter().map(|p| p.rgba.map(|x| x as f32)).collect();
        let depth = solution.pixels.iter().map(|p| p.depth as f32).collect();
        Ok(Rendered { frame: Frame::new(view.size, pixels, Some(depth)), stats })
    }

    fn model(&self, _view: &View) -> Result<Model, RenderError> {
        Ok(Model::Canonical)
    }
}
