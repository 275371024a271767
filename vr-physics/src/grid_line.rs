//! A uniform grid's field along a ray, under any reconstruction filter: a polynomial in every cell.
//!
//! Along a ray each index coordinate is linear in the distance, so a trilinear cell is a cubic, a tricubic one has degree 9, and
//! the nearest sample is constant between the middles of the lattice. The Gaussian is no polynomial; it is interpolated at
//! Chebyshev points, with the bound on the remainder that its size in the complex plane gives.

use std::sync::OnceLock;

use glam::{DMat3, DVec3};
use vr_core::filter::{GAUSSIAN_RADIUS, GAUSSIAN_SIGMA, Reconstruction};
use vr_core::{Calibration, Filter, IndexRay, Real, Sampler, UniformVolume, Voxel};

use crate::line::{Chord, LineField, LineModel, RayField};
use crate::poly::{Poly, chebyshev_point};
use crate::segments::Cut;

/// Gradients per index step at the samples, where shading takes them from there.
pub type SampleGradients<'a> = &'a (dyn Fn([usize; 3]) -> [f64; 3] + Sync);

/// Where the gradient of a field comes from.
#[derive(Clone, Copy)]
pub enum GradientSource<'a> {
    /// Nobody asks for it.
    None,
    /// The filter itself.
    Analytic,
    /// The samples' own gradients, interpolated trilinearly.
    Samples(SampleGradients<'a>),
}

/// A uniform grid along a ray.
pub struct GridLine<'a, T, F> {
    sampler: Sampler<'a, T, F>,
    ray: IndexRay,
    calibration: Calibration,
    to_world: DMat3,
    gradient: GradientSource<'a>,
}

impl<'a, T: Voxel, F: Reconstruction> GridLine<'a, T, F> {
    /// The field of a sampler of `volume` along a ray.
    pub fn new(
        volume: &UniformVolume,
        sampler: Sampler<'a, T, F>,
        ray: IndexRay,
        gradient: GradientSource<'a>,
    ) -> Self {
        let calibration = volume.calibration();
        let to_world = volume.placement().inverse_axes().transpose() * calibration.slope;
        Self { sampler, ray, calibration, to_world, gradient }
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

    /// Samples and polynomial weights along one axis, where the coordinate is `middle + half · t`.
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

    /// Largest distance of a sample under the filter from `base`.
    fn reach(&self, cell: [usize; 3], base: f64) -> f64 {
        let lattice = self.sampler.lattice();
        let taps: [[usize; 4]; 3] = std::array::from_fn(|a| F::FILTER.taps(cell[a], lattice.dims[a]));
        let inner = if F::FILTER.reach() == 0 { 1..3 } else { 0..4 };
        let mut reach = 0.0f64;
        for k in inner.clone() {
            for j in inner.clone() {
                for i in inner.clone() {
                    let s: f64 = lattice.at(taps[0][i], taps[1][j], taps[2][k]);
                    reach = reach.max((s - base).abs());
                }
            }
        }
        reach
    }

    fn polynomial(&self, cell: [usize; 3], from: f64, to: f64) -> LineModel {
        let (middle, half) = self.middle_and_half(from, to);
        let axes: [Axis; 3] = std::array::from_fn(|a| self.axis(a, cell[a], middle[a], half[a]));
        let lattice = self.sampler.lattice();
        let base: f64 = lattice.at(axes[0].index[0], axes[1].index[0], axes[2].index[0]);
        let reach = if F::FILTER == Filter::Nearest { 0.0 } else { self.reach(cell, base) };
        let offset = self.calibration.value(base);
        // A cell of equal samples is constant to the last bit: what a jump at exactly that value does depends on it.
        let field = if reach == 0.0 {
            Poly::constant(offset)
        } else {
            self.tensor(&axes, base) * self.calibration.slope + Poly::constant(offset)
        };
        // A few roundings per tap and axis, of products bounded by `reach` times the weights' gain; and of the position, which
        // is exact to a few units in the last place of an index.
        let depth = if F::FILTER.reach() == 0 { 32.0 } else { 512.0 };
        let index_error = lattice.dims.iter().fold(1.0f64, |m, &n| m.max(n as f64));
        let rounding = if reach == 0.0 {
            0.0
        } else {
            f64::EPSILON * (self.calibration.slope.abs() * reach * (depth + 2.0 * index_error) + offset.abs())
        };
        let (gradient, gradient_error) = self.gradient(cell, middle, half, &axes, base, rounding);
        LineModel { field, field_error: rounding, gradient, gradient_error, certain: true }
    }

    fn gradient(
        &self,
        cell: [usize; 3],
        middle: DVec3,
        half: DVec3,
        axes: &[Axis; 3],
        base: f64,
        rounding: f64,
    ) -> (Option<[Poly; 3]>, f64) {
        let per_index: [Poly; 3] = match self.gradient {
            GradientSource::None => return (None, 0.0),
            GradientSource::Analytic => std::array::from_fn(|a| {
                let mut axes = *axes;
                axes[a] = axes[a].slopes(half[a], F::FILTER, middle[a] - cell[a] as f64);
                // The slopes' weights sum to zero: any base will do.
                self.tensor(&axes, base)
            }),
            GradientSource::Samples(at) => trilinear_gradients(at, cell, middle, half),
        };
        let rows = [0, 1, 2].map(|r| self.to_world.row(r));
        let world = rows.map(|row| per_index[0] * row.x + per_index[1] * row.y + per_index[2] * row.z);
        // Relative to the field's own rounding: a gradient is a difference of as many products.
        let norm = rows.iter().map(|r| r.length()).fold(0.0, f64::max);
        let slope = self.calibration.slope.abs();
        (Some(world), 8.0 * rounding * norm / slope.max(f64::MIN_POSITIVE))
    }

    /// Calls `each` with every place inside the ray where the field goes over to another polynomial: its distance, and axis and index
    /// coordinate of the face that is crossed there; axis by axis.
    fn each_face(&self, mut each: impl FnMut(f64, usize, f64)) {
        let IndexRay { origin, direction, start, end, .. } = self.ray;
        for a in 0..3 {
            let (o, d) = (origin[a], direction[a]);
            if d == 0.0 {
                continue;
            }
            let shifts: &[f64] = match (F::FILTER, self.gradient, self.sampler.vacuum()) {
                // Constant around each sample; vacuum and the samples' gradients change at the lattice.
                (Filter::Nearest, GradientSource::None | GradientSource::Analytic, None) => &[0.5],
                (Filter::Nearest, ..) => &[0.0, 0.5],
                _ => &[0.0],
            };
            for shift in shifts {
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
        (self.ray.at(0.5 * (from + to)), self.ray.direction * (0.5 * (to - from)))
    }

    /// Interpolates field (and gradient) of the Gaussian at Chebyshev points.
    ///
    /// On the Bernstein ellipse of parameter ρ the coordinates leave the real axis by at most y = b·|half|, b = (ρ − 1/ρ)/2. There a
    /// tap is at most e^(y²/2σ²) times its real size, and the normaliser S at least its smallest real size less what it can
    /// change over y. The remainder is at most 4 M ρ^(−n)/(ρ − 1) (Trefethen, *Approximation Theory and Approximation
    /// Practice*, 2013, theorem 8.2).
    fn interpolated(&self, cell: [usize; 3], from: f64, to: f64) -> LineModel {
        // More would need fewer halvings, but the powers' coefficients grow as 2ⁿ, and rounding with them.
        const DEGREE: usize = 12;
        static NODES: OnceLock<[f64; DEGREE + 1]> = OnceLock::new();
        let (middle, half) = self.middle_and_half(from, to);
        let nodes: &[f64; DEGREE + 1] = NODES.get_or_init(|| std::array::from_fn(|j| chebyshev_point(DEGREE, j)));
        let at = |j: usize| {
            let p = (middle + half * nodes[j]).to_array();
            let (lattice, p) = (self.sampler.lattice(), inside(p, cell));
            match self.gradient {
                GradientSource::Analytic => F::value_and_gradient(lattice, p),
                _ => (F::value(lattice, p), [0.0; 3]),
            }
        };
        let samples: Vec<(f64, [f64; 3])> = (0..=DEGREE).map(at).collect();
        let base = samples[0].0;
        let values: Vec<f64> = samples.iter().map(|s| s.0 - base).collect();
        let reach = self.reach(cell, base);
        let offset = self.calibration.value(base);
        let slope = self.calibration.slope;
        let field = Poly::through_chebyshev_points(&values) * slope + Poly::constant(offset);
        let remainder = gaussian_remainder(half, DEGREE) * reach * slope.abs();
        let rounding = f64::EPSILON * (8192.0 * slope.abs() * reach + 2.0 * offset.abs());
        let field_error = remainder + rounding;
        let gradient = match self.gradient {
            GradientSource::None => None,
            GradientSource::Samples(g) => Some(trilinear_gradients(g, cell, middle, half)),
            GradientSource::Analytic => Some(std::array::from_fn(|a| {
                let values: Vec<f64> = samples.iter().map(|s| s.1[a]).collect();
                Poly::through_chebyshev_points(&values)
            })),
        };
        let rows = [0, 1, 2].map(|r| self.to_world.row(r));
        let gradient = gradient.map(|g| rows.map(|row| g[0] * row.x + g[1] * row.y + g[2] * row.z));
        // The derivative's remainder is not bounded here: shading by the Gaussian's own gradient is an estimate.
        let certain = !matches!(self.gradient, GradientSource::Analytic);
        let norm = rows.iter().map(|r| r.length()).fold(0.0, f64::max);
        let gradient_error = 64.0 * f64::EPSILON * norm * reach + if certain { 0.0 } else { 4.0 * remainder * norm };
        LineModel { field, field_error, gradient, gradient_error, certain }
    }
}

/// Clamps a position into a closed cell: rounding must not take the neighbour's taps.
fn inside(p: [f64; 3], cell: [usize; 3]) -> [f64; 3] {
    // The cell's upper face belongs to the next cell in the lattice's eyes: stay a bit below.
    std::array::from_fn(|a| {
        let low = cell[a] as f64;
        p[a].clamp(low, (low + 1.0).next_down())
    })
}

/// Bounds |f − interpolant| of the Gaussian field per unit of the samples' spread.
fn gaussian_remainder(half: DVec3, degree: usize) -> f64 {
    let mut best = f64::INFINITY;
    for rho in [3.0f64, 5.0, 8.0, 14.0, 30.0] {
        let (a, b) = (0.5 * (rho + 1.0 / rho), 0.5 * (rho - 1.0 / rho));
        let mut gain = 1.0;
        for axis in 0..3 {
            let h = half[axis].abs();
            // Beyond the interval's ends, too, the real part moves: by (a − 1) h.
            gain *= gaussian_gain(b * h, (a - 1.0) * h);
        }
        best = best.min(4.0 * gain * rho.powi(-(degree as i32)) / (rho - 1.0));
    }
    best
}

/// Bounds Σ|wᵢ(z)| of the four normalised taps, for real parts up to `beyond` outside the cell and imaginary parts up to `y`.
fn gaussian_gain(y: f64, beyond: f64) -> f64 {
    let g = |x: f64| libm::exp(-0.5 * (x / GAUSSIAN_SIGMA) * (x / GAUSSIAN_SIGMA));
    let edge = g(GAUSSIAN_RADIUS);
    // |g(x + iy)| = g(x) e^(y²/2σ²)
    let grow = libm::exp(0.5 * (y / GAUSSIAN_SIGMA) * (y / GAUSSIAN_SIGMA));
    // Over the cell [0, 1] the four taps' sum is smallest at its ends, where they are at distances 1, 0, 1 and 2.
    let smallest = 1.0 + 2.0 * g(1.0) + g(2.0) - 4.0 * edge;
    // Σ g(xᵢ) over the lattice is nowhere above σ√(2π) (1 + 2e^(−2π²σ²)) (Poisson's sum).
    let total = 1.76 * grow;
    // |g'(z)| = |z|/σ² |g(z)|, and x g(x) ≤ σ/√e for each tap: what the sum can lose on the way from the cell's nearest point.
    let steepest = grow * (4.0 * 0.607 * GAUSSIAN_SIGMA + 1.76 * y) / (GAUSSIAN_SIGMA * GAUSSIAN_SIGMA);
    let loss = (y + beyond) * steepest;
    if loss >= 0.8 * smallest { f64::INFINITY } else { (total + 4.0 * edge) / (smallest - loss) }
}

fn trilinear_gradients(at: SampleGradients<'_>, cell: [usize; 3], middle: DVec3, half: DVec3) -> [Poly; 3] {
    let one = Poly::constant(1.0);
    let x: [Poly; 3] = std::array::from_fn(|a| Poly::new(&[middle[a] - cell[a] as f64, half[a]]));
    let mut sum = [Poly::constant(0.0); 3];
    for corner in 0..8 {
        let high = |a: usize| corner >> a & 1;
        let weight = |a: usize| if high(a) == 1 { x[a] } else { one + x[a] * -1.0 };
        let w = weight(0) * weight(1) * weight(2);
        let g = at(std::array::from_fn(|a| cell[a] + high(a)));
        for c in 0..3 {
            sum[c] = sum[c] + w * g[c];
        }
    }
    sum
}

/// Lattice indices and weights along one axis.
#[derive(Clone, Copy)]
struct Axis {
    index: [usize; 4],
    weight: [Poly; 4],
    taps: usize,
}

impl Axis {
    /// The weights' derivatives by the index coordinate, of which `half` is the rate by t and `middle` the value at t = 0.
    fn slopes(&self, half: f64, filter: Filter, middle: f64) -> Self {
        let x = Poly::new(&[middle, half]);
        let weight = match filter {
            Filter::Trilinear => {
                let one = Poly::constant(1.0);
                [one * -1.0, one, one, one]
            }
            Filter::BSpline => cubics(x, &derivatives(&BSPLINE)),
            Filter::CatmullRom => cubics(x, &derivatives(&CATMULL_ROM)),
            Filter::Nearest | Filter::Gaussian => [Poly::constant(0.0); 4],
        };
        Self { weight, ..*self }
    }
}

/// Four cubics in the fraction: coefficients of 1, x, x², x³.
type Cubics = [[f64; 4]; 4];

const BSPLINE: Cubics = [
    [1.0 / 6.0, -0.5, 0.5, -1.0 / 6.0],
    [4.0 / 6.0, 0.0, -1.0, 0.5],
    [1.0 / 6.0, 0.5, 0.5, -0.5],
    [0.0, 0.0, 0.0, 1.0 / 6.0],
];

const CATMULL_ROM: Cubics =
    [[0.0, -0.5, 1.0, -0.5], [1.0, 0.0, -2.5, 1.5], [0.0, 0.5, 2.0, -1.5], [0.0, 0.0, -0.5, 0.5]];

fn derivatives(cubics: &Cubics) -> Cubics {
    cubics.map(|c| [c[1], 2.0 * c[2], 3.0 * c[3], 0.0])
}

fn cubics(x: Poly, c: &Cubics) -> [Poly; 4] {
    let (x2, one) = (x * x, Poly::constant(1.0));
    let x3 = x2 * x;
    c.map(|c| one * c[0] + x * c[1] + x2 * c[2] + x3 * c[3])
}

impl<T: Voxel, F: Reconstruction> LineField for GridLine<'_, T, F> {
    fn breakpoints(&self, out: &mut Vec<f64>) {
        out.push(self.ray.start);
        let first = out.len();
        self.each_face(|s, _, _| out.push(s));
        out[first..].sort_by(f64::total_cmp);
        out.push(self.ray.end);
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let cell = self.cell(self.ray.at(0.5 * (from + to)))?;
        Some(match F::FILTER {
            Filter::Gaussian => self.interpolated(cell, from, to),
            _ => self.polynomial(cell, from, to),
        })
    }
}

impl<T: Voxel, F: Reconstruction> RayField for GridLine<'_, T, F> {
    fn chord(&self) -> Chord {
        let IndexRay { start, end, offset, .. } = self.ray;
        Chord { start, end, offset }
    }

    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        out.push((self.ray.start, Cut::Entry));
        self.each_face(|s, axis, at| out.push((s, Cut::Face { axis, at })));
    }
}
