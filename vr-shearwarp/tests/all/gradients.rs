//! Opacity by the gradient, the transfer function of value and gradient, and the filter's own gradients.

use std::sync::Arc;

use vr_core::*;
use vr_physics::Metrics;
use vr_physics::check::pictures::*;
use vr_shearwarp::{EmptySpace, ShearWarp};

use crate::both_errors::both_errors;

const PROJECTIONS: [Option<f64>; 2] = [None, Some(40.0)];

/// A renderer with texels of so many voxels, and slices half as far apart; those of classified voxels a voxel apart.
fn renderer(texel: f64, classification: Classification) -> ShearWarp {
    let slice_distance = if classification == Classification::Pre { 1.0 / texel } else { 0.5 };
    ShearWarp { texel, slice_distance, classification, termination: 1.0, ..ShearWarp::default() }
}

fn shaded(scene: &Scene, shading: Shading) -> Scene {
    let side = Light { direction: Some(glam::DVec3::new(0.4, 1.0, 0.3)), color: [0.1, 0.3, 0.6] };
    Scene { shading: Some(Arc::new(shading)), lights: vec![Light::default(), side], ..scene.clone() }
}

/// A fog whose opacity follows the gradient, in every way that a scene can say so.
fn scenes() -> Vec<(&'static str, Scene)> {
    let plain = phantom_scene::<f32>("fog", 24, 1.0);
    // Gradients of the fog, in value per world unit, are some units long.
    let factors = vec![(0.5, 0.1), (1.5, 0.8), (4.0, 1.5)];
    let flat = Shading { gradient_opacity: factors.clone(), ..Shading::flat() };
    let lit = Shading { gradient_opacity: factors, ..Shading::default() };
    let row = |gradient: f64, opacity: f64| {
        let color = |value: f64| [value, 0.5 * opacity, 1.0 - value];
        let point = |value: f64| ControlPoint::new(value, color(value), opacity * value);
        (gradient, vec![point(0.0), point(0.5), point(1.0)])
    };
    let before = &plain.transfer;
    let rows = vec![row(0.3, 0.05), row(1.0, 0.9), row(3.0, 0.3)];
    let rows = TransferFunction::of_rows(rows, before.rule(), before.unit_distance()).unwrap();
    let by_rows = Scene { transfer: rows.into(), ..plain.clone() };
    let glow = |p: &ControlPoint| ControlPoint { emission: Some([p.opacity, 0.2, 0.1]), ..*p };
    let glowing: Vec<ControlPoint> = before.points().iter().map(glow).collect();
    let glowing = TransferFunction::new(glowing, before.rule(), before.unit_distance()).unwrap();
    vec![
        ("factors", shaded(&plain, flat.clone())),
        ("factors, shaded", shaded(&plain, lit.clone())),
        ("factors, emission", shaded(&Scene { transfer: glowing.into(), ..plain.clone() }, lit)),
        ("rows", by_rows.clone()),
        ("rows, shaded", shaded(&by_rows, Shading::default())),
        ("factors, level", Scene { compositing: Compositing::Accumulate { level: 0.6 }, ..shaded(&plain, flat) }),
    ]
}

/// Root of the mean square error against the renderer's own model and against the canonical pixels, and of another scene against the latter.
fn errors(renderer: &ShearWarp, scene: &Scene, other: &Scene, view: &View, canonical: &[[f64; 4]]) -> [f64; 3] {
    let [of_canonical, of_model] = both_errors(renderer, scene, view, canonical);
    [of_model, of_canonical, Metrics::of(canonical, draw(renderer, other, view).frame.pixels()).rmse]
}

#[test]
fn opacity_follows_the_gradient() {
    for (name, scene) in scenes() {
        for fov in PROJECTIONS {
            let view = view(&scene, 33.0, 21.0, fov, 10);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-5);
            // The same without gradients.
            let transfer =
                scene.transfer.rows().get(1).map_or(scene.transfer.clone(), |row| row.transfer.clone().into());
            let without = Scene { shading: None, transfer, ..scene.clone() };
            for classification in [Classification::Post, Classification::Pre] {
                // A model of its own is known of sums alone.
                if classification == Classification::Pre && scene.compositing != Compositing::Over {
                    continue;
                }
                let of = |texel| errors(&renderer(texel, classification), &scene, &without, &view, &truth);
                let [coarse, fine] = [0.5, 0.125].map(of);
                println!("{classification:?} {name} {fov:?}: {coarse:.4?} {fine:.4?}");
                // Light is interpolated between texels and nearest entries of tables are taken; the model knows of neither. Rows bend at
                // their magnitudes: order 1. Voxels that are classified are another medium, however fine the texels.
                let [of_model, canonical, without] = fine;
                assert!(
                    of_model < 6e-3 && of_model < coarse[0] / 2.0,
                    "{classification:?} {name}: {coarse:?} {fine:?}"
                );
                let far = classification == Classification::Pre;
                assert!(far || (canonical < 6e-3 && without > 3.0 * canonical), "{name}: {fine:?}");
            }
        }
    }
}

#[test]
fn blocks_and_runs_see_the_same_gradients() {
    for (name, scene) in scenes() {
        for axis in [(0.0, 0.0), (90.0, 0.0), (0.0, 89.0)] {
            let view = view(&scene, axis.0, axis.1, None, 16);
            let blocks = ShearWarp { empty_space: EmptySpace::Octree, ..ShearWarp::default() };
            let (a, b) = (draw(&ShearWarp::default(), &scene, &view).frame, draw(&blocks, &scene, &view).frame);
            let pairs = a.pixels().iter().flatten().zip(b.pixels().iter().flatten());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-5), "{name} {axis:?}");
        }
    }
}

#[test]
fn the_filters_own_gradient_shades() {
    let plain = phantom_scene::<f32>("fog", 24, 1.0);
    let analytic = Shading { gradient: GradientMethod::Analytic, ..Shading::default() };
    let steep = Shading { gradient_opacity: vec![(0.5, 0.1), (1.5, 0.8), (4.0, 1.5)], ..analytic.clone() };
    for (name, shading) in [("shaded", analytic), ("steep", steep)] {
        let scene = shaded(&plain, shading);
        for fov in PROJECTIONS {
            let view = view(&scene, 33.0, 21.0, fov, 12);
            let truth = solve(&scene, &view, &Model::Canonical, 1e-5);
            let of = |texel| errors(&renderer(texel, Classification::Post), &scene, &plain, &view, &truth);
            let [coarse, fine] = [1.0, 0.125].map(of);
            println!("{name} {fov:?}: {coarse:.4?} {fine:.4?}");
            // Gradients jump from cell to cell: first order, a factor of eight over three halvings.
            assert!(fine[0] < 5e-3 && fine[1] < 5e-3 && fine[1] < coarse[1] / 4.0, "{name}: {coarse:?} {fine:?}");
        }
    }
}

#[test]
fn where_the_filters_gradient_jumps_there_is_none() {
    let plain = phantom_scene::<u8>("fog", 8, 1.0);
    let scene = shaded(&plain, Shading { gradient: GradientMethod::Analytic, ..Shading::default() });
    let refused = |renderer: ShearWarp| match renderer.supports(&scene, None) {
        Err(RenderError::Unsupported(Unsupported { feature, .. })) => feature == Feature::AnalyticGradients,
        _ => false,
    };
    assert!(refused(ShearWarp::classic()));
    assert!(refused(ShearWarp { slice_distance: 1.0, ..ShearWarp::default() }));
    assert!(!refused(ShearWarp::default()));
}

#[test]
fn an_update_finds_other_gradients() {
    let control = Control::default();
    let plain = phantom_scene::<u8>("fog", 12, 1.0);
    let with = |gradient_opacity: Vec<(f64, f64)>, gradient| {
        shaded(&plain, Shading { gradient_opacity, gradient, ..Shading::default() })
    };
    let (voxels, filter) = (GradientMethod::CentralDifferences, GradientMethod::Analytic);
    let steps = [
        plain.clone(),
        with(vec![(0.5, 0.1), (2.0, 1.0)], voxels),
        with(vec![(0.5, 1.0), (2.0, 0.1)], voxels),
        with(vec![(0.5, 1.0), (2.0, 0.1)], filter),
        with(Vec::new(), filter),
        with(Vec::new(), voxels),
        plain.clone(),
    ];
    for empty_space in [EmptySpace::Runs, EmptySpace::Octree] {
        let renderer = ShearWarp { empty_space, ..ShearWarp::default() };
        let view = view(&plain, 33.0, 21.0, None, 12);
        let mut prepared = renderer.prepare(&steps[0], &control).unwrap();
        for step in &steps {
            prepared.update(step, &control).unwrap();
            let frame = prepared.render(&view, &control).unwrap().frame;
            assert_eq!(frame, draw(&renderer, step, &view).frame, "{:?}", step.shading);
        }
    }
}
