//! Pictures that would take seconds end soon after they are cancelled.

use std::time::Duration;

use vr_physics::check::pictures::{phantom_scene, view};
use vr_physics::check::time_to_cancel;
use vr_shearwarp::ShearWarp;

#[test]
fn slices_end_where_they_are() {
    let scene = phantom_scene::<u8>("fog", 128, 0.01);
    for fov in [None, Some(40.0)] {
        let view = view(&scene, 30.0, 20.0, fov, 512);
        let renderer = ShearWarp { slice_distance: 0.1, texel: 0.1, ..ShearWarp::default() };
        let time = time_to_cancel(&renderer, &scene, &view, Duration::from_millis(200));
        println!("{fov:?}: {time:?}");
        assert!(time < Duration::from_millis(300), "{fov:?}: {time:?}");
    }
}
