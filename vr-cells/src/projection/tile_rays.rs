//! Rays of a tile: their length for a unit of depth, and where they begin and end.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{pick, rows_at, splat};

use super::samples::{COUNT, Numbers, ROW};
use super::steps::Segments;
use super::tile::Painter;

/// Rays of a tile, sample by sample: length for a unit of depth, distances at which the ray begins and ends, and a number that means nothing.
pub(super) struct TileRays(Vec<[f32; 4]>);

/// Those of sixteen samples.
#[derive(Clone, Copy)]
pub(super) struct Ends<S: Simd> {
    /// Length of each ray for a unit of depth, in perspective.
    pub(super) along: f32x16<S>,
    near: f32x16<S>,
    far: f32x16<S>,
}

impl TileRays {
    /// The rays of a tile; `None` if they are parallel and nothing cuts them.
    pub(super) fn new(painter: &Painter<'_>, origin: [u32; 2], [width, height]: [u32; 2]) -> Option<Self> {
        if painter.focus.is_none() && !painter.is_cut {
            return None;
        }
        let mut rays = vec![[0.0; 4]; COUNT];
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let [along, near, far, _] = &mut rays[((y << ROW) + x) as usize];
            let sample = [origin[0] + x, origin[1] + y];
            if let Some(focus) = painter.focus {
                *along = painter.along(focus, sample.map(|n| f64::from(n) + 0.5)) as f32;
            }
            // Where nothing is left, both ends are the eye.
            if painter.is_cut
                && let Some([from, to]) = painter.ends(sample)
            {
                (*near, *far) = (from as f32, to as f32);
            }
        }
        Some(Self(rays))
    }

    /// The rays of some samples.
    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, numbers: &Numbers) -> Ends<S> {
        let [along, near, far, _] = rows_at(simd, numbers.map(|n| n as i32), |n| &self.0[n % COUNT]);
        Ends { along, near, far }
    }
}

impl<S: Simd> Ends<S> {
    /// The parts of segments between both ends.
    #[inline(always)]
    pub(super) fn cut(&self, simd: S, segments: &Segments<S>) -> Segments<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (near, length) = (segments.near, segments.length);
        let is_empty = length.simd_le(zero);
        let per_length = pick(is_empty, zero, one / pick(is_empty, one, length));
        let part = |at: f32x16<S>| ((at - near) * per_length).max(zero).min(one);
        let (start, end) = (part(self.near), part(self.far));
        let [a, b] = segments.ends;
        let rise = b - a;
        Segments {
            ends: [a + rise * start, a + rise * end],
            near: near + length * start,
            length: (length * (end - start)).max(zero),
        }
    }
}
