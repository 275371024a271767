//! The scenes that every renderer is measured on: phantoms under their own transfer functions, seen from an oblique direction.

use vr_core::phantom::{self, TRANSFER_UNIT_DISTANCE};
use vr_core::{Camera, OpacityRule, Scene, TransferFunction, View};

/// A scene, its view, and the name that results go by.
pub struct PhantomScene {
    /// The phantom's name.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// The view of all of it.
    pub view: View,
}

/// Every phantom on a grid of `samples`³, in pictures of `pixels`².
///
/// # Panics
/// If `samples` is below 2.
pub fn phantom_scenes(samples: usize, pixels: u32) -> Vec<PhantomScene> {
    let scene = |&name: &&'static str| {
        let phantom = phantom::by_name(name).expect("a name from the list");
        let grid = phantom::sample::<f32>(&*phantom, [samples; 3]).expect("at least two samples along each axis");
        let transfer = TransferFunction::new(phantom.transfer_points(), OpacityRule::Power, TRANSFER_UNIT_DISTANCE);
        let scene = Scene::new(grid.into(), transfer.expect("points that ascend"));
        let camera = Camera::framing(scene.volume.bounds(), 30.0, 20.0, None);
        PhantomScene { name, view: View::new(camera, [pixels, pixels]), scene }
    };
    phantom::NAMES.iter().map(scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_phantom_makes_a_scene() {
        let scenes = phantom_scenes(3, 7);
        assert_eq!(scenes.len(), phantom::NAMES.len());
        for PhantomScene { name, scene, view } in scenes {
            assert!(scene.validate().is_ok() && view.validate().is_ok() && view.camera.frame().is_ok(), "{name}");
        }
    }
}
