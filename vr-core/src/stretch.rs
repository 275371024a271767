//! The field of a grid on a stretch of a ray inside one cell, as a polynomial.

use glam::DVec3;

use crate::bound::{Bound, largest};
use crate::central_differences::gradient_at_sample;
use crate::field::{LEBESGUE, Poly, interpolation};
use crate::filter::{Filter, Lattice, Reconstruction};
use crate::grid::Calibration;
use crate::grid_volume::{GridVolume, LatticeVisitor, SamplerVisitor};
use crate::sampler::Sampler;
use crate::shading::GradientMethod;
use crate::voxel::Voxel;

/// A stretch of a ray inside one cell of a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    /// Its middle, in index space.
    pub middle: DVec3,
    /// Half its extent, in index steps.
    pub half: DVec3,
    /// Bound on the sum of the errors of the coordinates.
    pub position_error: f64,
    /// Source of the gradient, if it is asked for.
    pub gradient: Option<GradientMethod>,
}

/// The field on a stretch, in stored numbers per index step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StretchModel {
    pub field: Poly,
    pub field_error: f64,
    pub gradient: Option<[Poly; 3]>,
    /// Bound on the error of each component of the gradient.
    pub gradient_error: f64,
    /// False if the errors are estimates.
    pub certain: bool,
}

/// Degree of the field along a ray inside a cell. The Gaussian's is no polynomial.
fn degree(filter: Filter) -> usize {
    match filter {
        Filter::Nearest | Filter::Trilinear => 3,
        Filter::BSpline | Filter::CatmullRom => 9,
        Filter::Gaussian => 12,
    }
}

/// Places at which the interpolant of the Gaussian is compared with it.
const SEEN: [f64; 3] = [0.13, -0.58, 0.91];

impl Stretch {
    /// The field of a volume on the stretch; `None` in vacuum.
    pub(crate) fn model(self, volume: &GridVolume) -> Option<StretchModel> {
        let model = volume.with_sampler(self)?;
        if self.gradient == Some(GradientMethod::CentralDifferences) {
            let (gradient, gradient_error) = volume.with_lattice(self);
            return Some(StretchModel { gradient: Some(gradient), gradient_error, ..model });
        }
        Some(model)
    }

    /// The place at −1 ≤ t ≤ 1, in a cell: rounding does not carry it into the next one.
    fn place(&self, cell: [usize; 3], t: f64) -> [f64; 3] {
        let place = self.middle + self.half * t;
        std::array::from_fn(|a| place[a].clamp(cell[a] as f64, (cell[a] as f64 + 1.0).next_down()))
    }

    fn cell<T: Voxel>(&self, lattice: &Lattice<'_, T>) -> [usize; 3] {
        std::array::from_fn(|a| lattice.cell(a, self.middle[a]).0)
    }
}

impl SamplerVisitor for Stretch {
    type Output = Option<StretchModel>;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Option<StretchModel> {
        if sampler.vacuum().is_some_and(|v| v.contains(self.middle.to_array())) {
            return None;
        }
        let lattice = sampler.lattice();
        let cell = self.cell(lattice);
        let analytic = self.gradient == Some(GradientMethod::Analytic);
        let none = analytic.then_some([Poly::constant(0.0); 3]);
        let constant = |value: f64| {
            let field = Poly::constant(value);
            Some(StretchModel { field, field_error: 0.0, gradient: none, gradient_error: 0.0, certain: true })
        };
        if F::FILTER == Filter::Nearest {
            return constant(F::value(lattice, self.place(cell, 0.0)));
        }
        // Smallest and largest number under the filter. Equal ones make a constant to the last bit: what a jump at just that value does
        // depends on it.
        let taps: [[usize; 4]; 3] = std::array::from_fn(|a| F::FILTER.taps(cell[a], lattice.dims[a]));
        let inner = if F::FILTER.reach() == 0 { 1..3 } else { 0..4 };
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in inner.clone() {
            for j in inner.clone() {
                for i in inner.clone() {
                    let s: f64 = lattice.at(taps[0][i], taps[1][j], taps[2][k]);
                    (low, high) = (low.min(s), high.max(s));
                }
            }
        }
        if low == high {
            return constant(low);
        }
        let (size, span) = (low.abs().max(high.abs()), high - low);
        // Between eight corners the field rises by their span per index step at most. Weights of Catmull-Rom and their slopes add up to less than 2 and
        // 5 in size. A few roundings for each tap.
        let steepest = if F::FILTER.reach() == 0 { span } else { 5.0 * span };
        let displaced = steepest * self.position_error;
        let rounding = f64::EPSILON * if F::FILTER.reach() == 0 { 32.0 } else { 256.0 } * size;
        let rule = interpolation(degree(F::FILTER));
        let mut values = Vec::with_capacity(rule.nodes.len());
        let mut slopes: [Vec<f64>; 3] = Default::default();
        for &t in &rule.nodes {
            let place = self.place(cell, t);
            if analytic {
                let (value, slope) = F::value_and_gradient(lattice, place);
                values.push(value);
                slopes.iter_mut().zip(slope).for_each(|(all, s)| all.push(s));
            } else {
                values.push(F::value(lattice, place));
            }
        }
        let (field, dropped) = rule.through(&values, f64::EPSILON * size);
        let certain = F::FILTER != Filter::Gaussian;
        let missed = |truth: &dyn Fn(f64) -> f64, p: &Poly| {
            if certain { 0.0 } else { 4.0 * largest(SEEN.map(|t| truth(t) - p.at(t))) }
        };
        let field_error = LEBESGUE * (rounding + displaced)
            + displaced
            + dropped
            + missed(&|t| F::value(lattice, self.place(cell, t)), &field);
        let (mut gradient, mut gradient_error) = (None, 0.0f64);
        if analytic {
            let noise = f64::EPSILON * size;
            let made = slopes.each_ref().map(|values| rule.through(values, noise));
            let own = |a: usize| {
                missed(&|t| F::value_and_gradient(lattice, self.place(cell, t)).1[a], &made[a].0) + made[a].1
            };
            let off = largest((0..3).map(own));
            gradient_error = LEBESGUE * (8.0 * rounding + 4.0 * displaced) + off;
            gradient = Some(made.map(|m| m.0));
        }
        Some(StretchModel { field, field_error, gradient, gradient_error, certain })
    }
}

/// Central differences at the voxels, interpolated trilinearly.
impl LatticeVisitor for Stretch {
    type Output = ([Poly; 3], f64);

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> ([Poly; 3], f64) {
        let cell = self.cell(&lattice);
        let corner = |c: usize| gradient_at_sample::<T, f64>(&lattice, std::array::from_fn(|a| cell[a] + (c >> a & 1)));
        self.between_corners(cell, &std::array::from_fn(corner))
    }
}

impl Stretch {
    /// Vectors at the eight corners of a cell, interpolated trilinearly: cubics along the stretch, and a bound on the error of each component.
    pub(crate) fn between_corners(&self, cell: [usize; 3], corners: &[[f64; 3]; 8]) -> ([Poly; 3], f64) {
        let rule = interpolation(3);
        let mut values: [Vec<f64>; 3] = Default::default();
        for &t in &rule.nodes {
            let place = self.place(cell, t);
            let at: [f64; 3] = std::array::from_fn(|a| place[a] - cell[a] as f64);
            let weight = |c: usize| (0..3).map(|a| if c >> a & 1 == 1 { at[a] } else { 1.0 - at[a] }).product::<f64>();
            let weights: [f64; 8] = std::array::from_fn(weight);
            for (a, values) in values.iter_mut().enumerate() {
                values.push((0..8).map(|c| weights[c] * corners[c][a]).sum());
            }
        }
        let size = largest(corners.iter().flatten().copied());
        let made = values.map(|values| rule.through(&values, f64::EPSILON * size));
        let dropped = largest(made.iter().map(|m| m.1));
        let error = (LEBESGUE + 1.0) * size * (32.0 * f64::EPSILON + 2.0 * self.position_error) + dropped;
        (made.map(|m| m.0), error)
    }
}

impl StretchModel {
    /// The field in calibrated values, plus an offset, with a bound on its error.
    pub(crate) fn calibrated(&self, calibration: Calibration, offset: f64) -> (Poly, Bound) {
        let slope = calibration.slope;
        if self.field.is_constant() && self.field_error == 0.0 {
            // The value itself, to the last bit.
            return (Poly::constant(calibration.value(self.field.at(0.0)) + offset), Bound::ZERO);
        }
        let field = self.field * slope + Poly::constant(calibration.intercept + offset);
        let size = largest([field.coefficients()[0], calibration.intercept, offset]) + field.spread(1.0);
        (field, Bound::new(self.field_error) * slope + 4.0 * f64::EPSILON * size)
    }
}
