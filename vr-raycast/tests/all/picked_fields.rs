//! Values picked from adaptive meshes, rectilinear grids, sums of points and coloured voxels, by packets and ray by ray, against the reference.

use std::sync::Arc;

use glam::DVec3;
use vr_core::amr::{AmrCentring, AmrGrid, AmrSampling};
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::{
    Calibration, Camera, ColorGrid, Compositing, Control, ControlPoint, Model, OpacityRule, Placement, PointKernel,
    PointSet, Renderer, Scene, Shading, TransferFunction, UniformGrid, View, Volume,
};
use vr_physics::Reference;
use vr_physics::metrics::Metrics;
use vr_raycast::{RayCaster, Vector};

/// Between 0 and 1 over the unit cube.
fn wave(p: DVec3) -> f32 {
    (0.5 + 0.45 * (4.0 * p.x).sin() * (3.0 * p.y + 0.4).cos() * (3.5 * p.z + 0.3).sin()) as f32
}

/// Values of a lattice over the unit cube.
fn values<T>(places: &[f64], of: impl Fn(DVec3) -> T) -> Vec<T> {
    let mut values = Vec::new();
    for &z in places {
        for &y in places {
            values.extend(places.iter().map(|&x| of(DVec3::new(x, y, z))));
        }
    }
    values
}

/// Two levels, fine in one corner and around a few blocks.
fn mesh() -> Volume {
    let sampling = AmrSampling {
        origin: DVec3::ZERO,
        edge: 0.25,
        blocks: [4; 3],
        block_cells: [8; 3],
        ratios: vec![[2; 3]],
        centring: AmrCentring::Cells,
    };
    AmrGrid::refining(&sampling, wave, |low, _, _| low.element_sum() < 0.6).unwrap().into()
}

fn uneven() -> Volume {
    let mut places = vec![0.0];
    (0..23).for_each(|k| places.push(places[k] + 1.08f64.powi(k as i32)));
    let places: Vec<f64> = places.iter().map(|p| p / places[23]).collect();
    let axes = [places.clone(), places.clone(), places.clone()];
    Volume::Rectilinear(Arc::new(RectilinearGrid::new(axes, values(&places, wave), Centering::Points).unwrap()))
}

fn points() -> Volume {
    let places: Vec<DVec3> =
        (0..40).map(f64::from).map(|k| DVec3::new(k * 0.618, k * 0.414, k * 0.732).fract()).collect();
    let of = |share: f32| (0..40).map(|k| share * (1.0 + 0.5 * (k as f32).sin())).collect::<Vec<_>>();
    PointSet::new(places, of(0.3), of(0.002), vec![1.0; 40], PointKernel::CubicSpline).unwrap().into()
}

fn colored() -> Volume {
    let places: Vec<f64> = (0..24).map(|k| f64::from(k) / 23.0).collect();
    let placement = Placement::from_spacing([1.0 / 23.0; 3]).unwrap();
    let grid = UniformGrid::new([24; 3], values(&places, wave), placement, Calibration::default()).unwrap();
    let channel = |along: DVec3| values(&places, |p| (60000.0 * p.dot(along).abs().min(1.0)) as u16);
    let grid = Volume::from(grid).grid().unwrap().as_ref().clone();
    Volume::Color(Arc::new(ColorGrid::new(grid, [DVec3::X, DVec3::Y, DVec3::Z].map(channel)).unwrap()))
}

fn ramp() -> TransferFunction {
    let point = |value, opacity| ControlPoint::new(value, [1.0 - value, value, 0.5], opacity);
    TransferFunction::new(vec![point(0.0, 0.1), point(1.0, 1.0)], OpacityRule::Power, 0.2).unwrap()
}

fn rmse(scene: &Scene, caster: &RayCaster, solved: &[[f64; 4]], view: &View) -> f64 {
    let control = Control::default();
    let rendered = caster.prepare(scene, &control).unwrap().render(view, &control).unwrap();
    Metrics::of(solved, rendered.frame.pixels()).rmse
}

/// A step's own way from an extreme's place, and from the middle of what a mean is over: a quarter of the step has less than a third of the error.
#[test]
fn what_is_picked_converges_to_the_reference() {
    let operators =
        [Compositing::Maximum, Compositing::Minimum, Compositing::Average, Compositing::First { threshold: 0.6 }];
    for (kind, volume) in [("mesh", mesh()), ("rectilinear", uneven()), ("points", points()), ("colours", colored())] {
        let view = View::new(Camera::framing(volume.bounds(), 35.0, 25.0, Some(40.0)), [16, 16]);
        for compositing in operators {
            for shading in [None, Some(Arc::new(Shading::default()))] {
                let is_lit = shading.is_some() && matches!(compositing, Compositing::First { .. });
                let scene = Scene { compositing, shading, ..Scene::new(volume.clone(), ramp()) };
                let solved = Reference::new(1e-7).solve(&scene, &view, &Model::Canonical, &Control::default()).unwrap();
                let solved: Vec<[f64; 4]> = solved.pixels.iter().map(|p| p.rgba).collect();
                for vector in [Vector::Auto, Vector::Off] {
                    let [coarse, fine] = [1.0, 0.1]
                        .map(|step| rmse(&scene, &RayCaster { vector, ..RayCaster::uniform(step) }, &solved, &view));
                    let name = compositing.name();
                    println!("{kind}, {name}, lit {is_lit}, {vector:?}: {coarse:.1e}, then {fine:.1e}");
                    let floor = if is_lit { 2e-2 } else { 1e-3 };
                    assert!(
                        fine < floor && fine < coarse / 3.0 + 0.5 * floor,
                        "{kind}, {name}, {vector:?}: {coarse}, then {fine}"
                    );
                }
            }
        }
    }
}
