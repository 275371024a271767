//! Rectilinear grids: brute force through the field's values alone, closed forms, and uniform grids of the same values.

use crate::brute::{
    OPERATORS, agrees_with_brute_force, brute, difference, same_under_every_operator, solved, transfer, view, waves,
};
use glam::{DMat3, DVec3};
use vr_core::field::FunctionField;
use vr_core::rectilinear::{Centering, RectilinearGrid};
use vr_core::{
    Calibration, Camera, Clip, Compositing, Field, GradientMethod, Placement, Plane, Rays, Scene, Shading, UniformGrid,
    View, Volume,
};

/// Axes over the unit cube whose steps differ up to fortyfold.
fn uneven() -> [Vec<f64>; 3] {
    [
        vec![0.0, 0.02, 0.1, 0.4, 0.43, 0.8, 1.0],
        vec![0.0, 0.3, 0.35, 0.7, 0.95, 1.0],
        (0..9).map(|k| (f64::from(k) / 8.0).powi(2)).collect(),
    ]
}

fn sampled(axes: [Vec<f64>; 3], f: impl Fn(DVec3) -> f64) -> RectilinearGrid {
    let mut values = Vec::new();
    for &z in &axes[2] {
        for &y in &axes[1] {
            values.extend(axes[0].iter().map(|&x| f(DVec3::new(x, y, z)) as f32));
        }
    }
    RectilinearGrid::new(axes, values, Centering::Points).unwrap()
}

#[test]
fn every_operator_agrees_with_brute_force() {
    let grid = sampled(uneven(), waves);
    let plain = OPERATORS.map(|o| (o, None));
    let lit = [GradientMethod::Analytic, GradientMethod::CentralDifferences].map(|m| (Compositing::Over, Some(m)));
    for (compositing, shading) in plain.into_iter().chain(lit) {
        let volume: Volume = grid.clone().into();
        let volume = shading.map_or(volume.clone(), |method| volume.with_gradient(method));
        let shading = shading.map(|gradient| Shading { gradient, ..Shading::default() }.into());
        let scene = Scene { compositing, shading, ..Scene::new(volume, transfer(0.2)) };
        agrees_with_brute_force(&scene, 1e-8);
    }
}

#[test]
fn a_linear_field_is_its_function_on_uneven_axes() {
    let slope = DVec3::new(0.5, -0.3, 0.7);
    let value = move |p: DVec3| 0.25 + slope.dot(p);
    let grid = sampled(uneven(), value);
    // Values in f32 are off by 2⁻²⁵ of 1.45 at most, twice that over a step of 1/64.
    for at in [DVec3::new(0.01, 0.2, 0.001), DVec3::new(0.42, 0.9, 0.99), DVec3::ONE] {
        assert!((grid.value(at).unwrap() - value(at)).abs() < 1e-7);
        for method in [GradientMethod::Analytic, GradientMethod::CentralDifferences] {
            let found = grid.clone().with_gradient(method).gradient(at).unwrap();
            assert!((found - slope).abs().max_element() < 1e-5, "{method:?}: {found}");
        }
    }
    let function = FunctionField::new((DVec3::ZERO, DVec3::ONE), value).unwrap().with_lipschitz(slope.length());
    let scene = |volume: Volume| Scene::new(volume, transfer(0.2));
    let (a, b) = (scene(grid.into()), scene(function.into()));
    // The surface of `First` moves by the rounding of the values, and colours by their slope of 10 at most.
    same_under_every_operator([&a, &b], 8, 1e-6, f64::INFINITY);
}

/// Values on even axes, as both kinds of grid, with two voxels missing: the same picture under every operator, lit both ways, clipped.
#[test]
fn even_axes_are_a_uniform_grid() {
    let (dims, step) = ([7usize, 6, 9], [1.0 / 6.0, 0.2, 0.125]);
    let axes: [Vec<f64>; 3] = std::array::from_fn(|a| (0..dims[a]).map(|k| k as f64 * step[a]).collect());
    let with_holes = |mut values: Vec<f32>, holes: bool| {
        if holes {
            values[3 + 7 * (2 + 6 * 4)] = f32::NAN;
            values[0] = f32::NAN;
        }
        values
    };
    let whole = sampled(axes.clone(), waves);
    let values = |holes| {
        let mut all = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                let at = |x: usize| DVec3::new(axes[0][x], axes[1][y], axes[2][z]);
                all.extend((0..dims[0]).map(|x| waves(at(x)) as f32));
            }
        }
        with_holes(all, holes)
    };
    let placement = Placement::new(DVec3::ZERO, DMat3::from_diagonal(step.into())).unwrap();
    assert_eq!(whole.to_uniform().unwrap().placement().spacing(), placement.spacing());
    for holes in [false, true] {
        let uniform = UniformGrid::new(dims, values(holes), placement, Calibration::default()).unwrap();
        let uneven = RectilinearGrid::new(axes.clone(), values(holes), Centering::Points).unwrap();
        let plain = OPERATORS.map(|o| (o, None));
        let lit = [GradientMethod::Analytic, GradientMethod::CentralDifferences].map(|m| (Compositing::Over, Some(m)));
        for (compositing, method) in plain.into_iter().chain(lit) {
            let shading = method.map(|gradient| Shading { gradient, ..Shading::default() }.into());
            let scene = |volume: Volume| {
                let volume = method.map_or(volume.clone(), |m| volume.with_gradient(m));
                Scene { compositing, shading: shading.clone(), ..Scene::new(volume, transfer(0.2)) }
            };
            let mut view = view(9);
            view.clip = Clip { planes: vec![Plane { normal: DVec3::new(1.0, 0.3, -0.2), offset: 0.21 }], crop: None };
            let pictures = [scene(uniform.clone().into()), scene(uneven.clone().into())].map(|s| solved(&s, &view));
            for (i, (a, b)) in pictures[0].iter().zip(&pictures[1]).enumerate() {
                let off = difference(&a.rgba, &b.rgba);
                let bound = a.certainty.value() + b.certainty.value();
                assert!(
                    off <= bound.min(1e-6),
                    "{compositing:?}, {method:?}, holes {holes}: {off} at {i}, bound {bound}"
                );
            }
        }
    }
}

/// Rays in the planes of the grid themselves meet what lies on both sides: the field is continuous there.
#[test]
fn rays_in_planes_and_far_eyes_keep_their_bounds() {
    let grid = sampled(uneven(), waves);
    let scene = Scene::new(grid.into(), transfer(0.2));
    for distance in [3.0, 1e4, 1e7] {
        for (direction, up) in [(DVec3::X, DVec3::Z), (DVec3::Y, DVec3::X), (DVec3::Z, DVec3::Y)] {
            let at = DVec3::new(0.4, 0.35, 0.25);
            let camera = Camera {
                eye: at - direction * distance,
                target: at,
                up,
                projection: vr_core::Projection::Orthographic { height: 0.2 },
            };
            // The middle pixel's ray runs along an edge of four cells.
            let view = View::new(camera, [3, 3]);
            let rays = Rays::new(&view).unwrap();
            for (i, pixel) in solved(&scene, &view).iter().enumerate() {
                let expected = brute(&scene, &rays.at((i % 3) as f64 + 0.5, (i / 3) as f64 + 0.5));
                let off = difference(&pixel.rgba, &expected);
                // Coordinates of the eye are rounded, and values rise by 10 a unit at most.
                assert!(
                    pixel.certainty.value() < 1e-8 + 1e-10 * distance,
                    "{direction} from {distance}: {:?}",
                    pixel.certainty
                );
                assert!(off < 1e-3 + pixel.certainty.value(), "{direction} from {distance}: {off} at {i}");
            }
        }
    }
}
