//! Splats sorted into the tiles of a picture.

use vr_core::{Control, RenderError, image_order::in_parallel};

use crate::projection::SplatView;
use crate::source::Source;
use crate::splat::Splat;

/// Pixels along the edge of a tile.
pub(crate) const TILE: u32 = 32;

/// A splat and its sorting key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Keyed {
    pub(crate) key: u32,
    pub(crate) splat: Splat,
}

impl Keyed {
    /// A place for one.
    const NONE: Self = Self { key: 0, splat: Splat { place: [0.0; 3], scale: 1.0, weight: 0.0, value: 0.0 } };
}

/// Keys of splats.
#[derive(Clone, Copy)]
pub(crate) enum Keys {
    /// The first of the sheets, so far apart, that a kernel has a part of; there are so many sheets.
    Image { distance: f64, count: u32 },
    /// Their own sheet.
    Own,
    /// Nearest first.
    Depth,
}

impl Keys {
    #[inline(always)]
    fn of(self, splat: &Splat, half_depth: f64, sheet: u32) -> u32 {
        match self {
            Self::Image { distance, count } => {
                let front = f64::from(splat.place[2]) - half_depth / f64::from(splat.scale);
                // `as` saturates, and rounds down what is not negative.
                ((front / distance) as u32).min(count - 1)
            }
            Self::Own => sheet,
            Self::Depth => {
                // Bits of floats, in the order of the floats.
                let bits = splat.place[2].to_bits();
                if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
            }
        }
    }
}

/// The splats of a chunk, tile by tile.
struct Chunk {
    splats: Vec<Keyed>,
    /// First splat of each tile, and the end of the last one's.
    starts: Vec<u32>,
}

/// Splats by tile: those of some rows of tiles.
pub(crate) struct Bins {
    chunks: Vec<Chunk>,
}

impl Bins {
    /// Sorts what a source has into the rows `rows` of tiles.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(crate) fn new(
        source: &dyn Source,
        view: &SplatView,
        keys: Keys,
        rows: std::ops::Range<u32>,
        control: &Control,
    ) -> Result<Self, RenderError> {
        let across = view.size[0].div_ceil(TILE);
        let tiles = (rows.len() as u32 * across) as usize;
        let one = |chunk: u32| {
            let mut found: Vec<(u32, Keyed)> = Vec::new();
            let mut starts = vec![0u32; tiles + 1];
            source.splats(chunk as usize, &mut |splat, sheet| {
                let Some([x0, x1, y0, y1]) = view.rectangle(splat.place, splat.scale) else { return };
                let keyed = Keyed { key: keys.of(&splat, view.half_depth(), sheet), splat };
                for row in (y0 / TILE).max(rows.start)..(y1 / TILE + 1).min(rows.end) {
                    for column in x0 / TILE..=x1 / TILE {
                        let tile = (row - rows.start) * across + column;
                        starts[tile as usize + 1] += 1;
                        found.push((tile, keyed));
                    }
                }
            });
            for tile in 0..tiles {
                starts[tile + 1] += starts[tile];
            }
            let mut next = starts.clone();
            let mut splats = vec![Keyed::NONE; found.len()];
            for (tile, keyed) in found {
                let place = &mut next[tile as usize];
                splats[*place as usize] = keyed;
                *place += 1;
            }
            Chunk { splats, starts }
        };
        let chunks = in_parallel(control, source.chunks() as u32, one)?;
        Ok(Self { chunks: chunks.into_iter().filter(|chunk| !chunk.splats.is_empty()).collect() })
    }

    /// The splats of a tile, by key, and in the source's order where keys are equal.
    pub(crate) fn sorted(&self, tile: u32) -> Vec<Keyed> {
        let tile = tile as usize;
        let parts = self.chunks.iter().map(|c| &c.splats[c.starts[tile] as usize..c.starts[tile + 1] as usize]);
        let count = parts.clone().map(<[Keyed]>::len).sum();
        let (min, max) = parts.clone().flatten().fold((u32::MAX, 0), |(l, m), k| (l.min(k.key), m.max(k.key)));
        if max.saturating_sub(min) < MAX_SPAN {
            return counting_sort(parts, count, min, max);
        }
        let mut all = Vec::with_capacity(count);
        parts.for_each(|part| all.extend_from_slice(part));
        radix_sort(&mut all);
        all
    }
}

/// Number of keys up to which splats are sorted straight from their chunks: so many counters stay in the nearest cache.
const MAX_SPAN: u32 = 1 << 12;

/// Sorts by key, stably, while gathering: one pass counts and one places (Knuth 1973, algorithm 5.2D).
fn counting_sort<'a>(parts: impl Iterator<Item = &'a [Keyed]> + Clone, count: usize, min: u32, max: u32) -> Vec<Keyed> {
    let mut starts = vec![0u32; (max.saturating_sub(min) + 2) as usize];
    parts.clone().flatten().for_each(|k| starts[(k.key - min) as usize + 1] += 1);
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut all = vec![Keyed::NONE; count];
    for k in parts.flatten() {
        let place = &mut starts[(k.key - min) as usize];
        all[*place as usize] = *k;
        *place += 1;
    }
    all
}

/// Bits of a digit.
const DIGIT: u32 = 11;

/// Sorts by key, stably: a digit of the key at a time, from the lowest (Knuth 1973, algorithm 5.2.5R).
pub(crate) fn radix_sort(all: &mut Vec<Keyed>) {
    if all.len() < 64 {
        all.sort_by_key(|k| k.key);
        return;
    }
    let (min, max) = all.iter().fold((u32::MAX, 0), |(l, m), k| (l.min(k.key), m.max(k.key)));
    let mut other = all.clone();
    let mut shift = 0;
    while shift < 32 && (max - min) >> shift > 0 {
        let digit = |k: &Keyed| ((k.key - min) >> shift) as usize & ((1 << DIGIT) - 1);
        let mut starts = vec![0u32; (1 << DIGIT) + 1];
        all.iter().for_each(|k| starts[digit(k) + 1] += 1);
        for i in 0..1 << DIGIT {
            starts[i + 1] += starts[i];
        }
        for k in all.iter() {
            let place = &mut starts[digit(k)];
            other[*place as usize] = *k;
            *place += 1;
        }
        std::mem::swap(all, &mut other);
        shift += DIGIT;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn keyed(key: u32, i: usize) -> Keyed {
        Keyed { key, splat: Splat { place: [i as f32, 0.0, 0.0], scale: 1.0, weight: 1.0, value: 0.0 } }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]
        #[test]
        fn sorting_is_stable_and_in_order(keys in prop::collection::vec(prop_oneof![0u32..9, any::<u32>(), Just(u32::MAX)], 0..400)) {
            let mut got: Vec<Keyed> = keys.iter().enumerate().map(|(i, &k)| keyed(k, i)).collect();
            let mut want = got.clone();
            want.sort_by_key(|k| k.key);
            radix_sort(&mut got);
            prop_assert_eq!(got, want);
        }

        #[test]
        fn keys_of_depth_are_in_the_order_of_depths(a in -1e6f32..1e6, b in -1e6f32..1e6) {
            let of = |z: f32| Keys::Depth.of(&Splat { place: [0.0, 0.0, z], scale: 1.0, weight: 1.0, value: 0.0 }, 1.0, 0);
            prop_assert_eq!(a < b, of(a) < of(b));
        }
    }
}
