//! No bit of a picture depends on the vector instructions that draw it. Unit tests of the crate compile kernels for the baseline alone.

use proptest::prelude::*;
use vr_core::{ColorGrid, Control, GridVolume, RenderError, Renderer, Scene, Volume};
use vr_physics::check::TestScene;
use vr_physics::check::strategies::{Kind, point_scene};
use vr_raycast::{ImageSampling, RayCaster, Rule, Step, Vector};

use crate::common::{oblique, phantom_scenes, render};

/// One of each loop over steps, of each rule, and of what is proven.
fn casters() -> Vec<RayCaster> {
    let steps = |step| RayCaster { step, ..RayCaster::default() };
    let ruled = |rule| RayCaster { rule, ..RayCaster::uniform(0.7) };
    vec![
        ruled(Rule::Midpoint),
        ruled(Rule::Left),
        ruled(Rule::Linear),
        ruled(Rule::Quadratic),
        steps(Step::Local { error: 1e-3 }),
        steps(Step::Homogeneous { step: 0.5, error: 1e-2 }),
        steps(Step::Variance { step: 0.5, error: 1e-2 }),
        steps(Step::ErrorBound(4e-3)),
    ]
}

/// Draws a scene by each caster that can draw it, with all levels of instructions; returns the number of those that can.
fn drawn_alike(test: &TestScene) -> Result<usize, TestCaseError> {
    let control = Control::default();
    let mut drawn = 0;
    for caster in casters() {
        let draw = |vector| match (RayCaster { vector, ..caster.clone() }).prepare(&test.scene, &control) {
            Ok(mut prepared) => Some(prepared.render(&test.view, &control).unwrap().frame),
            Err(RenderError::Unsupported(_) | RenderError::Option(_)) => None,
            Err(error) => panic!("{caster:?}: {error}"),
        };
        let Some(best) = draw(Vector::Auto) else { continue };
        for vector in [Vector::Avx2, Vector::Baseline] {
            prop_assert!(draw(vector).as_ref() == Some(&best), "{:?} by {:?} of {:?}", vector, caster, test);
        }
        drawn += 1;
    }
    Ok(drawn)
}

/// The same scene with a colour at each voxel.
fn colored(test: TestScene) -> Option<TestScene> {
    let grid: &GridVolume = test.scene.volume.grid()?;
    let count: usize = grid.dims().iter().product();
    let channel = |prime: usize| (0..count).map(|i| (i * prime % 65_536) as u16).collect();
    let colors = ColorGrid::new(grid.clone(), [7919, 104_729, 15_485].map(channel)).ok()?;
    Some(TestScene { scene: Scene { volume: Volume::Color(colors.into()), ..test.scene }, view: test.view })
}

#[test]
fn no_bit_of_a_large_picture_depends_on_instructions_or_threads() {
    // In these, a few rays choose the length of steps.
    let size = 1 << (ImageSampling::LARGE.ilog2() / 2);
    for (name, scene) in phantom_scenes(24) {
        let view = oblique(&scene, size);
        let [best, avx2, baseline] = [Vector::Auto, Vector::Avx2, Vector::Baseline]
            .map(|vector| render(&RayCaster { vector, ..RayCaster::default() }, &scene, &view).frame);
        assert!(best == avx2 && best == baseline, "{name}");
        let control = Control::default().with_threads(3);
        let mut prepared = RayCaster::default().prepare(&scene, &control).unwrap();
        assert!(best == prepared.render(&view, &control).unwrap().frame, "{name}");
    }
}

#[test]
fn no_bit_depends_on_instructions() {
    for kind in Kind::ALL.into_iter().chain(Kind::OF_OTHER_VOLUMES) {
        let drawn: usize = (0..3).map(|seed| drawn_alike(&kind.draw(seed)).unwrap()).sum();
        println!("{}: {drawn} pictures", kind.name());
        assert!(drawn >= 3, "{}: {drawn}", kind.name());
    }
}

#[test]
fn no_bit_of_coloured_voxels_depends_on_instructions() {
    let kinds = [Kind::Plain, Kind::GradientOpacity, Kind::Lights, Kind::Extrema, Kind::Average, Kind::Filters];
    let scenes = kinds.into_iter().flat_map(|kind| (0..2).map(move |seed| kind.draw(seed)));
    let drawn: usize = scenes.filter_map(colored).map(|test| drawn_alike(&test).unwrap()).sum();
    assert!(drawn >= 24, "{drawn}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bit_of_points_depends_on_instructions(test in point_scene()) {
        prop_assert!(drawn_alike(&test)? > 0);
    }
}
