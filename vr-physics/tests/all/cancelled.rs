//! Solutions that would take minutes end soon after they are cancelled.

use std::time::Duration;

use vr_core::{Compositing, ControlPoint, OpacityRule, Scene, TransferFunction, View};
use vr_physics::Reference;
use vr_physics::check::pictures::{phantom_scene, view};
use vr_physics::check::time_to_cancel;

#[test]
fn tiles_of_many_rays_end_inside() {
    // A transfer function of so many knots that each cell is cut a hundred times.
    let knot = |k: u32| ControlPoint::new(f64::from(k) / 2.0, [f64::from(k % 2); 3], 1e-4 * f64::from(k % 3));
    let transfer = TransferFunction::new((0..=510).map(knot).collect(), OpacityRule::Power, 1.0).unwrap();
    let over = Scene { transfer: transfer.into(), ..phantom_scene::<u8>("marschner-lobb", 48, 1.0) };
    let [maximum, average] =
        [Compositing::Maximum, Compositing::Average].map(|c| Scene { compositing: c, ..over.clone() });
    for scene in [over, maximum, average] {
        // 65 thousand rays for a tile of the picture.
        let view = View { supersampling: 16, ..view(&scene, 30.0, 20.0, None, 64) };
        let time = time_to_cancel(&Reference::default(), &scene, &view, Duration::from_millis(200));
        println!("{}: {time:?}", scene.compositing.name());
        assert!(time < Duration::from_millis(300), "{}: {time:?}", scene.compositing.name());
    }
}
