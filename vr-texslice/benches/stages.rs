//! Time of pictures, by texture, slices and order, one thread: `cargo bench -p vr-texslice --bench stages`.
//!
//! Volumes of 128³ voxels; `VR_BENCH_SIZE=256` another size.

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, SamplingMode};
use vr_core::phantom::{self};
use vr_core::{Camera, Control, Renderer, Scene, View};
use vr_texslice::{DrawOrder, Format, Proxy, TextureSlicer};

fn scene(name: &str, n: usize) -> Scene {
    let phantom = phantom::by_name(name).expect("a known phantom");
    phantom::sampled_scene::<u8>(&*phantom, n, 1.0).expect("a valid size")
}

fn settings() -> Vec<(&'static str, TextureSlicer)> {
    let brute = TextureSlicer { slice_spacing: 1.0, ..TextureSlicer::brute_force() };
    let of = |format| TextureSlicer { format, ..brute.clone() };
    vec![
        ("planes", brute.clone()),
        ("planes, skipping and ending", TextureSlicer { slice_spacing: 1.0, ..TextureSlicer::default() }),
        ("shells", TextureSlicer { proxy: Proxy::Shells, ..brute.clone() }),
        ("stacks", TextureSlicer { proxy: Proxy::Stacks, ..brute.clone() }),
        ("pre-integrated", of(Format::PreIntegrated)),
        ("compressed", of(Format::Compressed)),
        ("rgba", of(Format::Rgba)),
        ("paletted", of(Format::Paletted)),
        ("bricks of 32", TextureSlicer { brick: Some(32), ..brute.clone() }),
        ("slice by slice", TextureSlicer { order: DrawOrder::Slices, ..brute }),
    ]
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args();
    let control = Control::default().with_threads(1);
    let n: usize = std::env::var("VR_BENCH_SIZE").ok().map_or(128, |n| n.parse().expect("a number"));
    for name in ["fog", "blobs"] {
        let scene = scene(name, n);
        let mut group = criterion.benchmark_group(format!("{name} {n}"));
        // Flat: the slowest take seconds.
        group.sample_size(10).sampling_mode(SamplingMode::Flat);
        group.warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
        for (projection, fov) in [("parallel", None), ("perspective", Some(30.0))] {
            let view = View::new(Camera::framing(scene.volume.bounds(), 20.0, 15.0, fov), [512; 2]);
            for (label, renderer) in settings() {
                let mut prepared = renderer.prepare(&scene, &control).expect("a scene that it can draw");
                // The first picture makes what is kept.
                prepared.render(&view, &control).expect("a view that it can draw");
                group.bench_function(BenchmarkId::new(label, projection), |b| {
                    b.iter(|| prepared.render(&view, &control).expect("a view that it can draw"));
                });
            }
        }
    }
    criterion.final_summary();
}
