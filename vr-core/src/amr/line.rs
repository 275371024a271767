//! An adaptive mesh along a ray.

use glam::DVec3;

use super::element::Element;
use super::grid::AmrGrid;
use crate::bound::{Bound, largest};
use crate::box_tree::LocalLine;
use crate::clip_error::clip_error;
use crate::field::{Chord, Cut, FieldLine, LineModel, Poly, distinct_places};
use crate::ray::Ray;
use crate::view::Clip;

/// An adaptive mesh along a ray: cut at every face of an element, and between two of them a cubic.
///
/// Distances are world units behind the offset of its [`Chord`].
#[derive(Debug)]
pub(super) struct AmrLine<'a> {
    grid: &'a AmrGrid,
    gradients: bool,
    /// Place at distance 0, near the mesh, so that distances are small numbers.
    base: DVec3,
    /// Unit vector.
    direction: DVec3,
    /// World distance from the ray's own origin to the base.
    offset: f64,
    /// Bound on the rounding of a place on the ray, in world units.
    place_error: DVec3,
    /// Faces, ascending, each with a bound on its error.
    breaks: Vec<(f64, f64)>,
}

impl<'a> AmrLine<'a> {
    /// The mesh along a ray; `None` where the ray does not meet its box.
    pub(super) fn new(grid: &'a AmrGrid, ray: &Ray, clip: &Clip, far: f64, gradients: bool) -> Option<Self> {
        let [from, to] = ray.inside(clip)?;
        let part = [from, to.min(far)];
        let (low, high) = grid.bounds();
        let offset = (0.5 * low + 0.5 * high - ray.origin).dot(ray.direction);
        let (base, direction) = (ray.origin + ray.direction * offset, ray.direction);
        let base_error = 4.0 * f64::EPSILON * (ray.origin.abs().max_element() + offset.abs());
        let reach = low.abs().max(high.abs()) + grid.origin.abs() + base.abs();
        let mut line = Self {
            grid,
            gradients,
            base,
            direction,
            offset,
            place_error: DVec3::splat(base_error) + reach * (4.0 * f64::EPSILON),
            breaks: Vec::new(),
        };
        let [start, end] = line.ends(part.map(|s| s - offset), (ray, clip))?;
        let mut faces = Vec::new();
        line.each_face([start.0, end.0], |at, error| faces.push((at, error)));
        let mut places = Vec::new();
        faces.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
        distinct_places([start, end], faces.clone(), &mut places);
        let error_of = |at: f64| {
            let same = faces.partition_point(|f| f.0 < at)..faces.partition_point(|f| f.0 <= at);
            largest(faces[same].iter().map(|f| f.1))
        };
        line.breaks = places
            .iter()
            .map(|&at| {
                let own = [start, end].into_iter().filter(|e| e.0 == at).map(|e| e.1);
                (at, error_of(at).max(largest(own)))
            })
            .collect();
        Some(line)
    }

    /// Both ends of the part inside the box of the values, each with a bound on its error.
    fn ends(&self, part: [f64; 2], (ray, clip): (&Ray, &Clip)) -> Option<[(f64, f64); 2]> {
        let [mut start, mut end] = part.map(|at| (at, clip_error(ray, clip, self.offset, at)));
        let (low, high) = self.grid.bounds();
        for a in 0..3 {
            let (rate, off) = (self.direction[a], self.place_error[a]);
            let [near, far] = [low[a] - self.base[a], high[a] - self.base[a]];
            if rate == 0.0 {
                if near > 0.0 || far < 0.0 {
                    return None;
                }
                continue;
            }
            let [near, far] = if rate > 0.0 { [near, far] } else { [far, near] }.map(|x| (x / rate, off / rate.abs()));
            start = if near.0 > start.0 { near } else { start };
            end = if far.0 < end.0 { far } else { end };
        }
        let rounded = |(at, error): (f64, f64)| (at, error + f64::EPSILON * at.abs());
        (start.0 < end.0).then(|| [start, end].map(rounded))
    }

    /// Calls `each` with the distances between two, and their errors, at which the ray crosses faces of elements: of all levels, since those of finer
    /// ones lie on the same places.
    fn each_face(&self, part: [f64; 2], mut each: impl FnMut(f64, f64)) {
        let tree = self.grid.tree();
        let line = LocalLine { origin: self.base - tree.middle(), direction: self.direction, ends: part };
        tree.each_along(&line, |number| {
            let level = self.grid.blocks[number].level;
            let nodes = self.grid.nodes_of_block(number);
            let [low, high] = nodes.map(|n| self.grid.position(level, n) - self.base);
            let [mut from, mut to] = part;
            for a in (0..3).filter(|&a| self.direction[a] != 0.0) {
                let [s, t] = [low[a] / self.direction[a], high[a] / self.direction[a]];
                let slack = 2.0 * self.place_error[a] / self.direction[a].abs();
                (from, to) = (from.max(s.min(t) - slack), to.min(s.max(t) + slack));
            }
            if from > to {
                return;
            }
            for a in (0..3).filter(|&a| self.direction[a] != 0.0) {
                let (rate, edge) = (self.direction[a], (high[a] - low[a]) / (nodes[1][a] - nodes[0][a]) as f64);
                // Nodes that the ray passes within the block, and one more at each end.
                let index = |s: f64| (rate * s - low[a]) / edge;
                let (i, j) = (index(from).min(index(to)), index(from).max(index(to)));
                let first = nodes[0][a] + (i.floor().max(0.0) as i64);
                let last = nodes[1][a].min(nodes[0][a].saturating_add(j.ceil().max(0.0) as i64));
                for node in first..=last {
                    let mut at = nodes[0];
                    at[a] = node;
                    let s = (self.grid.position(level, at)[a] - self.base[a]) / rate;
                    if s > part[0] && s < part[1] {
                        each(s, self.place_error[a] / rate.abs() + f64::EPSILON * s.abs());
                    }
                }
            }
        });
    }

    fn at(&self, s: f64) -> DVec3 {
        self.base + self.direction * s
    }

    /// Element at a distance, and the values at its corners; `None` in vacuum.
    fn value_element(&self, s: f64) -> Option<(Element, [f64; 8])> {
        let element = self.grid.element_at(self.at(s))?;
        let corners = self.grid.corners::<f64>(element);
        corners.iter().all(|v| !v.is_nan()).then_some((element, corners))
    }
}

/// Numbers at the corners of an element, along the ray.
fn cubic(corners: &[f64; 8], axes: &[Poly; 3]) -> Poly {
    // Differences from one of them keep a constant exact.
    let base = corners[0];
    let one = Poly::constant(1.0);
    let mut sum = Poly::constant(0.0);
    for (i, value) in corners.iter().enumerate().skip(1).filter(|(_, v)| **v != base) {
        let weight = |a: usize| if i >> a & 1 == 1 { axes[a] } else { one + axes[a] * -1.0 };
        sum = sum + weight(0) * weight(1) * weight(2) * (value - base);
    }
    sum + Poly::constant(base)
}

/// Difference of the largest and the smallest, and the largest size.
fn spread(corners: &[f64; 8]) -> (f64, f64) {
    let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (high - low, low.abs().max(high.abs()))
}

impl FieldLine for AmrLine<'_> {
    fn chord(&self) -> Chord {
        Chord { start: self.breaks[0].0, end: self.breaks[self.breaks.len() - 1].0, offset: self.offset }
    }

    fn breakpoints(&self, out: &mut Vec<f64>) {
        out.extend(self.breaks.iter().map(|b| b.0));
    }

    fn between(&self, from: f64, to: f64) -> Option<LineModel> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let (element, corners) = self.value_element(middle)?;
        let edges = self.grid.spacing_of(element.level) / self.grid.centring().elements() as f64;
        let at = self.grid.coordinates(element, self.at(middle));
        let step = self.direction * half / edges;
        let axes: [Poly; 3] = std::array::from_fn(|a| Poly::new(&[at[a], step[a]]));
        // Displacement in the element; a trilinear function changes by no more than its spread along an edge, twice that a little outside.
        let position = DVec3::from_array(element.node.map(|n| n.unsigned_abs() as f64));
        let displaced = (self.place_error / edges + position * (8.0 * f64::EPSILON)).element_sum();
        let error = |corners: &[f64; 8]| {
            let (spread, size) = spread(corners);
            // Means of eight numbers are rounded even where all are the same, but not if they are f32.
            let rounding = if spread == 0.0 { 0.0 } else { 64.0 * spread + 16.0 * size };
            rounding * f64::EPSILON + 2.0 * spread * displaced
        };
        let gradient = self.gradients.then(|| {
            let corners = self.grid.corners::<DVec3>(element);
            [0, 1, 2].map(|a| {
                let component = corners.map(|g| if g.is_nan() { 0.0 } else { g[a] });
                let bound = Bound::new(error(&component)) + 64.0 * f64::EPSILON * spread(&component).1;
                (cubic(&component, &axes), bound.value())
            })
        });
        Some(LineModel {
            field: cubic(&corners, &axes),
            field_error: Bound::new(error(&corners)).value(),
            gradient: gradient.map(|g| g.map(|component| component.0)),
            gradient_error: gradient.map_or(0.0, |g| largest(g.map(|component| component.1))),
            limits: None,
            certain: true,
        })
    }

    fn misplaced(&self, at: f64) -> f64 {
        let place = self.breaks.partition_point(|b| b.0 < at);
        let Some(&(found, error)) = self.breaks.get(place).filter(|b| b.0 == at) else { return 0.0 };
        let is_vacuum = |from: Option<&(f64, f64)>, to: Option<&(f64, f64)>| match (from, to) {
            (Some(from), Some(to)) => self.value_element(0.5 * (from.0 + to.0)).is_none(),
            _ => true,
        };
        let here = Some(&self.breaks[place]);
        let before = place.checked_sub(1).and_then(|i| self.breaks.get(i));
        let borders = is_vacuum(before, here) || is_vacuum(here, self.breaks.get(place + 1));
        debug_assert_eq!(found, at);
        if borders { error } else { 0.0 }
    }

    /// Appends the places at which the ray comes out of vacuum: faces are far too many to name.
    fn cuts(&self, out: &mut Vec<(f64, Cut)>) {
        let mut before = true;
        for pair in self.breaks.windows(2) {
            let vacuum = self.value_element(0.5 * (pair[0].0 + pair[1].0)).is_none();
            if before && !vacuum {
                out.push((pair[0].0, Cut::Entry));
            }
            before = vacuum;
        }
    }
}
