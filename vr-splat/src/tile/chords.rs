//! Sections of points in sheets parallel to the image: one look-up for a chord, and a polynomial for each sheet that it goes through.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{pick, splat};

use crate::chord_table::{ChordCourse, ChordTable};
use crate::splat::Splat;

use super::Tile;
use super::footprint::Passing;

/// Chords of sixteen rays through a kernel.
struct Chords<S: Simd> {
    course: ChordCourse<S>,
    nearest: f32x16<S>,
    /// 1 over half their lengths in depth; 0 for rays that miss the kernel.
    per_half: f32x16<S>,
}

impl<S: Simd> Chords<S> {
    /// ∫ W up to a depth, from the chord's middle.
    #[inline(always)]
    fn up_to(&self, simd: S, depth: f32x16<S>) -> f32x16<S> {
        let u = (depth - self.nearest) * self.per_half;
        self.course.up_to(simd, u.max(splat(simd, -1.0)).min(splat(simd, 1.0)))
    }
}

impl Tile<'_> {
    /// Adds what lies in each of some sheets of a splat.
    #[inline(always)]
    pub(super) fn add_chords<S: Simd>(
        &mut self,
        simd: S,
        table: &ChordTable,
        number: usize,
        at: &Splat,
        optics: [f32; 4],
        [first, last]: [u32; 2],
    ) {
        let painter = self.painter;
        let block = &self.blocks[number];
        let (near, far) = (block.near.load(simd), block.far.load(simd));
        let Some(passing) = Passing::new(simd, &self.axes, block, at) else { return };
        let factor = block.stretch.load(simd) * at.weight / passing.speed;
        let [enter, leave] = passing.chord(simd);
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let half = (leave - enter) * 0.5;
        let meets = half.simd_gt(zero);
        let per_half = pick(meets, one / pick(meets, half, one), zero);
        let chords = Chords { course: table.at(simd, passing.distance), nearest: passing.nearest, per_half };
        let mut start = splat(simd, first as f32 * painter.distance).max(near).min(far);
        // ∫ up to `start`; `None` before it is known.
        let (mut before, mut known) = (zero, false);
        for sheet in first..=last {
            let end = splat(simd, (sheet + 1) as f32 * painter.distance).max(near).min(far);
            if !enter.max(start).simd_lt(leave.min(end)).any_true() {
                (start, known) = (end, false);
                continue;
            }
            let after = chords.up_to(simd, end);
            // Kernels of points are nowhere negative; polynomials and rounding might be.
            if !known {
                before = chords.up_to(simd, start);
            }
            let section = (after - before).max(zero) * factor;
            (before, known) = (after, true);
            self.add_section(
                simd,
                [sheet as usize, number],
                section,
                (at.value, optics),
                Some([[start, end], [enter, leave]]),
            );
            start = end;
        }
    }
}
