//! Estimators of transmittance: time of one estimate, and variance · time, by which they compare: the time that a given error takes.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use glam::DVec3;
use vr_core::scattering::{PhaseFunction, Scattering};
use vr_core::{Clip, Ray, phantom};
use vr_light::{Coefficients, FunctionMedium, RandomStream, SceneMedium, TrackedMedium, TransmittanceEstimator};

/// Estimates by which the variance is told.
const COUNT: u64 = 20_000;

/// Media by name: the phantom fog on a grid, and a wall of high contrast among vacuum.
fn media() -> [(&'static str, TrackedMedium); 2] {
    let fog = phantom::by_name("fog").and_then(|fog| fog.scene(64).ok()).expect("there is a fog");
    let fog = SceneMedium::new(&fog, &Clip::default(), &Scattering::default()).expect("it scatters");
    let wall = |p: DVec3| if (0.1..0.12).contains(&p.x) { 50.0 } else { 0.0 };
    let holes =
        FunctionMedium::new((DVec3::NEG_ONE, DVec3::ONE), 1, PhaseFunction::Isotropic, [0.0, 50.0], move |p, _, _| {
            Coefficients { absorption: wall(p), ..Coefficients::default() }
        });
    let range = |low: DVec3, high: DVec3| if low.x < 0.12 && high.x > 0.1 { [0.0, 50.0] } else { [0.0; 2] };
    let holes = holes.expect("it has bounds").with_ranges([16, 1, 1], range);
    [("fog", TrackedMedium::new(Arc::new(fog))), ("holes", TrackedMedium::new(Arc::new(holes)))]
}

fn transmittance(criterion: &mut Criterion) {
    let ray = Ray { origin: DVec3::new(-2.0, 0.1, 0.2), direction: DVec3::X };
    for (name, medium) in media() {
        let mut group = criterion.benchmark_group(format!("transmittance of {name}"));
        for estimator in TransmittanceEstimator::ALL {
            let estimate = |sample| {
                let mut random = RandomStream::new(1, 0, sample);
                medium.transmittance(black_box(&ray), f64::INFINITY, 0, estimator, &mut random)
            };
            let (started, mut sum, mut squares) = (Instant::now(), 0.0, 0.0);
            for sample in 0..COUNT {
                let value = estimate(sample);
                sum += value;
                squares += value * value;
            }
            let nanoseconds = started.elapsed().as_secs_f64() * 1e9 / COUNT as f64;
            let mean = sum / COUNT as f64;
            let variance = squares / COUNT as f64 - mean * mean;
            println!(
                "{name}, {estimator:?}: mean {mean:.5}, variance {variance:.2e}, variance·time {:.2e} ns",
                variance * nanoseconds
            );
            let mut sample = 0;
            group.bench_function(format!("{estimator:?}"), |bencher| {
                bencher.iter(|| {
                    sample += 1;
                    estimate(sample)
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, transmittance);
criterion_main!(benches);
