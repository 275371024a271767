//! Sections of points in sheets parallel to the image: one look-up for a chord, and a polynomial for each sheet that it goes through. Where light depends on
//! gradients, those of the sections, too.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{pick, splat};

use crate::chord_table::{Chord, ChordCourse, ChordTable};
use crate::point_gradients::{GradientCourse, GradientSum};
use crate::point_mixture::{MIN_KERNEL, MIN_RIM_KERNEL};
use crate::rim_section::RimSection;
use crate::splat::Splat;

use super::Tile;
use super::footprint::{Passing, smallest};
use super::sheets::Section;

/// Chords of sixteen rays through a kernel.
pub(super) struct Chords<S: Simd> {
    pub(super) course: ChordCourse<S>,
    pub(super) nearest: f32x16<S>,
    /// 1 over half their lengths in depth; 0 for rays that miss the kernel.
    pub(super) per_half: f32x16<S>,
    pub(super) gradients: Option<ChordGradients<S>>,
}

/// Gradients along chords, but for the splat's weight.
pub(super) struct ChordGradients<S: Simd> {
    course: GradientCourse<S>,
    /// From the splat to the nearest places of the rays, in radii.
    across: [f32x16<S>; 3],
    /// Unit vectors along the rays.
    along: [f32x16<S>; 3],
    /// Half the lengths of the chords, in radii.
    half: f32x16<S>,
}

/// Integrals from the middle of chords up to a depth.
#[derive(Clone, Copy)]
pub(super) struct UpTo<S: Simd> {
    /// ∫ W.
    whole: f32x16<S>,
    /// Integral of the gradient, if that is asked for.
    gradient: Option<GradientSum<S>>,
}

/// Integrals over a section of chords.
pub(super) struct Between<S: Simd> {
    /// ∫ W.
    pub(super) whole: f32x16<S>,
    /// Integrals of the gradient across the chord, as a factor of its nearest place, and along it, if they are asked for.
    slope: Option<[f32x16<S>; 2]>,
}

impl<S: Simd> Chords<S> {
    /// Integrals up to a depth.
    #[inline(always)]
    pub(super) fn up_to(&self, simd: S, depth: f32x16<S>) -> UpTo<S> {
        self.up_to_part(simd, self.part_at(simd, depth))
    }

    /// Part of half the chord at a depth, within [−1, 1].
    #[inline(always)]
    fn part_at(&self, simd: S, depth: f32x16<S>) -> f32x16<S> {
        let u = (depth - self.nearest) * self.per_half;
        u.max(splat(simd, -1.0)).min(splat(simd, 1.0))
    }

    /// Integrals up to a part of half the chord.
    #[inline(always)]
    fn up_to_part(&self, simd: S, u: f32x16<S>) -> UpTo<S> {
        let whole = self.course.up_to(simd, u);
        #[expect(
            clippy::manual_map,
            reason = "a closure is not compiled for the vectors' instructions where it is not inlined"
        )]
        let gradient = match &self.gradients {
            Some(gradients) => Some(gradients.course.up_to(simd, u * gradients.half, whole)),
            None => None,
        };
        UpTo { whole, gradient }
    }

    /// ∫ W between two depths, and that of the gradient's parts across and along the chord.
    #[inline(always)]
    pub(super) fn between(&self, simd: S, before: &UpTo<S>, after: &UpTo<S>) -> Between<S> {
        // Kernels of points are nowhere negative; polynomials and rounding might be.
        let whole = (after.whole - before.whole).max(splat(simd, 0.0));
        // No closure: it is not compiled for the vectors' instructions where it is not inlined.
        let slope = match (before.gradient, after.gradient) {
            (Some(before), Some(after)) => Some([after.across - before.across, after.along - before.along]),
            _ => None,
        };
        Between { whole, slope }
    }

    /// The same for sums that are divided by each other: near rims to digits of their own, and nowhere 0 in a support.
    #[inline(always)]
    fn between_for_means(
        &self,
        simd: S,
        half: f32x16<S>,
        [start, end]: [f32x16<S>; 2],
        inside: f32x16<S>,
        difference: Between<S>,
    ) -> Between<S> {
        let ChordCourse::Bending { .. } = self.course else {
            return Between { whole: difference.whole.max(inside * MIN_KERNEL), ..difference };
        };
        let Between { whole, mut slope } = difference;
        let parts = [self.part_at(simd, start), self.part_at(simd, end)];
        let Some(rim) = RimSection::instead_of(simd, whole, half, parts) else { return difference };
        if let Some([across, along]) = &mut slope {
            *across = RimSection::pick(simd, whole, rim.across, *across);
            *along = RimSection::pick(simd, whole, rim.along, *along);
        }
        let whole = RimSection::pick(simd, whole, rim.whole, whole);
        Between { whole: whole.max(inside * MIN_RIM_KERNEL), slope }
    }

    /// ∫ of the gradient, times the splat's weight; `None` where it is not asked for.
    #[inline(always)]
    fn gradient(&self, between: &Between<S>, weight: f32) -> Option<[f32x16<S>; 3]> {
        let (Some(gradients), Some([across, along])) = (&self.gradients, between.slope) else { return None };
        let (turn, rise) = (across * weight, along * weight);
        let mut sum = gradients.across;
        for a in 0..3 {
            sum[a] = gradients.across[a] * turn + gradients.along[a] * rise;
        }
        Some(sum)
    }
}

impl Tile<'_> {
    /// Adds what lies in each of some sheets of a splat, and its gradient where `GRADIENTS` is set and the light depends on it.
    #[inline(always)]
    pub(super) fn add_chords<const GRADIENTS: bool, S: Simd>(
        &mut self,
        simd: S,
        table: &ChordTable,
        number: usize,
        at: &Splat,
        carried: (f32, [f32; 4]),
        sheets: [u32; 2],
    ) {
        let painter = self.painter;
        let block = &self.blocks[number];
        let (near, far) = (block.near.load(simd), block.far.load(simd));
        // The chords of the rays, and the courses of the kernel along them.
        let Some(passing) = Passing::new(simd, &self.axes, block, at) else { return };
        // Divisions are for the block, for the splat and one for the chord.
        let radius = 1.0 / at.scale;
        let per_speed = block.inverse_speed.load(simd) * radius;
        let factor = block.stretch.load(simd) * per_speed * at.weight;
        let chord = Chord::new(simd, passing.distance);
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (half, meets) = (chord.half * per_speed, chord.half.simd_gt(zero));
        let (enter, leave) = (passing.nearest - half, passing.nearest + half);
        // Rays that miss the kernel never enter it, and have left it.
        let enter = pick(meets, enter, splat(simd, f32::INFINITY));
        let leave = pick(meets, leave, splat(simd, f32::NEG_INFINITY));
        let gradient = if GRADIENTS { painter.summed_gradient() } else { None };
        let gradients = match gradient {
            Some(gradient) => {
                let speed = block.speed.load(simd);
                let mut along = [zero; 3];
                for a in 0..3 {
                    along[a] = block.along[a].load(simd) / speed;
                }
                let across = passing.across(simd, &self.axes, block, at);
                let course = gradient.along(simd, passing.distance);
                Some(ChordGradients { course, across, along, half: chord.half })
            }
            None => None,
        };
        let chords = Chords {
            course: table.at(simd, &chord),
            nearest: passing.nearest,
            per_half: chord.per_half * passing.speed,
            gradients,
        };
        // Sheets that any of the chords goes through: at the rim of a kernel these are fewer than the splat's. `as` saturates.
        let [front, back] = [smallest(enter), -smallest(-leave)].map(|depth| (depth * painter.per_distance) as u32);
        let (first, last) = (front.clamp(sheets[0], sheets[1]), back.clamp(sheets[0], sheets[1]));
        // Sections from sheet to sheet: differences of integrals up to their faces, half the whole chord's before it and behind it.
        let (from_start, to_end) = (chords.up_to_part(simd, -one), chords.up_to_part(simd, one));
        let mut start = splat(simd, first as f32 * painter.distance).max(near).min(far);
        let mut before = if start.simd_gt(enter).any_true() { chords.up_to(simd, start) } else { from_start };
        let mixes = painter.mixes();
        for sheet in first..=last {
            let end = splat(simd, (sheet + 1) as f32 * painter.distance).max(near).min(far);
            let is_end = sheet == last && !leave.simd_gt(end).any_true();
            let after = if is_end { to_end } else { chords.up_to(simd, end) };
            let mut between = chords.between(simd, &before, &after);
            if mixes {
                let inside = (leave.min(end) - enter.max(start)).max(zero) * passing.speed;
                between = chords.between_for_means(simd, chord.half, [start, end], inside, between);
            }
            let section = Section {
                whole: between.whole * factor,
                reach: Some([[start, end], [enter, leave]]),
                gradient: chords.gradient(&between, at.weight),
            };
            self.add_section(simd, [sheet as usize, number], section, carried);
            (before, start) = (after, end);
        }
    }
}
