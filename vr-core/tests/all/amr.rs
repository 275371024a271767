//! Adaptive meshes: what is refused, linear data, faces between levels, and a uniform grid as a mesh of one level.

use glam::DVec3;
use proptest::prelude::*;
use vr_core::amr::{AmrBlock, AmrCentring, AmrError, AmrGrid, AmrLattice, AmrSampling};
use vr_core::{Calibration, Field, Filter, GridVolume, Placement, Ray, UniformGrid, gradient_between_samples};

const CENTRINGS: [AmrCentring; 2] = [AmrCentring::Cells, AmrCentring::Points];

/// Numbers from a seed.
struct Random(u64);

impl Random {
    /// The next one, 0 to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// A mesh of blocks that are refined here and there: a third of those of level 0, half of those of level 1.
fn patchy(seed: u64, ratios: &[[u32; 3]], centring: AmrCentring, value: impl Fn(DVec3) -> f64) -> AmrGrid {
    let sampling = AmrSampling {
        origin: DVec3::new(-1.0, 2.0, 0.5),
        edge: 1.5,
        blocks: [3, 2, 3],
        // Blocks must be whole cells of the level before.
        block_cells: [0, 1, 2].map(|a| ratios.iter().fold(2, |n, r| common_multiple(n, r[a] as usize))),
        ratios: ratios.to_vec(),
        centring,
    };
    let first = sampling.origin;
    let chosen = |low: DVec3, _: DVec3, level: usize| {
        let [x, y, z] = ((low - first) * 16.0).round().to_array().map(|x| x as i64);
        let mix = (x * 73_856_093) ^ (y * 19_349_663) ^ (z * 83_492_791);
        // The first block always, so that there are all levels.
        low == first || Random(seed ^ mix as u64 ^ level as u64).next() < [0.4, 0.3][level.min(1)]
    };
    AmrGrid::refining(&sampling, |p| value(p) as f32, chosen).unwrap()
}

fn common_multiple(n: usize, ratio: usize) -> usize {
    (1..).map(|k| k * n).find(|m| m.is_multiple_of(ratio)).unwrap()
}

/// Ratios that are tried: alike on all axes and not, more than 2.
const RATIOS: [&[[u32; 3]]; 5] =
    [&[[2; 3], [2; 3]], &[[4; 3], [2; 3]], &[[3; 3]], &[[2, 1, 3], [1, 2, 2]], &[[3, 2, 1], [2; 3]]];

fn place(grid: &AmrGrid, random: &mut Random) -> DVec3 {
    let (low, high) = grid.bounds();
    low + (high - low) * DVec3::new(random.next(), random.next(), random.next())
}

#[test]
fn linear_data_is_linear_everywhere() {
    let slope = DVec3::new(0.3, -0.5, 0.7);
    let value = |p: DVec3| 0.25 + slope.dot(p);
    for centring in CENTRINGS {
        for (seed, ratios) in RATIOS.into_iter().enumerate() {
            let grid = patchy(seed as u64, ratios, centring, value);
            assert_eq!(grid.levels(), ratios.len() + 1);
            let mut random = Random(7);
            let (mut inside, mut lit) = (0, 0);
            for _ in 0..20_000 {
                let at = place(&grid, &mut random);
                let Some(found) = grid.value(at) else { continue };
                // Values are f32, of a size of 3 at most.
                assert!((found - value(at)).abs() < 1e-6, "{centring:?} {ratios:?} {at}: {found}");
                inside += 1;
                if let Some(gradient) = grid.gradient(at) {
                    // Differences of f32 of size 3, over 0.04 at least.
                    assert!((gradient - slope).abs().max_element() < 2e-5, "{centring:?} {ratios:?} {at}: {gradient}");
                    lit += 1;
                }
            }
            assert!(inside > 12_000 && lit == inside, "{centring:?} {ratios:?}: {inside}, {lit}");
        }
    }
}

#[test]
fn one_level_is_a_uniform_grid() {
    let dims = [5, 4, 6];
    let mut random = Random(3);
    let values: Vec<f32> = (0..dims.iter().product()).map(|_| random.next() as f32).collect();
    let spacing = DVec3::new(0.5, 0.75, 0.25);
    let axes = glam::DMat3::from_diagonal(spacing);
    for centring in CENTRINGS {
        let origin = DVec3::new(1.0, -2.0, 0.0);
        let first = if centring == AmrCentring::Cells { origin + 0.5 * spacing } else { origin };
        let uniform =
            UniformGrid::new(dims, values.clone(), Placement::new(first, axes).unwrap(), Calibration::default());
        let uniform = GridVolume::new(uniform.unwrap().into(), Filter::Trilinear);
        // The same in two blocks, cut at x = 2.
        let part = |from: usize, to: usize| AmrBlock {
            level: 0,
            first: [from as i64, 0, 0],
            dims: [to - from, dims[1], dims[2]],
            values: values.chunks(dims[0]).flat_map(|row| row[from..to].to_vec()).collect(),
        };
        let beyond = usize::from(centring == AmrCentring::Points);
        let grid = AmrGrid::new(origin, spacing, vec![], vec![part(0, 2 + beyond), part(2, 5)], centring).unwrap();
        assert_eq!(grid.bounds(), uniform.bounds());
        for _ in 0..5000 {
            let at = place(&grid, &mut random);
            let index = ((at - first) / spacing).to_array();
            let (value, gradient) = uniform.with_lattice(At(index));
            let found = grid.value(at).unwrap_or_else(|| panic!("{centring:?}: vacuum at {at}, index {index:?}"));
            assert!((found - value).abs() < 1e-12);
            let off = grid.gradient(at).unwrap() - DVec3::from_array(gradient) / spacing;
            assert!(off.abs().max_element() < 1e-11, "{off}");
        }
        let (low, high) = grid.bounds();
        assert!(grid.value(low).is_some() && grid.value(high).is_some() && grid.value(high + 1e-9).is_none());
    }
}

struct At([f64; 3]);

impl vr_core::LatticeVisitor for At {
    type Output = (f64, [f64; 3]);
    fn visit<T: vr_core::Voxel>(self, lattice: vr_core::filter::Lattice<'_, T>) -> Self::Output {
        let cell: [(usize, f64); 3] = std::array::from_fn(|a| lattice.cell(a, self.0[a]));
        let mut sum = 0.0;
        for corner in 0..8 {
            let high = |a: usize| corner >> a & 1;
            let weight = |a: usize| if high(a) == 1 { cell[a].1 } else { 1.0 - cell[a].1 };
            let at: f64 = lattice.at(cell[0].0 + high(0), cell[1].0 + high(1), cell[2].0 + high(2));
            sum += weight(0) * weight(1) * weight(2) * at;
        }
        (sum, gradient_between_samples(&lattice, self.0))
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// No cracks: both sides of every face of a cell, of any level, have the same value. The noise is of size 1 from one cell to the next.
    #[test]
    fn noise_is_continuous_across_every_face(seed in 0u64..1000, ratios in 0..RATIOS.len(), cells in any::<bool>()) {
        let centring = if cells { AmrCentring::Cells } else { AmrCentring::Points };
        let noise = |p: DVec3| (p * DVec3::new(917.0, 1313.0, 711.0)).element_sum().sin();
        let grid = patchy(seed, RATIOS[ratios], centring, noise);
        let finest = grid.finest_spacing();
        let mut random = Random(seed);
        let mut crossed = 0;
        for _ in 0..3000 {
            // On a face of the finest lattice, which all faces of coarser cells lie on, at times on an edge or a corner.
            let mut at = place(&grid, &mut random);
            let axes = [1, 2, 4, 1, 2, 4, 3, 5, 6, 7][(random.next() * 10.0) as usize];
            for a in (0..3).filter(|a| axes >> a & 1 == 1) {
                at[a] = grid.origin()[a] + ((at[a] - grid.origin()[a]) / finest[a]).round() * finest[a];
            }
            let off = finest * 1e-9;
            let values: Vec<f64> = (0..8)
                .filter_map(|i| {
                    let side = |a: usize| if axes >> a & 1 == 0 { 0.0 } else if i >> a & 1 == 1 { off[a] } else { -off[a] };
                    grid.value(at + DVec3::new(side(0), side(1), side(2)))
                })
                .collect();
            for value in &values {
                prop_assert!((value - values[0]).abs() < 1e-7, "{} at {at}: {values:?}", grid.levels());
                prop_assert!(value.abs() <= 1.0 + 1e-7, "within the values around");
            }
            crossed += usize::from(values.len() == 8);
        }
        prop_assert!(crossed > 1200, "{crossed}");
    }
}

fn block(level: usize, first: [i64; 3], dims: [usize; 3], value: f32) -> AmrBlock {
    AmrBlock { level, first, dims, values: vec![value; dims.iter().product()] }
}

fn new(ratios: &[[u32; 3]], blocks: Vec<AmrBlock>) -> Result<AmrGrid, AmrError> {
    AmrGrid::new(DVec3::ZERO, DVec3::ONE, ratios.to_vec(), blocks, AmrCentring::Cells)
}

#[test]
fn bad_input_is_refused_in_words() {
    let said = |ratios: &[[u32; 3]], blocks: Vec<AmrBlock>| new(ratios, blocks).unwrap_err().to_string();
    let coarse = || block(0, [0; 3], [4; 3], 1.0);
    let two = [[2; 3]];
    assert!(said(&[], vec![]).starts_with("found no block of level 0, of 1 levels"));
    assert!(said(&two, vec![coarse()]).starts_with("found no block of level 1, of 2 levels"));
    assert!(said(&[[1; 3]], vec![coarse()]).starts_with("refinement ratio from level 0 to 1: found [1, 1, 1]"));
    assert!(said(&[[0, 2, 2]], vec![coarse()]).contains("found [0, 2, 2]"));
    assert!(said(&[[1024; 3]; 6], vec![coarse()]).contains("found [1024, 1024, 1024]"));
    assert_eq!(said(&[[2; 3]; 40], vec![coarse()]), "found 41 levels: there may be at most 32");
    assert_eq!(
        said(&two, vec![coarse(), block(2, [0; 3], [2; 3], 1.0)]),
        "block 1: found level 2; there are 2, counted from 0"
    );
    assert!(said(&[], vec![block(0, [0; 3], [4, 0, 4], 1.0)]).starts_with("block 0: found the size [4, 0, 4]"));
    let long = AmrBlock { dims: [usize::MAX, 2, 2], ..coarse() };
    assert!(said(&[], vec![long]).starts_with("block 0: found 64 values for a size of"));
    let away = block(0, [i64::MAX - 2, 0, 0], [4; 3], 1.0);
    assert!(said(&[], vec![away]).contains("beyond 2^50 cells"));
    assert!(
        said(&two, vec![coarse(), block(1, [1, 0, 0], [2; 3], 1.0)])
            .contains("must be multiples of the ratio [2, 2, 2]")
    );
    assert!(said(&two, vec![coarse(), block(1, [0; 3], [2, 3, 2], 1.0)]).contains("whole cells of level 0"));
    assert!(
        said(&two, vec![coarse(), block(1, [6, 6, 6], [4; 3], 1.0)])
            .contains("block 1 of level 1 covers the cell [4, 3, 3] of level 0")
    );
    let overlapping = vec![coarse(), block(0, [3, 0, 0], [4; 3], 2.0)];
    assert!(
        said(&[], overlapping)
            .starts_with("blocks 0 and 1 of level 0 both cover the cell [3, 0, 0], with the values 1 and 2")
    );
    assert!(said(&[], vec![block(0, [0; 3], [4; 3], f32::INFINITY)]).contains("no finite value among 64"));
    assert!(said(&[], vec![block(0, [0; 3], [4, 1, 4], 1.0)]).starts_with("along y, there is but one layer"));
    let origin = |origin| AmrGrid::new(origin, DVec3::ONE, vec![], vec![coarse()], AmrCentring::Cells);
    for wrong in [DVec3::NAN, DVec3::splat(1e13), DVec3::INFINITY] {
        assert!(origin(wrong).unwrap_err().to_string().starts_with("origin: found ["));
    }
    let spacing = AmrGrid::new(DVec3::ZERO, DVec3::new(1.0, 0.0, 1.0), vec![], vec![coarse()], AmrCentring::Cells);
    assert!(spacing.unwrap_err().to_string().starts_with("spacing of level 0: found [1.0, 0.0, 1.0]"));
}

#[test]
fn equal_overlaps_and_missing_values_are_counted() {
    let mut hole = block(0, [0; 3], [4; 3], 1.0);
    hole.values[21] = f32::NEG_INFINITY;
    let grid = new(&[], vec![hole, block(0, [3, 0, 0], [3, 4, 4], 1.0)]).unwrap();
    assert_eq!((grid.repeated_values(), grid.missing_values()), (16, 1));
    assert_eq!(grid.leaf_cells(0), 64 + 32);
    // Value 21 is that of cell (1, 1, 1): what lies between it and the cells around is vacuum.
    assert_eq!(grid.value(DVec3::splat(1.4)), None);
    assert_eq!(grid.value(DVec3::new(2.6, 1.4, 1.4)), Some(1.0));
}

#[test]
fn coarse_cells_have_the_means_of_finer_ones() {
    let mut fine = block(1, [2; 3], [2; 3], 0.0);
    fine.values = (0..8).map(|i| i as f32).collect();
    let grid = new(&[[2; 3]], vec![fine, block(0, [0; 3], [4; 3], -1.0)]).unwrap();
    assert_eq!(grid.blocks()[0].level, 0, "coarse blocks come first");
    assert_eq!(grid.blocks()[0].values[21], 3.5);
    assert_eq!((grid.leaf_cells(0), grid.leaf_cells(1)), (63, 8));
    assert_eq!(grid.value_range(), (-1.0, 7.0));
    assert_eq!(grid.finest_dims(), [8; 3]);
}

/// Blocks only, wherever they are: the box of a level is never filled.
#[test]
fn memory_is_that_of_the_blocks() {
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 0.5,
        blocks: [2; 3],
        block_cells: [8; 3],
        ratios: vec![[2; 3]; 5],
        centring: AmrCentring::Cells,
    };
    let near = |low: DVec3, high: DVec3, _| low.max_element() < 0.1 && high.min_element() > 0.01;
    let grid = AmrGrid::refining(&sampling, |p| p.x as f32, near).unwrap();
    let cells: u64 = grid.finest_dims().iter().product();
    assert!(cells > 100_000_000, "{cells}");
    let values: usize = grid.blocks().iter().map(|b| 4 * b.values.len()).sum();
    assert!(grid.bytes() < values + values / 8, "{} for {values}", grid.bytes());
}

/// Level of the finest cell that covers a place.
fn level_at(grid: &AmrGrid, at: DVec3) -> Option<usize> {
    let covers = |block: &AmrBlock| {
        let index = (at - grid.origin()) / grid.spacing_of(block.level);
        let cells = block.cells(grid.centring());
        (0..3).all(|a| {
            let from = block.first[a] as f64;
            from <= index[a] && index[a] < from + cells[a] as f64
        })
    };
    grid.blocks().iter().filter(|b| covers(b)).map(|b| b.level).max()
}

/// A ray through a place of the mesh; along an axis or across a face of blocks now and then.
fn ray_through(grid: &AmrGrid, random: &mut Random) -> Ray {
    let mut at = place(grid, random);
    let mut direction = DVec3::new(random.next(), random.next(), random.next()) * 2.0 - 1.0;
    if random.next() < 0.3 {
        // In a face of cells, and parallel to it.
        let spacing = grid.spacing_of(0);
        at.x = grid.origin().x + ((at.x - grid.origin().x) / spacing.x).round() * spacing.x;
        direction.x = 0.0;
    }
    let direction = direction.normalize();
    Ray { origin: at - direction * 40.0 * random.next(), direction }
}

#[test]
fn parts_of_rays_are_all_that_is_not_vacuum() {
    let mut random = Random(7);
    for centring in CENTRINGS {
        for (seed, ratios) in RATIOS.into_iter().enumerate() {
            let mut noise = Random(seed as u64);
            let holed = seed % 2 == 1;
            let values = std::cell::RefCell::new(&mut noise);
            let value = |_: DVec3| {
                let v = values.borrow_mut().next();
                if holed && v < 0.01 { f64::NAN } else { v }
            };
            let grid = patchy(seed as u64, ratios, centring, value);
            for _ in 0..60 {
                let ray = ray_through(&grid, &mut random);
                let parts: Vec<_> = grid.parts_along(&ray, [0.0, 60.0]).collect();
                let mut last = 0.0;
                for part in &parts {
                    assert!(part.from >= last && part.to > part.from, "{part:?} behind {last}");
                    let level = grid.blocks()[part.block].level;
                    for t in [0.03, 0.4, 0.97] {
                        let at = ray.origin + ray.direction * (part.from + (part.to - part.from) * t);
                        let Some(value) = grid.value(at) else { panic!("vacuum at {at} in {part:?}") };
                        let within = part.range.map(f64::from);
                        assert!(within[0] - 1e-6 <= value && value <= within[1] + 1e-6, "{value} in {part:?}");
                        // Rounding may put what is in a face of two levels to either.
                        let off_faces = ray.direction.x != 0.0 && part.to - part.from > 1e-6;
                        assert!(!off_faces || level_at(&grid, at) == Some(level), "{at} in {part:?}");
                    }
                    // Nothing but vacuum lies between two parts.
                    for t in [0.1, 0.5, 0.9] {
                        let at = ray.origin + ray.direction * (last + (part.from - last) * t);
                        assert!(part.from - last < 1e-9 || grid.value(at).is_none(), "{at} before {part:?}");
                    }
                    last = part.to;
                }
                let total: f64 = parts.iter().map(|p| p.to - p.from).sum();
                let n = 4000;
                let along = |k: i32| ray.origin + ray.direction * (60.0 * (f64::from(k) + 0.5) / f64::from(n));
                let seen = (0..n).filter(|&k| grid.value(along(k)).is_some()).count();
                let off = (total - 60.0 * seen as f64 / f64::from(n)).abs();
                // Each end of a run of parts is known to one of the places.
                let ends = 2 + 2 * parts.windows(2).filter(|w| w[0].to != w[1].from).count();
                assert!(off < 60.0 / f64::from(n) * ends as f64, "{total}, but {seen} of {n}");
            }
        }
    }
}

/// Blocks in places so far apart that no one could go from cell to cell between them.
#[test]
fn rays_leap_between_blocks_that_are_far_apart() {
    let far = 1i64 << 35;
    let blocks = vec![block(0, [0; 3], [4; 3], 1.0), block(0, [far, 0, 0], [4; 3], 2.0)];
    let grid = new(&[], blocks).unwrap();
    let ray = Ray { origin: DVec3::new(-5.0, 2.1, 1.9), direction: DVec3::X };
    let parts: Vec<_> = grid.parts_along(&ray, [0.0, 1e12]).collect();
    let of_block = |number: usize| parts.iter().filter(move |p| p.block == number);
    let ends = [0, 1].map(|n| (of_block(n).next().unwrap().from, of_block(n).next_back().unwrap().to));
    let wanted = [(5.5, 8.5), (far as f64 + 5.5, far as f64 + 8.5)];
    assert!(ends.iter().zip(wanted).all(|(e, w)| (e.0 - w.0).abs() < 1e-3 && (e.1 - w.1).abs() < 1e-3), "{ends:?}");
}

/// Lattices have the samples of `corners` and `stencil`, and say where there are none.
#[test]
fn lattices_hold_the_samples_around_every_place_of_a_block() {
    for centring in CENTRINGS {
        for (seed, ratios) in RATIOS.into_iter().enumerate() {
            let mut noise = Random(seed as u64);
            let values = std::cell::RefCell::new(&mut noise);
            let grid = patchy(seed as u64, ratios, centring, |_| values.borrow_mut().next());
            let samples = grid.samples();
            let border = AmrLattice::border(centring) as i32;
            let (mut known, mut sloped) = (0, 0);
            for (number, block) in grid.blocks().iter().enumerate() {
                let own = AmrLattice { dims: block.dims, values: block.values.clone() };
                let made = samples.lattice(number);
                let bytes = |lattice: &AmrLattice| size_of_val(&*lattice.values) as u64;
                assert_eq!(samples.lattice_bytes(number), made.as_ref().map_or(0, bytes));
                let lattice = made.unwrap_or(own);
                let differences = samples.difference_lattice(number);
                assert_eq!(samples.difference_lattice_bytes(number), bytes(&differences));
                let at = |lattice: &AmrLattice, place: [i32; 3]| {
                    let [x, y, z] = place.map(|i| i as usize);
                    lattice.values[(z * lattice.dims[1] + y) * lattice.dims[0] + x]
                };
                let mut random = Random(number as u64);
                for _ in 0..50 {
                    let low: [i32; 3] =
                        std::array::from_fn(|a| (random.next() * (lattice.dims[a] - 1) as f64) as i32 - border);
                    let up = |i: usize| [i as i32 & 1, i as i32 >> 1 & 1, i as i32 >> 2];
                    let eight: [f32; 8] =
                        std::array::from_fn(|i| at(&lattice, std::array::from_fn(|a| low[a] + up(i)[a] + border)));
                    if let Some(corners) = samples.corners(number, low) {
                        known += 1;
                        assert_eq!(eight, corners, "{low:?} of {number}");
                    } else if centring == AmrCentring::Cells {
                        assert!(eight.iter().any(|v| !v.is_finite()), "{low:?} of {number}");
                    }
                    let mut stencil = [0.0; 32];
                    if samples.stencil(number, low, &mut stencil) {
                        sloped += 1;
                        // The samples in the middle, and those before them along x.
                        for i in 0..4 {
                            let by = |x: i32| [low[0] + x, low[1] + (i as i32 & 1), low[2] + (i as i32 >> 1)];
                            let got = at(&differences, by(-1).map(|i| i + border + 1));
                            assert!(got.is_nan() || (got - stencil[8 + i]).abs() < 1e-6, "{low:?} of {number}");
                            assert_eq!(at(&differences, by(0).map(|i| i + border + 1)), stencil[2 * i]);
                        }
                    }
                }
            }
            assert!(known > 100 && sloped > 100, "{known} {sloped}");
        }
    }
}

#[test]
fn samples_around_a_place_make_the_field_and_its_gradient() {
    for centring in CENTRINGS {
        for (seed, ratios) in RATIOS.into_iter().enumerate() {
            let mut noise = Random(seed as u64);
            let values = std::cell::RefCell::new(&mut noise);
            let grid = patchy(seed as u64, ratios, centring, |_| values.borrow_mut().next());
            let samples = grid.samples();
            let mut random = Random(seed as u64 + 99);
            let (mut told, mut inner, mut sloped, mut rims) = (0, 0, 0, 0);
            for _ in 0..3000 {
                let at = place(&grid, &mut random);
                let Some(level) = level_at(&grid, at) else { continue };
                let spacing = grid.spacing_of(level);
                let in_block = |b: &AmrBlock| {
                    let index = (at - grid.origin()) / spacing - DVec3::from_array(b.first.map(|i| i as f64));
                    let cells = DVec3::from_array(b.cells(centring).map(|n| n as f64));
                    b.level == level && index.cmpge(DVec3::ZERO).all() && index.cmplt(cells).all()
                };
                let number = grid.blocks().iter().position(in_block).unwrap();
                let local = (at - samples.first_place(number)) / spacing;
                let low = local.floor().to_array().map(|x| x as i32);
                let t = local - local.floor();
                let weight =
                    |i: usize| -> f64 { (0..3).map(|a| if i >> a & 1 == 1 { t[a] } else { 1.0 - t[a] }).product() };
                let corners = samples.corners(number, low);
                if let Some(corners) = corners {
                    told += 1;
                    let value: f64 = (0..8).map(|i| f64::from(corners[i]) * weight(i)).sum();
                    assert!((value - grid.value(at).unwrap()).abs() < 1e-6, "{at}");
                } else if let Some(value) = samples.value_at_rim(number, low, t) {
                    rims += 1;
                    assert!((value - grid.value(at).unwrap()).abs() < 1e-9, "{at}: {value}");
                } else {
                    assert!(grid.value(at).is_none(), "{at}");
                }
                let [first, last] = samples.inner(number);
                let is_inner = (0..3).all(|a| first[a] <= low[a] && low[a] <= last[a]);
                assert!(!is_inner || corners.is_some());
                inner += usize::from(is_inner);
                let mut s = [0.0; 32];
                if samples.stencil(number, low, &mut s) {
                    sloped += 1;
                    let rise = |a: usize, i: usize| {
                        let (bit, up) = (1 << a, i >> a & 1 == 1);
                        let others = [[1, 2], [0, 2], [0, 1]][a];
                        let plane = (i >> others[0] & 1) + 2 * (i >> others[1] & 1);
                        let (low, high) =
                            if up { (s[i - bit], s[12 + 8 * a + plane]) } else { (s[8 + 8 * a + plane], s[i + bit]) };
                        0.5 * f64::from(high - low) / spacing[a]
                    };
                    let gradient = grid.gradient(at).unwrap();
                    for a in 0..3 {
                        let slope: f64 = (0..8).map(|i| rise(a, i) * weight(i)).sum();
                        assert!((slope - gradient[a]).abs() < 1e-5 / spacing[a], "{slope} for {gradient}");
                    }
                }
            }
            assert!(told > 300 && inner > 50 && sloped > 20 && rims > 50, "{told} {inner} {sloped} {rims}");
        }
    }
}
