//! Meshes of cells: closed forms, a function of the same values, and brute force through the field's values alone.

use glam::DVec3;
use vr_core::cells::{CellMesh, CellValues};
use vr_core::field::FunctionField;
use vr_core::{
    Camera, Clip, Compositing, Control, ControlPoint, Field, Model, OpacityRule, Ray, Rays, Scene, Shading,
    TransferFunction, View, Volume,
};
use vr_physics::Reference;
use vr_physics::check::strategies::uneven_cubes;

/// n³ cubes of six cells each, over the unit cube; inner vertices are moved by up to `jitter` of a step.
fn mesh(n: usize, jitter: f64, value: impl Fn(DVec3) -> f64) -> CellMesh {
    let (moved, cells) = uneven_cubes([n; 3], jitter, 1);
    let values = moved.iter().map(|&v| value(v)).collect();
    CellMesh::new(moved, cells, CellValues::Vertices(values)).unwrap()
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

/// The slab on which a ray caster of another program gives 0.35 to 0.88, for rays run along the faces that cells share: 1 − e^(−½) everywhere.
#[test]
fn a_constant_slab_is_met_along_shared_faces() {
    let mesh = mesh(8, 0.0, |_| 1.0);
    let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
    let scene = Scene::new(mesh.into(), TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap());
    let any = view(1);
    let exact = 1.0 - (-0.5f64).exp();
    for direction in [DVec3::X, DVec3::Y, DVec3::Z] {
        let [across, up] =
            if direction == DVec3::Z { [DVec3::X, DVec3::Y] } else { [DVec3::Z, direction.cross(DVec3::Z).abs()] };
        for i in 1..16 {
            for j in 1..16 {
                let at = across * (f64::from(i) / 16.0) + up * (f64::from(j) / 16.0);
                let ray = Ray { origin: at - direction * 5.0, direction };
                let solved = Reference::default().transport(&scene, &any, &ray).unwrap().expect("it meets the slab");
                let off = (1.0 - solved.transmittance() - exact).abs();
                assert!(off < 1e-12 && solved.certainty.value() < 1e-12, "{ray:?}: {off}, {:?}", solved.certainty);
            }
        }
    }
}

/// A mesh of a linear function is that function, under every operator.
#[test]
fn a_linear_field_is_its_function() {
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = move |p: DVec3| 0.2 + slope.dot(p);
    let function = FunctionField::new((DVec3::ZERO, DVec3::ONE), value).unwrap().with_lipschitz(slope.length());
    let scene = |volume: Volume| Scene::new(volume, transfer());
    let (a, b) = (scene(mesh(4, 0.2, value).into()), scene(function.into()));
    for compositing in OPERATORS {
        let solve = |scene: &Scene| {
            let scene = Scene { compositing, ..scene.clone() };
            Reference::default().solve(&scene, &view(8), &Model::Canonical, &Control::default()).unwrap().pixels
        };
        for (a, b) in solve(&a).iter().zip(&solve(&b)) {
            for c in 0..4 {
                let off = (a.rgba[c] - b.rgba[c]).abs();
                let bound = a.certainty.value() + b.certainty.value();
                assert!(off <= bound + 1e-9, "{compositing:?}: {off} beyond {bound}");
                assert!(a.certainty.value() < 1e-8, "{compositing:?}: {:?}", a.certainty);
            }
        }
    }
}

/// Waves on a mesh of uneven cells, against many samples of its values.
#[test]
fn every_operator_agrees_with_brute_force() {
    let waves = |p: DVec3| 0.5 + 0.3 * (7.0 * p.x + 3.0 * p.y).sin() + 0.2 * (9.0 * p.z - 4.0 * p.y).cos();
    let mesh = mesh(4, 0.25, waves);
    let view = view(6);
    let rays = Rays::new(&view).unwrap();
    for (compositing, shading) in OPERATORS.map(|o| (o, false)).into_iter().chain([(Compositing::Over, true)]) {
        let scene = Scene {
            compositing,
            shading: shading.then(Shading::default).map(Into::into),
            ..Scene::new(mesh.clone().into(), transfer())
        };
        let solved = Reference::default().solve(&scene, &view, &Model::Canonical, &Control::default()).unwrap();
        for (i, pixel) in solved.pixels.iter().enumerate() {
            let ray = rays.at((i % 6) as f64 + 0.5, (i / 6) as f64 + 0.5);
            let expected = brute(&scene, &mesh, &ray);
            for c in 0..4 {
                let off = (pixel.rgba[c] - expected[c]).abs();
                // Midpoint samples are a 1/20000 apart; what they pick is off by as much of the slope.
                assert!(off <= pixel.certainty.value() + 2e-3, "{compositing:?}, {shading}: {off} at {i}");
                assert!(pixel.certainty.value() < 1e-3, "{compositing:?}, {shading}: {:?}", pixel.certainty);
            }
        }
    }
}

/// The same scene by many samples along a ray.
fn brute(scene: &Scene, mesh: &CellMesh, ray: &Ray) -> [f64; 4] {
    const SAMPLES: usize = 4000;
    let inside = Clip { crop: Some(mesh.bounds()), ..Clip::default() };
    let Some([from, to]) = ray.inside(&inside).filter(|[a, b]| a < b) else { return [0.0; 4] };
    let h = (to - from) / SAMPLES as f64;
    let places = (0..SAMPLES).map(|k| ray.origin + ray.direction * (from + (k as f64 + 0.5) * h));
    let along = scene.shading.as_ref().map(|s| s.along::<f64>(&scene.lights, ray.direction));
    let samples: Vec<(DVec3, f64)> = places.filter_map(|at| Some((at, mesh.value(at)?))).collect();
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
            let (factor, added) = along.reflect(mesh.gradient(at).unwrap().to_array());
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
