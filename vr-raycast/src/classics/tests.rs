//! Every structure over random blocks, rays and fields.

use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;
use vr_core::filter::Reconstruction;
use vr_core::*;
use vr_kernels::ranges::RangeBlocks;
use vr_kernels::tables::BakedTransfer;

use super::*;
use crate::leap::ExactCloud;

/// Makes all structures over the same blocks.
pub(super) fn leapers(
    dims: [usize; 3],
    ranges: &RangeBlocks,
    seen: &Visibility<f32>,
) -> Vec<(&'static str, Box<dyn Leaper>)> {
    let blocks = VisibleBlocks::new(dims, ranges, seen);
    vec![
        ("octree", Box::new(Octree::new(Arc::new(NodeRanges::new(dims, ranges)), ranges, seen))),
        ("pyramid", Box::new(Pyramid::new(&blocks))),
        ("exact cloud", Box::new(ExactCloud::new(&blocks))),
        ("chessboard cloud", Box::new(ChessboardCloud::new(&blocks))),
        ("boxes", Box::new(Boxes::new(&blocks))),
        ("polyhedron", Box::new(Polyhedron::new(&blocks))),
    ]
}

/// Returns all intervals of a ray, checked for order.
fn intervals(leaper: &dyn Leaper, ray: &IndexRay) -> Result<Vec<(f64, f64)>, TestCaseError> {
    let mut found: Vec<(f64, f64)> = Vec::new();
    let mut from = ray.start;
    while let Some((begin, end)) = leaper.next(ray, from) {
        prop_assert!(begin >= from && begin <= end && end > from && end <= ray.end, "{begin} {end} from {from}");
        prop_assert!(found.len() < 1000, "no end");
        found.push((begin, end));
        from = end;
    }
    Ok(found)
}

fn holds(intervals: &[(f64, f64)], s: f64) -> bool {
    intervals.iter().any(|&(begin, end)| begin <= s && s <= end)
}

/// Volumes of a few values, mostly 0, some with holes.
fn volumes() -> impl Strategy<Value = Volume> {
    let dims = prop::array::uniform3(2usize..14);
    let spacing = prop::array::uniform3(prop_oneof![Just(1.0), 0.2f64..4.0]);
    let spots = prop::collection::vec(
        (0usize..2744, prop_oneof![6 => (1u8..9).prop_map(f32::from), 1 => Just(f32::NAN)]),
        0..12,
    );
    (dims, spacing, spots).prop_map(|(dims, spacing, spots)| {
        let mut samples = vec![0.0f32; dims.iter().product()];
        for (at, value) in spots {
            let n = samples.len();
            samples[at % n] = value;
        }
        let placement = Placement::from_spacing(spacing).unwrap();
        UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into()
    })
}

/// Rays through a volume between two points, in tenths of its extent or on its lattice: in faces, along axes, through corners.
fn rays() -> impl Strategy<Value = ([f64; 3], [f64; 3], bool)> {
    let point = || prop::array::uniform3(prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0f64..1.0]);
    let aligned = (point(), point(), 0usize..3).prop_map(|(a, b, axis)| {
        let mut end = a;
        end[axis] = b[axis];
        (a, end)
    });
    let nearly = (point(), point(), 0usize..3, -1e-5f64..1e-5).prop_map(|(a, b, axis, tilt)| {
        let mut end = a.map(|x| x + tilt);
        end[axis] = b[axis];
        (a, end)
    });
    (prop_oneof![(point(), point()), aligned, nearly], prop::bool::ANY).prop_map(|((a, b), lattice)| (a, b, lattice))
}

fn ray_between(volume: &GridVolume, (from, to, lattice): ([f64; 3], [f64; 3], bool)) -> Option<IndexRay> {
    let last = volume.dims().map(|n| (n - 1) as f64);
    let place = |p: [f64; 3]| {
        let index: [f64; 3] = std::array::from_fn(|a| if lattice { (p[a] * last[a]).round() } else { p[a] * last[a] });
        volume.placement().to_world(index.into())
    };
    let (from, to) = (place(from), place(to));
    let direction = (to - from).try_normalize()?;
    let ray = Ray { origin: from - direction * 20.0, direction };
    IndexRay::new(&ray, volume.placement(), volume.dims(), &Clip::default(), f64::INFINITY)
}

fn transfers() -> impl Strategy<Value = TransferFunction> {
    let opacity = prop_oneof![2 => Just(0.0), 1 => 0.01f64..1.0];
    prop::collection::vec((prop_oneof![Just(0.0), Just(2.0), -1.0f64..9.0], opacity), 1..5).prop_map(|mut points| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points = points.into_iter().map(|(v, a)| ControlPoint::new(v, [1.0; 3], a)).collect();
        TransferFunction::new(points, OpacityRule::Power, 1.0).unwrap()
    })
}

/// The field in f32, at a position rounded to f32.
struct Sampled(DVec3);

impl SamplerVisitor for Sampled {
    type Output = f32;

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> f32 {
        let max_index = sampler.lattice().dims.map(|n| (n - 1) as f32);
        let at = self.0.to_array();
        sampler.value(std::array::from_fn(|a| (at[a] as f32).clamp(0.0, max_index[a])))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1024, failure_persistence: None, ..ProptestConfig::default() })]

    /// Every sample that a kernel can see, by table or exactly, lies in an interval of every structure.
    #[test]
    fn all_that_is_visible_lies_in_intervals(
        volume in volumes(),
        transfer in transfers(),
        lines in prop::collection::vec(rays(), 4),
        filter in prop::sample::select(&Filter::ALL[..]),
        edge in 1usize..5,
        threshold in prop::option::of(0.0f64..9.0),
    ) {
        let volume = volume.with_filter(filter);
        let volume = volume.grid().unwrap();
        let table = Arc::new(BakedTransfer::<f32>::new(&transfer, Calibration::default(), (0.0, 9.0), false, 0.3));
        let seen = match threshold {
            Some(threshold) => Visibility::of_threshold(threshold, Calibration::default()),
            None => Visibility::of_light(&transfer, Calibration::default(), Some(&table), None),
        };
        let shows = |value: f32| match threshold {
            Some(threshold) => value >= threshold as f32,
            None => !value.is_nan() && (transfer.at(value.into()).opacity > 0.0 || table.step(value)[3] > 0.0),
        };
        let ranges = RangeBlocks::of_volume(volume, edge);
        let leapers = leapers(volume.dims(), &ranges, &seen);
        for line in lines {
            let Some(ray) = ray_between(volume, line) else { continue };
            for (name, leaper) in &leapers {
                let found = intervals(leaper.as_ref(), &ray)?;
                for k in 0..=256u16 {
                    let s = (ray.start + ray.length() * f64::from(k) / 256.0).min(ray.end);
                    let value = volume.with_sampler(Sampled(ray.at(s)));
                    prop_assert!(!shows(value) || holds(&found, s), "{name}: {value} at {s} not in {found:?} of {ray:?}");
                }
            }
        }
    }

    /// The structures over blocks cut the ray where its beam enters and leaves visible blocks: no less is in an interval, and no more.
    #[test]
    fn structures_over_blocks_are_exact(
        dims in prop::array::uniform3(2usize..40),
        edge in 1usize..4,
        seed in any::<u64>(),
        share in prop_oneof![Just(0.0), Just(1.0), 0.0f64..1.0],
        cluster in 1usize..7,
        lines in prop::collection::vec(rays(), 4),
    ) {
        // Visible clusters, so that there are regions to leap over.
        let hash = |b: [usize; 3]| {
            let mut h = seed;
            for c in b {
                h = (h ^ (c / cluster) as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                h ^= h >> 29;
            }
            (h >> 11) as f64 / (1u64 << 53) as f64
        };
        let placement = Placement::from_spacing([1.0; 3]).unwrap();
        let volume: Volume = UniformGrid::new(dims, vec![0u8; dims.iter().product()], placement, Calibration::default()).unwrap().into();
        let volume = volume.grid().unwrap();
        let blocks = VisibleBlocks::from_fn(dims, edge, |b| hash(b) < share);
        let grid = blocks.grid();
        let structures: [(&str, Box<dyn Leaper>); 3] = [
            ("pyramid", Box::new(Pyramid::new(&blocks))),
            ("exact cloud", Box::new(ExactCloud::new(&blocks))),
            ("chessboard cloud", Box::new(ChessboardCloud::new(&blocks))),
        ];
        for line in lines {
            let Some(ray) = ray_between(volume, line) else { continue };
            for (name, leaper) in &structures {
                let found = intervals(leaper.as_ref(), &ray)?;
                for k in 0..=256u16 {
                    let s = (ray.start + ray.length() * f64::from(k) / 256.0).min(ray.end);
                    let touched = |reach: f64| {
                        let at = (ray.at(s) / edge as f64).to_array();
                        let span: [_; 3] = std::array::from_fn(|a| {
                            let block = |x: f64| (x.max(0.0) as usize).min(grid.blocks[a] - 1);
                            block(at[a] - reach)..=block(at[a] + reach)
                        });
                        let [xs, ys, zs] = span;
                        zs.into_iter().any(|z| ys.clone().any(|y| xs.clone().any(|x| blocks.at([x, y, z]))))
                    };
                    // Rounding in f64 is far below a thousandth of the reach.
                    prop_assert!(!touched(0.999 * grid.reach) || holds(&found, s), "{name}: {s} not in {found:?} of {ray:?}");
                    prop_assert!(touched(1.001 * grid.reach) || !holds(&found, s), "{name}: {s} in {found:?} of {ray:?}");
                }
            }
        }
    }
}

#[test]
fn chessboard_distances_are_a_kings() {
    let seeds = [[3, 4, 5], [66, 0, 9]];
    let blocks = VisibleBlocks::from_fn([71, 11, 13], 1, |b| seeds.contains(&b));
    let cloud = ChessboardCloud::new(&blocks);
    let n = blocks.grid().blocks;
    for z in 0..n[2] {
        for y in 0..n[1] {
            for x in 0..n[0] {
                let king = |s: [usize; 3]| x.abs_diff(s[0]).max(y.abs_diff(s[1])).max(z.abs_diff(s[2]));
                assert_eq!(usize::from(cloud.distance([x, y, z])), seeds.map(king).into_iter().min().unwrap());
            }
        }
    }
}

/// Memory beyond an 8-bit volume: at most 15 %, whatever the structure.
#[test]
fn structures_are_small() {
    let dims = [129, 97, 113];
    let samples: Vec<u8> = (0..dims.iter().product::<usize>()).map(|i| (i % 251) as u8).collect();
    let placement = Placement::from_spacing([1.0; 3]).unwrap();
    let volume: Volume = UniformGrid::new(dims, samples, placement, Calibration::default()).unwrap().into();
    let volume = volume.grid().unwrap();
    let ranges = RangeBlocks::of_volume(volume, EDGE);
    let seen = Visibility::of_threshold(128.0, Calibration::default());
    for (name, leaper) in leapers(dims, &ranges, &seen) {
        let bytes = leaper.bytes() + size_of_val(ranges.ranges());
        assert!(bytes as f64 <= 0.15 * volume.sample_bytes() as f64, "{name}: {bytes}");
    }
}
