//! Pictures that would take minutes end soon after they are cancelled, inside a tile and inside a ray.

use std::time::Duration;

use vr_core::{Configurable, Options, Scene, View, phantom};
use vr_physics::check::pictures::view;
use vr_physics::check::time_to_cancel;
use vr_raycast::RayCaster;

use crate::common::{homogeneous, volume};

/// A person is promised half a second, of which a machine with other work may take its part.
const SOON: Duration = Duration::from_millis(300);

/// Time that rays have before they are cancelled.
const AFTER: Duration = Duration::from_millis(200);

fn end(options: Options, scene: &Scene, view: &View) {
    let caster = RayCaster::default().configure(&options).unwrap();
    let time = time_to_cancel(&caster, scene, view, AFTER);
    println!("{options:?}: {time:?}");
    assert!(time < SOON, "{options:?}: {time:?}");
}

/// A medium that lets all rays through and is nowhere clear.
fn haze(n: usize) -> Scene {
    Scene::new(volume([n; 3], |x, y, z| (x * 1.7 + y * 2.3).sin() + z.cos()), homogeneous(1e-9))
}

fn uniform(step: f64) -> Options {
    Options::new().with("steps", "uniform").with("step", step)
}

#[test]
fn rays_end_where_they_are() {
    let scene = haze(16);
    let view = view(&scene, 30.0, 20.0, None, 8);
    // Rays of ten million steps; and lists of as many, that are made before the first is taken.
    let plain = uniform(2e-6).with("vector", "off");
    end(plain.clone(), &scene, &view);
    end(plain.clone().with("leaping", "none").with("order", "back-to-front"), &scene, &view);
    end(plain.with("traversal", "cells"), &scene, &view);
}

#[test]
fn tiles_end_between_packets() {
    let scene = haze(64);
    let large = view(&scene, 30.0, 20.0, None, 512);
    // A second and more for a tile; nearly the shortest steps that packets take.
    end(uniform(1e-4), &scene, &large);
    let picked = Scene { compositing: vr_core::Compositing::Average, ..scene.clone() };
    end(uniform(1e-4), &picked, &large);
    // A million rays for a tile of the picture, of which even adaptive rays leave many.
    let supersampled = View { supersampling: 32, ..view(&scene, 30.0, 20.0, None, 4096) };
    end(Options::new(), &scene, &supersampled);
    end(Options::new().with("max-error", 1e-6), &scene, &supersampled);
}

#[test]
fn points_end_between_packets() {
    let scene = Scene::new(phantom::points_by_name("plummer", 20_000).unwrap().into(), homogeneous(1e-9));
    end(uniform(1e-3), &scene, &view(&scene, 30.0, 20.0, None, 256));
}
