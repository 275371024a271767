//! Brute force: many samples of a field's values along a ray, no polynomials.

use glam::DVec3;
use vr_core::{Clip, Compositing, Ray, Scene};

/// The same scene by many samples along a ray.
pub fn brute(scene: &Scene, ray: &Ray) -> [f64; 4] {
    const SAMPLES: usize = 4000;
    let field = scene.volume.field().expect("no uniform grid");
    let inside = Clip { crop: Some(field.bounds()), ..Clip::default() };
    let Some([from, to]) = ray.inside(&inside).filter(|[a, b]| a < b) else { return [0.0; 4] };
    let h = (to - from) / SAMPLES as f64;
    let places = (0..SAMPLES).map(|k| ray.origin + ray.direction * (from + (k as f64 + 0.5) * h));
    let along = scene.shading.as_ref().map(|s| s.along::<f64>(&scene.lights, ray.direction));
    let samples: Vec<(DVec3, f64)> = places.filter_map(|at| Some((at, field.value(at)?))).collect();
    let picked = |v: f64| {
        let o = scene.transfer.at(v);
        [o.color[0] * o.opacity, o.color[1] * o.opacity, o.color[2] * o.opacity, o.opacity]
    };
    let values = samples.iter().map(|s| s.1);
    match scene.compositing {
        Compositing::Maximum => return picked(values.fold(f64::NEG_INFINITY, f64::max)),
        Compositing::Minimum => return picked(values.fold(f64::INFINITY, f64::min)),
        Compositing::Average => return picked(values.sum::<f64>() / samples.len() as f64),
        Compositing::First { threshold } => {
            let hit = samples.iter().find(|s| s.1 >= threshold);
            return hit.map_or([0.0; 4], |s| {
                let [r, g, b] = scene.transfer.at(s.1).color;
                [r, g, b, 1.0]
            });
        }
        _ => {}
    }
    let level = if let Compositing::Accumulate { level } = scene.compositing { level } else { 1.0 };
    let (mut rgb, mut alpha) = ([0.0; 3], 0.0);
    for (at, value) in samples {
        let mut color = scene.transfer.at(value).color;
        if let Some(along) = &along {
            let (factor, added) = along.reflect(field.gradient(at).unwrap().to_array());
            color = std::array::from_fn(|c| color[c] * factor[c] + added[c]);
        }
        let step: f64 = 1.0 - (-scene.transfer.extinction_at(value) * h).exp();
        let step = step.min((level - alpha) / (1.0 - alpha));
        for c in 0..3 {
            rgb[c] += (1.0 - alpha) * step * color[c];
        }
        alpha += (1.0 - alpha) * step;
    }
    [rgb[0], rgb[1], rgb[2], alpha]
}
