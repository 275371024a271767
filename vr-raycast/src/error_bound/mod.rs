//! Steps that keep a bound of the error; the README beside this file says what the bound means, and proves it.

mod account;
mod blocks;
mod cubic;
pub(crate) mod optics;
mod piece_by_piece;
mod step;
mod walk;

use std::sync::Arc;

use vr_core::filter::Lattice;
use vr_core::image_order::ImageSample;
use vr_core::{
    Compositing, Counts, Feature, Filter, GridVolume, IndexRay, LatticeVisitor, Layer, Rays, Real, RenderError, Scene,
    VacuumCells, View, Voxel,
};

use crate::capabilities::unsupported;
use crate::tracer::{RaySample, Tracer};
use account::{Account, Limits};
use blocks::Blocks;
use optics::Optics;
use piece_by_piece::Integral;
use walk::Medium;

/// Tables of a scene whose pictures keep a bound of the error.
#[derive(Clone, Debug)]
pub(crate) struct ErrorBound {
    pub(crate) volume: Arc<GridVolume>,
    optics: Optics,
    blocks: Blocks,
    error: f64,
    level: f64,
}

impl ErrorBound {
    /// Checks that there are bounds for a scene. Returns the level at which light ends.
    ///
    /// # Errors
    /// [`RenderError::Unsupported`] for what there is no bound for: other operators than over and accumulate, other filters than trilinear
    /// and nearest, shading, and emission given on its own under accumulate.
    pub(crate) fn check(scene: &Scene, volume: &GridVolume) -> Result<f64, RenderError> {
        let without =
            |what: String| Err(unsupported(Feature::MaxError, format!("a promised error (max-error) {what}")));
        let level = match scene.compositing {
            Compositing::Over => 1.0,
            Compositing::Accumulate { level } => level,
            other => return without(format!("under compositing '{}'", other.name())),
        };
        let filter = volume.filter();
        if !matches!(filter, Filter::Trilinear | Filter::Nearest) {
            return without(format!("with the filter '{filter}'"));
        }
        if scene.shading.is_some() {
            return without("with shading".to_owned());
        }
        if scene.transfer.has_rows() {
            return without("with a transfer function by gradient".to_owned());
        }
        if level < 1.0 && scene.transfer.has_emission() {
            return without("with emission given on its own under compositing 'accumulate'".to_owned());
        }
        Ok(level)
    }

    /// Prepares a scene for pictures of a largest error.
    ///
    /// # Errors
    /// Same as for [`Self::check`].
    pub(crate) fn new(error: f64, scene: &Scene, volume: &Arc<GridVolume>) -> Result<Self, RenderError> {
        let level = Self::check(scene, volume)?;
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let largest = f64::from(low.abs().max(high.abs()));
        let optics = Optics::new(&scene.transfer, volume.calibration(), largest);
        let blocks = Blocks::new(volume, &optics);
        Ok(Self { volume: Arc::clone(volume), optics, blocks, error, level })
    }

    fn limits(&self) -> Limits {
        // What storing a pixel as f32 takes.
        let error = self.error * (1.0 - 1e-3) - f64::from(f32::EPSILON);
        Limits {
            // A ray that is cut: see the README.
            error: if self.level < 1.0 { error / 3.0 } else { error },
            level: self.level,
            brightest: self.optics.brightest,
            emits: self.optics.emits,
        }
    }
}

/// Tracer of the rays of one view within the bound of the error.
pub(crate) struct BoundedRays<'a> {
    pub(crate) error_bound: &'a ErrorBound,
    pub(crate) volume: &'a GridVolume,
    pub(crate) view: &'a View,
    pub(crate) layer: Option<&'a Layer>,
    pub(crate) rays: Rays,
    /// True if f32 is tried first.
    pub(crate) single: bool,
}

impl Tracer for BoundedRays<'_> {
    fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let mut stages = Stages::default();
        for spot in spots {
            values.push(self.ray(spot, &mut stages, counts));
        }
    }
}

/// Counts of a group's rays in f32 so far.
#[derive(Default)]
struct Stages {
    tried: u32,
    failed: u32,
}

impl Stages {
    /// False if most rays have to be done again, so that f32 is a waste.
    fn is_single_worth_while(&self) -> bool {
        self.tried < 8 || 2 * self.failed < self.tried
    }
}

impl BoundedRays<'_> {
    fn ray(&self, spot: &ImageSample, stages: &mut Stages, counts: &mut Counts) -> RaySample {
        let layer = self.layer;
        let far = layer.map_or(f64::INFINITY, |l| l.depth(spot.pixel));
        let ray = self.rays.at(spot.x, spot.y);
        let part = IndexRay::new(&ray, self.volume.placement(), self.volume.dims(), &self.view.clip, far);
        let backdrop = layer.filter(|_| far < f64::INFINITY).map_or(0.0, |l| {
            let color = l.pixels[spot.pixel].0;
            color.into_iter().map(f64::from).fold(0.0, f64::max)
        });
        let value = part.map_or(RaySample::NOTHING, |part| {
            counts.rays += 1;
            let account = self.both_stages(part, backdrop, stages, counts);
            counts.terminated += u64::from(account.ended);
            let [r, g, b] = account.light;
            RaySample {
                rgba: [r, g, b, account.opacity()].map(|x| x as f32),
                depth: (account.half_way + part.offset) as f32,
            }
        });
        layer.map_or(value, |l| value.over(l, spot.pixel))
    }

    fn both_stages(&self, ray: IndexRay, backdrop: f64, stages: &mut Stages, counts: &mut Counts) -> Account {
        if self.single && stages.is_single_worth_while() {
            stages.tried += 1;
            let (account, kept) = self.volume.with_lattice(self.job::<f32>(ray, backdrop));
            counts.samples += account.steps;
            if kept {
                return account;
            }
            stages.failed += 1;
        }
        counts.repeated += u64::from(self.single);
        let (account, kept) = self.volume.with_lattice(self.job::<f64>(ray, backdrop));
        if !kept {
            counts.count_unbounded(self.error_bound.error * account.overrun());
        }
        counts.samples += account.steps;
        account
    }

    fn job<R: Real>(&self, ray: IndexRay, backdrop: f64) -> Job<'_, R> {
        Job {
            error_bound: self.error_bound,
            vacuum: self.volume.vacuum_cells(),
            nearest: self.volume.filter() == Filter::Nearest,
            ray,
            backdrop,
            precision: std::marker::PhantomData,
        }
    }
}

/// Integration of one ray in one precision.
struct Job<'a, R> {
    error_bound: &'a ErrorBound,
    vacuum: Option<&'a VacuumCells>,
    /// True under the filter nearest, false under trilinear.
    nearest: bool,
    ray: IndexRay,
    backdrop: f64,
    precision: std::marker::PhantomData<R>,
}

impl<R: Real> LatticeVisitor for Job<'_, R> {
    type Output = (Account, bool);

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        let account = Account::new(self.error_bound.limits(), self.ray.start, self.ray.end, self.backdrop);
        // Only f32 has something better to turn to.
        let gives_up = R::ROUNDOFF > f64::EPSILON;
        let mut integral = Integral::new(&self.error_bound.optics, account, gives_up);
        let medium = Medium { lattice, vacuum: self.vacuum, nearest: self.nearest, blocks: &self.error_bound.blocks };
        walk::along::<R, T>(&medium, &self.ray, &mut integral);
        integral.account.finish();
        let kept = integral.is_kept();
        (integral.account, kept)
    }
}
