//! Shading, of parallel rays by a table of normals and in perspective by each ray's own direction, against the reference.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;
use vr_core::phantom;
use vr_core::*;
use vr_physics::{Reference, Solution};
use vr_shearwarp::ShearWarp;

/// A shaded phantom, lit from the eye and, in another colour, from the side.
fn scene(name: &str, samples: usize, opacity: f64) -> Scene {
    let phantom: Box<dyn phantom::Phantom> = phantom::by_name(name).expect("a known phantom");
    let mut scene = phantom::sampled_scene::<u8>(&*phantom, samples, opacity).expect("a valid size");
    scene.shading = Some(Arc::new(Shading { specular: 0.8, power: 20.0, ..Shading::default() }));
    scene.lights = vec![
        Light { direction: None, color: [0.8; 3] },
        Light { direction: Some(DVec3::new(0.4, 1.0, 0.3)), color: [0.1, 0.3, 0.6] },
    ];
    scene
}

fn view(scene: &Scene, size: u32, fov: Option<f64>) -> View {
    View::new(Camera::framing(scene.volume.bounds(), 25.0, 15.0, fov), [size; 2])
}

fn root_mean_square(frame: &Frame, truth: &Solution) -> f64 {
    let off =
        |(got, want): (&[f32; 4], [f64; 4])| -> f64 { (0..4).map(|c| (f64::from(got[c]) - want[c]).powi(2)).sum() };
    let sum: f64 = frame.pixels().iter().zip(truth.pixels.iter().map(|p| p.rgba)).map(off).sum();
    (sum / frame.pixels().len() as f64 / 4.0).sqrt()
}

#[test]
fn shading_in_perspective_is_as_near_as_of_parallel_rays() {
    let control = Control::default();
    let scene = scene("hydrogen", 24, 0.5);
    for renderer in [ShearWarp::default(), ShearWarp::classic()] {
        let renderer = ShearWarp { texel: 0.25, slice_distance: 2.0, termination: 1.0, ..renderer };
        let errors = [None, Some(50.0)].map(|fov| {
            let view = view(&scene, 24, fov);
            let mut prepared = renderer.prepare(&scene, &control).unwrap();
            let frame = prepared.render(&view, &control).unwrap().frame;
            let error = |model: &Model| {
                root_mean_square(&frame, &Reference::new(1e-5).solve(&scene, &view, model, &control).unwrap())
            };
            [error(&prepared.model(&view).unwrap()), error(&Model::Canonical)]
        });
        println!("{:?}: its model and the canonical pixel: {errors:.4?}", renderer.classification);
        let [[parallel, canonical], [perspective, canonical_in_perspective]] = errors;
        // Measured, both ways to classify: 0.0003 and 0.0004 of its model; 0.005 and 0.004 at most of the canonical pixel, whose gradients are
        // interpolated, and not what they reflect.
        assert!(perspective < 2.0 * parallel && perspective < 0.001, "{errors:?}");
        assert!(canonical_in_perspective < 1.5 * canonical && canonical_in_perspective < 0.008, "{errors:?}");
    }
}

/// Times of shaded pictures in perspective over those of parallel rays, and of unshaded ones.
#[test]
#[ignore = "it measures time"]
fn time_of_shading_in_perspective() {
    let control = Control::default().with_threads(1);
    for name in ["blobs", "hydrogen"] {
        let shaded = scene(name, 128, 1.0);
        let plain = Scene { shading: None, ..shaded.clone() };
        for renderer in [ShearWarp::default(), ShearWarp::classic()] {
            let mut ways: Vec<_> = [(&shaded, None), (&shaded, Some(30.0)), (&plain, None), (&plain, Some(30.0))]
                .into_iter()
                .map(|(scene, fov)| (renderer.prepare(scene, &control).unwrap(), view(scene, 256, fov), Duration::MAX))
                .collect();
            for _ in 0..12 {
                for (prepared, view, best) in &mut ways {
                    let begin = Instant::now();
                    prepared.render(view, &control).unwrap();
                    *best = (*best).min(begin.elapsed());
                }
            }
            let [shaded, seen, plain, plain_seen] = [0, 1, 2, 3].map(|i| ways[i].2.as_secs_f64() * 1e3);
            println!(
                "{name} {:?}: shaded {shaded:.2} ms, in perspective {seen:.2} ms, {:.2}; plain {plain:.2} ms, {plain_seen:.2} ms, {:.2}",
                renderer.classification,
                seen / shaded,
                plain_seen / plain
            );
        }
    }
}
