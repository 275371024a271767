//! Walk along a ray through the blocks and cells of a grid.

use vr_core::filter::{Filter, Lattice, Nearest, Reconstruction};
use vr_core::{GridVolume, IndexRay, Real, Voxel};

use super::blocks::{Blocks, EDGE};
use super::crossed::Crossed;
use super::cubic::Cubic;
use super::looks::Looks;
use super::normals::{Gradients, Normals};
use super::piece_by_piece::Place;
use super::tint::{Tint, VoxelColors};
use super::wide_cells::WideCell;

/// Field that rays go through.
pub(super) struct Medium<'a, T> {
    /// The numbers under the filter: voxels, or coefficients for the B-spline.
    pub(super) lattice: Lattice<'a, T>,
    pub(super) filter: Filter,
    /// Its vacuum, and, for the B-spline, the voxels themselves.
    pub(super) volume: &'a GridVolume,
    pub(super) blocks: &'a Blocks,
    /// `None` where nothing looks at them.
    pub(super) gradients: Option<&'a Gradients>,
    /// `None` where voxels have no colours of their own.
    pub(super) colors: Option<VoxelColors<'a>>,
    /// Error that is promised.
    pub(super) error: f64,
}

impl<T> Medium<'_, T> {
    /// Returns the colours along a part of a cell that a ray crosses.
    pub(super) fn tint(&self, crossed: impl FnOnce() -> Crossed) -> Tint {
        self.colors.as_ref().map_or(Tint::White, |colors| colors.along(&crossed()))
    }
}

/// Sum or search along a ray, which takes its blocks and cells in turn, from the eye into the depth.
pub(super) trait Course {
    /// True if nothing more is to be done.
    fn is_done(&self) -> bool;

    /// Takes a block, through which the ray goes from `s` on, as a whole if it need not be looked at more closely; returns true if so.
    fn passes_block(&mut self, blocks: &Blocks, index: usize, s: f64, length: f64) -> bool;

    /// True if no value of a range matters.
    fn passes_values(&self, range: [f64; 2]) -> bool;

    /// Returns the error of the field that does not matter where its values are in a range.
    fn resolution(&self, range: [f64; 2]) -> f64;

    /// Takes a place at which the field jumps, begins or ends, and which is known up to a bound: lengths are off by that, not values.
    fn jump(&mut self, jump: &Jump);

    /// Takes a stretch of one stored number. `looks` gives gradient and colours along it.
    fn constant(&mut self, stored: f64, looks: impl FnOnce() -> Looks, s: f64, length: f64);

    /// Takes a cell, along which the field is the place's base + `cubic`.
    fn cell<R: Real>(&mut self, cubic: Cubic<R>, place: Place, looks: impl FnOnce() -> Looks, s: f64, length: f64);
}

/// Place at which a field jumps, or begins or ends.
pub(super) struct Jump {
    /// Bound of what it is off by.
    pub(super) misplaced: f64,
    /// Ranges of the values before and behind it; `None` where there is vacuum.
    pub(super) sides: [Option<[f64; 2]>; 2],
    /// True if what is behind it is so short that it may not exist.
    pub(super) short: bool,
}

/// Goes along a ray: over blocks at once where that is good enough, else cell by cell.
pub(super) fn along<R: Real, T: Voxel>(medium: &Medium<'_, T>, ray: &IndexRay, course: &mut impl Course) {
    let &Medium { ref lattice, filter, volume, blocks, gradients, .. } = medium;
    let (vacuum, nearest) = (volume.vacuum_cells(), filter == Filter::Nearest);
    let shifts: &[f64] = match (nearest, vacuum.is_some() || gradients.is_some()) {
        (false, _) => &[0.0],
        (true, false) => &[0.5],
        // Constant around each sample; vacuum begins, and gradients change, at the lattice.
        (true, true) => &[0.0, 0.5],
    };
    let mut planes = Planes::new(ray, shifts);
    let cells = lattice.dims.map(|n| n - 1);
    let misplaced = misplaced(ray, lattice.dims);
    let (mut s, mut last) = (ray.start, usize::MAX);
    while s < ray.end && !course.is_done() {
        let next = planes.next(s).min(ray.end);
        let middle = ray.at(0.5 * (s + next)).to_array();
        let cell: [usize; 3] = std::array::from_fn(|a| lattice.cell(a, middle[a]).0);
        let block = cell.map(|c| c / EDGE);
        let index = blocks.index(block);
        if index != last {
            let end = end_of_block(ray, block, cells).min(ray.end);
            if end > s {
                if course.passes_block(blocks, index, s, end - s) {
                    s = end;
                    continue;
                }
                last = index;
            }
        }
        let from = s;
        s = next;
        if next <= from || vacuum.is_some_and(|v| v.contains(middle)) {
            continue;
        }
        let crossed = || Crossed::new(ray, cell, [from, next], misplaced);
        match filter {
            Filter::Nearest => {
                let looks = || Looks {
                    normals: gradients.map_or(Normals::Absent, |g| g.along(lattice, &crossed(), true)),
                    tint: medium.tint(crossed),
                };
                course.constant(Nearest::value(lattice, middle), looks, from, next - from);
            }
            Filter::Trilinear => trilinear::<R, T>(medium, &crossed(), [from, next], course),
            Filter::BSpline | Filter::CatmullRom | Filter::Gaussian => {
                WideCell::new(medium, ray, cell, misplaced).cross::<R>([from, next], course);
            }
        }
    }
}

fn trilinear<R: Real, T: Voxel>(
    medium: &Medium<'_, T>,
    crossed: &Crossed,
    [from, to]: [f64; 2],
    course: &mut impl Course,
) {
    let &Crossed { cell, misplaced, .. } = crossed;
    let Medium { lattice, gradients, .. } = medium;
    let [row, slice] = [lattice.dims[0], lattice.dims[0] * lattice.dims[1]];
    let o = lattice.offset(cell[0], cell[1], cell[2]);
    let samples = &lattice.samples[o..];
    let corner = |i: usize| samples[i].to_f32();
    // The last one first: its check covers the others.
    let c7 = corner(slice + row + 1);
    let c =
        [corner(0), corner(1), corner(row), corner(row + 1), corner(slice), corner(slice + 1), corner(slice + row), c7];
    let (low, high) = c.iter().fold((c[0], c[0]), |(l, h), &x| (l.min(x), h.max(x)));
    let base = f64::from(c[0]);
    let looks = || Looks {
        normals: gradients.map_or(Normals::Absent, |gradients| gradients.along(lattice, crossed, false)),
        tint: medium.tint(|| *crossed),
    };
    if low == high {
        course.constant(base, looks, from, to - from);
        return;
    }
    if course.passes_values([f64::from(low), f64::from(high)]) {
        return;
    }
    let reach = (f64::from(high) - base).max(base - f64::from(low));
    let start = R::from_f32(c[0]);
    let part = crossed.part.map(|t| t.map(R::from_f64));
    let cubic = Cubic::across_box(c.map(|x| R::from_f32(x) - start), &part);
    // In a face, as far as rounding can tell, some samples have no weight.
    let limits = (!crossed.in_face).then_some([f64::from(low), f64::from(high)]);
    course.cell(cubic, Place { base, reach, limits, misplaced, off: 0.0 }, looks, from, to - from);
}

/// Returns the largest error of positions along a ray, in cells: a few units in the last place of the largest numbers that they are made of.
fn misplaced(ray: &IndexRay, dims: [usize; 3]) -> f64 {
    let max_size = dims.iter().fold(1.0f64, |m, &n| m.max(n as f64));
    let far = ray.start.abs().max(ray.end.abs());
    let size = (ray.direction * far).abs().max_element().max(ray.origin.abs().max_element());
    4.0 * f64::EPSILON * max_size.max(size)
}

/// Returns the distance at which a ray leaves a block.
fn end_of_block(ray: &IndexRay, block: [usize; 3], cells: [usize; 3]) -> f64 {
    let mut end = f64::INFINITY;
    for a in 0..3 {
        let d = ray.direction[a];
        if d != 0.0 {
            let first = block[a] * EDGE;
            let plane = if d > 0.0 { (first + EDGE).min(cells[a]) } else { first };
            end = end.min((plane as f64 - ray.origin[a]) / d);
        }
    }
    end
}

/// Planes that a ray crosses next, per axis and family.
struct Planes {
    families: [Family; 6],
    count: usize,
}

/// Family of parallel planes at unit distance.
#[derive(Clone, Copy, Default)]
struct Family {
    origin: f64,
    inverse: f64,
    /// Next plane.
    plane: f64,
    /// Distance at which the ray crosses it.
    s: f64,
    forward: f64,
}

impl Planes {
    fn new(ray: &IndexRay, shifts: &[f64]) -> Self {
        let mut planes = Self { families: [Family::default(); 6], count: 0 };
        for &shift in shifts {
            for a in 0..3 {
                let (origin, d) = (ray.origin[a] - shift, ray.direction[a]);
                if d == 0.0 {
                    continue;
                }
                let (inverse, forward) = (1.0 / d, d.signum());
                let mut plane = (origin + d * ray.start).floor() - forward;
                while (plane - origin) * inverse <= ray.start {
                    plane += forward;
                }
                let s = (plane - origin) * inverse;
                planes.families[planes.count] = Family { origin, inverse, plane, s, forward };
                planes.count += 1;
            }
        }
        planes
    }

    /// Returns the first crossing behind `s`.
    fn next(&mut self, s: f64) -> f64 {
        let mut first = f64::INFINITY;
        for f in &mut self.families[..self.count] {
            while f.s <= s {
                f.plane += f.forward;
                f.s = (f.plane - f.origin) * f.inverse;
            }
            first = first.min(f.s);
        }
        first
    }
}
