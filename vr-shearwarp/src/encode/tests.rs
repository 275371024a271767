//! Runs against the plain definition, on random small volumes and on the hard ones by name.

use proptest::prelude::*;
use vr_core::{AnyGrid, Calibration, GridVolume, Placement, UniformGrid, Volume, Voxel};
use vr_kernels::ranges::LevelRanges;

use super::*;

fn volume<T: Voxel>(dims: [usize; 3], samples: Vec<T>) -> Volume
where
    AnyGrid: From<UniformGrid<T>>,
{
    UniformGrid::new(dims, samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default()).unwrap().into()
}

/// Visible is what meets one of the closed ranges.
fn visibility(volume: &GridVolume, seen: &[(f64, f64)]) -> VisibleLevels {
    let range = volume.value_stats().range.unwrap_or((0.0, 0.0));
    VisibleLevels::new((range.0.into(), range.1.into()), volume.voxel_type().is_integer(), |from, to| {
        seen.iter().any(|&(a, b)| from <= b && a <= to)
    })
}

/// The samples of the corners of a cell.
fn corners<const N: usize, T: Voxel>(
    samples: &[T],
    dims: [usize; 3],
    layout: &Layout,
    [u, v, k]: [usize; 3],
) -> Vec<T> {
    let corner = |c: usize| layout.position([u + (c & 1), v + (c >> 1 & 1), k + (c >> 2)]);
    (0..2 * N).map(corner).map(|[x, y, z]| samples[(z * dims[1] + y) * dims[0] + x]).collect()
}

/// The definition.
fn is_visible<T: Leveled>(corners: &[T], rule: Rule<'_>) -> bool {
    if corners.iter().any(|c| c.is_missing()) {
        return false;
    }
    let by = |a: &&T, b: &&T| a.to_f32().total_cmp(&b.to_f32());
    let (low, high) = (*corners.iter().min_by(by).unwrap(), *corners.iter().max_by(by).unwrap());
    match rule {
        Rule::Interpolated(visibility) => visibility.between(low, high),
        Rule::Classified(visibility) => corners.iter().any(|&c| visibility.at(c)),
        Rule::Everything => true,
    }
}

/// Asserts that the voxels of a run are those of its cells.
fn holds_the_voxels<const N: usize, T: Leveled>(run: &Run<N>, [v, k]: [usize; 2], stored: &[T], dense: &Dense<'_, T>) {
    for ([dv, dk], at) in runs::edges::<N>().into_iter().zip(run.at) {
        let (at, len) = (at as usize, run.len as usize + 1);
        let row = dense.row([run.start as usize, v + dv, k + dk], len);
        for (a, b) in stored[at..at + len].iter().zip(row) {
            assert_eq!(a.to_f32().to_bits(), b.to_f32().to_bits());
        }
    }
}

/// Checks everything that is promised of one axis, one rule and one kind of cells.
fn check<const N: usize, T: Leveled>(volume: &GridVolume, samples: &[T], w: usize, rule: Rule<'_>) {
    let dims = volume.dims();
    let dense = Dense::new(samples, dims, w);
    let layout = dense.layout;
    let [nu, _, nw] = layout.size;
    let blocks = Pyramid::new(volume).visible(rule);
    // What is not copied is not looked at.
    let partial = Dense::visible(samples, dims, w, &blocks);
    let (runs, packing) = packed::<N, T>(&partial, &blocks, rule).unwrap();
    let stored = packing.pack(&partial, |s| s);
    assert_eq!(stored.len(), packing.stored() + PAD);
    let positions = packing.fill(&|[u, v, k], to: &mut [usize]| {
        for (i, to) in to.iter_mut().enumerate() {
            let [x, y, z] = layout.position([u + i, v, k]);
            *to = (z * dims[1] + y) * dims[0] + x;
        }
    });
    assert!(positions.iter().zip(&stored).take(packing.stored()).all(|(&p, s)| samples[p].to_f32() == s.to_f32()));
    // Each stored voxel once, in the order layer, row, column.
    let order = |&p: &usize| {
        let xyz = [p % dims[0], p / dims[0] % dims[1], p / (dims[0] * dims[1])];
        let [u, v, k] = layout.axes.map(|a| xyz[a]);
        (k, v, u)
    };
    assert!(positions[..packing.stored()].is_sorted_by(|a, b| order(a) < order(b)));

    let of_blocks = block_runs::<N>(layout, &blocks).unwrap();
    assert_eq!(of_blocks.is_none(), volume.vacuum_cells().is_some());
    assert_eq!((runs.layers(), runs.rows()), (if N == 2 { nw } else { nw - 1 }, layout.size[1] - 1));
    let mut needed = vec![false; samples.len()];
    let mut cells = 0;
    for k in 0..runs.layers() {
        assert_eq!(runs.layer_is_empty(k), (0..runs.rows()).all(|v| runs.row(k, v).is_empty()));
        for v in 0..runs.rows() {
            let expected: Vec<bool> =
                (0..nu - 1).map(|u| is_visible(&corners::<N, T>(samples, dims, &layout, [u, v, k]), rule)).collect();
            let covered = |runs: &[Run<N>]| {
                // In their order, apart, and as long as can be.
                assert!(runs.windows(2).all(|r| r[0].start + r[0].len < r[1].start));
                let mut covered = vec![false; nu - 1];
                for run in runs {
                    assert!(run.len > 0);
                    covered[run.start as usize..(run.start + run.len) as usize].fill(true);
                }
                covered
            };
            assert_eq!(covered(runs.row(k, v)), expected);
            for run in runs.row(k, v) {
                holds_the_voxels(run, [v, k], &stored, &dense);
            }
            cells += expected.iter().filter(|e| **e).count();
            for u in (0..nu - 1).filter(|&u| expected[u]) {
                for c in 0..2 * N {
                    let [x, y, z] = layout.position([u + (c & 1), v + (c >> 1 & 1), k + (c >> 2)]);
                    needed[(z * dims[1] + y) * dims[0] + x] = true;
                }
            }
            if let Some(runs) = &of_blocks {
                let covered = covered(runs.row(k, v));
                assert!(covered.iter().zip(&expected).all(|(covered, expected)| *covered || !expected));
                for run in runs.row(k, v) {
                    holds_the_voxels(run, [v, k], &dense.samples, &dense);
                    holds_the_voxels(run, [v, k], &partial.samples, &dense);
                }
            }
        }
    }
    assert_eq!((runs.cells(), runs.is_empty()), (cells, cells == 0));
    assert_eq!(packing.stored(), needed.iter().filter(|n| **n).count());
}

fn check_all<T: Leveled>(dims: [usize; 3], samples: Vec<T>, seen: &[(f64, f64)])
where
    AnyGrid: From<UniformGrid<T>>,
{
    let volume = volume(dims, samples.clone());
    let volume = volume.grid().unwrap();
    let visibility = visibility(volume, seen);
    for rule in [Rule::Interpolated(&visibility), Rule::Classified(&visibility), Rule::Everything] {
        for w in 0..3 {
            check::<2, T>(volume, &samples, w, rule);
            check::<4, T>(volume, &samples, w, rule);
        }
        blocks_are_brute_force(volume, &samples, rule);
    }
}

/// Visible blocks are those whose own range may be visible, and hold every visible cell.
fn blocks_are_brute_force<T: Leveled>(volume: &GridVolume, samples: &[T], rule: Rule<'_>) {
    let dims = volume.dims();
    let blocks = Pyramid::new(volume).visible(rule);
    let size = dims.map(|n| (n - 1).div_ceil(LevelRanges::EDGE));
    let mut count = 0;
    for (z, y, x) in positions(size) {
        let span = |a: usize, b: usize| b * LevelRanges::EDGE..((b + 1) * LevelRanges::EDGE + 1).min(dims[a]);
        let mut all = Vec::new();
        for z in span(2, z) {
            for y in span(1, y) {
                all.extend(span(0, x).map(|x| samples[(z * dims[1] + y) * dims[0] + x]).filter(|s| !s.is_missing()));
            }
        }
        let expected = match rule {
            _ if all.is_empty() => false,
            // Not the whole block is needed for a cell to be classified: its range decides.
            Rule::Classified(visibility) => is_visible(&all, Rule::Interpolated(visibility)),
            rule => is_visible(&all, rule),
        };
        count += usize::from(blocks.may([x, y, z]));
        if LevelRanges::are_exact(volume) || matches!(rule, Rule::Everything) {
            assert_eq!(blocks.may([x, y, z]), expected);
        } else {
            assert!(blocks.may([x, y, z]) || !expected);
        }
    }
    assert_eq!(blocks.count(), count);
}

fn positions([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..nx * ny * nz).map(move |i| (i / (nx * ny), i / nx % ny, i % nx))
}

/// Numbers that are mostly one, so that a part is sparse.
fn numbers() -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(prop_oneof![12 => Just(0u16), 1 => 0u16..=u16::MAX, 2 => 0u16..300], 1..4000)
}

fn dims() -> impl Strategy<Value = [usize; 3]> {
    prop_oneof![
        6 => prop::array::uniform3(2usize..12),
        1 => (62usize..72, 2usize..6, 2usize..4).prop_map(|(a, b, c)| [a, b, c]),
        1 => (62usize..72, 2usize..6, 2usize..4).prop_map(|(a, b, c)| [b, a, c]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn runs_are_the_definition(
        dims in dims(),
        numbers in numbers(),
        kind in 0..5,
        seen in prop::collection::vec((0.0f64..1.0, prop_oneof![Just(0.0), 0.0..0.3f64]), 0..3),
        // The smooth part of the field has small ranges in a cell.
        smooth in 0u16..40,
        missing in any::<bool>(),
    ) {
        let count = dims.iter().product::<usize>();
        let at = |i: usize| {
            let wave = (i % dims[0] + i / dims[0] % dims[1] + i / (dims[0] * dims[1])) as u16 * smooth;
            numbers[i % numbers.len()].wrapping_add(wave)
        };
        let raw: Vec<u16> = (0..count).map(at).collect();
        let low = f64::from(*raw.iter().min().unwrap());
        let high = f64::from(*raw.iter().max().unwrap());
        let scaled = |low: f64, high: f64| -> Vec<(f64, f64)> {
            seen.iter().map(|&(a, w)| ((low + a * (high - low)).round(), (low + (a + w) * (high - low)).round())).collect()
        };
        match kind {
            0 => check_all(dims, raw.iter().map(|&x| x as u8).collect::<Vec<_>>(), &scaled(0.0, 255.0)),
            1 => check_all(dims, raw.iter().map(|&x| x as i8).collect::<Vec<_>>(), &scaled(-128.0, 127.0)),
            2 => check_all(dims, raw, &scaled(low, high)),
            3 => check_all(dims, raw.iter().map(|&x| x as i16).collect::<Vec<_>>(), &scaled(-32768.0, 32767.0)),
            _ => {
                let float = |(i, &x): (usize, &u16)| if missing && (i * 7919) % 23 == 5 { f32::NAN } else { f32::from(x) / 7.0 };
                check_all(dims, raw.iter().enumerate().map(float).collect(), &scaled(low / 7.0, high / 7.0));
            }
        }
    }
}

const SIZES: [[usize; 3]; 7] = [[2, 2, 2], [5, 3, 2], [65, 3, 4], [3, 65, 4], [4, 3, 66], [64, 2, 3], [9, 10, 5]];

#[test]
fn empty_and_full_volumes() {
    for dims in SIZES {
        let count = dims.iter().product::<usize>();
        let samples: Vec<u8> = (0..count).map(|i| (i % 7) as u8).collect();
        check_all(dims, samples.clone(), &[]);
        check_all(dims, samples, &[(0.0, 9.0)]);
        check_all(dims, vec![3.5f32; count], &[(3.5, 3.5)]);
        check_all(dims, vec![3.5f32; count], &[(3.6, 4.0)]);
        check_all(dims, vec![f32::NAN; count], &[(0.0, 1.0)]);
    }
}

#[test]
fn one_voxel_is_seen_by_the_cells_around_it() {
    for dims in SIZES {
        let count = dims.iter().product::<usize>();
        for at in (0..count).step_by(count.div_ceil(9)) {
            let mut samples = vec![0u8; count];
            samples[at] = 200;
            check_all(dims, samples.clone(), &[(200.0, 200.0)]);
            check_all(dims, samples.iter().map(|&x| i16::from(x) * 100).collect(), &[(99.5, 99.6)]);
        }
    }
}

#[test]
fn a_missing_voxel_takes_the_cells_around_it() {
    for dims in SIZES {
        let count = dims.iter().product::<usize>();
        for at in (0..count).step_by(count.div_ceil(9)) {
            let mut samples: Vec<f32> = (0..count).map(|i| i as f32).collect();
            samples[at] = f32::NAN;
            check_all(dims, samples.clone(), &[(0.0, 1e9)]);
            check_all(dims, samples, &[(3.5, 7.0)]);
        }
    }
}

/// A whole layer between two that are missing: its squares are there though every cell in space is vacuum.
#[test]
fn a_layer_between_missing_ones() {
    let dims = [6, 5, 3];
    let samples: Vec<f32> = (0..90).map(|i| if i / 30 == 1 { i as f32 } else { f32::NAN }).collect();
    let volume = volume(dims, samples.clone());
    let volume = volume.grid().unwrap();
    let blocks = Pyramid::new(volume).visible(Rule::Everything);
    let (runs, _) = packed::<2, f32>(&Dense::new(&samples, dims, 2), &blocks, Rule::Everything).unwrap();
    assert_eq!(runs.cells(), 20);
    check_all(dims, samples, &[(40.0, 50.0)]);
}

/// Air of one number stays out of the blocks under a ramp that begins at it; what is a little more does not.
#[test]
fn air_of_floats_is_in_no_block() {
    let mut samples = vec![0.25f32; 17 * 17 * 17];
    samples[0] = 9.0;
    let last = samples.len() - 1;
    samples[last] = 0.250_000_1;
    let volume = volume([17; 3], samples);
    let volume = volume.grid().unwrap();
    let visibility = VisibleLevels::new((0.25, 9.0), false, |_, to| to > 0.25);
    let blocks = Pyramid::new(volume).visible(Rule::Interpolated(&visibility));
    assert!(blocks.count() == 2 && blocks.may([0; 3]) && blocks.may([3; 3]));
}

#[test]
fn threads_change_nothing() {
    let dims = [70, 30, 20];
    let samples: Vec<u8> = (0..42_000u64).map(|i| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 60) as u8).collect();
    let volume = volume(dims, samples.clone());
    let volume = volume.grid().unwrap();
    let visibility = visibility(volume, &[(15.0, 15.0)]);
    let encode = || {
        let rule = Rule::Classified(&visibility);
        let blocks = Pyramid::new(volume).visible(rule);
        let dense = Dense::new(&samples, dims, 0);
        let (runs, packing) = packed::<4, u8>(&dense, &blocks, rule).unwrap();
        (runs, packing.pack(&dense, |s| s))
    };
    let with = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(encode);
    assert_eq!(with(1), with(3));
}
