//! Steps that keep a bound of the error; the README beside this file says what the bound means, and proves it.

mod account;
mod blocks;
mod cone;
mod crossed;
mod cubic;
mod depth;
mod field_line;
mod first;
mod looks;
mod modulation;
mod normals;
pub(crate) mod optics;
mod packets;
mod picked_color;
mod picks;
mod piece_by_piece;
mod polynomials;
mod reflection;
#[cfg(test)]
mod seeded;
mod series;
mod step;
mod step_by_place;
mod tint;
mod walk;
mod wide_cells;

use std::marker::PhantomData;
use std::sync::Arc;

use fearless_simd::Level;
use vr_core::field::Chord;
use vr_core::filter::Lattice;
use vr_core::image_order::ImageSample;
use vr_core::{
    ColorGrid, Compositing, Counts, Filter, GridVolume, IndexRay, LatticeVisitor, Layer, Ray, Rays, Real, RenderError,
    Scene, View, Volume, Voxel,
};
use vr_kernels::vector::LANES;

use crate::source::Source;
use crate::tracer::{RaySample, Tracer};
use account::{Account, Limits};
use blocks::Blocks;
use field_line::FieldWay;
use first::FirstSearch;
use looks::Looks;
use modulation::Modulation;
use normals::Gradients;
use optics::Optics;
use packets::{BoundedPackets, PacketView};
use picked_color::PlacesOfExtreme;
use picks::{Search, Wanted};
use piece_by_piece::Integral;
use reflection::{RayReflection, Reflection};
use tint::VoxelColors;
use walk::{Course, Medium};

/// Tables of a scene whose pictures keep a bound of the error.
#[derive(Clone, Debug)]
pub(crate) struct ErrorBound {
    body: Body,
    optics: Optics,
    /// `None` where nothing looks at them.
    gradients: Option<Gradients>,
    /// `None` where colours stay as they are.
    reflection: Option<Reflection>,
    /// `None` where extinction stays as it is.
    modulation: Option<Modulation>,
    error: f64,
    /// Error of picked values that does not matter.
    resolution: f64,
    level: f64,
    sought: Sought,
    /// True if places have colours of their own.
    colored: bool,
}

/// Volume that rays go through.
#[derive(Clone, Debug)]
enum Body {
    Grid(Box<Grid>),
    /// Any other, which tells its course along a ray.
    Field(Volume),
}

/// Grid with what is prepared for it.
#[derive(Clone, Debug)]
struct Grid {
    volume: Arc<GridVolume>,
    /// `None` where voxels have no colours of their own.
    colors: Option<Arc<ColorGrid>>,
    blocks: Blocks,
    /// Packets; `None` where rays go one by one.
    packets: Option<BoundedPackets>,
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
    /// Prepares a scene for pictures of a largest error, by packets on vectors of a level where they are given.
    pub(crate) fn new(error: f64, scene: &Scene, source: &Source, vectors: Option<Level>) -> Self {
        let level = match scene.compositing {
            Compositing::Accumulate { level } => level,
            _ => 1.0,
        };
        let (calibration, colored) = (source.calibration(), scene.volume.has_colors());
        let largest = match source.grid() {
            Some(volume) => {
                let (low, high) = volume.value_stats().range.unwrap_or_default();
                f64::from(low.abs().max(high.abs()))
            }
            None => scene.volume.value_range().map_or(0.0, |(low, high)| low.abs().max(high.abs())),
        };
        let optics = Optics::new(&scene.transfer, calibration, largest);
        // A ray that is cut needs more than the account of its sum.
        let sought = match scene.compositing {
            Compositing::First { threshold } => Sought::First(threshold),
            other => Wanted::by(other, calibration).map_or(Sought::Light, Sought::Value),
        };
        // A surface shows colours, whatever the medium emits.
        let brightest = match sought {
            Sought::First(_) => scene.transfer.brightest_color(),
            _ => optics.brightest,
        };
        let gradients = match source.grid() {
            Some(volume) => Gradients::new(scene, volume),
            None => Gradients::of_field(scene),
        };
        let reflection = Reflection::new(scene, brightest);
        let modulation = Modulation::new(scene);
        let body = match source.grid() {
            None => Body::Field(scene.volume.clone()),
            Some(volume) => {
                let blocks = Blocks::new(volume, &optics);
                let colors = scene.volume.colors().cloned();
                let in_packets = level >= 1.0 && matches!(sought, Sought::Light) && modulation.is_none();
                let packets = vectors.filter(|_| in_packets).and_then(|level| {
                    let reflected = reflection.as_ref().zip(gradients.as_ref());
                    BoundedPackets::new(level, volume, &optics, reflected)
                });
                Body::Grid(Box::new(Grid { volume: Arc::clone(volume), colors, blocks, packets }))
            }
        };
        let resolution = 0.1 * error / picks::steepest(&scene.transfer, calibration);
        // An error δ of the value moves the place of an extreme, and with it the colour, by about √δ.
        let resolution = if colored { resolution * error } else { resolution };
        Self { body, optics, gradients, reflection, modulation, error, resolution, level, sought, colored }
    }

    /// Error that a ray may have: less what storing a pixel as f32 takes.
    fn ray_error(&self) -> f64 {
        let error = self.error * (1.0 - 1e-3) - f64::from(f32::EPSILON);
        // A ray that is cut where light goes with opacity: see the README.
        if self.level < 1.0 && !self.optics.emits { error / 3.0 } else { error }
    }

    /// True if rays are cut at a level of opacity, and gather light that does not go with opacity.
    fn cuts_emission(&self) -> bool {
        self.level < 1.0 && self.optics.emits
    }

    /// Prepares packets for a view, where there are any.
    pub(crate) fn packets(&self, view: &View) -> Result<Option<PacketView<'_>>, RenderError> {
        let Body::Grid(grid) = &self.body else { return Ok(None) };
        let prepared = grid.packets.as_ref();
        Ok(prepared.map(|packets| PacketView::new(packets, &grid.volume, view, self.ray_error())).transpose()?)
    }

    /// Limits of rays whose steps may use a share of the error.
    fn limits(&self, of_steps: f64) -> Limits {
        Limits {
            error: self.ray_error(),
            of_steps,
            level: self.level,
            brightest: self.reflection.as_ref().map_or(self.optics.brightest, |reflection| reflection.brightest),
            emits: self.optics.emits,
        }
    }
}

/// Shares of the error that steps may use where an emission is cut. Each is tried for rays of which the one before leaves too much light in doubt: the place of the cut depends on the error of the
/// steps, and light may depend on that place far more.
const SHARES_OF_CUT_EMISSION: [f64; 4] = [0.3, 0.03, 0.003, 3e-4];

/// Returns the largest component of the surface behind a pixel; 0 where there is none.
fn backdrop(layer: &Layer, pixel: usize) -> f32 {
    let (color, depth) = layer.pixels[pixel];
    if depth < f32::INFINITY { color.into_iter().fold(0.0, f32::max) } else { 0.0 }
}

/// Tracer of the rays of one view within the bound of the error.
pub(crate) struct BoundedRays<'a> {
    pub(crate) error_bound: &'a ErrorBound,
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
            if let (Some(packets), Body::Grid(grid)) = (&self.packets, &self.error_bound.body)
                && stages.packets.is_worth_while()
            {
                let before = counts.rays;
                let seen = (self.view, self.layer);
                open = packets.trace(
                    (&grid.volume, grid.colors.as_deref()),
                    &self.rays,
                    seen,
                    spots,
                    &mut traced[..spots.len()],
                    counts,
                );
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

    fn is_clear(&self, low: [u32; 2], high: [u32; 2]) -> bool {
        // What stands behind is drawn ray by ray.
        self.layer.is_none() && self.packets.as_ref().is_some_and(|packets| packets.is_clear(low, high))
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
        let backdrop = layer.map_or(0.0, |l| f64::from(backdrop(l, spot.pixel)));
        let value = self.way(&ray, far).map_or(RaySample::NOTHING, |way| {
            counts.rays += 1;
            if let Sought::Value(wanted) = self.error_bound.sought {
                return self.picked(&way, wanted, counts);
            }
            let reflection = self.error_bound.reflection.as_ref().map(|r| r.along(ray.direction));
            let ray = BoundedRay { way, reflection, backdrop };
            if let Sought::First(threshold) = self.error_bound.sought {
                return self.first(ray, threshold, counts);
            }
            let account = self.both_stages(&ray, single, counts);
            counts.terminated += u64::from(account.ended);
            let [r, g, b] = account.light;
            RaySample {
                rgba: [r, g, b, account.opacity()].map(|x| x as f32),
                depth: (account.half_way + ray.way.chord().offset) as f32,
            }
        });
        layer.map_or(value, |l| value.over(l, spot.pixel))
    }

    /// Returns the way of a ray through the volume, up to a world distance; `None` where it does not meet it.
    fn way(&self, ray: &Ray, far: f64) -> Option<Way<'_>> {
        let clip = &self.view.clip;
        let ErrorBound { body, gradients, error, .. } = self.error_bound;
        match body {
            Body::Grid(grid) => {
                let part = IndexRay::new(ray, grid.volume.placement(), grid.volume.dims(), clip, far)?;
                Some(Way::Grid(part, grid))
            }
            Body::Field(volume) => {
                FieldWay::new(volume.field()?, (ray, clip, far), gradients.as_ref(), *error).map(Way::Field)
            }
        }
    }

    /// Picks the value of a ray.
    fn picked(&self, way: &Way<'_>, wanted: Wanted, counts: &mut Counts) -> RaySample {
        let ErrorBound { optics, resolution, colored, .. } = self.error_bound;
        let (search, certain) = self.walk::<f64, _>(way, Search::new(wanted, *resolution, *colored));
        counts.samples += search.steps;
        let Some(stored) = search.stored() else { return RaySample::NOTHING };
        let Optics { transfer, calibration, .. } = optics;
        let (mut rgba, mut off) = picks::pixel(transfer, *calibration, stored);
        if *colored {
            let (color, color_off) = self.color_of(way, &search, counts);
            for (light, color) in rgba.iter_mut().zip(color) {
                *light *= color;
            }
            off += transfer.brightest_color() * color_off;
        }
        self.judge(off, certain, counts);
        RaySample { rgba: rgba.map(|x| x as f32), depth: (search.distance + way.chord().offset) as f32 }
    }

    /// Returns the colour of the place where a value was picked, or the mean of all, and a bound of what its channels are off by.
    fn color_of(&self, way: &Way<'_>, search: &Search, counts: &mut Counts) -> ([f64; 3], f64) {
        let Some(extreme) = search.extreme() else { return search.mean_color() };
        // All places at which the true extreme may be.
        let (places, _) = self.walk::<f64, _>(way, PlacesOfExtreme::new(extreme, self.error_bound.error));
        counts.samples += places.steps;
        (extreme.color, places.largest_difference())
    }

    /// Shows the first place of a ray where the field reaches a threshold.
    fn first(&self, ray: BoundedRay<'_>, threshold: f64, counts: &mut Counts) -> RaySample {
        let BoundedRay { way, reflection, .. } = ray;
        let search = FirstSearch::new(&self.error_bound.optics, reflection, threshold);
        let (search, certain) = self.walk::<f64, _>(&way, search);
        counts.samples += search.steps;
        let colors = self.error_bound.optics.transfer.brightest_color();
        let brightest = self.error_bound.reflection.as_ref().map_or(colors, |reflection| reflection.brightest);
        let pixel = search.pixel(brightest);
        self.judge(pixel.off, certain, counts);
        RaySample { rgba: pixel.rgba.map(|x| x as f32), depth: (pixel.distance + way.chord().offset) as f32 }
    }

    /// Counts a ray that is off by more than it may be, or of which no bound is known.
    fn judge(&self, off: f64, certain: bool, counts: &mut Counts) {
        if !certain {
            counts.count_unbounded(f64::NAN);
        } else if off > self.error_bound.ray_error() {
            counts.count_unbounded(off);
        }
    }

    fn both_stages(&self, ray: &BoundedRay<'_>, single: &mut Tries, counts: &mut Counts) -> Account {
        let shares = if self.error_bound.cuts_emission() { &SHARES_OF_CUT_EMISSION[..] } else { &[1.0] };
        let of_steps = shares[0];
        if self.single && single.is_worth_while() {
            single.tried += 1;
            let (account, kept) = self.integrated::<f32>(ray, of_steps);
            counts.samples += account.steps;
            if kept {
                return account;
            }
            single.failed += 1;
        }
        counts.repeated += u64::from(self.single);
        let (mut account, mut kept) = self.integrated::<f64>(ray, of_steps);
        for &of_steps in &shares[1..] {
            if kept || !account.is_doubtful() {
                break;
            }
            counts.repeated += 1;
            let steps = account.steps;
            (account, kept) = self.integrated::<f64>(ray, of_steps);
            account.steps += steps;
        }
        if !kept {
            counts.count_unbounded(self.error_bound.error * account.overrun());
        }
        counts.samples += account.steps;
        account
    }

    /// Integrates a ray in one precision, with steps that may use a share of the error. Also returns true if its bound is kept.
    fn integrated<R: Real>(&self, ray: &BoundedRay<'_>, of_steps: f64) -> (Account, bool) {
        let (error_bound, &BoundedRay { ref way, ref reflection, backdrop }) = (self.error_bound, ray);
        let Chord { start, end, .. } = way.chord();
        let account = Account::new(error_bound.limits(of_steps), start, end, backdrop);
        let by_place = (reflection.clone(), error_bound.modulation.as_ref(), Looks::unknown(error_bound.colored));
        // Only f32 has something better to turn to.
        let gives_up = R::ROUNDOFF > f64::EPSILON;
        let integral = Integral::new(&error_bound.optics, by_place, account, gives_up);
        let (mut integral, certain) = self.walk::<R, _>(way, integral);
        integral.account.finish();
        if !certain {
            integral.account.error = f64::NAN;
        }
        let kept = integral.is_kept();
        (integral.account, kept)
    }

    /// Takes a course along a way, in one precision. Returns it, and false if the field along it has no bounds, but estimates.
    fn walk<R: Real, C: Course>(&self, way: &Way<'_>, course: C) -> (C, bool) {
        match way {
            Way::Field(way) => {
                let mut course = course;
                let certain = way.walk::<R>(&mut course);
                (course, certain)
            }
            Way::Grid(part, grid) => {
                let walk = GridWalk { grid, part, error_bound: self.error_bound, course, precision: PhantomData::<R> };
                let volume = &grid.volume;
                let course = match volume.filter() {
                    Filter::BSpline => {
                        walk.visit(Lattice { samples: volume.spline_coefficients(), dims: volume.dims() })
                    }
                    _ => volume.with_lattice(walk),
                };
                (course, true)
            }
        }
    }
}

/// Ray in the volume.
struct BoundedRay<'a> {
    way: Way<'a>,
    /// `None` where colours stay as they are.
    reflection: Option<RayReflection<'a>>,
    /// Largest component of what stands behind the volume.
    backdrop: f64,
}

/// Way of a ray through the volume.
enum Way<'a> {
    Grid(IndexRay, &'a Grid),
    Field(FieldWay<'a>),
}

impl Way<'_> {
    fn chord(&self) -> Chord {
        match self {
            &Self::Grid(IndexRay { start, end, offset, .. }, _) => Chord { start, end, offset },
            Self::Field(way) => way.chord(),
        }
    }
}

/// Walk through a grid in one precision.
struct GridWalk<'a, R, C> {
    grid: &'a Grid,
    part: &'a IndexRay,
    error_bound: &'a ErrorBound,
    course: C,
    precision: PhantomData<R>,
}

impl<R: Real, C: Course> LatticeVisitor for GridWalk<'_, R, C> {
    type Output = C;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> C {
        let Self { grid, part, error_bound, mut course, .. } = self;
        let medium = Medium {
            lattice,
            filter: grid.volume.filter(),
            volume: &grid.volume,
            blocks: &grid.blocks,
            gradients: error_bound.gradients.as_ref(),
            colors: grid.colors.as_deref().map(VoxelColors::new),
            error: error_bound.error,
        };
        walk::along::<R, T>(&medium, part, &mut course);
        course
    }
}
