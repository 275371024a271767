//! Pick: what is seen at a place in the picture.

use glam::DVec3;
use serde::Serialize;
use vr_core::{Clip, Compositing, ParameterError, Rays, Scene, View, Volume};

use super::value_at::fill_values;

/// Parts of a voxel's edge between samples.
const STEP: f64 = 0.5;
/// Most samples of a ray.
const MAX_SAMPLES: usize = 4096;
/// Opacity below which nothing is seen.
const FAINT: f64 = 1e-3;

/// Heaviest sample of the ray through a place in the picture: the one that adds most to its opacity, or whose value the operator picks.
///
/// Samples lie half a voxel apart; opacity is that of the values alone, before any factor by gradient.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pick {
    /// World position of the sample.
    pub at: DVec3,
    /// Value there, without the codes that labels make of it.
    pub value: f64,
    /// Part of the ray's opacity that the sample adds, before the operator picks: 1 where one value is picked.
    pub share: f64,
}

impl Pick {
    /// Follows the ray through a place, in heights of the picture to the right of and above its middle.
    pub(super) fn of(
        (scene, values): (&Scene, &Volume),
        view: &View,
        place: [f64; 2],
    ) -> Result<Option<Self>, ParameterError> {
        if !place.iter().all(|c| c.is_finite()) {
            let found = format!("{place:?}");
            return Err(ParameterError { field: "pick".to_owned(), found, allowed: "must be finite" });
        }
        let [width, height] = view.size.map(f64::from);
        let ray = Rays::new(view)?.at(0.5 * width + place[0] * height, 0.5 * height - place[1] * height);
        // The stretch within the volume, the crop box and the planes.
        let (low, high) = scene.volume.bounds();
        let (crop_low, crop_high) = view.clip.crop.unwrap_or((low, high));
        let clip = Clip { crop: Some((low.max(crop_low), high.min(crop_high))), planes: view.clip.planes.clone() };
        let Some([start, end]) = ray.inside(&clip).filter(|[start, end]| end > start) else { return Ok(None) };
        let count = ((end - start) / (STEP * scene.volume.mean_spacing())).ceil().clamp(1.0, MAX_SAMPLES as f64);
        let step = (end - start) / count;
        let at: Vec<DVec3> =
            (0..count as usize).map(|i| ray.origin + ray.direction * (start + (i as f64 + 0.5) * step)).collect();
        let mut codes = vec![f64::NAN; at.len()];
        fill_values(&scene.volume, &at, &mut codes);
        let picked = match scene.compositing {
            Compositing::Maximum => codes.iter().enumerate().max_by(|a, b| ordered(*a.1, *b.1)).map(|(i, _)| (i, 1.0)),
            Compositing::Minimum => codes.iter().enumerate().max_by(|a, b| ordered(-a.1, -b.1)).map(|(i, _)| (i, 1.0)),
            Compositing::First { threshold } => codes.iter().position(|&v| v >= threshold).map(|i| (i, 1.0)),
            Compositing::Over | Compositing::Accumulate { .. } | Compositing::Average => heaviest(codes.iter().map(
                |&value| {
                    if value.is_nan() { 0.0 } else { scene.transfer.extinction_at(value) * step }
                },
            )),
        };
        let mut told = [f64::NAN];
        Ok(picked.and_then(|(i, share)| {
            fill_values(values, &at[i..=i], &mut told);
            (!told[0].is_nan()).then_some(Self { at: at[i], value: told[0], share })
        }))
    }
}

/// Order of values in which vacuum is below all.
fn ordered(a: f64, b: f64) -> std::cmp::Ordering {
    let low = |v: f64| if v.is_nan() { f64::NEG_INFINITY } else { v };
    low(a).total_cmp(&low(b))
}

/// The sample of these optical depths that adds most to the opacity, and its part of all of it; `None` where nothing is seen.
fn heaviest(depths: impl Iterator<Item = f64>) -> Option<(usize, f64)> {
    let (mut transmittance, mut best) = (1.0, (0, 0.0));
    for (i, depth) in depths.enumerate() {
        // Infinite depths are walls.
        let through = transmittance * (-depth).exp();
        let added = transmittance - through;
        if added > best.1 {
            best = (i, added);
        }
        transmittance = through;
    }
    let opacity = 1.0 - transmittance;
    (opacity > FAINT).then(|| (best.0, best.1 / opacity))
}
