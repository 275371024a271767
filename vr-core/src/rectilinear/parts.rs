//! Parts of a ray in the bricks and segments of a rectilinear grid.

use glam::DVec3;

use super::bricks::{AxisCuts, Bricks};
use super::grid::RectilinearGrid;
use super::plane_walk::{BoxPart, PlaneWalk};
use crate::missing::VacuumCells;

/// Part of a ray in one brick of a rectilinear grid, and in one segment of each axis; none of it is vacuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectilinearPart {
    /// Distance at which it begins.
    pub from: f64,
    /// Distance at which it ends.
    pub to: f64,
    /// Number of the brick.
    pub brick: usize,
    /// Numbers of the segments along x, y and z.
    pub segments: [usize; 3],
    /// World length in which steps are counted: an index step of the ray, to the nearest power of √2 in mean steps of the axes. Cells of about one size
    /// share a lattice of steps, and faces between them make no short ones. A larger world has longer steps in proportion.
    pub spacing: f64,
}

/// Parts of a ray between two distances, ascending.
#[derive(Clone, Debug)]
pub struct RectilinearParts<'a> {
    grid: &'a RectilinearGrid,
    bricks: &'a Bricks,
    vacuum: Option<&'a VacuumCells>,
    /// Position at distance 0, and unit vector.
    ray: [DVec3; 2],
    walk: PlaneWalk,
    /// Walk through the cells of a brick with vacuum, and the part that they are of.
    cells: Option<(PlaneWalk, RectilinearPart)>,
    mean: f64,
    /// Segments that the spacing was found for last.
    segments: [usize; 3],
    spacing: f64,
}

impl RectilinearGrid {
    /// Parts of a ray in its box, between two distances of the ray.
    pub fn parts_along(&self, origin: DVec3, direction: DVec3, [from, to]: [f64; 2]) -> RectilinearParts<'_> {
        let bricks = self.bricks();
        let ray = [origin, direction];
        let at = origin + direction * from;
        let piece = |a: usize| bricks.cuts()[a].of_cells[self.axes()[a].cell(at[a])] as usize;
        let walk = PlaneWalk::new(planes(bricks), ray, [from, to], [piece(0), piece(1), piece(2)]);
        RectilinearParts {
            grid: self,
            bricks,
            vacuum: self.lattice().vacuum_cells(),
            ray,
            walk,
            cells: None,
            mean: self.mean_spacing(),
            segments: [usize::MAX; 3],
            spacing: 0.0,
        }
    }
}

impl RectilinearParts<'_> {
    /// Returns the next part in the cells of a brick that are not vacuum.
    fn next_of_cells(&mut self) -> Option<RectilinearPart> {
        let (walk, part) = self.cells.as_mut()?;
        let axes = self.grid.axes();
        let planes = [axes[0].places(), axes[1].places(), axes[2].places()];
        while let Some(BoxPart { from, to, number }) = walk.next(planes) {
            if self.vacuum.is_none_or(|vacuum| !vacuum.is_vacuum(number)) {
                return Some(RectilinearPart { from, to, ..*part });
            }
        }
        self.cells = None;
        None
    }

    /// Returns the length in which steps are counted in some segments.
    #[inline]
    fn spacing(&mut self, segments: [usize; 3]) -> f64 {
        if segments != self.segments {
            let width = |a: usize| self.bricks.cuts()[a].segments[segments[a]].width;
            let per_mean = self.ray[1] / DVec3::new(width(0), width(1), width(2)) * self.mean;
            self.segments = segments;
            self.spacing = self.mean * inverse_root_in_half_octaves(per_mean.length_squared());
        }
        self.spacing
    }
}

impl Iterator for RectilinearParts<'_> {
    type Item = RectilinearPart;

    #[inline]
    fn next(&mut self) -> Option<RectilinearPart> {
        loop {
            if self.cells.is_some()
                && let Some(part) = self.next_of_cells()
            {
                return Some(part);
            }
            let BoxPart { from, to, number } = self.walk.next(planes(self.bricks))?;
            let cuts = self.bricks.cuts();
            let [x, y, z] = [0, 1, 2].map(|a| cuts[a].pieces[number[a]].map(|n| n as usize));
            let (brick, segments) = (self.bricks.number([x[1], y[1], z[1]]), [x[0], y[0], z[0]]);
            let part = RectilinearPart { from, to, brick, segments, spacing: self.spacing(segments) };
            if !self.bricks.has_vacuum(brick) {
                return Some(part);
            }
            if self.bricks.stored_range(brick).is_some() {
                let [origin, direction] = self.ray;
                let (at, axes) = (origin + direction * from, self.grid.axes());
                // Rounding must not lead out of the piece.
                let cell = std::array::from_fn(|a| cell_in(&cuts[a], number[a], axes[a].cell(at[a])));
                let planes = [axes[0].places(), axes[1].places(), axes[2].places()];
                self.cells = Some((PlaneWalk::new(planes, self.ray, [from, to], cell), part));
            }
        }
    }
}

fn planes(bricks: &Bricks) -> [&[f64]; 3] {
    let [x, y, z] = bricks.cuts();
    [&x.planes, &y.planes, &z.planes]
}

/// Cell of a piece nearest to a cell.
fn cell_in(cuts: &AxisCuts, piece: usize, cell: usize) -> usize {
    let [segment, brick] = cuts.pieces[piece].map(|n| n as usize);
    let segment = &cuts.segments[segment];
    let first = segment.first.max(brick * Bricks::EDGE);
    let last = segment.end.min((brick + 1) * Bricks::EDGE) - 1;
    cell.clamp(first, last)
}

/// The power of √2 that is nearest to 1/√x, for x of any usual size.
#[inline]
fn inverse_root_in_half_octaves(x: f64) -> f64 {
    // The exponent of √2·x is log₂ x, rounded.
    let power = ((x * std::f64::consts::SQRT_2).to_bits() >> 52) as i64 - 1023;
    let half = -power;
    let octaves = f64::from_bits(((half.div_euclid(2) + 1023) as u64) << 52);
    if half.rem_euclid(2) == 0 { octaves } else { octaves * std::f64::consts::SQRT_2 }
}

#[cfg(test)]
mod tests {
    use super::super::grid::Centering;
    use super::*;

    #[test]
    fn spacings_are_half_octaves() {
        for k in -40..40 {
            let power = libm::exp2(-0.5 * f64::from(k));
            for factor in [0.72, 1.0, 1.4] {
                let found = inverse_root_in_half_octaves(libm::exp2(f64::from(k)) * factor);
                assert!((found / power - 1.0).abs() < 1e-15, "{k}: {found} for {power}");
            }
        }
    }

    /// The parts are where the field is, in order, and of the cells that their middles are in.
    #[test]
    fn parts_are_all_that_is_not_vacuum() {
        let places: Vec<f64> = (0..24).map(|k| f64::from(k) + 0.4 * f64::from(k * k % 7) / 7.0).collect();
        let axes = [places.clone(), places[..20].to_vec(), places[..3].iter().map(|x| 4.0 * x).collect()];
        let dims = [24, 20, 3];
        let mut values: Vec<f32> = (0..dims.iter().product::<usize>()).map(|i| (i * 37 % 101) as f32).collect();
        [100, 101, 700, 1403].into_iter().for_each(|i| values[i] = f32::NAN);
        let grid = RectilinearGrid::new(axes, values, Centering::Points).unwrap();
        let (low, high) = grid.bounds();
        for k in 0..200 {
            let t = |i: u32| f64::from((k * 7919 + i * 104_729) % 997) / 997.0;
            let ends = [0, 1].map(|i| {
                let mut at = low + (high - low) * DVec3::new(t(3 * i), t(3 * i + 1), t(3 * i + 2));
                // From face to face.
                at[(k % 3) as usize] = if i == 0 { low } else { high }[(k % 3) as usize];
                at
            });
            let length = ends[0].distance(ends[1]);
            let direction = (ends[1] - ends[0]) / length;
            let parts: Vec<_> = grid.parts_along(ends[0], direction, [0.0, length]).collect();
            assert!(parts.windows(2).all(|w| w[0].to <= w[1].from), "{parts:?}");
            let is_covered = |s: f64| parts.iter().any(|part| part.from <= s && s < part.to);
            for i in 0..500 {
                let s = length * (f64::from(i) + 0.5) / 500.0;
                let index = grid.to_index(ends[0] + direction * s).unwrap();
                let cell: [usize; 3] = std::array::from_fn(|a| (index[a] as usize).min(dims[a] - 2));
                let is_vacuum = grid.lattice().vacuum_cells().is_some_and(|vacuum| vacuum.is_vacuum(cell));
                // Not within rounding of a face.
                let is_inner = (index - index.floor()).min_element() > 1e-9;
                assert!(!is_inner || is_covered(s) != is_vacuum, "{s} of {parts:?}");
                let Some(part) = parts.iter().find(|part| part.from <= s && s < part.to) else { continue };
                for a in (0..3).filter(|_| is_inner) {
                    let segment = &grid.bricks().segments(a)[part.segments[a]];
                    assert!((segment.first..segment.end).contains(&cell[a]));
                }
                let brick = grid.bricks().number(cell.map(|c| c / Bricks::EDGE));
                assert!(!is_inner || part.brick == brick);
            }
        }
    }
}
