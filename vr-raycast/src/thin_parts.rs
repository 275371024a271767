//! Visible parts of a volume so thin that rays some pixels apart pass on both sides of them.

use std::ops::Range;

use glam::DVec3;
use vr_core::filter::Lattice;
use vr_core::parallel::collect;
use vr_core::{GridVolume, LatticeVisitor, ParameterError, Placement, Scene, View, Voxel};
use vr_kernels::ranges::{LevelRanges, VisibleValues};

use crate::projection::{Projection, TILE};

/// Blocks that hold needles and dots: visible voxels around which hardly any is visible two voxels away.
///
/// Sheets are thin, too, but show as surfaces, whose rims are long: a screen that leaves rays out meets these, and follows them. Holes as small as that in
/// something visible are not looked for.
#[derive(Clone, Debug)]
pub(crate) struct ThinParts {
    placement: Placement,
    /// The blocks, by their place among all of them.
    blocks: Vec<[u16; 3]>,
}

/// Largest number of voxels in which something is seen, of the 98 on the surface of a cube of 5³, around the middle of a thin part: an oblique needle goes out
/// through two sides, by up to eight voxels each, those before it included. Through a sheet it would be 32, and more at the edge of something solid.
const MOST: u32 = 16;
/// Opacity of a voxel's length from which on a part counts: fainter ones change a picture by less than adaptive rays do.
const FAINT: f64 = 0.02;
/// Opacity of a voxel's length that a thin part has in its middle: what is fainter is found by its neighbours, or hardly shows.
const STRONG: f64 = 0.1;
/// Pixels of a voxel from which on nothing is thin: two voxels, the width of a dot, are then as far apart as the first rays.
const WIDE: f64 = 0.5 * TILE as f64 * std::f64::consts::SQRT_2;

impl ThinParts {
    /// Cells along the edge of a block.
    const EDGE: usize = LevelRanges::EDGE;

    /// Finds the thin parts of a grid under the scene's transfer function.
    pub(crate) fn new(scene: &Scene, volume: &GridVolume) -> Self {
        let levels = LevelRanges::of_volume(volume);
        let [faint, strong] = [FAINT, STRONG].map(|opacity| Codes::new(scene, volume, &levels, opacity));
        let blocks = volume.with_lattice(Search { faint: &faint, strong: &strong, levels: &levels });
        Self { placement: *volume.placement(), blocks }
    }

    /// Returns the tiles of a view in which thin parts may show, each once or more often.
    ///
    /// # Errors
    /// Same as for [`vr_core::Camera::frame`].
    pub(crate) fn tiles(&self, view: &View) -> Result<Vec<[usize; 2]>, ParameterError> {
        let projection = Projection::new(view, &self.placement)?;
        let half = 0.5 * Self::EDGE as f64;
        let stencil = projection.stencil(DVec3::splat(half + 1.0));
        // Seen along a diagonal, a block is longer by √3; and it may begin anywhere in a tile.
        let longest = (Self::EDGE as f64 + 2.0) * libm::sqrt(3.0) * WIDE / f64::from(TILE);
        let tiles_of_wide = longest.ceil() as u32 + 1;
        let mut tiles = Vec::new();
        for block in &self.blocks {
            let centre = DVec3::from_array(block.map(|b| f64::from(b) * Self::EDGE as f64 + half));
            let Some(seen) = projection.footprint(&stencil, centre) else { continue };
            if (0..2).all(|a| seen.high[a] - seen.low[a] > tiles_of_wide) {
                continue;
            }
            let columns = seen.low[0] as usize..=seen.high[0] as usize;
            tiles.extend(
                (seen.low[1] as usize..=seen.high[1] as usize).flat_map(|y| columns.clone().map(move |x| [x, y])),
            );
        }
        tiles.sort_unstable();
        tiles.dedup();
        Ok(tiles)
    }
}

/// Codes of levels: odd for visible ones, and the same for all that no way between them leads through a change.
struct Codes {
    low: f32,
    levels_per_value: f32,
    codes: [u8; LEVELS],
    /// Levels at which the code changes, and what it gains there, where these are few: then sums over them are quicker than the table, many voxels at once.
    few_changes: Option<Vec<(u8, u8)>>,
}

/// Largest number of changes that sums are quicker for.
const FEW: usize = 8;

const LEVELS: usize = LevelRanges::LAST as usize + 1;

impl Codes {
    /// Makes the codes of what a voxel's length of has at least an opacity.
    fn new(scene: &Scene, volume: &GridVolume, levels: &LevelRanges, opacity: f64) -> Self {
        // The opacity per unit distance that makes a voxel's length so opaque.
        let voxel = volume.placement().spacing().min_element();
        let optical_depth = -libm::log1p(-opacity);
        let (mut less, mut more) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (less + more);
            let is_less = scene.transfer.extinction(middle) * voxel < optical_depth;
            *if is_less { &mut less } else { &mut more } = middle;
        }
        let values = VisibleValues::above(&scene.transfer, less);
        let at = |level: usize| volume.calibration().value(levels.stored(level as u8));
        let mut codes = [0u8; LEVELS];
        for i in 0..LEVELS {
            let last = if i > 0 { codes[i - 1] } else { 0 };
            let was_visible = last % 2 == 1;
            // A thin peak between two clear levels parts them. Codes that come round after 256 changes are told apart from their neighbours still.
            codes[i] = match values.shows(at(i), at(i)) {
                visible if visible != was_visible => last.wrapping_add(1),
                false if i > 0 && values.shows(at(i - 1), at(i)) => last.wrapping_add(2),
                _ => last,
            };
        }
        let (low, high) = (levels.stored(0), levels.stored(LevelRanges::LAST));
        let levels_per_value = (f64::from(LevelRanges::LAST) / (high - low)) as f32;
        Self { low: low as f32, levels_per_value, codes, few_changes: few_changes(&codes) }
    }

    /// Returns the level of a stored number.
    #[inline(always)]
    fn level(&self, stored: f32) -> u8 {
        // `as` saturates, and takes NaN for 0.
        ((stored - self.low) * self.levels_per_value + 0.5) as u8
    }

    /// Returns the code of a stored number.
    #[inline(always)]
    fn of(&self, stored: f32) -> u8 {
        self.codes[usize::from(self.level(stored))]
    }

    /// Appends the codes of a row of voxels.
    fn append<T: Voxel>(&self, row: &[T], coded: &mut Vec<u8>) {
        let start = coded.len();
        coded.extend(row.iter().map(|sample| self.level(sample.to_f32())));
        let Some(changes) = &self.few_changes else {
            coded[start..].iter_mut().for_each(|level| *level = self.codes[usize::from(*level)]);
            return;
        };
        for levels in coded[start..].chunks_mut(WORD) {
            let mut codes = [self.codes[0]; WORD];
            for &(from, gain) in changes {
                for (code, &level) in codes.iter_mut().zip(&*levels) {
                    *code = code.wrapping_add(if level >= from { gain } else { 0 });
                }
            }
            levels.copy_from_slice(&codes[..levels.len()]);
        }
    }

    /// True if a voxel is visible, or the way from it to the next along an axis.
    fn is_seen<T: Voxel>(&self, lattice: &Lattice<'_, T>, at: [usize; 3]) -> bool {
        let code = |[x, y, z]: [usize; 3]| self.of(lattice.samples[lattice.offset(x, y, z)].to_f32());
        let next = |a: usize| {
            let mut next = at;
            next[a] = (next[a] + 1).min(lattice.dims[a] - 1);
            code(next)
        };
        shows(code(at), [next(0), next(1), next(2)])
    }
}

/// Returns the levels at which codes change, and what they gain there; `None` if these are many.
fn few_changes(codes: &[u8; LEVELS]) -> Option<Vec<(u8, u8)>> {
    let changes = codes.windows(2).zip(1u8..).filter(|(pair, _)| pair[0] != pair[1]);
    let changes: Vec<_> = changes.map(|(pair, level)| (level, pair[1].wrapping_sub(pair[0]))).collect();
    (changes.len() <= FEW).then_some(changes)
}

/// True if a voxel of a code is visible, or the way to one of the next along the axes, whose codes are given: the field may pass what is visible between two
/// voxels that are not.
#[inline(always)]
fn shows(here: u8, next: [u8; 3]) -> bool {
    // Without branches, so that many are looked at at once.
    (here % 2 == 1) | (next[0] != here) | (next[1] != here) | (next[2] != here)
}

/// Voxels of a word.
const WORD: usize = u64::BITS as usize;

/// Returns a word with a bit for each of its voxels, the first lowest.
fn packed(seen: &[bool; WORD]) -> u64 {
    seen.chunks_exact(8).zip(0u32..).fold(0, |word, (eight, i)| {
        let bytes = u64::from_le_bytes(std::array::from_fn(|k| u8::from(eight[k])));
        // The product brings the lowest bit of byte k to bit 56 + k, and nothing else there.
        word | (bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i)
    })
}

/// Search for blocks with thin parts.
struct Search<'a> {
    /// Codes of what counts at all, and of what a thin part must reach.
    faint: &'a Codes,
    strong: &'a Codes,
    levels: &'a LevelRanges,
}

/// Voxels beyond a box that decide whether something in it is thin.
const RIM: usize = 2;
/// Blocks along y and z that are looked at together: voxels beside them are looked at once more by the neighbours.
const GROUP: usize = 4;

impl LatticeVisitor for Search<'_> {
    type Output = Vec<[u16; 3]>;

    fn visit<T: Voxel>(self, lattice: Lattice<'_, T>) -> Self::Output {
        let blocks = self.levels.blocks();
        let [_, down, deep] = blocks.map(|n| n.div_ceil(GROUP));
        let row = |row: usize| {
            let group = [row % down, row / down];
            let [ys, zs] = [1, 2].map(|a| group[a - 1] * GROUP..((group[a - 1] + 1) * GROUP).min(blocks[a]));
            let is_mixed = |x: usize| zs.clone().any(|z| ys.clone().any(|y| self.is_mixed([x, y, z])));
            let mut found = Vec::new();
            let mut x = 0;
            while x < blocks[0] {
                // A run of blocks is looked at as one.
                let end = (x..blocks[0]).find(|&x| !is_mixed(x)).unwrap_or(blocks[0]);
                if end > x {
                    self.search([x..end, ys.clone(), zs.clone()], &lattice, &mut found);
                }
                x = end + 1;
            }
            found
        };
        collect(down * deep, row).concat()
    }
}

impl Search<'_> {
    /// True if something in a block is visible, and something is not.
    fn is_mixed(&self, [x, y, z]: [usize; 3]) -> bool {
        let [across, down, _] = self.levels.blocks();
        let [low, high] = self.levels.ranges()[(z * down + y) * across + x];
        let code = |level: u8| self.faint.codes[usize::from(level)];
        low <= high && code(low) != code(high)
    }

    /// Adds the blocks of a box of blocks in which something is thin.
    fn search<T: Voxel>(&self, blocks: [Range<usize>; 3], lattice: &Lattice<'_, T>, found: &mut Vec<[u16; 3]>) {
        let all = self.levels.blocks();
        // The last blocks have the last voxels, too.
        let voxels: [Range<usize>; 3] = std::array::from_fn(|a| {
            let end = if blocks[a].end == all[a] { lattice.dims[a] } else { blocks[a].end * ThinParts::EDGE };
            blocks[a].start * ThinParts::EDGE..end
        });
        let seen = SeenVoxels::new(self.faint, lattice, &voxels);
        let mut thin = Vec::new();
        for z in voxels[2].clone() {
            for y in voxels[1].clone() {
                seen.each_thin([y, z], |x| {
                    if voxels[0].contains(&x) && self.strong.is_seen(lattice, [x, y, z]) {
                        let at = [x, y, z];
                        thin.push(std::array::from_fn(|a| (at[a] / ThinParts::EDGE).min(all[a] - 1) as u16));
                    }
                });
            }
        }
        thin.sort_unstable();
        thin.dedup();
        found.append(&mut thin);
    }
}

/// Voxels of a box that are visible, or from which the way to the next along an axis is; a bit for each, and rows begin new words.
struct SeenVoxels {
    first: [usize; 3],
    dims: [usize; 3],
    words: Vec<u64>,
}

impl SeenVoxels {
    /// Looks at the voxels of a box, ends excluded, and those around it as far as they count.
    fn new<T: Voxel>(codes: &Codes, lattice: &Lattice<'_, T>, voxels: &[Range<usize>; 3]) -> Self {
        let first: [usize; 3] = std::array::from_fn(|a| voxels[a].start.saturating_sub(RIM));
        let dims: [usize; 3] = std::array::from_fn(|a| (voxels[a].end + RIM).min(lattice.dims[a]) - first[a]);
        // One more along each axis, to which the ways of the last lead; beyond the volume, the last voxel again.
        let [wide, high, deep] = dims.map(|n| n + 1);
        let clamped = |a: usize, i: usize| (first[a] + i).min(lattice.dims[a] - 1);
        let mut coded = Vec::with_capacity(wide * high * deep);
        for z in 0..deep {
            for y in 0..high {
                let start = lattice.offset(first[0], clamped(1, y), clamped(2, z));
                let row = &lattice.samples[start..start + wide.min(lattice.dims[0] - first[0])];
                codes.append(row, &mut coded);
                coded.resize((z * high + y + 1) * wide, *coded.last().expect("a row has voxels"));
            }
        }
        let mut words = Vec::with_capacity(dims[0].div_ceil(64) * dims[1] * dims[2]);
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                let row = |y: usize, z: usize| &coded[(z * high + y) * wide..][..wide];
                let (this, beside, behind) = (row(y, z), row(y + 1, z), row(y, z + 1));
                words.extend((0..dims[0]).step_by(WORD).map(|start| {
                    let end = (start + WORD).min(dims[0]);
                    let next = [&this[start + 1..=end], &beside[start..end], &behind[start..end]];
                    let mut seen = [false; WORD];
                    for (i, (seen, &here)) in seen.iter_mut().zip(&this[start..end]).enumerate() {
                        *seen = shows(here, next.map(|next| next[i]));
                    }
                    packed(&seen)
                }));
            }
        }
        Self { first, dims, words }
    }

    /// Returns a row of the box; `None` beyond it.
    fn row(&self, y: usize, z: usize) -> Option<&[u64]> {
        let words = self.dims[0].div_ceil(64);
        (y < self.dims[1] && z < self.dims[2]).then(|| &self.words[(z * self.dims[1] + y) * words..][..words])
    }

    /// Calls `each` with the x of every voxel of a row around which few others are.
    fn each_thin(&self, [y, z]: [usize; 2], mut each: impl FnMut(usize)) {
        let (y, z) = (y - self.first[1], z - self.first[2]);
        // Rows by their distances of −2 to 2 along y and z. What lies below 0 wraps, and is beyond the box, too.
        let rows: [[Option<&[u64]>; 5]; 5] = std::array::from_fn(|dz| {
            std::array::from_fn(|dy| self.row((y + dy).wrapping_sub(2), (z + dz).wrapping_sub(2)))
        });
        let word = |row: Option<&[u64]>, i: usize| row.map_or(0, |row| row[i]);
        let middle = rows[2][2].expect("a row of the box");
        for (i, &seen) in middle.iter().enumerate() {
            if seen == 0 {
                continue;
            }
            // Of the six voxels two away along the axes, a needle goes through two at the most.
            let before = if i > 0 { middle[i - 1] } else { 0 };
            let after = middle.get(i + 1).copied().unwrap_or(0);
            let ends = [seen << 2 | before >> 62, seen >> 2 | after << 62];
            let sides = [[2, 0], [2, 4], [0, 2], [4, 2]].map(|[dz, dy]: [usize; 2]| word(rows[dz][dy], i));
            let (mut one, mut two, mut more) = (0, 0, 0);
            for side in ends.into_iter().chain(sides) {
                more |= two & side;
                two |= one & side;
                one |= side;
            }
            let mut left = seen & !more;
            while left != 0 {
                let x = i * 64 + left.trailing_zeros() as usize;
                left &= left - 1;
                if Self::count_around(&rows, x) <= MOST {
                    each(self.first[0] + x);
                }
            }
        }
    }

    /// Returns the number of voxels on the surface of the cube of 5³ around one.
    fn count_around(rows: &[[Option<&[u64]>; 5]; 5], x: usize) -> u32 {
        let mut count = 0;
        for (dz, rows) in rows.iter().enumerate() {
            for (dy, row) in rows.iter().enumerate() {
                let Some(row) = row else { continue };
                let inside = (1..4).contains(&dz) && (1..4).contains(&dy);
                // The five around x, lowest bit first.
                let (word, bit) = (x / 64, x % 64);
                let five = match bit {
                    0 | 1 => row[word] << (2 - bit) | if word > 0 { row[word - 1] >> (62 + bit) } else { 0 },
                    62 | 63 => row[word] >> (bit - 2) | row.get(word + 1).map_or(0, |next| next << (66 - bit)),
                    _ => row[word] >> (bit - 2),
                };
                count += (five & if inside { 0b10001 } else { 0b11111 }).count_ones();
            }
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use vr_core::{Calibration, Camera, ControlPoint, OpacityRule, TransferFunction, UniformGrid, Volume};

    use super::*;

    fn thin(shown: impl Fn([usize; 3]) -> bool, opacity: f64) -> ThinParts {
        let n = 24;
        let samples: Vec<u8> =
            (0..n * n * n).map(|i| if shown([i % n, i / n % n, i / (n * n)]) { 200u8 } else { 10 }).collect();
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new([n; 3], samples, placement, Calibration::default()).unwrap().into();
        let points = vec![ControlPoint::new(100.0, [1.0; 3], 0.0), ControlPoint::new(180.0, [1.0; 3], opacity)];
        let transfer = TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap();
        let scene = Scene::new(volume.clone(), transfer);
        ThinParts::new(&scene, volume.grid().unwrap())
    }

    #[test]
    fn needles_and_dots_are_thin_and_larger_things_are_not() {
        assert_eq!(thin(|at| at == [9, 13, 5], 0.5).blocks, [[2, 3, 1]]);
        assert_eq!(thin(|at| at == [23, 0, 23], 0.5).blocks, [[5, 0, 5]]);
        let needle = |at: [usize; 3]| at[0] == at[1] && at[1] == at[2];
        assert!(thin(needle, 0.5).blocks.len() >= 6);
        for larger in [
            (|at| at[0] > 11) as fn([usize; 3]) -> bool,
            |at| at[0] + at[1] + at[2] == 30,
            |at| at.iter().all(|&i| (8..16).contains(&i)),
            |_| true,
            |_| false,
        ] {
            // Where a sheet leaves the volume, what is left of it may be thin.
            let is_inner = |block: &[u16; 3]| block.iter().all(|&b| (1..=4).contains(&b));
            assert!(!thin(larger, 0.5).blocks.iter().any(is_inner));
        }
        assert_eq!(thin(|at| at == [9, 13, 5], 0.01).blocks, [[0u16; 3]; 0], "too faint to count");
    }

    #[test]
    fn codes_of_rows_are_those_of_their_voxels() {
        // Few changes, and many.
        for every in [40, 3] {
            let codes: [u8; LEVELS] = std::array::from_fn(|level| (level / every * 7) as u8);
            let codes = Codes { low: -3.0, levels_per_value: 0.5, codes, few_changes: few_changes(&codes) };
            assert_eq!(codes.few_changes.is_some(), every == 40);
            let row: Vec<f32> = (0..600).map(|i| i as f32 - 20.0).chain([f32::NAN, f32::INFINITY]).collect();
            let mut coded = vec![9];
            codes.append(&row, &mut coded);
            assert!(coded[1..].iter().zip(&row).all(|(&code, &stored)| code == codes.of(stored)));
        }
        let seen: [bool; WORD] = std::array::from_fn(|i| i * i % 7 < 3);
        assert!((0..WORD).all(|i| packed(&seen) >> i & 1 == u64::from(seen[i])));
    }

    #[test]
    fn voxels_around_one_are_counted_across_words() {
        let (dims, mut state) = ([150, 9, 8], 1u32);
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 29 == 0
        };
        let voxels: Vec<bool> = (0..dims.iter().product()).map(|_| random()).collect();
        let words = voxels.chunks(dims[0]).flat_map(|row| {
            row.chunks(64)
                .map(|part| part.iter().enumerate().fold(0u64, |word, (i, &seen)| word | u64::from(seen) << i))
        });
        let seen = SeenVoxels { first: [0; 3], dims, words: words.collect() };
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                let mut found = Vec::new();
                seen.each_thin([y, z], |x| found.push(x));
                let at = |x: usize, y: usize, z: usize| voxels[(z * dims[1] + y) * dims[0] + x];
                let near = |i: usize, a: usize| i.saturating_sub(2)..(i + 3).min(dims[a]);
                let is_thin = |&x: &usize| {
                    let on_surface =
                        |[i, j, k]: [usize; 3]| [(i, x), (j, y), (k, z)].iter().any(|(a, b)| a.abs_diff(*b) == 2);
                    let cube =
                        near(z, 2).flat_map(|k| near(y, 1).flat_map(move |j| near(x, 0).map(move |i| [i, j, k])));
                    let around = cube.filter(|&p| on_surface(p) && at(p[0], p[1], p[2])).collect::<Vec<_>>();
                    let along_axes = around
                        .iter()
                        .filter(|p| [(p[0], x), (p[1], y), (p[2], z)].iter().filter(|(a, b)| a == b).count() == 2);
                    at(x, y, z) && along_axes.count() <= 2 && around.len() <= MOST as usize
                };
                assert_eq!(found, (0..dims[0]).filter(is_thin).collect::<Vec<_>>(), "{y} {z}");
            }
        }
    }

    #[test]
    fn tiles_cover_what_is_thin_where_voxels_are_small() {
        let thin = thin(|at| at == [9, 13, 5], 0.5);
        let camera = Camera::framing((DVec3::ZERO, DVec3::splat(23.0)), 30.0, 20.0, Some(30.0));
        for (size, few) in [([64, 64], true), ([2048, 2048], false)] {
            let view = View::new(camera, size);
            let tiles = thin.tiles(&view).unwrap();
            if !few {
                assert_eq!(tiles, [[0usize; 2]; 0]);
                continue;
            }
            let projection = Projection::new(&view, &thin.placement).unwrap();
            let dot = projection.footprint(&projection.stencil(DVec3::ONE), DVec3::new(9.0, 13.0, 5.0)).unwrap();
            for y in dot.low[1]..=dot.high[1] {
                for x in dot.low[0]..=dot.high[0] {
                    assert!(tiles.contains(&[x as usize, y as usize]), "{x} {y}");
                }
            }
            assert!(tiles.len() < 40, "{}", tiles.len());
        }
    }
}
