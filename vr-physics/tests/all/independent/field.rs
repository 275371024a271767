//! A volume's field along a ray: camera, box, clip, filters and gradients, all straight from their definitions.

use vr_core::filter::Reconstruction;
use vr_core::{Filter, GradientMethod, LatticeVisitor, Projection, Sampler, SamplerVisitor, Scene, View, Voxel};

use super::dd::*;

/// Indices, weights and weights' slopes along one axis.
type Taps = Vec<(usize, Dd, Dd)>;

/// Numbers at lattice points.
struct Numbers;

impl SamplerVisitor for Numbers {
    type Output = Vec<f64>;
    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> Vec<f64> {
        sampler.lattice().samples.iter().map(|s| f64::from(s.to_f32())).collect()
    }
}

impl LatticeVisitor for Numbers {
    type Output = Vec<f64>;
    fn visit<T: Voxel>(self, lattice: vr_core::filter::Lattice<'_, T>) -> Vec<f64> {
        lattice.samples.iter().map(|s| f64::from(s.to_f32())).collect()
    }
}

/// The field along one ray, by the distance s from a point near the volume.
pub struct Field {
    filter: Filter,
    dims: [usize; 3],
    /// Under the filter: samples, or coefficients of the B-spline.
    numbers: Vec<f64>,
    /// Samples, missing ones filled in.
    samples: Vec<f64>,
    /// Cells with a missing corner.
    vacuum: Vec<bool>,
    slope: f64,
    intercept: f64,
    /// Rows of the map from world steps to index steps.
    inverse: [V3; 3],
    gradient: Option<GradientMethod>,
    origin: V3,
    direction: V3,
    /// Work done so far, in taps.
    pub spent: std::cell::Cell<u64>,
    pub to_eye: [f64; 3],
    pub ends: [Dd; 2],
}

impl Field {
    /// The ray through a pixel's centre; `None` where it misses.
    pub fn new(scene: &Scene, view: &View, pixel: [u32; 2]) -> Option<Self> {
        let volume = scene.volume.grid().expect("a grid");
        let camera = &view.camera;
        let eye = v3(camera.eye);
        let ahead = unit(minus(v3(camera.target), eye));
        let right = unit(cross(ahead, unit(v3(camera.up))));
        let up = cross(right, ahead);
        let rows = dd(f64::from(view.size[1]));
        let height = match camera.projection {
            Projection::Orthographic { height } => dd(height),
            Projection::Perspective { fov } => (dd(fov) * dd(0.5)).tan_degrees() * dd(2.0),
        };
        let x = dd(f64::from(pixel[0]) + 0.5 - 0.5 * f64::from(view.size[0])) * height / rows;
        let y = dd(0.5 * f64::from(view.size[1]) - f64::from(pixel[1]) - 0.5) * height / rows;
        let aside = plus(times(right, x), times(up, y));
        let (start, toward) = match camera.projection {
            Projection::Orthographic { .. } => (plus(eye, aside), ahead),
            Projection::Perspective { .. } => (eye, unit(plus(ahead, aside))),
        };
        let placement = volume.placement();
        let columns = [placement.axes().x_axis, placement.axes().y_axis, placement.axes().z_axis].map(v3);
        let det = dot(columns[0], cross(columns[1], columns[2]));
        let inverse: [V3; 3] =
            std::array::from_fn(|a| cross(columns[(a + 1) % 3], columns[(a + 2) % 3]).map(|x| x / det));
        let shifted = minus(start, v3(placement.origin()));
        let mut ends = [dd(0.0), dd(1e300)];
        let mut keep = |x: Dd, rate: Dd, low: Dd| {
            // low <= x + s rate
            if rate.f() == 0.0 {
                if x.below(low) {
                    ends[1] = dd(-1e300);
                }
                return;
            }
            let s = (low - x) / rate;
            if rate.f() > 0.0 {
                if ends[0].below(s) {
                    ends[0] = s;
                }
            } else if s.below(ends[1]) {
                ends[1] = s;
            }
        };
        let dims = volume.dims();
        let origin = inverse.map(|row| dot(row, shifted));
        let direction = inverse.map(|row| dot(row, toward));
        for a in 0..3 {
            keep(origin[a], direction[a], dd(0.0));
            keep(-origin[a], -direction[a], -dd((dims[a] - 1) as f64));
        }
        if let Some((low, high)) = view.clip.crop {
            for a in 0..3 {
                keep(start[a], toward[a], dd(low[a]));
                keep(-start[a], -toward[a], -dd(high[a]));
            }
        }
        for plane in &view.clip.planes {
            keep(dot(v3(plane.normal), start), dot(v3(plane.normal), toward), dd(plane.offset));
        }
        if !ends[0].below(ends[1]) {
            return None;
        }
        let raw: Vec<f64> =
            vr_core::with_grid!(volume.values(), g => g.samples().iter().map(|s| f64::from(s.to_f32())).collect());
        let mut vacuum = vec![false; raw.len()];
        for (i, _) in raw.iter().enumerate().filter(|(_, s)| s.is_nan()) {
            let at = [i % dims[0], i / dims[0] % dims[1], i / dims[0] / dims[1]];
            for corner in 0..8 {
                let c: [usize; 3] = std::array::from_fn(|a| at[a].wrapping_sub(corner >> a & 1));
                if (0..3).all(|a| c[a] < dims[a]) {
                    vacuum[(c[2] * dims[1] + c[1]) * dims[0] + c[0]] = true;
                }
            }
        }
        let calibration = volume.calibration();
        Some(Self {
            filter: volume.filter(),
            dims,
            numbers: volume.with_sampler(Numbers),
            samples: volume.with_lattice(Numbers),
            vacuum,
            slope: calibration.slope,
            intercept: calibration.intercept,
            inverse,
            gradient: match &scene.shading {
                Some(s) => Some(s.gradient),
                None => scene.transfer.has_rows().then_some(GradientMethod::CentralDifferences),
            },
            origin,
            direction,
            spent: std::cell::Cell::new(0),
            to_eye: toward.map(|x| -x.f()),
            ends,
        })
    }

    fn at(&self, s: Dd) -> V3 {
        plus(self.origin, times(self.direction, s))
    }

    /// Every place where the field may be another function: faces of cells and, for the nearest filter, between samples.
    pub fn cuts(&self) -> Vec<Dd> {
        let mut cuts = vec![self.ends[0], self.ends[1]];
        for a in 0..3 {
            for k in 0..2 * self.dims[a] {
                if self.direction[a].f() != 0.0 && (k % 2 == 0 || self.filter == Filter::Nearest) {
                    let s = (dd(0.5 * k as f64) - self.origin[a]) / self.direction[a];
                    if self.ends[0].below(s) && s.below(self.ends[1]) {
                        cuts.push(s);
                    }
                }
            }
        }
        cuts.sort_by(|a, b| (*a - *b).f().total_cmp(&0.0));
        cuts
    }

    /// The cell of a point, a lower corner.
    fn cell(&self, p: V3) -> [usize; 3] {
        std::array::from_fn(|a| (p[a].floor().max(0.0) as usize).min(self.dims[a] - 2))
    }

    /// True in vacuum; on a face the cells on both sides count.
    pub fn is_vacuum(&self, s: Dd) -> bool {
        let p = self.at(s);
        let cell = self.cell(p);
        (0..8).any(|side| {
            let mut c = cell;
            for a in 0..3 {
                if side >> a & 1 == 1 {
                    if (p[a] - dd(c[a] as f64)).f() != 0.0 || c[a] == 0 {
                        return false;
                    }
                    c[a] -= 1;
                }
            }
            self.vacuum[(c[2] * self.dims[1] + c[1]) * self.dims[0] + c[0]]
        })
    }

    /// Indices, weights and weights' slopes along one axis, in the cell of `home`.
    fn taps(&self, a: usize, cell: usize, x: Dd, home: Dd) -> Taps {
        let n = self.dims[a] as isize;
        let t = x - dd(cell as f64);
        let clamp = |i: isize| i.clamp(0, n - 1) as usize;
        let mirror = |i: isize| {
            (if i < 0 {
                -i
            } else if i >= n {
                2 * n - 2 - i
            } else {
                i
            }) as usize
        };
        let poly = |c: [f64; 4]| {
            let [c0, c1, c2, c3] = c.map(dd);
            let value = c0 + t * (c1 + t * (c2 + t * c3));
            (value, c1 + t * (c2 * dd(2.0) + t * c3 * dd(3.0)))
        };
        match self.filter {
            Filter::Nearest => vec![(clamp((home + dd(0.5)).floor() as isize), dd(1.0), dd(0.0))],
            Filter::Trilinear => vec![(cell, dd(1.0) - t, dd(-1.0)), (cell + 1, t, dd(1.0))],
            Filter::CatmullRom => {
                let c = [[0.0, -0.5, 1.0, -0.5], [1.0, 0.0, -2.5, 1.5], [0.0, 0.5, 2.0, -1.5], [0.0, 0.0, -0.5, 0.5]];
                (0..4)
                    .map(|k| {
                        let (w, d) = poly(c[k]);
                        (clamp(cell as isize + k as isize - 1), w, d)
                    })
                    .collect()
            }
            Filter::BSpline => {
                let c = [[1.0, -3.0, 3.0, -1.0], [4.0, 0.0, -6.0, 3.0], [1.0, 3.0, 3.0, -3.0], [0.0, 0.0, 0.0, 1.0]];
                let six = dd(6.0);
                (0..4)
                    .map(|k| {
                        let (w, d) = poly(c[k]);
                        (mirror(cell as isize + k as isize - 1), w / six, d / six)
                    })
                    .collect()
            }
            Filter::Gaussian => {
                let scale = dd(1.0) / (dd(0.7) * dd(0.7) * dd(-2.0));
                // 0.7 is the f64 that stands in vr-core.
                let edge = (dd(4.0) * scale).exp();
                let xs: Vec<Dd> = (0..4).map(|k| t - dd(f64::from(k) - 1.0)).collect();
                let bells: Vec<Dd> = xs.iter().map(|&x| (x * x * scale).exp()).collect();
                let total = bells.iter().fold(dd(0.0), |s, &b| s + b - edge);
                let slopes: Vec<Dd> = (0..4).map(|k| xs[k] * bells[k] * scale * dd(2.0)).collect();
                let total_slope = slopes.iter().fold(dd(0.0), |s, &b| s + b);
                (0..4)
                    .map(|k| {
                        let w = (bells[k] - edge) / total;
                        (clamp(cell as isize + k as isize - 1), w, (slopes[k] - w * total_slope) / total)
                    })
                    .collect()
            }
        }
    }

    fn sum(&self, taps: &[Taps; 3], slope_of: Option<usize>) -> Dd {
        let weight = |a: usize, t: &(usize, Dd, Dd)| if slope_of == Some(a) { t.2 } else { t.1 };
        let mut sum = dd(0.0);
        for z in &taps[2] {
            let mut plane = dd(0.0);
            for y in &taps[1] {
                let row = (z.0 * self.dims[1] + y.0) * self.dims[0];
                let line = taps[0].iter().fold(dd(0.0), |s, x| s + weight(0, x) * dd(self.numbers[row + x.0]));
                plane = plane + weight(1, y) * line;
            }
            sum = sum + weight(2, z) * plane;
        }
        sum
    }

    /// True if all numbers under the filter are one.
    fn equal(&self, taps: &[Taps; 3]) -> bool {
        let number = |x: usize, y: usize, z: usize| self.numbers[(z * self.dims[1] + y) * self.dims[0] + x];
        let first = number(taps[0][0].0, taps[1][0].0, taps[2][0].0);
        taps[2].iter().all(|z| taps[1].iter().all(|y| taps[0].iter().all(|x| number(x.0, y.0, z.0) == first)))
    }

    fn all_taps(&self, s: Dd, home: Dd) -> ([Taps; 3], [usize; 3], V3) {
        let (p, inside) = (self.at(s), self.at(home));
        let cell = self.cell(inside);
        (std::array::from_fn(|a| self.taps(a, cell[a], p[a], inside[a])), cell, p)
    }

    /// The calibrated value; `home` is a point of the piece that the point belongs to.
    pub fn value(&self, s: Dd, home: Dd) -> Dd {
        let (taps, ..) = self.all_taps(s, home);
        self.spent
            .set(self.spent.get() + taps[0].len().pow(3) as u64 * if self.filter == Filter::Gaussian { 4 } else { 1 });
        // Weights add up to 1: equal numbers are that number, and its value is the f64 that it is calibrated to.
        if self.equal(&taps) {
            let first = self.numbers[(taps[2][0].0 * self.dims[1] + taps[1][0].0) * self.dims[0] + taps[0][0].0];
            return dd(self.slope * first + self.intercept);
        }
        let stored = self.sum(&taps, None);
        stored * dd(self.slope) + dd(self.intercept)
    }

    /// The world gradient.
    pub fn gradient(&self, s: Dd, home: Dd) -> V3 {
        let (taps, cell, p) = self.all_taps(s, home);
        self.spent.set(self.spent.get() + 3 * taps[0].len().pow(3) as u64);
        if self.gradient == Some(GradientMethod::Analytic) && self.equal(&taps) {
            return [dd(0.0); 3];
        }
        let per_index: V3 = match self.gradient {
            None => return [dd(0.0); 3],
            Some(GradientMethod::Analytic) => {
                if self.filter == Filter::Nearest {
                    [dd(0.0); 3]
                } else {
                    std::array::from_fn(|a| self.sum(&taps, Some(a)))
                }
            }
            Some(GradientMethod::CentralDifferences) => {
                let mut g = [dd(0.0); 3];
                for corner in 0..8usize {
                    let at: [usize; 3] = std::array::from_fn(|a| cell[a] + (corner >> a & 1));
                    let weight = (0..3).fold(dd(1.0), |w, a| {
                        let t = p[a] - dd(cell[a] as f64);
                        w * if corner >> a & 1 == 1 { t } else { dd(1.0) - t }
                    });
                    for a in 0..3 {
                        let number = |k: usize| {
                            let mut q = at;
                            q[a] = k;
                            dd(self.samples[(q[2] * self.dims[1] + q[1]) * self.dims[0] + q[0]])
                        };
                        let (low, high) = (at[a].max(1) - 1, (at[a] + 1).min(self.dims[a] - 1));
                        let rise = (number(high) - number(low)) / dd((high - low) as f64);
                        g[a] = g[a] + weight * rise;
                    }
                }
                g
            }
        };
        let scaled = times(per_index, dd(self.slope));
        std::array::from_fn(|c| (0..3).fold(dd(0.0), |sum, a| sum + self.inverse[a][c] * scaled[a]))
    }
}
