//! Optics where the field has a gradient: opacity that follows its magnitude, and light that it reflects.

use std::sync::Arc;

use vr_core::{Scene, Shading, TransferFunction};
use vr_kernels::step_by_gradient;

use crate::voxel_optics::{OPAQUE, optics_of};

/// Optics of a scene that look at gradients.
pub(crate) struct GradientOptics<'a> {
    transfer: &'a TransferFunction,
    pub(crate) shading: Arc<Shading>,
    /// True if opacity follows the gradient's magnitude, by factors or by the rows of the transfer function.
    pub(crate) follows: bool,
    /// True if colours reflect light; emission given on its own does not.
    pub(crate) reflects: bool,
}

impl<'a> GradientOptics<'a> {
    /// The optics of a scene whose light is composited; `None` where no gradient has a part in them.
    pub(crate) fn new(scene: &'a Scene) -> Option<Self> {
        let reflects = scene.compositing.integrates_light() && scene.reflection().is_some();
        let follows = scene.has_gradient_opacity();
        let shading = scene.gradient_shading().filter(|_| reflects || follows)?;
        Some(Self { transfer: &scene.transfer, shading, follows, reflects })
    }

    /// Light and opacity of a homogeneous step of `length` world units, before it reflects, where the gradient has a magnitude.
    pub(crate) fn step(&self, value: f64, magnitude: f64, length: f64) -> [f64; 4] {
        step_by_gradient(self.transfer, &self.shading, [value, magnitude], length)
    }

    /// (q, κ) of a voxel, per world unit, before it reflects; an opaque one's κ is large, not infinite.
    pub(crate) fn of_voxel(&self, value: f64, magnitude: f64) -> [f64; 4] {
        if self.transfer.has_rows() {
            let medium = self.transfer.mixture(value, magnitude);
            let [r, g, b] = medium.emission;
            return [r, g, b, medium.extinction];
        }
        let [r, g, b, kappa] = optics_of(self.transfer, value);
        let thinned = (kappa * self.shading.modulation(magnitude)).min(OPAQUE / self.transfer.unit_distance());
        // Light of what absorbs goes with what absorbs.
        let share = if self.transfer.has_emission() || kappa == 0.0 { 1.0 } else { thinned / kappa };
        [r * share, g * share, b * share, thinned]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vr_core::phantom::{self};
    use vr_core::{ControlPoint, OpacityRule};

    /// A scene whose opacity has a factor by the gradient.
    fn scene(emission: Option<[f64; 3]>, factors: Vec<(f64, f64)>) -> Scene {
        let points = [(0.0, 0.2), (1.0, 0.7)]
            .map(|(v, a)| ControlPoint { emission, ..ControlPoint::new(v, [1.0, 0.5, 0.25], a) });
        let transfer = TransferFunction::new(points.to_vec(), OpacityRule::Power, 1.0).unwrap();
        let sphere = phantom::by_name("blobs").unwrap();
        let volume = phantom::sample::<u8>(&*sphere, [4; 3]).unwrap();
        let shading = Shading { gradient_opacity: factors, ..Shading::default() };
        Scene { shading: Some(shading.into()), ..Scene::new(volume.into(), transfer) }
    }

    #[test]
    fn thin_steps_are_the_voxel_times_their_length() {
        for emission in [None, Some([0.3, 0.2, 0.1])] {
            let scene = scene(emission, vec![(0.0, 0.0), (2.0, 1.5)]);
            let optics = GradientOptics::new(&scene).unwrap();
            assert!(optics.follows && optics.reflects == emission.is_none());
            for (value, magnitude) in [(0.1, 0.0), (0.5, 1.0), (0.9, 3.0)] {
                let length = 1e-7;
                let step = optics.step(value, magnitude, length).map(|x| x / length);
                let voxel = optics.of_voxel(value, magnitude);
                // Of so thin a step the square of its depth is left out: 10⁻⁷ of it.
                assert!((0..4).all(|c| (step[c] - voxel[c]).abs() < 1e-6), "{step:?} for {voxel:?}");
                // The factor is 0 without a gradient, and 1.5 at most.
                let plain = optics_of(&scene.transfer, value);
                let factor = (0.75 * magnitude).min(1.5);
                assert!((voxel[3] - plain[3] * factor).abs() < 1e-12);
                let light = if emission.is_some() { plain[0] } else { plain[0] * factor };
                assert!((voxel[0] - light).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn no_gradient_is_asked_for_in_vain() {
        let plain = Scene { shading: None, ..scene(None, Vec::new()) };
        assert!(GradientOptics::new(&plain).is_none());
        assert!(GradientOptics::new(&scene(Some([1.0; 3]), Vec::new())).is_none());
        assert!(GradientOptics::new(&scene(None, Vec::new())).is_some_and(|o| o.reflects && !o.follows));
    }
}
