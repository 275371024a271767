//! Measures what homogeneous steps save and cost: `cargo run --release --example homogeneity_gain`.
use std::time::Instant;

use vr_core::phantom::{self, sample};
use vr_core::*;
use vr_physics::Reference;
use vr_physics::metrics::{Metrics, subgrid};
use vr_raycast::{RayCaster, Step};

fn main() {
    let control = Control::default().with_threads(1);
    for (name, n) in [("fog", 128), ("fog", 256), ("blobs", 128), ("hydrogen", 128)] {
        let phantom = phantom::by_name(name).unwrap();
        let volume = Volume::from(sample::<u8>(&*phantom, [n; 3]).unwrap());
        let transfer =
            TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, phantom::TRANSFER_UNIT_DISTANCE);
        let scene = Scene::new(volume, transfer.unwrap());
        let view = View::new(Camera::framing(scene.volume.bounds(), 33.0, 21.0, None), [256, 256]);
        let pixels = subgrid(24, view.size);
        let truth = Reference::new(1e-7).solve_pixels(&scene, &view, &Model::Canonical, &pixels, &control).unwrap();
        let truth: Vec<[f64; 4]> = truth.pixels.iter().map(|p| p.rgba).collect();
        let mut casters =
            vec![("step 0.5".to_owned(), RayCaster { step: Step::Uniform(0.5), ..RayCaster::uniform(0.2) })];
        for error in [0.5, 0.2, 0.1, 0.05, 0.01] {
            let step = Step::Homogeneous { step: 0.5, error };
            casters.push((format!("homogeneity {error}"), RayCaster { step, ..RayCaster::uniform(0.2) }));
        }
        for (what, caster) in casters {
            let start = Instant::now();
            let mut prepared = caster.prepare(&scene, &control).unwrap();
            let prepare = start.elapsed();
            let mut best = f64::INFINITY;
            let mut picture = None;
            for _ in 0..3 {
                let start = Instant::now();
                picture = Some(prepared.render(&view, &control).unwrap());
                best = best.min(start.elapsed().as_secs_f64());
            }
            let picture = picture.unwrap();
            let drawn: Vec<[f32; 4]> = pixels.iter().map(|&[x, y]| picture.frame.pixel(x, y)).collect();
            let m = Metrics::of(&truth, &drawn);
            let counts = picture.stats.counts;
            println!(
                "{name} {n} {what:<18} {:>7.1} ms, prepare {prepare:.1?}, {:>6.1} steps a ray, max error {:.1e}, RMSE {:.1e}",
                1e3 * best,
                counts.samples as f64 / counts.rays as f64,
                m.max,
                m.rmse
            );
        }
    }
}
