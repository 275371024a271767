//! The march along a ray.

use glam::DVec3;
use vr_core::filter::Reconstruction;
use vr_core::optics::{opacity_of_depth, source_weight};
use vr_core::transfer::Optical;
use vr_core::{Clip, Field, GridVolume, IndexRay, Ray, Sampler, SamplerVisitor, Scene, TransferFunction, Voxel};

use super::Marcher;
use super::classify::{classified, classified_before};
use super::fault::Fault;

/// Light and opacity of a ray.
pub(super) fn light(marcher: &Marcher, scene: &Scene, ray: &Ray, clip: &Clip) -> [f64; 4] {
    match (scene.volume.grid(), scene.volume.field()) {
        (Some(volume), _) => {
            let along = IndexRay::new(ray, volume.placement(), volume.dims(), clip, f64::INFINITY);
            along.map_or([0.0; 4], |ray| volume.with_sampler(GridMarch { marcher, volume, scene, ray }))
        }
        (None, Some(field)) => through_field(marcher, field, &scene.transfer, ray, clip),
        (None, None) => [0.0; 4],
    }
}

struct GridMarch<'a> {
    marcher: &'a Marcher,
    volume: &'a GridVolume,
    scene: &'a Scene,
    ray: IndexRay,
}

impl SamplerVisitor for GridMarch<'_> {
    type Output = [f64; 4];

    fn visit<T: Voxel, F: Reconstruction>(self, sampler: Sampler<'_, T, F>) -> [f64; 4] {
        let Self { marcher: &Marcher { fault, .. }, volume, scene, ray } = self;
        let (spacing, calibration) = (volume.placement().spacing(), volume.calibration());
        let optical_at = |s: f64| {
            let mut p = ray.at(s).to_array();
            if fault == Fault::HalfVoxelShift {
                p = std::array::from_fn(|a| (p[a] - 0.5).max(0.0));
            }
            let value = present(fault, sampler.value(p))?;
            Some(if fault == Fault::PreClassification {
                classified_before(&sampler, p, |stored| scene.transfer.at(calibration.value(stored)))
            } else {
                classified(fault, &scene.transfer, calibration.value(value))
            })
        };
        let spacing = if fault == Fault::SwappedSpacing { spacing.x } else { spacing.min_element() };
        marched(&scene.transfer, [ray.start, ray.end], self.marcher, spacing, optical_at)
    }
}

fn through_field(
    marcher: &Marcher,
    field: &dyn Field,
    transfer: &TransferFunction,
    ray: &Ray,
    clip: &Clip,
) -> [f64; 4] {
    let (low, high) = field.bounds();
    let whole = Clip { crop: Some((low, high)), ..Clip::default() };
    let (Some(a), Some(b)) = (ray.inside(&whole), ray.inside(clip)) else { return [0.0; 4] };
    let (fault, spacing) = (marcher.fault, field.spacing());
    let optical_at = |s: f64| {
        let mut at = ray.origin + ray.direction * s;
        if fault == Fault::HalfVoxelShift {
            at = (at - DVec3::splat(0.5 * spacing)).max(low);
        }
        let value = present(fault, field.value(at.clamp(low, high)).unwrap_or(f64::NAN))?;
        Some(classified(fault, transfer, value))
    };
    marched(transfer, [a[0].max(b[0]), a[1].min(b[1])], marcher, spacing, optical_at)
}

/// The value, if there is one.
fn present(fault: Fault, value: f64) -> Option<f64> {
    let value = if fault == Fault::MissingIsZero && value.is_nan() { 0.0 } else { value };
    (!value.is_nan()).then_some(value)
}

/// Adds up the light of steps between two distances; `optical_at` tells what is there, `None` in vacuum.
fn marched(
    transfer: &TransferFunction,
    [mut start, last]: [f64; 2],
    &Marcher { fault, step }: &Marcher,
    spacing: f64,
    optical_at: impl Fn(f64) -> Option<Optical>,
) -> [f64; 4] {
    // With an end to it in a huge world.
    let step = step * if fault == Fault::WorldStep { (1e-2 * (last - start)).max(1.0) } else { spacing };
    let (mut rgba, mut transmittance) = ([0.0; 4], 1.0);
    while start < last {
        let end = (start + step).min(last);
        let length = end - start;
        if fault == Fault::DroppedLastStep && length < step * (1.0 - 1e-9) {
            break;
        }
        let at = if fault == Fault::LeftSample { start } else { 0.5 * (start + end) };
        start = end;
        let Some(optical) = optical_at(at) else { continue };
        let length = if fault == Fault::NoOpacityCorrection { transfer.unit_distance() } else { length };
        let tau = transfer.extinction(optical.opacity) * length;
        let alpha = opacity_of_depth(tau);
        for c in 0..3 {
            let light = if transfer.has_emission() {
                optical.emission[c] * length * source_weight(tau)
            } else {
                optical.color[c] * alpha
            };
            rgba[c] += transmittance * light;
        }
        transmittance *= 1.0 - alpha;
    }
    rgba[3] = 1.0 - transmittance;
    rgba
}
