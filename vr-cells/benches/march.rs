//! Time of a frame of tetrahedra, by their number.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use vr_cells::CellMarcher;
use vr_core::phantom;
use vr_core::*;

fn frames(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("march");
    group.sample_size(10);
    for side in [13, 33, 70] {
        let blobs = phantom::by_name("blobs").expect("a known phantom");
        let scene = phantom::sampled_scene::<u8>(&*blobs, side, 0.3).expect("a valid size");
        let mesh = CellMesh::of_grid(scene.volume.grid().expect("a grid")).expect("finite values");
        let cells = mesh.cells().len();
        let scene = Scene { volume: mesh.into(), ..scene };
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [512; 2]);
        let control = Control::default().with_threads(1);
        let mut prepared = CellMarcher::default().prepare(&scene, &control).expect("a mesh");
        group.throughput(Throughput::Elements(cells as u64));
        group.bench_function(BenchmarkId::new("cells", cells), |b| {
            b.iter(|| prepared.render(&view, &control).expect("it is drawn").frame)
        });
    }
    group.finish();
}

criterion_group!(benches, frames);
criterion_main!(benches);
