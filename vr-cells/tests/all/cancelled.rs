//! Pictures that would take seconds end soon after they are cancelled.

use std::time::Duration;

use vr_cells::{CellMarcher, CellProjector};
use vr_core::{Renderer, Scene, View};
use vr_physics::check::time_to_cancel;

use crate::meshes::{mesh, transfer, view};

#[test]
fn cells_end_where_they_are() {
    let scene = Scene::new(mesh(24, 0.2, false, |_| false).into(), transfer(0.01));
    let view = View { size: [1024; 2], supersampling: 4, ..view(30.0, 20.0, None) };
    let renderers: [&dyn Renderer; 2] = [&CellMarcher::default(), &CellProjector::default()];
    for renderer in renderers {
        let time = time_to_cancel(renderer, &scene, &view, Duration::from_millis(200));
        println!("{}: {time:?}", renderer.name());
        assert!(time < Duration::from_millis(300), "{}: {time:?}", renderer.name());
    }
}
