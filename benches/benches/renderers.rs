//! One frame of every scene with every renderer, at its defaults, after `prepare`.
//!
//! A renderer's own bench, in its crate, tells where its time goes; this one tells how they compare. Speed alone says little:
//! `vr compare` puts the error beside it.

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use vr_core::{Control, Renderer};
use vr_physics::Reference;
use vr_raycast::RayCaster;
use vr_shearwarp::ShearWarp;
use vr_splat::Splatter;
use vr_study::subject::{Subject, phantom_subjects};
use vr_texslice::TextureSlicer;

fn frames(c: &mut Criterion) {
    let control = Control::default();
    let renderers: [(Box<dyn Renderer>, u32); 5] = [
        (Box::new(RayCaster::default()), 128),
        (Box::new(ShearWarp::default()), 128),
        (Box::new(TextureSlicer::default()), 128),
        (Box::new(Splatter::default()), 128),
        (Box::new(Reference::default()), 32),
    ];
    for (renderer, pixels) in renderers {
        let mut group = c.benchmark_group(format!("{} {pixels}x{pixels}", renderer.name()));
        group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
        for Subject { name, scene, view, .. } in phantom_subjects(64, [pixels; 2]).expect("enough samples") {
            let mut prepared = renderer.prepare(&scene, &control).expect("every renderer draws phantoms");
            group.bench_function(&name, |b| b.iter(|| prepared.render(&view, &control).expect("a frame")));
        }
    }
}

criterion_group!(benches, frames);
criterion_main!(benches);
