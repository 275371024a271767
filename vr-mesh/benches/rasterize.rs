//! A bumpy sphere of 10³ to 10⁶ triangles, and long slivers, in 512×512 pixels on one thread.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use vr_core::{Camera, Control, Light, Surfaces, TriangleMesh, View};
use vr_mesh::Surface;

/// A sphere of 2·n² triangles by longitude and latitude, or of slivers from pole to pole where `rings` is 2.
fn sphere(around: u32, rings: u32) -> TriangleMesh {
    let knot = |i: u32, j: u32| {
        let (longitude, latitude) = (f64::from(i % around) / f64::from(around), f64::from(j) / f64::from(rings));
        let (a, b) = (longitude * std::f64::consts::TAU, latitude * std::f64::consts::PI);
        DVec3::new(a.cos() * b.sin(), b.cos(), a.sin() * b.sin()) * (1.0 + 0.05 * (20.0 * a).sin() * (15.0 * b).sin())
    };
    let positions = (0..=rings).flat_map(|j| (0..around).map(move |i| knot(i, j))).collect();
    let squares = (0..rings).flat_map(|j| (0..around).map(move |i| [j * around + i, j * around + (i + 1) % around]));
    let halves = |[k, l]: [u32; 2]| [[k, l, l + around], [k, l + around, k + around]];
    TriangleMesh::new(positions, squares.flat_map(halves).collect()).expect("a sphere")
}

fn layers(c: &mut Criterion) {
    let control = Control::default().with_threads(1);
    let mut group = c.benchmark_group("512x512, one thread");
    group.sample_size(10);
    let meshes = [22, 70, 224, 707].map(|n| sphere(n, n)).into_iter().chain([sphere(10_000, 2)]);
    for (name, surface) in ["10^3", "10^4", "10^5", "10^6", "20k slivers"].into_iter().zip(meshes.map(Surface::new)) {
        for (word, fov) in [("parallel", None), ("perspective", Some(30.0))] {
            let view = View::new(Camera::framing(surface.bounds(), 30.0, 20.0, fov), [512, 512]);
            group.throughput(Throughput::Elements(surface.mesh.triangles().len() as u64));
            group.bench_function(format!("{name} {word}"), |b| {
                b.iter(|| surface.layer(&[Light::default()], &view, &control).expect("a layer"));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, layers);
criterion_main!(benches);
