//! Random scenes and views, for tests of packets.

use glam::{DMat3, DVec3};
use proptest::prelude::*;
use vr_core::{
    Calibration, Camera, Clip, Compositing, ControlPoint, OpacityRule, Placement, Plane, Scene, TransferFunction,
    UniformGrid, View, Volume,
};
use vr_physics::check::FixedLayer;

use crate::caster::Step;

/// Makes a grid of one of the five types from numbers in [0, 1].
pub(super) fn grid(kind: usize, dims: [usize; 3], samples: &[f64], placement: Placement) -> Volume {
    fn of<T: vr_core::Voxel>(
        dims: [usize; 3],
        samples: &[f64],
        placement: Placement,
        range: [f64; 2],
        round: impl Fn(f64) -> T,
    ) -> Volume
    where
        Volume: From<UniformGrid<T>>,
    {
        // Calibrated so that values are in [0, 1] again.
        let calibration =
            Calibration { slope: 1.0 / (range[1] - range[0]), intercept: -range[0] / (range[1] - range[0]) };
        let stored: Vec<T> = samples.iter().map(|x| round((range[0] + x * (range[1] - range[0])).round())).collect();
        UniformGrid::new(dims, stored, placement, calibration).unwrap().into()
    }
    match kind {
        0 => of(dims, samples, placement, [0.0, 255.0], |x| x as u8),
        1 => of(dims, samples, placement, [-128.0, 127.0], |x| x as i8),
        2 => of(dims, samples, placement, [0.0, 65535.0], |x| x as u16),
        3 => of(dims, samples, placement, [-32768.0, 32767.0], |x| x as i16),
        _ => {
            let stored: Vec<f32> = samples.iter().map(|&x| x as f32).collect();
            UniformGrid::new(dims, stored, placement, Calibration::default()).unwrap().into()
        }
    }
}

fn volumes() -> impl Strategy<Value = Volume> {
    let dims = prop::array::uniform3(2usize..20);
    let shape =
        (prop::array::uniform3(0.3f64..3.0), prop::array::uniform3(-0.3f64..0.3), prop::array::uniform3(-9.0f64..9.0));
    // Blobs: most of it empty, so that there is something to leap over.
    let blob = (prop::array::uniform3(0.0f64..1.0), 0.05f64..0.6);
    (0usize..6, dims, shape, prop::collection::vec(blob, 1..4), 0.0f64..0.1, any::<u64>()).prop_map(
        |(kind, dims, (spacing, shear, origin), blobs, noise, seed)| {
            let axes = DMat3::from_diagonal(DVec3::from(spacing))
                + DMat3::from_cols(DVec3::ZERO, DVec3::X * shear[0], DVec3::new(shear[1], shear[2], 0.0));
            let mut state = seed;
            let samples: Vec<f64> = (0..dims.iter().product::<usize>())
                .map(|i| {
                    state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                    let at = DVec3::from_array(std::array::from_fn(|a| at[a] as f64 / (dims[a] - 1) as f64));
                    let blob = |(middle, radius): &([f64; 3], f64)| 1.0 - at.distance(DVec3::from(*middle)) / radius;
                    let value = blobs.iter().map(blob).fold(0.0, f64::max);
                    (value + noise * (state >> 40) as f64 / (1u64 << 24) as f64).min(1.0)
                })
                .collect();
            // Holes in some grids of floats.
            let is_hole = |i: usize| kind == 5 && samples[i] > 0.3 && samples[i] < 0.6;
            let samples: Vec<f64> =
                (0..samples.len()).map(|i| if is_hole(i) { f64::NAN } else { samples[i] }).collect();
            grid(kind, dims, &samples, Placement::new(origin.into(), axes).unwrap())
        },
    )
}

/// Strategy of transfer functions whose ramps are at least a tenth of the range wide; clear below the first.
pub(super) fn transfers(max_opacity: f64) -> impl Strategy<Value = TransferFunction> {
    let point = (
        0.1f64..0.3,
        prop::array::uniform3(0.0f64..1.0),
        prop_oneof![0.0f64..max_opacity, Just(0.0), Just(max_opacity)],
    );
    (prop::collection::vec(point, 2..6), 0.2f64..3.0, any::<bool>(), any::<bool>()).prop_map(
        |(points, unit, power, emits)| {
            let mut value = 0.0;
            let emission = |c: [f64; 3], a: f64| emits.then(|| c.map(|c| if a == 0.0 { 0.0 } else { 3.0 * c }));
            let mut all =
                vec![ControlPoint { emission: emission([0.0; 3], 0.0), ..ControlPoint::new(0.12, [0.5; 3], 0.0) }];
            for (gap, color, opacity) in points {
                value += gap;
                let point = ControlPoint::new(value + 0.12, color, opacity);
                all.push(ControlPoint { emission: emission(color, opacity), ..point });
            }
            let rule = if power { OpacityRule::Power } else { OpacityRule::Extinction };
            TransferFunction::new(all, rule, unit).unwrap()
        },
    )
}

/// Strategy of transfer functions by value and gradient, of two rows.
pub(super) fn row_transfers(max_opacity: f64) -> impl Strategy<Value = TransferFunction> {
    let row = || transfers(max_opacity);
    (row(), row(), 0.0f64..1.0, 0.1f64..1.0).prop_filter_map(
        "emission in one row alone",
        |(low, high, gradient, gap)| {
            let rows = vec![(gradient, low.points().to_vec()), (gradient + gap, high.points().to_vec())];
            TransferFunction::of_rows(rows, low.rule(), low.unit_distance()).ok()
        },
    )
}

/// Views of a volume from all sides, from far and from within, clipped or not, with or without a layer; odd sizes.
fn scene_of(
    scene: Scene,
    (azimuth, elevation, fov): (f64, f64, Option<f64>),
    size: [u32; 2],
    cut: u32,
    share: f64,
) -> (Scene, View) {
    let bounds = scene.volume.bounds();
    let mut camera = Camera::framing(bounds, azimuth, elevation, fov);
    if cut & 1 == 1 {
        camera.eye = camera.target + (camera.eye - camera.target) * 0.05;
    }
    let mut view = View::new(camera, size);
    let extent = bounds.1 - bounds.0;
    let crop = (cut & 2 != 0).then(|| (bounds.0 + extent * 0.3 * share, bounds.1 - extent * 0.2));
    let plane = Plane { normal: DVec3::new(1.0, -0.5, 0.3), offset: DVec3::new(1.0, -0.5, 0.3).dot(camera.target) };
    view.clip = Clip { crop, planes: if cut & 4 != 0 { vec![plane] } else { Vec::new() } };
    if cut & 8 != 0 {
        let distance = (camera.target - camera.eye).length() as f32;
        let pixel = |i: u32| {
            ([0.1, 0.2, 0.3], if i.is_multiple_of(3) { f32::INFINITY } else { distance * (0.8 + 0.1 * (i % 5) as f32) })
        };
        return (FixedLayer::new(&view, pixel).among(&scene), view);
    }
    (scene, view)
}

/// Emission and absorption, as a whole or up to a level.
pub(super) fn sums() -> impl Strategy<Value = Compositing> {
    prop_oneof![Just(Compositing::Over), (0.05f64..1.0).prop_map(|level| Compositing::Accumulate { level })]
}

/// Scenes under transfer functions of at most this opacity, and views of them.
pub(super) fn scenes(max_opacity: f64) -> impl Strategy<Value = (Scene, View)> {
    let angles = (-180.0f64..180.0, -80.0f64..80.0, prop::option::of(20.0f64..90.0));
    let angles = prop_oneof![8 => angles, 1 => Just((90.0, 0.0, None)), 1 => Just((0.0, 0.0, Some(40.0)))];
    (volumes(), transfers(max_opacity), angles, 1u32..13, 1u32..10, 0u32..16, 0.0f64..1.0).prop_map(
        |(volume, transfer, angles, w, h, cut, share)| {
            scene_of(Scene::new(volume, transfer), angles, [w, h], cut, share)
        },
    )
}

/// Steps of one length, and local ones.
pub(super) fn steps() -> impl Strategy<Value = Step> {
    prop_oneof![(0.1f64..2.5).prop_map(Step::Uniform), (1e-4f64..1e-2).prop_map(|error| Step::Local { error })]
}

/// Factors on opacity by the gradient's magnitude; none in some scenes.
pub(super) fn factors() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((0.0f64..2.0, prop_oneof![4 => 0.0f64..3.0, 1 => Just(0.0)]), 0..4).prop_map(|mut factors| {
        factors.sort_by(|a, b| a.0.total_cmp(&b.0));
        factors
    })
}

/// Operators that pick a value, of values between 0 and 1.
pub(super) fn picks() -> impl Strategy<Value = Compositing> {
    prop_oneof![
        Just(Compositing::Maximum),
        Just(Compositing::Minimum),
        Just(Compositing::Average),
        (0.05f64..0.95).prop_map(|threshold| Compositing::First { threshold }),
    ]
}
