//! The projector against the marcher, on meshes that are hard to sort and cells that are hard to draw.

use crate::meshes::{errors, mesh, transfer, view};
use glam::DVec3;
use vr_cells::{Attenuation, CellMarcher, CellProjector};
use vr_core::cells::{CellMesh, CellValues};
use vr_core::{
    Camera, Clip, Control, ControlPoint, Frame, Layer, Light, OpacityRule, Plane, Projection, RenderError, Renderer,
    Scene, Surfaces, TransferFunction, View,
};

fn draw(renderer: &dyn Renderer, scene: &Scene, view: &View) -> Frame {
    let control = Control::default();
    renderer.prepare(scene, &control).unwrap().render(view, &control).unwrap().frame
}

/// Largest difference from the marcher's picture, and the root mean square.
fn difference(renderer: &CellProjector, scene: &Scene, view: &View) -> (f64, f64) {
    let (found, expected) = (draw(renderer, scene, view), draw(&CellMarcher::default(), scene, view));
    let (mut largest, mut sum) = (0.0f64, 0.0);
    for (found, expected) in found.pixels().iter().zip(expected.pixels()) {
        for c in 0..4 {
            let off = f64::from(found[c] - expected[c]).abs();
            (largest, sum) = (largest.max(off), sum + off * off);
        }
    }
    (largest, (sum / (4 * found.pixels().len()) as f64).sqrt())
}

/// Holds the projector to its documented errors.
fn check(name: &str, scene: &Scene, view: &View) {
    let (largest, rms) = difference(&CellProjector::default(), scene, view);
    println!("{name}: largest {largest:.1e}, root mean square {rms:.1e}");
    assert!(largest < 1.0 / 255.0 && rms < 1e-4, "{name}: {largest}, {rms}");
}

fn large(view: View) -> View {
    View { size: [150, 130], ..view }
}

/// Peaks and slopes without a jump: where a ray stays for long at a value where opacity jumps, the projector sees a ramp as wide as 4 of 8192 parts of all values.
fn smooth(opacity: f64) -> TransferFunction {
    let p = ControlPoint::new;
    let points = vec![
        p(0.1, [0.1, 0.2, 0.9], 0.0),
        p(0.45, [0.9, 0.3, 0.1], 0.4 * opacity),
        p(0.6, [0.2, 0.8, 0.3], 0.0),
        p(1.0, [1.0, 1.0, 0.9], opacity),
    ];
    TransferFunction::new(points, OpacityRule::Power, 0.1).unwrap()
}

/// Several meshes as one.
fn together(parts: &[CellMesh]) -> CellMesh {
    let (mut vertices, mut cells, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for part in parts {
        let first = vertices.len() as u32;
        vertices.extend(part.vertices());
        cells.extend(part.cells().iter().map(|cell| cell.map(|v| v + first)));
        let CellValues::Vertices(of_part) = part.values() else { unreachable!("made of vertices' values") };
        values.extend(of_part);
    }
    CellMesh::new(vertices, cells, CellValues::Vertices(values)).unwrap()
}

fn moved(mesh: &CellMesh, place: impl Fn(DVec3) -> DVec3) -> CellMesh {
    let vertices = mesh.vertices().iter().map(|&v| place(v)).collect();
    CellMesh::new(vertices, mesh.cells().to_vec(), mesh.values().clone()).unwrap()
}

/// Three beams, each of which lies over the next.
fn ring() -> CellMesh {
    let beam = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / 3.0;
        let (ahead, aside) = (DVec3::new(angle.cos(), angle.sin(), 0.0), DVec3::new(-angle.sin(), angle.cos(), 0.0));
        let place = |along: f64, across: f64, up: f64| aside * 0.3 + ahead * along + aside * across + DVec3::Z * up;
        let vertices =
            vec![place(-1.0, -0.15, -0.3), place(-1.0, 0.15, -0.3), place(1.0, 0.0, 0.25), place(1.0, 0.05, 0.45)];
        CellMesh::new(vertices, vec![[0, 1, 2, 3]], CellValues::Vertices(vec![0.2, 0.5, 0.8, 1.0])).unwrap()
    };
    together(&[beam(0), beam(1), beam(2)])
}

#[test]
fn cells_in_a_ring_are_in_order_along_every_ray() {
    let scene = Scene::new(ring().into(), transfer(0.9));
    for fov in [None, Some(40.0)] {
        for (yaw, pitch) in [(0.0, 0.0), (0.0, 90.0), (20.0, 60.0)] {
            let camera = Camera::framing(scene.volume.bounds(), yaw, pitch, fov);
            let (largest, _) = errors(&CellProjector::default(), &scene, &View::new(camera, [60, 50]));
            assert!(largest < 1e-3, "{yaw}, {pitch}: {largest}");
        }
    }
}

#[test]
fn parts_and_hollows_are_sorted() {
    let hollow = mesh(6, 0.25, false, |p| (p - 0.5).length() < 0.32 || (p.x > 0.5 && (p.y - 0.5).abs() < 0.1));
    let small = mesh(3, 0.2, false, |_| false);
    // One within the hollow of the other, and one beside it.
    let inner = moved(&small, |v| 0.5 + (v - 0.5) * 0.25);
    let beside = moved(&small, |v| DVec3::new(1.1, 0.2, 0.3) + v * 0.4);
    let scene = Scene::new(together(&[inner, hollow, beside]).into(), transfer(0.5));
    for (yaw, pitch, fov) in
        [(35.0, 25.0, None), (90.0, 0.0, None), (-120.0, -40.0, Some(50.0)), (77.0, 5.0, Some(90.0))]
    {
        let camera = Camera::framing(scene.volume.bounds(), yaw, pitch, fov);
        check("parts", &scene, &View::new(camera, [150, 130]));
    }
}

#[test]
fn faces_seen_from_their_edges_and_slivers_are_drawn() {
    let regular = mesh(4, 0.0, false, |_| false);
    let thin = moved(&mesh(4, 0.2, false, |_| false), |v| DVec3::new(v.x, v.y, 1e-3 * v.z));
    let sheared = moved(&mesh(4, 0.2, false, |_| false), |v| DVec3::new(v.x + 8.0 * v.z, v.y, v.z));
    for (name, mesh) in [("regular", regular), ("thin", thin), ("sheared", sheared)] {
        let bounds = mesh.bounds();
        let scene = Scene::new(mesh.into(), smooth(0.6));
        for (yaw, pitch) in [(0.0, 0.0), (90.0, 0.0), (0.0, 90.0), (1e-4, 1e-4), (45.0, 0.0), (30.0, 20.0)] {
            for fov in [None, Some(30.0)] {
                let camera = Camera::framing(bounds, yaw, pitch, fov);
                // The reference knows of pixels that see the mesh's rim from its edge: they are not certain.
                let (largest, rms) = errors(&CellProjector::default(), &scene, &View::new(camera, [48, 32]));
                let view = format!("{name} from {yaw}, {pitch}, {fov:?}");
                println!("{view}: largest {largest:.1e}, root mean square {rms:.1e}");
                assert!(largest < 1.0 / 255.0 && rms < 1e-4, "{view}: {largest}, {rms}");
            }
        }
    }
}

/// A wall at a distance that grows across the picture.
#[derive(Debug)]
struct Wall(f32);

impl Surfaces for Wall {
    fn layer(&self, _: &[Light], view: &View, _: &Control) -> Result<Layer, RenderError> {
        let pixels = (0..view.size[0] * view.size[1]).map(|i| {
            let share = (i % view.size[0]) as f32 / view.size[0] as f32;
            ([0.1, 0.4, 0.2], if share < 0.3 { f32::INFINITY } else { self.0 * (0.5 + share) })
        });
        Ok(Layer { pixels: pixels.collect() })
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        (DVec3::ZERO, DVec3::ONE)
    }
}

#[test]
fn rays_are_cut_by_walls_clips_and_the_eye() {
    let mesh = mesh(5, 0.2, false, |p| p.x > 0.6 && p.y > 0.6);
    let clip = Clip {
        crop: Some((DVec3::splat(0.1), DVec3::splat(0.85))),
        planes: vec![Plane { normal: DVec3::new(0.4, -0.3, 1.0), offset: 0.3 }],
    };
    for fov in [None, Some(40.0)] {
        let view = large(view(35.0, 25.0, fov));
        let away = (view.camera.eye - DVec3::splat(0.5)).length() as f32;
        let plain = Scene::new(mesh.clone().into(), transfer(0.7));
        let walled = Scene { surfaces: Some(std::sync::Arc::new(Wall(away))), ..plain.clone() };
        for scene in [plain, walled] {
            for clip in [Clip::default(), clip.clone()] {
                check("cut", &scene, &View { clip, supersampling: 2, ..view.clone() });
            }
        }
    }
    // The eye in the mesh: in parallel projection it cuts cells, in perspective tiles with cells around it go ray by ray.
    let scene = Scene::new(mesh.into(), transfer(0.4));
    for projection in [Projection::Orthographic { height: 0.7 }, Projection::Perspective { fov: 60.0 }] {
        let eye = DVec3::new(0.43, 0.41, 0.47);
        check("inside", &scene, &View::new(Camera { eye, target: DVec3::ZERO, up: DVec3::Y, projection }, [150, 130]));
    }
}

#[test]
fn the_classic_approximation_is_right_for_faint_cells_and_refuses_what_it_cannot_draw() {
    let classic = CellProjector { attenuation: Attenuation::Linear, ..CellProjector::default() };
    let faint = |density: f64| {
        let points = vec![ControlPoint::new(0.0, [1.0, 0.7, 0.2], density)];
        let transfer = TransferFunction::new(points, OpacityRule::Extinction, 1.0).unwrap();
        Scene::new(mesh(4, 0.2, false, |_| false).into(), transfer)
    };
    // Of a cell of optical depth τ at its thickest, opacity is off by τ²/8: a tenth of the density leaves a hundredth.
    let errors =
        |fov: Option<f64>| [0.1, 0.01].map(|d| difference(&classic, &faint(d), &large(view(35.0, 25.0, fov))).0);
    let [dense, thin] = errors(None);
    assert!(dense < 0.005 && (80.0..125.0).contains(&(dense / thin)), "{dense}, {thin}");
    // In perspective it is linear on the screen, where thickness is not: a tenth leaves a tenth of that.
    let [dense, thin] = errors(Some(40.0));
    assert!(dense < 0.005 && thin < 0.0005, "{dense}, {thin}");
    let scene = faint(1.0);
    let shaded = Scene { shading: Some(vr_core::Shading::default().into()), ..scene.clone() };
    let maximum = Scene { compositing: vr_core::Compositing::Maximum, ..scene.clone() };
    for scene in [shaded, maximum] {
        let error = classic.supports(&scene, None).unwrap_err().to_string();
        assert!(error.contains("attenuation=exact draws it"), "{error}");
    }
    let clip = Clip { crop: Some((DVec3::ZERO, DVec3::splat(0.5))), ..Clip::default() };
    let error = classic.supports(&scene, Some(&View { clip, ..view(0.0, 0.0, None) })).unwrap_err().to_string();
    assert!(error.contains("clip planes with attenuation=linear"), "{error}");
}

#[test]
fn random_meshes_and_views_agree() {
    let mut state = 5u64;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1u64 << 24) as f64
    };
    for round in 0..40 {
        let (n, jitter, of_cells) = (2 + round % 4, 0.3 * random(), round % 5 == 4);
        let hole = DVec3::new(random(), random(), random());
        let radius = 0.4 * random();
        let mesh = mesh(n, jitter, of_cells, |p| (p - hole).length() < radius);
        let scene = Scene::new(mesh.into(), smooth(0.1 + 0.8 * random()));
        let fov = [None, Some(20.0), Some(70.0)][round % 3];
        let view = view(360.0 * random(), 180.0 * random() - 90.0, fov);
        check(&format!("round {round}"), &scene, &View { size: [70, 66], ..view });
    }
}
