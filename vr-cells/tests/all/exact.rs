//! Both renderers against the reference: every operator, views from all sides and from inside, meshes with holes, rays along shared faces.

use crate::meshes::{OPERATORS, errors, mesh, transfer, view};
use glam::DVec3;
use vr_cells::{CellMarcher, CellProjector};
use vr_core::cells::{CellMesh, CellValues};
use vr_core::{
    Camera, Clip, Compositing, Control, ControlPoint, Frame, Light, OpacityRule, Plane, Projection, Renderer, Scene,
    Shading, TransferFunction, View,
};

/// A renderer and the bounds of its documentation: of any channel of any pixel, and of the root mean square.
struct Held {
    renderer: Box<dyn Renderer>,
    largest: f64,
    root_mean_square: f64,
}

impl Held {
    fn both() -> [Self; 2] {
        [
            Self { renderer: Box::new(CellMarcher::default()), largest: 1e-5, root_mean_square: f64::INFINITY },
            Self { renderer: Box::new(CellProjector::default()), largest: 1e-3, root_mean_square: 1e-4 },
        ]
    }

    /// Panics if a picture is further from the reference than `allowed`, or its root mean square than documented.
    fn within(&self, allowed: f64, name: &str, scene: &Scene, view: &View) {
        let (largest, rms) = errors(&*self.renderer, scene, view);
        println!("{}, {name}: largest {largest:.1e}, root mean square {rms:.1e}", self.renderer.name());
        assert!(largest < allowed, "{}, {name}: {largest}", self.renderer.name());
        assert!(rms < self.root_mean_square, "{}, {name}: root mean square {rms}", self.renderer.name());
    }

    fn draw(&self, scene: &Scene, view: &View, control: &Control) -> Frame {
        self.renderer.prepare(scene, control).unwrap().render(view, control).unwrap().frame
    }
}

#[test]
fn every_operator_is_exact() {
    for of_cells in [false, true] {
        let mesh = mesh(5, 0.25, of_cells, |p| (p - 0.5).length() < 0.3);
        for compositing in OPERATORS {
            for (yaw, pitch, fov) in [(35.0, 25.0, None), (-120.0, -40.0, Some(50.0))] {
                let scene = Scene { compositing, ..Scene::new(mesh.clone().into(), transfer(0.7)) };
                for held in Held::both() {
                    held.within(held.largest, &format!("{compositing:?}, {of_cells}"), &scene, &view(yaw, pitch, fov));
                }
            }
        }
    }
}

#[test]
fn shading_clips_walls_and_emission_are_exact() {
    let mesh = mesh(4, 0.2, false, |p| p.x > 0.6 && p.y > 0.6);
    let light = Light { direction: Some(DVec3::new(0.3, 1.0, 0.5)), color: [1.0, 0.8, 0.6] };
    let plain = Scene { lights: vec![Light::default(), light], ..Scene::new(mesh.into(), transfer(0.7)) };
    let shaded = Scene { shading: Some(Shading::default().into()), ..plain.clone() };
    let faded = Shading { gradient_opacity: vec![(0.5, 0.2), (3.0, 1.0)], ..Shading::default() };
    // Nothing is left of the medium, wall or not, where the gradient is small.
    let cut = Shading { gradient_opacity: vec![(1.0, 0.0), (2.5, 1.0)], ..Shading::default() };
    let row = |gradient, opacity: f64| {
        let points =
            vec![ControlPoint::new(0.2, [0.9, 0.3, 0.1], opacity), ControlPoint::new(0.8, [0.1, 0.3, 0.9], 0.5)];
        (gradient, points)
    };
    let rows = TransferFunction::of_rows(vec![row(0.5, 0.0), row(2.0, 0.7), row(4.0, 0.1)], OpacityRule::Power, 0.1);
    let rows = rows.unwrap();
    let wall = Scene { transfer: transfer(1.0).into(), ..plain.clone() };
    let glow =
        |v, e: f64| ControlPoint { emission: Some([e, 2.0 * e, 0.5]), ..ControlPoint::new(v, [0.0; 3], 0.3 * v) };
    let emission = TransferFunction::new(vec![glow(0.0, 0.0), glow(1.0, 3.0)], OpacityRule::Extinction, 0.3).unwrap();
    let view = view(35.0, 25.0, Some(40.0));
    let clip = Clip {
        crop: Some((DVec3::splat(0.1), DVec3::splat(0.85))),
        planes: vec![Plane { normal: DVec3::new(0.4, -0.3, 1.0), offset: 0.3 }],
    };
    for (name, scene) in [
        ("shaded", shaded.clone()),
        ("first, shaded", Scene { compositing: Compositing::First { threshold: 0.5 }, ..shaded.clone() }),
        ("gradient opacity", Scene { shading: Some(faded.into()), ..plain.clone() }),
        ("wall", wall.clone()),
        ("wall where the gradient is not small", Scene { shading: Some(cut.into()), ..wall }),
        ("gradient rows", Scene { transfer: rows.into(), ..plain.clone() }),
        ("emission", Scene { transfer: emission.into(), ..plain.clone() }),
    ] {
        for clip in [Clip::default(), clip.clone()] {
            let view = View { clip, ..view.clone() };
            for held in Held::both() {
                // Highlights turn within a cell, where the normal is that of an interpolated gradient.
                let turning = name.contains("shaded") || name.contains("gradient");
                held.within(if turning { 1e-4 } else { held.largest }, name, &scene, &view);
            }
        }
    }
}

/// The slab on which another program gives 0.35 to 0.88: 1 − e^(−½) in every pixel, whose rays run along shared faces and edges.
#[test]
fn a_constant_slab_is_the_same_everywhere() {
    let mut mesh = mesh(8, 0.0, false, |_| false);
    let ones = CellValues::Vertices(vec![1.0; mesh.vertices().len()]);
    mesh = CellMesh::new(mesh.vertices().to_vec(), mesh.cells().to_vec(), ones).unwrap();
    let points = vec![ControlPoint::new(0.0, [1.0; 3], 0.5)];
    let scene = Scene::new(mesh.into(), TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap());
    for direction in [DVec3::X, DVec3::NEG_Y, DVec3::Z] {
        let up = if direction.y == 0.0 { DVec3::Y } else { DVec3::Z };
        let camera = Camera {
            eye: DVec3::splat(0.5) - 3.0 * direction,
            target: DVec3::splat(0.5),
            up,
            projection: Projection::Orthographic { height: 1.0 },
        };
        // Pixel centres on the lattice's lines and diagonals.
        let control = Control::default();
        for size in [8, 15, 16] {
            let view = View::new(camera, [size; 2]);
            let exact = 1.0 - (-0.5f64).exp();
            for held in Held::both() {
                for (i, pixel) in held.draw(&scene, &view, &control).pixels().iter().enumerate() {
                    let name = held.renderer.name();
                    assert!((f64::from(pixel[3]) - exact).abs() < 1e-6, "{name}, {direction}, {size}, {i}: {pixel:?}");
                }
            }
        }
    }
}

#[test]
fn a_camera_inside_sees_what_lies_ahead() {
    let mesh = mesh(5, 0.2, false, |p| (p - DVec3::new(0.5, 0.5, 0.8)).length() < 0.15);
    let scene = Scene::new(mesh.into(), transfer(0.3));
    for projection in [Projection::Perspective { fov: 80.0 }, Projection::Orthographic { height: 0.7 }] {
        let camera =
            Camera { eye: DVec3::new(0.43, 0.51, 0.47), target: DVec3::new(0.9, 0.1, 0.9), up: DVec3::Y, projection };
        for held in Held::both() {
            held.within(held.largest, &format!("{projection:?}"), &scene, &View::new(camera, [17, 13]));
        }
    }
}

#[test]
fn threads_and_supersampling_change_nothing_else() {
    let scene = Scene::new(mesh(4, 0.2, false, |_| false).into(), transfer(0.7));
    let view = View { supersampling: 2, ..view(20.0, 10.0, None) };
    for held in Held::both() {
        let draw = |threads| held.draw(&scene, &view, &Control::default().with_threads(threads));
        assert_eq!(draw(1).pixels(), draw(3).pixels(), "{}", held.renderer.name());
        held.within(held.largest, "supersampled", &scene, &view);
    }
}
