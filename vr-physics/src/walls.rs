//! Discontinuities of a ray's medium: walls, jumps of the transfer function, and ends of the part that the field fills.

use vr_core::bound::{Bound, largest};
use vr_core::field::{FieldLine, LineModel, Poly};
use vr_core::transfer::{Optical, Segment};

use crate::optics::inside;
use crate::picked_color::PickedColor;
use crate::transport::{HALF_DEPTH, Place, Walk, band};

/// A side of a place where the medium jumps.
#[derive(Clone, Copy, Default)]
struct Side {
    /// Largest extinction there; 0 in a wall, whose depth in front is that of the other side.
    extinction: f64,
    emission: f64,
    /// True if opacity 1 may hold.
    wall: bool,
}

/// The largest depth per unit distance that is distinguished from a wall: α = 1 − e^(−80).
const MAX_DEPTH: f64 = 80.0;

impl<'a> Walk<'a> {
    /// Adds the error at the breakpoint `i`, where the field may jump: its place is only known to rounding.
    pub(crate) fn edge(&mut self, line: &dyn FieldLine, breakpoints: &[f64], i: usize) {
        let Some(&at) = breakpoints.get(i) else { return };
        let off = Bound::new(line.misplaced(at));
        if off == Bound::ZERO {
            return;
        }
        let side = |other: Option<&f64>| other.and_then(|&s| self.side(line, at, s, off)).unwrap_or_default();
        let behind = breakpoints.get(i + 1);
        let (left, right) = (side(i.checked_sub(1).map(|k| &breakpoints[k])), side(behind));
        let in_front = libm::exp(-self.result.depth);
        let depth = off * (left.extinction + right.extinction);
        self.depth_error += depth;
        let light = depth.min(1.0) * self.surface + off * (left.emission + right.emission);
        self.light_error += light * in_front;
        if right.wall && behind.is_some_and(|&s| !(off + line.misplaced(s)).within(s - at)) {
            // So thin a wall need not exist.
            self.light_error += 2.0 * in_front * self.brightest();
        }
    }

    /// The medium beside a breakpoint `at`, towards another one; `None` in vacuum.
    fn side(&self, line: &dyn FieldLine, at: f64, other: f64, off: Bound) -> Option<Side> {
        let near = at + (other - at) * (1.0 / 64.0);
        let model = if near > at { line.between(at, near) } else { line.between(near, at) }?;
        let slope = model.field.derivative();
        let slope = (Bound::new(slope.at(0.0)) + slope.spread(1.0)) * (2.0 / (near - at).abs());
        let value = model.field.at(if near > at { -1.0 } else { 1.0 });
        let moved = if slope == Bound::ZERO { Bound::ZERO } else { slope * off };
        let reach = (moved + model.error()).value();
        // A sliver between two faces has no reliable slope: there the voxels around it bound the values.
        let [min, max] = model.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let [low, high] = [value - reach, value + reach].map(|v| v.max(min).min(max));
        let touched = self.optics.touching(low, high);
        let factor = self.optics.largest_modulation();
        let side = |s: &Segment| {
            let ends = [low, high].map(|v| s.at(v.clamp(s.from, s.to)));
            let wall = self.optics.has_walls() && ends.iter().all(|o| o.opacity == 1.0);
            let extinction = if wall { 0.0 } else { largest(ends.map(|o| self.extinction(o.opacity))) * factor };
            Side { extinction, emission: largest(ends.iter().flat_map(|o| o.emission)), wall }
        };
        self.optics.of_rows(touched).map(side).reduce(|a, b| Side {
            extinction: a.extinction.max(b.extinction),
            emission: a.emission.max(b.emission),
            wall: a.wall || b.wall,
        })
    }

    /// κ of an opacity, a wall's being that of one that hardly lets anything through.
    fn extinction(&self, opacity: f64) -> f64 {
        self.optics.transfer.extinction(opacity).min(MAX_DEPTH / self.optics.transfer.unit_distance())
    }

    /// Chooses a side on a part where either side of a jump may hold: one that is no wall; and adds the error that this may cause.
    pub(crate) fn doubtful(&mut self, model: &LineModel, band: f64, half: f64, in_front: f64) -> &'a Segment {
        let optics = self.optics;
        let (value, reach) = (model.field.at(0.0), model.field.spread(1.0) + 2.0 * band);
        let (low, high) = (value - reach, value + reach);
        let all = optics.touching(low, high);
        let left = inside(all, model);
        let touched = if left.is_empty() { all } else { left };
        let is_wall = |s: &Segment| s.is_opaque() && optics.has_walls();
        // A mixture of rows is nowhere beyond all of them.
        let sides = || optics.of_rows(touched);
        let open = || sides().filter(|s| !is_wall(s));
        let ends = |s: &Segment| [low.clamp(s.from, s.to), high.clamp(s.from, s.to)].map(|v| s.at(v));
        let factors = self.modulation(model);
        let length = 2.0 * half;

        // Extinction, colour and emission are those of any value in reach: none is farther from what is taken than their ranges.
        let apart = |of: &dyn Fn(&Optical) -> f64, all: &mut dyn Iterator<Item = &Segment>| {
            let all = all.flat_map(ends).map(|o| of(&o));
            let (min, max) = all.fold((f64::INFINITY, Bound::ZERO), |(l, m), x| (l.min(x), m.max(x)));
            Bound::new((max.value() - min).max(0.0))
        };
        let extinction = |o: &Optical| self.extinction(o.opacity);
        let depth = apart(&extinction, &mut open()) * (length * factors[1]);
        let deepest = largest(open().flat_map(ends).map(|o| extinction(&o))) * length * factors[1];
        let by_channel = |of: fn(&Optical) -> [f64; 3], walls: bool| {
            let channel = |c: usize| apart(&|o| of(o)[c], &mut sides().filter(|s| walls || !is_wall(s)));
            channel(0).max(channel(1)).max(channel(2))
        };
        let color = by_channel(|o| o.color, false);
        let shine = by_channel(|o| o.emission, false);
        let walls = touched.iter().filter(|s| is_wall(s)).count();
        let light = if walls == touched.len() {
            // A wall whichever holds, of one colour or another.
            if optics.transfer.has_emission() { Bound::ZERO } else { by_channel(|o| o.color, true) }
        } else {
            depth.min(1.0) * self.brightest() + color * deepest.min(1.0) + shine * length
        };
        let mixed = walls > 0 && walls < touched.len();
        // Beside a wall all of the part's depth is in doubt: it may be wall, or stand before one.
        let (depth, light) =
            if mixed { (Bound::new(deepest), light + deepest.min(1.0) * self.brightest()) } else { (depth, light) };
        let largest_factor = optics.largest_color_factor();
        if walls < touched.len() {
            self.depth_error += depth;
        }
        self.light_error += light * (in_front * largest_factor);
        if mixed {
            self.pending_wall = self.pending_wall.max(2.0 * in_front * self.brightest());
        }
        // The part's own side, if it may be passed.
        let own = optics.segment_of(model, value);
        if walls == touched.len() || !is_wall(own) { own } else { touched.iter().find(|s| !is_wall(s)).unwrap_or(own) }
    }

    /// Adds the error of a wall that was touched within the field's error and not entered: it may or may not exist.
    pub(crate) fn touched_wall(&mut self) {
        if self.pending_wall > Bound::ZERO {
            self.light_error += self.pending_wall.value();
            self.depth_error = Bound::UNKNOWN;
            self.pending_wall = Bound::ZERO;
        }
    }

    /// The smallest and the largest factor on κ that the gradient's magnitude may give on a part.
    pub(crate) fn modulation(&self, model: &LineModel) -> [f64; 2] {
        let shading = match &self.optics.shading {
            Some((shading, _)) if !shading.gradient_opacity.is_empty() => shading,
            _ => return [1.0; 2],
        };
        let Some([min, max]) = magnitudes(model) else { return [1.0; 2] };
        let points = &shading.gradient_opacity;
        if !(min <= max && max.is_finite()) {
            let smallest = points.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
            return [smallest, shading.largest_modulation()];
        }
        let inside = points.iter().filter(|p| p.0 > min && p.0 < max).map(|p| p.1);
        let factors = inside.chain([min, max].map(|m| shading.modulation(m)));
        factors.fold([f64::INFINITY, 0.0], |[low, high], f| [low.min(f), high.max(f)])
    }

    /// True if every row that the gradient may choose on a part is clear in a segment.
    pub(crate) fn rows_are_clear(&self, model: &LineModel, segment: &Segment) -> bool {
        let transfer = self.optics.transfer;
        // NaN is taken for the largest.
        let [min, max] = magnitudes(model).unwrap_or([0.0, f64::NAN]);
        let rows = &transfer.rows()[transfer.row_mix(min.max(0.0)).lower..=transfer.row_mix(max).upper];
        let index = self.optics.index_of(segment);
        rows.iter().all(|row| row.transfer.segments()[index].is_clear())
    }

    /// Enters opacity 1 over a length: adds the colour at the point of entry, and ends the ray.
    pub(crate) fn wall(&mut self, (model, color): Place<'_>, segment: &Segment, s: f64, in_front: f64) {
        self.pending_wall = Bound::ZERO;
        let value = model.field.at(-1.0);
        let transfer = self.optics.transfer;
        // Up to the level, if there is one.
        let share = if self.deepest.is_finite() { (in_front - libm::exp(-self.deepest)).max(0.0) } else { in_front };
        let mut light = [0.0; 3];
        let mut off = Bound::ZERO;
        if !transfer.has_emission() {
            light = segment.at(value).color;
            if segment.to.is_finite() && segment.from.is_finite() {
                let slope = largest((0..3).map(|c| segment.end.color[c] - segment.start.color[c]));
                let slope = slope / (segment.to - segment.from);
                if slope > 0.0 {
                    // The value itself is rounded where it is taken from the polynomial.
                    off = Bound::new(band(model)) * (slope * self.optics.largest_color_factor());
                }
            }
            off += 16.0 * f64::EPSILON * self.surface;
            if let Some(color) = color {
                let own = PickedColor::at(color, -1.0, Bound::ZERO);
                light = std::array::from_fn(|c| light[c] * own.rgb[c]);
                off += Bound::new(own.error) * (transfer.brightest_color() * self.optics.largest_color_factor());
            }
            if let (Some((shading, ray)), Some(g)) = (&self.optics.shading, &model.gradient) {
                let gradient = g.map(|p| p.at(-1.0));
                let (factor, added) = ray.reflect(gradient);
                light = std::array::from_fn(|c| light[c] * factor[c] + added[c]);
                off += self.optics.shaded_error(gradient, model.slope_error() + rounding(g));
                off += 16.0 * f64::EPSILON * shading.power * self.surface;
            }
        }
        for c in 0..3 {
            self.result.radiance[c] += share * light[c];
        }
        self.light_error += off * share + self.front_error() * self.surface;
        if self.result.half_way == f64::INFINITY && self.deepest >= HALF_DEPTH * (1.0 - 4.0 * f64::EPSILON) {
            self.result.half_way = s;
        }
        self.result.depth = f64::INFINITY;
        self.result.pieces += 1;
        // The depth is infinite whatever was in front; what was doubtful there is in the light's error.
        self.depth_error = if self.depth_error.is_finite() { Bound::ZERO } else { Bound::UNKNOWN };
        self.ended = true;
    }
}

/// Smallest and largest magnitude that the gradient may have on a part, its error included; `None` without a gradient.
fn magnitudes(model: &LineModel) -> Option<[f64; 2]> {
    let g = model.gradient.as_ref()?;
    let square = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    let spread = square.spread(1.0);
    let off = (model.slope_error() * 2.0).value();
    let min = ((square.at(0.0) - spread).max(0.0).sqrt() - off).max(0.0);
    let max = (square.at(0.0) + spread).max(0.0).sqrt() + off;
    Some([min, max])
}

/// Rounding of a gradient's components.
fn rounding(gradient: &[Poly; 3]) -> Bound {
    let size = |p: &Poly| Bound::new(p.at(0.0)) + p.spread(1.0);
    gradient.iter().map(size).sum::<Bound>() * (4.0 * f64::EPSILON)
}
