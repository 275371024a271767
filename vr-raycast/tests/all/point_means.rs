//! Weighted means of scattered points, and their colours, against the reference.

use std::sync::Arc;

use glam::DVec3;
use vr_core::{Compositing, Light, PointKernel, PointMixing, PointSet, Scene, Shading, TransferFunction};
use vr_physics::check::strategies::{tame_mixed_point_scene, tame_point_scene};
use vr_physics::check::{Effort, agrees_with_reference_on};
use vr_raycast::RayCaster;

use crate::common::{self, framed_error};

/// Three points in each other's supports, with colours.
fn three(kernel: PointKernel, mixing: PointMixing) -> PointSet {
    let positions = vec![DVec3::ZERO, DVec3::new(0.8, 0.2, -0.1), DVec3::new(-0.3, 0.9, 0.4)];
    let points = PointSet::new(positions, vec![1.0; 3], vec![1.0, 2.0, 0.5], vec![1.0, 0.7, 0.4], kernel).unwrap();
    let colors = vec![[1.0, 0.2, 0.1], [0.1, 1.0, 0.3], [0.2, 0.1, 1.0]];
    points.with_mixing(mixing).unwrap().with_colors(colors).unwrap()
}

fn transfer() -> TransferFunction {
    common::transfer(&[(0.2, [0.4, 0.6, 0.9], 0.0), (0.6, [0.9, 0.7, 0.5], 0.2), (1.0, [1.0; 3], 0.5)], 0.3)
}

#[test]
fn means_and_colours_converge_to_the_reference() {
    for kernel in PointKernel::ALL {
        for mixing in PointMixing::ALL {
            let plain =
                Scene { lights: vec![Light::default()], ..Scene::new(three(kernel, mixing).into(), transfer()) };
            let shaded = Scene { shading: Some(Arc::new(Shading::default())), ..plain.clone() };
            for scene in [plain, shaded] {
                let errors =
                    [0.4, 0.1, 0.025].map(|step| framed_error(&scene, &RayCaster::uniform(step), Some(30.0)).rmse);
                println!(
                    "{kernel}, {mixing}, {}: {errors:?}",
                    if scene.shading.is_some() { "shaded" } else { "plain" }
                );
                // Order 2, for steps end where a mean begins and ends with a jump. But order 1 where it bends within a step or two: where a cone or a
                // Gaussian begins near the edge of another; and shaded, for gradients of a mean jump at the edges of supports.
                let steep = mixing == PointMixing::Mean && kernel != PointKernel::CubicSpline;
                let (floor, fall) = match (mixing, scene.shading.is_some()) {
                    (PointMixing::Mean, true) => (1e-3, 3.0),
                    // A cone's gradient jumps at its tip.
                    (PointMixing::Sum, true) => (1e-4, 20.0),
                    _ if steep => (2e-4, 10.0),
                    _ => (3e-5, 60.0),
                };
                assert!(errors[2] < floor && errors[2] < errors[0] / fall, "{kernel}, {mixing}: {errors:?}");
            }
        }
    }
}

#[test]
fn values_and_colours_are_picked_of_means() {
    let points = three(PointKernel::Gaussian, PointMixing::Mean);
    let operators = [
        Compositing::Maximum,
        Compositing::Minimum,
        Compositing::Average,
        Compositing::First { threshold: 0.75 },
        Compositing::Accumulate { level: 0.3 },
    ];
    for compositing in operators {
        let scene = Scene { compositing, ..Scene::new(points.clone().into(), transfer()) };
        let m = framed_error(&scene, &RayCaster::uniform(0.02), None);
        println!("{}: {m}", compositing.name());
        // A step's own way from an extreme's place.
        assert!(m.rmse < 5e-3, "{}: {m}", compositing.name());
    }
}

/// In f64, and on sixteen lanes in f32: sums, and means or colours.
#[test]
fn random_clouds_come_to_the_reference() {
    for caster in [RayCaster::exact(1.0 / 32.0), RayCaster::uniform(1.0 / 32.0)] {
        let effort = Effort::cases(96);
        for report in [
            agrees_with_reference_on(&caster, tame_point_scene(), |_, _| 2e-2, &effort),
            agrees_with_reference_on(&caster, tame_mixed_point_scene(), |_, _| 2e-2, &effort),
        ] {
            let report = report.unwrap_or_else(|e| panic!("{caster:?}: {e}"));
            println!("{report}");
            assert!(report.held > 60 && report.refused == 0, "{caster:?}: {report}");
        }
    }
}
