//! The walk of a ray through the cells of a majorant grid.

use glam::DVec3;
use vr_core::Ray;

use super::majorant_grid::{MajorantCell, MajorantGrid};

/// Part of a ray within one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// World distance at which it begins.
    pub start: f64,
    /// World distance at which it ends, not below `start`; +∞ in a medium without end.
    pub end: f64,
    /// Bounds of the extinction.
    pub cell: MajorantCell,
}

/// Stretches of a ray through a grid, in order: a digital differential analyser (Amanatides & Woo, "A fast voxel traversal algorithm", 1987).
///
/// # Examples
/// ```
/// use glam::DVec3;
/// use vr_core::Ray;
/// use vr_core::scattering::PhaseFunction;
/// use vr_light::{Coefficients, FunctionMedium, MajorantGrid, Walk};
///
/// let thicker = |_: DVec3, high: DVec3| [high.x - 0.25, high.x];
/// let wedge = FunctionMedium::new((DVec3::ZERO, DVec3::ONE), 1, PhaseFunction::Isotropic, [0.0, 1.0], |p, _, _| {
///     Coefficients { absorption: p.x, ..Coefficients::default() }
/// })?.with_ranges([4, 1, 1], thicker);
/// let ray = Ray { origin: DVec3::new(-1.0, 0.5, 0.5), direction: DVec3::X };
/// let grid = MajorantGrid::new(&wedge);
/// let bounds: Vec<f64> = Walk::new(&grid, &ray, f64::INFINITY).map(|stretch| stretch.cell.max).collect();
/// assert_eq!(bounds, [0.25, 0.5, 0.75, 1.0]);
/// # Ok::<(), vr_core::ParameterError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Walk<'a> {
    grid: &'a MajorantGrid,
    cell: [usize; 3],
    /// Steps of the cell along each axis: 1 forwards, `usize::MAX` (−1, wrapped) backwards.
    step: [usize; 3],
    /// World distances at which the ray leaves the cell along each axis, and those from one cell to the next.
    next: [f64; 3],
    spacing: [f64; 3],
    at: f64,
    end: f64,
}

impl<'a> Walk<'a> {
    /// The part of a ray up to the world distance `far`.
    #[inline]
    pub fn new(grid: &'a MajorantGrid, ray: &Ray, far: f64) -> Self {
        let (low, high) = grid.bounds();
        let (mut start, mut end) = (0.0f64, far);
        let inverse = ray.direction.to_array().map(|slope| 1.0 / slope);
        for a in 0..3 {
            let (from, to) = part_between(ray.origin[a], inverse[a], low[a], high[a]);
            (start, end) = (if from > start { from } else { start }, if to < end { to } else { end });
        }
        let mut walk =
            Self { grid, cell: [0; 3], step: [1; 3], next: [f64::INFINITY; 3], spacing: [0.0; 3], at: start, end };
        if start < end {
            walk.enter(ray, inverse, low);
        }
        walk
    }

    /// Finds the first cell, and the distances at which the ray leaves it.
    fn enter(&mut self, ray: &Ray, inverse: [f64; 3], low: DVec3) {
        let place = ray.origin + ray.direction * self.at;
        let (edges, per_unit) = (self.grid.edges(), self.grid.cells_per_unit());
        for a in 0..3 {
            let dims = self.grid.dims()[a];
            if dims == 1 {
                // Left where the box is, which `end` says.
                continue;
            }
            // `as` saturates: what rounding carries out of the box is in its outermost cells.
            let index = (((place[a] - low[a]) * per_unit[a]) as i32).clamp(0, dims as i32 - 1) as usize;
            self.cell[a] = index;
            if is_parallel(inverse[a]) {
                continue;
            }
            let forwards = inverse[a] > 0.0;
            self.step[a] = if forwards { 1 } else { usize::MAX };
            self.spacing[a] = edges[a] * inverse[a].abs();
            self.next[a] = (low[a] + (index + usize::from(forwards)) as f64 * edges[a] - ray.origin[a]) * inverse[a];
        }
    }
}

impl Iterator for Walk<'_> {
    type Item = Stretch;

    #[inline]
    fn next(&mut self) -> Option<Stretch> {
        if self.at >= self.end {
            return None;
        }
        let [x, y, z] = self.next;
        let axis = if x < y && x < z {
            0
        } else if y < z {
            1
        } else {
            2
        };
        let (start, cell) = (self.at, self.grid.cell(self.cell));
        // Rounding may put a face before the place reached: that stretch is empty.
        let next = self.next[axis];
        let end = if next < start { start } else { next };
        let end = if end < self.end { end } else { self.end };
        let index = self.cell[axis].wrapping_add(self.step[axis]);
        if index < self.grid.dims()[axis] && end < self.end {
            self.at = end;
            self.cell[axis] = index;
            self.next[axis] += self.spacing[axis];
        } else {
            self.at = self.end;
            // The last stretch reaches to the end: a face that rounding puts before it is the box's own.
            return Some(Stretch { start, end: self.end, cell });
        }
        Some(Stretch { start, end, cell })
    }
}

/// True for the inverse of a slope that leads nowhere: of 0, or of one so small that no distance of this world is long enough.
#[inline]
fn is_parallel(inverse: f64) -> bool {
    inverse.is_infinite()
}

/// Distances between which x + s·slope lies between two planes, perhaps infinitely far away; the wrong way round where it never does.
#[inline]
fn part_between(x: f64, inverse: f64, low: f64, high: f64) -> (f64, f64) {
    if is_parallel(inverse) {
        let inside = low <= x && x <= high;
        return if inside { (f64::NEG_INFINITY, f64::INFINITY) } else { (f64::INFINITY, f64::NEG_INFINITY) };
    }
    let (a, b) = ((low - x) * inverse, (high - x) * inverse);
    // NaN is never inside.
    if a <= b {
        (a, b)
    } else if b < a {
        (b, a)
    } else {
        (f64::INFINITY, f64::NEG_INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::{Coefficients, FunctionMedium};
    use crate::random::RandomStream;
    use vr_core::scattering::PhaseFunction;

    /// A medium whose cells are numbered by their bounds.
    fn numbered(resolution: [usize; 3]) -> MajorantGrid {
        let n = DVec3::from_array(resolution.map(|n| n as f64));
        let number = move |low: DVec3, high: DVec3| {
            let i = (0.5 * (low + high) * n).floor();
            (i.z * n.y + i.y) * n.x + i.x
        };
        let bounds = (DVec3::ZERO, DVec3::ONE);
        let medium =
            FunctionMedium::new(bounds, 1, PhaseFunction::Isotropic, [0.0, 1e9], |_, _, _| Coefficients::default());
        let range = move |low, high| [0.0, number(low, high)];
        MajorantGrid::new(&medium.unwrap().with_ranges(resolution, range))
    }

    #[test]
    fn stretches_are_the_cells_that_a_ray_meets() {
        let resolution = [7, 4, 5];
        let (grid, n) = (numbered(resolution), DVec3::from_array(resolution.map(|n| n as f64)));
        let mut random = RandomStream::new(1, 0, 0);
        for i in 0..2000 {
            let mut vector = || DVec3::new(random.uniform(), random.uniform(), random.uniform());
            let (origin, mut direction) = (3.0 * vector() - 1.0, vector() - 0.5);
            // Some rays run along axes, and some start on faces.
            if i % 3 == 0 {
                direction[i % 2] = 0.0;
            }
            let origin = if i % 5 == 0 { origin.round() } else { origin };
            let ray = Ray { origin, direction: direction.normalize() };
            let mut at = None;
            for stretch in Walk::new(&grid, &ray, 2.0) {
                assert!(at.is_none_or(|at| at == stretch.start) && stretch.start <= stretch.end && stretch.end <= 2.0);
                at = Some(stretch.end);
                // In the middle of a stretch that is longer than rounding, the cell is the one that the place is in.
                if stretch.end - stretch.start > 1e-9 {
                    let place = ray.origin + ray.direction * (0.5 * (stretch.start + stretch.end));
                    let cell = (place * n).floor().min(n - 1.0);
                    let on_face = (place * n - (place * n).round()).abs().min_element() < 1e-9;
                    let expected = (cell.z * n.y + cell.y) * n.x + cell.x;
                    assert!(on_face || stretch.cell.max == expected, "{ray:?}: {stretch:?} is not {expected}");
                }
            }
            let (from, to) = (0..3).fold((0.0f64, 2.0f64), |(from, to), a| {
                let (f, t) = part_between(ray.origin[a], 1.0 / ray.direction[a], 0.0, 1.0);
                (from.max(f), to.min(t))
            });
            assert_eq!(at, (from < to).then_some(to));
        }
    }

    #[test]
    fn boxes_without_end_are_walked_to_where_the_ray_goes() {
        let side = f64::INFINITY;
        let bounds = (DVec3::new(-side, -side, 0.0), DVec3::new(side, side, 1.0));
        let slab =
            FunctionMedium::new(bounds, 1, PhaseFunction::Isotropic, [0.0, 2.0], |_, _, _| Coefficients::default());
        let grid = MajorantGrid::new(&slab.unwrap().with_ranges([9, 9, 2], |_, _| [0.0, 2.0]));
        assert_eq!(grid.dims(), [1, 1, 2]);
        let walk = |direction: DVec3| {
            let ray = Ray { origin: DVec3::new(1e6, 0.0, 0.25), direction };
            Walk::new(&grid, &ray, f64::INFINITY).map(|s| (s.start, s.end)).collect::<Vec<_>>()
        };
        assert_eq!(walk(DVec3::Z), [(0.0, 0.25), (0.25, 0.75)]);
        assert_eq!(walk(DVec3::X), [(0.0, f64::INFINITY)]);
        assert_eq!(walk(DVec3::NAN), []);
    }
}
