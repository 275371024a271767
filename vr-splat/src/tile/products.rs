//! Sections of points along parallel rays, as sums of products of a ray's factor and a sheet's factor.
//!
//! Factors of rays are computed once for a splat and block, those of sheets are looked up once for a splat.

use fearless_simd::Simd;
use fearless_simd::prelude::*;
use vr_kernels::vector::{Lanes, pick, splat};

use crate::section_factors::{RayFactors, Row, SectionFactors};
use crate::splat::Splat;

use super::Tile;
use super::footprint::{parallel_square, smallest};
use super::fragments::CHANNELS;
use super::sheets::covers_all;

/// A splat's sections in the sheets that it is in.
pub(super) struct SheetProducts {
    /// Squared length of a unit of the view, in radii.
    square: f32,
    /// The radius, in units of the view.
    radius: f32,
    /// First and last sheet.
    sheets: [u32; 2],
    /// Factors of each sheet, times the splat's value.
    rows: Vec<Row>,
}

impl SheetProducts {
    pub(super) const NONE: Self = Self { square: 0.0, radius: 0.0, sheets: [0; 2], rows: Vec::new() };
}

impl Tile<'_> {
    /// Sets the factors of a splat's sheets, where rays are parallel and a unit of the view has a squared length of `square` in kernel space.
    #[inline(always)]
    pub(super) fn set_products<S: Simd>(
        &self,
        simd: S,
        (factors, square): (&SectionFactors, f32),
        products: &mut SheetProducts,
        at: &Splat,
        [first, last]: [u32; 2],
    ) {
        let painter = self.painter;
        products.square = square * (at.scale * at.scale);
        let speed = products.square.sqrt();
        products.radius = 1.0 / speed;
        products.sheets = [first, last];
        products.rows.clear();
        let factor = painter.view.unit as f32 * products.radius * at.weight * at.value;
        let mut before = factors.along(simd, part(first, painter.distance, at.place[2], speed));
        for sheet in first..=last {
            let after = factors.along(simd, part(sheet + 1, painter.distance, at.place[2], speed));
            products.rows.push(after.since(&before, factor));
            before = after;
        }
    }

    /// Adds a splat's sections to a block whose rays nothing cuts within its sheets.
    #[inline(always)]
    pub(super) fn add_products<S: Simd>(&mut self, simd: S, products: &SheetProducts, at: &Splat, number: usize) {
        let painter = self.painter;
        let one = splat(simd, 1.0);
        let square = parallel_square(simd, &self.blocks[number], at, products.square);
        let nearest = smallest(square);
        if nearest >= 1.0 {
            return;
        }
        let rays = RayFactors::new(simd, square);
        // Sheets that the longest of the chords goes through.
        let reach = (1.0 - nearest).sqrt() * products.radius;
        let [from, to] = products.sheets;
        let first = sheet_at((at.place[2] - reach) * painter.per_distance, from, to);
        let last = sheet_at((at.place[2] + reach) * painter.per_distance, from, to);
        let ring = painter.ring as usize;
        let start = self.place_of(0, number);
        let Some(channels) = self.sheets.get_mut(start..start + ring * CHANNELS) else { return };
        let (Some(filled), Some(touched)) = (self.filled.get_mut(..ring), self.touched.get_mut(..ring)) else { return };
        let Some(rows) = products.rows.get((first - from) as usize..=(last - from) as usize) else { return };
        let slots = Slots { ring, number };
        let is_filled = if rays.is_in_core(simd) {
            slots.add::<true, S>(simd, channels, filled, &rays, first, rows)
        } else {
            slots.add::<false, S>(simd, channels, filled, &rays, first, rows)
        };
        if is_filled {
            return;
        }
        // Record what the support covers of sheets that are not covered wholly.
        let half = (one - square).max(splat(simd, 0.0)).sqrt() * products.radius;
        let inside = square.simd_lt(one);
        let enter = pick(inside, splat(simd, at.place[2]) - half, splat(simd, f32::INFINITY));
        let leave = pick(inside, splat(simd, at.place[2]) + half, splat(simd, f32::NEG_INFINITY));
        for sheet in first..=last {
            let slot = sheet as usize & (ring - 1);
            if filled[slot] >> number & 1 == 1 {
                continue;
            }
            touched[slot] |= 1 << number;
            let start = splat(simd, sheet as f32 * painter.distance);
            let end = splat(simd, (sheet + 1) as f32 * painter.distance);
            if let [_, to_back, to_front] = &mut channels[slot * CHANNELS..][..CHANNELS] {
                let is_full = covers_all(simd, [to_back, to_front], [[start, end], [enter, leave]]);
                filled[slot] |= u64::from(is_full) << number;
            }
        }
    }
}

/// z of a sheet's face in a kernel, clamped to its support.
#[inline(always)]
fn part(face: u32, distance: f32, depth: f32, speed: f32) -> f32 {
    ((face as f32 * distance - depth) * speed).clamp(-1.0, 1.0)
}

/// Number of the sheet at a depth in units of sheets, clamped to a range. `as` saturates.
#[inline(always)]
fn sheet_at(depth: f32, from: u32, to: u32) -> u32 {
    (depth as i32).max(from as i32).min(to as i32) as u32
}

/// Slots of a block's sheets.
struct Slots {
    ring: usize,
    number: usize,
}

impl Slots {
    /// Adds sections to sheets from the first one on. Returns true if all of these are covered wholly.
    #[inline(always)]
    fn add<const CORE: bool, S: Simd>(
        &self,
        simd: S,
        channels: &mut [Lanes],
        filled: &[u64],
        rays: &RayFactors<S>,
        first: u32,
        rows: &[Row],
    ) -> bool {
        let mut open = 0;
        let mut slot = first as usize;
        for row in rows {
            slot &= self.ring - 1;
            if let (Some(sum), Some(filled)) = (channels.get_mut(slot * CHANNELS), filled.get(slot)) {
                *sum = Lanes::new(sum.load(simd) + rays.sum::<CORE>(row));
                open |= !filled;
            }
            slot += 1;
        }
        open >> self.number & 1 == 0
    }
}
