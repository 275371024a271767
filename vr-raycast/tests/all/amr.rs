//! Adaptive meshes: a uniform grid as one, the reference, and what is left out.

use glam::DVec3;
use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid, AmrSampling};
use vr_core::{
    Calibration, Camera, Compositing, Control, ControlPoint, Frame, Model, OpacityRule, Placement, Renderer, Scene,
    TransferFunction, UniformGrid, View, Volume,
};
use vr_physics::Reference;
use vr_raycast::{EmptySpace, RayCaster, Vector};

const CENTRINGS: [AmrCentring; 2] = [AmrCentring::Cells, AmrCentring::Points];

fn ball(p: DVec3) -> f64 {
    1.0 - 2.0 * (p - DVec3::new(0.45, 0.5, 0.55)).length() + 0.1 * (9.0 * p.x).sin()
}

/// Up to three levels over the unit cube.
fn refined(
    centring: AmrCentring,
    value: impl Fn(DVec3) -> f64,
    refine: impl Fn(DVec3, DVec3, usize) -> bool,
) -> AmrGrid {
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 0.25,
        blocks: [4; 3],
        block_cells: [4; 3],
        ratios: vec![[2; 3]; 2],
        centring,
    };
    AmrGrid::refining(&sampling, |p| value(p) as f32, refine).unwrap()
}

/// Fine where the ball's surface is.
fn mesh(centring: AmrCentring) -> AmrGrid {
    let near = |low: DVec3, high: DVec3, _: usize| (ball(0.5 * (low + high)) - 0.55).abs() < (high - low).length();
    refined(centring, ball, near)
}

/// Clear below 0.4 and above 0.8.
fn shell() -> TransferFunction {
    let p = ControlPoint::new;
    let points = vec![
        p(0.4, [0.1, 0.2, 0.9], 0.0),
        p(0.5, [0.9, 0.3, 0.1], 0.4),
        p(0.7, [0.9, 0.9, 0.1], 0.1),
        p(0.8, [0.2, 0.8, 0.3], 0.0),
    ];
    TransferFunction::new(points, OpacityRule::Power, 0.1).unwrap()
}

fn view(size: u32) -> View {
    View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), 35.0, 25.0, Some(40.0)), [size; 2])
}

fn drawn(caster: &RayCaster, scene: &Scene, size: u32) -> (Frame, vr_core::Counts) {
    let mut prepared = caster.prepare(scene, &Control::default()).unwrap();
    let rendered = prepared.render(&view(size), &Control::default()).unwrap();
    (rendered.frame, rendered.stats.counts)
}

/// Pixels of the reference.
fn solved(scene: &Scene, size: u32) -> Frame {
    let solved = Reference::default().solve(scene, &view(size), &Model::Canonical, &Control::default()).unwrap();
    Frame::new([size; 2], solved.pixels.iter().map(|p| p.rgba.map(|x| x as f32)).collect(), None)
}

fn largest_difference(a: &Frame, b: &Frame) -> f32 {
    let both = a.pixels().as_flattened().iter().zip(b.pixels().as_flattened());
    both.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn one_level_has_the_picture_of_a_uniform_grid() {
    let (n, step) = (24, 1.0 / 24.0);
    for centring in CENTRINGS {
        let first = if centring == AmrCentring::Cells { 0.5 * step } else { 0.0 };
        let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / (n * n)) as f64) * step + first;
        let values: Vec<f32> = (0..n * n * n).map(|i| ball(at(i)) as f32).collect();
        let placement = Placement::new(DVec3::splat(first), glam::DMat3::from_diagonal(DVec3::splat(step))).unwrap();
        let uniform = UniformGrid::new([n; 3], values.clone(), placement, Calibration::default()).unwrap();
        let block = AmrBlock { level: 0, first: [0; 3], dims: [n; 3], values };
        let grid = AmrGrid::new(DVec3::ZERO, DVec3::splat(step), vec![], vec![block], centring).unwrap();
        let [a, b] = [Volume::from(uniform), grid.into()].map(|volume| Scene::new(volume, shell()));
        for compositing in [
            Compositing::Over,
            Compositing::Maximum,
            Compositing::Average,
            Compositing::First { threshold: 0.55 },
            Compositing::Accumulate { level: 0.5 },
        ] {
            let [a, b] =
                [&a, &b].map(|scene| drawn(&RayCaster::exact(0.5), &Scene { compositing, ..scene.clone() }, 40).0);
            let off = largest_difference(&a, &b);
            assert!(off < 1e-6, "{centring:?} {compositing:?}: {off}");
        }
    }
}

#[test]
fn no_bit_depends_on_what_is_left_out() {
    for centring in CENTRINGS {
        for compositing in [Compositing::Over, Compositing::First { threshold: 0.5 }] {
            let scene = Scene { compositing, ..Scene::new(mesh(centring).into(), shell()) };
            let (a, left_out) = drawn(&RayCaster::uniform(0.5), &scene, 32);
            let all = RayCaster { empty_space: EmptySpace::None, ..RayCaster::uniform(0.5) };
            let (b, counts) = drawn(&all, &scene, 32);
            assert_eq!(largest_difference(&a, &b), 0.0, "{centring:?} {compositing:?}");
            assert_eq!(counts.skipped, 0);
            assert!(left_out.samples < counts.samples, "{left_out:?} {counts:?}");
            let plain = RayCaster { vector: Vector::Off, ..RayCaster::uniform(0.5) };
            let (_, left_out) = drawn(&plain, &scene, 32);
            assert!(left_out.skipped > 0, "{left_out:?}");
        }
    }
}

/// Steps are counted in cells of each level: the error falls with their square.
#[test]
fn converges_to_the_reference() {
    for centring in CENTRINGS {
        let scene = Scene::new(mesh(centring).into(), shell());
        let reference = solved(&scene, 24);
        let error = |step: f64| largest_difference(&drawn(&RayCaster::exact(step), &scene, 24).0, &reference);
        let errors = [0.5, 0.25, 0.125].map(error);
        assert!(errors[0] < 0.02 && errors[2] < 0.002, "{centring:?}: {errors:?}");
        assert!(errors[2] < 0.3 * errors[0], "{centring:?}: {errors:?}");
    }
}

/// A mesh of a linear function is drawn as that function.
#[test]
fn a_linear_field_has_no_cracks() {
    let value = |p: DVec3| 0.1 + 0.3 * p.x + 0.2 * p.y + 0.4 * p.z;
    let points = vec![ControlPoint::new(0.0, [1.0, 0.0, 0.0], 0.0), ControlPoint::new(1.0, [0.0, 1.0, 0.0], 1.0)];
    let ramp = TransferFunction::new(points, OpacityRule::Extinction, 0.5).unwrap();
    for centring in CENTRINGS {
        // Fine in the middle, and finer in one half of that: the rim is coarse everywhere, so that the box is full.
        let inner = |low: DVec3, high: DVec3, level: usize| {
            let middle = 0.5 * (low + high);
            (middle - 0.5).abs().max_element() < 0.25 && (level == 0 || middle.x < 0.5)
        };
        let grid = refined(centring, value, inner);
        assert_eq!(grid.levels(), 3);
        let (low, high) = grid.bounds();
        let corner = |i: usize| DVec3::select(glam::BVec3::new(i & 1 == 1, i & 2 == 2, i & 4 == 4), high, low);
        let corners: Vec<f32> = (0..8).map(|i| value(corner(i)) as f32).collect();
        let placement = Placement::new(low, glam::DMat3::from_diagonal(high - low)).unwrap();
        let linear = UniformGrid::new([2; 3], corners, placement, Calibration::default());
        let [a, b] = [grid.into(), Volume::from(linear.unwrap())].map(|volume| Scene::new(volume, ramp.clone()));
        let expected = solved(&b, 24);
        let off = largest_difference(&solved(&a, 24), &expected);
        assert!(off < 1e-6, "{centring:?}: {off}");
        // Middles of steps of another length miss differently, by less than this at 1/40 of the finest cell.
        let off = largest_difference(&drawn(&RayCaster::exact(0.025), &a, 24).0, &expected);
        assert!(off < 1e-5, "{centring:?}: {off}");
    }
}

/// Steps follow what is known of the values: the error that the default aims at, also where what is seen is thinner than a cell.
#[test]
fn default_steps_find_thin_sheets() {
    let point = |value, opacity| ControlPoint::new(value, [1.0, 0.5, 0.1], opacity);
    let points = vec![point(0.0, 0.0), point(0.54, 0.0), point(0.55, 0.9), point(0.56, 0.0), point(1.0, 0.0)];
    let sheet = TransferFunction::new(points, OpacityRule::Power, 0.05).unwrap();
    for centring in CENTRINGS {
        let scene = Scene::new(mesh(centring).into(), sheet.clone());
        let reference = solved(&scene, 32);
        let rmse = |caster: &RayCaster| {
            let (frame, _) = drawn(caster, &scene, 32);
            let both = frame.pixels().as_flattened().iter().zip(reference.pixels().as_flattened());
            let square: f64 = both.map(|(a, b)| f64::from(a - b).powi(2)).sum();
            (square / (4.0 * 32.0 * 32.0)).sqrt()
        };
        let local = rmse(&RayCaster::default());
        // Aimed at 5·10⁻⁴: an estimate of the size of changes, not of their shape.
        assert!(local < 1e-3, "{centring:?}: {local}");
    }
}
