//! Part of a ray inside the volume, and the field along it.

use vr_core::filter::{Lattice, Reconstruction};
use vr_core::{GradientMethod, IndexRay, LatticeVisitor, Real, Sampler, SamplerVisitor, Voxel, gradient_and_turn};

use crate::place_colors::PlaceColors;
use crate::run::Run;
use crate::source::Source;

/// Part of a ray inside the volume, and the field along it.
///
/// The passes over a run are dispatched here, once per run: to the voxel type and the filter, for which they are instantiated.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chord<'a> {
    pub(crate) source: &'a Source,
    /// Colours of the places, where they have any.
    pub(crate) colors: Option<PlaceColors<'a>>,
    pub(crate) ray: IndexRay,
}

impl Chord<'_> {
    /// Places the samples of a run's steps, at the fraction `offset` of each.
    pub(crate) fn place<R: Real>(&self, run: &mut Run<R>, offset: f64) {
        run.offset = offset;
        run.place(&self.ray, self.source.dims());
    }

    /// Makes `run` a single point.
    pub(crate) fn place_point<R: Real>(&self, run: &mut Run<R>, distance: f64) {
        run.steps.set_point(distance);
        self.place(run, 0.0);
    }

    /// Fills the values of a placed run.
    pub(crate) fn sample<R: Real>(&self, run: &mut Run<R>) {
        let len = run.len();
        self.values(run.position.each_ref().map(|p| &p[..len]), &mut run.value[..len]);
    }

    /// Fills the values at positions, given axis by axis.
    pub(crate) fn values<R: Real>(&self, position: [&[R]; 3], value: &mut [R]) {
        match self.source {
            Source::Grid(grid) => grid.with_sampler(Values { position, value }),
            Source::Other(field) => {
                field.values(position, value);
            }
        }
    }

    /// Fills the colours of the places of a run, where they have any; `all` of them, or those where something shows.
    pub(crate) fn colors<R: Real>(&self, run: &mut Run<R>, all: bool) {
        let Some(colors) = self.colors else { return };
        for j in 0..run.len() {
            if all || run.light[j] != [R::ZERO; 4] {
                run.color[j] = colors.at(run.position_of(j));
            }
        }
    }

    /// Multiplies the light of a run by the colours of its places, where they have any.
    pub(crate) fn tint<R: Real>(&self, run: &mut Run<R>) {
        if self.colors.is_some() {
            (0..run.len()).for_each(|j| self.tint_step(run, j));
        }
    }

    /// Multiplies the light of one step by the colour of its place.
    #[inline(always)]
    pub(crate) fn tint_step<R: Real>(&self, run: &mut Run<R>, j: usize) {
        if self.colors.is_some() {
            (0..3).for_each(|c| run.light[j][c] = run.light[j][c] * run.color[j][c]);
        }
    }

    /// Returns the colour of the place at a distance; white where it has none.
    pub(crate) fn color_at(&self, distance: f64) -> [f64; 3] {
        self.colors.map_or([1.0; 3], |colors| colors.at(self.position(distance)))
    }

    /// Returns the index-space position at a distance in the kernel's precision, clamped into the box like the positions of a run.
    #[inline(always)]
    pub(crate) fn position<R: Real>(&self, distance: f64) -> [R; 3] {
        let (at, dims) = (self.ray.at(distance), self.source.dims());
        std::array::from_fn(|a| R::from_f64(at[a].clamp(0.0, (dims[a] - 1) as f64)))
    }

    /// Fills the gradients of a placed run, where something absorbs or shines, and how they change over the steps, if the samples are in their middles.
    pub(crate) fn gradients<R: Real>(&self, run: &mut Run<R>, method: GradientMethod) {
        match (self.source, method) {
            (Source::Grid(grid), GradientMethod::CentralDifferences) => {
                let along = if run.offset == 0.5 { self.ray.direction.to_array() } else { [0.0; 3] };
                grid.with_lattice(CentralDifferences { run, along });
            }
            (Source::Grid(grid), GradientMethod::Analytic) => grid.with_sampler(AnalyticGradients(run)),
            // It has one, its own.
            (Source::Other(field), _) => field.gradients(run),
        }
    }

    /// Returns the point where sign·field reaches sign·threshold, between a distance where it does not (or is vacuum) and one where it does.
    pub(crate) fn crossing(&self, below: f64, reached: Crossing, sign: f64, threshold: f64) -> Crossing {
        let search = Bisection { chord: self, below, reached, sign, threshold };
        match self.source {
            Source::Grid(grid) => grid.with_sampler(search),
            Source::Other(field) => search.by(|distance| field.value_along(&self.ray, distance)),
        }
    }
}

/// Point at which the field reaches a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) distance: f64,
    /// Field at the point.
    pub(crate) stored: f64,
}

struct Values<'r, R> {
    position: [&'r [R]; 3],
    value: &'r mut [R],
}

impl<R: Real> SamplerVisitor for Values<'_, R> {
    type Output = ();

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        // Asked once a run: whether there is a hole to look out for.
        match sampler.vacuum() {
            None => self.fill(|p| F::value(sampler.lattice(), p)),
            Some(_) => self.fill(|p| sampler.value(p)),
        }
    }
}

impl<R: Real> Values<'_, R> {
    #[inline(always)]
    fn fill(self, value_at: impl Fn([R; 3]) -> R) {
        let [x, y, z] = self.position;
        for (value, ((&x, &y), &z)) in self.value.iter_mut().zip(x.iter().zip(y).zip(z)) {
            *value = value_at([x, y, z]);
        }
    }
}

struct AnalyticGradients<'r, R>(&'r mut Run<R>);

impl<R: Real> SamplerVisitor for AnalyticGradients<'_, R> {
    type Output = ();

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) {
        for j in 0..self.0.len() {
            if self.0.light[j] != [R::ZERO; 4] {
                self.0.gradient[j] = sampler.value_and_gradient(self.0.position_of(j)).1;
            }
        }
    }
}

struct CentralDifferences<'r, R> {
    run: &'r mut Run<R>,
    /// Index steps per world unit of a step over which the gradient is followed.
    along: [f64; 3],
}

impl<R: Real> LatticeVisitor for CentralDifferences<'_, R> {
    type Output = ();

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) {
        let Self { run, along } = self;
        for j in 0..run.len() {
            if run.light[j] != [R::ZERO; 4] {
                let step = along.map(|d| R::from_f64(d * run.steps.length[j]));
                [run.gradient[j], run.turn[j]] = gradient_and_turn(&lattice, run.position_of(j), step);
            }
        }
    }
}

struct Bisection<'c> {
    chord: &'c Chord<'c>,
    below: f64,
    reached: Crossing,
    sign: f64,
    threshold: f64,
}

/// Halvings of the step between two samples: 10⁻⁹ of it is left, which is below the rounding of an f32 depth.
const HALVINGS: u32 = 30;

impl SamplerVisitor for Bisection<'_> {
    type Output = Crossing;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Crossing {
        let (chord, max_index) = (self.chord, self.chord.source.dims().map(|n| (n - 1) as f64));
        self.by(|distance| {
            let at = chord.ray.at(distance).to_array();
            sampler.value::<f64>(std::array::from_fn(|a| at[a].clamp(0.0, max_index[a])))
        })
    }
}

impl Bisection<'_> {
    /// Halves the stretch by the stored number at a distance, which is NaN in vacuum.
    fn by(self, stored_at: impl Fn(f64) -> f64) -> Crossing {
        let (mut below, mut reached) = (self.below, self.reached);
        for _ in 0..HALVINGS {
            let distance = 0.5 * (below + reached.distance);
            let stored = stored_at(distance);
            // False in vacuum.
            if self.sign * stored >= self.sign * self.threshold {
                reached = Crossing { distance, stored };
            } else {
                below = distance;
            }
        }
        reached
    }
}
