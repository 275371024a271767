//! Time of pictures with a promised error, and of plain ones: `cargo run --release --example promise_time [size]`.
use std::time::Instant;

use vr_core::phantom::{self, sample};
use vr_core::*;
use vr_raycast::{RayCaster, Step};

fn main() {
    let size: u32 = std::env::args().nth(1).map_or(512, |s| s.parse().unwrap());
    let control = Control::default().with_threads(1);
    for (name, n) in [("marschner-lobb", 64), ("marschner-lobb", 128), ("fog", 128), ("blobs", 128)] {
        let phantom = phantom::by_name(name).unwrap();
        let grid = sample::<u8>(&*phantom, [n; 3]).unwrap();
        let volume = Volume::from(grid);
        let transfer =
            TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE)
                .unwrap();
        let scene = Scene::new(volume, transfer);
        let camera = Camera::framing(scene.volume.bounds(), 33.0, 21.0, None);
        let view = View::new(camera, [size, size]);
        let mut casters = vec![("step 0.2".to_owned(), RayCaster::uniform(0.2))];
        for e in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
            casters
                .push((format!("promise {e:e}"), RayCaster { step: Step::ErrorBound(e), ..RayCaster::uniform(0.2) }));
        }
        for (what, caster) in casters {
            let start = Instant::now();
            let mut prepared = caster.prepare(&scene, &control).unwrap();
            let prepare = start.elapsed();
            let mut best = f64::INFINITY;
            let mut counts = Counts::default();
            for _ in 0..3 {
                let start = Instant::now();
                counts = prepared.render(&view, &control).unwrap().stats.counts;
                best = best.min(start.elapsed().as_secs_f64());
            }
            println!(
                "{name} {n} {what:<16} {:>8.1} ms, prepare {prepare:.1?}, {:.1} steps a ray, repeated {} of {}, unbounded {}",
                1e3 * best,
                counts.samples as f64 / counts.rays as f64,
                counts.repeated,
                counts.rays,
                counts.unbounded
            );
        }
    }
}
