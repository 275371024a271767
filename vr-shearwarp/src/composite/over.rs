//! Samples composited front to back, onto texels that are not opaque yet.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x4, f32x16, i32x16};
use vr_kernels::vector::{
    LANES, packed, pick, share_to_level, source_weight_and_opacity, splat, step_of_thickness, transpose,
    transpose_packed,
};

use super::cells::{Columns, Edges, Places, SPAN, STEPS_F32, values};
use super::half::{note_half, place_halves};
use super::kernel::{Added, Chunk, Kernel, Row, Seen};
use super::ray_lights::RayLights;
use super::short_run::MAX_SHORT;
use crate::codes::Code;
use crate::lengths::Lengths;
use crate::optics::Optics;
use crate::reflections::Reflection;

/// Kinds of shading: none; by a table, where normals reflect the same light along all rays; or for each ray by itself.
pub(crate) const UNSHADED: u8 = 0;
pub(crate) const BY_TABLE: u8 = 1;
pub(crate) const BY_RAYS: u8 = 2;

/// Over, and accumulate. `PRE_CLASSIFIED`: voxels are classified, and then interpolated. `SHADING`: one of the constants above.
pub(crate) struct Over<'a, P: Code, const PRE_CLASSIFIED: bool, const SHADING: u8> {
    pub(crate) voxels: &'a [P],
    /// Normals in the order of the voxels, and what reflects at each; empty where nothing is shaded.
    pub(crate) normals: &'a [u16],
    pub(crate) reflections: &'a [Reflection],
    /// Lights for shading by rays.
    pub(crate) rays: Option<&'a RayLights>,
    pub(crate) optics: &'a Optics,
    pub(crate) lengths: &'a Lengths<P>,
    /// From this opacity on a texel is opaque.
    pub(crate) termination: f32,
    /// No texel gets more opaque than this.
    pub(crate) level: f32,
    /// Opacity at which a texel sees something: a half; infinite where the level is below.
    pub(crate) half: f32,
}

impl<P: Code, const PRE_CLASSIFIED: bool, const SHADING: u8> Kernel for Over<'_, P, PRE_CLASSIFIED, SHADING> {
    const CLOSES: bool = true;
    // Classified voxels, and what they reflect to rays, are of sixteen columns.
    const COLUMNS: usize = if PRE_CLASSIFIED || SHADING == BY_RAYS { LANES } else { SPAN };

    #[inline(always)]
    fn add<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        edges: &Edges<N>,
        columns: Columns,
        at: Chunk,
        shares: Option<&[f32; LANES]>,
        row: &mut Row<'_>,
    ) -> Added {
        if SHADING != BY_RAYS && UNIT && at.n <= MAX_SHORT && shares.is_none() && self.lengths.ratios.is_none() {
            return self.short_run(simd, edges, columns, &at, row);
        }
        let table = &self.lengths.table;
        let places = columns.places::<S, UNIT>(simd, edges.last);
        let mut samples = if PRE_CLASSIFIED && SHADING == BY_RAYS {
            self.of_voxels_by_rays::<S, N, UNIT>(simd, table, edges, &places, &at)
        } else if PRE_CLASSIFIED {
            self.of_voxels::<S, N, UNIT>(simd, table, edges, &places, at.n)
        } else {
            self.of_values::<S, N, UNIT>(simd, table, edges, &places, at.n)
        };
        if SHADING == BY_RAYS && !PRE_CLASSIFIED {
            samples = self.lit_by_rays::<S, N, UNIT>(simd, edges, &places, &at, samples);
        }
        let shares = shares.map(|shares| f32x16::load_array_ref(simd, shares).max(splat(simd, 0.0)));
        if let Some(ratios) = &self.lengths.ratios {
            let mut ratio = ratios.lanes(simd, at.x, at.y);
            if let Some(shares) = shares {
                ratio *= shares;
            }
            samples =
                if PRE_CLASSIFIED { step_of_thickness(simd, samples, ratio) } else { of_depth(simd, samples, ratio) };
        } else if let Some(shares) = shares {
            samples = step_of_thickness(simd, samples, shares);
        }
        self.composite(simd, samples, &at, row)
    }

    fn end<S: Simd>(&self, simd: S, row: &mut Row<'_>) {
        place_halves(simd, row);
    }

    /// The depth at which opacity reaches a half, the medium homogeneous around its slice.
    fn finish(&self, seen: &Seen<'_>, _: &mut [f32; 4]) -> f64 {
        let [begin, end] = seen.slices.interval(seen.depth_of_slice(), seen.chord);
        begin + seen.fraction * (end - begin)
    }
}

/// Samples of [`Entry::Depth`](crate::optics::Entry) that stand for that much of the table's length.
#[inline(always)]
pub(super) fn of_depth<S: Simd>(simd: S, [r, g, b, tau]: [f32x16<S>; 4], ratio: f32x16<S>) -> [f32x16<S>; 4] {
    let tau = tau * ratio;
    let (out, alpha) = source_weight_and_opacity(simd, tau);
    let shines = ratio * out;
    [r * shines, g * shines, b * shines, alpha]
}

impl<P: Code, const PRE_CLASSIFIED: bool, const SHADING: u8> Over<'_, P, PRE_CLASSIFIED, SHADING> {
    /// Sixteen samples, of which `n` count; the others are nothing.
    #[inline(always)]
    pub(super) fn of_values<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        table: &P::Table,
        edges: &Edges<N>,
        places: &Places<S>,
        n: usize,
    ) -> [f32x16<S>; 4] {
        let value = values::<S, P, N, UNIT>(simd, self.voxels, edges, places);
        // The last row is nothing.
        let nothing = P::LAST as f32;
        let place = (value * self.optics.scale + self.optics.bias).max(splat(simd, 0.0)).min(splat(simd, nothing));
        let counts = f32x16::load_array_ref(simd, &STEPS_F32).simd_lt(splat(simd, n as f32));
        let place: i32x16<S> = pick(counts, place, splat(simd, nothing)).to_int();
        // Read from memory one by one: taken from the register they would all wait for the one unit that can do that.
        let place = std::hint::black_box(place.to_array());
        let mut rows = [f32x4::splat(simd, 0.0); LANES];
        for i in 0..LANES {
            rows[i] = f32x4::load_array_ref(simd, P::row(table, place[i] as u32 as usize));
        }
        if SHADING == BY_TABLE {
            let weight = places.weight.to_array();
            for i in 0..n {
                rows[i] = self.lit(simd, edges, places.first + places.cell[i] as usize, weight[i], rows[i]);
            }
        }
        transpose(rows)
    }

    #[inline(always)]
    fn of_voxels<S: Simd, const N: usize, const UNIT: bool>(
        &self,
        simd: S,
        table: &P::Table,
        edges: &Edges<N>,
        places: &Places<S>,
        n: usize,
    ) -> [f32x16<S>; 4] {
        // Sixteen columns, summed across the edges; then along them.
        let mut columns = [splat(simd, 0.0); 4];
        for e in 0..N {
            let from = edges.at[e] + places.first;
            let voxels = &self.voxels[from..][..LANES];
            let mut rows = [f32x4::splat(simd, 0.0); LANES];
            for i in 0..LANES {
                rows[i] = f32x4::load_array_ref(simd, self.row(table, voxels[i]));
            }
            if SHADING == BY_TABLE {
                let normals = &self.normals[from..][..LANES];
                for i in 0..LANES {
                    rows[i] = self.lit_voxel(simd, rows[i], normals[i]);
                }
            }
            let rows = packed(rows);
            for quad in 0..4 {
                columns[quad] += rows[quad] * edges.of_voxels[e];
            }
        }
        let counts = f32x16::load_array_ref(simd, &STEPS_F32).simd_lt(splat(simd, n as f32));
        let nothing = splat(simd, 0.0);
        let mut samples = transpose_packed(columns);
        for c in 0..4 {
            samples[c] = pick(counts, places.between::<UNIT>(simd, samples[c]), nothing);
        }
        samples
    }

    /// A voxel, classified.
    #[inline(always)]
    pub(super) fn row<'t>(&self, table: &'t P::Table, voxel: P) -> &'t [f32; 4] {
        P::row(table, voxel.place(self.optics.codes_begin()))
    }

    /// A classified voxel, shaded.
    #[inline(always)]
    pub(super) fn lit_voxel<S: Simd>(&self, simd: S, sample: f32x4<S>, normal: u16) -> f32x4<S> {
        let Reflection { factor, added } = &self.reflections[usize::from(normal)];
        sample * f32x4::load_array_ref(simd, factor) + f32x4::load_array_ref(simd, added) * sample.to_array()[3]
    }

    /// Adds samples behind what texels hold that are not opaque.
    #[inline(always)]
    pub(super) fn composite<S: Simd>(
        &self,
        simd: S,
        [r, g, b, alpha]: [f32x16<S>; 4],
        at: &Chunk,
        row: &mut Row<'_>,
    ) -> Added {
        let (mine, termination) = ((1 << at.n) - 1, splat(simd, self.termination));
        let opacity = row.lanes(3, at.x);
        let before = f32x16::load_array_ref(simd, opacity);
        let open = before.simd_lt(termination);
        let clear = pick(open, splat(simd, 1.0) - before, splat(simd, 0.0));
        let after = before + alpha * clear;
        let closed = (open & after.simd_ge(termination)).to_bitmask() as u32 & mine;
        let mut share = clear;
        if closed != 0 && self.level < 1.0 {
            share = clear * share_to_level(simd, clear, alpha, self.level).0;
            *opacity = after.min(self.level).to_array();
        } else {
            *opacity = after.to_array();
        }
        let crossing = before.simd_lt(splat(simd, self.half)) & after.simd_ge(splat(simd, self.half));
        if crossing.any_true() {
            note_half(crossing.to_bitmask() as u32, at.x, &before.to_array(), &alpha.to_array(), at.slice, row);
        }
        for (component, light) in [r, g, b].into_iter().enumerate() {
            let sum = row.lanes(component, at.x);
            *sum = (f32x16::load_array_ref(simd, sum) + light * share).to_array();
        }
        Added { samples: (open.to_bitmask() as u32 & mine).count_ones(), closed }
    }

    /// A sample shaded by what reflects at the voxels around it, interpolated.
    #[inline(always)]
    pub(super) fn lit<S: Simd, const N: usize>(
        &self,
        simd: S,
        edges: &Edges<N>,
        cell: usize,
        weight: f32,
        sample: f32x4<S>,
    ) -> f32x4<S> {
        let (mut factor, mut added) = (f32x4::splat(simd, 0.0), f32x4::splat(simd, 0.0));
        for n in 0..N {
            for (right, weight) in [(0, 1.0 - weight), (1, weight)] {
                let normal = self.normals[edges.at[n] + cell + right];
                let reflection = &self.reflections[usize::from(normal)];
                let weight = edges.weights[n] * weight;
                factor += f32x4::load_array_ref(simd, &reflection.factor) * weight;
                added += f32x4::load_array_ref(simd, &reflection.added) * weight;
            }
        }
        sample * factor + added * sample.to_array()[3]
    }
}
