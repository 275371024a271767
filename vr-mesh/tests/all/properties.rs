//! Properties over random surfaces and views. The random numbers are the same on every run.

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use vr_core::{Camera, Clip, Control, Layer, Light, Plane, Projection, Rays, Surfaces, TriangleMesh, View};
use vr_mesh::Surface;

fn check<S: Strategy>(cases: u32, strategy: &S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    runner.run(strategy, test).unwrap_or_else(|e| panic!("{e}"));
}

fn draw(mesh: &TriangleMesh, view: &View) -> Layer {
    Surface::new(mesh.clone()).layer(&[Light::default()], view, &Control::default()).expect("a picture")
}

fn point(reach: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..reach).prop_map(DVec3::from)
}

/// Cameras on all sides, near and far, and within.
fn camera() -> impl Strategy<Value = Camera> {
    let projection = prop_oneof![
        (0.5..4.0).prop_map(|height| Projection::Orthographic { height }),
        (20.0..120.0).prop_map(|fov| Projection::Perspective { fov }),
    ];
    (point(3.0), point(0.5), projection).prop_filter_map("it sees something", |(eye, target, projection)| {
        let camera = Camera { eye, target, up: DVec3::new(0.1, 1.0, 0.2), projection };
        (camera.frame().is_ok() && eye.distance(target) > 0.1).then_some(camera)
    })
}

fn soup() -> impl Strategy<Value = TriangleMesh> {
    let triangles = prop::collection::vec(prop::array::uniform3(0u32..24), 1..60);
    (prop::collection::vec(point(1.0), 24), triangles)
        .prop_map(|(positions, triangles)| TriangleMesh::new(positions, triangles).expect("a surface"))
}

fn clip() -> impl Strategy<Value = Clip> {
    let plane = (point(1.0), -0.5..0.5).prop_map(|(normal, offset)| Plane { normal: normal + 0.01, offset });
    let crop = prop::option::of((point(1.0), 0.1..1.0).prop_map(|(low, edge)| (low, low + edge)));
    (crop, prop::collection::vec(plane, 0..2)).prop_map(|(crop, planes)| Clip { crop, planes })
}

/// Intersections of every triangle with a pixel's ray, by Cramer's rule (Möller & Trumbore, JGT 1997): distance, and how far inside of it.
fn hits(mesh: &TriangleMesh, view: &View, [x, y]: [u32; 2]) -> Vec<(f64, f64)> {
    let ray = Rays::new(view).unwrap().at(f64::from(x) + 0.5, f64::from(y) + 0.5);
    let hit = |triangle| {
        let [a, b, c] = mesh.corners(triangle);
        let (ab, ac, p) = (b - a, c - a, ray.direction.cross(c - a));
        let (from, recip) = (ray.origin - a, 1.0 / ab.dot(p));
        let (u, q) = (from.dot(p) * recip, from.cross(ab));
        let v = ray.direction.dot(q) * recip;
        (ac.dot(q) * recip, u.min(v).min(1.0 - u - v))
    };
    // Two corners in one place: nothing to meet.
    (0..mesh.triangles().len()).map(hit).filter(|(s, depth)| s.is_finite() && depth.is_finite()).collect()
}

/// Distances are those of a naive ray tracer, wherever it is sure of itself: rays that pass an edge or the clip's end by less than
/// 10⁻⁹ are left out, and so are triangles seen from the side.
#[test]
fn the_nearest_triangle_is_seen() {
    let seen = std::cell::Cell::new([0; 2]);
    check(300, &(soup(), camera(), clip()), |(mesh, camera, clip)| {
        let view = View { clip, ..View::new(camera, [23, 17]) };
        let layer = draw(&mesh, &view);
        let rays = Rays::new(&view).unwrap();
        for y in 0..17 {
            for x in 0..23 {
                let inside = rays.at(f64::from(x) + 0.5, f64::from(y) + 0.5).inside(&view.clip);
                let all = hits(&mesh, &view, [x, y]);
                let [start, end] = inside.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
                let near = |at: f64, of: f64| (at - of).abs() < 1e-9;
                if all.iter().any(|&(s, depth)| depth.abs() < 1e-9 || near(s, start) || near(s, end)) {
                    continue;
                }
                let met = all.iter().filter(|&&(s, depth)| depth > 0.0 && start < s && s < end);
                let nearest = met.fold(f64::INFINITY, |nearest, &(s, _)| nearest.min(s));
                let found = layer.depth((y * 23 + x) as usize);
                // Rounded to f32, by 6e-8 of itself; slivers seen from the side lose more in both computations.
                let agrees = found == nearest || (found - nearest).abs() < 1e-5 * nearest.max(1.0);
                prop_assert!(agrees, "({x}, {y}): found {found}, expected {nearest} of {all:?}");
                seen.set([seen.get()[0] + usize::from(nearest.is_finite()), seen.get()[1] + 1]);
            }
        }
        Ok(())
    });
    let [met, all] = seen.get();
    assert!(met > all / 8 && all > 100_000, "{met} of {all}: the test sees too little");
}

/// A net of n² squares, each cut in two, over [−1, 1]² at height 0 or as given; `lift` gives x, y and z of each knot.
fn net(n: u32, lift: impl Fn(f64, f64) -> DVec3) -> TriangleMesh {
    let along = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let knots = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    let positions = knots.map(|(i, j)| lift(along(i), along(j))).collect();
    let squares = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
    let halves = |k: u32| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]];
    TriangleMesh::new(positions, squares.flat_map(halves).collect()).expect("a surface")
}

/// Rays through knots and along edges: the knots lie on the centres of pixels, in the picture's own rows and columns.
#[test]
fn nothing_shines_through_edges_that_rays_run_along() {
    for (n, size) in [(8, 9), (16, 17), (8, 17), (32, 9)] {
        let mesh = net(n, |x, y| DVec3::new(x, y, 0.0));
        let pixel = 2.0 / f64::from(size - 1);
        let height = pixel * f64::from(size);
        for distance in [1.0, 3.0, 1e6] {
            let fov = 2.0 * (0.5 * height / distance).atan().to_degrees();
            for projection in [Projection::Orthographic { height }, Projection::Perspective { fov }] {
                let camera = Camera { eye: DVec3::Z * distance, target: DVec3::ZERO, up: DVec3::Y, projection };
                let layer = draw(&mesh, &View::new(camera, [size; 2]));
                let inner = |i: &usize| {
                    (1..size - 1).contains(&(*i as u32 % size)) && (1..size - 1).contains(&(*i as u32 / size))
                };
                let holes = (0..layer.pixels.len()).filter(inner).filter(|&i| layer.depth(i) == f64::INFINITY).count();
                assert_eq!(holes, 0, "{n} {size} {projection:?}");
            }
        }
    }
}

/// A crumpled sphere around the eye is seen wherever one looks, and from outside its silhouette has no holes.
#[test]
fn closed_surfaces_have_no_holes() {
    // The six faces of a cube, blown up to a sphere with bumps.
    let around = |n: u32, centre: DVec3, bump: f64| {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let first = positions.len() as u32;
                let face = net(n, |x, y| {
                    let mut p = DVec3::ZERO;
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, x, y);
                    let p = p.normalize();
                    // A knot is made from its own place alone: the same bits on all faces that share it.
                    centre + p * (1.0 + bump * (7.0 * p.x + 5.0 * p.y * p.z).sin() * (9.0 * p.z - 3.0 * p.y).cos())
                });
                positions.extend(face.positions());
                triangles.extend(face.triangles().iter().map(|t| t.map(|v| v + first)));
            }
        }
        TriangleMesh::new(positions, triangles).expect("a surface")
    };
    let strategy = (camera(), 1u32..40, 0.0..0.3, prop_oneof![Just(0.0), Just(1e3), Just(1e6)]);
    check(150, &strategy, |(camera, n, bump, far)| {
        let shift = DVec3::new(far, -far, 0.5 * far);
        let mesh = around(n, shift, bump);
        // From within: even a cube, of one square a side, has its faces at 0.57 of the radius, less the bumps.
        let eye = shift + 0.1 * camera.eye;
        let within = Camera { eye, target: eye + (camera.target - camera.eye), ..camera };
        let inside = View::new(within, [40, 40]);
        if matches!(camera.projection, Projection::Perspective { .. }) {
            let holes = draw(&mesh, &inside).pixels.iter().filter(|p| p.1 == f32::INFINITY).count();
            prop_assert_eq!(holes, 0);
        }
        Ok(())
    });
    // From outside, a convex one: every row is seen in one piece.
    check(100, &(camera(), 1u32..40), |(camera, n)| {
        let eye = camera.eye.normalize_or(DVec3::X) * 5.0;
        let view = View::new(Camera { eye, target: DVec3::ZERO, ..camera }, [64, 64]);
        let layer = draw(&around(n, DVec3::ZERO, 0.0), &view);
        for row in layer.pixels.chunks(64) {
            let ends = row.windows(2).filter(|w| (w[0].1 == f32::INFINITY) != (w[1].1 == f32::INFINITY)).count();
            prop_assert!(ends <= 2, "{} ends in a row", ends);
        }
        Ok(())
    });
}

#[test]
fn bits_do_not_depend_on_threads() {
    let mesh = net(150, |x, y| DVec3::new(x, y, 0.3 * (9.0 * x).sin() * (7.0 * y).cos()));
    let camera = Camera::framing(mesh.bounds(), 30.0, 40.0, Some(30.0));
    let view = View::new(camera, [133, 101]);
    let with = |threads| {
        let control = Control::default().with_threads(threads);
        Surface::new(mesh.clone()).layer(&[Light::default()], &view, &control).expect("a picture")
    };
    let one = with(1);
    assert!(one.pixels.iter().filter(|p| p.1.is_finite()).count() > 2000);
    for threads in [2, 3, 5] {
        assert_eq!(with(threads), one);
    }
}

#[test]
fn cancels() {
    let mesh = net(2, |x, y| DVec3::new(x, y, 0.0));
    let control = Control::default();
    control.cancel_flag().store(true, std::sync::atomic::Ordering::Relaxed);
    let view = View::new(Camera::framing(mesh.bounds(), 0.0, 0.0, None), [8, 8]);
    let outcome = Surface::new(mesh.clone()).layer(&[Light::default()], &view, &control);
    assert!(matches!(outcome, Err(vr_core::RenderError::Cancelled)));
}
