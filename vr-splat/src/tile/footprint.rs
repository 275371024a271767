//! Footprints: the part of a splat's kernel that each of sixteen rays goes through, and the depths between which it does.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, i32x16};
use vr_kernels::vector::{LANES, Lanes, pick, splat};

use crate::chord_table::ChordTable;
use crate::kernel::Profile;
use crate::projection::SplatView;
use crate::section_factors::SectionFactors;
use crate::section_table::SectionTable;
use crate::splat::Splat;
use crate::tile::block::Block;

/// A kernel, prepared for its footprints.
pub(crate) enum FootprintKernel {
    Radial(SectionTable),
    /// Adds the sections of points that are looked up by chords, and factors of sections along parallel rays, if there are any.
    Smooth(SectionTable, ChordTable, Option<SectionFactors>),
    Bilinear,
    BSpline,
    Box,
    CatmullRom,
    /// A product of windowed sincs or Gaussians.
    Tabulated(AxisTable),
}

/// A kernel along one axis over |t| in [0, 1], at equal distances, the last entry twice.
pub(crate) struct AxisTable(Vec<f32>);

/// Number of intervals of an [`AxisTable`].
const INTERVALS: usize = 4096;

impl FootprintKernel {
    pub(crate) fn new(profile: &Profile) -> Self {
        match profile {
            Profile::Radial(radial) => match ChordTable::new(radial) {
                Some(chords) => Self::Smooth(SectionTable::new(radial), chords, SectionFactors::new(radial)),
                None => Self::Radial(SectionTable::new(radial)),
            },
            Profile::Bilinear => Self::Bilinear,
            Profile::BSpline => Self::BSpline,
            Profile::Box => Self::Box,
            Profile::CatmullRom => Self::CatmullRom,
            Profile::Sinc(sinc) => Self::Tabulated(AxisTable::new(|t| sinc.at(t))),
            Profile::Gaussian(gaussian) => Self::Tabulated(AxisTable::new(|t| gaussian.at(t))),
        }
    }
}

impl AxisTable {
    fn new(kernel: impl Fn(f64) -> f64) -> Self {
        let entry = |i: usize| kernel(i as f64 / INTERVALS as f64) as f32;
        Self((0..=INTERVALS).chain([INTERVALS]).map(entry).collect())
    }

    #[inline(always)]
    fn at<S: Simd>(&self, simd: S, t: f32x16<S>) -> f32x16<S> {
        let x = t.abs().min(splat(simd, 1.0)) * INTERVALS as f32;
        let index: i32x16<S> = x.to_int();
        let t = x - index.to_float::<f32x16<S>>();
        let index = index.to_array();
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let pair = &self.0[index[i] as u32 as usize..][..2];
            (low[i], high[i]) = (pair[0], pair[1]);
        }
        let low = Lanes(low).load(simd);
        low + t * (Lanes(high).load(simd) - low)
    }
}

/// Axes of a view, in the precision of kernels.
#[derive(Clone, Copy)]
pub(crate) struct Axes {
    perspective: bool,
    base: f32,
    /// The view's x and y axes in kernel space.
    across: [[f32; 3]; 2],
    /// |x|², 2 x·y, |y|² of these.
    square: [f32; 3],
    /// See [`Self::round`].
    round: Option<f32>,
}

impl Axes {
    pub(crate) fn new(view: &SplatView) -> Self {
        let [x, y, z] = [view.kernel.axes.x_axis, view.kernel.axes.y_axis, view.kernel.axes.z_axis];
        let square = z.length_squared();
        // A rotation is rounded by a few units in the last place.
        let skew = [x.dot(y), y.dot(z), z.dot(x), x.length_squared() - square, y.length_squared() - square];
        let is_round = !view.perspective && skew.iter().all(|part| part.abs() < 1e-12 * square);
        Self {
            round: is_round.then_some(square as f32),
            perspective: view.perspective,
            base: view.base as f32,
            across: [x.as_vec3().to_array(), y.as_vec3().to_array()],
            square: [x.length_squared() as f32, (2.0 * x.dot(y)) as f32, y.length_squared() as f32],
        }
    }

    /// |x|², 2 x·y and |y|² of the view's x and y axes in kernel space.
    #[inline(always)]
    pub(crate) fn square(&self) -> [f32; 3] {
        self.square
    }

    /// Squared length in kernel space of a unit of the view, if rays are parallel and it is the same in all directions.
    #[inline(always)]
    pub(crate) fn round(&self) -> Option<f32> {
        self.round
    }

    /// Factor of rays' X and Y at a splat's depth.
    #[inline(always)]
    pub(crate) fn lever(&self, at: &Splat) -> f32 {
        if self.perspective { at.place[2] + self.base } else { 1.0 }
    }
}

/// Distances at which rays pass to the right of and above a splat, at its depth.
#[inline(always)]
fn beside<S: Simd>(simd: S, axes: &Axes, block: &Block, at: &Splat) -> [f32x16<S>; 2] {
    let (x, y) = (block.lateral[0].load(simd), block.lateral[1].load(simd));
    let lever = axes.lever(at);
    [x * lever - at.place[0], y * lever - at.place[1]]
}

/// Squared distances of parallel rays from a splat in kernel space, where a unit of the view has the squared length `square`.
#[inline(always)]
pub(super) fn parallel_square<S: Simd>(simd: S, block: &Block, at: &Splat, square: f32) -> f32x16<S> {
    let (u, v) = (block.lateral[0].load(simd) - at.place[0], block.lateral[1].load(simd) - at.place[1]);
    (u * u + v * v) * square
}

/// The smallest of sixteen numbers.
#[inline(always)]
pub(super) fn smallest<S: Simd>(all: f32x16<S>) -> f32 {
    let (low, high) = all.split();
    let (low, high) = low.min(high).split();
    let four = low.min(high).to_array();
    four[0].min(four[1]).min(four[2].min(four[3]))
}

/// Rays through a radially symmetric kernel.
pub(crate) struct Passing<S: Simd> {
    /// Distance of the lines from the middle, up to 1.
    pub(crate) distance: f32x16<S>,
    /// Depth at which they are nearest to it.
    pub(crate) nearest: f32x16<S>,
    /// Kernel space per unit of depth.
    pub(crate) speed: f32x16<S>,
}

/// Points of rays that are nearest to a splat in kernel space, where the support of a radial kernel is the unit ball.
pub(crate) struct Nearest<S: Simd> {
    /// Squared distance from the splat; 1 or more for rays outside the support.
    pub(crate) square: f32x16<S>,
    /// Depth.
    pub(crate) depth: f32x16<S>,
}

impl<S: Simd> Nearest<S> {
    /// `None` if no ray passes through the support.
    #[inline(always)]
    pub(crate) fn new(simd: S, axes: &Axes, block: &Block, at: &Splat) -> Option<Self> {
        let [u, v] = beside(simd, axes, block, at);
        let square = u * u * axes.square[0] + u * v * axes.square[1] + v * v * axes.square[2];
        let along = u * block.across[0].load(simd) + v * block.across[1].load(simd);
        let ahead = along * block.inverse_square.load(simd);
        let square = (square - along * ahead) * (at.scale * at.scale);
        if !square.simd_lt(splat(simd, 1.0)).any_true() {
            return None;
        }
        Some(Self { square, depth: splat(simd, at.place[2]) - ahead })
    }
}

impl<S: Simd> Passing<S> {
    /// `None` if no ray meets the kernel.
    #[inline(always)]
    pub(crate) fn new(simd: S, axes: &Axes, block: &Block, at: &Splat) -> Option<Self> {
        let Nearest { square, depth } = Nearest::new(simd, axes, block, at)?;
        Some(Self {
            distance: square.max(splat(simd, 0.0)).min(splat(simd, 1.0)).sqrt(),
            nearest: depth,
            speed: block.speed.load(simd) * at.scale,
        })
    }

    /// Vectors from the splat to the places of the rays that are nearest to it, in kernel space.
    #[inline(always)]
    pub(crate) fn across(&self, simd: S, axes: &Axes, block: &Block, at: &Splat) -> [f32x16<S>; 3] {
        let [u, v] = beside(simd, axes, block, at);
        let ahead = self.nearest - at.place[2];
        let [x, y] = axes.across;
        let mut across = [u; 3];
        for a in 0..3 {
            across[a] = (u * x[a] + v * y[a] + block.along[a].load(simd) * ahead) * at.scale;
        }
        across
    }

    /// The depths at which the rays enter the kernel and leave it; the same twice where they miss it.
    #[inline(always)]
    pub(crate) fn chord(&self, simd: S) -> [f32x16<S>; 2] {
        let one = splat(simd, 1.0);
        let half = ((one - self.distance) * (one + self.distance)).max(splat(simd, 0.0)).sqrt() / self.speed;
        [self.nearest - half, self.nearest + half]
    }

    /// ∫ W up to a depth, from the place that is nearest to the middle.
    #[inline(always)]
    pub(crate) fn up_to(&self, simd: S, table: &SectionTable, depth: f32x16<S>) -> f32x16<S> {
        let z = (depth - self.nearest) * self.speed;
        table.at(simd, self.distance, z.max(splat(simd, -1.0)).min(splat(simd, 1.0)))
    }
}

/// Rays through a kernel that is a product along the axes.
pub(crate) struct Crossing<S: Simd> {
    /// Positions in kernel space at the splat's depth.
    at: [f32x16<S>; 3],
    /// Kernel space per unit of depth.
    step: [f32x16<S>; 3],
    depth: f32,
}

impl<S: Simd> Crossing<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, axes: &Axes, block: &Block, at: &Splat) -> Self {
        let [u, v] = beside(simd, axes, block, at);
        let [x, y] = axes.across;
        let (mut place, mut step) = ([u; 3], [u; 3]);
        for a in 0..3 {
            place[a] = (u * x[a] + v * y[a]) * at.scale;
            step[a] = block.along[a].load(simd) * at.scale;
        }
        Self { at: place, step, depth: at.place[2] }
    }

    /// Places in kernel space at a depth.
    #[inline(always)]
    fn place(&self, depth: f32x16<S>) -> [f32x16<S>; 3] {
        let ahead = depth - self.depth;
        [self.at[0] + ahead * self.step[0], self.at[1] + ahead * self.step[1], self.at[2] + ahead * self.step[2]]
    }

    /// W of linear weights at a depth.
    #[inline(always)]
    pub(crate) fn bilinear(&self, simd: S, depth: f32x16<S>) -> f32x16<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let [x, y, z] = self.place(depth);
        let (x, y, z) = ((one - x.abs()).max(zero), (one - y.abs()).max(zero), (one - z.abs()).max(zero));
        x * y * z
    }

    /// W of a kernel that is a product along the axes, at a depth.
    #[inline(always)]
    pub(crate) fn weight(&self, simd: S, kernel: &FootprintKernel, depth: f32x16<S>) -> f32x16<S> {
        let [x, y, z] = self.place(depth);
        match kernel {
            FootprintKernel::Box => {
                // A hair wider, so that rounding leaves nothing out between two: there both count.
                let farthest = x.abs().max(y.abs()).max(z.abs());
                pick(farthest.simd_le(splat(simd, 1.0 + 2e-4)), splat(simd, 0.125), splat(simd, 0.0))
            }
            FootprintKernel::CatmullRom => catmull_rom(simd, x) * catmull_rom(simd, y) * catmull_rom(simd, z),
            FootprintKernel::Tabulated(table) => table.at(simd, x) * table.at(simd, y) * table.at(simd, z),
            FootprintKernel::Bilinear => self.bilinear(simd, depth),
            _ => cubic(simd, x) * cubic(simd, y) * cubic(simd, z),
        }
    }

    /// The depths between which rays are inside the cube, within others.
    #[inline(always)]
    pub(crate) fn inside(&self, simd: S, from: f32x16<S>, to: f32x16<S>) -> [f32x16<S>; 2] {
        let (mut from, mut to) = (from - self.depth, to - self.depth);
        let one = splat(simd, 1.0);
        for a in 0..3 {
            // Parallel to a face: all or nothing, by a slope that is as good as none.
            let step = self.step[a];
            let flat = step.abs().simd_lt(splat(simd, 1e-12));
            let inverse = one / pick(flat, splat(simd, 1e-12), step);
            let (p, q) = ((-one - self.at[a]) * inverse, (one - self.at[a]) * inverse);
            from = from.max(p.min(q));
            to = to.min(p.max(q));
        }
        [from + self.depth, to.max(from) + self.depth]
    }

    /// Depths at which rays cross the middle plane of each axis.
    #[inline(always)]
    pub(crate) fn middles(&self, simd: S) -> [f32x16<S>; 3] {
        let mut cross = self.at;
        for a in 0..3 {
            let flat = self.step[a].abs().simd_lt(splat(simd, 1e-12));
            cross[a] = splat(simd, self.depth) - self.at[a] / pick(flat, splat(simd, 1e-12), self.step[a]);
        }
        cross
    }
}

/// The cubic B-spline, stretched to [−1, 1] with an integral of 1.
#[inline(always)]
fn cubic<S: Simd>(simd: S, t: f32x16<S>) -> f32x16<S> {
    let (zero, x) = (splat(simd, 0.0), t.abs() * 2.0);
    let outer = (splat(simd, 2.0) - x).max(zero);
    let inner = (splat(simd, 1.0) - x).max(zero);
    (outer * outer * outer - inner * inner * inner * 4.0) * (1.0 / 3.0)
}

/// The Catmull-Rom cubic, stretched to [−1, 1] with an integral of 1.
#[inline(always)]
fn catmull_rom<S: Simd>(simd: S, t: f32x16<S>) -> f32x16<S> {
    let (zero, one, x) = (splat(simd, 0.0), splat(simd, 1.0), t.abs() * 2.0);
    let outer = (splat(simd, 2.0) - x).max(zero);
    let inner = (one - x).max(zero);
    outer * outer * (one - x) + inner * inner * (x * 4.0 - 2.0)
}

/// ∫ of a kernel between two depths, in kernel space times depth: by formula or by a rule that is exact for the pieces.
#[inline(always)]
pub(crate) fn whole<S: Simd>(
    simd: S,
    kernel: &FootprintKernel,
    axes: &Axes,
    block: &Block,
    at: &Splat,
    [from, to]: [f32x16<S>; 2],
) -> Option<f32x16<S>> {
    let to = to.max(from);
    match kernel {
        FootprintKernel::Radial(table) | FootprintKernel::Smooth(table, ..) => {
            let passing = Passing::new(simd, axes, block, at)?;
            // Nowhere negative; tables and rounding might be.
            let section = passing.up_to(simd, table, to) - passing.up_to(simd, table, from);
            Some(section.max(splat(simd, 0.0)) / passing.speed)
        }
        FootprintKernel::Bilinear => {
            let crossing = Crossing::new(simd, axes, block, at);
            let [from, to] = crossing.inside(simd, from, to);
            if !from.simd_lt(to).any_true() {
                return None;
            }
            // Cubics between the middle planes: two points of Gauss are exact on each.
            let [a, b, c] = crossing.middles(simd);
            let (a, b) = (a.min(b), a.max(b));
            let (b, c) = (b.min(c), b.max(c));
            let (a, b) = (a.min(b), a.max(b));
            let cuts = [from, a.max(from).min(to), b.max(from).min(to), c.max(from).min(to), to];
            let mut sum = splat(simd, 0.0);
            for k in 0..4 {
                let (middle, half) = ((cuts[k] + cuts[k + 1]) * 0.5, (cuts[k + 1] - cuts[k]) * 0.5);
                let aside = half * 0.577_350_26;
                sum += half * (crossing.bilinear(simd, middle - aside) + crossing.bilinear(simd, middle + aside));
            }
            Some(sum)
        }
        _ => {
            let crossing = Crossing::new(simd, axes, block, at);
            let [from, to] = crossing.inside(simd, from, to);
            if !from.simd_lt(to).any_true() {
                return None;
            }
            // Cubics are differentiable, sincs of a few waves: so many parts of three points of Gauss leave 10⁻⁵.
            let parts = match kernel {
                FootprintKernel::Box => return Some((to - from) * 0.125),
                FootprintKernel::Tabulated(_) => 12,
                _ => 10,
            };
            let half = (to - from) * (0.5 / parts as f32);
            let mut sum = splat(simd, 0.0);
            for part in 0..parts {
                let middle = from + half * (2 * part + 1) as f32;
                let aside = half * 0.774_596_7;
                let ends =
                    crossing.weight(simd, kernel, middle - aside) + crossing.weight(simd, kernel, middle + aside);
                sum += ends * (5.0 / 9.0) + crossing.weight(simd, kernel, middle) * (8.0 / 9.0);
            }
            Some(sum * half)
        }
    }
}
