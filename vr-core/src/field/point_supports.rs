//! Supports of scattered points that a ray meets, and the breakpoints between which their sum is smooth.

use super::kernel_shape::Shape;
use super::kernel_slope::jumps_at_edge;
use crate::point_kernel::PointKernel;

/// A support as the ray meets it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub(super) nearest: f64,
    pub(super) half: f64,
    /// Half the length inside the kernel's core; 0 where there is none.
    pub(super) core: f64,
    /// Vector from the point to where the ray is nearest to it, in radii, and the square of its length.
    pub(super) across: [f64; 3],
    pub(super) square: f64,
    pub(super) per_radius: f64,
    /// Factor of the shape in the sum of values, and in that of weights.
    pub(super) amplitude: f64,
    pub(super) weight: f64,
    /// Number of the point.
    pub(super) point: u32,
    /// Largest displacement by rounding, in radii.
    pub(super) displaced: f64,
    pub(super) kernel: PointKernel,
}

impl Support {
    pub(super) fn shape_at(&self, s: f64) -> Shape {
        match self.kernel {
            PointKernel::CubicSpline if (s - self.nearest).abs() < self.core => Shape::Core,
            PointKernel::CubicSpline => Shape::Rim,
            PointKernel::Gaussian => Shape::Gaussian,
            PointKernel::Cone => Shape::Cone,
        }
    }

    /// Largest displacement of the places at which the ray enters and leaves: where it grazes the support, that of the distance moves them far.
    pub(super) fn misplaced_edge(&self) -> f64 {
        let radius = 1.0 / self.per_radius;
        let half = (self.half * self.per_radius).max(self.displaced.sqrt());
        2.0 * radius * self.displaced * (1.0 + 1.0 / half)
    }

    /// Calls `wish` with places of breakpoints, each with the length of pieces above which it is wanted.
    fn wishes(&self, gradients: bool, mut wish: impl FnMut(f64, f64)) {
        let radius = 1.0 / self.per_radius;
        // Nearer to the point than this, all that is not polynomial is below every error that a caller asks for: r³ here, r there. Of gradients, r²
        // here; there, where the direction itself turns, what there is on so short a way.
        let floor = match self.kernel {
            PointKernel::CubicSpline if gradients => 1e-6,
            PointKernel::CubicSpline => 1e-5,
            PointKernel::Cone => 1e-12,
            PointKernel::Gaussian => 1.0,
        };
        // Polynomials of gradients have a lower degree: pieces are shorter.
        let part = if gradients { 0.2 } else { 0.6 };
        let last = self.half * self.per_radius;
        let square = self.square.max(floor * floor);
        // Along the line r itself tells how far the next branch point is. On the axis there is none but the bend at the point.
        let step = |u: f64| match self.kernel {
            PointKernel::Gaussian if gradients => 0.2,
            PointKernel::Gaussian => 0.4,
            _ if self.square == 0.0 && !gradients => f64::INFINITY,
            _ => part * (square + u * u).sqrt(),
        };
        let bends = self.square == 0.0 && self.kernel != PointKernel::Gaussian;
        wish(self.nearest, if bends { 0.0 } else { radius * step(0.0) });
        let mut u = step(0.0);
        while u < last {
            wish(self.nearest - radius * u, radius * step(u));
            wish(self.nearest + radius * u, radius * step(u));
            u += step(u);
        }
    }
}

/// Returns every breakpoint, ascending; closer ones for gradients.
pub(super) fn cuts(supports: &[Support], ends: [f64; 2], gradients: bool) -> Vec<f64> {
    let within = |s: &f64| *s > ends[0] && *s < ends[1];
    // Where the ray crosses spheres on which the sum is not smooth.
    let mut needed = Vec::with_capacity(4 * supports.len() + 2);
    needed.extend(ends);
    for s in supports {
        needed.extend([s.nearest - s.half, s.nearest + s.half].into_iter().filter(within));
        if s.core > 0.0 {
            needed.extend([s.nearest - s.core, s.nearest + s.core].into_iter().filter(within));
        }
    }
    needed.sort_unstable_by(f64::total_cmp);
    needed.dedup();
    // Those besides that make interpolation converge fast, where no other is close.
    let mut all = needed.clone();
    for s in supports {
        s.wishes(gradients, |at, length| {
            let next = needed.partition_point(|&x| x <= at);
            if within(&at) && needed[next] - needed[next - 1] > length {
                all.push(at);
            }
        });
    }
    if gradients {
        beside_vacuum(supports, |at| all.extend(Some(at).filter(within)));
    }
    all.sort_unstable_by(f64::total_cmp);
    all.dedup();
    all
}

/// Calls `wish` with places closer and closer to where the ray comes out of vacuum and goes into it, in quarters of a part without vacuum: a cubic spline's
/// gradient vanishes there with the square of the distance, and on a short piece its direction has all its digits.
fn beside_vacuum(supports: &[Support], mut wish: impl FnMut(f64)) {
    const QUARTERINGS: i32 = 20;
    let ends = supports.iter().filter(|s| !jumps_at_edge(s.kernel)).map(|s| [s.nearest - s.half, s.nearest + s.half]);
    for [from, to] in joined(ends.collect()) {
        for k in 1..=QUARTERINGS {
            let near = (to - from) * 0.25f64.powi(k);
            wish(from + near);
            wish(to - near);
        }
    }
}

/// The parts of a ray that chords of supports cover, ascending.
pub(super) fn joined(mut chords: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    chords.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut parts: Vec<[f64; 2]> = Vec::new();
    for [from, to] in chords {
        match parts.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => parts.push([from, to]),
        }
    }
    parts
}

/// The supports of each piece, by counting.
pub(super) fn members(supports: &[Support], cuts: &[f64]) -> (Vec<usize>, Vec<u32>) {
    let middles: Vec<f64> = cuts.windows(2).map(|w| 0.5 * (w[0] + w[1])).collect();
    let range = |s: &Support| {
        let from = middles.partition_point(|&m| m <= s.nearest - s.half);
        from..middles.partition_point(|&m| m < s.nearest + s.half).max(from)
    };
    let ranges: Vec<_> = supports.iter().map(range).collect();
    let mut first = vec![0; middles.len() + 1];
    for piece in ranges.iter().cloned().flatten() {
        first[piece + 1] += 1;
    }
    for i in 0..middles.len() {
        first[i + 1] += first[i];
    }
    let mut next = first.clone();
    let mut inside = vec![0; first[middles.len()]];
    for (k, range) in ranges.into_iter().enumerate() {
        for piece in range {
            inside[next[piece]] = k as u32;
            next[piece] += 1;
        }
    }
    (first, inside)
}
