//! Light of scattered points that are classified before they are splatted, where it depends on the gradient of their sum.

use std::sync::Arc;

use fearless_simd::Level;
use glam::DVec3;
use vr_core::cancel;
use vr_core::parallel::collect;
use vr_core::{ParameterError, PointSet, Scene, View};
use vr_kernels::vector::{LANES, PacketLights};

use crate::gradient_optics::GradientOptics;
use crate::sample_shader::{LitSample, SampleShader};
use crate::shading::point_shading;
use crate::sight::Sight;

/// Gradients of a sum of points at the points' own places, in value per world unit.
pub(crate) struct GradientsAtPoints(Vec<DVec3>);

impl GradientsAtPoints {
    /// Makes them when first asked for; the points keep them.
    pub(crate) fn of(points: &PointSet) -> Arc<Self> {
        let gradient = |k: usize| points.gradient(points.positions()[k]).unwrap_or_default();
        points.derived().get((), || {
            cancel::claim("the gradients at points", (points.count() * size_of::<DVec3>()) as u64);
            Self(collect(points.count(), gradient))
        })
    }
}

/// Points that a thread takes at once.
const CHUNK: usize = 1 << 10;

/// (q, κ) of each visible point in a view, per world unit: shaded, and with the opacity that the gradient at its place leaves it. `None` where the value
/// alone decides.
pub(crate) fn point_lights(
    scene: &Scene,
    points: &PointSet,
    visible: &[u32],
    view: &View,
    level: Level,
) -> Result<Option<Vec<[f32; 4]>>, ParameterError> {
    let Some(optics) = GradientOptics::new(scene) else { return Ok(None) };
    let packet = point_shading(&optics, scene, points);
    let shader = SampleShader { optics: &optics, packet, sight: Sight::new(view)?, level };
    let (gradients, unit) = (GradientsAtPoints::of(points), points.mean_spacing());
    let sample = |&k: &u32| {
        let k = k as usize;
        LitSample {
            value: f64::from(points.values()[k]),
            gradient: (gradients.0[k] * unit).to_array(),
            magnitude: gradients.0[k].length(),
            place: points.positions()[k],
            tint: [1.0; 3],
        }
    };
    let one = |chunk: usize| -> Vec<[f32; 4]> {
        let last = visible.len().min((chunk + 1) * CHUNK);
        let samples: Vec<LitSample> = visible[chunk * CHUNK..last].iter().map(sample).collect();
        let mut lights = PacketLights::default();
        samples.chunks(LANES).flat_map(|some| shader.rows(some, &mut lights)).collect()
    };
    Ok(Some(collect(visible.len().div_ceil(CHUNK), one).concat()))
}
