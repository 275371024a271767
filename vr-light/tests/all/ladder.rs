//! Bounds of what models of light leave out, against the whole equation.

use std::sync::Arc;

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed};
use vr_core::scattering::{Albedo, PhaseFunction, Scattering};
use vr_core::*;
use vr_light::*;

/// A cube of 3³ voxels with random values, a ramp of opacity, lamps and a sky.
fn scenes() -> impl Strategy<Value = Scene> {
    let values = prop::collection::vec(0u8..=255, 27);
    let albedo = prop_oneof![Just(None), (0.0f64..=1.0).prop_map(Some)];
    // Without lamps another bound holds, too.
    let lamp = prop_oneof![Just(0.0), 0.0f64..2.0];
    let (opacity, g, sky) = (0.01f64..0.999, -0.8f64..0.8, prop_oneof![Just(0.0), 0.0f64..1.0]);
    (values, albedo, opacity, g, sky, lamp, any::<bool>()).prop_map(|(values, albedo, opacity, g, sky, lamp, head)| {
        let placement = Placement::from_spacing([0.5; 3]).unwrap();
        let grid = UniformGrid::new([3; 3], values, placement, Calibration::default()).unwrap();
        let clear = ControlPoint::new(20.0, [0.2, 0.4, 0.9], 0.0);
        let dense = ControlPoint::new(255.0, [0.9, 0.7, 0.3], opacity);
        let transfer = TransferFunction::new(vec![clear, dense], OpacityRule::Power, 0.5).unwrap();
        let mut scene = Scene::new(grid.into(), transfer);
        let albedo = albedo.map_or(Albedo::Color, |albedo| Albedo::Constant([albedo; 3]));
        let phase = PhaseFunction::henyey_greenstein(g).unwrap();
        scene.scattering = Some(Arc::new(Scattering { albedo, phase, environment: [sky; 3], ..Scattering::default() }));
        let direction = (!head).then_some(DVec3::new(0.3, 1.0, 0.5));
        scene.lights = vec![Light { direction, color: [lamp; 3] }];
        scene
    })
}

/// A picture of a few pixels.
fn picture(renderer: &dyn Renderer, scene: &Scene) -> Frame {
    let camera = Camera::framing(scene.volume.bounds(), 30.0, 20.0, None);
    let (view, control) = (View::new(camera, [3, 3]), Control::default());
    renderer.prepare(scene, &control).unwrap().render(&view, &control).unwrap().frame
}

/// Largest amount by which two pictures differ beyond four standard errors of the first.
fn beyond_noise(full: &Frame, other: &Frame) -> f64 {
    let Some(Uncertainty::StandardError(errors)) = full.uncertainty() else { panic!("paths have noise") };
    let of_pixel = |i: usize| (0..4).map(move |c| (i, c));
    (0..full.pixels().len())
        .flat_map(of_pixel)
        .map(|(i, c)| f64::from((full.pixels()[i][c] - other.pixels()[i][c]).abs() - 4.0 * errors[i][c]))
        .fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(Config { cases: 500, rng_seed: RngSeed::Fixed(20), failure_persistence: None, ..Config::default() })]

    #[test]
    fn models_cost_no_more_than_their_bounds(scene in scenes()) {
        let ladder = Ladder::of(&scene, &Clip::default(), 0.0).unwrap();
        let full = picture(&LightRenderer { paths: 800, ..LightRenderer::default() }, &scene);
        // Emission and absorption is what the reference makes of the scene without scattering: the same extinction, and the source κ·c of what is
        // not scattered.
        let single = {
            let lamps = Scattering { environment: [0.0; 3], ..scene.scattering.as_deref().cloned().unwrap() };
            let lit = Scene { scattering: Some(Arc::new(lamps)), ..scene.clone() };
            let method = Method::Single;
            picture(&LightRenderer { method, step: 0.25, ..LightRenderer::default() }, &lit)
        };
        let dark = Scene { lights: vec![], ..scene.clone() };
        let dark = picture(&LightRenderer { max_scatterings: Some(0), paths: 200, ..LightRenderer::default() }, &dark);
        // The steps of single scattering and the noise of the other picture are another small part.
        let cost = ladder.cost(LightModel::EmissionAbsorption);
        let noise = dark.uncertainty().unwrap().largest();
        prop_assert!(beyond_noise(&full, &dark) <= cost + 4.0 * noise + 1e-6, "{cost}");
        // Without a sky, light that is scattered once is the model of one scattering.
        let sky = scene.scattering.as_deref().unwrap().environment[0];
        let cost = ladder.cost(LightModel::SingleScattering) + sky;
        prop_assert!(beyond_noise(&full, &single) <= cost + 1e-2, "{cost}");
        prop_assert!(ladder.cost(LightModel::MultipleScattering) == 0.0);
    }
}
