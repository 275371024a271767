//! Cells of the filters of four taps per axis, as cubics with a bound of what they miss.

use glam::DVec3;
use vr_core::field::{InterpolatedCell, Poly};
use vr_core::filter::{BSplineTaps, CatmullRomTaps, Filter, GaussianTaps};
use vr_core::{IndexRay, Real, Voxel};

use super::crossed::Crossed;
use super::cubic::Cubic;
use super::normals::{Gradients, Normals};
use super::piece_by_piece::Place;
use super::walk::{Course, Medium};

/// Largest number of halvings of a cell, after which a cubic is taken as it is: a cubic's miss falls by 16 with each.
const MAX_HALVINGS: u32 = 9;
/// Smallest miss that shorter cubics are asked for, relative to the reach of the samples.
const MIN_MISS: f64 = 1e-10;
/// Largest miss of a gradient, relative to its largest component on the piece, and as a share of the error promised.
const GRADIENT_SHARE: f64 = 0.02;
/// Share of a miss that does not matter that each of the last coefficients may have: there are twelve.
const NEGLIGIBLE: f64 = 0.05;
/// Smallest length of a part of a cell that is interpolated by itself, in units of what places are off by.
const SHORTEST: f64 = 1e6;
/// Largest sum of the sizes of the Catmull-Rom cubic's weights, along three axes: 1.25 along each.
const CATMULL_ROM_GAIN: f64 = 1.25 * 1.25 * 1.25;
/// Largest slope of the field per index step along one axis, by the reach of its samples.
const STEEPEST: f64 = 5.0;

/// A cell that a ray crosses.
pub(super) struct WideCell<'a, T> {
    medium: &'a Medium<'a, T>,
    ray: &'a IndexRay,
    cell: [usize; 3],
    misplaced: f64,
}

/// The field along a cell, and what it takes to hand pieces of it over.
struct Whole<'a> {
    along: &'a InterpolatedCell,
    base: f64,
    reach: f64,
    /// Distances at which the cell is entered and left.
    ends: [f64; 2],
    /// Gradients at its corners, where they are central differences.
    differences: Option<[[f64; 3]; 8]>,
}

impl<'a, T: Voxel> WideCell<'a, T> {
    pub(super) fn new(medium: &'a Medium<'a, T>, ray: &'a IndexRay, cell: [usize; 3], misplaced: f64) -> Self {
        Self { medium, ray, cell, misplaced }
    }

    /// Takes a course through the cell between two distances.
    pub(super) fn cross<R: Real>(&self, ends: [f64; 2], course: &mut impl Course) {
        let [from, to] = ends;
        let Medium { lattice, filter, gradients, .. } = self.medium;
        let base: f64 = lattice.at(self.cell[0], self.cell[1], self.cell[2]);
        let [low, high] = self.range();
        if low == high {
            return course.constant(base, || self.flat_normals(ends), from, to - from);
        }
        let bounds = match filter {
            Filter::CatmullRom => {
                let (middle, half) = (0.5 * (low + high), 0.5 * (high - low) * CATMULL_ROM_GAIN);
                [middle - half, middle + half]
            }
            _ => [low, high],
        };
        if course.passes_values(bounds) {
            return;
        }
        let reach = (high - base).max(base - low);
        let way = [self.ray.at(0.5 * (from + to)), self.ray.direction * (0.5 * (to - from))];
        let analytic = gradients.is_some_and(|gradients| gradients.analytic);
        // The Gaussian is no polynomial: shorter parts are known better.
        let enough = course.resolution(bounds).max(MIN_MISS * reach);
        let along = self.interpolated((base, reach), way, NEGLIGIBLE * enough, analytic);
        let middle = 0.5 * (from + to);
        if !along.error.within(enough) && middle - from > SHORTEST * (self.misplaced + f64::EPSILON * middle.abs()) {
            self.cross::<R>([from, middle], course);
            if !course.is_done() {
                self.cross::<R>([middle, to], course);
            }
            return;
        }
        let differences = gradients.filter(|gradients| !gradients.analytic).map(|_| self.differences());
        // A series of 64 products is no larger than this.
        let reach = 3.0 * reach;
        let whole = Whole { along: &along, base, reach, ends, differences };
        self.piece::<R>(&whole, [-1.0, 1.0], 0, course);
    }

    /// Returns the smallest and the largest number under the filter's taps.
    fn range(&self) -> [f64; 2] {
        let lattice = &self.medium.lattice;
        let taps: [[usize; 4]; 3] = std::array::from_fn(|a| self.medium.filter.taps(self.cell[a], lattice.dims[a]));
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for z in taps[2] {
            for y in taps[1] {
                for x in taps[0] {
                    let sample = lattice.samples[lattice.offset(x, y, z)].to_f32();
                    (low, high) = (low.min(sample), high.max(sample));
                }
            }
        }
        [low, high].map(f64::from)
    }

    fn interpolated(
        &self,
        (base, reach): (f64, f64),
        way: [DVec3; 2],
        negligible: f64,
        with_gradient: bool,
    ) -> InterpolatedCell {
        let (lattice, cell) = (&self.medium.lattice, self.cell);
        match self.medium.filter {
            Filter::BSpline => {
                InterpolatedCell::new::<BSplineTaps, T>(lattice, cell, base, reach, way, negligible, with_gradient)
            }
            Filter::CatmullRom => {
                InterpolatedCell::new::<CatmullRomTaps, T>(lattice, cell, base, reach, way, negligible, with_gradient)
            }
            _ => InterpolatedCell::new::<GaussianTaps, T>(lattice, cell, base, reach, way, negligible, with_gradient),
        }
    }

    /// Returns the central differences at the cell's corners.
    fn differences(&self) -> [[f64; 3]; 8] {
        let corner = |i: usize| std::array::from_fn(|a| self.cell[a] + (i >> a & 1));
        std::array::from_fn(|i| self.medium.volume.central_differences_at_sample(corner(i)))
    }

    fn crossed(&self, ends: [f64; 2]) -> Crossed {
        Crossed::new(self.ray, self.cell, ends, self.misplaced)
    }

    /// Returns the gradient along a part of the cell between two distances, by central differences at its corners.
    fn between(&self, gradients: &Gradients, differences: &[[f64; 3]; 8], ends: [f64; 2]) -> Normals {
        let crossed = self.crossed(ends);
        let volume = self.medium.volume;
        let turns = |sample: [usize; 3]| volume.central_differences_at_sample(sample) != [0.0; 3];
        gradients.between(differences, &crossed, || crossed.any_beyond(volume.dims(), turns))
    }

    /// Returns the gradient where the samples under all taps are equal.
    fn flat_normals(&self, ends: [f64; 2]) -> Normals {
        let Some(gradients) = self.medium.gradients else { return Normals::Absent };
        if !gradients.analytic {
            return self.between(gradients, &self.differences(), ends);
        }
        // Beyond a face that the ray may lie in, it need not be 0.
        if self.crossed(ends).beyond == [[false; 2]; 3] { Normals::Absent } else { Normals::Unknown }
    }

    /// Hands over a piece of the cell, from one place on [−1, 1] to another: as one cubic if what that misses does not matter, else by halves.
    fn piece<R: Real>(&self, whole: &Whole<'_>, part: [f64; 2], halvings: u32, course: &mut impl Course) {
        if course.is_done() {
            return;
        }
        let [a, b] = part;
        let (cubic, missed) = restricted(&whole.along.field, part);
        let off = missed + whole.along.error.value();
        let (low, high) = cubic.hull();
        let range = [whole.base + low - off, whole.base + high + off];
        if course.passes_values(range) {
            return;
        }
        // What is a little beyond counts, too, as far as the field is off.
        let nearby = [range[0] - 4.0 * off, range[1] + 4.0 * off];
        let gradient = whole.along.gradient.as_ref().map(|(gradient, off)| {
            let parts = gradient.map(|g| restricted(&g, part));
            (parts.map(|(cubic, _)| cubic.powers()), parts.iter().map(|p| p.1).fold(0.0, f64::max), off.value())
        });
        let smallest = MIN_MISS.max(4.0 * R::ROUNDOFF) * whole.reach;
        let turns = gradient.as_ref().is_some_and(|(powers, missed, _)| {
            let size = powers.iter().map(|p| p.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
            *missed > (GRADIENT_SHARE * self.medium.error * size).max(smallest)
        });
        if halvings < MAX_HALVINGS && (missed > course.resolution(nearby).max(smallest) || turns) {
            let middle = 0.5 * (a + b);
            self.piece::<R>(whole, [a, middle], halvings + 1, course);
            self.piece::<R>(whole, [middle, b], halvings + 1, course);
            return;
        }
        let [from, to] = whole.ends;
        let at = |t: f64| from + (to - from) * 0.5 * (t + 1.0);
        let ends = [at(a), at(b)];
        let normals = || {
            let Some(gradients) = self.medium.gradients else { return Normals::Absent };
            if let Some(differences) = &whole.differences {
                return self.between(gradients, differences, ends);
            }
            let Some((powers, missed, off)) = &gradient else { return Normals::Unknown };
            // The Gaussian's own gradient jumps at faces.
            if self.medium.filter == Filter::Gaussian && self.crossed(ends).beyond != [[false; 2]; 3] {
                return Normals::Unknown;
            }
            let displaced = 12.0 * STEEPEST * self.misplaced * whole.reach;
            gradients.by_cubics(powers, missed + off + displaced, STEEPEST * whole.reach)
        };
        let place =
            Place { base: whole.base, reach: whole.reach, limits: None, misplaced: STEEPEST * self.misplaced, off };
        let cubic = Cubic(cubic.0.map(R::from_f64));
        course.cell(cubic, place, normals, ends[0], ends[1] - ends[0]);
    }
}

/// Returns a polynomial on a part of [−1, 1], as a cubic, and a bound of what that misses.
fn restricted(poly: &Poly, [a, b]: [f64; 2]) -> (Cubic<f64>, f64) {
    let part = poly.restricted(a, b);
    let (cubic, missed) = part.economized(3);
    let mut c = [0.0; 4];
    c[..=cubic.degree()].copy_from_slice(cubic.coefficients());
    // Roundings of the shift and of taking the degree down, of sums of all coefficients.
    let rounding = 64.0 * f64::EPSILON * (poly.coefficients()[0].abs() + poly.spread(1.0));
    (Cubic::of_powers_about_middle(c), missed + rounding)
}
