//! Meshes of cells: along a ray they are what they are at its places, and no ray falls into a crack.

use glam::DVec3;
use proptest::prelude::*;
use vr_core::cells::{CellMesh, CellValues, NO_CELL};
use vr_core::{Calibration, Clip, Field, Filter, GridVolume, Placement, Plane, Ray, UniformGrid};

/// A lattice of n³ cubes of six cells each, its inner vertices moved by up to `jitter` steps.
fn mesh(n: usize, jitter: f64, seed: u64, of_cells: bool) -> CellMesh {
    let dims = [n + 1; 3];
    let mut state = seed | 1;
    let mut random = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 40) as f64 / (1u64 << 24) as f64 - 0.5
    };
    let count = dims.iter().product();
    let samples: Vec<f32> = (0..count).map(|_| 10.0 * random() as f32).collect();
    let grid = UniformGrid::new(dims, samples, Placement::from_spacing([1.0; 3]).unwrap(), Calibration::default());
    let plain = CellMesh::of_grid(&GridVolume::new(grid.unwrap().into(), Filter::Trilinear)).unwrap();
    let vertices: Vec<DVec3> = plain
        .vertices()
        .iter()
        .map(|&v| {
            let inner = (0..3).all(|a| v[a] > 0.0 && v[a] < n as f64);
            let moved = DVec3::new(random(), random(), random()) * (2.0 * jitter);
            if inner { v + moved } else { v }
        })
        .collect();
    let values = if of_cells {
        CellValues::Cells(plain.cells().iter().map(|_| random()).collect())
    } else {
        plain.values().clone()
    };
    let made = CellMesh::new(vertices, plain.cells().to_vec(), values).unwrap();
    assert!(made.repairs().is_empty(), "{:?}", made.repairs());
    made
}

fn unit(of: [f64; 3]) -> Option<DVec3> {
    DVec3::from(of).try_normalize()
}

/// Checks a line against the values at places, and returns the length of what is no vacuum.
fn check(mesh: &CellMesh, ray: &Ray, clip: &Clip) -> f64 {
    let Some(line) = mesh.along(ray, clip, f64::INFINITY, true) else { return 0.0 };
    let (chord, mut breaks) = (line.chord(), Vec::new());
    line.breakpoints(&mut breaks);
    assert!(breaks.windows(2).all(|w| w[0] < w[1]), "{breaks:?}");
    assert_eq!((breaks[0], breaks[breaks.len() - 1]), (chord.start, chord.end));
    let mut length = 0.0;
    for w in breaks.windows(2) {
        let Some(model) = line.between(w[0], w[1]) else { continue };
        length += w[1] - w[0];
        for t in [0.1, 0.5, 0.83] {
            let s = w[0] + t * (w[1] - w[0]);
            let at = ray.origin + ray.direction * (chord.offset + s);
            // In a sliver, rounding of the place decides on which side of a face it is.
            let Some(value) = mesh.value(at) else { continue };
            let found = model.field.at(2.0 * t - 1.0);
            assert!(
                (found - value).abs() <= model.field_error + 1e-9,
                "{found} for {value} at {at} ± {}",
                model.field_error
            );
            if let (Some(along), Some(gradient)) = (model.gradient, mesh.gradient(at)) {
                let found = DVec3::from(along.map(|g| g.at(2.0 * t - 1.0)));
                assert!((found - gradient).length() <= 3.0 * model.gradient_error + 1e-8, "{found} for {gradient}");
            }
        }
        assert!(model.field_error < 1e-6, "a bound that says something: {}", model.field_error);
    }
    length
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(19), failure_persistence: None, ..ProptestConfig::with_cases(300)
    })]

    /// Random rays through random meshes: the values of places, and not a crack.
    #[test]
    fn lines_agree_with_places(
        from in prop::array::uniform3(-1.0f64..5.0), to in prop::array::uniform3(0.0f64..3.0), seed in 0u64..40, of_cells: bool,
        offset in -0.5f64..3.0, clipped: bool,
    ) {
        let mesh = mesh(3, 0.2, seed, of_cells);
        let Some(direction) = unit([to[0] - from[0], to[1] - from[1], to[2] - from[2]]) else { return Ok(()) };
        let ray = Ray { origin: from.into(), direction };
        let planes = if clipped { vec![Plane { normal: DVec3::new(0.3, 0.5, -0.8), offset: offset - 1.0 }] } else { vec![] };
        let clip = Clip { planes, ..Clip::default() };
        let length = check(&mesh, &ray, &clip);
        // What the ray has inside the box.
        let whole = Clip { crop: Some((DVec3::ZERO, DVec3::splat(3.0))), ..clip };
        let expected = ray.inside(&whole).map_or(0.0, |[a, b]| b - a);
        prop_assert!((length - expected).abs() < 1e-9, "{length} of {expected}");
    }
}

/// Rays along the faces, edges and diagonals of a mesh, where rounding decides which cell is met.
#[test]
fn rays_along_faces_meet_no_crack() {
    let mesh = mesh(4, 0.0, 5, false);
    let directions: Vec<DVec3> = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [1, 0, 1], [0, 1, 1], [1, 1, 1]]
        .map(|d: [i32; 3]| DVec3::from(d.map(f64::from)).normalize())
        .to_vec();
    for &direction in &directions {
        for start in 0..125 {
            let lattice = DVec3::new((start % 5) as f64, (start / 5 % 5) as f64, (start / 25) as f64);
            // Through vertices, along edges and faces, and through the middles of edges.
            for shift in [DVec3::ZERO, DVec3::new(0.5, 0.5, 0.0), DVec3::new(0.25, 0.25, 0.25)] {
                let ray = Ray { origin: lattice + shift - direction * 9.0, direction };
                let inside = Clip { crop: Some((DVec3::ZERO, DVec3::splat(4.0))), ..Clip::default() };
                let expected = ray.inside(&inside).map_or(0.0, |[a, b]| b - a);
                let length = check(&mesh, &ray, &Clip::default());
                // A ray in the surface itself, or off it by rounding, may be outside.
                let outside = |x: f64| x <= 1e-12 || x >= 4.0 - 1e-12;
                let middle = ray.inside(&inside).map_or(DVec3::ZERO, |[a, b]| ray.origin + direction * (0.5 * (a + b)));
                let in_surface = middle.to_array().into_iter().any(outside);
                assert!(
                    (length - expected).abs() < 1e-9 || (in_surface && length < 1e-9),
                    "{ray:?}: {length} of {expected}"
                );
            }
        }
    }
}

/// Cells that do not touch: vacuum between them begins and ends where their faces are.
#[test]
fn vacuum_is_between_cells() {
    let corner = |at: f64| [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|v| v + at * DVec3::Z);
    let vertices = [corner(0.0), corner(5.0)].concat();
    let values = CellValues::Vertices((0..8).map(f64::from).collect());
    let mesh = CellMesh::new(vertices, vec![[0, 1, 2, 3], [4, 5, 6, 7]], values).unwrap();
    assert_eq!(mesh.neighbours(), [[NO_CELL; 4]; 2]);
    let ray = Ray { origin: DVec3::new(0.25, 0.25, -3.0), direction: DVec3::Z };
    assert!((check(&mesh, &ray, &Clip::default()) - 1.0).abs() < 1e-12);
    let mut jumps = Vec::new();
    mesh.jumps(&ray, [0.0, 100.0], &mut jumps);
    let expected = [3.0, 3.5, 8.0, 8.5];
    assert!(jumps.len() == 4 && jumps.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{jumps:?}");
    let line = mesh.along(&ray, &Clip::default(), f64::INFINITY, false).unwrap();
    let mut cuts = Vec::new();
    line.cuts(&mut cuts);
    assert_eq!(cuts.len(), 2, "it comes out of vacuum twice");
}

/// A mesh far from the world's origin, seen from far away.
#[test]
fn far_meshes_keep_their_digits() {
    let near = mesh(3, 0.2, 7, false);
    let away = DVec3::new(1e6, -3e6, 2e6);
    let vertices = near.vertices().iter().map(|&v| v + away).collect();
    let far = CellMesh::new(vertices, near.cells().to_vec(), near.values().clone()).unwrap();
    let direction = DVec3::new(0.3, 0.9, -0.4).normalize();
    let ray = Ray { origin: away + DVec3::splat(1.4) - direction * 1e7, direction };
    let line = far.along(&ray, &Clip::default(), f64::INFINITY, false).unwrap();
    let mut breaks = Vec::new();
    line.breakpoints(&mut breaks);
    assert!((breaks[breaks.len() - 1] - breaks[0] - 3.3).abs() < 1.0);
    for w in breaks.windows(2) {
        let model = line.between(w[0], w[1]).expect("no crack");
        let at = ray.origin + ray.direction * (line.chord().offset + 0.5 * (w[0] + w[1]));
        let value = near.value(at - away).unwrap();
        // Rounding of the place moves it by 1e-9 here, and slopes are below 100.
        assert!((model.field.at(0.0) - value).abs() <= model.field_error + 1e-6);
    }
}
