//! Opacity by the gradient in adaptive meshes and rectilinear grids, by packets and ray by ray, against the reference.

use std::sync::Arc;

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::{
    Camera, Control, ControlPoint, Model, OpacityRule, Renderer, Scene, Shading, TransferFunction, View, Volume,
};
use vr_physics::Reference;
use vr_physics::metrics::Metrics;
use vr_raycast::{RayCaster, Vector};

/// Between 0 and 1, with slopes up to 2.
fn ball(p: DVec3) -> f64 {
    1.0 / (1.0 + ((p.distance(DVec3::splat(0.5)) - 0.3) / 0.125).exp())
}

/// Two levels over the unit cube, fine in one corner.
fn mesh() -> Volume {
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 0.5,
        blocks: [2; 3],
        block_cells: [8; 3],
        ratios: vec![[2; 3]],
        centring: AmrCentring::Cells,
    };
    AmrGrid::refining(&sampling, |p| ball(p) as f32, |low, _, _| low == DVec3::ZERO).unwrap().into()
}

/// Cells from 0.02 to 0.1 over the unit cube.
fn uneven() -> Volume {
    let mut places = vec![0.0];
    (0..19).for_each(|k| places.push(places[k] + 1.1f64.powi(k as i32)));
    let places: Vec<f64> = places.iter().map(|p| p / places[19]).collect();
    let mut values = Vec::new();
    for &z in &places {
        for &y in &places {
            values.extend(places.iter().map(|&x| ball(DVec3::new(x, y, z)) as f32));
        }
    }
    let grid = RectilinearGrid::new([places.clone(), places.clone(), places], values, Centering::Points).unwrap();
    Volume::Rectilinear(Arc::new(grid))
}

fn points(share: f64) -> Vec<ControlPoint> {
    let point = |value, opacity| ControlPoint::new(value, [1.0, value, 1.0 - value], share * opacity);
    vec![point(0.1, 0.0), point(0.5, 0.3), point(1.0, 0.1)]
}

fn scenes(volume: &Volume) -> Vec<(&'static str, Scene)> {
    let by_value = TransferFunction::new(points(1.0), OpacityRule::Power, 0.1).unwrap();
    let by_rows =
        TransferFunction::of_rows(vec![(0.2, points(0.1)), (1.5, points(1.0))], OpacityRule::Power, 0.1).unwrap();
    let gradient_opacity = vec![(0.2, 0.1), (1.5, 1.5)];
    let by_value = Scene::new(volume.clone(), by_value);
    let by_rows = Scene::new(volume.clone(), by_rows);
    let with = |scene: &Scene, shading: Shading| Scene { shading: Some(Arc::new(shading)), ..scene.clone() };
    vec![
        ("factors", with(&by_value, Shading { gradient_opacity: gradient_opacity.clone(), ..Shading::flat() })),
        ("factors, shaded", with(&by_value, Shading { gradient_opacity, ..Shading::default() })),
        ("rows, shaded", with(&by_rows, Shading::default())),
        ("rows", by_rows),
    ]
}

/// The midpoint rule is of order 2 where the gradient is continuous; it jumps at the faces of cells of other levels, in a part of the mesh that shrinks with
/// the step no more: a quarter of the step, an eighth of the error at least.
#[test]
fn opacity_by_the_gradient_converges_to_the_reference() {
    for (kind, volume) in [("mesh", mesh()), ("rectilinear grid", uneven())] {
        let view = View::new(Camera::framing(volume.bounds(), 35.0, 25.0, Some(40.0)), [16, 16]);
        for (look, scene) in scenes(&volume) {
            let control = Control::default();
            let solved = Reference::new(1e-6).solve(&scene, &view, &Model::Canonical, &control).unwrap();
            let solved: Vec<[f64; 4]> = solved.pixels.iter().map(|p| p.rgba).collect();
            for vector in [Vector::Auto, Vector::Off] {
                let rmse = [1.0, 0.25].map(|step| {
                    let caster = RayCaster { vector, ..RayCaster::uniform(step) };
                    let rendered = caster.prepare(&scene, &control).unwrap().render(&view, &control).unwrap();
                    Metrics::of(&solved, rendered.frame.pixels()).rmse
                });
                println!("{kind}, {look}, {vector:?}: {rmse:?}");
                assert!(rmse[1] < 5e-4 && rmse[1] < rmse[0] / 8.0 + 5e-5, "{kind}, {look}, {vector:?}: {rmse:?}");
            }
        }
    }
}
