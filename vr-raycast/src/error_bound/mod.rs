//! Steps that keep a bound of the error; the README beside this file says what the bound means, and proves it.

mod account;
mod blocks;
mod cone;
mod crossed;
mod cubic;
mod first;
mod modulation;
mod normals;
pub(crate) mod optics;
mod packets;
mod picks;
mod piece_by_piece;
mod reflection;
#[cfg(test)]
mod seeded;
mod series;
mod step;
mod walk;
mod wide_cells;

use std::sync::Arc;

use fearless_simd::Level;
use vr_core::filter::Lattice;
use vr_core::image_order::ImageSample;
use vr_core::{
    Compositing, Counts, Feature, Filter, GridVolume, IndexRay, LatticeVisitor, Layer, Rays, Real, RenderError, Scene,
    View, Voxel,
};
use vr_kernels::vector::LANES;

use crate::capabilities::unsupported;
use crate::tracer::{RaySample, Tracer};
use account::{Account, Limits};
use blocks::Blocks;
use first::FirstSearch;
use modulation::Modulation;
use normals::Gradients;
use optics::Optics;
use packets::{BoundedPackets, PacketView};
use picks::{Search, Wanted};
use piece_by_piece::Integral;
use reflection::{RayReflection, Reflection};
use walk::{Course, Medium};

/// Tables of a scene whose pictures keep a bound of the error.
#[derive(Clone, Debug)]
pub(crate) struct ErrorBound {
    pub(crate) volume: Arc<GridVolume>,
    optics: Optics,
    /// `None` where nothing looks at them.
    gradients: Option<Gradients>,
    /// `None` where colours stay as they are.
    reflection: Option<Reflection>,
    /// `None` where extinction stays as it is.
    modulation: Option<Modulation>,
    blocks: Blocks,
    /// Packets; `None` where rays go one by one.
    packets: Option<BoundedPackets>,
    error: f64,
    /// What values that are picked may be off by without that it matters.
    resolution: f64,
    level: f64,
    sought: Sought,
}

/// Result of each ray.
#[derive(Clone, Copy, Debug)]
enum Sought {
    /// Light that is gathered.
    Light,
    Value(Wanted),
    /// The first place where the field reaches this value.
    First(f64),
}

impl ErrorBound {
    /// Checks that there are bounds for a scene. Returns the level at which light ends.
    ///
    /// # Errors
    /// [`RenderError::Unsupported`] for what there is no bound for: transfer functions by gradient, and emission given on its own under accumulate.
    pub(crate) fn check(scene: &Scene) -> Result<f64, RenderError> {
        let without =
            |what: String| Err(unsupported(Feature::MaxError, format!("a promised error (max-error) {what}")));
        let level = match scene.compositing {
            Compositing::Accumulate { level } => level,
            _ => 1.0,
        };
        if scene.transfer.has_rows() {
            return without("with a transfer function by gradient".to_owned());
        }
        if level < 1.0 && scene.transfer.has_emission() {
            return without("with emission given on its own under compositing 'accumulate'".to_owned());
        }
        Ok(level)
    }

    /// Prepares a scene for pictures of a largest error, by packets on vectors of a level where they are given.
    ///
    /// # Errors
    /// Same as for [`Self::check`].
    pub(crate) fn new(
        error: f64,
        scene: &Scene,
        volume: &Arc<GridVolume>,
        vectors: Option<Level>,
    ) -> Result<Self, RenderError> {
        let level = Self::check(scene)?;
        let (low, high) = volume.value_stats().range.unwrap_or_default();
        let largest = f64::from(low.abs().max(high.abs()));
        let optics = Optics::new(&scene.transfer, volume.calibration(), largest);
        let blocks = Blocks::new(volume, &optics);
        // A ray that is cut needs more than the account of its sum.
        let sought = match scene.compositing {
            Compositing::First { threshold } => Sought::First(threshold),
            other => Wanted::by(other, volume.calibration()).map_or(Sought::Light, Sought::Value),
        };
        // A surface shows colours, whatever the medium emits.
        let brightest = match sought {
            Sought::First(_) => scene.transfer.brightest_color(),
            _ => optics.brightest,
        };
        let gradients = Gradients::new(scene, volume);
        let reflection = Reflection::new(scene, brightest);
        let modulation = Modulation::new(scene);
        let in_packets = level >= 1.0 && matches!(sought, Sought::Light) && modulation.is_none();
        let packets = vectors.filter(|_| in_packets).and_then(|level| {
            let reflected = reflection.as_ref().zip(gradients.as_ref());
            BoundedPackets::new(level, volume, &optics, &blocks, reflected)
        });
        let resolution = 0.1 * error / picks::steepest(&scene.transfer, volume.calibration());
        let volume = Arc::clone(volume);
        Ok(Self {
            volume,
            optics,
            gradients,
            reflection,
            modulation,
            blocks,
            packets,
            error,
            resolution,
            level,
            sought,
        })
    }

    /// Error that a ray may have: less what storing a pixel as f32 takes.
    fn ray_error(&self) -> f64 {
        let error = self.error * (1.0 - 1e-3) - f64::from(f32::EPSILON);
        // A ray that is cut: see the README.
        if self.level < 1.0 { error / 3.0 } else { error }
    }

    /// Prepares packets for a view, where there are any.
    pub(crate) fn packets(&self, view: &View) -> Result<Option<PacketView<'_>>, RenderError> {
        let prepared = self.packets.as_ref();
        Ok(prepared.map(|packets| PacketView::new(packets, &self.volume, view, self.ray_error())).transpose()?)
    }

    fn limits(&self) -> Limits {
        Limits {
            error: self.ray_error(),
            level: self.level,
            brightest: self.reflection.as_ref().map_or(self.optics.brightest, |reflection| reflection.brightest),
            emits: self.optics.emits,
        }
    }
}

/// Returns the largest component of the surface behind a pixel; 0 where there is none.
fn backdrop(layer: &Layer, pixel: usize) -> f32 {
    let (color, depth) = layer.pixels[pixel];
    if depth < f32::INFINITY { color.into_iter().fold(0.0, f32::max) } else { 0.0 }
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
    /// Packets, which are tried before rays go one by one.
    pub(crate) packets: Option<PacketView<'a>>,
}

impl Tracer for BoundedRays<'_> {
    fn trace(&self, spots: &[ImageSample], _: Option<&[u32]>, values: &mut Vec<RaySample>, counts: &mut Counts) {
        let mut stages = Stages::default();
        for spots in spots.chunks(LANES) {
            let mut traced = [RaySample::NOTHING; LANES];
            let mut open = u32::MAX;
            if let Some(packets) = self.packets.as_ref().filter(|_| stages.packets.is_worth_while()) {
                let before = counts.rays;
                let seen = (self.view, self.layer);
                open = packets.trace(self.volume, &self.rays, seen, spots, &mut traced[..spots.len()], counts);
                let failed = open.count_ones();
                stages.packets.tried += (counts.rays - before) as u32 + failed;
                stages.packets.failed += failed;
                counts.repeated += u64::from(failed);
            }
            for (i, (value, spot)) in traced.iter_mut().zip(spots).enumerate() {
                if open >> i & 1 == 1 {
                    *value = self.ray(spot, &mut stages.single, counts);
                } else if let Some(layer) = self.layer {
                    *value = value.over(layer, spot.pixel);
                }
            }
            values.extend_from_slice(&traced[..spots.len()]);
        }
    }
}

/// Ways to trace a ray that may not keep its bound, the cheapest first.
#[derive(Default)]
struct Stages {
    packets: Tries,
    single: Tries,
}

/// Numbers of rays of a group that were traced one way so far.
#[derive(Default)]
struct Tries {
    tried: u32,
    failed: u32,
}

impl Tries {
    /// False if most rays have to be traced again, so that trying this way costs more than it saves.
    fn is_worth_while(&self) -> bool {
        self.tried < 8 || 2 * self.failed < self.tried
    }
}

impl BoundedRays<'_> {
    fn ray(&self, spot: &ImageSample, single: &mut Tries, counts: &mut Counts) -> RaySample {
        let layer = self.layer;
        let far = layer.map_or(f64::INFINITY, |l| l.depth(spot.pixel));
        let ray = self.rays.at(spot.x, spot.y);
        let part = IndexRay::new(&ray, self.volume.placement(), self.volume.dims(), &self.view.clip, far);
        let backdrop = layer.map_or(0.0, |l| f64::from(backdrop(l, spot.pixel)));
        let value = part.map_or(RaySample::NOTHING, |part| {
            counts.rays += 1;
            if let Sought::Value(wanted) = self.error_bound.sought {
                return self.picked(&part, wanted, counts);
            }
            let reflection = self.error_bound.reflection.as_ref().map(|r| r.along(ray.direction));
            if let Sought::First(threshold) = self.error_bound.sought {
                return self.first(&part, reflection, threshold, counts);
            }
            let account = self.both_stages(BoundedRay { part, reflection, backdrop }, single, counts);
            counts.terminated += u64::from(account.ended);
            let [r, g, b] = account.light;
            RaySample {
                rgba: [r, g, b, account.opacity()].map(|x| x as f32),
                depth: (account.half_way + part.offset) as f32,
            }
        });
        layer.map_or(value, |l| value.over(l, spot.pixel))
    }

    /// Picks the value of a ray.
    fn picked(&self, ray: &IndexRay, wanted: Wanted, counts: &mut Counts) -> RaySample {
        let search =
            self.with_lattice(SearchJob { rays: self, ray, search: Search::new(wanted, self.error_bound.resolution) });
        counts.samples += search.steps;
        let Some(stored) = search.stored() else { return RaySample::NOTHING };
        let Optics { transfer, calibration, .. } = &self.error_bound.optics;
        let (rgba, off) = picks::pixel(transfer, *calibration, stored);
        if off > self.error_bound.ray_error() {
            counts.count_unbounded(off);
        }
        RaySample { rgba: rgba.map(|x| x as f32), depth: (search.distance + ray.offset) as f32 }
    }

    /// Shows the first place of a ray where the field reaches a threshold.
    fn first(
        &self,
        ray: &IndexRay,
        reflection: Option<RayReflection<'_>>,
        threshold: f64,
        counts: &mut Counts,
    ) -> RaySample {
        let search = FirstSearch::new(&self.error_bound.optics, reflection, threshold);
        let search = self.with_lattice(SearchJob { rays: self, ray, search });
        counts.samples += search.steps;
        let colors = self.error_bound.optics.transfer.brightest_color();
        let brightest = self.error_bound.reflection.as_ref().map_or(colors, |reflection| reflection.brightest);
        let pixel = search.pixel(brightest);
        if pixel.off > self.error_bound.ray_error() {
            counts.count_unbounded(pixel.off);
        }
        RaySample { rgba: pixel.rgba.map(|x| x as f32), depth: (pixel.distance + ray.offset) as f32 }
    }

    /// Hands over the numbers under the filter.
    fn with_lattice<V: LatticeVisitor>(&self, visitor: V) -> V::Output {
        match self.volume.filter() {
            Filter::BSpline => {
                let (samples, dims) = (self.volume.spline_coefficients(), self.volume.dims());
                visitor.visit(Lattice { samples, dims })
            }
            _ => self.volume.with_lattice(visitor),
        }
    }

    fn medium<'a, T: Voxel>(&'a self, lattice: Lattice<'a, T>) -> Medium<'a, T> {
        let &ErrorBound { ref blocks, ref gradients, error, .. } = self.error_bound;
        let (filter, volume, gradients) = (self.volume.filter(), self.volume, gradients.as_ref());
        Medium { lattice, filter, volume, blocks, gradients, error }
    }

    fn both_stages(&self, ray: BoundedRay<'_>, single: &mut Tries, counts: &mut Counts) -> Account {
        if self.single && single.is_worth_while() {
            single.tried += 1;
            let (account, kept) = self.with_lattice(self.job::<f32>(ray.clone()));
            counts.samples += account.steps;
            if kept {
                return account;
            }
            single.failed += 1;
        }
        counts.repeated += u64::from(self.single);
        let (account, kept) = self.with_lattice(self.job::<f64>(ray));
        if !kept {
            counts.count_unbounded(self.error_bound.error * account.overrun());
        }
        counts.samples += account.steps;
        account
    }

    fn job<'a, R: Real>(&'a self, ray: BoundedRay<'a>) -> Job<'a, R> {
        Job { rays: self, ray, precision: std::marker::PhantomData }
    }
}

/// Ray in the volume.
#[derive(Clone)]
struct BoundedRay<'a> {
    part: IndexRay,
    /// `None` where colours stay as they are.
    reflection: Option<RayReflection<'a>>,
    /// Largest component of what stands behind the volume.
    backdrop: f64,
}

/// Integration of one ray in one precision.
struct Job<'a, R> {
    rays: &'a BoundedRays<'a>,
    ray: BoundedRay<'a>,
    precision: std::marker::PhantomData<R>,
}

impl<R: Real> LatticeVisitor for Job<'_, R> {
    type Output = (Account, bool);

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        let BoundedRay { part, reflection, backdrop } = self.ray;
        let error_bound = self.rays.error_bound;
        let account = Account::new(error_bound.limits(), part.start, part.end, backdrop);
        let by_gradient = (reflection, error_bound.modulation.as_ref());
        // Only f32 has something better to turn to.
        let gives_up = R::ROUNDOFF > f64::EPSILON;
        let mut integral = Integral::new(&error_bound.optics, by_gradient, account, gives_up);
        walk::along::<R, T>(&self.rays.medium(lattice), &part, &mut integral);
        integral.account.finish();
        let kept = integral.is_kept();
        (integral.account, kept)
    }
}

/// Search along one ray, in f64.
struct SearchJob<'a, C> {
    rays: &'a BoundedRays<'a>,
    ray: &'a IndexRay,
    search: C,
}

impl<C: Course> LatticeVisitor for SearchJob<'_, C> {
    type Output = C;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> C {
        let mut search = self.search;
        walk::along::<f64, T>(&self.rays.medium(lattice), self.ray, &mut search);
        search
    }
}
