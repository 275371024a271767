//! A scene and a view of it, printed as a scene file.

use vr_core::{Scene, View};
use vr_io::{SceneFile, scene_text};

/// A scene and a view of it. `{:?}` prints a scene file with the voxels inline, so that the scene of a failing property test can
/// be drawn by `vr render --scene`.
#[derive(Clone)]
pub struct TestScene {
    /// The scene.
    pub scene: Scene,
    /// The view of it.
    pub view: View,
}

impl TestScene {
    /// The text of the scene file.
    ///
    /// # Errors
    /// A scene that no scene file can hold: more than 64³ voxels or 4096 points, volumes that are neither. (A layer is left out.)
    pub fn scene_file(&self) -> Result<String, Box<dyn std::error::Error>> {
        Ok(scene_text(&SceneFile::describe(&self.scene, &self.view)?)?)
    }
}

impl std::fmt::Debug for TestScene {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.scene_file() {
            Ok(text) => write!(f, "\n{text}"),
            Err(e) => write!(f, "\n# {e}\n# {:?}\n# {:?}", self.scene, self.view),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cases;
    use crate::check::strategies::scene;
    use proptest::prelude::*;

    fn read_back(text: &str) -> TestScene {
        let path = std::path::Path::new("");
        let loaded = vr_io::resolve_scene(&vr_io::parse_scene(text, path).unwrap(), path).unwrap();
        TestScene { scene: loaded.scene, view: loaded.view }
    }

    #[test]
    fn hard_cases_print_as_scene_files_and_come_back() {
        // Scene files name other volumes than uniform grids and points by their own files.
        for case in cases::all().into_iter().filter(|case| case.scene.volume.grid().is_some()) {
            let printed = format!("{:?}", TestScene { scene: case.scene.clone(), view: case.view.clone() });
            let back = read_back(&printed);
            assert_eq!(*back.scene.transfer, *case.scene.transfer, "{}", case.name);
            assert_eq!(back.view, case.view, "{}", case.name);
            let stats = |s: &Scene| {
                let c = *s.volume.grid().unwrap().value_stats();
                (c.range, c.nan + c.infinite)
            };
            assert_eq!(stats(&back.scene), stats(&case.scene), "{}", case.name);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

        #[test]
        fn random_scenes_print_as_scene_files_and_come_back(test in scene()) {
            let back = read_back(&format!("{test:?}"));
            prop_assert_eq!(&*back.scene.transfer, &*test.scene.transfer);
            prop_assert_eq!(&back.view, &test.view);
            prop_assert_eq!(&back.scene.shading, &test.scene.shading);
            prop_assert_eq!((back.scene.compositing, back.scene.volume.filter()), (test.scene.compositing, test.scene.volume.filter()));
            let axes = |t: &Scene| t.volume.grid().unwrap().placement().axes();
            let (a, b) = (axes(&back.scene), axes(&test.scene));
            // Spacing and direction are normalised on the way.
            prop_assert!(a.abs_diff_eq(b, 1e-14 * b.x_axis.length().max(b.y_axis.length()).max(b.z_axis.length())));
        }
    }
}
