//! Pictures that would take seconds end soon after they are cancelled.

use std::time::Duration;

use vr_physics::check::pictures::{phantom_scene, view};
use vr_physics::check::time_to_cancel;
use vr_texslice::{Format, TextureSlicer};

#[test]
fn slices_end_where_they_are() {
    let scene = phantom_scene::<u8>("fog", 64, 0.01);
    let view = view(&scene, 30.0, 20.0, None, 1024);
    for format in [Format::default(), Format::Compressed] {
        let slicer = TextureSlicer { format, slice_spacing: 0.01, ..TextureSlicer::default() };
        let time = time_to_cancel(&slicer, &scene, &view, Duration::from_millis(200));
        println!("{format:?}: {time:?}");
        assert!(time < Duration::from_millis(300), "{format:?}: {time:?}");
    }
}
