//! Parts of a ray that supports of points cover.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use glam::DVec3;
use vr_core::{Placement, Ray};
use vr_kernels::vector::{LANES, Lanes, Vectorized, pick, splat};

use super::cells::{PointCells, PointLevel};

/// Search for the parts of a ray that supports cover, ascending, by the lists of points in cells.
///
/// From where a part has come to, the support there that reaches furthest leads on: all that hold a place are in the list of its cell, and sixteen of them are looked at
/// at once. Only where none leads on, cells ahead are searched for the next one. So a ray looks at a cell about once a radius, and not at every
/// support that it goes through.
pub(super) struct CoveredParts<'a> {
    pub(super) cells: &'a PointCells,
    /// Placement of the field's lattice, whose axes are those of the world.
    pub(super) placement: &'a Placement,
    pub(super) ray: &'a Ray,
    /// Begin and end of the part of the ray that is looked at.
    pub(super) ends: [f64; 2],
}

/// Smallest distance that counts as a gap or as progress, in units of the points' spacing: some roundings of places in f32.
const MIN_WAY: f32 = 1e-6;

/// Part of a cell's edge by which a search goes beyond its face: within what lists take in beside their cells.
const BEYOND: f64 = 1e-6;

/// Place in a cell of the lists.
struct CellPlace {
    cell: usize,
    /// Offset from the cell's lower corner, in units of the spacing.
    offset: [f32; 3],
    /// Distance along the ray to the face at which it leaves the cell.
    exit: f64,
}

/// Supports along a ray as seen from a place, by distances in units of the spacing.
struct Ahead {
    /// Largest distance to which a support that holds the place reaches; 0 if none does.
    reach: f32,
    /// Entry and exit of the nearest support ahead; +∞ if the list has none.
    next: [f32; 2],
}

impl Vectorized for CoveredParts<'_> {
    type Output = Vec<[f64; 2]>;
    const AVX2_ALONE: bool = cfg!(test);

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Vec<[f64; 2]> {
        let (unit, gap) = (self.cells.spacing, f64::from(MIN_WAY) * self.cells.spacing);
        let [from, to] = self.ends;
        let (mut parts, mut begin, mut at) = (Vec::new(), from, from);
        while at < to {
            let mut reach = 0.0f32;
            for level in &self.cells.levels {
                let place = self.place(level, at);
                reach = reach.max(self.look(simd, level, &place).reach);
            }
            if reach > MIN_WAY {
                at += f64::from(reach) * unit;
                continue;
            }
            let next = self.next(simd, at);
            let entry = next.map_or(f64::INFINITY, |[entry, _]| entry);
            if entry > at + gap {
                if at > begin {
                    parts.push([begin, at.min(to)]);
                }
                begin = entry;
            }
            let Some([_, exit]) = next.filter(|[entry, _]| *entry < to) else { return parts };
            at = exit;
        }
        if to > begin {
            parts.push([begin, to]);
        }
        parts
    }
}

impl CoveredParts<'_> {
    /// Place at a distance along the ray in the cells of a level.
    #[inline(always)]
    fn place(&self, level: &PointLevel, distance: f64) -> CellPlace {
        let edge = self.placement.spacing() * f64::from(1u32 << level.shift);
        let at = (self.ray.origin + self.ray.direction * distance - self.placement.origin()) / edge;
        let last = DVec3::from_array(level.cells.map(|n| (n - 1) as f64));
        let cell = at.floor().clamp(DVec3::ZERO, last);
        let inside = at - cell;
        let mut exit = f64::INFINITY;
        for a in 0..3 {
            let along = self.ray.direction[a] / edge[a];
            let way = if along > 0.0 { 1.0 - inside[a] } else { -inside[a] };
            if along != 0.0 {
                exit = exit.min((way / along).max(0.0));
            }
        }
        let [x, y, z] = cell.to_array().map(|i| i as usize);
        let offset = (inside * edge / self.cells.spacing).as_vec3().to_array();
        CellPlace { cell: (z * level.cells[1] + y) * level.cells[0] + x, offset, exit }
    }

    /// Looks along the ray at the supports in the list of a place.
    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, level: &PointLevel, place: &CellPlace) -> Ahead {
        let [dx, dy, dz] = self.ray.direction.as_vec3().to_array();
        let [px, py, pz] = place.offset;
        let (zero, never) = (splat(simd, 0.0), splat(simd, f32::INFINITY));
        let (mut reach, mut entry, mut exit) = (zero, never, never);
        let numbers = f32x16::load_array(simd, std::array::from_fn(|i| i as f32));
        let entries = level.entries(place.cell);
        let [xs, ys, zs, squares] = &level.supports;
        for first in entries.clone().step_by(LANES) {
            let x = splat(simd, px) - sixteen(simd, xs, first);
            let y = splat(simd, py) - sixteen(simd, ys, first);
            let z = splat(simd, pz) - sixteen(simd, zs, first);
            let along = x * dx + y * dy + z * dz;
            let within = sixteen(simd, squares, first) - (x * x + y * y + z * z);
            let square = along * along + within;
            let is_crossed = square.simd_gt(zero) & numbers.simd_lt(splat(simd, (entries.end - first) as f32));
            let half = square.max(zero).sqrt();
            let (near, far) = (zero - along - half, half - along);
            let holds = is_crossed & within.simd_gt(zero);
            reach = pick(holds, reach.max(far), reach);
            let is_next = is_crossed & near.simd_gt(zero) & far.simd_gt(splat(simd, MIN_WAY)) & near.simd_lt(entry);
            (entry, exit) = (pick(is_next, near, entry), pick(is_next, far, exit));
        }
        let (entry, exit) = (Lanes::new(entry), Lanes::new(exit));
        let nearest = (0..LANES).fold(0, |best, i| if entry.0[i] < entry.0[best] { i } else { best });
        let reach = Lanes::new(reach).0.into_iter().fold(0.0, f32::max);
        Ahead { reach, next: [entry.0[nearest], exit.0[nearest]] }
    }

    /// Entry and exit of the next support behind a distance that none holds.
    #[inline(always)]
    fn next<S: Simd>(&self, simd: S, from: f64) -> Option<[f64; 2]> {
        let mut found: Option<[f64; 2]> = None;
        for level in &self.cells.levels {
            let beyond = BEYOND * (self.placement.spacing() * f64::from(1u32 << level.shift)).min_element();
            let mut at = from;
            while at < self.ends[1] && found.is_none_or(|[entry, _]| at < entry) {
                let place = self.place(level, at);
                let next = self.look(simd, level, &place).next.map(|way| at + f64::from(way) * self.cells.spacing);
                at += place.exit + beyond;
                // Behind the cell, another one may be nearer.
                if next[0] <= at {
                    found = found.filter(|best| best[0] <= next[0]).or(Some(next));
                    break;
                }
            }
        }
        found
    }
}

/// Sixteen numbers of a column.
#[inline(always)]
fn sixteen<S: Simd>(simd: S, column: &[f32], first: usize) -> f32x16<S> {
    f32x16::from_slice(simd, &column[first..first + LANES])
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use vr_core::{Clip, Field, IndexRay, PointKernel, PointMixing, PointSet, Volume};
    use vr_kernels::vector;

    use super::*;
    use crate::packet::points::engine::listed_cells;
    use crate::source::Source;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

        /// Places are covered where the set has a value: all but those nearer to an edge than f32 tells.
        #[test]
        fn parts_are_where_points_have_values(
            all in prop::collection::vec((prop::array::uniform3(-1.0f64..1.0), prop_oneof![0.02f32..0.1, 0.1f32..0.5]), 1..60),
            eye in prop::array::uniform3(-1.0f64..1.0),
            target in prop::array::uniform3(-1.0f64..1.0),
            share in prop::collection::vec(0.0f64..1.0, 64),
        ) {
            let positions = all.iter().map(|(p, _)| DVec3::from(*p)).collect();
            let radii: Vec<f32> = all.iter().map(|(_, r)| *r).collect();
            let ones = vec![1.0; all.len()];
            let points = PointSet::new(positions, radii, ones.clone(), ones, PointKernel::Cone).unwrap();
            let points = points.with_mixing(PointMixing::Mean).unwrap();
            let volume = Volume::from(points.clone());
            let source = Source::of(&volume).unwrap();
            let cells = listed_cells(&points, source.placement(), source.dims()).unwrap();
            let way = DVec3::from(target) - DVec3::from(eye);
            prop_assume!(way.length() > 0.1);
            let ray = Ray { origin: DVec3::from(eye), direction: way.normalize() };
            let part = IndexRay::new(&ray, source.placement(), source.dims(), &Clip::default(), f64::INFINITY);
            let Some(part) = part else { return Ok(()) };
            let ends = [part.start + part.offset, part.end + part.offset];
            let search = CoveredParts { cells: &cells, placement: source.placement(), ray: &ray, ends };
            let parts = vector::run(fearless_simd::Level::new(), search);
            prop_assert!(parts.as_flattened().is_sorted());
            let mut jumps = Vec::new();
            points.jumps(&ray, ends, &mut jumps);
            for at in share.into_iter().map(|share| ends[0] + share * (ends[1] - ends[0])) {
                // A ray that grazes a support enters it where rounding lets it.
                if parts.as_flattened().iter().chain(&jumps).any(|edge| (edge - at).abs() < 2e-3) {
                    continue;
                }
                let is_covered = parts.iter().any(|part| part[0] <= at && at <= part[1]);
                prop_assert_eq!(is_covered, points.value(ray.origin + ray.direction * at).is_some(), "at {} of {:?}", at, parts);
            }
            // Each edge is one of the field's, as far as f32 tells.
            let inner = parts.as_flattened().iter().filter(|&&s| s > ends[0] && s < ends[1]);
            for edge in inner {
                let off = jumps.iter().map(|jump| (jump - edge).abs()).fold(f64::INFINITY, f64::min);
                prop_assert!(off < 1e-3, "{edge} of {jumps:?}");
            }
        }
    }
}
