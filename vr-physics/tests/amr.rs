//! Adaptive meshes: a uniform grid as one, linear data, and brute force through the field's values alone.

use glam::DVec3;
use vr_core::amr::{AmrBlock, AmrCentring, AmrGrid, AmrSampling};
use vr_core::field::FunctionField;
use vr_core::{
    Calibration, Camera, Clip, Compositing, Control, ControlPoint, Field, Model, OpacityRule, Placement, Ray, Rays,
    Scene, Shading, TransferFunction, UniformGrid, View, Volume,
};
use vr_physics::Reference;

const CENTRINGS: [AmrCentring; 2] = [AmrCentring::Cells, AmrCentring::Points];

/// Three levels over the unit cube and a little more: the middle is refined, and of that one corner again.
fn mesh(centring: AmrCentring, value: impl Fn(DVec3) -> f64) -> AmrGrid {
    let sampling = AmrSampling {
        origin: DVec3::splat(-0.1),
        edge: 0.3,
        blocks: [4; 3],
        block_cells: [2; 3],
        ratios: vec![[2; 3]; 2],
        centring,
    };
    let near = |low: DVec3, high: DVec3, level: usize| {
        let middle = 0.5 * (low + high);
        [(middle - 0.5).abs().max_element() < 0.3, middle.max_element() < 0.5][level]
    };
    AmrGrid::refining(&sampling, |p| value(p) as f32, near).unwrap()
}

fn transfer() -> TransferFunction {
    let p = ControlPoint::new;
    let points = vec![
        p(0.1, [0.1, 0.2, 0.9], 0.0),
        p(0.45, [0.9, 0.3, 0.1], 0.25),
        p(0.6, [0.2, 0.8, 0.3], 0.05),
        p(1.0, [1.0, 1.0, 0.9], 0.6),
    ];
    TransferFunction::new(points, OpacityRule::Power, 0.2).unwrap()
}

fn view(size: u32) -> View {
    View::new(Camera::framing((DVec3::ZERO, DVec3::ONE), 35.0, 25.0, Some(40.0)), [size; 2])
}

const OPERATORS: [Compositing; 6] = [
    Compositing::Over,
    Compositing::Maximum,
    Compositing::Minimum,
    Compositing::Average,
    Compositing::First { threshold: 0.55 },
    Compositing::Accumulate { level: 0.5 },
];

fn solve(scene: &Scene, compositing: Compositing, size: u32) -> Vec<vr_physics::Pixel> {
    let scene = Scene { compositing, ..scene.clone() };
    Reference::default().solve(&scene, &view(size), &Model::Canonical, &Control::default()).unwrap().pixels
}

fn waves(p: DVec3) -> f64 {
    0.5 + 0.3 * (7.0 * p.x + 3.0 * p.y).sin() + 0.2 * (9.0 * p.z - 4.0 * p.y).cos()
}

/// A mesh of one level has the pixels of the uniform grid, shaded or not, under every operator.
#[test]
fn one_level_has_the_pixels_of_a_uniform_grid() {
    let (n, step) = (6, 1.0 / 6.0);
    for centring in CENTRINGS {
        let first = if centring == AmrCentring::Cells { 0.5 * step } else { 0.0 };
        let at = |i: usize| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / (n * n)) as f64) * step + first;
        let values: Vec<f32> = (0..n * n * n).map(|i| waves(at(i)) as f32).collect();
        let placement = Placement::new(DVec3::splat(first), glam::DMat3::from_diagonal(DVec3::splat(step))).unwrap();
        let uniform = UniformGrid::new([n; 3], values.clone(), placement, Calibration::default()).unwrap();
        let uniform = Volume::from(uniform);
        let block = AmrBlock { level: 0, first: [0; 3], dims: [n; 3], values };
        let grid = AmrGrid::new(DVec3::ZERO, DVec3::splat(step), vec![], vec![block], centring).unwrap();
        for shading in [None, Some(Shading::default().into())] {
            let [a, b] = [uniform.clone(), grid.clone().into()]
                .map(|volume| Scene { shading: shading.clone(), ..Scene::new(volume, transfer()) });
            for compositing in OPERATORS {
                for (a, b) in solve(&a, compositing, 8).iter().zip(&solve(&b, compositing, 8)) {
                    let bound = a.certainty.value() + b.certainty.value();
                    for c in 0..4 {
                        let off = (a.rgba[c] - b.rgba[c]).abs();
                        assert!(off <= bound + 1e-12 && bound < 1e-6, "{centring:?} {compositing:?}: {off}, {bound}");
                    }
                }
            }
        }
    }
}

/// A mesh of a linear function is that function, under every operator, to the rounding of f32.
#[test]
fn a_linear_field_is_its_function() {
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = move |p: DVec3| 0.2 + slope.dot(p);
    for centring in CENTRINGS {
        let grid = mesh(centring, value);
        let function = FunctionField::new(grid.bounds(), value).unwrap().with_lipschitz(slope.length());
        let [a, b] = [grid.into(), function.into()].map(|volume: Volume| Scene::new(volume, transfer()));
        for compositing in OPERATORS {
            // The rim of the mesh is coarse everywhere, so that both boxes are full.
            for (a, b) in solve(&a, compositing, 8).iter().zip(&solve(&b, compositing, 8)) {
                for c in 0..4 {
                    let off = (a.rgba[c] - b.rgba[c]).abs();
                    let bound = a.certainty.value() + b.certainty.value();
                    assert!(off <= bound + 1e-6, "{centring:?} {compositing:?}: {off} beyond {bound}");
                    assert!(a.certainty.value() < 1e-7, "{compositing:?}: {:?}", a.certainty);
                }
            }
        }
    }
}

/// Waves on three levels, against many samples of the values.
#[test]
fn every_operator_agrees_with_brute_force() {
    let view = view(6);
    let rays = Rays::new(&view).unwrap();
    for centring in CENTRINGS {
        let grid = mesh(centring, waves);
        for (compositing, shading) in OPERATORS.map(|o| (o, false)).into_iter().chain([(Compositing::Over, true)]) {
            let scene = Scene {
                compositing,
                shading: shading.then(Shading::default).map(Into::into),
                ..Scene::new(grid.clone().into(), transfer())
            };
            for (i, pixel) in solve(&scene, compositing, 6).iter().enumerate() {
                let ray = rays.at((i % 6) as f64 + 0.5, (i / 6) as f64 + 0.5);
                let expected = brute(&scene, &grid, &ray);
                for c in 0..4 {
                    let off = (pixel.rgba[c] - expected[c]).abs();
                    // Midpoint samples are 1/4000 of the chord apart; those that pick a place are off by as much of the slope.
                    assert!(off <= pixel.certainty.value() + 2e-3, "{compositing:?}, {shading}: {off} at {i}");
                    assert!(pixel.certainty.value() < 1e-3, "{compositing:?}, {shading}: {:?}", pixel.certainty);
                }
            }
        }
    }
}

/// Cells without a value, and rays along the faces of cells, which graze vacuum.
#[test]
fn holes_are_vacuum() {
    let block = |hole: bool| {
        let mut values = vec![1.0; 216];
        values[3 * 36 + 3 * 6 + 3] = if hole { f32::NAN } else { 1.0 };
        AmrBlock { level: 0, first: [0; 3], dims: [6; 3], values }
    };
    let scene = |hole: bool| {
        let grid = AmrGrid::new(DVec3::ZERO, DVec3::ONE, vec![], vec![block(hole)], AmrCentring::Cells).unwrap();
        let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
        Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap())
    };
    let depth = |scene: &Scene, y: f64| {
        let ray = Ray { origin: DVec3::new(-9.0, y, 3.3), direction: DVec3::X };
        let solved = Reference::default().transport(scene, &view(1), &ray).unwrap().expect("it meets the box");
        -solved.transmittance().ln()
    };
    // From the first middle to the last are 5 steps; the hole takes one on both sides of its middle.
    for (y, hole, expected) in
        [(3.3, false, 2.5), (3.3, true, 1.5), (2.7, true, 1.5), (2.2, true, 2.5), (5.2, true, 2.5)]
    {
        let found = depth(&scene(hole), y);
        assert!((found - expected).abs() < 1e-9, "{y} {hole}: {found}");
    }
}

/// The same scene by many samples along a ray.
fn brute(scene: &Scene, grid: &AmrGrid, ray: &Ray) -> [f64; 4] {
    const SAMPLES: usize = 4000;
    let inside = Clip { crop: Some(grid.bounds()), ..Clip::default() };
    let Some([from, to]) = ray.inside(&inside).filter(|[a, b]| a < b) else { return [0.0; 4] };
    let h = (to - from) / SAMPLES as f64;
    let places = (0..SAMPLES).map(|k| ray.origin + ray.direction * (from + (k as f64 + 0.5) * h));
    let along = scene.shading.as_ref().map(|s| s.along::<f64>(&scene.lights, ray.direction));
    let samples: Vec<(DVec3, f64)> = places.filter_map(|at| Some((at, grid.value(at)?))).collect();
    let picked = |v: f64| {
        let o = scene.transfer.at(v);
        [o.color[0] * o.opacity, o.color[1] * o.opacity, o.color[2] * o.opacity, o.opacity]
    };
    let values = samples.iter().map(|s| s.1);
    match scene.compositing {
        Compositing::Maximum => return picked(values.fold(f64::NEG_INFINITY, f64::max)),
        Compositing::Minimum => return picked(values.fold(f64::INFINITY, f64::min)),
        Compositing::Average => return picked(values.sum::<f64>() / samples.len() as f64),
        Compositing::First { threshold } => {
            let hit = samples.iter().find(|s| s.1 >= threshold);
            return hit.map_or([0.0; 4], |s| {
                let [r, g, b] = scene.transfer.at(s.1).color;
                [r, g, b, 1.0]
            });
        }
        _ => {}
    }
    let level = if let Compositing::Accumulate { level } = scene.compositing { level } else { 1.0 };
    let (mut rgb, mut alpha) = ([0.0; 3], 0.0);
    for (at, value) in samples {
        let mut color = scene.transfer.at(value).color;
        if let Some(along) = &along {
            let (factor, added) = along.reflect(grid.gradient(at).unwrap().to_array());
            color = std::array::from_fn(|c| color[c] * factor[c] + added[c]);
        }
        let step: f64 = 1.0 - (-scene.transfer.extinction_at(value) * h).exp();
        let step = step.min((level - alpha) / (1.0 - alpha));
        for c in 0..3 {
            rgb[c] += (1.0 - alpha) * step * color[c];
        }
        alpha += (1.0 - alpha) * step;
    }
    [rgb[0], rgb[1], rgb[2], alpha]
}
