//! Random scenes of voxels with colours of their own.

use proptest::prelude::*;
use vr_core::{ColorGrid, Scene, Volume};

use super::hashed::Hashed;
use super::kinds::{Kind, scene_of};
use crate::check::TestScene;

/// A scene of any [`Kind`] except `Offsets`, `Extremes` and `Far`, with a colour for each voxel: all the same, similar ones, or any.
pub fn colored_grid_scene() -> impl Strategy<Value = TestScene> {
    let kinds: Vec<Kind> =
        Kind::ALL.into_iter().filter(|kind| ![Kind::Offsets, Kind::Extremes, Kind::Far].contains(kind)).collect();
    let change = prop_oneof![1 => Just(0.0), 4 => 0.0..=1.0];
    (scene_of(&kinds), change, any::<u64>()).prop_map(|(test, change, seed)| {
        let Volume::Grid(values) = &test.scene.volume else { return test };
        let voxels = values.dims().iter().product::<usize>();
        let channel = |c: i64| {
            let color = |i: i64| Hashed::of(seed, [c, i]).part();
            let all = color(-1);
            let light = |i: usize| (1.0 - change) * all + change * color(i as i64);
            (0..voxels).map(|i| (f64::from(ColorGrid::WHITE) * light(i)) as u16).collect()
        };
        let colors = ColorGrid::new(values.as_ref().clone(), [0, 1, 2].map(channel)).expect("a colour for each voxel");
        TestScene { scene: Scene { volume: colors.into(), ..test.scene }, view: test.view }
    })
}

#[cfg(test)]
mod tests {
    use crate::check::strategies::drawn::{draw, scenes_are_solved, some};

    use super::*;

    #[test]
    fn scenes_are_solved_and_colours_are_of_all_sorts() {
        let scenes = draw(colored_grid_scene(), 120);
        scenes_are_solved(&scenes);
        let spread = |test: &TestScene| {
            let red = test.scene.volume.colors().expect("voxels with colours").channels()[0].samples;
            red.iter().max().unwrap() - red.iter().min().unwrap()
        };
        some(&scenes, "one colour", |test| spread(test) == 0);
        some(&scenes, "many colours", |test| spread(test) > ColorGrid::WHITE / 2);
    }
}
