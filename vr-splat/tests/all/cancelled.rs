//! Pictures that would take seconds end soon after they are cancelled.

use std::time::Duration;

use vr_core::{Scene, phantom};
use vr_physics::check::pictures::{phantom_scene, view};
use vr_physics::check::time_to_cancel;
use vr_splat::{Buffers, Splatter};

#[test]
fn tiles_end_where_they_are() {
    let grid = phantom_scene::<u8>("fog", 96, 0.01);
    let points = phantom::points_by_name("plummer", 100_000).unwrap();
    let points = Scene::new(points.into(), (*grid.transfer).clone());
    for (scene, buffers) in [(&grid, Buffers::Image), (&grid, Buffers::Axis), (&points, Buffers::Image)] {
        let view = view(scene, 30.0, 20.0, None, 2048);
        let slice_spacing = if buffers == Buffers::Image { 0.05 } else { 1.0 };
        let renderer = Splatter { buffers, slice_spacing, ..Splatter::default() };
        let time = time_to_cancel(&renderer, scene, &view, Duration::from_millis(200));
        println!("{buffers:?}: {time:?}");
        assert!(time < Duration::from_millis(300), "{buffers:?}: {time:?}");
    }
}
