//! Shading, as vector code wants it, and the most light that there can be.

use std::sync::Arc;

use vr_core::{GridVolume, Scene};
use vr_kernels::vector::PacketShading;

use crate::draw::Brightest;
use crate::support::shades;

/// The scene's shading for a texture with such an order of axes.
pub(crate) fn packet_shading(scene: &Scene, volume: &GridVolume, axes: [usize; 3]) -> Option<PacketShading> {
    let shading = Arc::clone(scene.shading.as_ref()?);
    // A gradient's length does not matter: scaled to 1, so that worlds of any scale neither overflow nor vanish.
    let matrix = volume.placement().inverse_axes().transpose();
    let largest = matrix.to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let to_world = std::array::from_fn(|row| axes.map(|a| (matrix.col(a)[row] / largest) as f32));
    Some(PacketShading { shading, lights: scene.lights.clone(), to_world })
}

/// The most light that a fragment can send.
pub(crate) fn brightest(scene: &Scene) -> Brightest {
    if scene.transfer.has_emission() {
        return Brightest::Emission(scene.transfer.brightest_emission());
    }
    let color = scene.transfer.brightest_color();
    let Some(shading) = scene.shading.as_ref().filter(|_| shades(scene)) else { return Brightest::Radiance(color) };
    let light = |c: usize| scene.lights.iter().map(|l| l.color[c]).sum::<f64>();
    let lights = light(0).max(light(1)).max(light(2));
    // Where the gradient is zero, the colour stays.
    Brightest::Radiance(color * (shading.ambient + shading.diffuse * lights).max(1.0) + shading.specular * lights)
}
