//! A uniform grid's field along a ray, under any reconstruction filter: a polynomial in every cell.
//!
//! Along a ray each index coordinate is linear in the distance, so a trilinear cell is a cubic, a tricubic one has degree 9, and
//! the nearest voxel is constant between the middles of the lattice. The Gaussian is no polynomial; it is interpolated at
//! Chebyshev points ([`InterpolatedCell`]).

use glam::{DMat3, DVec3};
use vr_core::bound::Bound;
use vr_core::field::{Chord, Cut, FieldLine, InterpolatedCell, LineModel, Poly, distinct_places};
use vr_core::filter::{GaussianTaps, Reconstruction};
use vr_core::{Calibration, Filter, GridVolume, IndexRay, Real, Sampler, Voxel};

use crate::double::Double;
use crate::exact_ray::{ExactPlacement, IndexChord};
use crate::tap_weights::{Axis, BSPLINE, CATMULL_ROM, cubics};

/// Gradients per index step at the voxels, for shading that takes them from there.
pub type SampleGradients<'a> = &'a (dyn Fn([usize; 3]) -> [f64; 3] + Sync);

/// The source of a field's gradient.
#[derive(Clone, Copy)]
pub enum GradientSource<'a> {
    /// No gradient is needed.
    None,
    /// The filter itself.
    Analytic,
    /// The voxels' own gradients, interpolated trilinearly.
    Samples(SampleGradients<'a>),
}

/// A uniform grid along a ray.
pub struct GridLine<'a, T, F> {
    sampler: Sampler<'a, T, F>,
    chord: IndexChord,
    calibration: Calibration,
    to_world: DMat3,
    /// Relative error of `to_world`.
    to_world_error: f64,
    gradient: GradientSource<'a>,
}

impl<'a, T: Voxel, F: Reconstruction> GridLine<'a, T, F> {
    /// The field of a sampler of `volume` along a ray, whose numbers are taken to be exact.
    pub fn new(volume: &GridVolume, sampler: Sampler<'a, T, F>, ray: IndexRay, gradient: GradientSource<'a>) -> Self {
        let farthest = ray.start.abs().max(ray.end.abs());
        let off = |a: usize| f64::EPSILON * (ray.origin[a].abs() + ray.direction[a].abs() * farthest);
        let position_error = std::array::from_fn(off);
        let chord = IndexChord { ray, position_error, end_error: [0.0; 2] };
        let placement = ExactPlacement::new(volume.placement(), volume.dims());
        Self::along(volume.calibration(), &placement, sampler, chord, gradient)
    }

    /// The field of a sampler along a chord, its numbers under a calibration.
    pub(crate) fn along(
        calibration: Calibration,
        placement: &ExactPlacement,
        sampler: Sampler<'a, T, F>,
        chord: IndexChord,
        gradient: GradientSource<'a>,
    ) -> Self {
        let to_world = placement.inverse().transpose() * calibration.slope;
        let to_world_error = 4.0 * f64::EPSILON + 2.0 * placement.axes_error();
        Self { sampler, chord, calibration, to_world, to_world_error, gradient }
    }

    /// The closed cell that the middle of an interval lies in, per axis; `None` in vacuum.
    fn cell(&self, middle: DVec3) -> Option<[usize; 3]> {
        let p = middle.to_array();
        if self.sampler.vacuum().is_some_and(|v| v.contains(p)) {
            return None;
        }
        let lattice = self.sampler.lattice();
        Some(std::array::from_fn(|a| lattice.cell(a, p[a]).0))
    }

    /// Voxel indices and polynomial weights along one axis, where the coordinate is `middle + half · t`.
    fn axis(&self, axis: usize, cell: usize, middle: f64, half: f64) -> Axis {
        let n = self.sampler.lattice().dims[axis];
        let x = Poly::new(&[middle - cell as f64, half]);
        match F::FILTER {
            Filter::Nearest => {
                let index = (middle + 0.5).to_index().min(n - 1);
                Axis { index: [index; 4], weight: [Poly::constant(1.0); 4], taps: 1 }
            }
            Filter::Trilinear => {
                let one = Poly::constant(1.0);
                Axis { index: [cell, cell + 1, 0, 0], weight: [one + x * -1.0, x, one, one], taps: 2 }
            }
            Filter::BSpline => Axis { index: F::FILTER.taps(cell, n), weight: cubics(x, &BSPLINE), taps: 4 },
            Filter::CatmullRom => Axis { index: F::FILTER.taps(cell, n), weight: cubics(x, &CATMULL_ROM), taps: 4 },
            Filter::Gaussian => unreachable!("interpolated, not expanded"),
        }
    }

    /// Field (in stored units, less `base`) as the tensor product of weights.
    fn tensor(&self, axes: &[Axis; 3], base: f64) -> Poly {
        let lattice = self.sampler.lattice();
        let mut sum = Poly::constant(0.0);
        for k in 0..axes[2].taps {
            let mut plane = Poly::constant(0.0);
            for j in 0..axes[1].taps {
                let mut line = Poly::constant(0.0);
                for i in 0..axes[0].taps {
                    let s: f64 = lattice.at(axes[0].index[i], axes[1].index[j], axes[2].index[k]);
                    line = line + axes[0].weight[i] * (s - base);
                }
                plane = plane + axes[1].weight[j] * line;
            }
            sum = sum + axes[2].weight[k] * plane;
        }
        sum
    }

    /// Largest distance of a voxel's value under the filter from `base`.
    fn reach(&self, cell: [usize; 3], base: f64) -> f64 {
        let lattice = self.sampler.lattice();
        let taps: [[usize; 4]; 3] = std::array::from_fn(|a| F::FILTER.taps(cell[a], lattice.dims[a]));
        let inner = if F::FILTER.reach() == 0 { 1..3 } else { 0..4 };
        let mut reach = Bound::ZERO;
        for k in inner.clone() {
            for j in inner.clone() {
                for i in inner.clone() {
                    let s: f64 = lattice.at(taps[0][i], taps[1][j], taps[2][k]);
                    reach = reach.max(s - base);
                }
            }
        }
        reach.value()
    }

    /// The value of a stored number, as `Calibration::value` defines it, and its rounding. A constant *is* that value; between voxels
    /// the field is slope and intercept applied to the reconstructed number.
    fn calibrated(&self, stored: f64) -> (f64, f64) {
        let Calibration { slope, intercept } = self.calibration;
        let value = self.calibration.value(stored);
        let product = slope * stored;
        // What the product and the sum lose (Knuth's two-sum).
        let part = value - product;
        let lost = (product - (value - part)) + (intercept - part);
        (value, slope.mul_add(stored, -product).abs() + lost.abs())
    }

    /// Bound on the field's error by that of positions, in stored units: its slope per index is below 5 times the voxels' reach.
    fn displaced(&self, reach: f64) -> f64 {
        let steepest = if F::FILTER.reach() == 0 { 2.0 } else { 5.0 };
        steepest * reach * self.chord.position_error.iter().sum::<f64>()
    }

    fn polynomial(&self, cell: [usize; 3], from: f64, to: f64) -> LineModel {
        let (middle, half) = self.middle_and_half(from, to);
        let axes: [Axis; 3] = std::array::from_fn(|a| self.axis(a, cell[a], middle[a], half[a]));
        let base: f64 = self.sampler.lattice().at(axes[0].index[0], axes[1].index[0], axes[2].index[0]);
        let reach = if F::FILTER == Filter::Nearest { 0.0 } else { self.reach(cell, base) };
        let (offset, calibration_error) = self.calibrated(base);
        let slope = self.calibration.slope;
        // A cell of equal samples is constant to the last bit: what a jump at exactly that value does depends on it.
        let (field, rounding) = if reach == 0.0 {
            (Poly::constant(offset), 0.0)
        } else {
            // A few roundings per tap and axis, of products bounded by `reach` times the weights' gain.
            let depth = if F::FILTER.reach() == 0 { 32.0 } else { 512.0 };
            let stored = f64::EPSILON * depth * reach + self.displaced(reach);
            let field = self.tensor(&axes, base) * slope + Poly::constant(offset);
            (field, slope.abs() * stored + f64::EPSILON * offset.abs())
        };
        let tie = if F::FILTER == Filter::Nearest { slope.abs() * self.tie(&axes, middle, half) } else { 0.0 };
        let analytic = || {
            let slopes: [Poly; 3] = std::array::from_fn(|a| {
                let mut axes = axes;
                axes[a] = axes[a].slopes(half[a], F::FILTER, middle[a] - cell[a] as f64);
                // The slopes' weights sum to zero: any base will do.
                self.tensor(&axes, base)
            });
            (slopes, Bound::new(4096.0 * f64::EPSILON * reach + 4.0 * self.displaced(reach)))
        };
        let (gradient, gradient_error) = self.gradient(cell, middle, half, reach, analytic);
        let calibration_error = if reach == 0.0 { 0.0 } else { calibration_error };
        let field_error = Bound::new(rounding) + calibration_error + tie;
        let limits = if reach == 0.0 { None } else { self.limits(cell, middle, half) };
        LineModel { field, field_error: field_error.value(), gradient, gradient_error, limits, certain: true }
    }

    /// Smallest and largest value of a cell's voxels, which a trilinear field does not reach inside it: there all eight have a positive weight.
    ///
    /// `None` if all values are equal, if the ray may lie in a face, where some weights are 0, and if calibration rounds a value.
    fn limits(&self, cell: [usize; 3], middle: DVec3, half: DVec3) -> Option<[f64; 2]> {
        let inside = |a: usize| {
            let (off, place) = (self.chord.position_error[a], middle[a] - cell[a] as f64);
            half[a].abs() > off || place > off && place < 1.0 - off
        };
        if F::FILTER != Filter::Trilinear || !(0..3).all(inside) {
            return None;
        }
        let lattice = self.sampler.lattice();
        let (slope, intercept) = (Double::from(self.calibration.slope), Double::from(self.calibration.intercept));
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in 0..8 {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|a| cell[a] + (corner >> a & 1));
            let stored: f64 = lattice.at(x, y, z);
            let value = slope * Double::from(stored) + intercept;
            if value.rest() != 0.0 {
                return None;
            }
            (low, high) = (low.min(value.round()), high.max(value.round()));
        }
        (low < high).then_some([low, high])
    }

    /// Difference of two voxels if the ray runs along the face half way between them, to within its error: it may be nearer to either.
    fn tie(&self, axes: &[Axis; 3], middle: DVec3, half: DVec3) -> f64 {
        let lattice = self.sampler.lattice();
        let index = axes.map(|a| a.index[0]);
        let here: f64 = lattice.at(index[0], index[1], index[2]);
        let mut difference = 0.0;
        for a in 0..3 {
            let off = self.chord.position_error[a];
            let face = (middle[a] + 0.5).round();
            let along = half[a].abs() <= off && (middle[a] + 0.5 - face).abs() <= off;
            if off > 0.0 && along && face >= 1.0 && face < lattice.dims[a] as f64 {
                let mut other = index;
                other[a] = if index[a] == face as usize { index[a] - 1 } else { face as usize };
                let there: f64 = lattice.at(other[0], other[1], other[2]);
                difference += (there - here).abs();
            }
        }
        difference
    }

    /// The world gradient and the error of its components; `analytic`: the filter's own per index step, with its error.
    fn gradient(
        &self,
        cell: [usize; 3],
        middle: DVec3,
        half: DVec3,
        reach: f64,
        analytic: impl FnOnce() -> ([Poly; 3], Bound),
    ) -> (Option<[Poly; 3]>, f64) {
        let (per_index, off, size) = match self.gradient {
            GradientSource::None => return (None, 0.0),
            GradientSource::Analytic => {
                let (slopes, off) = analytic();
                (slopes, off, 5.0 * reach)
            }
            GradientSource::Samples(at) => {
                let (slopes, size) = trilinear_gradients(at, cell, middle, half);
                let displaced = 2.0 * self.chord.position_error.iter().sum::<f64>();
                (slopes, Bound::new(size * (64.0 * f64::EPSILON + displaced)), size)
            }
        };
        let rows = [0, 1, 2].map(|r| self.to_world.row(r));
        let world = rows.map(|row| per_index[0] * row.x + per_index[1] * row.y + per_index[2] * row.z);
        if size == 0.0 {
            return (Some(world), 0.0);
        }
        let norm = rows.iter().map(|r| Bound::new(r.abs().element_sum())).fold(Bound::ZERO, Bound::max);
        (Some(world), ((off + self.to_world_error * size) * norm).value())
    }

    /// Shifts of the faces from the lattice.
    fn shifts(&self) -> &'static [f64] {
        match (F::FILTER, self.gradient, self.sampler.vacuum()) {
            // Constant around each sample; vacuum and the samples' gradients change at the lattice.
            (Filter::Nearest, GradientSource::None | GradientSource::Analytic, None) => &[0.5],
            (Filter::Nearest, ..) => &[0.0, 0.5],
            _ => &[0.0],
        }
    }

    /// Calls `each` with every place inside the ray at which the field's polynomial changes: its distance, and axis and index
    /// coordinate of the face that is crossed there; axis by axis.
    fn each_face(&self, mut each: impl FnMut(f64, usize, f64)) {
        let IndexRay { origin, direction, start, end, .. } = self.chord.ray;
        for a in 0..3 {
            let (o, d) = (origin[a], direction[a]);
            if d == 0.0 {
                continue;
            }
            for shift in self.shifts() {
                let (x0, x1) = (o + d * start - shift, o + d * end - shift);
                let (low, high) = (x0.min(x1).ceil(), x0.max(x1).floor());
                let mut k = low;
                while k <= high {
                    let s = (k + shift - o) / d;
                    if s > start && s < end {
                        each(s, a, k + shift);
                    }
                    k += 1.0;
                }
            }
        }
    }

    fn middle_and_half(&self, from: f64, to: f64) -> (DVec3, DVec3) {
        (self.chord.ray.at(0.5 * (from + to)), self.chord.ray.direction * (0.5 * (to - from)))
    }

    /// The Gaussian's field, interpolated.
    fn interpolated(&self, cell: [usize; 3], from: f64, to: f64) -> LineModel {
        let (middle, half) = self.middle_and_half(from, to);
        let lattice = self.sampler.lattice();
        let base: f64 = lattice.at(cell[0], cell[1], cell[2]);
        let reach = self.reach(cell, base);
        let (offset, calibration_error) = self.calibrated(base);
        let slope = self.calibration.slope;
        if reach == 0.0 {
            // Weights sum to 1: equal samples make a constant, which needs no interpolation.
            let none = || ([Poly::constant(0.0); 3], Bound::ZERO);
            let (gradient, gradient_error) = self.gradient(cell, middle, half, reach, none);
            let field = Poly::constant(offset);
            return LineModel { field, field_error: 0.0, gradient, gradient_error, limits: None, certain: true };
        }
        let own_slopes = matches!(self.gradient, GradientSource::Analytic);
        let part =
            InterpolatedCell::new::<GaussianTaps, T>(lattice, cell, base, reach, [middle, half], 0.0, own_slopes);
        let field = part.field * slope + Poly::constant(offset);
        let field_error = (part.error + self.displaced(reach)) * slope + f64::EPSILON * offset + calibration_error;
        let displaced = 4.0 * self.displaced(reach);
        let slopes = || part.gradient.map_or(([Poly::constant(0.0); 3], Bound::ZERO), |(g, off)| (g, off + displaced));
        let (gradient, gradient_error) = self.gradient(cell, middle, half, reach, slopes);
        LineModel { field, field_error: field_error.value(), gradient, gradient_error, limits: None, certain: true }
    }

    /// Bound on the error of a face's distance: its axis' error over the rate at which the ray crosses it.
    fn place_error(&self, at: f64) -> f64 {
        let IndexRay { origin, direction, start, end, .. } = self.chord.ray;
        let rounding = f64::EPSILON * at.abs();
        let mut largest = Bound::new(rounding);
        for (edge, off) in [start, end].into_iter().zip(self.chord.end_error) {
            if at == edge {
                largest = largest.max(off);
            }
        }
        for a in (0..3).filter(|&a| direction[a] != 0.0) {
            let (x, off) = (origin[a] + direction[a] * at, self.chord.position_error[a]);
            let reach = 4.0 * (off + direction[a].abs() * rounding);
            if self.shifts().iter().any(|shift| (x - shift - (x - shift).round()).abs() <= reach) {
                largest = largest.max(off / direction[a].abs() + rounding);
            }
        }
        largest.value()
    }

    /// True if the field, or its gradient where one is asked for, may jump at a face.
    fn jumps_at_faces(&self) -> bool {
        let smooth_gradient = match self.gradient {
            GradientSource::None => true,
            GradientSource::Samples(_) => F::FILTER != Filter::Nearest,
            GradientSource::Analytic => matches!(F::FILTER, Filter::BSpline | Filter::CatmullRom),
        };
        F::FILTER == Filter::Nearest || self.sampler.vacuum().is_some() || !smooth_gradient
    }
}

/// The voxels' gradients along the ray, per index step, and the largest component of any.
fn trilinear_gradients(at: SampleGradients<'_>, cell: [usize; 3], middle: DVec3, half: DVec3) -> ([Poly; 3], f64) {
    let one = Poly::constant(1.0);
    let x: [Poly; 3] = std::array::from_fn(|a| Poly::new(&[middle[a] - cell[a] as f64, half[a]]));
    let (mut sum, mut size) = ([Poly::constant(0.0); 3], Bound::ZERO);
    for corner in 0..8 {
        let high = |a: usize| corner >> a & 1;
        let weight = |a: usize| if high(a) == 1 { x[a] } else { one + x[a] * -1.0 };
        let w = weight(0) * weight(1) * weight(2);
        let g = at(std::array::from_fn(|a| cell[a] + high(a)));
        for c in 0..3 {
            sum[c] = sum[c] + w * g[c];
            size = size.max(g[c]);
        }
    }
    (sum, size.value())
}

impl<T: Voxel, F: Reconstruction> FieldLine for GridLine<'_, T, F> {
    fn chord(&self) -> Chord {
        let IndexRay { start, end, offset, .. } = self.chord.ray;
        Chord { start, end, offset }
    }

    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        out.push((self.chord.ray.start, Cut::Entry));
        self.each_face(|s, axis, at| out.push((s, Cut::Face { axis, at })));
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        let IndexRay { direction, start, end, .. } = self.chord.ray;
        // Each with its error.
        let mut faces = Vec::new();
        self.each_face(|s, axis, _| {
            faces.push((s, self.chord.position_error[axis] / direction[axis].abs() + f64::EPSILON * s.abs()));
        });
        let rounded = |end: f64, off: f64| (end, off + f64::EPSILON * end.abs());
        let ends = [rounded(start, self.chord.end_error[0]), rounded(end, self.chord.end_error[1])];
        distinct_places(ends, faces, out);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let cell = self.cell(self.chord.ray.at(0.5 * (from + to)))?;
        Some(match F::FILTER {
            Filter::Gaussian => self.interpolated(cell, from, to),
            _ => self.polynomial(cell, from, to),
        })
    }

    fn misplaced(&self, at: f64) -> f64 {
        let IndexRay { start, end, .. } = self.chord.ray;
        if at <= start {
            return self.chord.end_error[0];
        }
        if at >= end {
            return self.chord.end_error[1];
        }
        if self.jumps_at_faces() { self.place_error(at) } else { 0.0 }
    }
}
