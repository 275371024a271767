//! Random whole scenes.

use proptest::prelude::*;
use vr_core::{Filter, Scene, View};

use super::assembly::{self, Look, MAX_PIXELS, picture};
use super::cameras::{generic, viewpoint};
use super::grids::{grid, smooth_grid, tame_grid};
use super::looks::{filter, scheme, shading, tame_compositing};
use super::transfers::{recipe, smooth_recipe, tame_recipe};
use crate::check::TestScene;

/// Any valid scene, the unkind included; see the [module](super).
pub fn scene() -> impl Strategy<Value = TestScene> {
    let background = prop_oneof![3 => Just([0.0f32; 3]), 1 => [0.0f32..1.0, 0.0f32..1.0, 0.0f32..1.0]];
    let look = (filter(), shading(), scheme(), background)
        .prop_map(|(filter, shading, compositing, background)| Look { filter, shading, compositing, background });
    assembly::scenes(grid(), recipe(), picture(viewpoint()), look)
}

/// A scene whose picture depends continuously on every number; see the [module](super).
pub fn tame_scene() -> impl Strategy<Value = TestScene> {
    let filter = filter().prop_map(|f| if f == Filter::Nearest { Filter::Trilinear } else { f });
    let look = (filter, tame_compositing())
        .prop_map(|(filter, compositing)| Look { filter, ..Look::plain(compositing, None) });
    assembly::scenes(tame_grid(), tame_recipe(), picture(generic()), look)
}

/// A trilinear scene under emission and absorption that is as smooth as such a scene can be, with unequal extinction at both ends
/// of nearly every ray; see the [module](super).
pub fn smooth_scene() -> impl Strategy<Value = TestScene> {
    (smooth_grid(), smooth_recipe(), generic(), 4u32..=MAX_PIXELS).prop_map(|(volume, recipe, viewpoint, side)| {
        let transfer = recipe.of_volume(&volume);
        let camera = viewpoint.camera(&volume, side);
        TestScene { scene: Scene::new(volume, transfer), view: View::new(camera, [side, side]) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::strategies::drawn::{self, draw};
    use vr_core::{IndexRay, Rays};

    fn assert_valid(t: &TestScene) {
        t.scene.validate().unwrap();
        t.view.validate().unwrap();
        t.view.camera.frame().unwrap();
    }

    #[test]
    fn every_scene_is_valid_and_every_feature_is_drawn() {
        let scenes = draw(scene(), 1000);
        scenes.iter().for_each(assert_valid);
        let some = |what: &str, test: &dyn Fn(&TestScene) -> bool| drawn::some(&scenes, what, test);
        for f in Filter::ALL {
            some(f.name(), &|t| t.scene.volume.filter() == Some(f));
        }
        for c in ["over", "first", "average", "maximum", "minimum", "accumulate"] {
            some(c, &|t| t.scene.compositing.name() == c);
        }
        let grid = |t: &TestScene| t.scene.volume.grid().unwrap().placement().axes();
        some("shading", &|t| t.scene.shading.is_some());
        some("crop", &|t| t.view.clip.crop.is_some());
        some("planes", &|t| !t.view.clip.planes.is_empty());
        some("jumps", &|t| t.scene.transfer.has_jumps());
        some("opaque", &|t| t.scene.transfer.segments().iter().any(|s| s.is_opaque()));
        some("emission", &|t| t.scene.transfer.has_emission());
        some("missing samples", &|t| t.scene.volume.grid().unwrap().vacuum_cells().is_some());
        some("constant", &|t| t.scene.volume.value_range().is_some_and(|(a, b)| a == b));
        some("negative slope", &|t| t.scene.volume.grid().unwrap().calibration().slope < 0.0);
        some("mirrored", &|t| grid(t).determinant() < 0.0);
        some("sheared", &|t| grid(t).x_axis.normalize().dot(grid(t).y_axis.normalize()).abs() > 0.05);
        some("several rays a pixel", &|t| t.view.supersampling > 1);
        some("eye inside", &|t| {
            let u = t.scene.volume.grid().unwrap();
            let at = u.placement().to_index(t.view.camera.eye);
            (0..3).all(|a| at[a] > 0.0 && at[a] < (u.dims()[a] - 1) as f64)
        });
        for kind in ["u8", "i8", "u16", "i16", "f32"] {
            some(kind, &|t| t.scene.volume.grid().unwrap().voxel_type().name() == kind);
        }
    }

    #[test]
    fn tame_and_smooth_scenes_are_what_they_are_called() {
        for t in draw(tame_scene(), 300) {
            assert_valid(&t);
            assert!(!t.scene.transfer.has_jumps() && t.scene.volume.filter().unwrap().is_continuous());
            assert!(t.scene.transfer.points().iter().all(|p| p.opacity <= 0.95));
            assert!(t.scene.volume.grid().unwrap().vacuum_cells().is_none());
        }
        let smooth = draw(smooth_scene(), 300);
        for t in &smooth {
            assert_valid(t);
            let (low, high) = t.scene.volume.value_range().unwrap();
            assert!(low < high, "a slope");
            assert!(t.scene.transfer.segment_at(low) == t.scene.transfer.segment_at(high), "no kink between");
        }
        let hits = smooth.iter().filter(|t| {
            let u = t.scene.volume.grid().unwrap();
            let middle =
                Rays::new(&t.view).unwrap().at(0.5 * f64::from(t.view.size[0]), 0.5 * f64::from(t.view.size[1]));
            IndexRay::new(&middle, u.placement(), u.dims(), &t.view.clip, f64::INFINITY).is_some()
        });
        assert_eq!(hits.count(), 300, "the middle of every picture shows the volume");
    }
}
