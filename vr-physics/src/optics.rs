//! One scene's transfer function and shading, as one ray meets them.

use vr_core::transfer::Segment;
use vr_core::{OpacityRule, RayShading, Shading, TransferFunction};

use vr_core::bound::{Bound, largest};
use vr_core::field::LineModel;

/// Selects, of some neighbouring segments, those that a stretch may be in over a length: the ones that its limits leave.
pub(crate) fn inside<'s>(segments: &'s [Segment], model: &LineModel) -> &'s [Segment] {
    let Some([low, high]) = model.limits else { return segments };
    let first = segments.partition_point(|s| s.to <= low);
    let end = segments.partition_point(|s| s.from < high);
    &segments[first..end.max(first)]
}

/// Transfer function and shading as one ray meets them.
pub struct Optics<'a> {
    /// The map from value to extinction and emission.
    pub transfer: &'a TransferFunction,
    /// The shading, and its part that is constant along the ray.
    pub shading: Option<(&'a Shading, RayShading<f64>)>,
    /// Values at which the transfer function has a kink.
    pub(crate) kinks: Vec<f64>,
    /// Values at which it jumps.
    pub(crate) jumps: Vec<f64>,
    /// Magnitudes of the gradient at which the medium has kinks.
    pub(crate) magnitudes: Vec<f64>,
}

impl<'a> Optics<'a> {
    /// Makes them for a ray, along which the shading's part is constant: see [`Shading::along`].
    pub fn new(transfer: &'a TransferFunction, shading: Option<(&'a Shading, RayShading<f64>)>) -> Self {
        let (mut kinks, mut jumps) = (Vec::new(), Vec::new());
        let rows = transfer.rows();
        for (i, pair) in transfer.segments().windows(2).enumerate() {
            let mut rows = rows.iter().map(|row| row.transfer.segments());
            let goes_on = pair[0].end == pair[1].start && rows.all(|row| row[i].end == row[i + 1].start);
            if goes_on { &mut kinks } else { &mut jumps }.push(pair[1].from);
        }
        let factors = shading.iter().flat_map(|(s, _)| s.gradient_opacity.iter().map(|p| p.0));
        let magnitudes = factors.chain(rows.iter().map(|row| row.gradient)).collect();
        Self { transfer, shading, kinks, jumps, magnitudes }
    }

    /// Segments of all rows where the given neighbouring ones are those of their upper bound; the given ones of a transfer function without rows.
    pub(crate) fn of_rows<'s>(&'s self, segments: &'s [Segment]) -> impl Iterator<Item = &'s Segment> {
        let rows = self.transfer.rows();
        let own = if rows.is_empty() { segments } else { &[] };
        let first = segments.first().map_or(0, |s| self.index_of(s));
        let range = first..first + segments.len();
        own.iter().chain(rows.iter().flat_map(move |row| &row.transfer.segments()[range.clone()]))
    }

    /// Index of a segment of the transfer function.
    pub(crate) fn index_of(&self, segment: &Segment) -> usize {
        self.transfer.segments().partition_point(|s| s.from < segment.from)
    }

    /// Largest light that a wall, or an infinitely deep medium, can send: none where emission is given on its own.
    pub(crate) fn brightest_surface(&self) -> f64 {
        if self.transfer.has_emission() { 0.0 } else { self.brightest_first() }
    }

    /// Largest light of a first crossing: the brightest colour, shaded as bright as can be.
    pub(crate) fn brightest_first(&self) -> f64 {
        let color = self.transfer.brightest_color();
        match &self.shading {
            None => color,
            Some((s, ray)) => {
                let light = total_light(ray);
                (color * (s.ambient + s.diffuse * light) + s.specular * light).max(color)
            }
        }
    }

    /// Largest emission per world unit, where it is given on its own.
    pub(crate) fn brightest_emission(&self) -> f64 {
        self.transfer.brightest_emission()
    }

    /// True if opacity 1 is a wall here.
    pub(crate) fn has_walls(&self) -> bool {
        self.transfer.rule() == OpacityRule::Power
    }

    /// The segments of the transfer function that hold somewhere between two values: at least one.
    pub(crate) fn touching(&self, low: f64, high: f64) -> &[Segment] {
        let all = self.transfer.segments();
        let first = all.partition_point(|s| s.to < low).min(all.len() - 1);
        let end = all.partition_point(|s| s.from <= high);
        &all[first..end.max(first + 1)]
    }

    /// Segment that holds at a computed value of a stretch, which rounding may have put beyond the stretch's limits.
    pub(crate) fn segment_of(&self, model: &LineModel, value: f64) -> &'a Segment {
        let at = self.transfer.segment_at(value);
        let Some([low, high]) = model.limits else { return at };
        match inside(self.transfer.segments(), model) {
            [first, ..] if at.to <= low => first,
            [.., last] if at.from >= high => last,
            _ => at,
        }
    }

    /// The largest factor on κ.
    pub(crate) fn largest_modulation(&self) -> f64 {
        self.shading.as_ref().map_or(1.0, |(s, _)| s.largest_modulation())
    }

    /// The largest factor on a colour.
    pub(crate) fn largest_color_factor(&self) -> f64 {
        self.shading.as_ref().map_or(1.0, |(s, ray)| (s.ambient + s.diffuse * total_light(ray)).max(1.0))
    }

    /// Bound on the error of the colour at a value whose error is at most `error`.
    pub(crate) fn color_error(&self, value: f64, error: Bound) -> Bound {
        if error == Bound::ZERO {
            return error;
        }
        if !error.is_finite() {
            return Bound::new(self.transfer.brightest_color());
        }
        let (low, high) = (value - error.value(), value + error.value());
        let here = self.transfer.at(value).color;
        let ends = self.touching(low, high).iter().flat_map(|s| [low, high].map(|v| s.at(v.clamp(s.from, s.to)).color));
        let apart = ends.map(|c| Bound::new(largest((0..3).map(|i| c[i] - here[i])))).fold(Bound::ZERO, Bound::max);
        // An error below the value's own rounding does not show at the ends.
        let unseen = error.min(4.0 * f64::EPSILON * value);
        let steepest = self.touching(low, high).iter().filter(|s| (s.to - s.from).is_finite()).map(|s| {
            let rise = largest((0..3).map(|c| s.end.color[c] - s.start.color[c]));
            Bound::new(rise / (s.to - s.from))
        });
        apart + unseen * steepest.fold(Bound::ZERO, Bound::max)
    }

    /// Bound on the error of reflected light if that of each component of the gradient is at most `error`.
    pub(crate) fn shaded_error(&self, gradient: [f64; 3], error: Bound) -> Bound {
        if error == Bound::ZERO {
            return error;
        }
        let largest = largest(gradient);
        let size = if largest > 0.0 {
            largest * gradient.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
        } else {
            0.0
        };
        self.turned(error * 4.0 / size)
    }

    /// Bound on the error of reflected light if the normal's error is a vector no longer than `turn`.
    pub(crate) fn turned(&self, turn: Bound) -> Bound {
        let Some((s, ray)) = &self.shading else { return Bound::ZERO };
        if turn == Bound::ZERO {
            return turn;
        }
        let light = total_light(ray);
        // |x^p − y^p| ≤ p |x − y| on [0, 1] for p ≥ 1, and ≤ |x − y|^p below.
        let highlight = match s.power {
            0.0 => Bound::ZERO,
            p if p >= 1.0 => turn * p,
            p => Bound::new(libm::pow(turn.value(), p)),
        };
        let diffuse = turn * (s.diffuse * light * self.transfer.brightest_color());
        (diffuse + highlight * (s.specular * light)).min(self.brightest_first())
    }
}

/// Sum of the largest component of each light.
fn total_light(shading: &RayShading<f64>) -> f64 {
    shading.lights.iter().map(|l| largest(l.color)).sum()
}
