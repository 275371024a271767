//! Media whose opacity follows the length of the gradient.

use vr_core::{Calibration, Classification, Filter, GradientMethod, GridVolume, Scene, TransferFunction};

use crate::codes::Codes;
use crate::optics::Optics;
use crate::shear_warp::ShearWarp;

/// The medium at some lengths of the gradient, between which extinction and emission are linear: the rows of a transfer function, or the points of
/// the factor on the extinction.
pub(crate) struct Steepness {
    /// Lengths in [`unit()`]s, in ascending order.
    pub(crate) nodes: Vec<f64>,
    pub(crate) optics: Vec<Optics>,
}

impl Steepness {
    /// The media of a scene; one node for one whose opacity does not follow the gradient.
    pub(crate) fn new(scene: &Scene, volume: &GridVolume, codes: &Codes, classification: Classification) -> Self {
        let unit = unit(volume);
        let calibration = volume.calibration();
        let optics = |transfer| optics(transfer, calibration, codes, classification);
        if scene.transfer.has_rows() {
            let rows = scene.transfer.rows();
            return Self {
                nodes: rows.iter().map(|row| row.gradient / unit).collect(),
                optics: rows.iter().map(|row| optics(&row.transfer)).collect(),
            };
        }
        let base = optics(&scene.transfer);
        let points = scene.shading.as_ref().map_or(&[][..], |s| &s.gradient_opacity);
        if points.is_empty() || !scene.has_gradient_opacity() {
            return Self { nodes: vec![0.0], optics: vec![base] };
        }
        Self {
            nodes: points.iter().map(|p| p.0 / unit).collect(),
            optics: points.iter().map(|p| base.with_extinction_times(p.1)).collect(),
        }
    }
}

/// Tables of a transfer function.
pub(crate) fn optics(
    transfer: &TransferFunction,
    calibration: Calibration,
    codes: &Codes,
    classification: Classification,
) -> Optics {
    match classification {
        Classification::Post => Optics::of_values(transfer, calibration, codes),
        Classification::Pre => Optics::of_voxels(transfer, calibration, codes),
    }
}

/// The length of a gradient that counts as 1: the range of values over a voxel, so that no length is too large for an f32.
pub(crate) fn unit(volume: &GridVolume) -> f64 {
    let range = volume.value_range().map_or(0.0, |(low, high)| high - low);
    let unit = range / volume.placement().spacing().min_element();
    if unit > 0.0 && unit.is_finite() { unit } else { 1.0 }
}

/// True if samples look at the filter's own gradient, for opacity or for shading.
pub(crate) fn samples_filter_gradients(scene: &Scene) -> bool {
    scene.compositing.integrates_light() && looks_at_filter_gradients(scene)
}

/// True if samples, or surfaces that are met between them, look at the filter's own gradient.
pub(crate) fn looks_at_filter_gradients(scene: &Scene) -> bool {
    let looks = scene.reflection().is_some() || scene.has_gradient_opacity();
    looks && scene.gradient_shading().is_some_and(|shading| shading.gradient == GradientMethod::Analytic)
}

/// True if samples reflect light by central differences that are interpolated to them, and not by what the voxels around reflect.
///
/// Between the voxels of a smooth field the two differ by the square of a voxel. The nearest voxels are for labels and other fields that are not smooth, in which normals
/// turn by any angle from voxel to voxel, and the mean of what they reflect is no nearer to the reference in finer texels.
pub(crate) fn reflects_by_interpolated_gradients(renderer: &ShearWarp, scene: &Scene) -> bool {
    renderer.classification == Classification::Post && scene.volume.filter() == Some(Filter::Nearest)
}
