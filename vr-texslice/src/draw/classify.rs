//! From values to light and opacity.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};
use vr_kernels::vector::{LANES, Lanes, OpticsTable, Rows, SegmentTable, pick, splat, step_light, step_of_thickness};

use super::chunk::{CHUNK, Chunk};

/// Classification of fragments.
#[derive(Clone, Copy)]
pub(crate) enum Classifier<'a> {
    /// By a look-up in a table of whole slabs, where all are equally long; other lengths by their optical depth.
    Table { rows: Rows<'a>, optics: &'a OpticsTable, even: bool },
    /// One by one in f64, where no table tells apart all that the transfer function does: light and opacity of a stored number and a length in table
    /// lengths.
    Exact(&'a (dyn Fn(f32, f32) -> [f32; 4] + Sync)),
    /// Integrates segments between two values.
    Segments(&'a SegmentTable),
    /// Texels are light and opacity of one table length.
    Done { even: bool },
    /// Not at all: the operator picks a value.
    Values,
}

/// Turns the values of a chunk into light and opacity of slabs so long, in table lengths. `outer`: the first or the last of rays, and no whole ones.
#[inline(never)]
pub(crate) fn classify<S: Simd>(simd: S, with: &Classifier<'_>, ratio: &Lanes, outer: bool, chunk: &mut Chunk) {
    simd.vectorize(
        #[inline(always)]
        || match *with {
            Classifier::Table { rows, even: true, .. } if !outer => {
                for j in 0..chunk.len {
                    let value = chunk.value[j].load(simd);
                    let [r, g, b, a] = rows.at(simd, value);
                    let a = where_defined(simd, value, a);
                    chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
            }
            Classifier::Table { optics, .. } => {
                let ratio = ratio.load(simd);
                for j in 0..chunk.len {
                    let value = chunk.value[j].load(simd);
                    let found = optics.rows().at(simd, value);
                    let [r, g, b, a] = step_light(simd, found, ratio, optics.emits);
                    let a = where_defined(simd, value, a);
                    chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
            }
            Classifier::Exact(light) => {
                for j in 0..chunk.len {
                    for i in 0..LANES {
                        let found = light(chunk.value[j].0[i], ratio.0[i]);
                        (0..4).for_each(|c| chunk.light[j][c].0[i] = found[c]);
                    }
                }
            }
            Classifier::Done { even } if outer || !even => {
                let ratio = ratio.load(simd);
                for j in 0..chunk.len {
                    let [r, g, b, a] = &chunk.light[j];
                    let light = [r.load(simd), g.load(simd), b.load(simd), a.load(simd)];
                    let [r, g, b, corrected] = step_of_thickness(simd, light, ratio);
                    let a = where_defined(simd, light[3], corrected);
                    chunk.light[j] = [Lanes::new(r), Lanes::new(g), Lanes::new(b), Lanes::new(a)];
                }
            }
            Classifier::Done { .. } | Classifier::Segments(_) | Classifier::Values => {}
        },
    );
}

/// Vacuum stays NaN: whatever a table has said of it.
#[inline(always)]
fn where_defined<S: Simd>(simd: S, value: f32x16<S>, alpha: f32x16<S>) -> f32x16<S> {
    pick(value.simd_eq(value), alpha, splat(simd, f32::NAN))
}

/// Light and opacity of segments that end at the values of a chunk, each so long in world units; each begins where the one before it ended, the first at
/// `before`. `backwards`: they end nearer to the eye than they begin.
///
/// Off by 2·10⁻⁶ or less of [`PreIntegrated::segment`](vr_kernels::tables::PreIntegrated::segment): rounding alone, for the arithmetic is the same, sixteen
/// segments at a time. A segment from or to vacuum has the opacity NaN, as vacuum has.
#[inline(never)]
pub(crate) fn integrate<S: Simd>(
    simd: S,
    table: &SegmentTable,
    before: &Lanes,
    length: &[Lanes; CHUNK],
    backwards: bool,
    chunk: &mut Chunk,
) {
    // Two at a time where the next is as long: they share the value between them. But not where one of two may end at a wall: how its neighbour is rounded would
    // depend on that, and so on where chunks begin.
    let pairs = !table.pre_integrated().has_walls();
    let mut near = *before;
    let mut j = 0;
    while j < chunk.len {
        let next = if pairs && j + 1 < chunk.len && length[j].0 == length[j + 1].0 { j + 1 } else { j };
        let mut ends = [near, chunk.value[j], chunk.value[next]];
        near = ends[2];
        if backwards {
            ends.reverse();
        }
        let defined = ends.map(|end| end.0.map(|value| !value.is_nan()));
        for value in ends.iter_mut().flat_map(|end| &mut end.0) {
            // A table's values must be numbers.
            *value = if value.is_nan() { 0.0 } else { *value };
        }
        let mut light = [[Lanes::ZERO; 4]; 2];
        table.lines(simd, &ends, [&length[j]; 2], u32::MAX, &mut light);
        for (part, light) in light.iter_mut().enumerate() {
            for i in (0..LANES).filter(|&i| !(defined[part][i] && defined[part + 1][i])) {
                light[3].0[i] = f32::NAN;
            }
        }
        if backwards {
            light.reverse();
        }
        chunk.light[next] = light[1];
        chunk.light[j] = light[0];
        j = next + 1;
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use fearless_simd::{Level, dispatch};
    use vr_core::{Calibration, ControlPoint, OpacityRule, TransferFunction};
    use vr_kernels::tables::PreIntegrated;

    use super::*;

    /// Segments of 128 samples on each ray, some of them vacuum, by an integration in chunks of so many.
    fn integrated(table: &SegmentTable, len: usize, backwards: bool) -> Vec<[[f32; 4]; LANES]> {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1u64 << 24) as f32
        };
        let value = |x: f32| if x < 0.05 { f32::NAN } else { 1.2 * x - 0.1 };
        let values: Vec<Lanes> = (0..129).map(|_| Lanes(std::array::from_fn(|_| value(random())))).collect();
        let mut chunk = Chunk::EMPTY;
        let mut all = Vec::new();
        for (k, part) in values[1..].chunks(len).enumerate() {
            chunk.len = part.len();
            chunk.value[..len].copy_from_slice(part);
            // The first is shorter.
            let length = std::array::from_fn(|j| Lanes([if k == 0 && j == 0 { 0.1 } else { 0.3 }; LANES]));
            dispatch!(Level::new(), simd => integrate(simd, table, &values[k * len], &length, backwards, &mut chunk));
            for (j, light) in chunk.light[..len].iter().enumerate() {
                let (near, far) = (&values[k * len + j], &part[j]);
                all.push(std::array::from_fn(|i| light.map(|lanes| lanes.0[i])));
                for i in 0..LANES {
                    let [front, back] = if backwards { [far.0[i], near.0[i]] } else { [near.0[i], far.0[i]] };
                    if front.is_nan() || back.is_nan() {
                        assert!(light[3].0[i].is_nan());
                        continue;
                    }
                    let want = table.pre_integrated().segment(front, back, length[j].0[i]);
                    for c in 0..4 {
                        let off = (light[c].0[i] - want[c]).abs();
                        assert!(off <= 2e-6 * (1.0 + want[c]), "{front} {back}: {off} of {want:?}");
                    }
                }
            }
        }
        all
    }

    #[test]
    fn segments_are_those_of_the_table_wherever_chunks_begin() {
        for opacity in [0.8, 1.0] {
            let points = [(0.25, 0.0), (0.5, 0.5), (0.75, opacity), (0.875, opacity), (1.0, 0.0)];
            let points = points.map(|(value, opacity)| ControlPoint::new(value, [1.0, value, 0.25], opacity));
            let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 0.5).unwrap();
            let table = PreIntegrated::new(&transfer, Calibration::default(), (-0.2, 1.2), 1024);
            assert_eq!(table.has_walls(), opacity == 1.0);
            let table = SegmentTable::new(&Arc::new(table));
            for backwards in [false, true] {
                let one_by_one = integrated(&table, 1, backwards);
                let bits = |all: &[[[f32; 4]; LANES]]| -> Vec<u32> {
                    all.iter().flatten().filter(|l| !l[3].is_nan()).flatten().map(|x| x.to_bits()).collect()
                };
                for len in [2, 4, CHUNK] {
                    assert_eq!(bits(&integrated(&table, len, backwards)), bits(&one_by_one), "{opacity} {len}");
                }
            }
        }
    }
}
