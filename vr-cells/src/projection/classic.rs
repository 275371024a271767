//! Light of a cell by the classic approximation: opacity and colour of the thickest point, linear from there to the rim.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{pick, splat};

use super::line::Line;
use super::outline::Outline;
use super::outline_lanes::{LocalLine, OutlineLanes};
use super::samples::{Numbers, Samples};
use super::screen_mesh::{ScreenVertex, area};
use super::tile::Painter;

/// A cell's light.
pub(super) struct ClassicCell {
    /// Opacity at the apex.
    opacity: f32,
    /// Colour in each triangle between the apex and an edge of the outline.
    colors: [[LocalLine; 3]; 4],
    /// Edges of the outline.
    count: usize,
}

impl ClassicCell {
    /// The light of a cell, of a tile that begins at `origin`.
    pub(super) fn new(
        painter: &Painter<'_>,
        (outline, corners): (&Outline, &[ScreenVertex; 4]),
        lanes: &OutlineLanes,
        origin: [u32; 2],
    ) -> Self {
        // Front and back at the apex.
        let base = [outline.base.depth.at(outline.apex), outline.base.value.at(outline.apex)];
        let other = [base[0] + outline.rise[0], base[1] + outline.rise[1]];
        let (values, thickness) = match painter.focus {
            None => ([base[1], other[1]], outline.rise[0].abs()),
            Some(focus) => {
                let along = painter.along(focus, [0, 1].map(|a| outline.apex[a] + f64::from(origin[a])));
                ([base[1] / base[0], other[1] / other[0]], (1.0 / base[0] - 1.0 / other[0]).abs() * along)
            }
        };
        let optics = |place: f64| painter.transfer.at(painter.table.value(place));
        let [a, b] = values.map(optics);
        let extinction = 0.5 * (painter.transfer.extinction(a.opacity) + painter.transfer.extinction(b.opacity));
        let apex_color: [f64; 3] = std::array::from_fn(|c| 0.5 * (a.color[c] + b.color[c]));
        let color_of = |i: usize| {
            let ScreenVertex { depth, value, .. } = corners[i];
            optics(if painter.focus.is_some() { value / depth } else { value }).color
        };
        let triangle = |k: usize| {
            let ends = outline.edges[k].ends;
            let at = [corners[ends[0]].at, corners[ends[1]].at, outline.apex];
            let rim = ends.map(color_of);
            let twice_area = area(at);
            std::array::from_fn(|c| {
                let line = if twice_area > 0.0 {
                    Line::through(at, [rim[0][c], rim[1][c], apex_color[c]], twice_area)
                } else {
                    Line::constant(apex_color[c])
                };
                LocalLine::new(&line, lanes.centre)
            })
        };
        let opacity = -libm::expm1(-extinction * thickness) as f32;
        let colors = [triangle(0), triangle(1), triangle(2), triangle(outline.count - 1)];
        Self { opacity, colors, count: outline.count }
    }

    /// Adds the light to some samples.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &self,
        simd: S,
        samples: &mut Samples,
        numbers: &Numbers,
        outline: &OutlineLanes,
        places: [f32x16<S>; 2],
        min_clear: f32,
    ) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        // The triangle of a sample is that whose edge leaves the least of the thickness.
        let mut least = splat(simd, f32::INFINITY);
        let mut color = [zero; 3];
        for i in 0..self.count {
            let part = outline.edge(i, places);
            let is_least = part.simd_lt(least);
            least = pick(is_least, part, least);
            for c in 0..3 {
                color[c] = pick(is_least, self.colors[i][c].at(places), color[c]);
            }
        }
        let mut sums = samples.load(simd, numbers);
        let before = sums.clear;
        let alpha = outline.share(simd, places) * self.opacity;
        for c in 0..3 {
            sums.light[c] += before * alpha * color[c].max(zero);
        }
        sums.clear = before * (one - alpha);
        samples.store(numbers, &sums);
        samples.close_dark(simd, numbers, [before, sums.clear], min_clear);
    }
}
