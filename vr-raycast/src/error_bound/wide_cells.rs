//! Cells of the filters of four taps per axis, as cubics with a bound of what they miss.

use glam::DVec3;
use vr_core::field::InterpolatedCell;
use vr_core::filter::{BSplineTaps, CatmullRomTaps, Filter, GaussianTaps};
use vr_core::{IndexRay, Real, Voxel};

use super::crossed::Crossed;
use super::looks::Looks;
use super::normals::{Gradients, Normals};
use super::polynomials::{CubicVector, MIN_MISS, Polynomials};
use super::tint::Tint;
use super::walk::{Course, Medium};

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
            let looks = || Looks { normals: self.flat_normals(ends), tint: self.tint(ends) };
            return course.constant(base, looks, from, to - from);
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
        let normals = |ends: [f64; 2], cubics: Option<&CubicVector>| {
            let Some(gradients) = gradients else { return Normals::Absent };
            if let Some(differences) = &differences {
                return self.between(gradients, differences, ends);
            }
            // The Gaussian's own gradient jumps at faces.
            let jumps = *filter == Filter::Gaussian && self.crossed(ends).beyond != [[false; 2]; 3];
            match cubics {
                Some(cubics) if !jumps => gradients.by_cubics(cubics, STEEPEST * reach),
                _ => Normals::Unknown,
            }
        };
        // A field of 64 products is no larger than this, whatever it is rounded by.
        let reach = 3.0 * reach;
        let displaced = 12.0 * STEEPEST * self.misplaced * reach;
        let gradient = along.gradient.map(|(gradient, off)| (gradient, off.value() + displaced, STEEPEST * reach));
        let looks = |ends: [f64; 2], cubics: Option<&CubicVector>, _: Option<&CubicVector>| Looks {
            normals: normals(ends, cubics),
            tint: self.tint(ends),
        };
        let pieces = Polynomials {
            field: along.field,
            off: along.error.value(),
            base,
            reach,
            limits: None,
            misplaced: STEEPEST * self.misplaced,
            gradient,
            colors: None,
            ends,
            error: self.medium.error,
            looks: &looks,
        };
        pieces.hand_over::<R>(course);
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

    /// Returns the colours along a part of the cell between two distances.
    fn tint(&self, ends: [f64; 2]) -> Tint {
        self.medium.tint(|| self.crossed(ends))
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
}
