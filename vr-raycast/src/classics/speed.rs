//! Nanoseconds per ray, for comparing changes to a structure: `cargo test --release -p vr-raycast --lib classics::speed -- --ignored --nocapture`.

use std::time::{Duration, Instant};

use vr_core::phantom::{self, Blobs, Fog, Phantom, Shells, TRANSFER_UNIT_DISTANCE};
use vr_core::*;
use vr_kernels::ranges::RangeBlocks;

use super::tests::leapers;
use super::*;

const CHUNK: usize = 256;

#[test]
#[ignore = "prints times"]
fn nanoseconds_per_ray() {
    let scenes: [(&str, Box<dyn Phantom>); 3] =
        [("blobs", Box::new(Blobs::default())), ("shells", Box::new(Shells)), ("fog", Box::new(Fog::default()))];
    println!("| scene | structure | ns per ray | intervals per ray | bytes |\n|---|---|--:|--:|--:|");
    for (name, phantom) in scenes {
        let grid = phantom::sample::<u8>(phantom.as_ref(), [256; 3]).unwrap();
        let volume = Volume::from(grid);
        let points = phantom.transfer_points();
        let transfer = TransferFunction::new(points, OpacityRule::Power, TRANSFER_UNIT_DISTANCE).unwrap();
        let uniform = volume.grid().unwrap();
        let seen = Visibility::of_light(&transfer, uniform.calibration(), None, None);
        let ranges = RangeBlocks::of_volume(uniform, 8);
        let view = View::new(Camera::framing(volume.bounds(), 30.0, 20.0, None), [256, 256]);
        let rays = Rays::new(&view).unwrap();
        let pixels = (0..256u32 * 256).map(|i| rays.at(f64::from(i % 256) + 0.5, f64::from(i / 256) + 0.5));
        let parts: Vec<IndexRay> = pixels
            .filter_map(|ray| IndexRay::new(&ray, uniform.placement(), uniform.dims(), &view.clip, f64::INFINITY))
            .collect();
        for (structure, leaper) in leapers(uniform.dims(), &ranges, &seen) {
            // Few enough rays at a time for no other program to come in between, at least once.
            let mut best = vec![Duration::MAX; parts.len().div_ceil(CHUNK)];
            let mut intervals = 0;
            for _ in 0..15 {
                intervals = 0;
                for (chunk, best) in parts.chunks(CHUNK).zip(&mut best) {
                    let start = Instant::now();
                    for ray in chunk {
                        let mut from = ray.start;
                        while let Some((_, end)) = leaper.next(ray, from) {
                            intervals += 1;
                            from = end;
                        }
                    }
                    *best = start.elapsed().min(*best);
                }
            }
            let best: Duration = best.iter().sum();
            let rays = parts.len() as f64;
            let (ns, intervals) = (best.as_secs_f64() * 1e9 / rays, f64::from(intervals) / rays);
            println!("| {name} | {structure} | {ns:.0} | {intervals:.2} | {} |", leaper.bytes());
        }
    }
}
