//! One algorithm crate alone: the samples of a program, drawn into its terminal.
//!
//! `cargo run --release -p vr-examples --example one_crate`

use vr_core::{
    Calibration, Camera, Control, ControlPoint, OpacityRule, Placement, Renderer, Scene, TransferFunction, UniformGrid,
    View,
};
use vr_raycast::RayCaster;

/// Samples along each edge.
const N: usize = 48;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A torus in bytes: densest in the middle of its tube.
    let sample = |i: usize| {
        let at = [i % N, i / N % N, i / N / N].map(|k| 2.0 * k as f64 / (N - 1) as f64 - 1.0);
        let from_ring = (at[0].hypot(at[1]) - 0.6).hypot(at[2]);
        (255.0 * (1.0 - from_ring / 0.3).max(0.0)) as u8
    };
    let samples: Vec<u8> = (0..N * N * N).map(sample).collect();
    let grid = UniformGrid::new([N; 3], samples, Placement::from_spacing([1.0; 3])?, Calibration::default())?;

    let points = vec![ControlPoint::new(20.0, [1.0; 3], 0.0), ControlPoint::new(255.0, [1.0; 3], 0.2)];
    let scene = Scene::new(grid.into(), TransferFunction::new(points, OpacityRule::Power, 1.0)?);
    // Characters are twice as high as wide.
    let view = View::new(Camera::framing(scene.bounds(), 20.0, 40.0, Some(30.0)), [40, 40]);

    let control = Control::default();
    let frame = RayCaster::default().prepare(&scene, &control)?.render(&view, &control)?.frame;
    for y in 0..40 {
        let shade = |x| b" .:-=+*#%@"[(9.0 * frame.pixel(x, y)[3]) as usize] as char;
        println!("{}", (0..40).flat_map(|x| [shade(x); 2]).collect::<String>());
    }
    Ok(())
}
