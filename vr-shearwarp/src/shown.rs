//! The parts of a scene, besides its transfer function, that decide which voxels are encoded and with what.

use vr_core::{Compositing, Scene};

use crate::shear_warp::ShearWarp;
use crate::steepness::{reflects_by_interpolated_gradients, samples_filter_gradients};

/// Demands of a scene on its encoded volume.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Shown {
    /// True if light is integrated, and not a value picked.
    light: bool,
    /// Value at which a surface is shown.
    threshold: Option<f64>,
    /// True if samples reflect light by the codes of voxels' normals. The one surface of `first` has a gradient of its own.
    pub(crate) normals: bool,
    /// True if samples look at the gradients of voxels: opacity follows them, and they reflect light as well. They do the latter anyway where voxels have colours,
    /// which come before what reflects, and where values are those of the nearest voxels.
    pub(crate) gradients: bool,
    /// Factors on the extinction by the gradient, whose ever it is.
    factors: Vec<(f64, f64)>,
}

impl Shown {
    pub(crate) fn of(renderer: &ShearWarp, scene: &Scene) -> Self {
        let light = scene.compositing.integrates_light();
        let of_voxels = !samples_filter_gradients(scene);
        let reflects = light && of_voxels && scene.reflection().is_some();
        let follows = scene.has_gradient_opacity()
            || scene.volume.colors().is_some()
            || reflects_by_interpolated_gradients(renderer, scene);
        let threshold = match scene.compositing {
            Compositing::First { threshold } => Some(threshold),
            _ => None,
        };
        Self {
            light,
            threshold,
            normals: reflects && !follows,
            gradients: of_voxels && scene.has_gradient_opacity() || reflects && follows,
            factors: scene.shading.as_ref().map(|shading| shading.gradient_opacity.clone()).unwrap_or_default(),
        }
    }
}
